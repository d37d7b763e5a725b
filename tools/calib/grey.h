/* SPDX-License-Identifier: MIT
 * The picture that calibration looks at: the mean of the frames without dark level,
 * mosaic and hot pixels, left-justified to 16 bits. */
#ifndef PLFT_CALIB_GREY_H
#define PLFT_CALIB_GREY_H

#include <stdint.h>

#define PLFT_SATURATED 65535u /* marks a clipped pixel; others stay below */

typedef struct plft_grey {
    uint16_t *px; /* [h][w], malloc'd */
    int w, h;
    int bits;            /* of the frames it came from */
    int frames;          /* averaged */
    double pedestal;     /* sample value of no light */
    double dark_level;   /* mean of the dark frame, full scale 65535; 0: none given */
    double shift;        /* pixel centres lie at integer + shift (0.5 after a mosaic) */
    long hot, saturated; /* pixels */
    uint32_t *sum;       /* while frames are added */
} plft_grey;

/* Add a frame px[h][w] of right-justified samples.  The first fixes size and bits.
 * px is read only.  0, or -1 when the size or bits differ or memory is short. */
int plft_grey_add(plft_grey *grey, const uint16_t *px, int w, int h, int bits);

/* Take a single frame's memory instead of copying it: `px` must come from malloc and
 * belongs to `grey` afterwards. */
void plft_grey_take(plft_grey *grey, uint16_t *px, int w, int h, int bits);

/* Mean of what was added, minus dark[h][w] (right-justified like the frames; NULL:
 * none) with a pedestal of 1/64 of full scale that keeps the noise of black pixels.
 * 0, or -1. */
int plft_grey_finish(plft_grey *grey, const uint16_t *dark);

/* Whether the four pixels of 2 x 2 groups differ by over 8 % in the mean: a colour
 * mosaic, or something that is treated as one without harm. */
int plft_grey_is_mosaic(const plft_grey *grey);

/* Every pixel becomes the mean of a 2x2 group; shift is then 0.5. */
void plft_grey_merge_mosaic(plft_grey *grey);

/* Replace isolated bright pixels by the mean of their neighbours: value above the
 * second brightest neighbour by 1/50 of full scale and three times the neighbours'
 * own spread. A lens spot of 0.7 px standard deviation passes. */
void plft_grey_drop_hot(plft_grey *grey);

void plft_grey_free(plft_grey *grey);

#endif
