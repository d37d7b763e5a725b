/* SPDX-License-Identifier: MIT
 * Depth from slope (the paper's equation 1): 1/d = 1/F - (1/f)(1 - h/v) with
 * h/v = -D/kappa, kappa = f*p/(f_m*P), is a straight line in the slope D:
 *   1/d = inv0 + gain*D
 * F focal length, f lens-to-array distance, p sensor pixel, f_m microlens focal length,
 * P lens pitch.  Nearer than focus is D < 0.  A host tool computes the two numbers
 * once. */
#ifndef PLENOFIX_DEPTH_H
#define PLENOFIX_DEPTH_H

#include "plenofix/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct plfx_optics {
    int32_t inv0_q24; /* 1/F - 1/f = 1/d_focus, dioptres, -128 .. 128 */
    int64_t gain_q24; /* -1/(f*kappa), dioptres per unit slope, |gain| < 2^15;
                         < 0 for raw frames */
} plfx_optics;

/* Inverse depth, dioptres, saturated.  Precondition: slope != PLFX_SLOPE_NONE. */
int32_t plfx_inv_depth_q24(const plfx_optics *o, int32_t slope_q16);

/* Depth in micrometres, rounded; UINT32_MAX at or beyond infinity or 4294 m. */
uint32_t plfx_depth_um(int32_t inv_q24);

/* Depth row: um[i] = depth of slope[i]; 0 where the slope is NONE. */
void plfx_depth_row(const plfx_optics *o, const int32_t *slope_q16, int32_t n,
                    uint32_t *um);

#ifdef __cplusplus
}
#endif
#endif
