/* SPDX-License-Identifier: MIT
 * Whole-frame matching: SAD by the row engine, NCC by zncc.c. */
#include "plenofix/sweep.h"
#include "arena.h"
#include "engine.h"
#include "fix.h"

static int32_t is_zncc(const plfx_plan *p)
{
    return p->cfg.cost == PLFX_COST_ZNCC;
}

size_t plfx_sweep_ws(const plfx_plan *plan)
{
    plfx_arena a = {NULL, 0};

    if (is_zncc(plan)) {
        plfx_sweep_state s;
        plfx_zncc_carve(&s, plan, &a);
    } else {
        plfx_engine e;
        plfx_engine_carve(&e, plan, PLFX_LEAVE_COSTS, &a);
    }
    return a.used;
}

static int32_t map_ok(const plfx_plan *plan, const plfx_map *m)
{
    return m && m->slope_q16 && m->w == plan->nx && m->h == plan->ny &&
           m->stride >= m->w;
}

static plfx_status check(const plfx_plan *plan, const plfx_views *v,
                         const plfx_map *out, const void *ws, size_t ws_size)
{
    if (!plan || !v || !v->px || plan->cfg.method > PLFX_METHOD_PAIRS ||
        v->nx != plan->nx || v->ny != plan->ny || v->n != plan->cfg.n ||
        !map_ok(plan, out)) {
        return PLFX_E_ARG;
    }
    if (!ws || !plfx_aligned(ws) || ws_size < plfx_sweep_ws(plan)) {
        return PLFX_E_SIZE;
    }
    return PLFX_OK;
}

/* Map rows y0 .. y1-1, all of which hold a window. */
typedef struct band {
    int32_t y0, y1;
} band;

static void sweep_zncc(const plfx_plan *plan, const plfx_views *views, band b,
                       const plfx_map *out, plfx_arena *a)
{
    plfx_sweep_state s;
    int32_t y;

    plfx_zncc_carve(&s, plan, a);
    s.src = plfx_ring_of(views);
    plfx_zncc_begin(&s, b.y0);
    for (y = b.y0; y < b.y1; y++) {
        plfx_map row = plfx_map_row(out, y);
        plfx_zncc_map_row(&s, y, &row);
    }
}

static void sweep_sad(const plfx_plan *plan, const plfx_views *views, band b,
                      const plfx_map *out, plfx_arena *a)
{
    plfx_rows src = {views->px, plan->ny, NULL, 1, 0};
    plfx_engine e;
    int32_t y;

    plfx_engine_carve(&e, plan, PLFX_LEAVE_COSTS, a);
    plfx_match_start(&e.match, b.y0);
    for (y = b.y0; y < b.y1; y++) {
        plfx_map row = plfx_map_row(out, y);
        plfx_engine_row(&e, &src, y, &row);
    }
}

plfx_status plfx_sweep_rows(const plfx_plan *plan, const plfx_views *views, int32_t j0,
                            int32_t j1, const plfx_map *out, void *ws, size_t ws_size)
{
    plfx_status status = check(plan, views, out, ws, ws_size);
    int32_t r;
    int32_t y;
    plfx_arena a;
    band b;

    if (status != PLFX_OK) {
        return status;
    }
    if (j0 < 0 || j0 > j1 || j1 > plan->ny) {
        return PLFX_E_ARG;
    }
    a.base = ws;
    a.used = 0;
    r = plan->cfg.window / 2;
    b.y0 = plfx_clamp_i32(j0, r, plan->ny - r);
    b.y1 = plfx_clamp_i32(j1, b.y0, plan->ny - r);
    if (b.y0 < b.y1 && is_zncc(plan)) {
        sweep_zncc(plan, views, b, out, &a);
    } else if (b.y0 < b.y1) {
        sweep_sad(plan, views, b, out, &a);
    }
    for (y = j0; y < j1; y++) {
        if (y < r || y >= plan->ny - r) {
            plfx_map row = plfx_map_row(out, y);
            plfx_map_edge(&row);
        }
    }
    return PLFX_OK;
}

plfx_status plfx_sweep(const plfx_plan *plan, const plfx_views *views,
                       const plfx_map *out, void *ws, size_t ws_size)
{
    int32_t ny = plan ? plan->ny : 0;

    return plfx_sweep_rows(plan, views, 0, ny, out, ws, ws_size);
}
