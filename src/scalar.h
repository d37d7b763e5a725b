/* SPDX-License-Identifier: MIT
 * Per-pixel arithmetic of matching, in the common subset of C99 and OpenCL C: the same
 * text is compiled into the core and pasted before the OpenCL kernels. */
#ifndef PLENOFIX_SRC_SCALAR_H
#define PLENOFIX_SRC_SCALAR_H

#include "fix.h"

#if defined(__OPENCL_C_VERSION__)
#define PLFX_TABLE __constant
#else
#define PLFX_TABLE static const
#endif

/* v = m * 2^(2 exp), m in [2^28, 2^30): g = 2^29/sqrt(m), 2^14 .. 2^15.  v = 0: g =
 * 0. */
typedef struct plfx_rsqrt {
    uint32_t g;
    int32_t exp;
} plfx_rsqrt;

/* round(2^18 / sqrt(64 + i)), i = 0 .. 192: Q15 mantissas of 2^29/sqrt(m) at
 * m = (64 + i)*2^22. */
PLFX_TABLE uint16_t plfx_rsqrt_table[193] = {
    32768, 32515, 32268, 32026, 31790, 31558, 31332, 31111, 30894, 30682, 30474, 30270,
    30070, 29874, 29682, 29494, 29309, 29127, 28949, 28774, 28602, 28434, 28268, 28105,
    27945, 27787, 27632, 27480, 27330, 27183, 27038, 26895, 26755, 26617, 26481, 26346,
    26214, 26084, 25956, 25830, 25705, 25583, 25462, 25342, 25225, 25109, 24994, 24882,
    24770, 24660, 24552, 24445, 24339, 24235, 24132, 24031, 23930, 23831, 23733, 23637,
    23541, 23447, 23354, 23262, 23170, 23080, 22992, 22904, 22817, 22731, 22646, 22562,
    22479, 22396, 22315, 22235, 22155, 22077, 21999, 21922, 21845, 21770, 21695, 21621,
    21548, 21476, 21404, 21333, 21263, 21193, 21124, 21056, 20988, 20921, 20855, 20789,
    20724, 20660, 20596, 20533, 20470, 20408, 20346, 20285, 20225, 20165, 20106, 20047,
    19988, 19930, 19873, 19816, 19760, 19704, 19649, 19594, 19539, 19485, 19431, 19378,
    19326, 19273, 19221, 19170, 19119, 19068, 19018, 18968, 18919, 18870, 18821, 18773,
    18725, 18677, 18630, 18583, 18536, 18490, 18444, 18399, 18354, 18309, 18264, 18220,
    18176, 18133, 18090, 18047, 18004, 17962, 17920, 17878, 17837, 17795, 17755, 17714,
    17674, 17634, 17594, 17554, 17515, 17476, 17438, 17399, 17361, 17323, 17285, 17248,
    17211, 17174, 17137, 17100, 17064, 17028, 16992, 16957, 16921, 16886, 16851, 16817,
    16782, 16748, 16714, 16680, 16646, 16613, 16579, 16546, 16514, 16481, 16448, 16416,
    16384,
};

static inline plfx_rsqrt plfx_rsqrt_u64(uint64_t v)
{
    plfx_rsqrt r = {0, 0};
    int32_t top;
    uint32_t m;
    uint32_t i;
    uint32_t f;

    if (v == 0) {
        return r;
    }
    top = plfx_log2_u64(v);
    if (top >= 28) {
        r.exp = (top - 28) / 2;
        m = (uint32_t)(v >> (2 * r.exp));
    } else {
        r.exp = -((29 - top) / 2);
        m = (uint32_t)(v << (-2 * r.exp));
    }
    i = (m >> 22) - 64u; /* 0 .. 191: m is 2^28 .. 2^30 - 1 */
    f = (m >> 6) & 0xffffu;
    r.g = plfx_rsqrt_table[i] -
          ((((uint32_t)plfx_rsqrt_table[i] - plfx_rsqrt_table[i + 1]) * f + 32768u) >>
           16);
    return r;
}

/* Cost 32767 - z of a covariance between windows of variances a and b:
 * z = cov/sqrt(va*vb) * sqrt(m_a)/2, -2^14 .. 2^14; 0 when either has no variance. */
static inline uint32_t plfx_zncc_cost_of(int64_t cov, plfx_rsqrt a, plfx_rsqrt b)
{
    int32_t down = a.exp + b.exp + 15;
    int64_t t;

    if (a.g == 0 || b.g == 0) {
        return 32767u;
    }
    t = down >= 0 ? plfx_asr_i64(cov, down) : cov * ((int64_t)1 << -down);
    return (uint32_t)(32767 - (int32_t)plfx_round_shift_i64(t * (int64_t)b.g, 15));
}

/* The correlation itself from such a cost and the reference's mantissa: Q15. */
static inline int32_t plfx_correlation_q15(uint32_t cost, uint32_t g)
{
    int32_t r = plfx_asr_i32((32767 - (int32_t)cost) * (int32_t)g + 4096, 13);

    return plfx_clamp_i32(r, -32768, 32767);
}

/* floor(2^steps * num / den), num < 2^24, steps <= 8. */
static inline uint32_t plfx_divide(uint32_t num, uint32_t den, int32_t steps)
{
    return (num << steps) / den;
}

/* Vertex between labels from the rises a (next) and b (previous), 16 bits each:
 * sixteenths, -8 .. 8, by parabola or (vee) equiangular lines. */
static inline int32_t plfx_vertex_q4(uint32_t a, uint32_t b, int32_t vee)
{
    uint32_t num;
    uint32_t den;
    int32_t f;

    if ((a | b) >= 16384u) {
        a >>= 2;
        b >>= 2;
    }
    num = a > b ? a - b : b - a;
    den = vee ? (a > b ? a : b) : a + b;
    den = den > 1u ? den : 1u; /* no rise at all: 0 */
    f = (int32_t)((plfx_divide(num, den, 4) + 1u) >> 1);
    return b > a ? f : -f;
}

/* Margin (second - best)/(second + floor), in steps of 2^-8, all arguments first cut to
 * a quarter: 0 <= best <= second, second + floor < 2^17. */
static inline uint32_t plfx_margin_u16(uint32_t best, uint32_t second,
                                       uint32_t floor_cost)
{
    uint32_t num = (second - best) >> 2;
    uint32_t den = (second + floor_cost) >> 2;
    uint32_t q;

    if (num == 0) { /* as it is when den is */
        return 0;
    }
    q = plfx_divide(num, den, 8);
    return (q > 255u ? 255u : q) << 8;
}

#endif
