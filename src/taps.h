/* SPDX-License-Identifier: MIT
 * The arithmetic of view.h, written once: means along a row and between two rows, then
 * black level, gain and tone.  All steps are 32-bit and lane-wise, so that a loop over
 * lenses becomes vector code; only the pixel loads are not. */
#ifndef PLENOFIX_SRC_TAPS_H
#define PLENOFIX_SRC_TAPS_H

#include "plenofix/view.h"
#include "kernels.h"
#include "fix.h"

#define PLFX_TAP_LANES 16 /* lenses gathered side by side, whatever the target */

/* Two neighbours, the left one low: compilers make one load of it. */
static inline uint32_t plfx_two(const uint16_t *px)
{
    return (uint32_t)px[0] | (uint32_t)px[1] << 16;
}

/* Mean of two pixels in 16 bits: f/256 of q, k = raw bits - 8 bits taken off, half =
 * 2^(k-1).  24 bits; the product wraps and comes back. */
static inline uint32_t plfx_between(uint32_t p, uint32_t q, uint32_t f, uint32_t half,
                                    int32_t k)
{
    return ((p << 8) + (q - p) * f + half) >> k;
}

/* The same of plfx_two(). */
static inline uint32_t plfx_along(uint32_t two, uint32_t f, uint32_t half, int32_t k)
{
    return plfx_between(two & 65535u, two >> 16, f, half, k);
}

/* Mean of two 16-bit means, f/256 of the lower one. */
static inline uint32_t plfx_across(uint32_t upper, uint32_t lower, uint32_t f)
{
    return ((upper << 8) + (lower - upper) * f + 128u) >> 8;
}

typedef struct plfx_curve { /* a tone and a sensor */
    uint32_t black, clipped, gain, top;
    int32_t down; /* 28 - bits - shift, 8 .. 28 */
} plfx_curve;

static inline plfx_curve plfx_curve_of(const plfx_tone *t, int32_t raw_bits)
{
    uint32_t full = ((1u << raw_bits) - 1u) << (16 - raw_bits);
    plfx_curve c;

    c.black = t->black_u16;
    c.clipped = full < t->sat_u16 ? full : t->sat_u16;
    c.gain = t->gain_q12;
    c.top = (1u << t->bits) - 1u;
    c.down = 28 - t->bits - t->shift;
    return c;
}

/* Light above the black level; every choice a minimum or maximum, no branch. */
static inline uint32_t plfx_lit(plfx_curve c, uint32_t v)
{
    return (v > c.black ? v : c.black) - c.black;
}

/* lit: 19 bits with white gain: times gain under 524273 * 8191 < 2^32.  The half is
 * added after one bit less was shifted out: the same rounding, no 33rd bit. */
static inline uint32_t plfx_curve_end(plfx_curve c, uint32_t v, uint32_t lit)
{
    uint32_t out = (((lit * c.gain) >> (c.down - 1)) + 1u) >> 1;

    out = out < c.top ? out : c.top;
    return v >= c.clipped ? c.top : out;
}

/* The view sample of a 16-bit mean. */
static inline uint32_t plfx_toned(plfx_curve c, uint32_t v)
{
    return plfx_curve_end(c, v, plfx_lit(c, v));
}

/* The same with white gain: 16 + 16 bits. */
static inline uint32_t plfx_toned_white(plfx_curve c, uint32_t v, uint32_t gain_u13)
{
    return plfx_curve_end(c, v, (plfx_lit(c, v) * gain_u13 + 4096u) >> 13);
}

/* Where LANES lenses are sampled along an axis: whole pixels and 1/256.  `shift` holds
 * the rounding half. */
static inline void plfx_places(const int32_t *restrict c_q16, int32_t shift_q16,
                               int32_t *restrict whole, uint32_t *restrict part)
{
    int32_t i;

    PLFX_LANE_LOOP(i, PLFX_TAP_LANES)
    {
        int32_t at_q8 = plfx_asr_i32(c_q16[i] + shift_q16, 8);
        whole[i] = plfx_asr_i32(at_q8, 8);
        part[i] = (uint32_t)at_q8 & 255u;
    }
}

/* Displacement of a view with the tone's and the rounding half. */
static inline plfx_point plfx_tap_shift(const plfx_lut *lut, const plfx_tone *tone,
                                        plfx_offset at)
{
    plfx_point s = plfx_view_offset(lut, at);

    s.x_q16 += 256 * tone->dx_q8 + 128;
    s.y_q16 += 256 * tone->dy_q8 + 128;
    return s;
}

#endif
