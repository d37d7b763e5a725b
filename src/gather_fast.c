/* SPDX-License-Identifier: MIT
 * The fast profile's gathering: lenses that begin in the same sensor row stand side by
 * side, so that their taps are lane-wise but for the two pixel loads. */
#include "gather.h"
#include "bytes.h"
#include "kernels.h"
#include "fix.h"

#include <string.h>

#define LANES 8
PLFX_STATIC_ASSERT(LANES <= PLFX_GATHER_SPARE, spare_lanes_fit);

/* Centres of lens row j: those of plfx_lut_centre(), by steps. */
static void centres(const plfx_gather *g, int32_t j)
{
    const plfx_lattice *l = &g->lut->lattice;
    int64_t odd = j & 1;
    int64_t x = (int64_t)l->origin.x_q16 * 64 + (int64_t)j * l->b.x_q22 +
                odd * l->odd.x_q22 + 32;
    int64_t y = (int64_t)l->origin.y_q16 * 64 + (int64_t)j * l->b.y_q22 +
                odd * l->odd.y_q22 + 32;
    const uint8_t *r =
        g->lut->blob + g->lut->resi.offset + 4 * ((size_t)j * (size_t)l->nx);
    int64_t has = g->lut->resi.length > 0 ? 1024 : 0;
    int32_t i;

    for (i = 0; i < l->nx; i++) {
        int64_t dx = has ? plfx_get_i16(r + 4 * i) * has : 0;
        int64_t dy = has ? plfx_get_i16(r + 4 * i + 2) * has : 0;
        g->centre[i].x_q16 = plfx_sat_i32(plfx_asr_i64(x + dx, 6));
        g->centre[i].y_q16 = plfx_sat_i32(plfx_asr_i64(y + dy, 6));
        x += l->a.x_q22;
        y += l->a.y_q22;
    }
}

/* Missing lenses are left out by a first row that no lens has. */
static void mark(const plfx_gather *g, int32_t j)
{
    int32_t i;

    for (i = 0; g->lut->flag.length > 0 && i < g->lut->lattice.nx; i++) {
        if (plfx_lut_flags(g->lut, i, j) & PLFX_LENS_MISSING) {
            g->begin[i] = -1;
        }
    }
}

/* First sensor row of each lens; rows and columns that the lens row spans. */
static plfx_rows_span extent(plfx_gather *g, plfx_gather_order *o, int32_t j)
{
    int32_t nx = g->lut->lattice.nx;
    plfx_rows_span all = {INT32_MAX, -1};
    int32_t left = INT32_MAX;
    int32_t right = INT32_MIN;
    int32_t i;

    for (i = 0; i < nx; i++) {
        g->begin[i] = (int16_t)plfx_gather_under(g, g->centre[i]).lo;
    }
    mark(g, j);
    for (i = 0; i < nx; i++) {
        if (g->begin[i] >= 0) {
            int32_t hi = plfx_gather_under(g, g->centre[i]).hi;
            all.lo = plfx_min_i32(all.lo, g->begin[i]);
            all.hi = plfx_max_i32(all.hi, hi);
            left = plfx_min_i32(left, g->centre[i].x_q16);
            right = plfx_max_i32(right, g->centre[i].x_q16);
        }
    }
    o->inside = all.hi >= all.lo && left + g->least.x_q16 >= 0 &&
                plfx_asr_i32(right + g->most.x_q16, 16) < g->lut->sensor_w - 1;
    return all;
}

/* Counting sort by the first sensor row: stable, so that lanes write side by side. */
static void sort(const plfx_gather *g, plfx_gather_order *o)
{
    int32_t nx = g->lut->lattice.nx;
    int32_t i;

    memset(o->start, 0, (PLFX_GATHER_ROWS + 1u) * sizeof(uint16_t));
    for (i = 0; i < nx; i++) {
        if (g->begin[i] >= 0) {
            o->start[g->begin[i] - o->first + 1]++;
        }
    }
    for (i = 0; i < o->count; i++) {
        o->start[i + 1] = (uint16_t)(o->start[i + 1] + o->start[i]);
    }
    for (i = 0; i < nx; i++) { /* start[b] runs ahead to start[b+1] */
        if (g->begin[i] >= 0) {
            uint16_t at = o->start[g->begin[i] - o->first]++;
            o->x_q16[at] = g->centre[i].x_q16;
            o->y_q16[at] = g->centre[i].y_q16;
            o->lens[at] = (uint16_t)i;
        }
    }
    for (i = o->count; i > 0; i--) {
        o->start[i] = o->start[i - 1];
    }
    o->start[0] = 0;
    for (i = 0; i < LANES; i++) { /* lanes beyond the last lens read beside it */
        int32_t end = o->start[o->count];
        o->x_q16[end + i] = o->x_q16[end - 1];
        o->y_q16[end + i] = o->y_q16[end - 1];
    }
}

void plfx_gather_sort(plfx_gather *g, int32_t j)
{
    int32_t slot = j % g->open;
    plfx_gather_order *o = &g->order[slot];
    plfx_rows_span s;

    centres(g, j);
    s = extent(g, o, j);
    g->lo[slot] = s.lo;
    g->hi[slot] = s.hi;
    o->first = s.lo;
    o->count = 0;
    if (s.hi >= s.lo) {
        o->count = s.hi - s.lo + 1;
        sort(g, o);
    }
}

typedef struct row_view { /* one view in one sensor row */
    const uint16_t *px;
    plfx_point shift;
    int32_t y, last_x, last_y, down;
    uint32_t half;
} row_view;

/* Means of two neighbours for LANES lenses, 16 bits. */
static inline void along(const row_view *v, const int32_t *restrict cx,
                         uint32_t *restrict h, int32_t inside)
{
    const uint16_t *restrict px = v->px;
    int32_t x0[LANES];
    int32_t x1[LANES];
    uint32_t f[LANES];
    uint32_t p[LANES];
    uint32_t q[LANES];
    int32_t shift = v->shift.x_q16;
    uint32_t half = v->half;
    int32_t down = v->down;
    int32_t i;

    PLFX_LANE_LOOP(i, LANES)
    {
        int32_t x = plfx_asr_i32(cx[i] + shift, 8);
        f[i] = (uint32_t)x & 255u;
        x0[i] = plfx_asr_i32(x, 8);
    }
    if (inside) {
        for (i = 0; i < LANES; i++) {
            const uint16_t *at = px + x0[i];
            p[i] = at[0];
            q[i] = at[1];
        }
    } else {
        for (i = 0; i < LANES; i++) {
            x1[i] = plfx_clamp_i32(x0[i] + 1, 0, v->last_x);
            p[i] = px[plfx_clamp_i32(x0[i], 0, v->last_x)];
            q[i] = px[x1[i]];
        }
    }
    PLFX_LANE_LOOP(i, LANES)
    {
        h[i] = (p[i] * (256u - f[i]) + q[i] * f[i] + half) >> down;
    }
}

/* First taps.  A lens whose first row is the next one takes a number that its own first
 * tap replaces. */
static void first_taps(const row_view *v, const int32_t *cx, uint16_t *restrict to,
                       int32_t inside)
{
    uint32_t h[LANES];
    int32_t i;

    along(v, cx, h, inside);
    PLFX_LANE_LOOP(i, LANES)
    {
        to[i] = (uint16_t)h[i];
    }
}

/* First or second taps of LANES lenses, the first m of which count. */
static void taps(const row_view *v, const int32_t *restrict cx,
                 const int32_t *restrict cy, uint16_t *restrict to, int32_t m,
                 int32_t inside)
{
    int32_t shift = v->shift.y_q16;
    int32_t now = v->y;
    int32_t last = v->last_y;
    uint32_t h[LANES];
    int32_t i;

    along(v, cx, h, inside);
    PLFX_LANE_LOOP(i, LANES)
    {
        int32_t y = plfx_asr_i32(cy[i] + shift, 8);
        int32_t r = plfx_asr_i32(y, 8);
        uint32_t w = (uint32_t)y & 255u;
        uint32_t old = to[i];
        uint32_t both = (old * (256u - w) + h[i] * w + 128u) >> 8;
        uint32_t next = now == r + 1 ? both : old;
        next = now == plfx_clamp_i32(r, 0, last) ? h[i] : next;
        to[i] = (uint16_t)(i < m ? next : old);
    }
}

/* Nonzero when one of LANES lenses has its second tap in this row. */
static int32_t any_second(const row_view *v, const int32_t *restrict cy)
{
    int32_t any = 0;
    int32_t i;

    PLFX_LANE_LOOP(i, LANES)
    {
        any |= v->y == plfx_asr_i32(cy[i] + v->shift.y_q16, 16) + 1;
    }
    return any;
}

/* Lenses of one bucket. */
static void run(const row_view *v, const plfx_gather_order *o, int32_t bucket,
                int32_t age, uint16_t *to)
{
    int32_t end = o->start[bucket + 1];
    int32_t i;

    for (i = o->start[bucket]; i < end; i += LANES) {
        if (age == 0 && end - i >= LANES) {
            first_taps(v, o->x_q16 + i, to + i, o->inside);
        } else if (age < 2 || any_second(v, o->y_q16 + i)) {
            taps(v, o->x_q16 + i, o->y_q16 + i, to + i, end - i, o->inside);
        }
    }
}

/* View k has taps in row y of lenses that begin 0, 1 or, by the carry of fractions, 2
 * rows before the row that lies as far above as the view does below the uppermost. */
static void view_taps(const plfx_gather *g, const row_view *v, int32_t k, int32_t slot)
{
    const plfx_gather_order *o = &g->order[slot];
    size_t nx = (size_t)g->lut->lattice.nx;
    int32_t lower = g->shift[k].y_q16 - g->least.y_q16;
    int32_t first = v->y - o->first - plfx_asr_i32(lower, 16);
    uint16_t *to = g->rows + (size_t)(slot * g->n + k) * nx;
    int32_t clamped = v->y == v->last_y || o->first == 0;
    int32_t b0 = clamped ? 0 : plfx_max_i32(first - 2, 0);
    int32_t b1 = plfx_min_i32(clamped ? o->count - 1 : first, o->count - 1);
    int32_t b;

    for (b = b0; b <= b1; b++) {
        run(v, o, b, clamped ? 1 : first - b, to);
    }
}

void plfx_gather_lanes(plfx_gather *g, int32_t j, int32_t y, const plfx_raw_row *row)
{
    int32_t k;
    row_view v;

    v.px = g->pixels ? g->pixels : (const uint16_t *)(const void *)row->bytes;
    v.y = y;
    v.last_x = g->lut->sensor_w - 1;
    v.last_y = g->lut->sensor_h - 1;
    v.down = g->bits - 8;
    v.half = (1u << v.down) >> 1;
    for (k = 0; k < g->n; k++) {
        v.shift = g->shift[k];
        view_taps(g, &v, k, j % g->open);
    }
}

/* From the row's order to columns; missing lenses are 0. */
void plfx_gather_place(plfx_gather *g, int32_t j)
{
    int32_t slot = j % g->open;
    const plfx_gather_order *o = &g->order[slot];
    size_t nx = (size_t)g->lut->lattice.nx;
    int32_t m = o->count > 0 ? o->start[o->count] : 0;
    int32_t k;
    int32_t i;

    for (k = 0; k < g->n; k++) {
        uint16_t *row = g->rows + (size_t)(slot * g->n + k) * nx;
        memcpy(g->line, row, nx * sizeof(uint16_t));
        for (i = 0; i < m; i++) {
            row[o->lens[i]] = g->line[i];
        }
    }
}
