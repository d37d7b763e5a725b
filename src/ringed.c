/* SPDX-License-Identifier: MIT */
#include "ringed.h"
#include "fix.h"

#include <string.h>

static int32_t is_gradient(const plfx_plan *plan)
{
    return plan->cfg.method == PLFX_METHOD_GRADIENT;
}

int32_t plfx_ringed_is(const plfx_plan *plan)
{
    if (is_gradient(plan)) {
        return plan->cfg.n == PLFX_G_VIEWS;
    }
    return plan->cfg.method == PLFX_METHOD_PAIRS && plan->cfg.cost == PLFX_COST_ZNCC;
}

static void measure(plfx_ringed *r, const plfx_plan *plan)
{
    int32_t gradient = is_gradient(plan);

    r->plan = plan;
    r->margin = plan->cfg.window / 2 + gradient;
    r->below = gradient ? 1 : plan->reach_y;
    r->above = plfx_max_i32(r->below, plan->cfg.texture > 0);
    r->depth = r->above + 1 + r->below + (gradient ? 0 : plan->cfg.window);
}

static void carve_zncc(plfx_ringed *r, plfx_arena *a)
{
    plfx_sweep_state dry;
    plfx_sweep_state *s = plfx_take(a, 1, sizeof *s);

    plfx_zncc_carve(s ? s : &dry, r->plan, a);
    r->zncc = s;
}

static void carve_gradient(plfx_ringed *r, plfx_arena *a)
{
    plfx_gradient_state dry;
    plfx_gradient_state *s = plfx_take(a, 1, sizeof *s);

    plfx_gradient_carve(s ? s : &dry, r->plan, a);
    r->gradient = s;
}

static plfx_ring ring_of(const plfx_ringed *r)
{
    plfx_ring ring = {r->px, r->plan->nx, r->plan->ny, r->plan->cfg.n, r->depth};

    return ring;
}

void plfx_ringed_carve(plfx_ringed *r, const plfx_plan *plan, plfx_arena *a)
{
    measure(r, plan);
    r->zncc = NULL;
    r->gradient = NULL;
    r->px = plfx_take(a, (size_t)r->depth * plan->cfg.n * (size_t)plan->nx,
                      sizeof(uint16_t));
    if (is_gradient(plan)) {
        carve_gradient(r, a);
    } else {
        carve_zncc(r, a);
    }
}

void plfx_ringed_start(plfx_ringed *r, int32_t y0)
{
    if (r->gradient) {
        r->gradient->src = ring_of(r);
        plfx_gradient_begin(r->gradient, y0);
    } else {
        r->zncc->src = ring_of(r);
        plfx_zncc_begin(r->zncc, y0);
    }
}

/* Sums of the gradient take row j - 1 at once: its own rows of derivatives are what a
 * window keeps of it. */
void plfx_ringed_put(const plfx_ringed *r, int32_t j, const uint16_t *rows)
{
    size_t len = (size_t)r->plan->cfg.n * (size_t)r->plan->nx;

    memcpy(r->px + (size_t)(j % r->depth) * len, rows, len * sizeof(uint16_t));
    if (r->gradient) {
        plfx_gradient_enter(r->gradient, j - 1);
    }
}

void plfx_ringed_row(plfx_ringed *r, int32_t y, const plfx_map *row)
{
    if (r->gradient) {
        plfx_gradient_row(r->gradient, y, row);
    } else {
        plfx_zncc_map_row(r->zncc, y, row);
    }
}
