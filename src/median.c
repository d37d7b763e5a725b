/* SPDX-License-Identifier: MIT
 * Weighted median of a map.  A neighbour's weight falls with its grey difference d in
 * the reference view: (1 - (d/h)^2)^2, 0 from h on.  The map is brought to 15 bits
 * over its own range, or that of the labels where winners are all; the median is built
 * bit by bit, a chunk of a row at once:
 *   least v with 2 * sum(w[i] : e[i] <= v) >= sum(w).  Edges repeat. */
#include <string.h>

#include "frame_state.h"
#include "arena.h"
#include "fix.h"

#define CHUNK 64 /* pixels of a row at once */
#define TOP   32767

typedef struct chunk { /* then value and weight of one neighbour after the other */
    int16_t total[CHUNK], low[CHUNK], high[CHUNK], trial[CHUNK], sum[CHUNK];
} chunk;

size_t plfx_median_work(int32_t window)
{
    return sizeof(chunk) + (size_t)(window * window) * 2u * CHUNK * sizeof(int16_t);
}

/* Values of neighbour i; its weights (0 .. 255: 49 of them stay under 2^14) are CHUNK
 * behind. */
static int16_t *value_of(chunk *c, int32_t i)
{
    return (int16_t *)(void *)(c + 1) + (size_t)i * 2u * CHUNK;
}

size_t plfx_median_carve(const plfx_frame_state *s, plfx_median_rows *t, int32_t window,
                         void *base)
{
    plfx_arena a = {base, 0};

    t->window = window;
    t->wide = (size_t)s->nx + (size_t)window - 1 + CHUNK;
    t->value = plfx_take(&a, (size_t)window * t->wide, sizeof *t->value);
    return a.used;
}

size_t plfx_median_scratch(const plfx_frame_state *s)
{
    int32_t window = plfx_max_i32(s->cfg.median1, s->cfg.median2);
    plfx_median_rows t;

    return plfx_median_carve(s, &t, window, NULL) + plfx_median_work(window);
}

static void set_range(plfx_median_rows *t, int32_t low, int32_t high)
{
    t->low = low;
    t->shift = 0;
    while (((int64_t)high - low) >> t->shift > TOP) { /* at most 17 times */
        t->shift++;
    }
}

void plfx_median_of_labels(const plfx_frame_state *s, plfx_median_rows *t)
{
    int32_t first = plfx_plan_slope_q16(s->plan, 0);
    int32_t last = plfx_plan_slope_q16(s->plan, 16 * (s->labels - 1));

    set_range(t, plfx_frame_e_of(s, first), plfx_frame_e_of(s, last));
}

static void find_range(const plfx_frame_state *s, plfx_median_rows *t,
                       const int32_t *in)
{
    size_t n = (size_t)s->nx * (size_t)s->ny;
    int32_t low = in[0];
    int32_t high = in[0];
    size_t i;

    for (i = 0; i < n; i++) {
        low = in[i] < low ? in[i] : low;
        high = in[i] > high ? in[i] : high;
    }
    set_range(t, low, high);
}

/* Ends repeated, into slot y % window. */
void plfx_median_load(const plfx_frame_state *s, const plfx_median_rows *t,
                      const int32_t *e, int32_t y)
{
    size_t at = (size_t)(y % t->window) * t->wide;
    int32_t r = t->window / 2;
    int32_t x;

    for (x = 0; x < (int32_t)t->wide; x++) {
        int32_t from = plfx_clamp_i32(x - r, 0, s->nx - 1);
        int64_t v = (int64_t)e[from] - t->low;
        t->value[at + (size_t)x] = (int16_t)plfx_asr_i64(v, t->shift);
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

static void fill_chunk(const plfx_frame_state *s, const plfx_median_rows *t, int32_t x,
                       int32_t y, chunk *c)
{
    int32_t w = t->window;
    uint16_t h = s->cfg.similar_q4;
    uint16_t recip = (uint16_t)(65535u / h);
    const uint16_t *centre = plfx_frame_line(s, s->plan->cfg.ref, y) + x;
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
        const uint16_t *grey = plfx_frame_line(s, s->plan->cfg.ref, yy) + x;
        weigh(grey + i % w - w / 2, centre, recip, h, value_of(c, i) + CHUNK, c->total);
        spread(t->value + at, value_of(c, i), c->low, c->high);
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
            count(value_of(c, i), value_of(c, i) + CHUNK, c->trial, c->sum);
        }
        for (i = 0; i < CHUNK; i++) {
            int16_t under = (int16_t) - ((int16_t)(2 * c->sum[i]) < c->total[i]);
            c->low[i] = (int16_t)(c->low[i] + (step & under));
        }
    }
}

void plfx_median_row(const plfx_frame_state *s, const plfx_median_rows *t, int32_t y,
                     int32_t *out, void *work)
{
    chunk *c = work;
    int32_t x;
    int32_t i;

    for (x = 0; x < s->nx; x += CHUNK) {
        fill_chunk(s, t, x, y, c);
        median_chunk(c, t->window * t->window);
        for (i = 0; i < plfx_min_i32(CHUNK, s->nx - x); i++) {
            out[x + i] = (c->low[i] * (1 << t->shift)) + t->low;
        }
    }
}

void plfx_median(const plfx_frame_state *s, int32_t window, const int32_t *in,
                 int32_t *out)
{
    unsigned char *work = s->scratch;
    plfx_median_rows t;
    int32_t loaded = 0;
    int32_t y;

    work += plfx_median_carve(s, &t, window, work);
    if (s->cfg.taps) {
        find_range(s, &t, in);
    } else { /* winners alone: their range is known before the frame is */
        plfx_median_of_labels(s, &t);
    }
    for (y = 0; y < s->ny; y++) {
        for (; loaded < s->ny && loaded <= y + window / 2; loaded++) {
            plfx_median_load(s, &t, in + (size_t)loaded * (size_t)s->nx, loaded);
        }
        plfx_median_row(s, &t, y, out + (size_t)y * (size_t)s->nx, work);
    }
}
