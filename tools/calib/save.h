/* SPDX-License-Identifier: MIT
 * A calibration as a table description. */
#ifndef PLFT_CALIB_SAVE_H
#define PLFT_CALIB_SAVE_H

#include "calib/calib.h"

typedef struct plft_saved {
    plfx_lut_desc desc; /* its pointers lead to the arrays below */
    int16_t *resid;
    uint8_t *flags;
    uint16_t *profile, *gain;
    char *meta;
} plft_saved;

/* Residuals where the calibration found any, flags where a lens has one, dark level
 * where a dark frame was subtracted, provenance as text.  0, or PLFT_DATA with a
 * message. */
int plft_saved_init(plft_saved *saved, const plft_calib *calib, const plft_grey *grey);

/* White gains from a frame of a uniform scene, of the table's size: the micro-image
 * of each of up to 8 x 8 zones at whole-pixel offsets, and one factor a lens. Gain 1
 * is the level of the brightest twentieth of the lenses.  0, or PLFT_DATA with a
 * message. */
int plft_saved_gain(plft_saved *saved, const plft_calib *calib, const plft_grey *white);

/* Whether a frame of the table's size shows its lenses where the table has them.  0, or
 * PLFT_DATA with a message that names `path`. */
int plft_saved_agrees(const plft_saved *saved, const plft_grey *frame,
                      const char *path);

/* Write it, and open what was written to check it.  0, or PLFT_DATA with a message. */
int plft_saved_write(const plft_saved *saved, const char *path, size_t *bytes);

void plft_saved_free(plft_saved *saved);

#endif
