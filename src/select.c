/* SPDX-License-Identifier: MIT */
#include "rows.h"
#include "fix.h"

plfx_winner plfx_select(const uint16_t *cost, int32_t n, int32_t step, int32_t fit)
{
    plfx_winner w = {0, 0, cost[0], 65535u, 0, 0};
    int32_t seen = 0;
    int32_t l;

    for (l = 1; l < n; l++) {
        if (cost[l * step] < w.best) {
            w.best = cost[l * step];
            w.label = l;
        }
    }
    for (l = 0; l < n; l++) {
        if (l < w.label - 1 || l > w.label + 1) {
            w.second = (uint16_t)plfx_min_i32(w.second, cost[l * step]);
            seen = 1;
        }
    }
    if (!seen) {
        w.second = w.best;
    }
    w.tie = seen && w.second == w.best;
    w.end = w.label == 0 || w.label == n - 1;
    if (!w.end) {
        const uint16_t *c = cost + w.label * step;
        w.frac_q4 = plfx_vertex_q4((uint32_t)(c[step] - w.best),
                                   (uint32_t)(c[-step] - w.best), fit);
    }
    return w;
}
