/* SPDX-License-Identifier: MIT
 * Modes in a series of displacements, found without a hint. */
#ifndef PLFT_FIND_H
#define PLFT_FIND_H

#include "fft/fft.h"

typedef struct plft_spectrum {
    int bins;      /* 0: too short a series */
    double hz_bin; /* step of frequency */
    uint32_t amplitude[((size_t)1 << (PLFX_FFT_LOG2_MAX - 1)) + 1u]; /* any unit */
} plft_spectrum;

/* Amplitude spectrum of component `axis` of series[rows][regions][3], summed over the
 * regions that were measured in 9 of 10 frames; a sample that was not is the region's
 * mean here.  At least 128 rows.  0 or PLFT_DATA. */
int plft_spectrum_of(plft_spectrum *s, const double *series, int rows, int regions,
                     int axis, double rate);

/* Frequencies of its peaks, strongest first; returns their number, at most max. */
int plft_find_modes(const plft_spectrum *s, double *hz, int max);

#endif
