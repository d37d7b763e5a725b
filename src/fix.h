/* SPDX-License-Identifier: MIT
 * Rounding and saturation, once; in the common subset of C99 and OpenCL C.  The only
 * place where negative numbers are shifted right: every compiler we build with shifts
 * arithmetically; tests/unit/test_fix.c holds it. */
#ifndef PLENOFIX_SRC_FIX_H
#define PLENOFIX_SRC_FIX_H

#if !defined(__OPENCL_C_VERSION__)
#include <stdint.h>
#endif

static inline int32_t plfx_min_i32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline int32_t plfx_max_i32(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static inline int32_t plfx_clamp_i32(int32_t v, int32_t lo, int32_t hi)
{
    return plfx_min_i32(plfx_max_i32(v, lo), hi);
}

static inline int64_t plfx_clamp_i64(int64_t v, int64_t lo, int64_t hi)
{
    int64_t least = v > lo ? v : lo;

    return least < hi ? least : hi;
}

/* floor(v / 2^s), 0 <= s <= 31. */
static inline int32_t plfx_asr_i32(int32_t v, int32_t s)
{
    return v >> s;
}

/* floor(v / 2^s), 0 <= s <= 63. */
static inline int64_t plfx_asr_i64(int64_t v, int32_t s)
{
    return v >> s;
}

/* floor(v / 2^s + 1/2), 1 <= s <= 62, |v| < 2^62. */
static inline int64_t plfx_round_shift_i64(int64_t v, int32_t s)
{
    return plfx_asr_i64(v + ((int64_t)1 << (s - 1)), s);
}

/* n/d rounded half away from zero; d > 0, |n| < 2^62, d < 2^62. */
static inline int64_t plfx_div_round_i64(int64_t n, int64_t d)
{
    return n >= 0 ? (n + d / 2) / d : -((-n + d / 2) / d);
}

/* floor(log2(v)), v > 0. */
static inline int32_t plfx_log2_u64(uint64_t v)
{
#if defined(__OPENCL_C_VERSION__)
    return 63 - (int32_t)clz(v);
#elif defined(__GNUC__)
    return 63 - __builtin_clzll(v);
#else
    int32_t n = 0;
    int32_t step;

    for (step = 32; step > 0; step >>= 1) {
        if (v >> step) {
            v >>= step;
            n += step;
        }
    }
    return n;
#endif
}

/* Saturate to 32 bits. */
static inline int32_t plfx_sat_i32(int64_t v)
{
    return v > INT32_MAX ? INT32_MAX : v < INT32_MIN ? INT32_MIN : (int32_t)v;
}

/* floor(sqrt(v)). */
static inline uint32_t plfx_isqrt_u64(uint64_t v)
{
    uint64_t root = 0;
    uint64_t bit = (uint64_t)1 << 62;
    int32_t i;

    for (i = 0; i < 32; i++) { /* 32 steps: one bit of the root each */
        uint64_t trial = root + bit;
        root >>= 1;
        if (v >= trial) {
            v -= trial;
            root += bit;
        }
        bit >>= 2;
    }
    return (uint32_t)root;
}

#endif
