/* SPDX-License-Identifier: MIT
 * Sum of absolute differences in 16 bits, exact by the shifts of the plan. */
#include "sweep_state.h"
#include "fix.h"

static void difference(uint16_t *restrict sum, const uint16_t *restrict a,
                       const uint16_t *restrict b, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint16_t hi = a[i] > b[i] ? a[i] : b[i];
        uint16_t lo = a[i] > b[i] ? b[i] : a[i];
        sum[i] = (uint16_t)(sum[i] + (uint16_t)(hi - lo));
    }
}

/* Columns hold exact sums: what leaves was added before, so no wrap occurs. */
static void accumulate(uint16_t *restrict col, const uint16_t *restrict item, int32_t n,
                       int32_t shift, int32_t sign)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint16_t c = (uint16_t)(item[i] >> shift);
        col[i] = (uint16_t)(sign > 0 ? col[i] + c : col[i] - c);
    }
}

static void add_view(const plfx_sweep_state *s, int32_t view, int32_t label, int32_t y)
{
    plfx_shift shift = plfx_plan_shift(s->plan, view, label);

    plfx_sample_row(s->plan, s->views, view, shift, y, 0, s->plan->nx, s->sample);
    difference(s->item, plfx_ref_row(s, y), s->sample, s->plan->nx);
}

void plfx_sad_row(const plfx_sweep_state *s, int32_t y, int32_t sign)
{
    int32_t nx = s->plan->nx;
    int32_t labels = s->plan->cfg.labels;
    int32_t others = s->plan->cfg.n - 1;
    int32_t per_pair = others / s->pairs; /* all, or one */
    int32_t p;
    int32_t l;
    int32_t k;
    int32_t i;

    for (p = 0; p < s->pairs; p++) {
        for (l = 0; l < labels; l++) {
            for (i = 0; i < nx; i++) {
                s->item[i] = 0;
            }
            for (k = 0; k < per_pair; k++) {
                add_view(s, plfx_pair_view(s->plan, p + k), l, y);
            }
            accumulate(s->sad_col +
                           ((size_t)p * (size_t)labels + (size_t)l) * (size_t)nx,
                       s->item, nx, s->plan->sad_shift1, sign);
        }
    }
}

static void slide(const uint16_t *restrict col, uint16_t *restrict out, int32_t nx,
                  int32_t w, int32_t shift)
{
    uint32_t sum = 0;
    int32_t i;

    for (i = 0; i < nx; i++) {
        sum += (uint32_t)(col[i] >> shift);
        if (i >= w) {
            sum -= (uint32_t)(col[i - w] >> shift);
        }
        if (i >= w - 1) {
            out[i - w / 2] = (uint16_t)sum;
        }
    }
}

void plfx_sad_cost(const plfx_sweep_state *s, int32_t p)
{
    int32_t nx = s->plan->nx;
    int32_t labels = s->plan->cfg.labels;
    int32_t l;

    for (l = 0; l < labels; l++) {
        slide(s->sad_col + ((size_t)p * (size_t)labels + (size_t)l) * (size_t)nx,
              s->cost + (size_t)l * (size_t)nx, nx, s->plan->cfg.window,
              s->plan->sad_shift2);
    }
}
