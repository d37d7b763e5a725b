/* SPDX-License-Identifier: MIT */
#include "plenofix/depth.h"
#include "fix.h"

int32_t plfx_inv_depth_q24(const plfx_optics *o, int32_t slope_q16)
{
    /* |gain| < 2^39, |slope| < 2^20 in practice: cut to keep the product under 2^62 */
    int64_t slope = plfx_clamp_i32(slope_q16, -(1 << 22), 1 << 22);

    return plfx_sat_i32(o->inv0_q24 + plfx_round_shift_i64(o->gain_q24 * slope, 16));
}

uint32_t plfx_depth_um(int32_t inv_q24)
{
    uint64_t um;

    if (inv_q24 <= 0) {
        return UINT32_MAX;
    }
    um = (((uint64_t)1000000u << 24) + (uint64_t)inv_q24 / 2u) / (uint64_t)inv_q24;
    return um > UINT32_MAX ? UINT32_MAX : (uint32_t)um;
}

void plfx_depth_row(const plfx_optics *o, const int32_t *slope_q16, int32_t n,
                    uint32_t *um)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        um[i] = slope_q16[i] == PLFX_SLOPE_NONE
                    ? 0u
                    : plfx_depth_um(plfx_inv_depth_q24(o, slope_q16[i]));
    }
}
