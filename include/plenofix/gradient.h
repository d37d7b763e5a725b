/* SPDX-License-Identifier: MIT
 * Least-squares gradient slope (Adelson and Wang 1992; the paper's equation 3) from a
 * centre view and its four neighbours one sub-aperture step away:
 *   D = -sum(Ix*Iu + Iy*Iv) / sum(Ix^2 + Iy^2)
 * over a window.  Derivatives are the matched 3-tap pair of Farid and Simoncelli
 * (2004), prefilter p = [59 138 59]/256, derivative d = [-109 0 109]/256: Iu is d along
 * u and p along x and y; Ix is p along u and y and d along x; likewise Iy, Iv.  Equal
 * prefilters on all axes are what keeps the slope from being read low. */
#ifndef PLENOFIX_GRADIENT_H
#define PLENOFIX_GRADIENT_H

#include "plenofix/plan.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Workspace, bytes: exactly enough. */
size_t plfx_gradient_ws(const plfx_plan *plan);

/* plan: method GRADIENT, views in the order centre, -u, +u, -v, +v at equal steps.  On
 * a hexagonal lattice the neighbouring rows are displaced by the odd-row step first.
 * conf = e/(e + t): e the smaller eigenvalue of the window's structure tensor, (counts
 * per lens)^2 a sample, t the square of 1/64 of full scale.  A lens whose conf is under
 * the plan's unique_u16, or without any gradient, is NONE with flag TEXTURE.  |slope|
 * saturates at 8.  Cost per lens: about 80 multiplications, whatever the window, and a
 * division of 64 bits (two where a step is no pixel); 15 multiplications and a division
 * more where conf_u16 or unique_u16 asks for confidence.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE. */
plfx_status plfx_gradient(const plfx_plan *plan, const plfx_views *views,
                          const plfx_map *out, void *ws, size_t ws_size) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
