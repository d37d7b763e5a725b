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
    int all, flat, lens, edge;
} plft_pick_why;

typedef struct plft_pick_places { /* where a region can lie */
    plft_pick *list;              /* free() it */
    int n;
    plft_pick_why why;
} plft_pick_places;

/* All places with texture on one surface; n may be 0: `why` tells.  0 or PLFT_DATA. */
int plft_pick_find(const plft_field *field, const plft_pick_wish *wish,
                   plft_pick_places *places);

/* wish->n regions that do not meet, picked[wish->n], count in *n >= 1; fewer when not
 * as many fit.  They lie far from each other, distances counted in parts of what the
 * places span along columns and rows: on a long surface at both rims too.
 * places->n >= 1.
 * 0 or PLFT_DATA. */
int plft_pick_choose(const plft_pick_places *places, const plft_pick_wish *wish,
                     plft_pick *picked, int *n);

/* Take a place and those within a third of a region of it off the list. */
void plft_pick_avoid(plft_pick_places *places, const plft_pick_wish *wish,
                     const plft_pick *bad);

/* Standard errors of the picked regions, n <= PLFX_ROI_MAX, by the core itself: `raw`
 * (count, 2 .. PLFX_ROI_REST_MAX) are frames of the scene at rest.  0 or PLFT_DATA. */
int plft_pick_check(const plfx_lut *lut, const plfx_raw *raw, int count, int views,
                    double radius, const plft_pick_wish *wish, plft_pick *picked,
                    int n);

#endif
