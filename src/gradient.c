/* SPDX-License-Identifier: MIT */
#include "plenofix/gradient.h"
#include "gradient_state.h"
#include "engine.h"
#include "fix.h"
#include "kernels.h"

#include <string.h>

typedef plfx_gradient_state state;

static int64_t *sums(plfx_arena *a, const plfx_plan *plan)
{
    return plfx_take(a, (size_t)plan->nx, sizeof(int64_t));
}

void plfx_gradient_carve(state *s, const plfx_plan *plan, plfx_arena *a)
{
    size_t nx = (size_t)plan->nx;

    s->plan = plan;
    s->col.num = sums(a, plan);
    s->col.xx = sums(a, plan);
    s->col.yy = sums(a, plan);
    s->col.xy = sums(a, plan);
    s->slants = plfx_take(a, 4u * (plan->cfg.window + 1u) * nx, sizeof(int16_t));
    s->spare = plfx_take(a, 2u * nx, sizeof(uint32_t));
    s->beside = NULL;
    if (plan->hex) {
        s->beside = plfx_take(a, 2u * PLFX_G_VIEWS * nx, sizeof(uint16_t));
    }
}

size_t plfx_gradient_ws(const plfx_plan *plan)
{
    plfx_arena a = {NULL, 0};
    state s;

    plfx_gradient_carve(&s, plan, &a);
    return a.used;
}

/* Row y-1 (side 0) or y+1 of a view: on a hexagonal lattice displaced by the odd-row
 * step, so that columns line up. */
static const uint16_t *beside(const state *s, int32_t view, int32_t side, int32_t y)
{
    plfx_shift shift = {0, 0, 2 * side - 1, 0};
    uint16_t *out;

    if (!s->plan->hex) {
        return plfx_ring_row(&s->src, y + shift.ky, view);
    }
    out = s->beside + (size_t)(2 * view + side) * (size_t)s->plan->nx;
    plfx_sample_row(s->plan, &s->src, view, shift, y, 0, s->plan->nx, out);
    return out;
}

/* Where the derivatives of row y rest. */
static plfx_slants resting(const state *s, int32_t y)
{
    size_t nx = (size_t)s->plan->nx;
    int16_t *at = s->slants + 4u * nx * (size_t)(y % (s->plan->cfg.window + 1));
    plfx_slants d = {at, at + nx, at + 2u * nx, at + 3u * nx};

    return d;
}

/* Row y enters the columns, row y - window leaves them; it rests where y + 1 will. */
static void add_row(const state *s, int32_t y)
{
    plfx_strips strips;
    plfx_slants in = resting(s, y);
    plfx_slants out = resting(s, y + 1);
    int32_t v;

    for (v = 0; v < PLFX_G_VIEWS; v++) {
        strips.px[v][0] = beside(s, v, 0, y);
        strips.px[v][1] = plfx_ring_row(&s->src, y, v);
        strips.px[v][2] = beside(s, v, 1, y);
    }
    plfx_gradient_slants(&strips, s->plan->nx, s->spare, &in);
    plfx_gradient_columns(&s->col, &in, &out, s->plan->nx,
                          plfx_asr_i32(s->plan->col_q16, 4),
                          plfx_asr_i32(s->plan->row_q16, 4));
}

/* Of one window. */
typedef struct window_sums {
    int64_t num, xx, yy, xy;
} window_sums;

/* What every lens of a row shares, out of reach of what is written to the map. */
typedef struct shared {
    int64_t xx_q12, yy_q12; /* weights of the energies */
    int64_t area;
    int32_t du_q8, bits, unique;
} shared;

static shared of_row(const plfx_plan *plan)
{
    int64_t col = plfx_asr_i32(plan->col_q16, 4);
    int64_t line = plfx_asr_i32(plan->row_q16, 4);
    shared s;

    s.xx_q12 = plfx_asr_i64(col * col, 12);
    s.yy_q12 = plfx_asr_i64(line * line, 12);
    s.area = (int64_t)plan->cfg.window * plan->cfg.window;
    s.du_q8 = plan->du_q8[2];
    s.bits = plan->cfg.bits;
    s.unique = plan->cfg.unique_u16;
    return s;
}

/* INT32_MIN is PLFX_SLOPE_NONE: no gradient at all. */
static int32_t slope_of(const shared *s, const window_sums *w)
{
    return plfx_ratio_q16(-w->num, s->xx_q12 * w->xx + s->yy_q12 * w->yy, s->du_q8);
}

static uint16_t conf_of(const shared *s, const window_sums *w, int32_t slope)
{
    plfx_products p = {0, 0, w->xx, w->yy, w->xy};

    return slope == PLFX_SLOPE_NONE
               ? 0
               : (uint16_t)plfx_gradient_conf_u16(p, s->area, s->bits);
}

static void edge(const plfx_map *row, int32_t x0, int32_t x1)
{
    int32_t x;

    for (x = x0; x < x1; x++) {
        plfx_map_put(row, (size_t)x, PLFX_SLOPE_NONE, 0, PLFX_FLAG_EDGE);
    }
}

/* Slopes of the windows that columns w .. end-1 complete; conf: NULL, or confidences as
 * well, and unsure slopes are none.  Column 0 is 0. */
static inline void windows(const shared *like, const plfx_slant_sums *col, int32_t w,
                           int32_t end, int32_t *restrict slope,
                           uint16_t *restrict conf)
{
    window_sums sum = {0, 0, 0, 0};
    int32_t x;

    for (x = 1; x < end; x++) {
        int32_t out = x > w ? x - w : 0;
        sum.num += col->num[x] - col->num[out];
        sum.xx += col->xx[x] - col->xx[out];
        sum.yy += col->yy[x] - col->yy[out];
        sum.xy += col->xy[x] - col->xy[out];
        if (x < w) {
            continue;
        }
        slope[x - w] = slope_of(like, &sum);
        if (conf) {
            uint16_t sure = conf_of(like, &sum, slope[x - w]);
            slope[x - w] = sure < like->unique ? PLFX_SLOPE_NONE : slope[x - w];
            conf[x - w] = sure < like->unique ? 0 : sure;
        }
    }
}

/* Windows with their stencils inside the map: lenses r+1 .. nx-2-r. */
static void target_row(const state *s, const plfx_map *row)
{
    const shared like = of_row(s->plan);
    const plfx_slant_sums col = s->col;
    int32_t w = s->plan->cfg.window;
    int32_t x0 = w - w / 2;
    int32_t x1 = s->plan->nx - 1 - w / 2;
    uint16_t *conf = NULL;
    int32_t x;

    edge(row, 0, x0);
    if (row->conf_u16) {
        conf = row->conf_u16 + x0;
    } else if (like.unique > 0) {
        conf = (uint16_t *)(void *)s->spare;
    }
    if (conf || PLFX_LANES <= 2) {
        windows(&like, &col, w, s->plan->nx - 1, row->slope_q16 + x0, conf);
    } else { /* written out once more, without confidences */
        windows(&like, &col, w, s->plan->nx - 1, row->slope_q16 + x0, NULL);
    }
    for (x = x0; row->flags && x < x1; x++) {
        row->flags[x] = row->slope_q16[x] == PLFX_SLOPE_NONE ? PLFX_FLAG_TEXTURE : 0u;
    }
    edge(row, x1, s->plan->nx);
    plfx_map_no_sigma(row);
}

void plfx_gradient_begin(state *s, int32_t y0)
{
    size_t nx = (size_t)s->plan->nx;

    memset(s->col.num, 0, nx * sizeof(int64_t));
    memset(s->col.xx, 0, nx * sizeof(int64_t));
    memset(s->col.yy, 0, nx * sizeof(int64_t));
    memset(s->col.xy, 0, nx * sizeof(int64_t));
    memset(s->slants, 0, 4u * (s->plan->cfg.window + 1u) * nx * sizeof(int16_t));
    s->next = y0 - s->plan->cfg.window / 2;
}

void plfx_gradient_enter(state *s, int32_t y)
{
    for (; s->next <= y; s->next++) {
        add_row(s, s->next);
    }
}

void plfx_gradient_row(state *s, int32_t y, const plfx_map *row)
{
    plfx_gradient_enter(s, y + s->plan->cfg.window / 2);
    target_row(s, row);
}

static plfx_status check(const plfx_plan *plan, const plfx_views *v,
                         const plfx_map *out, const void *ws, size_t ws_size)
{
    if (!plan || plan->cfg.method != PLFX_METHOD_GRADIENT || !v || !v->px ||
        v->nx != plan->nx || v->ny != plan->ny || v->n != PLFX_G_VIEWS || !out ||
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
