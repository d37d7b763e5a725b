/* SPDX-License-Identifier: MIT
 * Two maps to compare, of at most PLANES_CELLS lenses. */
#ifndef PLENOFIX_TESTS_PLANES_H
#define PLENOFIX_TESTS_PLANES_H

#include "plenofix/plan.h"

typedef struct planes {
    int32_t slope[PLANES_CELLS];
    uint16_t conf[PLANES_CELLS], sigma[PLANES_CELLS];
    uint8_t flags[PLANES_CELLS];
} planes;
static planes got, want;

static inline plfx_map map_of(planes *p, const plfx_plan *plan)
{
    plfx_map m = {p->slope, p->conf, p->sigma, p->flags, plan->nx, plan->ny, plan->nx};

    return m;
}

#endif
