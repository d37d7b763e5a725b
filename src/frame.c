/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "frame_state.h"
#include "arena.h"
#include "fix.h"

#define SMOOTH_FROM_Q4 12    /* noise from which views are smoothed first */
#define ARM_SUM_MAX    32767 /* 16-bit signed lanes */

int32_t plfx_frame_e_of(const plfx_frame_state *s, int32_t slope_q16)
{
    return (int32_t)plfx_round_shift_i64((int64_t)slope_q16 * s->base_q8, 8);
}

int32_t plfx_frame_slope_of(const plfx_frame_state *s, int32_t e_q16)
{
    return (int32_t)plfx_div_round_i64((int64_t)e_q16 * 256, s->base_q8);
}

uint16_t plfx_frame_sigma(const plfx_frame_state *s, uint32_t sigma_q16)
{
    uint64_t v = ((uint64_t)sigma_q16 << 12) / (uint32_t)s->base_q8; /* q16*q4*q8 */

    return (uint16_t)(v < PLFX_SIGMA_NONE - 1u ? v : PLFX_SIGMA_NONE - 1u);
}

static int32_t window_ok(int32_t w, int32_t max)
{
    return w == 0 || (w % 2 == 1 && w <= max);
}

static int32_t cfg_ok(const plfx_frame_cfg *c)
{
    return (c->arms == 4 || c->arms == 8) && c->keep >= 1 && c->keep <= 4 &&
           c->shrink <= 1 && (c->paths == 0 || c->paths == 5 || c->paths == 8) &&
           window_ok(c->median1, 7) && window_ok(c->median2, 7) &&
           (c->taps == 0 || c->taps == 4 || c->taps == 6) && c->window % 2 == 1 &&
           c->window <= 15 && c->passes >= 1 && c->passes <= 4 && c->axes <= 1 &&
           c->trunc_q4 >= 1 && c->trunc_q4 <= 1024 && c->gtrunc_q4 >= 1 &&
           c->gtrunc_q4 <= 1024 && c->gweight_q4 <= 31 && c->p1_q4 < c->p2_q4 &&
           c->p2_q4 <= 1024 && c->soften_q4 >= 1 && c->similar_q4 >= 1 &&
           c->robust_q4 >= 16 && c->robust_q4 <= 2048 && c->gate_q8 >= 1 &&
           c->gate_q8 <= 256 && c->clamp_q8 <= 256 && c->prior_q12 >= 1 &&
           c->noise_q4 <= 256;
}

/* Offsets in columns and rows a unit of slope, q8. */
static int32_t offset_x(const plfx_plan *p, int32_t k)
{
    return (int32_t)plfx_round_shift_i64((int64_t)p->du_q8[k] * p->col_q16, 16);
}

static int32_t offset_y(const plfx_plan *p, int32_t k)
{
    return (int32_t)plfx_round_shift_i64((int64_t)p->dv_q8[k] * p->row_q16, 16);
}

static int32_t magnitude(int32_t v)
{
    return v < 0 ? -v : v;
}

/* Sector of a direction: 0 +u, 1 +u+v, 2 +v ... of eight; borders at 22.5 degrees
 * (tangent 106/256), of four at 45. */
static int32_t sector(int32_t u, int32_t v, int32_t arms)
{
    int64_t au = magnitude(u);
    int64_t av = magnitude(v);

    if (arms == 4) {
        return au >= av ? (u > 0 ? 0 : 2) : (v > 0 ? 1 : 3);
    }
    if (256 * av <= 106 * au) {
        return u > 0 ? 0 : 4;
    }
    if (256 * au <= 106 * av) {
        return v > 0 ? 2 : 6;
    }
    return u > 0 ? (v > 0 ? 1 : 7) : (v > 0 ? 3 : 5);
}

static int32_t used(const plfx_frame_state *s, const uint8_t *skip, int32_t k)
{
    return k != s->plan->cfg.ref && !(skip && skip[k]);
}

static void derive_arms(plfx_frame_state *s, const uint8_t *skip)
{
    const plfx_plan *p = s->plan;
    int32_t k;

    s->base_q8 = 0;
    s->arms = 0;
    memset(s->arm_n, 0, sizeof s->arm_n);
    for (k = 0; k < s->n; k++) {
        if (used(s, skip, k)) {
            s->arm_n[sector(p->du_q8[k], p->dv_q8[k], s->cfg.arms)]++;
            s->base_q8 = plfx_max_i32(s->base_q8, magnitude(offset_x(p, k)));
            s->base_q8 = plfx_max_i32(s->base_q8, magnitude(offset_y(p, k)));
        }
    }
    for (k = 0; k < s->cfg.arms; k++) {
        s->arms += s->arm_n[k] > 0;
    }
    s->keep = plfx_min_i32(s->cfg.keep, s->arms);
}

static int32_t cost_max(const plfx_frame_state *s)
{
    return s->cfg.trunc_q4 + s->cfg.gtrunc_q4 * 2 * s->cfg.gweight_q4 / 16;
}

static int32_t arms_fit(const plfx_frame_state *s)
{
    int32_t a;

    for (a = 0; a < PLFX_ARMS_MAX; a++) {
        if (s->arm_n[a] * cost_max(s) > ARM_SUM_MAX) {
            return 0;
        }
    }
    return 1;
}

/* Mean of an arm times 2^up, so that the box fits 15 bits: mul in [2^14, 2^15]. */
static void derive_scales(plfx_frame_state *s)
{
    int32_t w = s->plan->cfg.window;
    int32_t most = w * w * cost_max(s); /* under 2^23 */
    int32_t up = 0;
    int32_t full;
    int32_t a;

    while (most > ARM_SUM_MAX) { /* at most 8 times */
        most = plfx_asr_i32(most, 1);
        up--;
    }
    while (most <= ARM_SUM_MAX / 2) { /* at most 11 times */
        most *= 2;
        up++;
    }
    for (a = 0; a < s->cfg.arms; a++) {
        int32_t n = plfx_max_i32(s->arm_n[a], 1);
        int32_t log = 0;
        while (2 << log <= n) { /* at most 7 times */
            log++;
        }
        s->arm_shift[a] = 14 + log - up;
        s->arm_mul[a] = (uint16_t)(((16384 << log) + n / 2) / n);
    }
    full = s->keep * most / 8; /* half of the range of keep quarters */
    /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): a frame has arms */
    s->vol_mul = (uint16_t)plfx_min_i32(65535, (255 * 65536 + full / 2) / full);
}

static void derive_penalties(plfx_frame_state *s)
{
    int32_t c = cost_max(s);

    s->p1 = plfx_max_i32(1, (s->cfg.p1_q4 * 510 + c / 2) / c);
}

/* P2 / (1 + i/S) in volume units, S in sixteenths, i in 8-bit levels. */
static uint16_t penalty_of(const plfx_frame_state *s, int32_t i)
{
    int32_t den = (s->cfg.soften_q4 + 16 * i) * cost_max(s) / 510;
    int32_t p2 = s->cfg.p2_q4 * s->cfg.soften_q4 / plfx_max_i32(den, 1);

    p2 = plfx_max_i32(p2, (11 * s->p1 + 9) / 10);
    return (uint16_t)plfx_min_i32(p2, 4000);
}

void plfx_frame_tables(const plfx_frame_state *s, const uint8_t *skip)
{
    const plfx_plan *p = s->plan;
    int32_t k;

    for (k = 0; k < s->n; k++) {
        int64_t x = (int64_t)offset_x(p, k) * 65536;
        int64_t y = (int64_t)offset_y(p, k) * 65536;
        s->bx_q16[k] = (int32_t)plfx_div_round_i64(x, s->base_q8);
        s->by_q16[k] = (int32_t)plfx_div_round_i64(y, s->base_q8);
        s->arm_of[k] = -1;
        if (used(s, skip, k)) {
            s->arm_of[k] = (int8_t)sector(p->du_q8[k], p->dv_q8[k], s->cfg.arms);
        }
    }
    for (k = 0; s->p2_of && k < 256; k++) {
        s->p2_of[k] = penalty_of(s, k);
    }
}

/* The winner's own error, which the prior stands for, grows with noise: 0.05 columns a
 * grey level, in quadrature. */
static uint16_t widened_prior(const plfx_frame_cfg *c)
{
    uint64_t more = 64u * (uint64_t)c->noise_q4 / 5u;
    uint64_t p = plfx_isqrt_u64((uint64_t)c->prior_q12 * c->prior_q12 + more * more);

    return (uint16_t)(p < UINT16_MAX ? p : UINT16_MAX);
}

/* Costs of matching samples grow with the noise: truncation, penalties, grey gates and
 * residual limits move with it. */
static void adapt(plfx_frame_cfg *c)
{
    uint32_t n = c->noise_q4 < SMOOTH_FROM_Q4 ? c->noise_q4 : (3u * c->noise_q4) / 8u;

    c->trunc_q4 = (uint16_t)(c->trunc_q4 + 2u * n);
    c->gtrunc_q4 = (uint16_t)(c->gtrunc_q4 + 4u * n);
    c->p1_q4 = (uint16_t)(c->p1_q4 + (3u * n + 10u) / 20u);
    c->p2_q4 = (uint16_t)(c->p2_q4 + (14u * n + 10u) / 20u);
    c->similar_q4 = (uint16_t)(c->similar_q4 + 4u * n);
    c->robust_q4 = (uint16_t)(c->robust_q4 + 2u * n);
    c->prior_q12 = widened_prior(c);
}

plfx_status plfx_frame_derive(plfx_frame_state *s, const plfx_plan *plan,
                              const plfx_frame_cfg *cfg, const uint8_t *skip)
{
    if (!plan || !cfg || plan->cfg.method != PLFX_METHOD_ARMS || !cfg_ok(cfg)) {
        return PLFX_E_ARG;
    }
    s->plan = plan;
    s->cfg = *cfg;
    s->smooth = cfg->noise_q4 >= SMOOTH_FROM_Q4;
    adapt(&s->cfg);
    s->nx = plan->nx;
    s->ny = plan->ny;
    s->n = plan->cfg.n;
    s->labels = plan->cfg.labels;
    s->ring = 0;
    s->kept = s->ny;
    s->pad = plan->reach_x + 4;
    s->stride = (s->nx + 2 * s->pad + 15) & ~15;
    derive_arms(s, skip);
    if (s->base_q8 == 0) { /* as it is without arms */
        return PLFX_E_ARG;
    }
    if (!arms_fit(s)) {
        return PLFX_E_RANGE;
    }
    derive_scales(s);
    derive_penalties(s);
    return PLFX_OK;
}

static size_t largest_scratch(const plfx_frame_state *s)
{
    size_t most = plfx_arms_scratch(s);
    size_t now = plfx_sgm_scratch(s);

    most = now > most ? now : most;
    now = plfx_median_scratch(s);
    most = now > most ? now : most;
    now = s->cfg.taps ? plfx_refine_scratch(s) : 0;
    most = now > most ? now : most;
    now = s->cfg.taps ? plfx_sigma_scratch(s) : 0;
    return now > most ? now : most;
}

size_t plfx_frame_carve(plfx_frame_state *s, void *base)
{
    plfx_arena a = {base, 0};
    size_t pixels = (size_t)s->nx * (size_t)s->ny;
    size_t slice = (size_t)s->nx * (size_t)s->labels;
    size_t rows = s->cfg.paths == 8 ? (size_t)s->ny : 1;

    s->arm_of = plfx_take(&a, (size_t)s->n, 1);
    s->bx_q16 = plfx_take(&a, (size_t)s->n, 4);
    s->by_q16 = plfx_take(&a, (size_t)s->n, 4);
    s->p2_of = plfx_take(&a, 256, 2);
    s->sample = plfx_take(
        &a, (size_t)s->ny * (size_t)s->n * (size_t)s->stride + PLFX_WINNER_CHUNK, 2);
    s->volume = plfx_take(&a, slice * (size_t)s->ny, 1);
    s->sum = plfx_take(&a, slice * rows + PLFX_ALIGN, 2);
    s->e_a = plfx_take(&a, pixels, 4);
    s->e_b = plfx_take(&a, pixels, 4);
    s->conf = plfx_take(&a, pixels, 2);
    s->sigma = plfx_take(&a, pixels, 2);
    s->flags = plfx_take(&a, pixels, 1);
    if (s->cfg.taps) {
        s->base = plfx_take(&a, pixels, 4);
        s->misfit = plfx_take(&a, pixels, 4);
        s->lever = plfx_take(&a, pixels, 4);
    }
    if (s->cfg.axes) {
        int32_t k;
        for (k = 0; k < 2; k++) {
            s->axis_best[k] = plfx_take(&a, pixels, 2);
            s->axis_label[k] = plfx_take(&a, pixels, 1);
        }
    }
    s->scratch = plfx_take(&a, largest_scratch(s), 1);
    return a.used;
}

size_t plfx_frame_ws(const plfx_plan *plan, const plfx_frame_cfg *cfg)
{
    plfx_frame_state s;

    if (plfx_frame_derive(&s, plan, cfg, NULL) != PLFX_OK) {
        return 0;
    }
    return plfx_frame_carve(&s, NULL);
}

/* Binomial [1 2 1]/4 along a row, in place; ends repeat. */
static void smooth_row(uint16_t *row, int32_t n)
{
    uint32_t before = row[0];
    int32_t x;

    for (x = 0; x < n; x++) {
        uint32_t here = row[x];
        uint32_t next = x + 1 < n ? row[x + 1] : here;
        row[x] = (uint16_t)((before + 2 * here + next + 2) >> 2);
        before = here;
    }
}

/* Row y of the views from raw rows y-1 .. y+1, along the columns. */
static const uint16_t *raw_row(const plfx_views *v, int32_t k, int32_t y)
{
    int32_t j = plfx_clamp_i32(y, 0, v->ny - 1);

    return v->px + ((size_t)j * (size_t)v->n + (size_t)k) * (size_t)v->nx;
}

/* 12-bit copies with repeated ends. */
static void load_row(const plfx_frame_state *s, const plfx_views *views, int32_t k,
                     int32_t y)
{
    const uint16_t *in = raw_row(views, k, y);
    const uint16_t *above = raw_row(views, k, y - 1);
    const uint16_t *below = raw_row(views, k, y + 1);
    uint16_t *out =
        s->sample + ((size_t)y * (size_t)s->n + (size_t)k) * (size_t)s->stride;
    int32_t up = 12 - s->plan->cfg.bits;
    uint16_t top = (uint16_t)((1u << s->plan->cfg.bits) - 1u);
    int32_t x;

    for (x = 0; x < s->nx; x++) {
        uint32_t v = in[x] < top ? in[x] : top;
        if (s->smooth) {
            uint32_t a = above[x] < top ? above[x] : top;
            uint32_t b = below[x] < top ? below[x] : top;
            out[s->pad + x] = (uint16_t)((((a + 2 * v + b) << up) + 2) >> 2);
        } else {
            out[s->pad + x] = (uint16_t)(v << up);
        }
    }
    if (s->smooth) {
        smooth_row(out + s->pad, s->nx);
    }
    for (x = 0; x < s->pad; x++) {
        out[x] = out[s->pad];
    }
    for (x = s->pad + s->nx; x < s->stride; x++) {
        out[x] = out[s->pad + s->nx - 1];
    }
}

void plfx_frame_load(const plfx_frame_state *s, const plfx_views *views)
{
    int32_t k;
    int32_t y;

    for (y = 0; y < s->ny; y++) {
        for (k = 0; k < s->n; k++) {
            load_row(s, views, k, y);
        }
    }
    memset(s->sample + (size_t)s->ny * (size_t)s->n * (size_t)s->stride, 0,
           PLFX_WINNER_CHUNK * sizeof *s->sample);
}

static void swap_maps(plfx_frame_state *s)
{
    int32_t *t = s->e_a;

    s->e_a = s->e_b;
    s->e_b = t;
}

static void refine(plfx_frame_state *s)
{
    int32_t i;

    if (s->cfg.median1) {
        plfx_median(s, s->cfg.median1, s->e_a, s->e_b);
        swap_maps(s);
    }
    for (i = 0; s->cfg.taps && i < s->cfg.passes; i++) {
        plfx_refine(s, s->e_a, s->e_b, i + 1 == s->cfg.passes);
        swap_maps(s);
    }
    if (s->cfg.median2) {
        plfx_median(s, s->cfg.median2, s->e_a, s->e_b);
        swap_maps(s);
    }
    if (s->cfg.taps) {
        plfx_sigma_map(s, s->e_a);
    }
}

static void write_row(const plfx_frame_state *s, const plfx_map *out, int32_t y)
{
    size_t to = (size_t)y * (size_t)out->stride;
    size_t from = (size_t)y * (size_t)s->nx;
    int32_t x;

    for (x = 0; x < s->nx; x++, to++, from++) {
        out->slope_q16[to] = plfx_frame_slope_of(s, s->e_a[from]);
        if (out->conf_u16) {
            out->conf_u16[to] = s->conf[from];
        }
        if (out->sigma_u20) {
            out->sigma_u20[to] = s->cfg.taps ? s->sigma[from] : PLFX_SIGMA_NONE;
        }
        if (out->flags) {
            out->flags[to] = s->flags[from];
        }
    }
}

static void flag_row(const plfx_frame_state *s, const plfx_views *views, int32_t y)
{
    size_t at = (size_t)y * (size_t)s->nx;
    plfx_frame_out row;

    row.raw = raw_row(views, s->plan->cfg.ref, y);
    row.top = (1u << s->plan->cfg.bits) - 1u;
    row.e = s->e_a + at;
    row.conf = s->conf + at;
    row.flags = s->flags + at;
    plfx_frame_flags(s, &row, y);
    if (s->cfg.axes) {
        plfx_frame_axes(s, s->axis_label[0] + at, s->axis_label[1] + at, row.flags);
    }
}

static int32_t views_fit(const plfx_plan *p, const plfx_views *v, const plfx_map *out)
{
    return v && v->px && out && out->slope_q16 && v->nx == p->nx && v->ny == p->ny &&
           v->n == p->cfg.n && out->w == p->nx && out->h == p->ny &&
           out->stride >= p->nx;
}

plfx_status plfx_frame(const plfx_plan *plan, const plfx_frame_cfg *cfg,
                       const plfx_views *views, const uint8_t *skip,
                       const plfx_map *out, void *ws, size_t ws_size)
{
    plfx_frame_state s;
    plfx_status status = plfx_frame_derive(&s, plan, cfg, skip);
    int32_t y;

    if (status != PLFX_OK) {
        return status;
    }
    if (!views_fit(plan, views, out)) {
        return PLFX_E_ARG;
    }
    if (!ws || !plfx_aligned(ws) || ws_size < plfx_frame_carve(&s, NULL)) {
        return PLFX_E_SIZE;
    }
    (void)plfx_frame_carve(&s, ws);
    plfx_frame_tables(&s, skip);
    plfx_frame_load(&s, views);
    plfx_arms_volume(&s);
    plfx_sgm(&s);
    refine(&s);
    for (y = 0; y < s.ny; y++) {
        if (out->flags) {
            flag_row(&s, views, y);
        }
        write_row(&s, out, y);
    }
    return PLFX_OK;
}
