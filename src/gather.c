/* SPDX-License-Identifier: MIT */
#include "gather.h"
#include "fix.h"
#include "mend.h"

/* Pixels under one lens: offsets of +-128 px and two taps. */
#define SEGMENT_MAX 260

static void carve_lenses(plfx_gather *g, plfx_arena *a)
{
    size_t n = (size_t)g->blocks * PLFX_TAP_LANES;
    int32_t k;

    for (k = 0; k < g->open; k++) {
        plfx_gather_lenses *l = &g->lens[k];
        l->x_q16 = plfx_take(a, 2u * n, sizeof(int32_t));
        l->y_q16 = plfx_behind(l->x_q16, n, sizeof(int32_t));
        l->block = plfx_take(a, (size_t)g->blocks, sizeof(plfx_gather_block));
    }
}

void plfx_gather_carve(plfx_gather *g, const plfx_stream_cfg *cfg, plfx_arena *a)
{
    size_t nx = (size_t)cfg->lut->lattice.nx;
    size_t open = (size_t)cfg->open_rows;
    size_t n = cfg->plan->cfg.n;

    g->lut = cfg->lut;
    g->tone = cfg->tone;
    g->at = cfg->plan->cfg.at;
    g->n = cfg->plan->cfg.n;
    g->open = cfg->open_rows;
    g->white = cfg->white && cfg->lut->gain.length > 0;
    g->bits = cfg->bits;
    g->lanes = cfg->profile == PLFX_PROFILE_FAST;
    g->blocks = (cfg->lut->lattice.nx + PLFX_TAP_LANES - 1) / PLFX_TAP_LANES;
    g->shift = plfx_take(a, n, sizeof(plfx_point));
    g->rows = plfx_take(a, open * n * nx + PLFX_TAP_LANES, sizeof(uint16_t));
    g->line = g->white ? plfx_take(a, nx, sizeof(uint16_t)) : NULL;
    g->pixels = NULL;
    if (g->lanes) {
        carve_lenses(g, a);
        if (cfg->format != PLFX_RAW_U16) {
            g->pixels = plfx_take(a, (size_t)cfg->lut->sensor_w, sizeof(uint16_t));
        }
    }
}

void plfx_gather_start(plfx_gather *g)
{
    int32_t k;

    for (k = 0; k < g->n; k++) {
        plfx_point s = plfx_tap_shift(g->lut, &g->tone, g->at[k]);
        if (g->shift) {
            g->shift[k] = s;
        }
        g->least.x_q16 = k ? plfx_min_i32(g->least.x_q16, s.x_q16) : s.x_q16;
        g->least.y_q16 = k ? plfx_min_i32(g->least.y_q16, s.y_q16) : s.y_q16;
        g->most.x_q16 = k ? plfx_max_i32(g->most.x_q16, s.x_q16) : s.x_q16;
        g->most.y_q16 = k ? plfx_max_i32(g->most.y_q16, s.y_q16) : s.y_q16;
    }
}

plfx_rows_span plfx_gather_under(const plfx_gather *g, plfx_point c)
{
    int32_t last = g->lut->sensor_h - 1;
    plfx_rows_span s;

    s.lo = plfx_clamp_i32(plfx_asr_i32(c.y_q16 + g->least.y_q16, 16), 0, last);
    s.hi = plfx_clamp_i32(plfx_asr_i32(c.y_q16 + g->most.y_q16, 16) + 1, 0, last);
    return s;
}

static int32_t missing(const plfx_gather *g, int32_t i, int32_t j)
{
    return (plfx_lut_flags(g->lut, i, j) & PLFX_LENS_MISSING) != 0;
}

plfx_rows_span plfx_gather_span(const plfx_gather *g, int32_t j)
{
    plfx_rows_span all = {INT32_MAX, -1};
    int32_t i;

    for (i = 0; i < g->lut->lattice.nx; i++) {
        if (!missing(g, i, j)) {
            plfx_rows_span s = plfx_gather_under(g, plfx_lut_centre(g->lut, i, j));
            all.lo = plfx_min_i32(all.lo, s.lo);
            all.hi = plfx_max_i32(all.hi, s.hi);
        }
    }
    return all;
}

void plfx_gather_open(plfx_gather *g, int32_t j)
{
    int32_t slot = j % g->open;
    plfx_rows_span s;

    if (g->lanes) {
        plfx_gather_aim(g, j);
        return;
    }
    s = plfx_gather_span(g, j);
    g->lo[slot] = s.lo;
    g->hi[slot] = s.hi;
}

void plfx_gather_unpack(plfx_gather *g, const plfx_raw_row *row)
{
    if (g->pixels) {
        plfx_status checked = plfx_raw_unpack(row, 0, row->width, g->pixels);
        (void)checked; /* by the caller: it cannot fail */
    }
}

/* Pixels x0 .. x1 of a row: in place, or unpacked here. */
static const uint16_t *segment(const plfx_raw_row *row, int32_t x0, int32_t x1,
                               uint16_t *room)
{
    plfx_status checked;

    if (row->format == PLFX_RAW_U16) {
        return (const uint16_t *)(const void *)row->bytes + x0;
    }
    checked = plfx_raw_unpack(row, x0, x1 - x0 + 1, room);
    (void)checked; /* by the caller: it cannot fail */
    return room;
}

typedef struct lens { /* what the taps of one lens share */
    plfx_point c;
    const uint16_t *px; /* pixel x0 */
    int32_t x0, y;
} lens;

/* Mean of two neighbours, 16 bits. */
static uint32_t along(const plfx_gather *g, const lens *l, int32_t k)
{
    int32_t last = g->lut->sensor_w - 1;
    int32_t x_q8 = plfx_asr_i32(l->c.x_q16 + g->shift[k].x_q16, 8);
    int32_t x = plfx_asr_i32(x_q8, 8);
    uint32_t p = l->px[plfx_clamp_i32(x, 0, last) - l->x0];
    uint32_t q = l->px[plfx_clamp_i32(x + 1, 0, last) - l->x0];
    int32_t down = g->bits - 8;

    return plfx_along(p | q << 16, (uint32_t)x_q8 & 255u, (1u << down) >> 1, down);
}

static void tap(const plfx_gather *g, const lens *l, int32_t k, uint16_t *to)
{
    int32_t last = g->lut->sensor_h - 1;
    int32_t y_q8 = plfx_asr_i32(l->c.y_q16 + g->shift[k].y_q16, 8);
    int32_t r = plfx_asr_i32(y_q8, 8);
    int32_t first = plfx_clamp_i32(r, 0, last);

    if (l->y == first) {
        *to = (uint16_t)along(g, l, k);
    } else if (l->y == r + 1) {
        *to = (uint16_t)plfx_across(*to, along(g, l, k), (uint32_t)y_q8 & 255u);
    }
}

/* All views of a lens that has taps in row y. */
static void taps(const plfx_gather *g, plfx_point c, int32_t y, const plfx_raw_row *row,
                 uint16_t *to)
{
    int32_t last = g->lut->sensor_w - 1;
    size_t nx = (size_t)g->lut->lattice.nx;
    uint16_t room[SEGMENT_MAX];
    int32_t x1;
    int32_t k;
    lens l;

    l.c = c;
    l.y = y;
    l.x0 = plfx_clamp_i32(plfx_asr_i32(c.x_q16 + g->least.x_q16, 16), 0, last);
    x1 = plfx_clamp_i32(plfx_asr_i32(c.x_q16 + g->most.x_q16, 16) + 1, 0, last);
    l.px = segment(row, l.x0, x1, room);
    for (k = 0; k < g->n; k++) {
        tap(g, &l, k, to + (size_t)k * nx);
    }
}

void plfx_gather_taps(plfx_gather *g, int32_t j, int32_t y, const plfx_raw_row *row)
{
    int32_t nx = g->lut->lattice.nx;
    int32_t slot = j % g->open;
    uint16_t *to = g->rows + (size_t)(slot * g->n) * (size_t)nx;
    int32_t i;

    if (y < g->lo[slot]) { /* a row is closed before y goes beyond it */
        return;
    }
    if (g->lanes) {
        plfx_gather_lanes(g, j, y, row);
        return;
    }
    for (i = 0; i < nx; i++) {
        plfx_point c = plfx_lut_centre(g->lut, i, j);
        plfx_rows_span s = plfx_gather_under(g, c);
        if (y >= s.lo && y <= s.hi && !missing(g, i, j)) {
            taps(g, c, y, row, to + i);
        }
    }
}

static void tone_row(plfx_curve c, uint16_t *row, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        row[i] = (uint16_t)plfx_toned(c, row[i]);
    }
}

static void tone_row_white(plfx_curve c, const uint16_t *restrict gain_u13,
                           uint16_t *restrict row, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        row[i] = (uint16_t)plfx_toned_white(c, row[i], gain_u13[i]);
    }
}

void plfx_gather_close(plfx_gather *g, int32_t j)
{
    int32_t nx = g->lut->lattice.nx;
    plfx_curve c = plfx_curve_of(&g->tone, g->bits);
    int32_t k;

    for (k = 0; k < g->n; k++) {
        uint16_t *row = g->rows + (size_t)((j % g->open) * g->n + k) * (size_t)nx;
        if (g->white) {
            plfx_status known =
                plfx_lut_gain_row(g->lut, j, g->at[k].u_q8, g->at[k].v_q8, g->line);
            (void)known; /* the table was opened: it cannot fail */
            tone_row_white(c, g->line, row, nx);
        } else {
            tone_row(c, row, nx);
        }
        plfx_mend_row(g->lut, j, row);
    }
}
