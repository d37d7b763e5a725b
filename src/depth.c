/* SPDX-License-Identifier: MIT */
#include "plenofix/depth.h"
#include "depth_scalar.h"

int32_t plfx_inv_depth_q24(const plfx_optics *o, int32_t slope_q16)
{
    return plfx_inverse_q24(o->inv0_q24, o->gain_q24, slope_q16);
}

uint32_t plfx_depth_um(int32_t inv_q24)
{
    return inv_q24 <= 0 ? UINT32_MAX : plfx_micrometres(inv_q24);
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
