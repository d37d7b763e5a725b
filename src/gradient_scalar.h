/* SPDX-License-Identifier: MIT
 * Per-lens arithmetic of the least-squares gradient, in the common subset of C99 and
 * OpenCL C. */
#ifndef PLENOFIX_SRC_GRADIENT_SCALAR_H
#define PLENOFIX_SRC_GRADIENT_SCALAR_H

#include "fix.h"

/* Matched pair: sum of p = 256, d over two samples. */
#define PLFX_P_SIDE 59
#define PLFX_P_MID  138
#define PLFX_D_SIDE 109

typedef struct plfx_products { /* of one lens, or their sums over a window */
    int64_t xu, yv, xx, yy, xy;
} plfx_products;

/* Steps of slope, q16, of num/den steps: both are cut to 31 bits of den.
 * |num/den| of 2^12 and more is 2^12. */
static inline int64_t plfx_steps_q16(int64_t num, int64_t den)
{
    int32_t over = plfx_log2_u64((uint64_t)den) - 30;
    int64_t limit;
    int64_t q;

    if (over > 0) {
        num = plfx_asr_i64(num, over);
        den = plfx_asr_i64(den, over);
    }
    limit = den * 4096; /* |slope * du_q8| beyond 16 * 256: saturated below */
    q = num < 0 ? -num : num;
    q = q < limit ? q : limit;
    q = (q * 65536 + den / 2) / den;
    return num < 0 ? -q : q;
}

/* num/den as a slope: |slope| saturates at 8.  INT32_MIN where den is not over 0. */
static inline int32_t plfx_ratio_q16(int64_t num, int64_t den, int64_t du_q8)
{
    int64_t q;

    if (den <= 0) {
        return INT32_MIN;
    }
    q = plfx_steps_q16(num, den);
    if (du_q8 != 256) { /* a division saved where a step is a pixel */
        q = du_q8 < 0 ? -q : q;
        q = plfx_div_round_i64(q * 256, du_q8 < 0 ? -du_q8 : du_q8);
    }
    return plfx_clamp_i32(plfx_sat_i32(q), -(8 << 16), 8 << 16);
}

/* Least squares over both axes with the lattice's ratios in q12 (under 2^13):
 * window sums of products are under 2^45. */
static inline int32_t plfx_gradient_slope_q16(plfx_products w, int32_t col_q16,
                                              int32_t row_q16, int32_t du_q8)
{
    int64_t col = plfx_asr_i32(col_q16, 4);
    int64_t row = plfx_asr_i32(row_q16, 4);
    int64_t den =
        plfx_asr_i64(col * col, 12) * w.xx + plfx_asr_i64(row * row, 12) * w.yy;

    return plfx_ratio_q16(-(col * w.xu + row * w.yv), den, du_q8);
}

/* One Newton step towards 1/sqrt(x); x q16, 1 .. 4, y q15. */
static inline uint32_t plfx_gradient_nearer(uint32_t y, uint32_t x)
{
    return (y * (98304u - ((((y * y) >> 15) * x) >> 16))) >> 16;
}

/* floor(sqrt(v)), v < 2^52, v = x 2^(2e): 1/sqrt(x) by a parabola, 2.4 % off, and two
 * steps, 2^-14 off; then the root by a step of its own, and the last count by squares.
 * No bit waits for the one before: roots of neighbours run side by side. */
static inline uint32_t plfx_gradient_root(uint64_t v)
{
    uint64_t any = v | 1u; /* as near to v, and never 0 */
    int32_t e = plfx_asr_i32(plfx_log2_u64(any) - 16, 1); /* -8 .. 17 */
    int32_t down = e < 0 ? 0 : e;
    uint32_t x = (uint32_t)(any >> (2 * down)) << (2 * (down - e));
    uint32_t y = 43759u - ((((26914u - ((3356u * (x >> 2)) >> 14)) * (x >> 2)) >> 15));
    int64_t a = (int64_t)v;
    int32_t r;
    int32_t d;

    y = plfx_gradient_nearer(plfx_gradient_nearer(y, x), x);
    r = (int32_t)((uint32_t)(((uint64_t)x * y) >> 6) >> (17 - e));
    d = (int32_t)plfx_asr_i64(a - (int64_t)r * r, down); /* under 2^24 */
    r += (int32_t)plfx_asr_i64((int64_t)d * (int64_t)y, 24);
    r -= (int64_t)r * r > a ? 1 : 0;
    r += ((int64_t)r + 1) * ((int64_t)r + 1) <= a ? 1 : 0;
    return (uint32_t)r;
}

/* e/(e + t): e the smaller eigenvalue of the structure tensor of n samples, counts^2 a
 * sample, t the square of 1/64 of full scale.  Both are kept n/2^k times as large, n <
 * 2^k <= 2n, for nothing to be divided twice. */
static inline uint32_t plfx_gradient_conf_u16(plfx_products w, int64_t n, int32_t bits)
{
    int32_t k = plfx_log2_u64((uint64_t)n) + 1;
    int64_t xx = plfx_asr_i64(w.xx, k); /* q8, under 2^30 */
    int64_t yy = plfx_asr_i64(w.yy, k);
    int64_t d = plfx_asr_i64(xx - yy, 6);
    int64_t c = plfx_asr_i64(w.xy, k + 5);
    int64_t root = (int64_t)plfx_gradient_root((uint64_t)(d * d + c * c));
    int64_t least = plfx_asr_i64(xx + yy, 6) - root; /* twice e, q2 */
    uint64_t e = least > 0 ? (uint64_t)least : 0u;
    uint64_t t = (uint64_t)plfx_asr_i64(n << (2 * bits - 9), k);

    /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): t is 2^6 at least */
    return (uint32_t)(e * 65535u / (e + t));
}

#endif
