/* SPDX-License-Identifier: MIT
 * Has the lens lattice moved since the calibration?
 *
 * Lenses of a frame are registered near the table's centres; their displacements are a
 * similarity about the middle of the sensor:
 *   dx = shift_x + scale*X - rotation*Y,   dy = shift_y + rotation*X + scale*Y
 * with (X,Y) the distance from the middle; rotation in radians. */
#ifndef PLFT_CALIB_DRIFT_H
#define PLFT_CALIB_DRIFT_H

#include "calib/grey.h"
#include "plenofix/lut.h"

typedef struct plft_drift {
    double shift_x, shift_y, rotation, scale;
    double shift_sigma, rotation_sigma, scale_sigma; /* 1-sigma */
    double corner; /* largest displacement on the sensor, px */
    double rms;    /* of the lenses about the similarity, px per axis */
    int lenses;    /* that took part */
    int tried;
    int moved; /* beyond 4 sigma and 0.05 px at the worst corner */
    char reason[200];
} plft_drift;

/* About 3,000 lenses take part.  Shifts of up to a quarter of the pitch are found; a
 * shift by whole pitches cannot show.  0, or -1 with a reason when the frame
 * disagrees with the table: fewer than half of the lenses are where a lens should
 * be. */
int plft_drift_find(plft_drift *drift, const plfx_lut *lut, const plft_grey *grey);

#endif
