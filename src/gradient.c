/* SPDX-License-Identifier: MIT */
#include "plenofix/gradient.h"
#include "rows.h"
#include "arena.h"
#include "fix.h"

#include <string.h>

/* Matched pair, sum of p = 256, d per sample = 218/256 over two samples. */
#define P_SIDE 59
#define P_MID  138
#define D_SIDE 109

enum { CENTRE, LEFT, RIGHT, UP, DOWN, VIEWS };

typedef struct cell { /* products of one lens, or their column sums */
    int64_t xu, yv, xx, yy, xy;
} cell;

typedef struct state {
    const plfx_plan *plan;
    const plfx_views *views;
    cell *col; /* [nx] sums over the window's rows */
    uint16_t
        *row[VIEWS][3]; /* rows y-1, y, y+1 of each view, aligned to row y's columns */
} state;

static void carve(state *s, const plfx_plan *plan, plfx_arena *a)
{
    int32_t v;
    int32_t r;

    s->plan = plan;
    s->col = plfx_take(a, (size_t)plan->nx, sizeof(cell));
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

    carve(&s, plan, &a);
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
            plfx_sample_row(s->plan, s->views, v, shift, y, 0, s->plan->nx,
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

static const int32_t smooth[3] = {P_SIDE, P_MID, P_SIDE};
static const int32_t differ[3] = {-D_SIDE, 0, D_SIDE};

/* Derivative along x or y of three views in line, prefiltered along their offset:
 * q4. */
static int64_t spatial_q4(const state *s, int32_t minus, int32_t plus, int32_t x,
                          const int32_t *along, const int32_t *across)
{
    int64_t sum = P_SIDE * (stencil(s, minus, x, along, across) +
                            stencil(s, plus, x, along, across)) +
                  P_MID * stencil(s, CENTRE, x, along, across);

    return plfx_round_shift_i64(sum, 20);
}

/* Derivative along the offset, prefiltered along x and y: q4 a step. */
static int64_t angular_q4(const state *s, int32_t minus, int32_t plus, int32_t x)
{
    int64_t diff =
        stencil(s, plus, x, smooth, smooth) - stencil(s, minus, x, smooth, smooth);

    return plfx_round_shift_i64(D_SIDE * diff, 20);
}

static cell products(const state *s, int32_t x)
{
    int64_t ix = spatial_q4(s, LEFT, RIGHT, x, differ, smooth);
    int64_t iy = spatial_q4(s, UP, DOWN, x, smooth, differ);
    cell c;

    c.xu = ix * angular_q4(s, LEFT, RIGHT, x);
    c.yv = iy * angular_q4(s, UP, DOWN, x);
    c.xx = ix * ix;
    c.yy = iy * iy;
    c.xy = ix * iy;
    return c;
}

static void add(cell *to, const cell *c, int64_t sign)
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
        cell c = products(s, x);
        add(&s->col[x], &c, sign);
    }
}

/* num/den as a slope: num and den are cut to 31 bits of den; |slope| saturates at 8. */
static int32_t ratio_q16(int64_t num, int64_t den, int64_t du_q8)
{
    int32_t over = plfx_log2_u64((uint64_t)den) - 30;
    int64_t limit;

    if (over > 0) {
        num = plfx_asr_i64(num, over);
        den = plfx_asr_i64(den, over);
    }
    limit = den * 4096; /* |slope * du_q8| beyond 16 * 256: saturated below */
    num = num > limit ? limit : num < -limit ? -limit : num;
    if (du_q8 < 0) {
        num = -num;
        du_q8 = -du_q8;
    }
    num = plfx_div_round_i64(num * 65536, den);
    num = plfx_div_round_i64(num * 256, du_q8);
    return plfx_clamp_i32(plfx_sat_i32(num), -(8 << 16), 8 << 16);
}

/* Least squares over both axes with the lattice's ratios in q12 (under 2^13): window
 * sums of products are under 2^45. */
static int32_t slope_q16(const plfx_plan *plan, const cell *w)
{
    int64_t col = plfx_asr_i32(plan->col_q16, 4);
    int64_t row = plfx_asr_i32(plan->row_q16, 4);
    int64_t num = -(col * w->xu + row * w->yv);
    int64_t den =
        plfx_asr_i64(col * col, 12) * w->xx + plfx_asr_i64(row * row, 12) * w->yy;

    return den > 0 ? ratio_q16(num, den, plan->du_q8[2]) : PLFX_SLOPE_NONE;
}

/* Smaller eigenvalue of the structure tensor of n samples, counts^2 a sample. */
static uint64_t smaller_eigenvalue(const cell *w, int64_t n)
{
    int64_t xx = w->xx / n; /* q8, under 2^36 */
    int64_t yy = w->yy / n;
    int64_t xy = w->xy / n;
    int64_t d = plfx_asr_i64(xx - yy, 6);
    int64_t c = plfx_asr_i64(xy, 5);
    int64_t root = (int64_t)plfx_isqrt_u64((uint64_t)(d * d + c * c)) * 64;
    int64_t least = plfx_asr_i64(xx + yy - root, 9);

    return least > 0 ? (uint64_t)least : 0u;
}

static uint16_t confidence(const plfx_plan *plan, const cell *w)
{
    int64_t n = (int64_t)plan->cfg.window * plan->cfg.window;
    uint64_t e = smaller_eigenvalue(w, n);
    uint64_t floor_e = (uint64_t)1 << (2 * (plan->cfg.bits - 6));

    return (uint16_t)(e * 65535u / (e + floor_e));
}

static void write_lens(const plfx_map *m, size_t at, int32_t slope, uint16_t conf,
                       uint8_t flags)
{
    m->slope_q16[at] = slope;
    if (m->conf_u16) {
        m->conf_u16[at] = slope == PLFX_SLOPE_NONE ? 0u : conf;
    }
    if (m->sigma_u20) {
        m->sigma_u20[at] = PLFX_SIGMA_NONE;
    }
    if (m->flags) {
        m->flags[at] = flags;
    }
}

static void judge(const plfx_plan *plan, const plfx_map *out, size_t at, const cell *w)
{
    uint16_t conf = confidence(plan, w);
    int32_t slope = slope_q16(plan, w);

    if (slope == PLFX_SLOPE_NONE) {
        write_lens(out, at, slope, 0, PLFX_FLAG_TEXTURE);
    } else if (conf < plan->cfg.unique_u16) {
        write_lens(out, at, PLFX_SLOPE_NONE, 0, PLFX_FLAG_TEXTURE);
    } else {
        write_lens(out, at, slope, conf, 0);
    }
}

static void edge(const plfx_map *out, int32_t y, int32_t x0, int32_t x1)
{
    int32_t x;

    for (x = x0; x < x1; x++) {
        write_lens(out, (size_t)y * (size_t)out->stride + (size_t)x, PLFX_SLOPE_NONE, 0,
                   PLFX_FLAG_EDGE);
    }
}

/* Windows with their stencils inside the map: lenses r+1 .. nx-2-r. */
static void target_row(const state *s, const plfx_map *out, int32_t y)
{
    int32_t w = s->plan->cfg.window;
    int32_t r = w / 2;
    cell sum = {0, 0, 0, 0, 0};
    int32_t x;

    edge(out, y, 0, r + 1);
    for (x = 1; x < s->plan->nx - 1; x++) {
        add(&sum, &s->col[x], 1);
        if (x > w) {
            add(&sum, &s->col[x - w], -1);
        }
        if (x >= w) {
            judge(s->plan, out, (size_t)y * (size_t)out->stride + (size_t)(x - r),
                  &sum);
        }
    }
    edge(out, y, s->plan->nx - 1 - r, s->plan->nx);
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
    int32_t w;
    int32_t y;

    if (status != PLFX_OK) {
        return status;
    }
    a.base = ws;
    a.used = 0;
    carve(&s, plan, &a);
    s.views = views;
    memset(s.col, 0, (size_t)plan->nx * sizeof(cell));
    w = plan->cfg.window;
    for (y = 1; y < plan->ny - 1; y++) { /* product rows 1 .. ny-2 */
        columns(&s, y, 1);
        if (y > w) {
            columns(&s, y - w, -1);
        }
        if (y >= w) {
            target_row(&s, out, y - w / 2);
        }
    }
    for (y = 0; y <= w / 2; y++) {
        edge(out, y, 0, plan->nx);
        edge(out, plan->ny - 1 - y, 0, plan->nx);
    }
    return PLFX_OK;
}
