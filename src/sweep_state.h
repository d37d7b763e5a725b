/* SPDX-License-Identifier: MIT
 * Working state of one sweep over a frame, carved from the caller's workspace. */
#ifndef PLENOFIX_SRC_SWEEP_STATE_H
#define PLENOFIX_SRC_SWEEP_STATE_H

#include "rows.h"

typedef struct plfx_pair_row { /* results of one pair along a row */
    int32_t *slope_q16;
    uint16_t *conf_u16, *weight_u16;
    uint8_t *flags;
} plfx_pair_row;

typedef struct plfx_sweep_state {
    const plfx_plan *plan;
    const plfx_views *views;
    int32_t pairs;                     /* winners a pixel: 1, or one a view */
    plfx_span *span;                   /* [pairs][labels] */
    uint16_t *cost;                    /* [labels][nx] window costs of one pair */
    uint16_t *sample;                  /* [nx] */
    uint32_t *tex_col, *tex;           /* [nx] gradient sums: columns, windows */
    plfx_pair_row out;                 /* [pairs][nx] each */
    int32_t *slopes;                   /* [pairs] of one lens */
    uint16_t *weights;                 /* [pairs] */
    uint32_t *b_col, *bb_col, *ab_col; /* [pairs][labels][nx] */
    uint32_t *a_col, *aa_col;          /* [nx] */
    uint64_t *a_sum;                   /* [nx] window sums of the reference */
    plfx_rsqrt *a_rsqrt;               /* [nx] of its variance */
} plfx_sweep_state;

/* Row y of the views enters (sign 1) or leaves (-1) the columns. */
void plfx_zncc_row(const plfx_sweep_state *s, int32_t y, int32_t sign);
void plfx_texture_row(const plfx_sweep_state *s, int32_t y, int32_t sign);

/* Window costs of pair p for the current columns, lenses r .. nx-1-r of s->cost. */
void plfx_zncc_cost(const plfx_sweep_state *s, int32_t p);
/* Reference statistics of the current columns; before plfx_zncc_cost(). */
void plfx_zncc_reference(const plfx_sweep_state *s);
/* Texture sums of the current columns into s->tex. */
void plfx_texture_sums(const plfx_sweep_state *s);

/* Winners of pair p along target row y into s->out. */
void plfx_pair_winners(const plfx_sweep_state *s, int32_t p, int32_t y);

typedef struct plfx_fused { /* one lens of plenoptic stereo */
    int32_t slope_q16;
    uint16_t conf_u16;
    uint8_t flags;
} plfx_fused;

/* Slope of lens x from its pairs by the plan's rule; confidence is the mean over all
 * pairs, those without a slope counting 0; OCCLUDED when more than a third of the
 * measured pairs lie over two labels away. */
plfx_fused plfx_fuse_pairs(const plfx_sweep_state *s, int32_t x);

/* The view of pair p: the p-th one that is not the reference. */
static inline int32_t plfx_pair_view(const plfx_plan *plan, int32_t p)
{
    return p < plan->cfg.ref ? p : p + 1;
}

/* Row y of the reference view. */
static inline const uint16_t *plfx_ref_row(const plfx_sweep_state *s, int32_t y)
{
    return s->views->px +
           ((size_t)y * (size_t)s->views->n + s->plan->cfg.ref) * (size_t)s->views->nx;
}

#endif
