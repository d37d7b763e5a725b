/* SPDX-License-Identifier: MIT
 * Zero-mean normalised cross-correlation by column sums: exact integer moments,
 * fixed-point normalisation.  With w <= 31 rows of 12-bit samples a column of squares
 * is under 2^30; window sums under 2^35; N*S under 2^45. */
#include "sweep_state.h"
#include "fix.h"

static void add_reference(uint32_t *restrict a_col, uint32_t *restrict aa_col,
                          const uint16_t *restrict a, int32_t n, uint32_t sign)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint32_t v = a[i];
        a_col[i] += sign * v;
        aa_col[i] += sign * (v * v);
    }
}

static void add_pair(uint32_t *restrict b_col, uint32_t *restrict bb_col,
                     uint32_t *restrict ab_col, const uint16_t *restrict a,
                     const uint16_t *restrict b, int32_t n, uint32_t sign)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint32_t v = b[i];
        b_col[i] += sign * v;
        bb_col[i] += sign * (v * v);
        ab_col[i] += sign * (v * a[i]);
    }
}

void plfx_zncc_row(const plfx_sweep_state *s, int32_t y, int32_t sign)
{
    const plfx_plan *plan = s->plan;
    uint32_t factor = (uint32_t)sign; /* 1 or 2^32 - 1: adds or subtracts modulo 2^32 */
    int32_t p;
    int32_t l;

    add_reference(s->a_col, s->aa_col, plfx_ref_row(s, y), plan->nx, factor);
    for (p = 0; p < s->pairs; p++) {
        int32_t view = plfx_pair_view(plan, p);
#if PLFX_ZNCC_BY_ROWS
        if (s->rows->whole[p].is) {
            plfx_zncc_row_whole(s, p, y, factor);
            continue;
        }
#endif
        for (l = 0; l < plan->cfg.labels; l++) {
            size_t at = ((size_t)p * plan->cfg.labels + (size_t)l) * (size_t)plan->nx;
            plfx_sample_row(plan, &s->src, view, plfx_plan_shift(plan, view, l), y, 0,
                            plan->nx, s->sample);
            add_pair(s->b_col + at, s->bb_col + at, s->ab_col + at, plfx_ref_row(s, y),
                     s->sample, plan->nx, factor);
        }
    }
}

void plfx_zncc_reference(const plfx_sweep_state *s)
{
    int32_t w = s->plan->cfg.window;
    uint64_t n = (uint64_t)w * (uint64_t)w;
    uint64_t sum = 0;
    uint64_t squares = 0;
    int32_t i;

    for (i = 0; i < s->plan->nx; i++) {
        sum += s->a_col[i];
        squares += s->aa_col[i];
        if (i >= w) {
            sum -= s->a_col[i - w];
            squares -= s->aa_col[i - w];
        }
        if (i >= w - 1) {
            s->a_sum[i - w / 2] = sum;
            s->a_rsqrt[i - w / 2] = plfx_rsqrt_u64(n * squares - sum * sum);
#if PLFX_ZNCC_BY_ROWS
            s->rows->a_low[i - w + 1] = (uint32_t)sum;
            s->rows->a_exp[i - w + 1] =
                s->a_rsqrt[i - w / 2].g ? s->a_rsqrt[i - w / 2].exp : PLFX_ZNCC_FLAT;
#endif
        }
    }
}

typedef struct moments {
    uint64_t b, bb, ab;
} moments;

static void step(moments *m, const uint32_t *b, const uint32_t *bb, const uint32_t *ab,
                 int32_t i, int32_t w)
{
    m->b += b[i];
    m->bb += bb[i];
    m->ab += ab[i];
    if (i >= w) {
        m->b -= b[i - w];
        m->bb -= bb[i - w];
        m->ab -= ab[i - w];
    }
}

static uint16_t cost_of(const plfx_sweep_state *s, const moments *m, int32_t x,
                        uint64_t n)
{
    int64_t cov = (int64_t)(n * m->ab) - (int64_t)(s->a_sum[x] * m->b);
    plfx_rsqrt b = plfx_rsqrt_u64(n * m->bb - m->b * m->b);

    return (uint16_t)plfx_zncc_cost_of(cov, s->a_rsqrt[x], b);
}

void plfx_zncc_cost(const plfx_sweep_state *s, int32_t p)
{
    int32_t nx = s->plan->nx;
    int32_t w = s->plan->cfg.window;
    uint64_t n = (uint64_t)w * (uint64_t)w;
    int32_t l;
    int32_t i;

#if PLFX_ZNCC_BY_ROWS
    if (plfx_zncc_narrow(s->plan)) {
        plfx_zncc_cost_narrow(s, p);
        return;
    }
#endif
    for (l = 0; l < s->plan->cfg.labels; l++) {
        size_t at = ((size_t)p * s->plan->cfg.labels + (size_t)l) * (size_t)nx;
        moments m = {0, 0, 0};
        for (i = 0; i < nx; i++) {
            step(&m, s->b_col + at, s->bb_col + at, s->ab_col + at, i, w);
            if (i >= w - 1) {
                s->cost[(size_t)l * (size_t)nx + (size_t)(i - w / 2)] =
                    cost_of(s, &m, i - w / 2, n);
            }
        }
    }
}
