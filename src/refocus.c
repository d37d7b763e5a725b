/* SPDX-License-Identifier: MIT */
#include "plenofix/refocus.h"
#include "rows.h"
#include "fix.h"

#define CHUNK 64 /* lenses summed at a time on the stack */

static void add(uint32_t *restrict sum, const uint16_t *restrict row, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        sum[i] += row[i]; /* 128 views * 65535 < 2^23 */
    }
}

static void chunk(const plfx_plan *plan, const plfx_ring *views, int32_t slope_q16,
                  int32_t j, int32_t x0, int32_t n, uint16_t *out)
{
    uint32_t sum[CHUNK] = {0};
    uint16_t row[CHUNK];
    uint32_t count = plan->cfg.n;
    int32_t k;
    int32_t i;

    for (k = 0; k < plan->cfg.n; k++) {
        plfx_sample_row(plan, views, k, plfx_shift_at(plan, k, slope_q16), j, x0, n,
                        row);
        add(sum, row, n);
    }
    for (i = 0; i < n; i++) {
        /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): a plan has views */
        out[i] = (uint16_t)((sum[i] + count / 2u) / count);
    }
}

plfx_status plfx_refocus(const plfx_plan *plan, const plfx_views *views,
                         int32_t slope_q16, const plfx_image *out)
{
    plfx_ring rows;
    int32_t j;
    int32_t x;

    if (!plan || !views || !views->px || !out || !out->px || views->nx != plan->nx ||
        views->ny != plan->ny || views->n != plan->cfg.n || out->w != plan->nx ||
        out->h != plan->ny || out->stride < out->w || slope_q16 < -(8 << 16) ||
        slope_q16 > 8 << 16) {
        return PLFX_E_ARG;
    }
    rows = plfx_ring_of(views);
    for (j = 0; j < plan->ny; j++) {
        for (x = 0; x < plan->nx; x += CHUNK) {
            chunk(plan, &rows, slope_q16, j, x, plfx_min_i32(CHUNK, plan->nx - x),
                  out->px + (size_t)j * (size_t)out->stride + x);
        }
    }
    return PLFX_OK;
}
