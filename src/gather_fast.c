/* SPDX-License-Identifier: MIT
 * The fast profile's gathering: blocks of lenses side by side, lane-wise but for the
 * pixel loads.  A block is visited in the sensor rows that any of its lenses needs. */
#include "gather_row.h"
#include "bytes.h"
#include "lut_rows.h"

#define LANES PLFX_TAP_LANES

#define ABOVE_ALL (-(1 << 30)) /* y of a missing lens: -16384 px, */
#define ABOVE     (-16000)     /* which no displacement brings to this row */
#define NARROW    32000 /* rows of a sensor whose lenses lie within 2^15 everywhere */

/* floor((at + i step)/64) of lenses i, in 32 bits that wrap: where they do, no lens is
 * in use, since those lie within a pitch of the sensor. */
static void steps(int64_t at, int32_t step, int32_t n, int32_t *restrict to)
{
    uint32_t whole = (uint32_t)plfx_asr_i64(at, 6);
    uint32_t part = (uint32_t)at & 63u;
    uint32_t wholes = (uint32_t)plfx_asr_i32(step, 6);
    uint32_t parts = (uint32_t)step & 63u;
    int32_t i;

    for (i = 0; i < n; i++) { /* parts: under 4096 * 64 */
        uint32_t k = (uint32_t)i;
        to[i] = (int32_t)(whole + k * wholes + ((part + k * parts) >> 6));
    }
}

/* Centres of lens row j: those of plfx_lut_centre(), by steps; a residual is q12. */
static void centres(const plfx_gather *g, int32_t j, const plfx_gather_lenses *to)
{
    const plfx_lattice *l = &g->lut->lattice;
    int64_t odd = j & 1;
    int64_t x = (int64_t)l->origin.x_q16 * 64 + (int64_t)j * l->b.x_q22 +
                odd * l->odd.x_q22 + 32;
    int64_t y = (int64_t)l->origin.y_q16 * 64 + (int64_t)j * l->b.y_q22 +
                odd * l->odd.y_q22 + 32;
    const uint8_t *r = plfx_lut_resi_row(g->lut, j);
    int32_t i;

    steps(x, l->a.x_q22, l->nx, to->x_q16);
    steps(y, l->a.y_q22, l->nx, to->y_q16);
    for (i = 0; g->lut->resi.length > 0 && i < l->nx; i++) {
        uint32_t dx = 16u * (uint32_t)plfx_get_i16(r + 4 * i);
        uint32_t dy = 16u * (uint32_t)plfx_get_i16(r + 4 * i + 2);
        to->x_q16[i] = (int32_t)((uint32_t)to->x_q16[i] + dx);
        to->y_q16[i] = (int32_t)((uint32_t)to->y_q16[i] + dy);
    }
}

/* Missing lenses, and lanes behind the last lens, out of every row's way. */
static void set_aside(const plfx_gather *g, int32_t j, const plfx_gather_lenses *to)
{
    int32_t nx = g->lut->lattice.nx;
    int32_t i;

    for (i = 0; g->lut->flag.length > 0 && i < nx; i++) {
        if (plfx_lut_flags(g->lut, i, j) & PLFX_LENS_MISSING) {
            to->y_q16[i] = ABOVE_ALL;
        }
    }
    for (i = nx; i < g->blocks * LANES; i++) {
        to->x_q16[i] = to->x_q16[nx - 1];
        to->y_q16[i] = ABOVE_ALL;
    }
}

/* Bounds of a block; lenses set aside are put beside a measured one. */
static void bound(const plfx_gather *g, int32_t *restrict x, const int32_t *restrict y,
                  plfx_gather_block *b)
{
    int32_t least = INT32_MAX;
    int32_t most = INT32_MIN;
    int32_t left = INT32_MAX;
    int32_t right = INT32_MIN;
    int32_t i;

    PLFX_LANE_LOOP(i, LANES)
    {
        int32_t here = y[i];
        int32_t at = x[i];
        int32_t out = here == ABOVE_ALL;
        least = plfx_min_i32(least, out ? INT32_MAX : here);
        most = plfx_max_i32(most, here);
        left = plfx_min_i32(left, out ? INT32_MAX : at);
        right = plfx_max_i32(right, out ? INT32_MIN : at);
    }
    PLFX_LANE_LOOP(i, LANES)
    {
        x[i] = y[i] == ABOVE_ALL ? left : x[i];
    }
    b->least_q16 = least;
    b->most_q16 = most;
    b->inside = right >= left && left + g->least.x_q16 >= 0 &&
                plfx_asr_i32(right + g->most.x_q16, 16) < g->lut->sensor_w - 1;
}

void plfx_gather_aim(plfx_gather *g, int32_t j)
{
    int32_t slot = j % g->open;
    const plfx_gather_lenses *l = &g->lens[slot];
    plfx_rows_span all = {INT32_MAX, -1};
    int32_t b;

    centres(g, j, l);
    set_aside(g, j, l);
    for (b = 0; b < g->blocks; b++) {
        bound(g, l->x_q16 + b * LANES, l->y_q16 + b * LANES, l->block + b);
        if (l->block[b].most_q16 >= l->block[b].least_q16) {
            plfx_point upper = {0, l->block[b].least_q16};
            plfx_point lower = {0, l->block[b].most_q16};
            all.lo = plfx_min_i32(all.lo, plfx_gather_under(g, upper).lo);
            all.hi = plfx_max_i32(all.hi, plfx_gather_under(g, lower).hi);
        }
    }
    g->lo[slot] = all.lo;
    g->hi[slot] = all.hi;
}

/* Taps of LANES lenses, given their pixel pairs.  A lens that has none here keeps its
 * number. */
static inline void mix(const plfx_gather_row *v, const uint32_t *restrict two,
                       const uint32_t *restrict f, const int32_t *restrict cy,
                       int32_t shift, uint16_t *restrict to)
{
    int32_t r[LANES];
    uint32_t w[LANES];
    uint32_t s[LANES];
    int32_t i;

    plfx_places(cy, shift, r, w);
    PLFX_LANE_LOOP(i, LANES)
    {
        s[i] = to[i];
    }
    PLFX_LANE_LOOP(i, LANES)
    {
        uint32_t h = plfx_along(two[i], f[i], v->half, v->down);
        uint32_t next = r[i] == v->before ? plfx_across(s[i], h, w[i]) : s[i];
        s[i] = r[i] >= v->from && r[i] <= v->to ? h : next;
    }
    PLFX_LANE_LOOP(i, LANES)
    {
        to[i] = (uint16_t)s[i];
    }
}

static inline void taps(const plfx_gather_row *v, const int32_t *restrict cx,
                        const int32_t *restrict cy, plfx_point shift,
                        uint16_t *restrict to)
{
    int32_t x[LANES];
    uint32_t f[LANES];
    uint32_t two[LANES];
    int32_t i;

    plfx_places(cx, shift.x_q16, x, f);
    for (i = 0; i < LANES; i++) {
        two[i] = plfx_two(v->px + x[i]);
    }
    mix(v, two, f, cy, shift.y_q16, to);
}

/* The same where samples may lie beside the sensor. */
static void taps_beside(const plfx_gather_row *v, const int32_t *restrict cx,
                        const int32_t *restrict cy, plfx_point shift,
                        uint16_t *restrict to)
{
    int32_t x[LANES];
    uint32_t f[LANES];
    uint32_t two[LANES];
    int32_t i;

    plfx_places(cx, shift.x_q16, x, f);
    for (i = 0; i < LANES; i++) {
        uint32_t p = v->px[plfx_clamp_i32(x[i], 0, v->last_x)];
        uint32_t q = v->px[plfx_clamp_i32(x[i] + 1, 0, v->last_x)];
        two[i] = p | q << 16;
    }
    mix(v, two, f, cy, shift.y_q16, to);
}

/* All views of a block. */
static void block_taps(const plfx_gather *g, const plfx_gather_row *v,
                       const plfx_gather_block *b, const int32_t *cx, const int32_t *cy,
                       uint16_t *to)
{
    size_t nx = (size_t)g->lut->lattice.nx;
    int32_t k;

#if defined(PLFX_KERNELS_AVX2)
    if (v->narrow && b->inside) {
        plfx_gather_narrow(g, v, b, cx, cy, to);
        return;
    }
#endif
    for (k = 0; k < g->n; k++) {
        plfx_point s = g->shift[k];
        if (plfx_gather_meets(v, b, s.y_q16, s.y_q16)) {
            if (b->inside) {
                taps(v, cx, cy, s, to + (size_t)k * nx);
            } else {
                taps_beside(v, cx, cy, s, to + (size_t)k * nx);
            }
        }
    }
}

void plfx_gather_lanes(plfx_gather *g, int32_t j, int32_t y, const plfx_raw_row *row)
{
    int32_t slot = j % g->open;
    const plfx_gather_lenses *l = &g->lens[slot];
    uint16_t *to = g->rows + (size_t)(slot * g->n) * (size_t)g->lut->lattice.nx;
    int32_t b;
    plfx_gather_row v;

    v.px = g->pixels ? g->pixels : (const uint16_t *)(const void *)row->bytes;
    v.from = y == 0 ? ABOVE : y; /* rows off the sensor take its first or last */
    v.to = y == g->lut->sensor_h - 1 ? INT32_MAX : y;
    v.before = y - 1;
    v.last_x = g->lut->sensor_w - 1;
    v.down = g->bits - 8;
    v.half = (1u << v.down) >> 1;
    v.narrow = (v.down <= 4) & (g->lut->sensor_h < NARROW);
    for (b = 0; b < g->blocks; b++) {
        if (plfx_gather_meets(&v, l->block + b, g->least.y_q16, g->most.y_q16)) {
            block_taps(g, &v, l->block + b, l->x_q16 + b * LANES, l->y_q16 + b * LANES,
                       to + b * LANES);
        }
    }
}
