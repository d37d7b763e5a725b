/* SPDX-License-Identifier: MIT
 * Portable row kernels: plain loops over PLFX_LANES lanes that compilers turn into
 * vector code.  A difference is written max - min (no widening); a fraction of a
 * difference as a Q15 product with one rounding (one instruction on most vector
 * units); a choice as a mask.  Loops over lanes must not be peeled away before they
 * are vectorised. */
#include "lanes.h"
#include "fix.h"

#include <string.h>

/* a + (b - a)*f/16 rounded half up; f_q15 = f*2^11. */
static inline int16_t mix(int16_t a, int16_t b, int16_t f_q15)
{
    int16_t d = (int16_t)(b - a);

    return (int16_t)(a + (int16_t)(plfx_asr_i32(plfx_asr_i32(d * f_q15, 14) + 1, 1)));
}

void plfx_k_pads(int16_t *row, int32_t blocks, int32_t left, int32_t right,
                 int16_t first, int16_t last)
{
    int32_t t;

    for (t = 0; t < right; t++) { /* the block one segment on: lanes move down by one */
        int16_t *to = row + (blocks + t) * PLFX_LANES;
        memcpy(to, row + t * PLFX_LANES + 1, (PLFX_LANES - 1) * sizeof(int16_t));
        to[PLFX_LANES - 1] = last;
    }
    for (t = 1; t <= left; t++) {
        int16_t *to = row - t * PLFX_LANES;
        memcpy(to + 1, row + (blocks - t) * PLFX_LANES,
               (PLFX_LANES - 1) * sizeof(int16_t));
        to[0] = first;
    }
}

static inline void cost_set(uint16_t *restrict item, const int16_t *restrict c,
                            const int16_t *restrict v, int16_t f)
{
    int32_t i;

    LANES(i)
    {
        item[i] = (uint16_t)plfx_apart(c[i], mix(v[i], v[i + PLFX_LANES], f));
    }
}

static inline void cost_add(uint16_t *restrict item, const int16_t *restrict c,
                            const int16_t *restrict v, int16_t f)
{
    int32_t i;

    LANES(i)
    {
        item[i] =
            (uint16_t)(item[i] + plfx_apart(c[i], mix(v[i], v[i + PLFX_LANES], f)));
    }
}

void plfx_k_cost(uint16_t *restrict item, const int16_t *restrict c,
                 const int16_t *restrict base, const plfx_tap *restrict tap,
                 int32_t labels, int32_t first)
{
    int32_t l;

    if (first) {
        for (l = 0; l < labels; l++) {
            cost_set(item + l * PLFX_LANES, c, base + tap[l].off, tap[l].f_q15);
        }
    } else {
        for (l = 0; l < labels; l++) {
            cost_add(item + l * PLFX_LANES, c, base + tap[l].off, tap[l].f_q15);
        }
    }
}

/* Weighted rows in 16 + 4 bits: V <= 4095. */
static inline void cost_rows(uint16_t *restrict item, const int16_t *restrict c,
                             const int16_t *restrict p, const int16_t *restrict q,
                             const plfx_tap *a, const plfx_tap *b)
{
    uint16_t fa = (uint16_t)(a->f_q15 >> 11);
    uint16_t fb = (uint16_t)(b->f_q15 >> 11);
    uint16_t ga = (uint16_t)(16 - fa);
    uint16_t gb = (uint16_t)(16 - fb);
    uint32_t wa = a->w_q4;
    uint32_t wb = b->w_q4;
    int32_t i;

    LANES(i)
    {
        uint16_t u = (uint16_t)((uint16_t)p[i] * ga + (uint16_t)p[i + PLFX_LANES] * fa);
        uint16_t v = (uint16_t)((uint16_t)q[i] * gb + (uint16_t)q[i + PLFX_LANES] * fb);
        int16_t s = (int16_t)((u * wa + v * wb + 128u) >> 8);
        item[i] = (uint16_t)(item[i] + plfx_apart(c[i], s));
    }
}

void plfx_k_cost_2d(uint16_t *restrict item, const int16_t *restrict c,
                    const int16_t *restrict base, const plfx_tap *restrict upper,
                    const plfx_tap *restrict lower, int32_t labels, int32_t first)
{
    int32_t l;

    if (first) {
        memset(item, 0, (size_t)labels * PLFX_LANES * sizeof(uint16_t));
    }
    for (l = 0; l < labels; l++) {
        if (lower[l].w_q4 == 0) {
            cost_add(item + l * PLFX_LANES, c, base + upper[l].off, upper[l].f_q15);
        } else {
            cost_rows(item + l * PLFX_LANES, c, base + upper[l].off,
                      base + lower[l].off, upper + l, lower + l);
        }
    }
}

void plfx_k_scale(uint16_t *item, int32_t n, int32_t shift)
{
    int32_t q;

    for (q = 0; q < n; q++) {
        item[q] = (uint16_t)(item[q] >> shift);
    }
}

#if !defined(PLFX_KERNELS_DSP)
static void update_exact(const plfx_update_block *b, uint16_t *restrict col,
                         int16_t *restrict sum, const uint16_t *restrict leave)
{
    const uint16_t *restrict item = b->item;
    const uint16_t *restrict gone = b->gone;
    int16_t low[PLFX_LANES];
    int32_t l;
    int32_t i;

    plfx_lead_start(b->lead, low);
    for (l = 0; l < b->labels; l++) {
        LANES(i)
        {
            uint16_t c = (uint16_t)(col[i] + item[i] - gone[i]);
            int16_t s = (int16_t)(sum[i] + c - leave[i]);
            col[i] = c;
            sum[i] = s;
            plfx_lead_meet(b->lead, low, i, s, l);
        }
        col += PLFX_LANES;
        sum += PLFX_LANES;
        leave += PLFX_LANES;
        item += PLFX_LANES;
        gone += PLFX_LANES;
    }
    plfx_lead_end(b->lead, low, b->sum);
}

static void update_scaled(const plfx_update_block *b, uint16_t *restrict col,
                          int16_t *restrict sum, const uint16_t *restrict leave)
{
    const uint16_t *restrict item = b->item;
    const uint16_t *restrict gone = b->gone;
    uint16_t m[PLFX_LANES];
    int16_t low[PLFX_LANES];
    int32_t l;
    int32_t i;

    plfx_factor_of(m, b->s2);
    plfx_lead_start(b->lead, low);
    for (l = 0; l < b->labels; l++) {
        LANES(i)
        {
            uint16_t c = (uint16_t)(col[i] + item[i] - gone[i]);
            int16_t s =
                (int16_t)(sum[i] + plfx_scaled(c, m[i]) - plfx_scaled(leave[i], m[i]));
            col[i] = c;
            sum[i] = s;
            plfx_lead_meet(b->lead, low, i, s, l);
        }
        col += PLFX_LANES;
        sum += PLFX_LANES;
        leave += PLFX_LANES;
        item += PLFX_LANES;
        gone += PLFX_LANES;
    }
    plfx_lead_end(b->lead, low, b->sum);
}

void plfx_k_update(const plfx_update_block *b)
{
    if (b->s2 == 0) {
        update_exact(b, b->col, b->sum, b->leave);
    } else {
        update_scaled(b, b->col, b->sum, b->leave);
    }
}

/* m: factors of the scale, NULL where sums are exact. */
static inline void slide_label(int16_t *restrict sum, const uint16_t *restrict enter,
                               const uint16_t *restrict leave,
                               const uint16_t *restrict m, plfx_lead *lead,
                               int16_t *restrict low, int32_t l)
{
    int32_t i;

    LANES(i)
    {
        int16_t s = (int16_t)(m ? sum[i] + plfx_scaled(enter[i], m[i]) -
                                      plfx_scaled(leave[i], m[i])
                                : sum[i] + enter[i] - leave[i]);
        sum[i] = s;
        plfx_lead_meet(lead, low, i, s, l);
    }
}

/* Two labels a turn. */
static inline void slide(int16_t *restrict sum, const uint16_t *restrict enter,
                         const uint16_t *restrict leave, int32_t labels,
                         const uint16_t *restrict m, plfx_lead *lead)
{
    const int16_t *some = sum;
    int16_t low[PLFX_LANES];
    int32_t l;

    plfx_lead_start(lead, low);
    for (l = 0; l + 1 < labels; l += 2) {
        slide_label(sum, enter, leave, m, lead, low, l);
        slide_label(sum + PLFX_LANES, enter + PLFX_LANES, leave + PLFX_LANES, m, lead,
                    low, l + 1);
        sum += 2 * PLFX_LANES;
        enter += 2 * PLFX_LANES;
        leave += 2 * PLFX_LANES;
    }
    if (l < labels) {
        slide_label(sum, enter, leave, m, lead, low, l);
    }
    plfx_lead_end(lead, low, some);
}

static void slide_exact(int16_t *sum, const uint16_t *enter, const uint16_t *leave,
                        int32_t labels, plfx_lead *lead)
{
    slide(sum, enter, leave, labels, NULL, lead);
}

static void slide_scaled(int16_t *sum, const uint16_t *enter, const uint16_t *leave,
                         int32_t labels, int32_t s2, plfx_lead *lead)
{
    uint16_t m[PLFX_LANES];

    plfx_factor_of(m, s2);
    slide(sum, enter, leave, labels, m, lead);
}

void plfx_k_slide(int16_t *sum, const uint16_t *enter, const uint16_t *leave,
                  int32_t labels, int32_t s2, plfx_lead *lead)
{
    if (s2 == 0) {
        slide_exact(sum, enter, leave, labels, lead);
    } else {
        slide_scaled(sum, enter, leave, labels, s2, lead);
    }
}

#endif
