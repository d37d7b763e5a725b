/* SPDX-License-Identifier: MIT
 * Methods that look at rows of the views more than once, fed row by row: pairs by
 * zero-mean NCC, least-squares gradient.  A ring keeps the rows that the next step
 * needs: of NCC those of a window, of the window before it and around them; of the
 * gradient three, as its derivatives rest in rows of their own. */
#ifndef PLENOFIX_SRC_RINGED_H
#define PLENOFIX_SRC_RINGED_H

#include "arena.h"
#include "gradient_state.h"
#include "sweep_state.h"

typedef struct plfx_ringed {
    const plfx_plan *plan;
    int32_t margin;       /* map rows at either border without a window */
    int32_t above, below; /* rows of views that a row of a window needs around itself */
    int32_t depth;        /* rows kept */
    uint16_t *px;         /* [depth][n][nx] */
    plfx_sweep_state *zncc; /* one of the two, the other NULL */
    plfx_gradient_state *gradient;
} plfx_ringed;

/* 1: the plan's method is one of these. */
int32_t plfx_ringed_is(const plfx_plan *plan);

/* Memory from the arena (measured when its base is NULL). */
void plfx_ringed_carve(plfx_ringed *r, const plfx_plan *plan, plfx_arena *a);

/* Forget all rows; the first map row is y0: margin <= y0. */
void plfx_ringed_start(plfx_ringed *r, int32_t y0);

/* View row j, rows in order: [n][nx] samples. */
void plfx_ringed_put(const plfx_ringed *r, int32_t j, const uint16_t *rows);

/* Map row y, y consecutive, when row y + window/2 + below of the views is the last that
 * came, or none is to come. */
void plfx_ringed_row(plfx_ringed *r, int32_t y, const plfx_map *row);

#endif
