/* SPDX-License-Identifier: MIT
 * The two steps of a lattice from the picture alone: autocorrelation of a few
 * blocks. */
#ifndef PLFT_CALIB_PERIOD_H
#define PLFT_CALIB_PERIOD_H

#include "calib/grey.h"
#include "calib/lattice.h"

typedef struct plft_period {
    plft_vec v1, v2; /* reduced basis, pixels */
    double strength; /* mean correlation at the lattice lags, 1 for a perfect lattice */
    double rest;     /* standard deviation of the correlation at other lags */
} plft_period;

/* Power spectra of four blocks of 512 x 512 samples add up; low frequencies (periods
 * over 200 px) are dropped; the amplitude spectrum, not its square, is transformed
 * back, which keeps strong single frequencies from ruling.  The finest lattice
 * through the peaks that keeps three quarters of the best mean correlation wins.
 * Periods 6 .. 170 px; pictures whose lattice is coarse are looked at again reduced
 * four times. 0, or -1 when nothing repeats or memory is short. */
int plft_period_find(const plft_grey *grey, plft_period *period);

#endif
