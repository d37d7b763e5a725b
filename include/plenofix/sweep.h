/* SPDX-License-Identifier: MIT
 * Matching of a block of views by plan: box-filtered SAD or zero-mean NCC, winner,
 * sub-label fit, texture and uniqueness tests.  src/NUMERICS.md defines every number;
 * tests/ref/ computes them the slow, obvious way. */
#ifndef PLENOFIX_SWEEP_H
#define PLENOFIX_SWEEP_H

#include "plenofix/plan.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Workspace of plfx_sweep(), bytes.  Exactly that much is enough and is needed. */
size_t plfx_sweep_ws(const plfx_plan *plan);

/* Match a whole frame.  `views` has the plan's views in the plan's order; `out` has the
 * plan's nx x ny.  Samples whose window at the winning label leaves a view in use are
 * NONE with flag EDGE.  Cost per lens: a constant times labels times (n-1), whatever
 * the window.  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE. */
plfx_status plfx_sweep(const plfx_plan *plan, const plfx_views *views,
                       const plfx_map *out, void *ws, size_t ws_size) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
