/* SPDX-License-Identifier: MIT
 * Standard errors of the refinement (frame.h).  Scores
 *   t(q) = A(q) (e(q) - e(p) - step) - B(q)
 * are summed over every block of 3x3 that touches the window: neighbours share texture,
 * interpolation errors and, when views are smoothed, noise, so their scores are not
 * independent.  With triangular weights 1 - |l|/3 (Bartlett; Conley 1999) at lag l
 *   sum over blocks of (sum t)^2 / 9 / bias,  bias = 1 - (3 - 8/(3 w))^2 / w^2
 * where bias is what the step's fit to its own window takes away.  It is not let under
 * the information times the mean squared residual, which a lucky window would be. */
#include <string.h>

#include "refine_state.h"
#include "fix.h"

#define SCORE_MAX  (1 << 24) /* 9 of them squared, 289 times: under 2^63 */
#define ROOT_MAX   ((uint64_t)1 << 31)
#define MISFIT_TOP ((uint64_t)1 << 24) /* by A >> 8 under 2^63 */
#define LEVER_MAX  ((int64_t)1 << 24)
#define PULL_Q4    29u /* 1.8 priors: a winner that little texture holds is worse */

/* A (e(q) - e(p) - step) - B in columns, q2. */
static int32_t score_of(const plfx_sums *q, int32_t d, int32_t step)
{
    int64_t t = plfx_asr_i64(q->a * (d - step) - q->b * 16384, 18);

    return (int32_t)plfx_clamp_i64(t, -SCORE_MAX, SCORE_MAX);
}

/* Scores of the window in the middle of a grid that is two wider on every side; each
 * cell then holds the sum of three along the row. */
static void fill_scores(const plfx_frame_state *s, const plfx_refine_work *t,
                        const int32_t *e, plfx_refine_window w, int32_t here,
                        int32_t step)
{
    int32_t gate = s->cfg.gate_q8 * 256;
    int32_t side = s->cfg.window + 4;
    int32_t y;
    int32_t x;

    memset(t->score, 0, (size_t)(side * side) * sizeof *t->score);
    for (y = w.y0; y <= w.y1; y++) {
        const plfx_sums *row = plfx_refine_row(s, t, y);
        const int32_t *there = e + (size_t)y * (size_t)s->nx;
        int32_t *out = t->score + (size_t)(y - w.y0 + 2) * (size_t)side;
        for (x = w.x0; x <= w.x1; x++) {
            int32_t d = there[x] - here;
            if (d < gate && d > -gate) {
                out[x - w.x0 + 2] = score_of(row + x, d, step);
            }
        }
        for (x = 0; x < side - 2; x++) {
            out[x] += out[x + 1] + out[x + 2];
        }
    }
}

/* Sum over the blocks of (sum t)^2, q4. */
static uint64_t sum_blocks(const int32_t *score, int32_t side)
{
    uint64_t sum = 0;
    int32_t y;
    int32_t x;

    for (y = 0; y < side - 2; y++) {
        const int32_t *r = score + (size_t)y * (size_t)side;
        for (x = 0; x < side - 2; x++) {
            int64_t b = (int64_t)r[x] + r[x + side] + r[x + 2 * side];
            sum += (uint64_t)(b * b);
        }
    }
    return sum;
}

/* 1/(9 bias), q12; a window of one says nothing of its scatter. */
static uint64_t block_share_q12(int32_t w)
{
    int64_t w4 = (int64_t)w * w * w * w;
    int64_t lags = 9 * w - 8; /* 3 w^2 times the root of 1 - bias */

    return w > 1 ? (uint64_t)(4096 * w4 / (9 * w4 - lags * lags)) : 455u;
}

/* Variance of the sum of scores, q4. */
static uint64_t variance(const plfx_frame_state *s, const plfx_refine_work *t,
                         const plfx_solution *v)
{
    uint64_t share = block_share_q12(s->cfg.window);
    uint64_t blocks = sum_blocks(t->score, s->cfg.window + 4);
    uint64_t misfit = (uint64_t)v->misfit_q8;
    uint64_t least;

    blocks = (blocks >> 12) * share + (((blocks & 4095u) * share) >> 12);
    misfit = misfit < MISFIT_TOP ? misfit : MISFIT_TOP;
    least = ((uint64_t)v->a >> 8) * misfit;
    blocks = blocks > least ? blocks : least;
    return s->smooth ? blocks / 9u * 16u : blocks;
}

/* What the median of the refined map leaves of a window's error, q8, by its side:
 * windows that overlap share theirs (five by five boxes averaged over five by five
 * places keep 0.68; 0.61 was found on drawn scenes). */
static uint64_t kept_q8(const plfx_frame_state *s)
{
    static const uint16_t share[4] = {256, 208, 156, 128};

    return share[s->cfg.median2 / 2u];
}

static uint64_t cut_root(uint64_t v)
{
    return v < ROOT_MAX ? v : ROOT_MAX;
}

void plfx_sigma_pixel(const plfx_frame_state *s, const plfx_refine_work *t,
                      const int32_t *e, plfx_refine_window w, size_t at,
                      const plfx_solution *v)
{
    uint64_t norm = (uint64_t)(v->a + v->lambda);
    uint64_t pull = ((uint64_t)v->lambda * s->cfg.prior_q12 * PULL_Q4) >> 18; /* q2 */
    uint64_t step = (uint64_t)(v->step < 0 ? -v->step : v->step) / 4u;
    uint64_t root;

    fill_scores(s, t, e, w, e[at], v->step);
    root = cut_root(plfx_isqrt_u64(variance(s, t, v)));
    root = (root * kept_q8(s)) >> 8;
    pull = cut_root(pull);
    root = plfx_isqrt_u64(root * root + pull * pull);
    root = cut_root((root << 18) / norm);
    s->base[at] = plfx_cut_u32(plfx_isqrt_u64(root * root + step * step));
    s->misfit[at] = plfx_cut_u32((uint64_t)v->misfit_q8);
    /* sqrt(samples A / arms) / (A + lambda), columns a count, q20; half of the square
     * where the share across an edge takes the rest (sigma_map.c) */
    root = plfx_isqrt_u64((uint64_t)v->samples * (uint64_t)v->a / (uint32_t)s->arms /
                          (s->cfg.rival_q8 ? 2u : 1u));
    root = ((root * kept_q8(s)) << 14) / norm;
    s->lever[at] = (uint32_t)plfx_clamp_i64((int64_t)root, 0, LEVER_MAX); /* < 2^54 */
}
