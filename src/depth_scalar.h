/* SPDX-License-Identifier: MIT
 * Depth of one lens, in the common subset of C99 and OpenCL C. */
#ifndef PLENOFIX_SRC_DEPTH_SCALAR_H
#define PLENOFIX_SRC_DEPTH_SCALAR_H

#include "fix.h"

/* Inverse depth, dioptres q24, saturated. */
static inline int32_t plfx_inverse_q24(int32_t inv0_q24, int64_t gain_q24,
                                       int32_t slope_q16)
{
    /* |gain| < 2^39, |slope| < 2^20 in practice: cut to keep the product under 2^62 */
    int64_t slope = plfx_clamp_i32(slope_q16, -(1 << 22), 1 << 22);

    return plfx_sat_i32(inv0_q24 + plfx_round_shift_i64(gain_q24 * slope, 16));
}

/* Micrometres of a positive inverse depth, cut at 2^32 - 1. */
static inline uint32_t plfx_micrometres(int32_t inv_q24)
{
    uint64_t um =
        (((uint64_t)1000000u << 24) + (uint64_t)inv_q24 / 2u) / (uint64_t)inv_q24;

    return um > 0xffffffffu ? 0xffffffffu : (uint32_t)um;
}

#endif
