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

/* floor(sqrt(v)), v < 2^52.  As plfx_isqrt_u64(), by masks: which bits fit cannot be
 * guessed, and a branch missed costs more than a step. */
static inline uint32_t plfx_gradient_root(uint64_t v)
{
    uint64_t bit = (uint64_t)1 << 50;
    uint64_t root = 0;
    int32_t i;

    for (i = 0; i < 26; i++) { /* 26 steps: one bit of the root each */
        uint64_t trial = root + bit;
        uint64_t fits = v >= trial ? ~(uint64_t)0 : 0u;
        root = (root >> 1) + (bit & fits);
        v -= trial & fits;
        bit >>= 2;
    }
    return (uint32_t)root;
}

/* e/(e + t): e the smaller eigenvalue of the structure tensor of n samples,
 * counts^2 a sample, t the square of 1/64 of full scale. */
static inline uint32_t plfx_gradient_conf_u16(plfx_products w, int64_t n, int32_t bits)
{
    /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): n is a window's area */
    int64_t xx = w.xx / n; /* q8, under 2^30 */
    int64_t yy = w.yy / n;
    int64_t xy = w.xy / n;
    int64_t d = plfx_asr_i64(xx - yy, 6);
    int64_t c = plfx_asr_i64(xy, 5);
    int64_t root = (int64_t)plfx_gradient_root((uint64_t)(d * d + c * c)) * 64;
    int64_t least = plfx_asr_i64(xx + yy - root, 9);
    uint64_t e = least > 0 ? (uint64_t)least : 0u;

    return (uint32_t)(e * 65535u / (e + ((uint64_t)1 << (2 * (bits - 6)))));
}

#endif
