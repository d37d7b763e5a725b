/* SPDX-License-Identifier: MIT
 * Contracts of the helpers of fix.h in ACSL: their results as specified, no overflow,
 * no shift out of range.  Proved by Frama-C's WP: .ci/checks/proof.py.  What shifts by
 * a variable is left to bounded.c. */
#include <stdint.h>

/*@ assigns \nothing;
    ensures \result == (a < b ? a : b); */
static inline int32_t plfx_min_i32(int32_t a, int32_t b);

/*@ assigns \nothing;
    ensures \result == (a > b ? a : b); */
static inline int32_t plfx_max_i32(int32_t a, int32_t b);

/*@ requires lo <= hi;
    assigns \nothing;
    ensures lo <= \result <= hi;
    ensures lo <= v <= hi ==> \result == v;
    ensures v < lo ==> \result == lo;
    ensures v > hi ==> \result == hi; */
static inline int32_t plfx_clamp_i32(int32_t v, int32_t lo, int32_t hi);

/*@ requires lo <= hi;
    assigns \nothing;
    ensures lo <= \result <= hi;
    ensures lo <= v <= hi ==> \result == v;
    ensures v < lo ==> \result == lo;
    ensures v > hi ==> \result == hi; */
static inline int64_t plfx_clamp_i64(int64_t v, int64_t lo, int64_t hi);

/*@ requires 0 <= s <= 31;
    assigns \nothing;
    ensures \result == (v >> s); */
static inline int32_t plfx_asr_i32(int32_t v, int32_t s);

/*@ requires 0 <= s <= 63;
    assigns \nothing;
    ensures \result == (v >> s); */
static inline int64_t plfx_asr_i64(int64_t v, int32_t s);

/*@ requires 0 < d < 0x4000000000000000;
    requires -0x4000000000000000 < n < 0x4000000000000000;
    assigns \nothing;
    ensures n >= 0 ==> \result == (n + d / 2) / d;
    ensures n < 0 ==> \result == -((-n + d / 2) / d); */
static inline int64_t plfx_div_round_i64(int64_t n, int64_t d);

/*@ assigns \nothing;
    ensures INT32_MIN <= v <= INT32_MAX ==> \result == v;
    ensures v > INT32_MAX ==> \result == INT32_MAX;
    ensures v < INT32_MIN ==> \result == INT32_MIN; */
static inline int32_t plfx_sat_i32(int64_t v);

#include "fix.h"
