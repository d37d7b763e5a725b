/* SPDX-License-Identifier: MIT */
#include "plenofix/gradient.h"
#include "gradient_state.h"
#include "engine.h"
#include "fix.h"

#include <string.h>

enum { CENTRE, LEFT, RIGHT, UP, DOWN, VIEWS = PLFX_GRADIENT_VIEWS };

typedef plfx_gradient_state state;

void plfx_gradient_carve(state *s, const plfx_plan *plan, plfx_arena *a)
{
    int32_t v;
    int32_t r;

    s->plan = plan;
    s->col = plfx_take(a, (size_t)plan->nx, sizeof(plfx_products));
    for (v = 0; v < VIEWS; v++) {
        for (r = 0; r < 3; r++) {
            s->row[v][r] = plfx_take(a, (size_t)plan->nx, sizeof(uint16_t));
        }
    }
}

size_t plfx_gradient_ws(const plfx_plan *plan)
{
    plfx_arena a = {NULL, 0};
    state s;

    plfx_gradient_carve(&s, plan, &a);
    return a.used;
}

/* Rows y-1 .. y+1 of every view; on a hexagonal lattice the outer ones are displaced by
 * the odd-row step so that columns line up. */
static void load(const state *s, int32_t y)
{
    int32_t v;
    int32_t r;

    for (v = 0; v < VIEWS; v++) {
        for (r = 0; r < 3; r++) {
            plfx_shift shift = {0, 0, r - 1, 0};
            plfx_sample_row(s->plan, &s->src, v, shift, y, 0, s->plan->nx,
                            s->row[v][r]);
        }
    }
}

/* A 3x3 separable stencil of one view at x: 12-bit samples, 12 + 16 bits. */
static int64_t stencil(const state *s, int32_t v, int32_t x, const int32_t along[3],
                       const int32_t across[3])
{
    int64_t sum = 0;
    int32_t r;

    for (r = 0; r < 3; r++) {
        const uint16_t *p = s->row[v][r] + x;
        sum += across[r] * ((int64_t)along[0] * p[-1] + (int64_t)along[1] * p[0] +
                            (int64_t)along[2] * p[1]);
    }
    return sum;
}

static const int32_t smooth[3] = {PLFX_P_SIDE, PLFX_P_MID, PLFX_P_SIDE};
static const int32_t differ[3] = {-PLFX_D_SIDE, 0, PLFX_D_SIDE};

/* Derivative along x or y of three views in line, prefiltered along their offset:
 * q4. */
static int64_t spatial_q4(const state *s, int32_t minus, int32_t plus, int32_t x,
                          const int32_t *along, const int32_t *across)
{
    int64_t sum = PLFX_P_SIDE * (stencil(s, minus, x, along, across) +
                                 stencil(s, plus, x, along, across)) +
                  PLFX_P_MID * stencil(s, CENTRE, x, along, across);

    return plfx_round_shift_i64(sum, 20);
}

/* Derivative along the offset, prefiltered along x and y: q4 a step. */
static int64_t angular_q4(const state *s, int32_t minus, int32_t plus, int32_t x)
{
    int64_t diff =
        stencil(s, plus, x, smooth, smooth) - stencil(s, minus, x, smooth, smooth);

    return plfx_round_shift_i64(PLFX_D_SIDE * diff, 20);
}

static plfx_products products(const state *s, int32_t x)
{
    int64_t ix = spatial_q4(s, LEFT, RIGHT, x, differ, smooth);
    int64_t iy = spatial_q4(s, UP, DOWN, x, smooth, differ);
    plfx_products c;

    c.xu = ix * angular_q4(s, LEFT, RIGHT, x);
    c.yv = iy * angular_q4(s, UP, DOWN, x);
    c.xx = ix * ix;
    c.yy = iy * iy;
    c.xy = ix * iy;
    return c;
}

static void add(plfx_products *to, const plfx_products *c, int64_t sign)
{
    to->xu += sign * c->xu;
    to->yv += sign * c->yv;
    to->xx += sign * c->xx;
    to->yy += sign * c->yy;
    to->xy += sign * c->xy;
}

/* Row y of products enters or leaves the columns, lenses 1 .. nx-2. */
static void columns(const state *s, int32_t y, int64_t sign)
{
    int32_t x;

    load(s, y);
    for (x = 1; x < s->plan->nx - 1; x++) {
        plfx_products c = products(s, x);
        add(&s->col[x], &c, sign);
    }
}

static void judge(const plfx_plan *plan, const plfx_map *row, int32_t x,
                  const plfx_products *w)
{
    int64_t n = (int64_t)plan->cfg.window * plan->cfg.window;
    uint16_t conf = (uint16_t)plfx_gradient_conf_u16(*w, n, plan->cfg.bits);
    int32_t slope =
        plfx_gradient_slope_q16(*w, plan->col_q16, plan->row_q16, plan->du_q8[2]);

    if (slope == PLFX_SLOPE_NONE || conf < plan->cfg.unique_u16) {
        plfx_map_put(row, (size_t)x, PLFX_SLOPE_NONE, 0, PLFX_FLAG_TEXTURE);
    } else {
        plfx_map_put(row, (size_t)x, slope, conf, 0);
    }
}

static void edge(const plfx_map *row, int32_t x0, int32_t x1)
{
    int32_t x;

    for (x = x0; x < x1; x++) {
        plfx_map_put(row, (size_t)x, PLFX_SLOPE_NONE, 0, PLFX_FLAG_EDGE);
    }
}

/* Windows with their stencils inside the map: lenses r+1 .. nx-2-r. */
static void target_row(const state *s, const plfx_map *row)
{
    int32_t w = s->plan->cfg.window;
    int32_t r = w / 2;
    plfx_products sum = {0, 0, 0, 0, 0};
    int32_t x;

    edge(row, 0, r + 1);
    for (x = 1; x < s->plan->nx - 1; x++) {
        add(&sum, &s->col[x], 1);
        if (x > w) {
            add(&sum, &s->col[x - w], -1);
        }
        if (x >= w) {
            judge(s->plan, row, x - r, &sum);
        }
    }
    edge(row, s->plan->nx - 1 - r, s->plan->nx);
}

void plfx_gradient_begin(state *s, int32_t y0)
{
    memset(s->col, 0, (size_t)s->plan->nx * sizeof(plfx_products));
    s->first = y0 - s->plan->cfg.window / 2;
    s->next = s->first;
}

void plfx_gradient_row(state *s, int32_t y, const plfx_map *row)
{
    int32_t w = s->plan->cfg.window;

    for (; s->next <= y + w / 2; s->next++) {
        columns(s, s->next, 1);
        if (s->next - w >= s->first) {
            columns(s, s->next - w, -1);
        }
    }
    target_row(s, row);
}

static plfx_status check(const plfx_plan *plan, const plfx_views *v,
                         const plfx_map *out, const void *ws, size_t ws_size)
{
    if (!plan || plan->cfg.method != PLFX_METHOD_GRADIENT || !v || !v->px ||
        v->nx != plan->nx || v->ny != plan->ny || v->n != VIEWS || !out ||
        !out->slope_q16 || out->w != plan->nx || out->h != plan->ny ||
        out->stride < out->w) {
        return PLFX_E_ARG;
    }
    if (!ws || !plfx_aligned(ws) || ws_size < plfx_gradient_ws(plan)) {
        return PLFX_E_SIZE;
    }
    return PLFX_OK;
}

plfx_status plfx_gradient(const plfx_plan *plan, const plfx_views *views,
                          const plfx_map *out, void *ws, size_t ws_size)
{
    plfx_status status = check(plan, views, out, ws, ws_size);
    plfx_arena a;
    state s;
    int32_t r;
    int32_t y;

    if (status != PLFX_OK) {
        return status;
    }
    a.base = ws;
    a.used = 0;
    plfx_gradient_carve(&s, plan, &a);
    s.src = plfx_ring_of(views);
    r = plan->cfg.window / 2;
    plfx_gradient_begin(&s, r + 1);
    for (y = 0; y < plan->ny; y++) {
        plfx_map row = plfx_map_row(out, y);
        if (y <= r || y >= plan->ny - 1 - r) {
            plfx_map_edge(&row);
        } else {
            plfx_gradient_row(&s, y, &row);
        }
    }
    return PLFX_OK;
}
