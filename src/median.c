/* SPDX-License-Identifier: MIT
 * Weighted median of a map.  A neighbour's weight falls with its grey difference d in
 * the reference view: (1 - (d/h)^2)^2, 0 from h on.  The map is brought to 15 bits
 * over its own range; the median is built bit by bit, a chunk of a row at once:
 *   least v with 2 * sum(w[i] : e[i] <= v) >= sum(w).  Edges repeat. */
#include <string.h>

#include "frame_state.h"
#include "arena.h"
#include "fix.h"

#define WINDOW_MAX 7
#define CELLS      (WINDOW_MAX * WINDOW_MAX)
#define CHUNK      64 /* pixels of a row at once */
#define TOP        32767

typedef struct scratch {
    int16_t *value; /* [window][nx + window - 1 + CHUNK] */
    uint16_t *grey; /* likewise */
    size_t wide;
    int32_t window, low, shift; /* value = (e - low) >> shift */
} scratch;

typedef struct chunk {
    int16_t value[CELLS][CHUNK];
    int16_t weight[CELLS][CHUNK]; /* 0 .. 255: 49 of them stay under 2^14 */
    int16_t total[CHUNK], low[CHUNK], high[CHUNK], trial[CHUNK], sum[CHUNK];
} chunk;

static size_t carve(const plfx_frame_state *s, scratch *t, chunk **c, void *base)
{
    plfx_arena a = {base, 0};

    t->wide = (size_t)s->nx + WINDOW_MAX - 1 + CHUNK;
    t->value = plfx_take(&a, WINDOW_MAX * t->wide, sizeof *t->value);
    t->grey = plfx_take(&a, WINDOW_MAX * t->wide, sizeof *t->grey);
    *c = plfx_take(&a, 1, sizeof **c);
    return a.used;
}

size_t plfx_median_scratch(const plfx_frame_state *s)
{
    scratch t;
    chunk *c;

    return carve(s, &t, &c, NULL);
}

static void find_range(const plfx_frame_state *s, scratch *t, const int32_t *in)
{
    size_t n = (size_t)s->nx * (size_t)s->ny;
    int32_t low = in[0];
    int32_t high = in[0];
    size_t i;

    for (i = 0; i < n; i++) {
        low = in[i] < low ? in[i] : low;
        high = in[i] > high ? in[i] : high;
    }
    t->low = low;
    t->shift = 0;
    while (((int64_t)high - low) >> t->shift > TOP) { /* at most 17 times */
        t->shift++;
    }
}

/* Row y of the map and of the reference, ends repeated, into slot y % window. */
static void load_row(const plfx_frame_state *s, const scratch *t, const int32_t *in,
                     int32_t y)
{
    const int32_t *e = in + (size_t)y * (size_t)s->nx;
    const uint16_t *grey = plfx_frame_row(s, s->plan->cfg.ref, y);
    size_t at = (size_t)(y % t->window) * t->wide;
    int32_t r = t->window / 2;
    int32_t x;

    for (x = 0; x < (int32_t)t->wide; x++) {
        int32_t from = plfx_clamp_i32(x - r, 0, s->nx - 1);
        int64_t v = (int64_t)e[from] - t->low;
        t->value[at + (size_t)x] = (int16_t)plfx_asr_i64(v, t->shift);
        t->grey[at + (size_t)x] = grey[from];
    }
}

/* Weights of one neighbour.  u = (d/h)^2 in Q8 from d/h in Q8, both cut at 1. */
static void weigh(const uint16_t *restrict a, const uint16_t *restrict b,
                  uint16_t recip, uint16_t h, int16_t *restrict weight,
                  int16_t *restrict total)
{
    int32_t i;

    for (i = 0; i < CHUNK; i++) {
        int16_t d = (int16_t)(a[i] - b[i]);
        int16_t m = (int16_t)-d;
        uint16_t q;
        uint16_t u;
        d = d > m ? d : m;
        d = d < (int16_t)h ? d : (int16_t)h;
        q = (uint16_t)(((uint32_t)(uint16_t)d * recip) >> 8); /* 0 .. 255 */
        u = (uint16_t)((uint16_t)(q * q) >> 8);
        u = (uint16_t)(255 - u);
        u = (uint16_t)((uint16_t)(u * u) >> 8);
        weight[i] = (int16_t)u;
        total[i] = (int16_t)(total[i] + (int16_t)u);
    }
}

static void spread(const int16_t *restrict v, int16_t *restrict copy,
                   int16_t *restrict low, int16_t *restrict high)
{
    int32_t i;

    for (i = 0; i < CHUNK; i++) {
        copy[i] = v[i];
        low[i] = v[i] < low[i] ? v[i] : low[i];
        high[i] = v[i] > high[i] ? v[i] : high[i];
    }
}

static void fill_chunk(const plfx_frame_state *s, const scratch *t, int32_t x,
                       int32_t y, chunk *c)
{
    int32_t w = t->window;
    uint16_t h = s->cfg.similar_q4;
    uint16_t recip = (uint16_t)(65535u / h);
    const uint16_t *centre = t->grey + (size_t)(y % w) * t->wide + (size_t)(x + w / 2);
    int32_t i;

    /* NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): never a dry run */
    memset(c->total, 0, sizeof c->total);
    for (i = 0; i < CHUNK; i++) {
        c->low[i] = TOP;
        c->high[i] = 0;
    }
    for (i = 0; i < w * w; i++) {
        int32_t yy = plfx_clamp_i32(y + i / w - w / 2, 0, s->ny - 1);
        size_t at = (size_t)(yy % w) * t->wide + (size_t)(x + i % w);
        weigh(t->grey + at, centre, recip, h, c->weight[i], c->total);
        spread(t->value + at, c->value[i], c->low, c->high);
    }
}

static void count(const int16_t *restrict value, const int16_t *restrict weight,
                  const int16_t *restrict trial, int16_t *restrict sum)
{
    int32_t i;

    for (i = 0; i < CHUNK; i++) {
        int16_t in = (int16_t) - (value[i] <= trial[i]);
        sum[i] = (int16_t)(sum[i] + (weight[i] & in));
    }
}

/* Bits that the widest spread of the chunk needs. */
static int32_t bits_of(const chunk *c)
{
    int32_t most = 0;
    int32_t bits = 0;
    int32_t i;

    for (i = 0; i < CHUNK; i++) {
        most = plfx_max_i32(most, c->high[i] - c->low[i]);
    }
    while (most >> bits) { /* at most 15 times */
        bits++;
    }
    return bits;
}

/* Leaves the median in c->low. */
static void median_chunk(chunk *c, int32_t cells)
{
    int32_t bit = bits_of(c);
    int32_t i;

    while (bit-- > 0) { /* at most 15 times */
        int16_t step = (int16_t)(1 << bit);
        for (i = 0; i < CHUNK; i++) {
            int32_t v = c->low[i] + step - 1;
            c->trial[i] = (int16_t)(v < TOP ? v : TOP);
            c->sum[i] = 0;
        }
        for (i = 0; i < cells; i++) {
            count(c->value[i], c->weight[i], c->trial, c->sum);
        }
        for (i = 0; i < CHUNK; i++) {
            int16_t under = (int16_t) - ((int16_t)(2 * c->sum[i]) < c->total[i]);
            c->low[i] = (int16_t)(c->low[i] + (step & under));
        }
    }
}

void plfx_median(const plfx_frame_state *s, int32_t window, const int32_t *in,
                 int32_t *out)
{
    scratch t;
    chunk *c;
    int32_t loaded = 0;
    int32_t x;
    int32_t y;
    int32_t i;

    (void)carve(s, &t, &c, s->scratch);
    t.window = window;
    find_range(s, &t, in);
    for (y = 0; y < s->ny; y++) {
        int32_t *row = out + (size_t)y * (size_t)s->nx;
        for (; loaded < s->ny && loaded <= y + window / 2; loaded++) {
            load_row(s, &t, in, loaded);
        }
        for (x = 0; x < s->nx; x += CHUNK) {
            fill_chunk(s, &t, x, y, c);
            median_chunk(c, window * window);
            for (i = 0; i < plfx_min_i32(CHUNK, s->nx - x); i++) {
                row[x + i] = (c->low[i] * (1 << t.shift)) + t.low;
            }
        }
    }
}
