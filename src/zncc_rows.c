/* SPDX-License-Identifier: MIT
 * Normalised cross-correlation of whole rows in 32 bits, where N * full scale is
 * under 2^16.5: N^2 * full^2 / 4 bounds variances and covariances, so that they are
 * exact modulo 2^32.  The numbers are those of plfx_zncc_cost_of(), in loops without
 * branches.
 *
 * A pair whose labels are whole columns of the same row sees one row of the other
 * view, continued on both sides: its sums and norms are taken once for all labels. */
#include "sweep_state.h"
#include "fix.h"

#include <string.h>

#if PLFX_ZNCC_BY_ROWS

int32_t plfx_zncc_narrow(const plfx_plan *plan)
{
    uint64_t w = plan->cfg.window;
    uint64_t top = w * w * ((1u << plan->cfg.bits) - 1u);

    return top * top < (uint64_t)1 << 33;
}

plfx_whole plfx_zncc_whole(const plfx_plan *plan, int32_t p)
{
    int32_t view = plfx_pair_view(plan, p);
    plfx_whole h = {plfx_zncc_narrow(plan), INT32_MAX, INT32_MIN};
    int32_t l;

    for (l = 0; l < plan->cfg.labels; l++) {
        plfx_shift t = plfx_plan_shift(plan, view, l);
        h.is &= t.fx_q4 == 0 && t.ky == 0 && t.fy_q4 == 0;
        h.least = plfx_min_i32(h.least, t.kx);
        h.most = plfx_max_i32(h.most, t.kx);
    }
    return h;
}

/* ab += sign * a*b */
static void add_products(uint32_t *restrict ab, const uint16_t *restrict a,
                         const uint16_t *restrict b, int32_t n, uint32_t sign)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        ab[i] += sign * ((uint32_t)a[i] * b[i]);
    }
}

static void add_moments(uint32_t *restrict b_col, uint32_t *restrict bb_col,
                        const uint16_t *restrict b, int32_t n, uint32_t sign)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint32_t v = b[i];
        b_col[i] += sign * v;
        bb_col[i] += sign * (v * v);
    }
}

/* Row y of a whole pair enters or leaves. */
void plfx_zncc_row_whole(const plfx_sweep_state *s, int32_t p, int32_t y, uint32_t sign)
{
    const plfx_plan *plan = s->plan;
    plfx_whole h = s->rows->whole[p];
    int32_t nx = plan->nx;
    int32_t view = plfx_pair_view(plan, p);
    size_t at = (size_t)p * plan->cfg.labels * (size_t)nx;
    const uint16_t *row = plfx_ring_row(&s->src, y, view);
    int32_t n = nx + h.most - h.least;
    int32_t i;

    for (i = 0; i < n; i++) {
        s->sample[i] = row[plfx_clamp_i32(i + h.least, 0, nx - 1)];
    }
    add_moments(s->b_col + at, s->bb_col + at, s->sample, n, sign);
    for (i = 0; i < plan->cfg.labels; i++) {
        int32_t k = plfx_plan_shift(plan, view, i).kx - h.least;
        add_products(s->ab_col + at + (size_t)i * (size_t)nx, plfx_ref_row(s, y),
                     s->sample + k, nx, sign);
    }
}

/* next[i] = p[i] + p[i+step], i < n. */
static void fold(const uint32_t *restrict p, uint32_t *restrict next, int32_t step,
                 int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        next[i] = p[i] + p[i + step];
    }
}

static void add(uint32_t *restrict sum, const uint32_t *restrict p, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        sum[i] += p[i];
    }
}

/* sum[i] = col[i] + .. + col[i+w-1], i <= n - w, by powers of two: w is odd. */
static void windows(const plfx_sweep_state *s, const uint32_t *col, uint32_t *sum,
                    int32_t n)
{
    int32_t w = s->plan->cfg.window;
    const uint32_t *p = col;
    int32_t done = 1;
    int32_t step;
    int32_t turn = 0;

    memcpy(sum, col, (size_t)(n - w + 1) * sizeof(uint32_t));
    for (step = 1; 2 * step <= w; step *= 2) { /* at most 4 turns: w <= 31 */
        uint32_t *next = s->rows->half[turn];
        fold(p, next, step, n - 2 * step + 1);
        if (w & (2 * step)) {
            add(sum, next + done, n - w + 1);
            done += 2 * step;
        }
        p = next;
        turn = 1 - turn;
    }
}

/* bb becomes the variance. */
static void variances(const uint32_t *restrict b, uint32_t *restrict bb, int32_t n,
                      uint32_t items)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        bb[i] = items * bb[i] - b[i] * b[i];
    }
}

/* Mantissas and exponents: v = m * 2^(2e), m in [2^28, 2^30); at: table index; v = 0
 * gives m = 0. */
static void normalise(const uint32_t *restrict v, uint32_t *restrict m,
                      int32_t *restrict e, uint32_t *restrict at, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint32_t x = v[i];
        int32_t k = x >= 1u << 30 ? 1 : 0;
        uint32_t top;
        x = x >= 1u << 30 ? x >> 2 : x;
        k = x < 1u << 14 ? k - 8 : k;
        x = x < 1u << 14 ? x << 16 : x;
        k = x < 1u << 22 ? k - 4 : k;
        x = x < 1u << 22 ? x << 8 : x;
        k = x < 1u << 26 ? k - 2 : k;
        x = x < 1u << 26 ? x << 4 : x;
        k = x < 1u << 28 ? k - 1 : k;
        x = x < 1u << 28 ? x << 2 : x;
        top = x > 1u << 28 ? x : 1u << 28;
        m[i] = x;
        e[i] = k;
        at[i] = (top >> 22) - 64u;
    }
}

/* at becomes the table's entry and its fall to the next. */
static void look_up(const uint32_t *restrict steps, uint32_t *restrict at, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        at[i] = steps[at[i]];
    }
}

/* v becomes g, 0 where there is no variance. */
static void mantissas(const uint32_t *restrict m, const uint32_t *restrict step,
                      uint32_t *restrict v, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint32_t f = (m[i] >> 6) & 0xffffu;
        uint32_t g = (step[i] >> 16) - (((step[i] & 0xffffu) * f + 32768u) >> 16);
        v[i] = m[i] ? g : 0u;
    }
}

void plfx_zncc_normalise(const plfx_sweep_state *s, uint32_t *v, int32_t *e, int32_t n)
{
    plfx_zncc_piece *q = s->rows->piece;
    int32_t i;

    for (i = 0; i < n; i += PLFX_ZNCC_PIECE) {
        int32_t k = plfx_min_i32(PLFX_ZNCC_PIECE, n - i);
        normalise(v + i, q->m, e + i, q->step, k);
        look_up(s->rows->steps, q->step, k);
        mantissas(q->m, q->step, v + i, k);
    }
}

/* Sums, mantissas and exponents of the windows of n columns of b. */
static void norms(const plfx_sweep_state *s, size_t at, int32_t n)
{
    uint32_t w = s->plan->cfg.window;
    int32_t count = n - (int32_t)w + 1;

    windows(s, s->b_col + at, s->rows->b_sum, n);
    windows(s, s->bb_col + at, s->rows->b_g, n);
    variances(s->rows->b_sum, s->rows->b_g, count, w * w);
    plfx_zncc_normalise(s, s->rows->b_g, s->rows->b_exp, count);
}

/* |cov| < 2^31 and t < 2^15 in size: no shift loses a bit that counts. */
static void costs(const plfx_sweep_state *s, int32_t shift, int32_t n,
                  uint16_t *restrict out)
{
    uint32_t w = s->plan->cfg.window;
    uint32_t items = w * w;
    const uint32_t *restrict ab = s->rows->ab_sum;
    const uint32_t *restrict a = s->rows->a_low;
    const int32_t *restrict ae = s->rows->a_exp;
    const uint32_t *restrict b = s->rows->b_sum + shift;
    const uint32_t *restrict g = s->rows->b_g + shift;
    const int32_t *restrict be = s->rows->b_exp + shift;
    int32_t i;

    for (i = 0; i < n; i++) {
        int32_t cov = (int32_t)(items * ab[i] - a[i] * b[i]);
        int32_t down = ae[i] + be[i] + 15;
        int32_t right = down > 0 ? down : 0;
        int32_t left = down < 0 ? -down : 0;
        int32_t t = (int32_t)((uint32_t)plfx_asr_i32(cov, right) << left);
        int32_t z = plfx_asr_i32(t * (int32_t)g[i] + 16384, 15);
        out[i] = (uint16_t)(ae[i] == PLFX_ZNCC_FLAT ? 32767 : 32767 - z);
    }
}

void plfx_zncc_cost_narrow(const plfx_sweep_state *s, int32_t p)
{
    const plfx_plan *plan = s->plan;
    plfx_whole h = s->rows->whole[p];
    int32_t nx = plan->nx;
    int32_t r = plan->cfg.window / 2;
    size_t first = (size_t)p * plan->cfg.labels * (size_t)nx;
    int32_t l;

    if (h.is) {
        norms(s, first, nx + h.most - h.least);
    }
    for (l = 0; l < plan->cfg.labels; l++) {
        size_t at = first + (size_t)l * (size_t)nx;
        int32_t shift = 0;
        if (h.is) {
            shift = plfx_plan_shift(plan, plfx_pair_view(plan, p), l).kx - h.least;
        } else {
            norms(s, at, nx);
        }
        windows(s, s->ab_col + at, s->rows->ab_sum, nx);
        costs(s, shift, nx - 2 * r, s->cost + (size_t)l * (size_t)nx + r);
    }
}

void plfx_zncc_start(const plfx_sweep_state *s)
{
    int32_t i;

    for (i = 0; i < 192; i++) {
        uint32_t here = plfx_rsqrt_table[i];
        s->rows->steps[i] = here << 16 | (here - plfx_rsqrt_table[i + 1]);
    }
    for (i = 0; !s->rows->lanes && i < s->pairs; i++) {
        s->rows->whole[i] = plfx_zncc_whole(s->plan, i);
    }
}

#else
typedef int plfx_zncc_no_rows; /* a file is never empty */
#endif
