/* SPDX-License-Identifier: MIT */
#include "engine.h"
#include "fix.h"

#include <string.h>

static int32_t fuses(const plfx_plan *plan)
{
    return plan->cfg.method == PLFX_METHOD_PAIRS;
}

/* The median of one pair is the pair. */
static int32_t only_pair(const plfx_plan *plan)
{
    return plan->cfg.n == 2 && plan->cfg.fuse == PLFX_FUSE_MEDIAN;
}

static void carve_pairs(plfx_engine *e, plfx_arena *a)
{
    size_t pairs = (size_t)e->match.pairs;
    size_t nx = (size_t)e->match.plan->nx;

    e->fuse.plan = e->match.plan;
    e->fuse.pairs = e->match.pairs;
    e->fuse.out.slope_q16 = plfx_take(a, pairs * nx, sizeof(int32_t));
    e->fuse.out.conf_u16 = plfx_take(a, 2u * pairs * nx, sizeof(uint16_t));
    e->fuse.out.weight_u16 =
        plfx_behind(e->fuse.out.conf_u16, pairs * nx, sizeof(uint16_t));
    e->fuse.out.flags = plfx_take(a, pairs * nx, sizeof(uint8_t));
    e->fuse.slopes = plfx_take(a, pairs, sizeof(int32_t));
    e->fuse.weights = plfx_take(a, pairs, sizeof(uint16_t));
    e->lines = plfx_take(a, pairs, sizeof(plfx_line));
}

static void aim_lines(plfx_engine *e)
{
    size_t nx = (size_t)e->match.plan->nx;
    int32_t p;

    for (p = 0; p < e->match.pairs; p++) {
        e->lines[p].slope_q16 = e->fuse.out.slope_q16 + (size_t)p * nx;
        e->lines[p].conf_u16 = e->fuse.out.conf_u16 + (size_t)p * nx;
        e->lines[p].weight_u16 = e->fuse.out.weight_u16 + (size_t)p * nx;
        e->lines[p].flags = e->fuse.out.flags + (size_t)p * nx;
    }
}

void plfx_engine_carve(plfx_engine *e, const plfx_plan *plan, int32_t leave,
                       plfx_arena *a)
{
    plfx_match_carve(&e->match, plan, leave, a);
    e->lines = NULL;
    if (fuses(plan)) {
        carve_pairs(e, a);
        if (e->lines) {
            aim_lines(e);
        }
    }
}

plfx_map plfx_map_row(const plfx_map *m, int32_t y)
{
    size_t at = (size_t)y * (size_t)m->stride;
    plfx_map row = *m;

    row.slope_q16 += at;
    row.conf_u16 = m->conf_u16 ? m->conf_u16 + at : NULL;
    row.sigma_u20 = m->sigma_u20 ? m->sigma_u20 + at : NULL;
    row.flags = m->flags ? m->flags + at : NULL;
    row.h = 1;
    return row;
}

void plfx_map_put(const plfx_map *row, size_t at, int32_t slope, uint16_t conf,
                  uint8_t flags)
{
    row->slope_q16[at] = slope;
    if (row->conf_u16) {
        row->conf_u16[at] = slope == PLFX_SLOPE_NONE ? 0 : conf;
    }
    if (row->sigma_u20) {
        row->sigma_u20[at] = PLFX_SIGMA_NONE;
    }
    if (row->flags) {
        row->flags[at] = flags;
    }
}

void plfx_map_edge(const plfx_map *row)
{
    int32_t x;

    for (x = 0; x < row->w; x++) {
        row->slope_q16[x] = PLFX_SLOPE_NONE;
    }
    if (row->conf_u16) {
        memset(row->conf_u16, 0, (size_t)row->w * sizeof(uint16_t));
    }
    if (row->flags) {
        memset(row->flags, PLFX_FLAG_EDGE, (size_t)row->w);
    }
    plfx_map_no_sigma(row);
}

static void fuse_row(const plfx_engine *e, const plfx_map *row)
{
    int32_t r = e->match.plan->cfg.window / 2;
    int32_t x;

    for (x = 0; x < row->w; x++) {
        if (x < r || x >= row->w - r) {
            plfx_map_put(row, (size_t)x, PLFX_SLOPE_NONE, 0, PLFX_FLAG_EDGE);
        } else {
            plfx_fused f = plfx_fuse_pairs(&e->fuse, x);
            plfx_map_put(row, (size_t)x, f.slope_q16, f.conf_u16, f.flags);
        }
    }
}

void plfx_map_no_sigma(const plfx_map *row)
{
    int32_t x;

    for (x = 0; row->sigma_u20 && x < row->w; x++) {
        row->sigma_u20[x] = PLFX_SIGMA_NONE;
    }
}

void plfx_engine_row(plfx_engine *e, const plfx_rows *src, int32_t y,
                     const plfx_map *row)
{
    if (fuses(e->match.plan) && !only_pair(e->match.plan)) {
        plfx_match_row(&e->match, src, y, e->lines);
        fuse_row(e, row);
    } else {
        plfx_line line = {row->slope_q16, row->conf_u16, NULL, row->flags};
        plfx_match_row(&e->match, src, y, &line);
        plfx_map_no_sigma(row);
    }
}
