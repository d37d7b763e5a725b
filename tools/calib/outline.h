/* SPDX-License-Identifier: MIT
 * Outline of the mean micro-image: is it the image of an aperture?
 *
 * A micro-image shows the main lens' aperture.  The outline, where light falls to half
 * between centre and darkest place of the cell, has one radius if that is a disc, and
 * not if it is a tile of some texture.  rms of the radius over its mean: disc 0,
 * regular hexagon 0.04, square 0.10, rectangle of 2 to 1 0.28.
 */
#ifndef PLFT_CALIB_OUTLINE_H
#define PLFT_CALIB_OUTLINE_H

#include "calib/calib.h"

/* Sets outline from shape and lattice.  Where light does not fall to half inside the
 * cell, the border stands for the outline: discs that just touch stay even.  1 when the
 * middle has less than half of the border's light, over the darkest place. */
void plft_outline(plft_calib *calib);

/* 1 when no aperture looks so; 2 when it may be one, but not a round one; else 0. */
int plft_outline_odd(const plft_calib *calib);

#endif
