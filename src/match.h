/* SPDX-License-Identifier: MIT
 * The matcher: view rows in, winners of one lens row out.  Columns of costs are kept
 * per pair, label and lens; each new row enters them, the row that leaves the window
 * is taken out again.  Three ways to know the leaving cost, equal to the bit:
 *   ROWS   from the striped view rows of the whole window        (whole frames, pairs)
 *   COSTS  from a ring of the window's cost rows                 (fast streams)
 *   DROP   from the source's rows, before the source lets go     (small streams) */
#ifndef PLENOFIX_SRC_MATCH_H
#define PLENOFIX_SRC_MATCH_H

#include "arena.h"
#include "kernels.h"
#include "rows.h"

enum { PLFX_LEAVE_ROWS, PLFX_LEAVE_COSTS, PLFX_LEAVE_DROP };

/* Where view rows lie.  Row j of view k: from row `packed_end` on at
 * px + ((j % depth)*n + k)*nx, rows before it packed (store.h) in row slots
 * j % packed_depth. */
typedef struct plfx_rows {
    const uint16_t *px;
    int32_t depth;
    const uint8_t *packed;
    int32_t packed_depth, packed_end;
} plfx_rows;

typedef struct plfx_line { /* winners of one pair along a row, lenses 0 .. nx-1 */
    int32_t *slope_q16;
    uint16_t *conf_u16;   /* NULL: not wanted */
    uint16_t *weight_u16; /* NULL: not wanted; never without confidence */
    uint8_t *flags;       /* NULL: not wanted */
} plfx_line;

typedef struct plfx_match {
    const plfx_plan *plan;
    int32_t leave; /* PLFX_LEAVE_* */
    int32_t pairs, others, labels, blocks, cells;
    int32_t flat;         /* 1: no view is displaced across rows */
    int32_t above, below; /* rows that a target row needs around itself */
    int32_t depth;        /* slots of striped rows */
    int32_t slot_len;     /* samples of a slot */
    uint16_t floor_cost;  /* of the confidence */
    int32_t first, next;  /* cost rows: first one added, next one to add */
    int32_t *tag;         /* [depth] row held by a slot, -1 none */
    int32_t *row_at;      /* [n] block 0 of view k inside a slot */
    int32_t *pads;        /* [2n] blocks before and behind */
    int32_t *step;        /* [pairs] samples between labels, 0: not whole or not even */
    int32_t *shift_q4;    /* [others][labels][2] when not flat */
    plfx_tap *tap[2][2];  /* [entering, leaving][upper, lower] of [others][labels] */
    int16_t *line;        /* [blocks*lanes] a row before striping, replicated */
    int16_t *strip;       /* [depth][slot_len] */
    uint16_t *col;        /* [pairs][blocks][labels][lanes] */
    uint16_t *ring;       /* [window][pairs][blocks][labels][lanes] when COSTS */
    uint16_t *item, *gone; /* [labels][lanes] costs of one block */
    uint16_t *zero;        /* [labels][lanes] */
    int16_t *sum, *order;  /* [labels][lanes], sum with a label before and behind,
                            then plfx_lead */
    int16_t *code;         /* [blocks*lanes] winners, striped */
    uint16_t *conf;
    int16_t *code_row; /* [nx] winners by lens */
    uint16_t *conf_row;
    uint16_t *no_row;        /* [nx] flags that refuse a winner */
    plfx_span *span;         /* [pairs][labels] */
    uint16_t *tex_ring;      /* [window][nx] gradients, when the texture test is on */
    uint16_t *tex_above;     /* [nx] the reference row before */
    uint16_t *tex_now;       /* [nx] */
    int32_t tex_ready;       /* 1: tex_above holds the row before the first */
    uint32_t *tex_col, *tex; /* [nx] */
} plfx_match;

/* Sizes from the plan, memory from the arena (measured when its base is NULL). */
void plfx_match_carve(plfx_match *m, const plfx_plan *plan, int32_t leave,
                      plfx_arena *a);

/* Forget all rows; the first output row is y0: window/2 <= y0. */
void plfx_match_start(plfx_match *m, int32_t y0);

/* Row r of the source has come and may go; in order, from plfx_match_from() on.  Not
 * needed where the source keeps its rows. */
void plfx_match_feed(plfx_match *m, const plfx_rows *src, int32_t r);
int32_t plfx_match_from(const plfx_match *m);

/* Cost rows up to `last` enter the columns. */
void plfx_match_enter(plfx_match *m, const plfx_rows *src, int32_t last);

/* Lenses of output row y for every pair, y consecutive from y0 on; lines[p]. */
void plfx_match_row(plfx_match *m, const plfx_rows *src, int32_t y,
                    const plfx_line *lines);

/* DROP: take row y - window/2 out after output row y, while the source still has it. */
void plfx_match_drop(plfx_match *m, const plfx_rows *src, int32_t y);

/* Winners along a row and what judges them, by lens. */
typedef struct plfx_judge {
    const plfx_plan *plan;
    int16_t *code_row;
    uint16_t *conf_row, *no_row;
    const uint16_t *lit_row; /* 0: a window without variance; NULL: not looked at */
    const uint32_t *tex;
    const plfx_span *span; /* [labels] */
} plfx_judge;

/* From the winners (with conf_row, if conf) to line `out`. */
void plfx_judge_row(const plfx_judge *m, int32_t y, int32_t conf, const plfx_line *out);

/* Texture of the reference: row y enters, the row a window before leaves. */
void plfx_match_texture_start(plfx_match *m);
void plfx_match_texture_before(plfx_match *m, const plfx_rows *src, int32_t r);
void plfx_match_texture_row(plfx_match *m, int32_t y);
void plfx_match_texture_sums(plfx_match *m);

/* Row r of view k out of the source. */
void plfx_match_fetch(const plfx_match *m, const plfx_rows *src, int32_t r, int32_t k,
                      uint16_t *row);

#endif
