/* SPDX-License-Identifier: MIT
 * Complex Fourier transform of a square of 2^k samples, single precision. */
#ifndef PLFT_CALIB_FFT_H
#define PLFT_CALIB_FFT_H

/* In place, z[n][n][2] (re, im), n a power of two, 2 .. 4096, unscaled.
 * sign: -1 forward, +1 backward.  0, or -1 when memory is short. */
int plft_fft_square(float *z, int n, int sign);

#endif
