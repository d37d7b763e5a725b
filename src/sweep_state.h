/* SPDX-License-Identifier: MIT
 * Working state of one sweep over a frame, carved from the caller's workspace.
 */
#ifndef PLENOFIX_SRC_SWEEP_STATE_H
#define PLENOFIX_SRC_SWEEP_STATE_H

#include "arena.h"
#include "kernels.h"
#include "rows.h"

typedef struct plfx_pair_row { /* results of one pair along a row */
    int32_t *slope_q16;
    uint16_t *conf_u16, *weight_u16;
    uint8_t *flags;
} plfx_pair_row;

/* Whole rows in 32 bits pay where there are lanes; on small cores the code
 * would not. */
#define PLFX_ZNCC_BY_ROWS (PLFX_LANES > 2)
#define PLFX_ZNCC_PIECE   64 /* lenses worked on at a time */
#define PLFX_ZNCC_FLAT    8  /* exponent of a reference window without variance */

typedef struct plfx_zncc_piece {
    uint32_t m[PLFX_ZNCC_PIECE], step[PLFX_ZNCC_PIECE];
} plfx_zncc_piece;

/* A pair whose labels are whole columns, and which. */
typedef struct plfx_whole {
    int32_t is, least, most;
} plfx_whole;

/* Winners along a row by label after label: [nx] each. */
typedef struct plfx_race {
    uint16_t *label, *best, *second;
    uint16_t *before; /* least of all labels but the last one */
    uint16_t *won;    /* 65535: the last label became the best */
} plfx_race;

/* What zncc_rows.c works on. */
typedef struct plfx_zncc_rows {
    uint32_t *a_low;                 /* [nx] a_sum modulo 2^32, from lens window/2 */
    int32_t *a_exp;                  /* [nx] exponents of a_rsqrt, likewise */
    uint32_t *ab_sum;                /* [nx] window sums */
    uint32_t *b_sum, *b_g, *half[2]; /* [3 nx] likewise; mantissas; folded columns */
    int32_t *b_exp;                  /* [3 nx] */
    uint32_t *steps;                 /* [192] table of mantissas with their falls */
    plfx_whole *whole;               /* [pairs] */
    plfx_zncc_piece *piece;
    struct plfx_zncc_lanes *lanes; /* in the workspace, or NULL: not by lanes */
} plfx_zncc_rows;

typedef struct plfx_sweep_state {
    const plfx_plan *plan;
    plfx_ring src;
    int32_t first, next;               /* rows: first one entered, next one to enter */
    int32_t pairs;                     /* winners a pixel: 1, or one a view */
    plfx_span *span;                   /* [pairs][labels] */
    uint16_t *cost;                    /* [labels][nx] window costs of one pair */
    uint16_t *sample;                  /* [3 nx]: a row, or one continued */
    uint32_t *tex_col, *tex;           /* [nx] gradient sums: columns, windows */
    plfx_pair_row out;                 /* [pairs][nx] each */
    int32_t *slopes;                   /* [pairs] of one lens */
    uint16_t *weights;                 /* [pairs] */
    uint32_t *b_col, *bb_col, *ab_col; /* [pairs][labels][nx] */
    uint32_t *a_col, *aa_col;          /* [nx] */
    uint64_t *a_sum;                   /* [nx] window sums of the reference */
    plfx_rsqrt *a_rsqrt;               /* [nx] of its variance */
    plfx_zncc_rows *rows;              /* in the workspace */
    plfx_race race;
} plfx_sweep_state;

/* Memory from the arena (measured when its base is NULL). */
void plfx_zncc_carve(plfx_sweep_state *s, const plfx_plan *plan, plfx_arena *a);
/* Forget all rows; the first map row is y0: window/2 <= y0. */
void plfx_zncc_begin(plfx_sweep_state *s, int32_t y0);
/* Row y of the map, y consecutive, where rows of the views around its window and the
 * window before are at hand; `row` is a map of one row. */
void plfx_zncc_map_row(plfx_sweep_state *s, int32_t y, const plfx_map *row);

/* Row y of the views enters (sign 1) or leaves (-1) the columns. */
void plfx_zncc_row(const plfx_sweep_state *s, int32_t y, int32_t sign);
void plfx_texture_row(const plfx_sweep_state *s, int32_t y, int32_t sign);

/* Window costs of pair p for the current columns, lenses r .. nx-1-r of
 * s->cost. */
void plfx_zncc_cost(const plfx_sweep_state *s, int32_t p);
/* 1: 32 bits hold every moment of the plan; then the same costs faster. */
int32_t plfx_zncc_narrow(const plfx_plan *plan);
plfx_whole plfx_zncc_whole(const plfx_plan *plan, int32_t p);
void plfx_zncc_start(const plfx_sweep_state *s);
void plfx_zncc_row_whole(const plfx_sweep_state *s, int32_t p, int32_t y,
                         uint32_t sign);
void plfx_zncc_cost_narrow(const plfx_sweep_state *s, int32_t p);
/* Variances v become mantissas (0: none) and exponents, n of them. */
void plfx_zncc_normalise(const plfx_sweep_state *s, uint32_t *v, int32_t *e, int32_t n);
/* Winners of s->cost along the row. */
void plfx_race_row(const plfx_sweep_state *s);
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

/* Slope of lens x from its pairs by the plan's rule.  A pair that won at an end
 * of the range does not count unless all did (RANGE_END).  Confidence is the
 * mean over all pairs, those that do not count giving 0; OCCLUDED when more
 * than a third of the counted pairs lie over two labels away. */
plfx_fused plfx_fuse_pairs(const plfx_sweep_state *s, int32_t x);

/* The view of pair p: the p-th one that is not the reference. */
static inline int32_t plfx_pair_view(const plfx_plan *plan, int32_t p)
{
    return p < plan->cfg.ref ? p : p + 1;
}

/* Row y of the reference view. */
static inline const uint16_t *plfx_ref_row(const plfx_sweep_state *s, int32_t y)
{
    return plfx_ring_row(&s->src, y, s->plan->cfg.ref);
}

#endif
