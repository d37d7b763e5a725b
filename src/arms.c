/* SPDX-License-Identifier: MIT
 * Cost volume: arms of views.  The loops over a row are plain 16-bit lane arithmetic.
 */
#include <string.h>

#include "arms_rows.h"
#include "arena.h"
#include "fix.h"

typedef struct scratch {
    uint16_t *warp;    /* [n][2][nx]: rows after the horizontal step, by parity */
    int16_t *diff;     /* [n][3][nx + 2] */
    int16_t *arm_sum;  /* [arms][nx] */
    int16_t *arm_row;  /* [arms][window][nx + 2r] */
    int16_t *column;   /* [nx + 2r] */
    int16_t *least;    /* [PLFX_ARMS_LEVELS][nx] */
    int16_t *axis[2];  /* [nx] lesser of the two arms along u, along v */
    uint8_t *cost;     /* [3][nx + 2] */
    plfx_shift *shift; /* [n] */
} scratch;

static size_t carve(const plfx_frame_state *s, scratch *t, void *base)
{
    plfx_arena a = {base, 0};
    size_t nx = (size_t)s->nx;
    size_t w = s->plan->cfg.window;
    size_t n = (size_t)s->n;

    t->warp = plfx_take(&a, n * 2 * nx, sizeof *t->warp);
    t->diff = plfx_take(&a, n * 3 * (nx + 2), sizeof *t->diff);
    t->arm_sum = plfx_take(&a, PLFX_ARMS_MAX * nx, sizeof *t->arm_sum);
    t->arm_row = plfx_take(&a, PLFX_ARMS_MAX * w * (nx + w - 1), sizeof *t->arm_row);
    t->column = plfx_take(&a, nx + w - 1, sizeof *t->column);
    t->least = plfx_take(&a, PLFX_ARMS_LEVELS * nx, sizeof *t->least);
    t->axis[0] = plfx_take(&a, nx, sizeof *t->axis[0]);
    t->axis[1] = plfx_take(&a, nx, sizeof *t->axis[1]);
    t->cost = plfx_take(&a, 3 * (nx + 2), sizeof *t->cost);
    t->shift = plfx_take(&a, n, sizeof *t->shift);
    return a.used;
}

size_t plfx_arms_scratch(const plfx_frame_state *s)
{
    scratch t;

    return carve(s, &t, NULL);
}

/* out = (a*(16-f) + b*f + 8) >> 4: under 2^16. */
static void blend(const uint16_t *restrict a, const uint16_t *restrict b, int32_t f,
                  int32_t n, uint16_t *restrict out)
{
    uint16_t w1 = (uint16_t)f;
    uint16_t w0 = (uint16_t)(16 - f);
    int32_t i;

    for (i = 0; i < n; i++) {
        uint16_t v = (uint16_t)(a[i] * w0 + b[i] * w1 + 8);
        out[i] = (uint16_t)(v >> 4);
    }
}

/* d = view - reference. */
static void subtract(const uint16_t *restrict v, const uint16_t *restrict ref,
                     int32_t n, int16_t *restrict d)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        d[i] = (int16_t)(v[i] - ref[i]);
    }
}

/* The same with the vertical step in it. */
static void blend_subtract(const uint16_t *restrict a, const uint16_t *restrict b,
                           int32_t f, const uint16_t *restrict ref, int32_t n,
                           int16_t *restrict d)
{
    uint16_t w1 = (uint16_t)f;
    uint16_t w0 = (uint16_t)(16 - f);
    int32_t i;

    for (i = 0; i < n; i++) {
        uint16_t v = (uint16_t)(a[i] * w0 + b[i] * w1 + 8);
        d[i] = (int16_t)((uint16_t)(v >> 4) - ref[i]);
    }
}

/* Where a row is read: from a sample on, f sixteenths of the next one. */
typedef struct place {
    const uint16_t *row;
    int32_t f;
} place;

/* Source row r of view k, displaced for target row y. */
static place place_of(const plfx_frame_state *s, int32_t k, const plfx_shift *shift,
                      int32_t y, int32_t r)
{
    int32_t from = plfx_clamp_i32(r, 0, s->ny - 1);
    const uint16_t *row = plfx_frame_line(s, k, from);
    int32_t q4 = 16 * shift->kx + shift->fx_q4;
    place p;

    if (s->plan->hex) {
        q4 += ((y & 1) - (from & 1)) * s->plan->odd_q4;
    }
    p.f = q4 & 15;
    p.row = row + plfx_asr_i32(q4 - p.f, 4);
    return p;
}

/* A pointer into the samples, or into `buffer` after blending (which `fresh` may
 * spare). */
static const uint16_t *blended(const plfx_frame_state *s, place p, int32_t fresh,
                               uint16_t *buffer)
{
    if (p.f == 0) {
        return p.row;
    }
    if (fresh) {
        blend(p.row, p.row + 1, p.f, s->nx, buffer);
    }
    return buffer;
}

static const uint16_t *source_row(const plfx_frame_state *s, int32_t k,
                                  const plfx_shift *shift, int32_t y, int32_t r,
                                  int32_t fresh, uint16_t *buffer)
{
    return blended(s, place_of(s, k, shift, y, r), fresh, buffer);
}

/* sum += min(|blend of a and b - ref|, T). */
static void cost_flat(const uint16_t *restrict a, const uint16_t *restrict b, int32_t f,
                      const uint16_t *restrict ref, uint16_t limit, int32_t n,
                      int16_t *restrict sum)
{
    uint16_t w1 = (uint16_t)f;
    uint16_t w0 = (uint16_t)(16 - f);
    int16_t trunc = (int16_t)limit;
    int32_t i;

    for (i = 0; i < n; i++) {
        uint16_t v = (uint16_t)(a[i] * w0 + b[i] * w1 + 8);
        int16_t d = (int16_t)((uint16_t)(v >> 4) - ref[i]);
        int16_t m = (int16_t)-d;
        d = d > m ? d : m;
        d = d < trunc ? d : trunc;
        sum[i] = (int16_t)(sum[i] + d);
    }
}

void plfx_arms_flat(const plfx_frame_state *s, int32_t k, const plfx_shift *shift,
                    int32_t y, uint16_t *warp, int16_t *sum)
{
    const uint16_t *ref = plfx_frame_line(s, s->plan->cfg.ref, y);
    int32_t r = y + shift->ky;
    place p = place_of(s, k, shift, y, r);
    const uint16_t *a = p.row;
    const uint16_t *b = p.row + 1;
    int32_t f = p.f;

    if (shift->fy_q4 != 0) {
        f = shift->fy_q4;
        a = blended(s, p, 1, warp);
        b = blended(s, place_of(s, k, shift, y, r + 1), 1, warp + s->nx);
    }
    cost_flat(a, b, f, ref, s->cfg.trunc_q4, s->nx, sum);
}

void plfx_arms_diff(const plfx_frame_state *s, int32_t k, const plfx_shift *shift,
                    int32_t y, int32_t fresh, uint16_t *warp, int16_t *diff)
{
    const uint16_t *ref = plfx_frame_line(s, s->plan->cfg.ref, y);
    int32_t r = y + shift->ky;
    uint16_t *w0 = warp + (r & 1) * s->nx;
    uint16_t *w1 = warp + ((r + 1) & 1) * s->nx;
    int32_t first = fresh || s->plan->hex || shift->fy_q4 == 0;
    const uint16_t *a = source_row(s, k, shift, y, r, first, w0);

    if (shift->fy_q4 == 0) {
        subtract(a, ref, s->nx, diff + 1);
    } else {
        const uint16_t *b = source_row(s, k, shift, y, r + 1, 1, w1);
        blend_subtract(a, b, shift->fy_q4, ref, s->nx, diff + 1);
    }
    diff[0] = diff[1];
    diff[s->nx + 1] = diff[s->nx];
}

/* Row y of view k at the label under way. */
static void diff_row(const plfx_frame_state *s, const scratch *t, int32_t k, int32_t y,
                     int16_t *diff)
{
    plfx_arms_diff(s, k, t->shift + k, y, y == 0,
                   t->warp + (size_t)k * 2 * (size_t)s->nx, diff);
}

static int16_t *diff_at(const plfx_frame_state *s, const scratch *t, int32_t k,
                        int32_t y)
{
    int32_t r = plfx_clamp_i32(y, 0, s->ny - 1) % 3;

    return t->diff + ((size_t)k * 3 + (size_t)r) * ((size_t)s->nx + 2);
}

/* sum += min(|d|,T) + (min(|dx|,G) + min(|dy|,G)) * w/16.  |d| < 2^12, so every step
 * stays within 2^15; G*31*2/16 < 2^12. */
void plfx_arms_cost(const int16_t *restrict up, const int16_t *restrict mid,
                    const int16_t *restrict down, const plfx_frame_cfg *cfg, int32_t n,
                    int16_t *restrict sum)
{
    int16_t trunc = (int16_t)cfg->trunc_q4;
    int16_t gtrunc = (int16_t)cfg->gtrunc_q4;
    int16_t weight = (int16_t)cfg->gweight_q4;
    int32_t i;

    for (i = 0; i < n; i++) {
        int16_t d = mid[i + 1];
        int16_t x = (int16_t)(mid[i + 2] - mid[i]);
        int16_t y = (int16_t)(down[i + 1] - up[i + 1]);
        int16_t dn = (int16_t)-d;
        int16_t xn = (int16_t)-x;
        int16_t yn = (int16_t)-y;
        uint16_t g;
        d = d > dn ? d : dn;
        x = x > xn ? x : xn;
        y = y > yn ? y : yn;
        d = d < trunc ? d : trunc;
        x = x < gtrunc ? x : gtrunc;
        y = y < gtrunc ? y : gtrunc;
        g = (uint16_t)((uint16_t)(x + y) * weight);
        sum[i] = (int16_t)(sum[i] + d + (int16_t)(g >> 4));
    }
}

/* Mean of an arm scaled for the box: (sum*mul + half) >> shift, ends repeated r times.
 */
void plfx_arms_mean(const int16_t *restrict sum, uint16_t mul, int32_t shift, int32_t n,
                    int32_t r, int16_t *restrict out)
{
    uint32_t half = 1u << (shift - 1);
    int32_t i;

    for (i = 0; i < n; i++) {
        uint16_t v = (uint16_t)sum[i];
        out[r + i] = (int16_t)(((uint32_t)v * mul + half) >> shift);
    }
    for (i = 0; i < r; i++) {
        out[i] = out[r];
        out[r + n + i] = out[r + n - 1];
    }
}

static int16_t *arm_row_at(const plfx_frame_state *s, const scratch *t, int32_t arm,
                           int32_t y)
{
    int32_t w = s->plan->cfg.window;
    int32_t r = plfx_clamp_i32(y, 0, s->ny - 1) % w;

    return t->arm_row +
           ((size_t)arm * (size_t)w + (size_t)r) * ((size_t)s->nx + (size_t)w - 1);
}

/* Stage 1: costs of row y of every arm, from difference rows y-1 .. y+1. */
static void arm_rows(const plfx_frame_state *s, const scratch *t, int32_t y)
{
    int32_t k;
    int32_t a;

    memset(t->arm_sum, 0, PLFX_ARMS_MAX * (size_t)s->nx * sizeof *t->arm_sum);
    for (k = 0; k < s->n; k++) {
        if (s->arm_of[k] < 0) {
            continue;
        }
        if (y == 0) {
            diff_row(s, t, k, 0, diff_at(s, t, k, 0));
        }
        if (y + 1 < s->ny) {
            diff_row(s, t, k, y + 1, diff_at(s, t, k, y + 1));
        }
        plfx_arms_cost(diff_at(s, t, k, y - 1), diff_at(s, t, k, y),
                       diff_at(s, t, k, y + 1), &s->cfg, s->nx,
                       t->arm_sum + (size_t)s->arm_of[k] * (size_t)s->nx);
    }
    for (a = 0; a < s->cfg.arms; a++) {
        if (s->arm_n[a] > 0) {
            plfx_arms_mean(t->arm_sum + (size_t)a * (size_t)s->nx, s->arm_mul[a],
                           s->arm_shift[a], s->nx, s->plan->cfg.window / 2,
                           arm_row_at(s, t, a, y));
        }
    }
}

void plfx_arms_column(const int16_t *restrict sum, uint16_t mul, int32_t shift,
                      int32_t n, int32_t sign, int16_t *restrict col)
{
    uint32_t half = 1u << (shift - 1);
    int16_t whole = (int16_t)(sign * (1 << (14 - plfx_min_i32(shift, 14))));
    int32_t i;

    if (mul == 16384 && shift <= 14) { /* 2^k views: nothing is rounded */
        for (i = 0; i < n; i++) {
            col[i] = (int16_t)(col[i] + (int16_t)(sum[i] * whole));
        }
        return;
    }
    for (i = 0; i < n; i++) {
        uint16_t v = (uint16_t)sum[i];
        int32_t mean = (int32_t)(((uint32_t)v * mul + half) >> shift);
        col[i] = (int16_t)(col[i] + sign * mean);
    }
}

void plfx_arms_box(const int16_t *restrict in, int32_t window, int32_t n,
                   int16_t *restrict out)
{
    int32_t i;
    int32_t k;

    for (i = 0; i < n; i++) {
        out[i] = (int16_t)(in[i] + in[i + 1] + in[i + 2]);
    }
    for (k = 3; k < window; k += 2) {
        for (i = 0; i < n; i++) {
            out[i] = (int16_t)(out[i] + in[i + k] + in[i + k + 1]);
        }
    }
}

/* out = a + b + c. */
static void add_three(const int16_t *restrict a, const int16_t *restrict b,
                      const int16_t *restrict c, int32_t n, int16_t *restrict out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        out[i] = (int16_t)(a[i] + b[i] + c[i]);
    }
}

/* out += a + b. */
static void add_two(const int16_t *restrict a, const int16_t *restrict b, int32_t n,
                    int16_t *restrict out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        out[i] = (int16_t)(out[i] + a[i] + b[i]);
    }
}

/* Insert v into the ordered rows of least costs. */
void plfx_arms_keep(const int16_t *restrict v, int32_t n, int16_t *restrict least)
{
    int16_t *restrict m0 = least;
    int16_t *restrict m1 = least + n;
    int16_t *restrict m2 = least + 2 * n;
    int16_t *restrict m3 = least + 3 * n;
    int32_t i;

    for (i = 0; i < n; i++) {
        int16_t a = v[i];
        int16_t b = m0[i];
        int16_t c = m1[i];
        int16_t d = m2[i];
        int16_t e = m3[i];
        int16_t x = a > b ? a : b;
        int16_t y = x > c ? x : c;
        int16_t z = y > d ? y : d;
        m0[i] = a < b ? a : b;
        m1[i] = x < c ? x : c;
        m2[i] = y < d ? y : d;
        m3[i] = z < e ? z : e;
    }
}

void plfx_arms_lesser(const int16_t *restrict v, int32_t n, int16_t *restrict least)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        least[i] = v[i] < least[i] ? v[i] : least[i];
    }
}

/* Running least over the labels. */
void plfx_arms_follow(const int16_t *restrict v, int32_t label, int32_t n,
                      int16_t *restrict best, uint8_t *restrict at)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint8_t k = at[i];
        at[i] = v[i] < best[i] ? (uint8_t)label : k;
        best[i] = v[i] < best[i] ? v[i] : best[i];
    }
}

/* Axis of an arm, 0 u, 1 v, or -1: sectors are eighths or quarters of the circle. */
int32_t plfx_arms_axis(const plfx_frame_state *s, int32_t a)
{
    int32_t eighth = s->cfg.arms == 4 ? 2 * a : a;

    return eighth % 4 == 0 ? 0 : eighth % 4 == 2 ? 1 : -1;
}

/* Box of arm a around row y, and its place among the least. */
static void box_arm(const plfx_frame_state *s, const scratch *t, int32_t a, int32_t y)
{
    int32_t w = s->plan->cfg.window;
    int32_t wide = s->nx + w - 1;
    int16_t *box = t->arm_sum;
    int32_t i;

    add_three(arm_row_at(s, t, a, y - w / 2), arm_row_at(s, t, a, y - w / 2 + 1),
              arm_row_at(s, t, a, y - w / 2 + 2), wide, t->column);
    for (i = 3; i < w; i += 2) {
        add_two(arm_row_at(s, t, a, y - w / 2 + i),
                arm_row_at(s, t, a, y - w / 2 + i + 1), wide, t->column);
    }
    plfx_arms_box(t->column, w, s->nx, box);
    plfx_arms_keep(box, s->nx, t->least);
    if (s->cfg.axes && plfx_arms_axis(s, a) >= 0) {
        plfx_arms_lesser(box, s->nx, t->axis[plfx_arms_axis(s, a)]);
    }
}

/* 8-bit cost from the `keep` least: quarters first, so that the sum fits 15 bits. */
void plfx_arms_quantise(const int16_t *restrict least, int32_t n, int32_t keep,
                        uint16_t mul, uint8_t *restrict out)
{
    int16_t on1 = (int16_t)(keep > 1 ? -1 : 0);
    int16_t on2 = (int16_t)(keep > 2 ? -1 : 0);
    int16_t on3 = (int16_t)(keep > 3 ? -1 : 0);
    int32_t i;

    for (i = 0; i < n; i++) {
        uint16_t sum = (uint16_t)((least[i] >> 2) + ((least[i + n] >> 2) & on1) +
                                  ((least[i + 2 * n] >> 2) & on2) +
                                  ((least[i + 3 * n] >> 2) & on3));
        uint32_t v = ((uint32_t)sum * mul) >> 16;
        out[i] = (uint8_t)(v < 255u ? v : 255u);
    }
}

static uint8_t *cost_at(const plfx_frame_state *s, const scratch *t, int32_t y)
{
    int32_t r = plfx_clamp_i32(y, 0, s->ny - 1) % 3;

    return t->cost + (size_t)r * ((size_t)s->nx + 2);
}

static void follow_axes(const plfx_frame_state *s, const scratch *t, int32_t label,
                        int32_t y)
{
    size_t at = (size_t)y * (size_t)s->nx;
    int32_t k;

    for (k = 0; k < 2; k++) {
        if (label == 0) {
            memcpy(s->axis_best[k] + at, t->axis[k], (size_t)s->nx * sizeof(int16_t));
            memset(s->axis_label[k] + at, 0, (size_t)s->nx);
        } else {
            plfx_arms_follow(t->axis[k], label, s->nx, s->axis_best[k] + at,
                             s->axis_label[k] + at);
        }
    }
}

/* Stage 2: cost of row y, ends repeated. */
static void cost_row(const plfx_frame_state *s, const scratch *t, int32_t label,
                     int32_t y)
{
    uint8_t *out = cost_at(s, t, y);
    int32_t i;
    int32_t a;

    for (i = 0; i < PLFX_ARMS_LEVELS * s->nx; i++) {
        t->least[i] = INT16_MAX;
    }
    for (i = 0; i < s->nx; i++) {
        t->axis[0][i] = INT16_MAX;
        t->axis[1][i] = INT16_MAX;
    }
    for (a = 0; a < s->cfg.arms; a++) {
        if (s->arm_n[a] > 0) {
            box_arm(s, t, a, y);
        }
    }
    if (s->cfg.axes) {
        follow_axes(s, t, label, y);
    }
    plfx_arms_quantise(t->least, s->nx, s->keep, s->vol_mul, out + 1);
    out[0] = out[1];
    out[s->nx + 1] = out[s->nx];
}

void plfx_arms_least(const uint8_t *restrict a, const uint8_t *restrict b,
                     const uint8_t *restrict c, int32_t n, uint8_t *restrict out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint8_t m = b[i + 1];
        m = a[i] < m ? a[i] : m;
        m = a[i + 1] < m ? a[i + 1] : m;
        m = a[i + 2] < m ? a[i + 2] : m;
        m = b[i] < m ? b[i] : m;
        m = b[i + 2] < m ? b[i + 2] : m;
        m = c[i] < m ? c[i] : m;
        m = c[i + 1] < m ? c[i + 1] : m;
        m = c[i + 2] < m ? c[i + 2] : m;
        out[i] = m;
    }
}

/* Stage 3: row y of the volume at a label. */
static void volume_row(const plfx_frame_state *s, const scratch *t, int32_t label,
                       int32_t y)
{
    uint8_t *out =
        s->volume + ((size_t)y * (size_t)s->labels + (size_t)label) * (size_t)s->nx;

    if (s->cfg.shrink) {
        plfx_arms_least(cost_at(s, t, y - 1), cost_at(s, t, y), cost_at(s, t, y + 1),
                        s->nx, out);
    } else {
        memcpy(out, cost_at(s, t, y) + 1, (size_t)s->nx);
    }
}

static void one_label(const plfx_frame_state *s, const scratch *t, int32_t label)
{
    int32_t r = s->plan->cfg.window / 2;
    int32_t step;
    int32_t k;

    for (k = 0; k < s->n; k++) {
        t->shift[k] = plfx_plan_shift(s->plan, k, label);
    }
    for (step = 0; step < s->ny + r + 1; step++) {
        if (step < s->ny) {
            arm_rows(s, t, step);
        }
        if (step >= r && step - r < s->ny) {
            cost_row(s, t, label, step - r);
        }
        if (step >= r + 1) {
            volume_row(s, t, label, step - r - 1);
        }
    }
}

void plfx_arms_volume(const plfx_frame_state *s)
{
    scratch t;
    int32_t label;

    (void)carve(s, &t, s->scratch);
    for (label = 0; label < s->labels; label++) {
        one_label(s, &t, label);
    }
}
