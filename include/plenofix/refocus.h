/* SPDX-License-Identifier: MIT
 * Synthetic refocus by shift and sum: each view is displaced so that slope D falls
 * together, then averaged. */
#ifndef PLENOFIX_REFOCUS_H
#define PLENOFIX_REFOCUS_H

#include "plenofix/plan.h"

#ifdef __cplusplus
extern "C" {
#endif

/* out(i,j) = round(mean over the plan's views of the view sampled at the shift of slope
 * `slope_q16`, 1/16 column and row, bilinear, replicated border).  The plan gives views
 * and lattice; its labels are not used.  out: nx x ny.  PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_refocus(const plfx_plan *plan, const plfx_views *views,
                         int32_t slope_q16, const plfx_image *out) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
