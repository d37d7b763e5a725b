/* SPDX-License-Identifier: MIT
 * Costs along arms of views, row by row: view rows in, rows of the map out, the same
 * bits as plfx_frame() without paths and refinement.
 *
 * All labels move down together.  Columns of every arm and label are kept; the row that
 * enters them and the row that leaves are both computed from the view rows, of which a
 * window and what the labels reach around it are held, at rest but for the reference.
 * An arm at a time is laid out for its labels. */
#ifndef PLENOFIX_SRC_ARMS_STREAM_H
#define PLENOFIX_SRC_ARMS_STREAM_H

#include "arena.h"
#include "arms_rows.h"

typedef struct plfx_arms_range {
    int32_t from, to; /* rows from .. to - 1 */
} plfx_arms_range;

typedef struct plfx_arms_stream {
    plfx_frame_state frame;
    plfx_median_rows median;
    int32_t grad;          /* 1: costs look at the rows above and below */
    int32_t before, after; /* view rows that a cost row needs around itself */
    int32_t next, winner;  /* cost row and winner row to come */
    plfx_arms_range cost_rows, winner_rows;
    int32_t depth;       /* rows of the store */
    uint8_t *store;      /* [n - 1][depth] view rows at rest */
    uint8_t *slot;       /* [n] which view of its arm */
    int32_t *shift_q4;   /* [n][labels][2] */
    int16_t *col;        /* [arms in use][labels][nx] sums over the window's rows */
    uint8_t *cost;       /* [labels][3][nx + 2] */
    uint8_t *axis_label; /* [2][2][nx] of two rows: u, v */
    int32_t *e;          /* [nx] after the median */
    /* One after the other in the same place: of costs, */
    uint16_t *warp; /* [2][nx] */
    int16_t *diff;  /* [1 or 3][nx + 2] */
    int16_t *arm;   /* [nx] sum of its views, box */
    int16_t *wide;  /* [nx + window - 1] a column row, ends repeated */
    int16_t *least; /* [PLFX_ARMS_LEVELS][nx] */
    int16_t *axis;  /* [2][nx] */
    int16_t *best;  /* [2][nx] of them over the labels */
    /* of winners, */
    int16_t *sum; /* [labels][PLFX_WINNER_CHUNK] */
    void *chunk;
    void *work; /* of the median */
} plfx_arms_stream;

/* 1: rows of this can be streamed. */
int32_t plfx_arms_streams(const plfx_plan *plan, const plfx_frame_cfg *cfg);

/* After plfx_arms_streams() said 1.  base NULL: bytes alone. */
size_t plfx_arms_carve(plfx_arms_stream *a, const plfx_plan *plan,
                       const plfx_frame_cfg *cfg, void *base);

/* Map rows j0 .. j1-1 are wanted; the view rows that it takes. */
plfx_arms_range plfx_arms_start(plfx_arms_stream *a, int32_t j0, int32_t j1);

/* View rows that must have come below map row y before it, but for the last of all. */
int32_t plfx_arms_below(const plfx_arms_stream *a);

/* View row j: [n][nx] samples. */
void plfx_arms_put(plfx_arms_stream *a, int32_t j, const uint16_t *rows);

/* What view rows up to `last` allow, as long as map row y is the next. */
void plfx_arms_enter(plfx_arms_stream *a, int32_t last, int32_t y);

/* Map row y, y consecutive. */
void plfx_arms_row(plfx_arms_stream *a, int32_t y, const plfx_map *row);

#endif
