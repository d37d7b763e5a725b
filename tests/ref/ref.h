/* SPDX-License-Identifier: MIT
 * Slow, obvious references: each follows src/NUMERICS.md sample by sample. */
#ifndef PLENOFIX_TESTS_REF_H
#define PLENOFIX_TESTS_REF_H

#include "plenofix/plenofix.h"

/* View k at label l as target (x,y) sees it. */
uint16_t ref_sample(const plfx_plan *plan, const plfx_views *views, int32_t k,
                    int32_t l, int32_t x, int32_t y);

/* Window costs of all labels of pair p (SWEEP: p = 0) at (x,y), window inside the
 * map. */
void ref_costs(const plfx_plan *plan, const plfx_views *views, int32_t p, int32_t x,
               int32_t y, uint16_t *cost);

/* The whole map, pixel by pixel. */
void ref_sweep(const plfx_plan *plan, const plfx_views *views, const plfx_map *out);

/* Small deterministic generator: the same numbers on every machine. */
typedef struct ref_rng {
    uint32_t state;
} ref_rng;
uint32_t ref_next(ref_rng *rng);                         /* 32 bits */
int32_t ref_range(ref_rng *rng, int32_t lo, int32_t hi); /* lo .. hi */

#endif
