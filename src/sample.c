/* SPDX-License-Identifier: MIT */
#include "rows.h"
#include "fix.h"

typedef struct tap_row { /* one source row and where it is entered */
    const uint16_t *px;
    int32_t k;           /* column offset */
    uint32_t f_q4, w_q4; /* fraction along the row, weight of the row */
} tap_row;

static tap_row tap(const plfx_plan *plan, const plfx_ring *views, int32_t view,
                   int32_t x_q4, int32_t j, int32_t row, uint32_t w_q4)
{
    tap_row t;
    int32_t r = plfx_clamp_i32(row, 0, views->ny - 1);
    int32_t x = x_q4;

    if (plan->hex) {
        x += plan->odd_q4 * ((j & 1) - (r & 1));
    }
    t.px = plfx_ring_row(views, r, view);
    t.k = plfx_asr_i32(x, 4);
    t.f_q4 = (uint32_t)(x - 16 * t.k);
    t.w_q4 = w_q4;
    return t;
}

/* One tap row at lens x, clamped: at most 12 + 4 bits. */
static uint32_t along(const tap_row *t, int32_t x, int32_t last)
{
    uint32_t p = t->px[plfx_clamp_i32(x + t->k, 0, last)];
    uint32_t q = t->px[plfx_clamp_i32(x + t->k + 1, 0, last)];

    return p * (16u - t->f_q4) + q * t->f_q4;
}

static uint16_t clamped(const tap_row *a, const tap_row *b, int32_t x, int32_t last)
{
    return (
        uint16_t)((along(a, x, last) * a->w_q4 + along(b, x, last) * b->w_q4 + 128u) >>
                  8);
}

/* Lenses first .. end-1 of the row, none of whose taps needs clamping. */
static void inner(const tap_row *a, const tap_row *b, int32_t first, int32_t end,
                  uint16_t *restrict out)
{
    const uint16_t *restrict p = a->px + first + a->k;
    const uint16_t *restrict q = b->px + first + b->k;
    uint32_t fa = a->f_q4;
    uint32_t fb = b->f_q4;
    uint32_t wa = a->w_q4;
    uint32_t wb = b->w_q4;
    int32_t n = end - first;
    int32_t i;

    for (i = 0; i < n; i++) {
        uint32_t u = p[i] * (16u - fa) + p[i + 1] * fa;
        uint32_t v = q[i] * (16u - fb) + q[i + 1] * fb;
        out[i] = (uint16_t)((u * wa + v * wb + 128u) >> 8);
    }
}

/* The same along one row only. */
static void inner_row(const tap_row *a, int32_t first, int32_t end,
                      uint16_t *restrict out)
{
    const uint16_t *restrict p = a->px + first + a->k;
    uint32_t f = a->f_q4;
    int32_t n = end - first;
    int32_t i;

    for (i = 0; i < n; i++) {
        out[i] = (uint16_t)((p[i] * (16u - f) + p[i + 1] * f + 8u) >> 4);
    }
}

void plfx_sample_row(const plfx_plan *plan, const plfx_ring *views, int32_t k,
                     plfx_shift s, int32_t j, int32_t x0, int32_t n, uint16_t *out)
{
    int32_t x_q4 = 16 * s.kx + s.fx_q4;
    tap_row a = tap(plan, views, k, x_q4, j, j + s.ky, 16u - (uint32_t)s.fy_q4);
    tap_row b = tap(plan, views, k, x_q4, j, j + s.ky + 1, (uint32_t)s.fy_q4);
    int32_t last = views->nx - 1;
    int32_t lo = plfx_max_i32(-a.k, s.fy_q4 ? -b.k : -a.k);
    int32_t hi = last - plfx_max_i32(a.k, s.fy_q4 ? b.k : a.k);
    int32_t first = plfx_clamp_i32(lo, x0, x0 + n);
    int32_t end = plfx_clamp_i32(hi, first, x0 + n);
    int32_t x;

    for (x = x0; x < first; x++) {
        out[x - x0] = clamped(&a, &b, x, last);
    }
    if (s.fy_q4) {
        inner(&a, &b, first, end, out + (first - x0));
    } else {
        inner_row(&a, first, end, out + (first - x0));
    }
    for (x = end; x < x0 + n; x++) {
        out[x - x0] = clamped(&a, &b, x, last);
    }
}

plfx_span plfx_span_of(const plfx_plan *plan, plfx_shift s, int32_t r)
{
    int32_t other_row = s.ky != 0 || s.fy_q4 != 0;
    int32_t odd = plan->hex && other_row ? plan->odd_q4 : 0;
    int32_t x_q4 = 16 * s.kx + s.fx_q4;
    int32_t lo = plfx_asr_i32(x_q4 - plfx_max_i32(odd, -odd), 4);
    int32_t hi = -plfx_asr_i32(-(x_q4 + plfx_max_i32(odd, -odd)), 4);
    plfx_span span;

    span.x0 = (int16_t)(r - plfx_min_i32(lo, 0));
    span.x1 = (int16_t)(plan->nx - 1 - r - plfx_max_i32(hi, 0));
    span.y0 = (int16_t)(r - plfx_min_i32(s.ky, 0));
    span.y1 = (int16_t)(plan->ny - 1 - r - plfx_max_i32(s.ky + (s.fy_q4 > 0), 0));
    return span;
}
