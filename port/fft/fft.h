/* SPDX-License-Identifier: MIT
 * Power spectra in 32-bit fixed point: kissfft with int32 scalars where its source is
 * at hand, else a radix-2 of our own of the same scaling.  16-bit transforms are left
 * out on purpose: at -40 dB of full scale they keep 3 to 20 dB of signal over their
 * rounding. */
#ifndef PLFX_PORT_FFT_H
#define PLFX_PORT_FFT_H

#include "plenofix/base.h"

#define PLFX_FFT_LOG2_MIN 5
#define PLFX_FFT_LOG2_MAX 14
/* Workspace for a transform of 2^log2 complex values, 64-bit words. */
#define PLFX_FFT_WORDS(log2) (((size_t)7 << ((log2)-1)) + 65u)

typedef struct plfx_fft {
    int32_t log2;
    int32_t *in, *out; /* workspace: real and imaginary parts by turns */
    int32_t *factor;   /* workspace: factors of a turn, q31, or kissfft's state */
    uint64_t *sum;     /* workspace: of powers */
} plfx_fft;

/* PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE (workspace under PLFX_FFT_WORDS). */
plfx_status plfx_fft_init(plfx_fft *fft, int32_t log2, uint64_t *ws,
                          size_t words) PLFX_MUST_USE;

/* fft->out = transform of the n = 2^log2 complex values at fft->in over n. */
void plfx_fft_run(plfx_fft *fft);

/* Welch's power spectrum of x[0 .. count-1], count >= n: halves overlap, each less its
 * mean and under Hann's window.  power[0 .. n/2]: mean square of a bin, scaled so that
 * the greatest is under 2^31 and not under 2^30 unless all are 0.  scale_log2: powers
 * were shifted down by this (negative: up).  PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_fft_welch(plfx_fft *fft, const int16_t *x, int32_t count,
                           uint32_t *power, int32_t *scale_log2) PLFX_MUST_USE;

/* "kissfft" or "radix-2". */
const char *plfx_fft_name(void);

#endif
