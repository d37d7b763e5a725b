/* SPDX-License-Identifier: MIT
 * Has the lens lattice moved since the calibration?  plenofix/drift.h for the tools. */
#ifndef PLFT_CALIB_DRIFT_H
#define PLFT_CALIB_DRIFT_H

#include "common/frame.h"
#include "plenofix/lut.h"

typedef struct plft_drift {
    double shift_x, shift_y, rotation, scale;        /* as in plenofix/drift.h */
    double shift_sigma, rotation_sigma, scale_sigma; /* 1-sigma */
    double corner; /* largest displacement on the sensor, px */
    double rms;    /* of the lenses about the similarity, px per axis */
    int lenses;    /* that took part */
    int tried;
    int moved; /* beyond 4 sigma and 0.05 px at the worst corner */
    int state; /* plfx_drift_state */
    char reason[200];
} plft_drift;

/* At most `lenses` take part (plenofix/drift.h).  0, or -1 with a reason when the frame
 * says nothing about the table or disagrees with it. */
int plft_drift_find(plft_drift *drift, const plfx_lut *lut, const plft_frame *frame,
                    int lenses);

/* Warn with its reason when a frame clearly is another camera's: `path`, as above. */
void plft_drift_warn(const char *path, const plfx_lut *lut, const plft_frame *frame);

#endif
