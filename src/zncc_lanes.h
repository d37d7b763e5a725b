/* SPDX-License-Identifier: MIT
 * Normalised cross-correlation on striped rows: zncc_lanes.c. */
#ifndef PLENOFIX_SRC_ZNCC_LANES_H
#define PLENOFIX_SRC_ZNCC_LANES_H

#include "arena.h"
#include "match.h"
#include "sweep_state.h"

typedef struct plfx_zncc_stats { /* striped, by the first column of a window */
    uint32_t *sum, *g;           /* window sum; mantissa, 0: no variance */
    int32_t *exp;
} plfx_zncc_stats;

typedef struct plfx_zncc_lanes {
    const plfx_plan *plan;
    int32_t pairs, labels, blocks;
    int32_t reach;        /* blocks of a row with all that labels and windows read on */
    int32_t a_low;        /* least exponent of a row's windows */
    uint32_t *col;        /* [pairs][blocks][labels][lanes] N a b */
    uint32_t *moments;    /* [1 + pairs][2][reach][lanes]: samples, squares; 0:
                           reference */
    uint32_t *sum, *zero; /* [labels][lanes] */
    int32_t *left[2], *right[2]; /* [reach][lanes] entering, leaving row */
    plfx_zncc_stats a, b;        /* [reach][lanes] */
    int16_t *line, *strip;       /* [blocks*lanes] */
    int16_t *cost, *order;       /* [labels][lanes], cost as sums of match.h */
    int32_t *shift;              /* [labels] samples */
    plfx_lead *lead;
    int16_t *code, *best, *rest, *lit; /* [blocks*lanes] winners, striped */
    int16_t *best_row, *rest_row;      /* [nx] */
    plfx_line *lines;                  /* [pairs] */
    plfx_judge row;                    /* the rest by lens */
} plfx_zncc_lanes;

/* 1: the plan is one that this file can run. */
int32_t plfx_zncc_lanes_fit(const plfx_plan *plan);

void plfx_zncc_lanes_carve(plfx_zncc_lanes *z, const plfx_plan *plan, plfx_arena *a);
void plfx_zncc_lanes_start(plfx_zncc_lanes *z);

/* Row y enters and row `gone` leaves (-1: none); then, where lines[p] are
 * given, the winners of every pair along row `target`. */
void plfx_zncc_lanes_row(const plfx_sweep_state *s, int32_t y, int32_t gone,
                         int32_t target, const plfx_line *lines);

#endif
