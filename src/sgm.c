/* SPDX-License-Identifier: MIT
 * Semi-global aggregation.  Paths from the row above or below run a whole row at once;
 * the two along the row run on a transposed copy, all labels of a pixel at once. */
#include <string.h>

#include "frame_state.h"
#include "arena.h"
#include "fix.h"

#define FAR 16000 /* a cost that never wins; FAR + 255 + P2 < 2^15 */

typedef struct scratch {
    int16_t *path[3][2];  /* [labels + 2][nx + 2], by direction and parity of row */
    int16_t *least[3][2]; /* [nx + 2] least over the labels */
    int16_t *bound;       /* [nx] */
    int16_t *cost_t;      /* [nx][deep] */
    int16_t *sum_t;       /* [nx][deep] */
    int16_t *line;        /* [2][deep + 2 + 6] */
    void *winner;         /* of plfx_winner_row() */
    int32_t deep;         /* labels rounded up to 8 */
} scratch;

static size_t carve(const plfx_frame_state *s, scratch *t, void *base)
{
    plfx_arena a = {base, 0};
    size_t wide = (size_t)s->nx + 2;
    int32_t i;

    t->deep = (s->labels + 7) & ~7;
    for (i = 0; i < 6; i++) {
        t->path[i / 2][i % 2] =
            plfx_take(&a, wide * (size_t)(s->labels + 2), sizeof(int16_t));
        t->least[i / 2][i % 2] = plfx_take(&a, wide, sizeof(int16_t));
    }
    t->bound = plfx_take(&a, wide, sizeof(int16_t));
    t->cost_t = plfx_take(&a, (size_t)s->nx * (size_t)t->deep, sizeof(int16_t));
    t->sum_t = plfx_take(&a, (size_t)s->nx * (size_t)t->deep, sizeof(int16_t));
    t->line = plfx_take(&a, 2 * (size_t)(t->deep + 8), sizeof(int16_t));
    t->winner = plfx_take(&a, plfx_winner_scratch(), 1);
    return a.used;
}

size_t plfx_sgm_scratch(const plfx_frame_state *s)
{
    scratch t;

    return carve(s, &t, NULL);
}

static int16_t penalty(const plfx_frame_state *s, uint16_t a, uint16_t b)
{
    int32_t d = a > b ? a - b : b - a;

    return (int16_t)s->p2_of[d >> 4]; /* 12 bits -> 8-bit levels */
}

/* bound[x] = least of the pixel before + P2'. */
static void bounds(const plfx_frame_state *s, const int16_t *least, int32_t y,
                   int32_t from, int32_t dx, int16_t *bound)
{
    const uint16_t *here = plfx_frame_row(s, s->plan->cfg.ref, y);
    const uint16_t *there = plfx_frame_row(s, s->plan->cfg.ref, from) + dx;
    int32_t x;

    for (x = 0; x < s->nx; x++) {
        bound[x] = (int16_t)(least[x + 1 + dx] + penalty(s, here[x], there[x]));
    }
}

/* One label of one row of a path.  a, b, c: labels below, this, above at the pixel
 * before. */
static void step_label(const int16_t *restrict a, const int16_t *restrict b,
                       const int16_t *restrict c, const int16_t *restrict bound,
                       const int16_t *restrict least, const uint8_t *restrict cost,
                       int16_t p1, int32_t n, int16_t *restrict out,
                       int16_t *restrict out_least, int16_t *restrict sum)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        int16_t v = a[i] < c[i] ? a[i] : c[i];
        v = (int16_t)(v + p1);
        v = v < b[i] ? v : b[i];
        v = v < bound[i] ? v : bound[i];
        v = (int16_t)(v - least[i] + cost[i]);
        out[i] = v;
        out_least[i] = v < out_least[i] ? v : out_least[i];
        sum[i] = (int16_t)(sum[i] + v);
    }
}

/* Direction d (dx = d - 1) of row y, coming from row `from`. */
static void step_row(const plfx_frame_state *s, const scratch *t, int32_t d, int32_t y,
                     int32_t from, int16_t *sum)
{
    size_t wide = (size_t)s->nx + 2;
    const int16_t *before = t->path[d][from & 1] + d; /* column x holds pixel x-1+d */
    const int16_t *least = t->least[d][from & 1];
    int16_t *out = t->path[d][y & 1];
    int16_t *out_least = t->least[d][y & 1];
    const uint8_t *cost = s->volume + (size_t)y * (size_t)s->labels * (size_t)s->nx;
    int32_t l;

    bounds(s, least, y, plfx_clamp_i32(from, 0, s->ny - 1), d - 1, t->bound);
    for (l = 1; l <= s->nx; l++) {
        out_least[l] = INT16_MAX;
    }
    for (l = 0; l < s->labels; l++) {
        const int16_t *b = before + (size_t)(l + 1) * wide;
        step_label(b - wide, b, b + wide, t->bound, least + d,
                   cost + (size_t)l * (size_t)s->nx, (int16_t)s->p1, s->nx,
                   out + (size_t)(l + 1) * wide + 1, out_least + 1,
                   sum + (size_t)l * (size_t)s->nx);
    }
}

/* Rows that stand before the first: no cost at all, so that the first row's is its
 * own. */
static void reset_paths(const plfx_frame_state *s, const scratch *t)
{
    size_t wide = (size_t)s->nx + 2;
    size_t bytes = wide * (size_t)(s->labels + 2) * sizeof(int16_t);
    int32_t i;
    size_t x;

    for (i = 0; i < 6; i++) {
        int16_t *p = t->path[i / 2][i % 2];
        memset(p, 0, bytes);
        memset(t->least[i / 2][i % 2], 0, wide * sizeof(int16_t));
        for (x = 0; x < wide; x++) {
            p[x] = FAR;
            p[x + wide * (size_t)(s->labels + 1)] = FAR;
        }
    }
}

/* A row of costs, labels together; the labels that fill up a lane group never win. */
static void transpose_in(const plfx_frame_state *s, const scratch *t, int32_t y)
{
    const uint8_t *cost = s->volume + (size_t)y * (size_t)s->labels * (size_t)s->nx;
    int32_t x;
    int32_t l;

    for (x = 0; x < s->nx; x++) {
        int16_t *out = t->cost_t + (size_t)x * (size_t)t->deep;
        for (l = 0; l < s->labels; l++) {
            out[l] = cost[(size_t)l * (size_t)s->nx + (size_t)x];
        }
        for (; l < t->deep; l++) {
            out[l] = FAR;
        }
    }
}

static void transpose_add(const plfx_frame_state *s, const scratch *t, int16_t *sum)
{
    int32_t x;
    int32_t l;

    for (x = 0; x < s->nx; x++) {
        const int16_t *in = t->sum_t + (size_t)x * (size_t)t->deep;
        for (l = 0; l < s->labels; l++) {
            sum[(size_t)l * (size_t)s->nx + (size_t)x] = in[l];
        }
    }
}

/* All labels of one pixel; returns the least. */
static int16_t step_pixel(const int16_t *restrict before, const int16_t *restrict cost,
                          int16_t p1, int16_t bound, int16_t least, int32_t deep,
                          int16_t *restrict out, int16_t *restrict sum)
{
    int16_t m = INT16_MAX;
    int32_t l;

    for (l = 0; l < deep; l++) {
        int16_t v = before[l] < before[l + 2] ? before[l] : before[l + 2];
        v = (int16_t)(v + p1);
        v = v < before[l + 1] ? v : before[l + 1];
        v = v < bound ? v : bound;
        v = (int16_t)(v - least + cost[l]);
        out[l + 1] = v;
        m = v < m ? v : m;
        sum[l] = (int16_t)(sum[l] + v);
    }
    return m;
}

/* A path along row y; step 1 from the left, -1 from the right. */
static void along_row(const plfx_frame_state *s, const scratch *t, int32_t y,
                      int32_t step)
{
    const uint16_t *grey = plfx_frame_row(s, s->plan->cfg.ref, y);
    int16_t least = 0;
    int32_t i;

    memset(t->line, 0, 2 * (size_t)(t->deep + 8) * sizeof *t->line);
    for (i = 0; i < 2; i++) {
        t->line[i * (t->deep + 8)] = FAR;
        t->line[i * (t->deep + 8) + t->deep + 1] = FAR;
    }
    for (i = 0; i < s->nx; i++) {
        int32_t x = step > 0 ? i : s->nx - 1 - i;
        int32_t from = i == 0 ? x : x - step;
        int16_t p2 = penalty(s, grey[x], grey[from]);
        least = step_pixel(t->line + ((i + 1) & 1) * (t->deep + 8),
                           t->cost_t + (size_t)x * (size_t)t->deep, (int16_t)s->p1,
                           (int16_t)(least + p2), least, t->deep,
                           t->line + (i & 1) * (t->deep + 8),
                           t->sum_t + (size_t)x * (size_t)t->deep);
    }
}

static int16_t *sum_row(const plfx_frame_state *s, int32_t y)
{
    size_t row = (size_t)s->labels * (size_t)s->nx;

    return s->sum + (s->cfg.paths == 8 ? (size_t)y * row : 0);
}

/* From the top: three paths from above and the two along the row. */
static void downward(const plfx_frame_state *s, const scratch *t, int32_t y)
{
    int16_t *sum = sum_row(s, y);
    int32_t d;

    transpose_in(s, t, y);
    memset(t->sum_t, 0, (size_t)s->nx * (size_t)t->deep * sizeof *t->sum_t);
    along_row(s, t, y, 1);
    along_row(s, t, y, -1);
    transpose_add(s, t, sum);
    for (d = 0; d < 3; d++) {
        step_row(s, t, d, y, y - 1, sum);
    }
}

static void plain(const plfx_frame_state *s, int32_t y)
{
    size_t row = (size_t)s->labels * (size_t)s->nx;
    const uint8_t *cost = s->volume + (size_t)y * row;
    int16_t *sum = sum_row(s, y);
    size_t i;

    for (i = 0; i < row; i++) {
        sum[i] = cost[i];
    }
}

void plfx_sgm(const plfx_frame_state *s)
{
    scratch t;
    int32_t y;
    int32_t d;

    (void)carve(s, &t, s->scratch);
    reset_paths(s, &t);
    for (y = 0; y < s->ny; y++) {
        if (s->cfg.paths == 0) {
            plain(s, y);
        } else {
            downward(s, &t, y);
        }
        if (s->cfg.paths != 8) {
            plfx_winner_row(s, y, sum_row(s, y), t.winner);
        }
    }
    if (s->cfg.paths != 8) {
        return;
    }
    reset_paths(s, &t);
    for (y = s->ny - 1; y >= 0; y--) {
        for (d = 0; d < 3; d++) {
            step_row(s, &t, d, y, y + 1, sum_row(s, y));
        }
        plfx_winner_row(s, y, sum_row(s, y), t.winner);
    }
}
