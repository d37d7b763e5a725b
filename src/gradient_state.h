/* SPDX-License-Identifier: MIT
 * Least-squares gradient row by row: rows of five views in, rows of the map out. */
#ifndef PLENOFIX_SRC_GRADIENT_STATE_H
#define PLENOFIX_SRC_GRADIENT_STATE_H

#include "arena.h"
#include "gradient_rows.h"
#include "rows.h"

typedef struct plfx_gradient_state {
    const plfx_plan *plan;
    plfx_ring src;
    plfx_slant_sums col; /* over the window's rows */
    int16_t *slants;     /* [window+1][4][nx] derivatives of the rows */
    uint16_t *beside; /* [views][2][nx]: rows y-1, y+1 in row y's columns, hexagonal */
    uint32_t *spare;  /* [2][nx] */
    int32_t next;     /* row of derivatives to add */
} plfx_gradient_state;

/* Memory from the arena (measured when its base is NULL). */
void plfx_gradient_carve(plfx_gradient_state *s, const plfx_plan *plan, plfx_arena *a);

/* Forget all rows; the first map row is y0: window/2 < y0. */
void plfx_gradient_begin(plfx_gradient_state *s, int32_t y0);

/* Rows up to y enter the sums, where rows y-1 .. y+1 of the views are at hand for each
 * that is new; the window of map row y - window/2 then ends with row y. */
void plfx_gradient_enter(plfx_gradient_state *s, int32_t y);

/* Row y of the map, y consecutive; rows that have not entered do, as above.  `row` is a
 * map of one row. */
void plfx_gradient_row(plfx_gradient_state *s, int32_t y, const plfx_map *row);

#endif
