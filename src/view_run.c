/* SPDX-License-Identifier: MIT */
#include "view_run.h"

#if PLFX_LANES >= 8 && PLFX_KERNELS_C

#define LENSES PLFX_RUN_LENSES
#define VIEWS  PLFX_RUN_VIEWS

/* Means along VIEWS pairs of neighbours at px, 16 bits: view.h's h in 16-bit steps.
 * With g = f - 128, d = q - p under 2^12, k = bits - 8, up = 15 - bits:
 *   (p*256 + d*f + half) >> k = ((p + q) << up) + ((d*g + half) >> k)
 * and the last term is the rounded product of d << up and g << 8, both signed 16;
 * scale = 2^up, because a shift by a variable is done in wider lanes. */
static inline void along_run(const uint16_t *restrict px, const int16_t *restrict g,
                             uint16_t scale, uint16_t *restrict h)
{
    int32_t i;

    PLFX_LANE_LOOP(i, VIEWS)
    {
        uint16_t p = px[i];
        uint16_t q = px[i + 1];
        uint16_t sum = (uint16_t)(p + q);
        uint16_t less = (uint16_t)(q - p);
        int16_t d = (int16_t)(uint16_t)(less * scale);
        int16_t e = (int16_t)plfx_asr_i32(plfx_asr_i32(d * g[i], 14) + 1, 1);
        h[i] = (uint16_t)((uint16_t)(sum * scale) + (uint16_t)e);
    }
}

/* The lens at (x, y), px the pixel of its first view. */
static inline void sample_run(const plfx_view_run *r, int32_t x_q16, int32_t y_q16,
                              const uint16_t *restrict px, uint16_t *restrict out)
{
    const uint16_t *restrict sx = r->x_u16;
    const uint16_t *restrict sy = r->y_u16;
    uint16_t cx = (uint16_t)((uint32_t)x_q16 & 65535u);
    uint16_t cy = (uint16_t)((uint32_t)y_q16 & 65535u);
    uint16_t scale = (uint16_t)(128u >> r->down);
    plfx_curve curve = r->curve;
    int16_t g[VIEWS];
    uint16_t f[VIEWS];
    uint16_t upper[VIEWS];
    uint16_t lower[VIEWS];
    uint32_t v[VIEWS];
    int32_t i;

    PLFX_LANE_LOOP(i, VIEWS)
    {
        g[i] = (int16_t)(((uint16_t)(cx + sx[i]) & 0xff00u) ^ 0x8000u);
        f[i] = (uint16_t)((uint16_t)(cy + sy[i]) >> 8);
    }
    along_run(px, g, scale, upper);
    along_run(px + r->w, g, scale, lower);
    PLFX_LANE_LOOP(i, VIEWS)
    {
        v[i] = plfx_across(upper[i], lower[i], f[i]);
    }
    if (r->toned) {
        PLFX_LANE_LOOP(i, VIEWS)
        {
            v[i] = plfx_toned(curve, v[i]);
        }
    }
    PLFX_LANE_LOOP(i, VIEWS)
    {
        out[i] = (uint16_t)v[i];
    }
}

void plfx_view_tile(const plfx_view_run *r, uint16_t (*restrict tile)[VIEWS])
{
    const uint16_t *px = r->px;
    int32_t at[LENSES]; /* the first view's pixel */
    int32_t l;

    PLFX_LANE_LOOP(l, LENSES)
    {
        at[l] = plfx_asr_i32(r->y_q16[l] + r->first.y_q16, 16) * r->w +
                plfx_asr_i32(r->x_q16[l] + r->first.x_q16, 16);
    }
    for (l = 0; l < LENSES; l++) {
        sample_run(r, r->x_q16[l], r->y_q16[l], px + at[l], tile[l]);
    }
}

void plfx_view_turn(uint16_t (*restrict tile)[VIEWS], int32_t n, uint16_t *restrict to,
                    size_t step)
{
    int32_t i;
    int32_t l;

    for (i = 0; i < n; i++) {
        uint16_t *restrict row = to + (size_t)i * step;
        for (l = 0; l < LENSES; l++) {
            row[l] = tile[l][i];
        }
        PLFX_WILL_WRITE(row + PLFX_RUN_AHEAD);
    }
}

#endif
