/* SPDX-License-Identifier: MIT
 * One plane of samples from what a camera stores: colour, mosaic, dark level. */
#ifndef PLFT_MOSAIC_H
#define PLFT_MOSAIC_H

#include "common/frame.h"

#define PLFT_CHANNEL_GREY (-1) /* else 0 red, 1 green, 2 blue */

/* Subtract dark[h][w] in place, at least 0; clipped samples stay clipped, so that they
 * are still known for it.  0, or PLFT_DATA when size, channels or bits differ. */
int plft_subtract_dark(plft_frame *frame, const plft_frame *dark, const char *name);

/* Replace a frame by one plane: luma of RGB, 2x2 mean or one channel of a mosaic
 * (bayer: plfx_bayer).  A 2x2 mean is centred half a pixel right and down: *half is
 * then set to 1, else to 0.  0 or PLFT_DATA. */
int plft_to_plane(plft_frame *frame, int bayer, int channel, int *half,
                  const char *name);

#endif
