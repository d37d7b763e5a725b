/* SPDX-License-Identifier: MIT
 * Derivatives of rows and their products.  Sums stay in 32 bits: the factor of the
 * derivative, 109, is taken last, and its product of 36 bits is rounded in two
 * parts. */
#include "gradient_rows.h"
#include "fix.h"

/* A smoothed difference has 29 bits and its sign, a window of products 45. */
PLFX_STATIC_ASSERT(((1u << PLFX_BITS_MAX) - 1u) * 65536u < 1u << 28, a_slant_fits);
PLFX_STATIC_ASSERT(PLFX_WINDOW_MAX *PLFX_WINDOW_MAX < 1 << 15, a_window_fits);

static uint32_t smooth(uint32_t before, uint32_t at, uint32_t after)
{
    return PLFX_P_SIDE * (before + after) + PLFX_P_MID * at;
}

/* Of one lens, what the three rows give before neighbours along the row are looked at.
 * x: smoothed along y and u, 28 bits.  u: difference along u, smoothed along y, 21 bits
 * and sign; differences wrap below zero and come back when read as signed. */
static void along_u(const plfx_strips *in, int32_t nx, uint32_t *restrict x,
                    uint32_t *restrict u)
{
    const uint16_t *const *c = in->px[PLFX_G_CENTRE];
    const uint16_t *const *l = in->px[PLFX_G_LEFT];
    const uint16_t *const *r = in->px[PLFX_G_RIGHT];
    const uint16_t *restrict c0 = c[0];
    const uint16_t *restrict c1 = c[1];
    const uint16_t *restrict c2 = c[2];
    const uint16_t *restrict l0 = l[0];
    const uint16_t *restrict l1 = l[1];
    const uint16_t *restrict l2 = l[2];
    const uint16_t *restrict r0 = r[0];
    const uint16_t *restrict r1 = r[1];
    const uint16_t *restrict r2 = r[2];
    int32_t i;

    for (i = 0; i < nx; i++) {
        uint32_t before = smooth(l0[i], c0[i], r0[i]);
        uint32_t at = smooth(l1[i], c1[i], r1[i]);
        uint32_t after = smooth(l2[i], c2[i], r2[i]);
        x[i] = smooth(before, at, after);
        u[i] = smooth((uint32_t)r0[i] - l0[i], (uint32_t)r1[i] - l1[i],
                      (uint32_t)r2[i] - l2[i]);
    }
}

/* y: difference along y, smoothed along v; v: along v, smoothed along y; 21 bits and
 * sign each. */
static void along_v(const plfx_strips *in, int32_t nx, uint32_t *restrict y,
                    uint32_t *restrict v)
{
    const uint16_t *const *c = in->px[PLFX_G_CENTRE];
    const uint16_t *const *t = in->px[PLFX_G_UP];
    const uint16_t *const *b = in->px[PLFX_G_DOWN];
    const uint16_t *restrict c0 = c[0];
    const uint16_t *restrict c2 = c[2];
    const uint16_t *restrict t0 = t[0];
    const uint16_t *restrict t1 = t[1];
    const uint16_t *restrict t2 = t[2];
    const uint16_t *restrict b0 = b[0];
    const uint16_t *restrict b1 = b[1];
    const uint16_t *restrict b2 = b[2];
    int32_t i;

    for (i = 0; i < nx; i++) {
        y[i] = smooth(t2[i], c2[i], b2[i]) - smooth(t0[i], c0[i], b0[i]);
        v[i] = smooth((uint32_t)b0[i] - t0[i], (uint32_t)b1[i] - t1[i],
                      (uint32_t)b2[i] - t2[i]);
    }
}

/* floor(109 t / 2^20 + 1/2) of a t of 29 bits and sign, read from its low 32 bits. */
static int16_t slant_q4(uint32_t t)
{
    int32_t high = plfx_asr_i32((int32_t)t, 12);
    uint32_t low = (PLFX_D_SIDE * (t & 4095u) + (1u << 19)) >> 12;

    return (int16_t)plfx_asr_i32(PLFX_D_SIDE * high + (int32_t)low, 8);
}

/* Difference along the row. */
static void differences(const uint32_t *restrict a, int32_t nx, int16_t *restrict out)
{
    int32_t i;

    for (i = 1; i < nx - 1; i++) {
        out[i] = slant_q4(a[i + 1] - a[i - 1]);
    }
}

static void smoothed(const uint32_t *restrict a, int32_t nx, int16_t *restrict out)
{
    int32_t i;

    for (i = 1; i < nx - 1; i++) {
        out[i] = slant_q4(smooth(a[i - 1], a[i], a[i + 1]));
    }
}

void plfx_gradient_slants(const plfx_strips *in, int32_t nx, uint32_t *spare,
                          const plfx_slants *out)
{
    uint32_t *other = spare + nx;

    along_u(in, nx, spare, other);
    differences(spare, nx, out->ix);
    smoothed(other, nx, out->iu);
    along_v(in, nx, spare, other);
    smoothed(spare, nx, out->iy);
    smoothed(other, nx, out->iv);
}

/* Change of one product: |a b - c d| < 2^31. */
static int32_t change(int16_t a, int16_t b, int16_t c, int16_t d)
{
    return (int32_t)a * b - (int32_t)c * d;
}

static void add(int64_t *restrict sum, const int16_t *restrict a,
                const int16_t *restrict b, const int16_t *restrict c,
                const int16_t *restrict d, int32_t nx, int32_t weight_q12)
{
    int32_t i;

    for (i = 1; i < nx - 1; i++) {
        sum[i] += (int64_t)change(a[i], b[i], c[i], d[i]) * weight_q12;
    }
}

static void square(int64_t *restrict sum, const int16_t *restrict a,
                   const int16_t *restrict c, int32_t nx)
{
    int32_t i;

    for (i = 1; i < nx - 1; i++) {
        sum[i] += change(a[i], a[i], c[i], c[i]);
    }
}

void plfx_gradient_columns(const plfx_slant_sums *sum, const plfx_slants *in,
                           const plfx_slants *out, int32_t nx, int32_t col_q12,
                           int32_t row_q12)
{
    add(sum->num, in->ix, in->iu, out->ix, out->iu, nx, col_q12);
    add(sum->num, in->iy, in->iv, out->iy, out->iv, nx, row_q12);
    add(sum->xy, in->ix, in->iy, out->ix, out->iy, nx, 1);
    square(sum->xx, in->ix, out->ix, nx);
    square(sum->yy, in->iy, out->iy, nx);
}
