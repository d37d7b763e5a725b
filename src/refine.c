/* SPDX-License-Identifier: MIT
 * One robust Gauss-Newton step on e over all views.  Units: samples s of 12 bits;
 * residuals q4, gradients q2, weights q8.  For a view of share (bx,by):
 *   r = V(x + e*bx, y + e*by) - I(x,y),   g = bx*Ix + by*Iy
 *   A = sum w g^2,  B = sum w g r,  R = sum w r^2  (each >> 8),  W = sum w
 * then over the window's pixels q with |e(q) - e(p)| < gate
 *   step = sum(A (e(q)-e(p)) - B) / (A' + lambda),  lambda = mean(r^2) / prior^2
 * A' is sum A less what noise adds to squared gradients, W mean(b^2) noise^2 K, K the
 * sum of squares of the derivative's taps; at least a quarter of sum A.
 * |r| < 2^15, |g| < 2^16, n <= 128: A < 2^39, and 225 of them under 2^47; times the
 * gate under 2^63. */
#include <string.h>

#include "frame_state.h"
#include "arena.h"
#include "fix.h"
#include "ls_kernel.h"
#include "refine_state.h"

#define RESIDUAL_FLOOR 819 /* q8 of 12-bit counts: (0.11 grey levels)^2 */
#define OUTSIDE        (1 << 24)
#define NOISE_PLAIN    14791 /* K in q14 of views as they are: 130/144 */
#define NOISE_SMOOTH   1397  /* and of smoothed ones, of the noise before smoothing */

typedef plfx_sums sums;
typedef plfx_refine_work scratch;

static size_t carve(const plfx_frame_state *s, scratch *t, void *base)
{
    plfx_arena a = {base, 0};
    size_t nx = (size_t)s->nx;
    size_t side = (size_t)s->cfg.window + 4;

    t->ring = plfx_take(&a, (size_t)s->cfg.window * nx, sizeof *t->ring);
    t->gx = plfx_take(&a, nx, sizeof *t->gx);
    t->gy = plfx_take(&a, nx, sizeof *t->gy);
    t->value = plfx_take(&a, nx, sizeof *t->value);
    t->tukey = plfx_take(&a, PLFX_TUKEY_STEPS, sizeof *t->tukey);
    t->score = plfx_take(&a, side * side, sizeof *t->score);
    return a.used;
}

size_t plfx_refine_scratch(const plfx_frame_state *s)
{
    scratch t;

    return carve(s, &t, NULL);
}

/* (1 - (r/R)^2)^2 in Q8 by r/R in 256ths. */
static void fill_tukey(scratch *t)
{
    uint32_t i;

    for (i = 0; i < PLFX_TUKEY_STEPS; i++) {
        uint32_t q = 65536u - i * i;
        t->tukey[i] = (uint16_t)((q >> 8) * (q >> 8) >> 8);
    }
}

/* Five-point derivative [1 -8 0 8 -1]/12 at q2: t*4/12. */
static int32_t derivative(int32_t m2, int32_t m1, int32_t p1, int32_t p2)
{
    return plfx_asr_i32((m2 - 8 * m1 + 8 * p1 - p2) * 341 + 512, 10); /* 1/3 */
}

static void gradient_row(const plfx_frame_state *s, const scratch *t, int32_t y)
{
    const uint16_t *r[5];
    int32_t i;
    int32_t x;

    for (i = 0; i < 5; i++) {
        r[i] = plfx_frame_row(s, s->plan->cfg.ref,
                              plfx_clamp_i32(y + i - 2, 0, s->ny - 1));
    }
    for (x = 0; x < s->nx; x++) {
        t->gx[x] = derivative(r[2][x - 2], r[2][x - 1], r[2][x + 1], r[2][x + 2]);
        t->gy[x] = derivative(r[0][x], r[1][x], r[3][x], r[4][x]);
    }
}

/* Sample position in phases of 1/64: whole columns and phase. */
typedef struct place {
    int32_t at, phase;
} place;

static place place_of(int32_t e_q16, int32_t share_q16, int32_t log)
{
    int32_t q = (int32_t)plfx_round_shift_i64((int64_t)e_q16 * share_q16, 32 - log);
    place p;

    p.at = plfx_asr_i32(q, log);
    p.phase = q - p.at * (1 << log);
    return p;
}

static int32_t dot4(const int16_t *t, int32_t a, int32_t b, int32_t c, int32_t d)
{
    return t[0] * a + t[1] * b + t[2] * c + t[3] * d;
}

/* Along a row, along a column, or both: value at q4. */
static int32_t value_along(const uint16_t *v, ptrdiff_t step, int32_t phase)
{
    return plfx_asr_i32(
        dot4(plfx_ls4[phase], v[-step], v[0], v[step], v[2 * step]) + 512, 10);
}

static int32_t value_both(const uint16_t *v, ptrdiff_t step, int32_t px, int32_t py)
{
    int32_t h[4];
    int32_t i;

    for (i = 0; i < 4; i++) { /* q2: 14 bits and overshoot */
        const uint16_t *r = v + (i - 1) * step;
        h[i] = plfx_asr_i32(dot4(plfx_ls4[px], r[-1], r[0], r[1], r[2]) + 2048, 12);
    }
    return plfx_asr_i32(dot4(plfx_ls4[py], h[0], h[1], h[2], h[3]) + 2048, 12);
}

/* Taps between two of the table's phases, q24: rows of the table sum to 2^14, so these
 * sum to 2^24. */
static void blend_taps(int32_t phase_q16, int32_t taps[6])
{
    const int16_t *a = plfx_ls6[phase_q16 >> 10];
    const int16_t *b = plfx_ls6[(phase_q16 >> 10) + 1];
    int32_t f = phase_q16 & 1023;
    int32_t i;

    for (i = 0; i < 6; i++) {
        taps[i] = a[i] * (1024 - f) + b[i] * f;
    }
}

/* Six taps along a step, q4. */
static int32_t value6_along(const uint16_t *v, ptrdiff_t step, int32_t phase)
{
    int32_t taps[6];
    int64_t sum = 0;
    int32_t i;

    blend_taps(phase, taps);
    for (i = 0; i < 6; i++) {
        sum += (int64_t)taps[i] * v[(i - 2) * step];
    }
    return (int32_t)plfx_round_shift_i64(sum, 20);
}

/* Along rows to q8, then along the column to q4. */
static int32_t value6_both(const uint16_t *v, ptrdiff_t step, int32_t px, int32_t py)
{
    int32_t tx[6];
    int32_t ty[6];
    int64_t sum = 0;
    int32_t i;
    int32_t j;

    blend_taps(px, tx);
    blend_taps(py, ty);
    for (j = 0; j < 6; j++) {
        const uint16_t *r = v + (j - 2) * step;
        int64_t h = 0;
        for (i = 0; i < 6; i++) {
            h += (int64_t)tx[i] * r[i - 2];
        }
        sum += ty[j] * plfx_round_shift_i64(h, 16);
    }
    return (int32_t)plfx_round_shift_i64(sum, 28);
}

/* Value where pixel (x,y) with displacement e sees view k. */
static int32_t value4(const plfx_frame_state *s, int32_t k, int32_t x, int32_t y,
                      int32_t e)
{
    place px = place_of(e, s->bx_q16[k], 6);
    place py = place_of(e, s->by_q16[k], 6);
    int32_t xx = x + px.at;
    int32_t yy = y + py.at;
    ptrdiff_t step = (ptrdiff_t)s->n * s->stride;
    const uint16_t *v;

    if (xx < 1 || yy < 1 || xx > s->nx - 3 || yy > s->ny - 3) {
        return OUTSIDE;
    }
    v = plfx_frame_row(s, k, yy) + xx;
    if (s->by_q16[k] == 0) {
        return value_along(v, 1, px.phase);
    }
    if (s->bx_q16[k] == 0) {
        return value_along(v, step, py.phase);
    }
    return value_both(v, step, px.phase, py.phase);
}

static int32_t value6(const plfx_frame_state *s, int32_t k, int32_t x, int32_t y,
                      int32_t e)
{
    place px = place_of(e, s->bx_q16[k], 16);
    place py = place_of(e, s->by_q16[k], 16);
    int32_t xx = x + px.at;
    int32_t yy = y + py.at;
    ptrdiff_t step = (ptrdiff_t)s->n * s->stride;
    const uint16_t *v;

    if (xx < 2 || yy < 2 || xx > s->nx - 4 || yy > s->ny - 4) {
        return OUTSIDE;
    }
    v = plfx_frame_row(s, k, yy) + xx;
    if (s->by_q16[k] == 0) {
        return value6_along(v, 1, px.phase);
    }
    if (s->bx_q16[k] == 0) {
        return value6_along(v, step, py.phase);
    }
    return value6_both(v, step, px.phase, py.phase);
}

/* Row y of view k, warped; OUTSIDE where the kernel leaves the view. */
static void values(const plfx_frame_state *s, const int32_t *e, int32_t k, int32_t y,
                   int32_t *value)
{
    int32_t x;

    if (s->cfg.taps == 6) {
        for (x = 0; x < s->nx; x++) {
            value[x] = value6(s, k, x, y, e[x]);
        }
    } else {
        for (x = 0; x < s->nx; x++) {
            value[x] = value4(s, k, x, y, e[x]);
        }
    }
}

static void add_view(const plfx_frame_state *s, const scratch *t, int32_t k, int32_t y,
                     sums *row)
{
    const uint16_t *ref = plfx_frame_row(s, s->plan->cfg.ref, y);
    int32_t bx = plfx_asr_i32(s->bx_q16[k] + 8, 4); /* q12: 13 bits by 16 of gradient */
    int32_t by = plfx_asr_i32(s->by_q16[k] + 8, 4);
    int32_t limit = s->cfg.robust_q4 * 16;
    uint32_t recip = (256u << 16) / (uint32_t)limit;
    int32_t x;

    for (x = 0; x < s->nx; x++) {
        int32_t r = t->value[x] - 16 * ref[x];
        int32_t m = r < 0 ? -r : r;
        int32_t g = plfx_asr_i32(bx * t->gx[x] + by * t->gy[x], 12);
        int32_t wg;
        int32_t w;
        row[x].n += t->value[x] != OUTSIDE;
        if (m >= limit) {
            continue;
        }
        w = t->tukey[((uint32_t)m * recip) >> 16];
        wg = w * g;
        row[x].a += (int64_t)wg * g;
        row[x].b += (int64_t)wg * r;
        row[x].r += (int64_t)w * r * r;
        row[x].w += w;
    }
}

static void sum_row(const plfx_frame_state *s, const scratch *t, const int32_t *e,
                    int32_t y)
{
    sums *row = plfx_refine_row(s, t, y);
    int32_t k;
    int32_t x;

    memset(row, 0, (size_t)s->nx * sizeof *row);
    gradient_row(s, t, y);
    for (k = 0; k < s->n; k++) {
        if (s->arm_of[k] >= 0) {
            values(s, e + (size_t)y * (size_t)s->nx, k, y, t->value);
            add_view(s, t, k, y, row);
        }
    }
    for (x = 0; x < s->nx; x++) {
        row[x].a = plfx_asr_i64(row[x].a, 8);
        row[x].b = plfx_asr_i64(row[x].b, 8);
        row[x].r = plfx_asr_i64(row[x].r, 8);
    }
}

typedef plfx_refine_window window;

static window window_of(const plfx_frame_state *s, int32_t x, int32_t y)
{
    int32_t r = s->cfg.window / 2;
    window w;

    w.x0 = plfx_max_i32(x - r, 0);
    w.x1 = plfx_min_i32(x + r, s->nx - 1);
    w.y0 = plfx_max_i32(y - r, 0);
    w.y1 = plfx_min_i32(y + r, s->ny - 1);
    return w;
}

/* Gated sums of a window; b in q16 columns times A. */
static sums gather(const plfx_frame_state *s, const scratch *t, const int32_t *e,
                   window w, int32_t here)
{
    int32_t gate = s->cfg.gate_q8 * 256;
    sums total = {0, 0, 0, 0, 0};
    int32_t yy;
    int32_t xx;

    for (yy = w.y0; yy <= w.y1; yy++) {
        const sums *row = plfx_refine_row(s, t, yy);
        const int32_t *there = e + (size_t)yy * (size_t)s->nx;
        for (xx = w.x0; xx <= w.x1; xx++) {
            int32_t d = there[xx] - here;
            if (d >= gate || d <= -gate) {
                continue;
            }
            total.a += row[xx].a;
            total.b += row[xx].a * d - row[xx].b * 16384;
            total.r += row[xx].r;
            total.w += row[xx].w;
            total.n += row[xx].n;
        }
    }
    return total;
}

/* Squared gradient that noise alone gives a view, q8 of A. */
static int64_t gradient_noise(const plfx_frame_state *s)
{
    int64_t n2 = (int64_t)s->cfg.noise_q4 * s->cfg.noise_q4; /* counts^2 */
    int64_t share = 0;
    int64_t views = 0;
    int32_t k;

    for (k = 0; k < s->n; k++) {
        if (s->arm_of[k] >= 0) {
            share += (int64_t)s->bx_q16[k] * s->bx_q16[k];
            share += (int64_t)s->by_q16[k] * s->by_q16[k];
            views++;
        }
    }
    /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): a frame has arms */
    share = plfx_asr_i64(share / views, 16); /* at most 2^17 */
    return plfx_asr_i64(share * n2 * (s->smooth ? NOISE_SMOOTH : NOISE_PLAIN), 18);
}

/* Information without what noise adds to it. */
static int64_t information(const sums *t, int64_t noise_q8)
{
    int64_t left = t->a - plfx_asr_i64(t->w * noise_q8, 16);
    int64_t least = plfx_asr_i64(t->a, 2);

    return left < least ? least : left;
}

/* Mean of w r^2 over the views' samples, q8. */
static int64_t misfit_of(const sums *t)
{
    int64_t mean_q8 = t->n > 0 ? t->r / t->n : 0;

    return mean_q8 < RESIDUAL_FLOOR ? RESIDUAL_FLOOR : mean_q8;
}

/* Noise over the information prior: q8 -> q4, q24 of 1/prior^2; at least 1. */
static int64_t damping(const plfx_frame_state *s, int64_t misfit_q8)
{
    int64_t prior2 = (int64_t)s->cfg.prior_q12 * s->cfg.prior_q12;
    int64_t lambda = (misfit_q8 << 20) / prior2;

    return lambda < 1 ? 1 : lambda;
}

/* Gauss-Newton step, q16 columns. */
static int32_t step_of(const plfx_frame_state *s, const plfx_solution *v, int64_t b)
{
    int32_t most = s->cfg.clamp_q8 * 256;
    int64_t d = plfx_div_round_i64(b, v->a + v->lambda);

    return (int32_t)plfx_clamp_i64(d, -most, most);
}

static void finish_pixel(const plfx_frame_state *s, const scratch *t, const int32_t *in,
                         int32_t x, int32_t y, int32_t *out)
{
    size_t at = (size_t)y * (size_t)s->nx + (size_t)x;
    window w = window_of(s, x, y);
    sums total = gather(s, t, in, w, in[at]);
    plfx_solution v;

    v.a = information(&total, t->noise_q8);
    v.misfit_q8 = misfit_of(&total);
    v.lambda = damping(s, v.misfit_q8);
    v.step = step_of(s, &v, total.b);
    v.samples = total.n;
    out[at] = in[at] + v.step;
    if (t->last) {
        plfx_sigma_pixel(s, t, in, w, at, &v);
    }
    if (total.w < total.n * 160) {
        s->flags[at] |= PLFX_FLAG_OCCLUDED;
    }
}

void plfx_refine(const plfx_frame_state *s, const int32_t *in, int32_t *out,
                 int32_t last)
{
    scratch t;
    int32_t r = s->cfg.window / 2;
    int32_t y;
    int32_t x;

    (void)carve(s, &t, s->scratch);
    t.last = last;
    t.noise_q8 = gradient_noise(s);
    fill_tukey(&t);
    for (y = 0; y < s->ny + r; y++) {
        if (y < s->ny) {
            sum_row(s, &t, in, y);
        }
        for (x = 0; y >= r && x < s->nx; x++) {
            finish_pixel(s, &t, in, x, y - r, out);
        }
    }
}
