/* SPDX-License-Identifier: MIT
 * Whole-frame matching: rows enter the columns, windows slide along them. */
#include "plenofix/sweep.h"
#include "plenofix/fuse.h"
#include "sweep_state.h"
#include "arena.h"
#include "fix.h"

#include <string.h>

static int32_t is_zncc(const plfx_plan *p)
{
    return p->cfg.cost == PLFX_COST_ZNCC;
}

static void carve_zncc(plfx_sweep_state *s, plfx_arena *a, size_t nx, size_t cells)
{
    s->b_col = plfx_take(a, cells, sizeof(uint32_t));
    s->bb_col = plfx_take(a, cells, sizeof(uint32_t));
    s->ab_col = plfx_take(a, cells, sizeof(uint32_t));
    s->a_col = plfx_take(a, nx, sizeof(uint32_t));
    s->aa_col = plfx_take(a, nx, sizeof(uint32_t));
    s->a_sum = plfx_take(a, nx, sizeof(uint64_t));
    s->a_rsqrt = plfx_take(a, nx, sizeof(plfx_rsqrt));
}

static void carve(plfx_sweep_state *s, const plfx_plan *plan, plfx_arena *a)
{
    size_t nx = (size_t)plan->nx;
    size_t labels = plan->cfg.labels;
    size_t pairs = plan->cfg.method == PLFX_METHOD_PAIRS ? plan->cfg.n - 1u : 1u;

    s->plan = plan;
    s->pairs = (int32_t)pairs;
    s->span = plfx_take(a, pairs * labels, sizeof(plfx_span));
    s->cost = plfx_take(a, labels * nx, sizeof(uint16_t));
    s->sample = plfx_take(a, nx, sizeof(uint16_t));
    s->item = plfx_take(a, nx, sizeof(uint16_t));
    s->tex_col = plfx_take(a, nx, sizeof(uint32_t));
    s->tex = plfx_take(a, nx, sizeof(uint32_t));
    s->out.slope_q16 = plfx_take(a, pairs * nx, sizeof(int32_t));
    s->out.conf_u16 = plfx_take(a, pairs * nx, sizeof(uint16_t));
    s->out.weight_u16 = plfx_take(a, pairs * nx, sizeof(uint16_t));
    s->out.flags = plfx_take(a, pairs * nx, sizeof(uint8_t));
    s->slopes = plfx_take(a, pairs, sizeof(int32_t));
    s->weights = plfx_take(a, pairs, sizeof(uint16_t));
    if (is_zncc(plan)) {
        carve_zncc(s, a, nx, pairs * labels * nx);
    } else {
        s->sad_col = plfx_take(a, pairs * labels * nx, sizeof(uint16_t));
    }
}

size_t plfx_sweep_ws(const plfx_plan *plan)
{
    plfx_arena a = {NULL, 0};
    plfx_sweep_state s;

    carve(&s, plan, &a);
    return a.used;
}

static void meet(plfx_span *to, plfx_span with)
{
    to->x0 = (int16_t)plfx_max_i32(to->x0, with.x0);
    to->x1 = (int16_t)plfx_min_i32(to->x1, with.x1);
    to->y0 = (int16_t)plfx_max_i32(to->y0, with.y0);
    to->y1 = (int16_t)plfx_min_i32(to->y1, with.y1);
}

/* Spans of every pair and label: in a sweep those of all views meet. */
static void fill_spans(const plfx_sweep_state *s)
{
    const plfx_plan *plan = s->plan;
    int32_t labels = plan->cfg.labels;
    int32_t per_pair = (plan->cfg.n - 1) / s->pairs;
    int32_t r = plan->cfg.window / 2;
    int32_t p;
    int32_t l;
    int32_t k;

    for (p = 0; p < s->pairs; p++) {
        for (l = 0; l < labels; l++) {
            plfx_span *to = s->span + p * labels + l;
            for (k = 0; k < per_pair; k++) {
                int32_t view = plfx_pair_view(plan, p + k);
                plfx_span one = plfx_span_of(plan, plfx_plan_shift(plan, view, l), r);
                if (k == 0) {
                    *to = one;
                } else {
                    meet(to, one);
                }
            }
        }
    }
}

static void clear(const plfx_sweep_state *s)
{
    size_t nx = (size_t)s->plan->nx;
    size_t cells = (size_t)s->pairs * s->plan->cfg.labels * nx;

    memset(s->tex_col, 0, nx * sizeof(uint32_t));
    if (is_zncc(s->plan)) {
        memset(s->b_col, 0, cells * sizeof(uint32_t));
        memset(s->bb_col, 0, cells * sizeof(uint32_t));
        memset(s->ab_col, 0, cells * sizeof(uint32_t));
        memset(s->a_col, 0, nx * sizeof(uint32_t));
        memset(s->aa_col, 0, nx * sizeof(uint32_t));
    } else {
        memset(s->sad_col, 0, cells * sizeof(uint16_t));
    }
}

static void columns(const plfx_sweep_state *s, int32_t y, int32_t sign)
{
    if (is_zncc(s->plan)) {
        plfx_zncc_row(s, y, sign);
    } else {
        plfx_sad_row(s, y, sign);
    }
    plfx_texture_row(s, y, sign);
}

static void write_sample(const plfx_map *m, size_t at, int32_t slope, uint16_t conf,
                         uint8_t flags)
{
    m->slope_q16[at] = slope;
    if (m->conf_u16) {
        m->conf_u16[at] = slope == PLFX_SLOPE_NONE ? 0 : conf;
    }
    if (m->sigma_u20) {
        m->sigma_u20[at] = PLFX_SIGMA_NONE;
    }
    if (m->flags) {
        m->flags[at] = flags;
    }
}

static void edge_row(const plfx_sweep_state *s, const plfx_map *out, int32_t y)
{
    int32_t x;

    for (x = 0; x < s->plan->nx; x++) {
        write_sample(out, (size_t)y * (size_t)out->stride + (size_t)x, PLFX_SLOPE_NONE,
                     0, PLFX_FLAG_EDGE);
    }
}

static void fuse_row(const plfx_sweep_state *s, const plfx_map *out, int32_t y)
{
    int32_t r = s->plan->cfg.window / 2;
    int32_t x;

    for (x = 0; x < s->plan->nx; x++) {
        size_t at = (size_t)y * (size_t)out->stride + (size_t)x;
        if (x < r || x >= s->plan->nx - r) {
            write_sample(out, at, PLFX_SLOPE_NONE, 0, PLFX_FLAG_EDGE);
        } else if (s->plan->cfg.method == PLFX_METHOD_SWEEP) {
            write_sample(out, at, s->out.slope_q16[x], s->out.conf_u16[x],
                         s->out.flags[x]);
        } else {
            plfx_fused f = plfx_fuse_pairs(s, x);
            write_sample(out, at, f.slope_q16, f.conf_u16, f.flags);
        }
    }
}

static void target_row(const plfx_sweep_state *s, const plfx_map *out, int32_t y)
{
    int32_t p;

    plfx_texture_sums(s);
    if (is_zncc(s->plan)) {
        plfx_zncc_reference(s);
    }
    for (p = 0; p < s->pairs; p++) {
        if (is_zncc(s->plan)) {
            plfx_zncc_cost(s, p);
        } else {
            plfx_sad_cost(s, p);
        }
        plfx_pair_winners(s, p, y);
    }
    fuse_row(s, out, y);
}

static int32_t map_ok(const plfx_plan *plan, const plfx_map *m)
{
    return m && m->slope_q16 && m->w == plan->nx && m->h == plan->ny &&
           m->stride >= m->w;
}

static plfx_status check(const plfx_plan *plan, const plfx_views *v,
                         const plfx_map *out, const void *ws, size_t ws_size)
{
    if (!plan || !v || !v->px || plan->cfg.method == PLFX_METHOD_GRADIENT ||
        v->nx != plan->nx || v->ny != plan->ny || v->n != plan->cfg.n ||
        !map_ok(plan, out)) {
        return PLFX_E_ARG;
    }
    if (!ws || !plfx_aligned(ws) || ws_size < plfx_sweep_ws(plan)) {
        return PLFX_E_SIZE;
    }
    return PLFX_OK;
}

plfx_status plfx_sweep(const plfx_plan *plan, const plfx_views *views,
                       const plfx_map *out, void *ws, size_t ws_size)
{
    plfx_status status = check(plan, views, out, ws, ws_size);
    plfx_arena a;
    plfx_sweep_state s;
    int32_t w;
    int32_t y;

    if (status != PLFX_OK) {
        return status;
    }
    a.base = ws;
    a.used = 0;
    carve(&s, plan, &a);
    s.views = views;
    fill_spans(&s);
    clear(&s);
    w = plan->cfg.window;
    for (y = 0; y < plan->ny; y++) {
        columns(&s, y, 1);
        if (y >= w) {
            columns(&s, y - w, -1);
        }
        if (y >= w - 1) {
            target_row(&s, out, y - w / 2);
        }
        if (y < w / 2 || y >= plan->ny - w / 2) {
            edge_row(&s, out, y);
        }
    }
    return PLFX_OK;
}
