/* SPDX-License-Identifier: MIT
 * Zero-mean NCC row by row: rows of the views in, rows of the map out. */
#include "arena.h"
#include "engine.h"
#include "fix.h"
#include "plenofix/fuse.h"
#include "zncc_lanes.h"

#include <string.h>

#if PLFX_ZNCC_BY_ROWS
static void carve_rows(plfx_sweep_state *s, plfx_arena *a, size_t nx)
{
    uint32_t *words;

    s->rows = plfx_take(a, 1, sizeof(plfx_zncc_rows));
    words = plfx_take(a, 18u * nx + 192u, sizeof(uint32_t));
    if (s->rows) {
        s->rows->lanes = NULL;
        s->rows->a_low = words;
        s->rows->a_exp = (int32_t *)words + nx;
        s->rows->ab_sum = words + 2u * nx;
        s->rows->b_sum = words + 3u * nx;
        s->rows->b_g = words + 6u * nx;
        s->rows->half[0] = words + 9u * nx;
        s->rows->half[1] = words + 12u * nx;
        s->rows->b_exp = (int32_t *)words + 15u * nx;
        s->rows->steps = words + 18u * nx;
    }
    words = plfx_take(a, (size_t)s->pairs, sizeof(plfx_whole));
    if (s->rows) {
        s->rows->whole = (plfx_whole *)(void *)words;
    }
    words = plfx_take(a, 1, sizeof(plfx_zncc_piece));
    if (s->rows) {
        s->rows->piece = (plfx_zncc_piece *)(void *)words;
    }
}
#else
static void carve_rows(plfx_sweep_state *s, plfx_arena *a, size_t nx)
{
    (void)a;
    (void)nx;
    s->rows = NULL;
}
#endif

static void carve_zncc(plfx_sweep_state *s, plfx_arena *a, size_t nx, size_t cells)
{
    s->b_col = plfx_take(a, cells, sizeof(uint32_t));
    s->bb_col = plfx_take(a, cells, sizeof(uint32_t));
    s->ab_col = plfx_take(a, cells, sizeof(uint32_t));
    s->a_col = plfx_take(a, nx, sizeof(uint32_t));
    s->aa_col = plfx_take(a, nx, sizeof(uint32_t));
    s->a_sum = plfx_take(a, nx, sizeof(uint64_t));
    s->a_rsqrt = plfx_take(a, nx, sizeof(plfx_rsqrt));
    carve_rows(s, a, nx);
    s->race.label = plfx_take(a, 5u * nx, sizeof(uint16_t));
    s->race.best = plfx_behind(s->race.label, nx, sizeof(uint16_t));
    s->race.second = plfx_behind(s->race.label, 2u * nx, sizeof(uint16_t));
    s->race.before = plfx_behind(s->race.label, 3u * nx, sizeof(uint16_t));
    s->race.won = plfx_behind(s->race.label, 4u * nx, sizeof(uint16_t));
}

#if PLFX_ZNCC_BY_ROWS
static void carve_lanes(plfx_sweep_state *s, plfx_arena *a)
{
    plfx_zncc_lanes dry;
    plfx_zncc_lanes *z = plfx_take(a, 1, sizeof(plfx_zncc_lanes));
    uint32_t *words = plfx_take(a, 192, sizeof(uint32_t));
    plfx_zncc_piece *piece;

    s->rows = plfx_take(a, 1, sizeof(plfx_zncc_rows));
    piece = plfx_take(a, 1, sizeof(plfx_zncc_piece));
    if (s->rows) {
        s->rows->steps = words;
        s->rows->piece = piece;
        s->rows->lanes = z;
    }
    plfx_zncc_lanes_carve(z ? z : &dry, s->plan, a);
    if (z) {
        z->row.plan = s->plan;
        z->row.tex = s->tex;
        z->row.span = s->span;
    }
}
#endif

void plfx_zncc_carve(plfx_sweep_state *s, const plfx_plan *plan, plfx_arena *a)
{
    size_t nx = (size_t)plan->nx;
    size_t labels = plan->cfg.labels;
    size_t pairs = plan->cfg.n - 1u; /* correlation is of pairs alone */

    s->plan = plan;
    s->pairs = (int32_t)pairs;
    s->span = plfx_take(a, pairs * labels, sizeof(plfx_span));
    s->cost = plfx_take(a, labels * nx, sizeof(uint16_t));
    s->sample = plfx_take(a, 3u * nx, sizeof(uint16_t));
    s->tex_col = plfx_take(a, nx, sizeof(uint32_t));
    s->tex = plfx_take(a, nx, sizeof(uint32_t));
    s->out.slope_q16 = plfx_take(a, pairs * nx, sizeof(int32_t));
    s->out.conf_u16 = plfx_take(a, pairs * nx, sizeof(uint16_t));
    s->out.weight_u16 = plfx_take(a, pairs * nx, sizeof(uint16_t));
    s->out.flags = plfx_take(a, pairs * nx, sizeof(uint8_t));
    s->slopes = plfx_take(a, pairs, sizeof(int32_t));
    s->weights = plfx_take(a, pairs, sizeof(uint16_t));
#if PLFX_ZNCC_BY_ROWS
    if (plfx_zncc_lanes_fit(plan)) {
        carve_lanes(s, a);
        return;
    }
#endif
    carve_zncc(s, a, nx, pairs * labels * nx);
}

/* Spans of every pair and label. */
static void fill_spans(const plfx_sweep_state *s)
{
    const plfx_plan *plan = s->plan;
    int32_t labels = plan->cfg.labels;
    int32_t r = plan->cfg.window / 2;
    int32_t p;
    int32_t l;

    for (p = 0; p < s->pairs; p++) {
        int32_t view = plfx_pair_view(plan, p);
        for (l = 0; l < labels; l++) {
            s->span[p * labels + l] =
                plfx_span_of(plan, plfx_plan_shift(plan, view, l), r);
        }
    }
}

static void clear(const plfx_sweep_state *s)
{
    size_t nx = (size_t)s->plan->nx;
    size_t cells = (size_t)s->pairs * s->plan->cfg.labels * nx;

    /* NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): carved where lanes are not */
    memset(s->b_col, 0, cells * sizeof(uint32_t));
    memset(s->bb_col, 0, cells * sizeof(uint32_t));
    memset(s->ab_col, 0, cells * sizeof(uint32_t));
    memset(s->a_col, 0, nx * sizeof(uint32_t));
    memset(s->aa_col, 0, nx * sizeof(uint32_t));
}

void plfx_zncc_begin(plfx_sweep_state *s, int32_t y0)
{
    size_t nx = (size_t)s->plan->nx;

    fill_spans(s);
    memset(s->tex_col, 0, nx * sizeof(uint32_t));
    memset(s->tex, 0, nx * sizeof(uint32_t));
    s->first = y0 - s->plan->cfg.window / 2;
    s->next = s->first;
#if PLFX_ZNCC_BY_ROWS
    plfx_zncc_start(s);
    if (s->rows->lanes) {
        plfx_zncc_lanes_start(s->rows->lanes);
        return;
    }
#endif
    clear(s);
}

/* The row that leaves the window when row y enters; -1: none. */
static int32_t gone(const plfx_sweep_state *s, int32_t y)
{
    int32_t r = y - s->plan->cfg.window;

    return r >= s->first ? r : -1;
}

static void texture(const plfx_sweep_state *s, int32_t y)
{
    if (s->plan->cfg.texture > 0) {
        plfx_texture_row(s, y, 1);
        if (gone(s, y) >= 0) {
            plfx_texture_row(s, gone(s, y), -1);
        }
    }
}

static void columns(const plfx_sweep_state *s, int32_t y)
{
    plfx_zncc_row(s, y, 1);
    if (gone(s, y) >= 0) {
        plfx_zncc_row(s, gone(s, y), -1);
    }
}

static void fuse_row(const plfx_sweep_state *s, const plfx_map *row)
{
    int32_t r = s->plan->cfg.window / 2;
    int32_t x;

    for (x = 0; x < s->plan->nx; x++) {
        if (x < r || x >= s->plan->nx - r) {
            plfx_map_put(row, (size_t)x, PLFX_SLOPE_NONE, 0, PLFX_FLAG_EDGE);
        } else {
            plfx_fused f = plfx_fuse_pairs(s, x);
            plfx_map_put(row, (size_t)x, f.slope_q16, f.conf_u16, f.flags);
        }
    }
}

static void columns_row(const plfx_sweep_state *s, int32_t y, const plfx_map *row)
{
    int32_t p;

    plfx_zncc_reference(s);
    for (p = 0; p < s->pairs; p++) {
        plfx_zncc_cost(s, p);
        plfx_pair_winners(s, p, y);
    }
    fuse_row(s, row);
}

#if PLFX_ZNCC_BY_ROWS
/* Lines of the pairs: rows of s->out, or the map's own where one pair is the
 * result. */
static int32_t aim_line(const plfx_sweep_state *s, const plfx_map *row, int32_t p,
                        plfx_line *line)
{
    size_t at = (size_t)p * (size_t)s->plan->nx;

    if (s->pairs == 1 && s->plan->cfg.fuse == PLFX_FUSE_MEDIAN) {
        line->slope_q16 = row->slope_q16;
        line->conf_u16 = row->conf_u16;
        line->weight_u16 = NULL;
        line->flags = row->flags;
        return 1;
    }
    line->slope_q16 = s->out.slope_q16 + at;
    line->conf_u16 = s->out.conf_u16 + at;
    line->weight_u16 = s->out.weight_u16 + at;
    line->flags = s->out.flags + at;
    return 0;
}

/* Row `last` enters, and map row `target` comes out. */
static void lanes_row(const plfx_sweep_state *s, int32_t last, int32_t target,
                      const plfx_map *row)
{
    plfx_line *lines = s->rows->lanes->lines;
    int32_t whole = 0;
    int32_t p;

    for (p = 0; p < s->pairs; p++) {
        whole = aim_line(s, row, p, lines + p);
    }
    plfx_zncc_lanes_row(s, last, gone(s, last), target, lines);
    if (whole) {
        plfx_map_no_sigma(row);
    } else {
        fuse_row(s, row);
    }
}

static int32_t by_lanes(const plfx_sweep_state *s)
{
    return s->rows->lanes != NULL;
}

static void enter(const plfx_sweep_state *s, int32_t y)
{
    if (by_lanes(s)) {
        plfx_zncc_lanes_row(s, y, gone(s, y), 0, NULL);
    } else {
        columns(s, y);
    }
}

static void come_out(const plfx_sweep_state *s, int32_t last, int32_t y,
                     const plfx_map *row)
{
    if (by_lanes(s)) {
        lanes_row(s, last, y, row);
    } else {
        columns(s, last);
        columns_row(s, y, row);
    }
}
#else
static void enter(const plfx_sweep_state *s, int32_t y)
{
    columns(s, y);
}

static void come_out(const plfx_sweep_state *s, int32_t last, int32_t y,
                     const plfx_map *row)
{
    columns(s, last);
    columns_row(s, y, row);
}
#endif

void plfx_zncc_map_row(plfx_sweep_state *s, int32_t y, const plfx_map *row)
{
    int32_t last = y + s->plan->cfg.window / 2;

    for (; s->next < last; s->next++) {
        texture(s, s->next);
        enter(s, s->next);
    }
    texture(s, last);
    if (s->plan->cfg.texture > 0) {
        plfx_texture_sums(s);
    }
    come_out(s, last, y, row);
    s->next = last + 1;
}
