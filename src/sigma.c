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
#define LEVER_MAX  ((uint64_t)1 << 24)
#define RIVAL_CONF 39322u /* 0.6 */
#define BIN_LEAST  160u   /* of a misfit of 32 */

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

static uint32_t cut_u32(uint64_t v)
{
    v = v < UINT32_MAX ? v : UINT32_MAX;
    return (uint32_t)v;
}

void plfx_sigma_pixel(const plfx_frame_state *s, const plfx_refine_work *t,
                      const int32_t *e, plfx_refine_window w, size_t at,
                      const plfx_solution *v)
{
    uint64_t norm = (uint64_t)(v->a + v->lambda);
    uint64_t pull = ((uint64_t)v->lambda * s->cfg.prior_q12) >> 14; /* q2 */
    uint64_t root;

    fill_scores(s, t, e, w, e[at], v->step);
    root = plfx_isqrt_u64(variance(s, t, v));
    root = root < ROOT_MAX ? root : ROOT_MAX;
    pull = pull < ROOT_MAX ? pull : ROOT_MAX;
    root = plfx_isqrt_u64(root * root + pull * pull);
    s->base[at] = cut_u32((root << 18) / norm);
    s->misfit[at] = cut_u32((uint64_t)v->misfit_q8);
    /* sqrt(samples A / arms) / (A + lambda), columns a count, q20 */
    root = plfx_isqrt_u64((uint64_t)v->samples * (uint64_t)v->a / (uint32_t)s->arms);
    root = (root << 22) / norm;
    root = root < LEVER_MAX ? root : LEVER_MAX;
    s->lever[at] = (uint32_t)root;
}

/* Exponent and five bits; no misfit lies under 819 (refine.c). */
static uint32_t bin_of(uint32_t v)
{
    uint32_t e = 0;

    while (v >> e > 1u) { /* at most 31 times */
        e++;
    }
    return (e << 5) | ((v >> (e - 5u)) & 31u);
}

/* Middle of the misfits, q8: 2 % fine. */
static uint32_t usual_misfit(const plfx_frame_state *s, const plfx_refine_work *t)
{
    size_t n = (size_t)s->nx * (size_t)s->ny;
    uint32_t k = BIN_LEAST;
    size_t seen;
    size_t i;

    memset(t->bin, 0, PLFX_MISFIT_BINS * sizeof *t->bin);
    for (i = 0; i < n; i++) {
        t->bin[bin_of(s->misfit[i])]++;
    }
    seen = t->bin[k];
    while (2 * seen < n) { /* at most PLFX_MISFIT_BINS: they hold n */
        k++;
        seen += t->bin[k];
    }
    return (32u | (k & 31u)) << ((k >> 5) - 5u);
}

/* What chance gives: two standard errors above: half of a residual's square is
 * the reference's noise, the same for all views, so that a window of w^2 pixels holds
 * w^2/c of it: 2 sqrt(2 c/w^2)/2, c the filter's reach, 64/9 of smoothed views. */
static uint32_t chance_misfit(const plfx_frame_state *s, uint32_t usual)
{
    uint32_t root_q8 = s->smooth ? 966u : 362u; /* sqrt(2 c) */

    return cut_u32(usual + (((uint64_t)usual * root_q8 / s->cfg.window) >> 8));
}

/* rival * max(0, 1 - c/0.6)^2, q16 columns. */
static uint64_t rival_of(const plfx_frame_state *s, uint16_t conf)
{
    uint32_t near_q8 = conf < RIVAL_CONF ? (RIVAL_CONF - conf) * 256u / RIVAL_CONF : 0u;

    return ((uint64_t)near_q8 * near_q8 * s->cfg.rival_q8) >> 8;
}

void plfx_sigma_finish(const plfx_frame_state *s, const plfx_refine_work *t)
{
    size_t n = (size_t)s->nx * (size_t)s->ny;
    uint32_t usual = chance_misfit(s, usual_misfit(s, t));
    size_t i;

    for (i = 0; i < n; i++) {
        uint32_t over = s->misfit[i] > usual ? s->misfit[i] - usual : 0u;
        uint64_t more = (s->lever[i] * plfx_isqrt_u64(over)) >> 8; /* q20 q4 -> q16 */
        uint64_t rival = rival_of(s, s->conf[i]);
        uint64_t base = s->base[i];
        base = base < ROOT_MAX / 2 ? base : ROOT_MAX / 2;
        more = more < ROOT_MAX / 2 ? more : ROOT_MAX / 2;
        base = plfx_isqrt_u64(base * base + more * more + rival * rival);
        s->sigma[i] = plfx_frame_sigma(s, cut_u32(base));
    }
}
