/* SPDX-License-Identifier: MIT
 * Views without what is coarser or finer than the window of a match. */
#ifndef PLFT_BAND_PASS_H
#define PLFT_BAND_PASS_H

#include "plenofix/image.h"

/* Every view I of n becomes, in place, on a grey in the middle of its range,
 *   mid + [1 2 1]/4 * [1 2 1]'/4 * I - mean of I over 7x7,   mid = 2^(bits-1),
 * halves rounded up, borders repeated, cut to the range.  In amplitude half is left at
 * 11 and at 4 samples a period: even brightness, which differs from view to view
 * without a white frame, goes, and so does most of the noise.  A sample at the end of
 * its range stays there, so that saturation is still seen; no other comes to lie there.
 * bits: 8 .. 12.  0 or PLFT_DATA. */
int plft_band_pass(plfx_views *views, int bits);

/* What is left of the noise of a sample, and of the difference of two neighbours. */
#define PLFT_BAND_NOISE 0.358
#define PLFT_BAND_STEP  0.2165

#endif
