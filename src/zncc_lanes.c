/* SPDX-License-Identifier: MIT
 * Normalised cross-correlation on striped rows, where every label of every pair
 * is a whole column and 32 bits hold every moment (zncc_rows.c).  The numbers
 * are those of plfx_zncc_cost_of().
 *
 * Columns hold N a b, so that a window's sum less Sa Sb is the covariance; a
 * column changes by the row that enters and the row that leaves at once.  Sums
 * and norms of a view are taken once for all labels: label l reads them k(l)
 * blocks on. */
#include "zncc_lanes.h"
#include "fix.h"
#include "lanes.h"

#include <string.h>

#if PLFX_ZNCC_BY_ROWS

static int32_t blocks_of(const plfx_plan *plan)
{
    return plfx_max_i32((plan->nx + PLFX_LANES - 1) / PLFX_LANES, plan->cfg.window);
}

/* Blocks between the least and the greatest shift of any pair; -1 when one is
 * not whole. */
static int32_t widest(const plfx_plan *plan)
{
    int32_t span = 0;
    int32_t p;

    for (p = 0; p < plan->cfg.n - 1; p++) {
        plfx_whole h = plfx_zncc_whole(plan, p);
        if (!h.is) {
            return -1;
        }
        span = plfx_max_i32(span, h.most - h.least);
    }
    return span;
}

int32_t plfx_zncc_lanes_fit(const plfx_plan *plan)
{
    return plfx_zncc_narrow(plan) && widest(plan) >= 0;
}

static uint32_t *words(plfx_arena *a, int32_t blocks)
{
    return plfx_take(a, (size_t)blocks * PLFX_LANES, sizeof(uint32_t));
}

static void carve_stats(plfx_zncc_lanes *z, plfx_arena *a, plfx_zncc_stats *t,
                        int32_t blocks)
{
    (void)z;
    t->sum = words(a, blocks);
    t->g = words(a, blocks);
    t->exp = (int32_t *)words(a, blocks);
}

static void carve_rows(plfx_zncc_lanes *z, plfx_arena *a, size_t nx)
{
    size_t wide = (size_t)z->blocks * PLFX_LANES;
    size_t cells = (size_t)z->labels * PLFX_LANES;

    z->line = plfx_take(a, wide, sizeof(int16_t));
    z->strip = plfx_take(a, (size_t)z->reach * PLFX_LANES, sizeof(int16_t));
    z->cost = plfx_take(a, cells + 2u * PLFX_LANES, sizeof(int16_t));
    z->cost = z->cost ? z->cost + PLFX_LANES : NULL;
    z->order = plfx_take(a, cells, sizeof(int16_t));
    z->shift = plfx_take(a, (size_t)z->labels, sizeof(int32_t));
    z->lead = plfx_take(a, 1, sizeof(plfx_lead));
    z->code = plfx_take(a, 4u * wide, sizeof(int16_t));
    z->best = plfx_behind(z->code, wide, sizeof(int16_t));
    z->rest = plfx_behind(z->code, 2u * wide, sizeof(int16_t));
    z->lit = plfx_behind(z->code, 3u * wide, sizeof(int16_t));
    z->row.code_row = plfx_take(a, 6u * nx, sizeof(int16_t));
    z->row.conf_row = plfx_behind(z->row.code_row, nx, sizeof(int16_t));
    z->row.no_row = plfx_behind(z->row.code_row, 2u * nx, sizeof(int16_t));
    z->row.lit_row = plfx_behind(z->row.code_row, 3u * nx, sizeof(int16_t));
    z->best_row = plfx_behind(z->row.code_row, 4u * nx, sizeof(int16_t));
    z->rest_row = plfx_behind(z->row.code_row, 5u * nx, sizeof(int16_t));
}

void plfx_zncc_lanes_carve(plfx_zncc_lanes *z, const plfx_plan *plan, plfx_arena *a)
{
    size_t columns;

    z->plan = plan;
    z->labels = plan->cfg.labels;
    z->pairs = plan->cfg.n - 1;
    z->blocks = blocks_of(plan);
    z->reach = z->blocks + widest(plan) + plan->cfg.window;
    columns = (size_t)z->pairs * (size_t)z->blocks * (size_t)z->labels * PLFX_LANES;
    z->col = plfx_take(a, columns + PLFX_LANES, sizeof(uint32_t));
    z->moments = plfx_take(a, 2u * (size_t)(z->pairs + 1) * (size_t)z->reach,
                           PLFX_LANES * sizeof(uint32_t));
    z->sum = plfx_take(a, (size_t)z->labels * PLFX_LANES, sizeof(uint32_t));
    z->zero = plfx_take(a, (size_t)z->labels * PLFX_LANES, sizeof(uint32_t));
    z->left[0] = (int32_t *)words(a, z->reach);
    z->left[1] = (int32_t *)words(a, z->reach);
    z->right[0] = (int32_t *)words(a, z->reach);
    z->right[1] = (int32_t *)words(a, z->reach);
    carve_stats(z, a, &z->a, z->reach);
    carve_stats(z, a, &z->b, z->reach);
    z->lines = plfx_take(a, (size_t)z->pairs, sizeof(plfx_line));
    carve_rows(z, a, (size_t)plan->nx);
}

void plfx_zncc_lanes_start(plfx_zncc_lanes *z)
{
    size_t cells = (size_t)z->labels * PLFX_LANES;
    size_t columns = (size_t)z->pairs * (size_t)z->blocks * cells;
    size_t i;

    memset(z->col, 0, (columns + PLFX_LANES) * sizeof(uint32_t));
    memset(z->moments, 0,
           2u * (size_t)(z->pairs + 1) * (size_t)z->reach * PLFX_LANES *
               sizeof(uint32_t));
    memset(z->zero, 0, cells * sizeof(uint32_t));
    memset(z->cost - PLFX_LANES, 0, (cells + 2u * PLFX_LANES) * sizeof(int16_t));
    for (i = 0; i < cells; i++) {
        z->order[i] = (int16_t)(cells - i);
    }
}

/* A row from column `from` on over n blocks, in 32 bits; NULL: zeros. */
static void lay(plfx_zncc_lanes *z, const uint16_t *row, int32_t from, int32_t n,
                int32_t *restrict out)
{
    int32_t nx = z->plan->nx;
    int32_t wide = z->blocks * PLFX_LANES;
    int32_t first;
    int32_t end;
    int32_t i;
    int32_t b;

    if (!row) {
        memset(out, 0, (size_t)n * PLFX_LANES * sizeof(int32_t));
        return;
    }
    first = plfx_clamp_i32(-from, 0, wide);
    end = plfx_clamp_i32(nx - from, first, wide);
    for (i = 0; i < first; i++) {
        z->line[i] = (int16_t)row[0];
    }
    /* no shift reaches a whole row: end > first */
    memcpy(z->line + first, row + first + from,
           (size_t)(end - first) * sizeof(int16_t));
    for (i = end; i < wide; i++) {
        z->line[i] = (int16_t)row[nx - 1];
    }
    plfx_k_stripe(z->line, z->blocks, z->strip);
    for (b = 0; b < z->blocks * PLFX_LANES; b++) {
        out[b] = z->strip[b];
    }
    for (b = z->blocks; b < n; b++) { /* one segment on: lanes move down by one */
        int32_t *to = out + b * PLFX_LANES;
        int32_t last = b - z->blocks + wide + from; /* of lane PLFX_LANES - 1 */
        memcpy(to, to - wide + 1, (PLFX_LANES - 1) * sizeof(int32_t));
        to[PLFX_LANES - 1] = row[plfx_clamp_i32(last, 0, nx - 1)];
    }
}

/* Columns of samples and squares. */
static void add_moments(uint32_t *restrict s, uint32_t *restrict q,
                        const int32_t *restrict in, const int32_t *restrict out,
                        int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint32_t v = (uint32_t)in[i];
        uint32_t w = (uint32_t)out[i];
        s[i] += v - w;
        q[i] += v * v - w * w;
    }
}

/* Sums of w blocks, of n blocks. */
static void windows(const uint32_t *restrict col, uint32_t *restrict sum, int32_t n,
                    int32_t w)
{
    uint32_t run[PLFX_LANES];
    int32_t b;
    int32_t i;

    memset(run, 0, sizeof run);
    for (b = 0; b < w - 1; b++) {
        LANES(i)
        {
            run[i] += col[b * PLFX_LANES + i];
        }
    }
    for (b = 0; b < n; b++) {
        LANES(i)
        {
            uint32_t s = run[i] + col[(b + w - 1) * PLFX_LANES + i];
            sum[b * PLFX_LANES + i] = s;
            run[i] = s - col[b * PLFX_LANES + i];
        }
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

/* Least exponent; where there is no variance any will do, the covariance is 0.
 */
static int32_t least_of(int32_t *restrict e, const uint32_t *restrict g, int32_t n)
{
    int32_t low = 16;
    int32_t i;

    for (i = 0; i < n; i++) {
        int32_t v = g[i] ? e[i] : 1;
        e[i] = v;
        low = v < low ? v : low;
    }
    return low;
}

/* Window sums, mantissas and exponents of n blocks; the least exponent. */
static int32_t rate(const plfx_sweep_state *s, plfx_zncc_stats *t, const uint32_t *col,
                    int32_t n)
{
    const plfx_zncc_lanes *z = s->rows->lanes;
    int32_t w = z->plan->cfg.window;

    windows(col, t->sum, n, w);
    windows(col + z->reach * PLFX_LANES, t->g, n, w);
    variances(t->sum, t->g, n * PLFX_LANES, (uint32_t)(w * w));
    plfx_zncc_normalise(s, t->g, t->exp, n * PLFX_LANES);
    return least_of(t->exp, t->g, n * PLFX_LANES);
}

/* One block enters: columns and sums of all labels. */
static void add_products(uint32_t *restrict col, uint32_t *restrict sum,
                         const uint32_t *restrict leave, const int32_t *a,
                         const int32_t *a_gone, const int32_t *restrict b,
                         const int32_t *restrict b_gone, const int32_t *restrict shift,
                         int32_t labels)
{
    uint32_t here[PLFX_LANES];
    uint32_t there[PLFX_LANES];
    int32_t l;
    int32_t i;

    memcpy(here, a, sizeof here);
    memcpy(there, a_gone, sizeof there);
    for (l = 0; l < labels; l++) {
        const int32_t *restrict in = b + shift[l];
        const int32_t *restrict out = b_gone + shift[l];
        LANES(i)
        {
            uint32_t c =
                col[i] + here[i] * (uint32_t)in[i] - there[i] * (uint32_t)out[i];
            col[i] = c;
            sum[i] += c - leave[i];
        }
        col += PLFX_LANES;
        sum += PLFX_LANES;
        leave += PLFX_LANES;
    }
}

/* One block behind the last: the columns of the next segment. */
static void slide(uint32_t *restrict sum, const uint32_t *restrict enter,
                  const uint32_t *restrict leave, int32_t n)
{
    int32_t q;

    for (q = 0; q < n; q++) {
        sum[q] += enter[q] - leave[q];
    }
}

/* What the costs of a block read: a's window sum and exponent, b's at label 0.
 */
typedef struct norms {
    const uint32_t *a_sum, *b_sum, *b_g;
    const int32_t *a_exp, *b_exp;
} norms;

/* Costs less 2^15 of one label, exponents together at least 0: |cov| < 2^31, t
 * < 2^15 in size.  Lanes behind the last lens hold any sums: their product wraps, and
 * nobody reads their costs. */
static void cost_label(const uint32_t *restrict sum, const uint32_t *restrict a,
                       const int32_t *restrict e, const uint32_t *restrict b,
                       const uint32_t *restrict g, const int32_t *restrict be,
                       int16_t *restrict out)
{
    int32_t i;

    LANES(i)
    {
        int32_t cov = (int32_t)(sum[i] - a[i] * b[i]);
        int32_t t = plfx_asr_i32(cov, e[i] + be[i]);
        out[i] = (int16_t)~plfx_asr_i32((int32_t)((uint32_t)t * g[i] + 16384u), 15);
    }
}

static void costs(const plfx_zncc_lanes *z, const norms *k, int16_t *restrict out)
{
    uint32_t a[PLFX_LANES];
    int32_t e[PLFX_LANES];
    int16_t low[PLFX_LANES];
    int32_t l;
    int32_t i;

    LANES(i)
    {
        a[i] = k->a_sum[i];
        e[i] = k->a_exp[i] + 15;
    }
    plfx_lead_start(z->lead, low);
    for (l = 0; l < z->labels; l++) {
        int32_t at = z->shift[l];
        cost_label(z->sum + l * PLFX_LANES, a, e, k->b_sum + at, k->b_g + at,
                   k->b_exp + at, out);
        LANES(i)
        {
            low[i] = out[i] < low[i] ? out[i] : low[i];
        }
        out += PLFX_LANES;
    }
    plfx_lead_end(z->lead, low, out - PLFX_LANES);
}

/* The same for any exponents: windows of almost no contrast. */
static void costs_faint(const plfx_zncc_lanes *z, const norms *k, int16_t *restrict out)
{
    int16_t low[PLFX_LANES];
    int32_t l;
    int32_t i;

    plfx_lead_start(z->lead, low);
    for (l = 0; l < z->labels; l++) {
        const uint32_t *restrict sum = z->sum + l * PLFX_LANES;
        int32_t at = z->shift[l];
        LANES(i)
        {
            int32_t cov = (int32_t)(sum[i] - k->a_sum[i] * k->b_sum[at + i]);
            int32_t down = k->a_exp[i] + k->b_exp[at + i] + 15;
            int32_t right = down > 0 ? down : 0;
            int32_t left = down < 0 ? -down : 0;
            int32_t t = (int32_t)((uint32_t)plfx_asr_i32(cov, right) << left);
            int32_t u = (int32_t)((uint32_t)t * k->b_g[at + i] + 16384u);
            int16_t s = (int16_t)~plfx_asr_i32(u, 15);
            out[l * PLFX_LANES + i] = s;
            low[i] = s < low[i] ? s : low[i];
        }
    }
    plfx_lead_end(z->lead, low, out);
}

/* A row of one pair: what enters and leaves, whether winners are wanted. */
typedef struct turn {
    uint32_t *col;
    int32_t emit, rated, faint;
} turn;

static void winners(const plfx_zncc_lanes *z, const turn *t, int32_t b)
{
    int32_t at = (b - z->plan->cfg.window + 1) * PLFX_LANES;
    norms k = {z->a.sum + at, z->b.sum + at, z->b.g + at, z->a.exp + at, z->b.exp + at};
    plfx_winners out = {NULL, NULL, 0, NULL, NULL};

    out.code = z->code + at;
    if (t->rated) {
        out.best = z->best + at;
        out.rest = z->rest + at;
    }
    if (t->faint) {
        costs_faint(z, &k, z->cost);
    } else {
        costs(z, &k, z->cost);
    }
    plfx_k_select(z->cost, z->lead, z->order, z->labels, z->plan->cfg.fit, &out);
}

static void along(const plfx_zncc_lanes *z, const turn *t)
{
    int32_t w = z->plan->cfg.window;
    size_t cells = (size_t)z->labels * PLFX_LANES;
    int32_t b;

    memset(z->sum, 0, cells * sizeof(uint32_t));
    for (b = 0; b < z->blocks; b++) {
        uint32_t *col = t->col + (size_t)b * cells;
        int32_t at = b * PLFX_LANES;
        add_products(col, z->sum, b < w ? z->zero : col - (size_t)w * cells,
                     z->left[0] + at, z->left[1] + at, z->right[0] + at,
                     z->right[1] + at, z->shift, z->labels);
        if (t->emit && b >= w - 1) {
            winners(z, t, b);
        }
    }
    for (b = z->blocks; t->emit && b < z->blocks + w - 1; b++) {
        slide(z->sum, t->col + (size_t)(b - z->blocks) * cells + 1,
              t->col + (size_t)(b - w) * cells, (int32_t)cells);
        winners(z, t, b);
    }
}

/* Confidence and weight from the correlations of the best and the second best.
 */
static void rate_row(const plfx_zncc_lanes *z, uint16_t *restrict weight)
{
    int32_t r = z->plan->cfg.window / 2;
    int32_t end = z->plan->nx - r;
    int32_t i;

    for (i = r; i < end; i++) {
        uint32_t g = z->row.lit_row[i];
        uint32_t best = (uint32_t)(z->best_row[i] + PLFX_BIAS);
        uint32_t rest = (uint32_t)(z->rest_row[i] + PLFX_BIAS);
        int32_t r1 = plfx_correlation_q15(best, g);
        int32_t r2 = plfx_correlation_q15(rest, g);
        uint32_t m =
            plfx_margin_u16((uint32_t)(32768 - r1), (uint32_t)(32768 - r2), 512u);
        z->row.conf_row[i] = (uint16_t)(r1 > 0 ? m : 0u);
        if (weight) {
            weight[i] = (uint16_t)(r1 > 0 ? 2 * r1 : 0);
        }
    }
}

static void collect(const plfx_zncc_lanes *z, const turn *t, int32_t p, int32_t y,
                    const plfx_line *line)
{
    int32_t r = z->plan->cfg.window / 2;
    int32_t n = z->plan->nx - 2 * r;
    int32_t wide = z->blocks * PLFX_LANES;
    plfx_judge judge = z->row;
    /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): a row that is due has one */
    plfx_line out = *line;
    int32_t i;

    for (i = 0; i < wide; i++) {
        z->lit[i] = (int16_t)(uint16_t)z->a.g[i];
    }
    plfx_k_unstripe(z->code, z->blocks, n, z->row.code_row + r);
    plfx_k_unstripe(z->lit, z->blocks, n, (int16_t *)z->row.lit_row + r);
    if (t->rated) {
        plfx_k_unstripe(z->best, z->blocks, n, z->best_row + r);
        plfx_k_unstripe(z->rest, z->blocks, n, z->rest_row + r);
        rate_row(z, line->weight_u16);
    }
    judge.span += p * z->labels;
    out.weight_u16 = NULL;
    plfx_judge_row(&judge, y, t->rated, &out);
}

static const uint16_t *view_row(const plfx_sweep_state *s, int32_t y, int32_t view)
{
    return y < 0 ? NULL : plfx_ring_row(&s->src, y, view);
}

static void run_pair(const plfx_sweep_state *s, int32_t p, int32_t y, int32_t gone,
                     turn *t)
{
    plfx_zncc_lanes *z = s->rows->lanes;
    int32_t view = plfx_pair_view(z->plan, p);
    plfx_whole h = plfx_zncc_whole(z->plan, p);
    int32_t n = z->blocks + h.most - h.least + z->plan->cfg.window - 1;
    uint32_t *col = z->moments + 2 * (p + 1) * z->reach * PLFX_LANES;
    int32_t l;

    for (l = 0; l < z->labels; l++) {
        z->shift[l] = (plfx_plan_shift(z->plan, view, l).kx - h.least) * PLFX_LANES;
    }
    lay(z, view_row(s, y, view), h.least, n, z->right[0]);
    lay(z, view_row(s, gone, view), h.least, n, z->right[1]);
    add_moments(col, col + z->reach * PLFX_LANES, z->right[0], z->right[1],
                n * PLFX_LANES);
    t->col = z->col + (size_t)(p * z->blocks) * (size_t)z->labels * PLFX_LANES;
    if (t->emit) {
        int32_t low = rate(s, &z->b, col, z->blocks + h.most - h.least);
        t->faint = low + z->a_low + 15 < 0;
    }
    along(z, t);
}

void plfx_zncc_lanes_row(const plfx_sweep_state *s, int32_t y, int32_t gone,
                         int32_t target, const plfx_line *lines)
{
    plfx_zncc_lanes *z = s->rows->lanes;
    int32_t w = z->plan->cfg.window;
    int32_t n = z->blocks + w - 1;
    uint32_t *col = z->moments;
    int32_t p;
    turn t = {NULL, lines != NULL, 0, 0};

    lay(z, view_row(s, y, z->plan->cfg.ref), 0, n, z->left[0]);
    lay(z, view_row(s, gone, z->plan->cfg.ref), 0, n, z->left[1]);
    add_moments(col, col + z->reach * PLFX_LANES, z->left[0], z->left[1],
                n * PLFX_LANES);
    for (p = 0; p < n * PLFX_LANES; p++) { /* N a: products become N a b */
        z->left[0][p] *= w * w;
        z->left[1][p] *= w * w;
    }
    if (t.emit) {
        z->a_low = rate(s, &z->a, col, z->blocks);
        t.rated = lines->conf_u16 || z->plan->cfg.unique_u16 > 0;
    }
    for (p = 0; p < z->pairs; p++) {
        run_pair(s, p, y, gone, &t);
        if (t.emit) {
            collect(z, &t, p, target, lines + p);
        }
    }
}

#else
typedef int plfx_zncc_no_lanes; /* a file is never empty */
#endif
