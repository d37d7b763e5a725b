/* SPDX-License-Identifier: MIT
 * Regions worth watching: where a surface of one depth carries texture along both
 * axes. */
#ifndef PLFT_MOTION_PICK_H
#define PLFT_MOTION_PICK_H

#include "common/match.h"
#include "plenofix/roi.h"

typedef struct plft_pick_wish {
    int n, w, h, gap; /* regions wanted, at most PLFX_ROI_MAX, their lenses, lenses
                         between them */
    double texture;   /* least rms gradient along the weaker axis over the mean */
} plft_pick_wish;

typedef struct plft_pick {
    int i, j;       /* centre, lenses */
    double texture; /* rms gradient a lens over the mean brightness, both axes */
    double weak;    /* the same along the direction that has least */
    double mean;    /* brightness, view samples */
    double slope;   /* median of the depth map */
    /* By the core, once checked: */
    double sigma[3]; /* u, v lens pitches; w slope */
    unsigned flags;  /* PLFX_ROI_*; 0: good */
} plft_pick;

typedef struct plft_pick_why { /* candidates, and what spoke against them */
    int all, flat, lens, edge, crowded;
} plft_pick_why;

/* The best wish->n regions, spread over the picture: picked[wish->n], count in *n.
 * Fewer, even 0, when there are not as many; `why` tells.  0 or PLFT_DATA. */
int plft_pick_regions(const plft_field *field, const plft_pick_wish *wish,
                      plft_pick *picked, int *n, plft_pick_why *why);

/* Standard errors of the picked regions, n <= PLFX_ROI_MAX, by the core itself: `raw`
 * (count, 2 .. PLFX_ROI_REST_MAX) are frames of the scene at rest.  0 or PLFT_DATA. */
int plft_pick_check(const plfx_lut *lut, const plfx_raw *raw, int count, int views,
                    double radius, const plft_pick_wish *wish, plft_pick *picked,
                    int n);

#endif
