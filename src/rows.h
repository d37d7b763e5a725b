/* SPDX-License-Identifier: MIT
 * Row stages: pure functions over rows of the caller's memory.  They validate nothing;
 * the public functions did.  src/NUMERICS.md defines the numbers. */
#ifndef PLENOFIX_SRC_ROWS_H
#define PLENOFIX_SRC_ROWS_H

#include "plenofix/plan.h"
#include "scalar.h"

/* Shift of view k at any slope, rounded to 1/16 column and row. */
plfx_shift plfx_shift_at(const plfx_plan *plan, int32_t k, int32_t slope_q16);

/* Rows of views at hand: row j of view k at px + ((j % depth)*n + k)*nx.  Of a whole
 * frame depth is ny. */
typedef struct plfx_ring {
    const uint16_t *px;
    int32_t nx, ny, n, depth;
} plfx_ring;

static inline plfx_ring plfx_ring_of(const plfx_views *v)
{
    plfx_ring r = {v->px, v->nx, v->ny, v->n, v->ny};

    return r;
}

static inline const uint16_t *plfx_ring_row(const plfx_ring *r, int32_t j, int32_t k)
{
    return r->px + ((size_t)(j % r->depth) * (size_t)r->n + (size_t)k) * (size_t)r->nx;
}

/* View k as the target row j sees it through shift s: out[i] for lenses x0 .. x0+n-1.
 *   B_r(x) = V[r][x+k]*(16-f) + V[r][x+k+1]*f,  r = j+ky, j+ky+1
 *   out = (B_r0*(16-fy) + B_r1*fy + 128) >> 8
 * On hexagonal lattices a row of the other parity is displaced by odd_q4 sixteenths.
 * Indices clamp to the map.  Samples up to 12 bits: 20 bits before the shift. */
void plfx_sample_row(const plfx_plan *plan, const plfx_ring *views, int32_t k,
                     plfx_shift s, int32_t j, int32_t x0, int32_t n, uint16_t *out);

/* Where a window may stand so that no view in use is left: lenses x0..x1, rows
 * y0..y1. */
typedef struct plfx_span {
    int16_t x0, x1, y0, y1;
} plfx_span;

/* Span of view k at a shift, for window radius r. */
plfx_span plfx_span_of(const plfx_plan *plan, plfx_shift s, int32_t r);

/* One pixel's winner: label and its fraction, costs or scores around it. */
typedef struct plfx_winner {
    int32_t label;
    int32_t frac_q4; /* -8 .. 8 */
    uint16_t best, second;
    uint8_t end; /* 1: first or last label */
    uint8_t tie; /* 1: another label, not a neighbour, is as good */
} plfx_winner;

/* Smallest of cost[l*step], l = 0 .. n-1; first on ties; fit per plfx_fit. */
plfx_winner plfx_select(const uint16_t *cost, int32_t n, int32_t step, int32_t fit);

/* Cost that counts as noise: a 1/1024 of full scale a sample, in units of the window
 * sum. */
uint32_t plfx_sad_floor(const plfx_plan *plan);

/* Baseline squared in 1/64 px^2, 1 .. 65535: it saturates at 32 px. */
uint16_t plfx_baseline_weight(const plfx_plan *plan, int32_t view);

#endif
