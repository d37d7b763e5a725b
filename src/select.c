/* SPDX-License-Identifier: MIT */
#include "sweep_state.h"
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

/* One label enters: a new best makes the least of the labels before its neighbour the
 * second; a label right behind the best is its neighbour and does not count. */
static void enter(const plfx_race *r, const uint16_t *restrict cost, int32_t l,
                  int32_t n)
{
    uint16_t *restrict label = r->label;
    uint16_t *restrict best = r->best;
    uint16_t *restrict second = r->second;
    uint16_t *restrict before = r->before;
    uint16_t *restrict won = r->won;
    int32_t x;

    for (x = 0; x < n; x++) {
        uint16_t v = cost[x];
        uint16_t b = best[x];
        uint16_t least = v < b ? v : b;
        uint16_t beside = (uint16_t)(v | won[x]);
        uint16_t rest = second[x] < beside ? second[x] : beside;
        uint16_t m = least != b ? 0xffffu : 0u;
        second[x] = m ? before[x] : rest;
        label[x] = m ? (uint16_t)l : label[x];
        before[x] = b;
        best[x] = least;
        won[x] = m;
    }
}

void plfx_race_row(const plfx_sweep_state *s)
{
    int32_t r = s->plan->cfg.window / 2;
    size_t nx = (size_t)s->plan->nx;
    plfx_race lane = {s->race.label + r, s->race.best + r, s->race.second + r,
                      s->race.before + r, s->race.won + r};
    int32_t n = s->plan->nx - 2 * r;
    int32_t l;
    int32_t x;

    for (x = 0; x < n; x++) {
        lane.label[x] = 0;
        lane.best[x] = s->cost[r + x];
        lane.second[x] = 65535u;
        lane.before[x] = 65535u;
        lane.won[x] = 65535u;
    }
    for (l = 1; l < s->plan->cfg.labels; l++) {
        enter(&lane, s->cost + (size_t)l * nx + r, l, n);
    }
}
