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

/* Map rows j0 .. j1-1 alone: a band for a thread of the caller's, each with a
 * workspace of its own; `out` is the whole map.  Bands together give plfx_sweep()'s
 * map to the bit. Each band costs window-1 further rows of columns.  Same errors;
 * PLFX_E_ARG for rows off the map. */
plfx_status plfx_sweep_rows(const plfx_plan *plan, const plfx_views *views, int32_t j0,
                            int32_t j1, const plfx_map *out, void *ws,
                            size_t ws_size) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
