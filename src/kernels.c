/* SPDX-License-Identifier: MIT
 * Portable row kernels: plain loops over PLFX_LANES lanes that compilers turn into
 * vector code.  A difference is written max - min (no widening); a fraction of a
 * difference as a Q15 product with one rounding (one instruction on most vector
 * units); a choice as a mask.  Loops over lanes must not be peeled away before they
 * are vectorised. */
#include "kernels.h"
#include "fix.h"

#include <string.h>

#define LANES(i) PLFX_LANE_LOOP(i, PLFX_LANES)

static inline int16_t apart(int16_t a, int16_t b)
{
    int16_t hi = a > b ? a : b;
    int16_t lo = a > b ? b : a;

    return (int16_t)(hi - lo);
}

/* a + (b - a)*f/16 rounded half up; f_q15 = f*2^11. */
static inline int16_t mix(int16_t a, int16_t b, int16_t f_q15)
{
    int16_t d = (int16_t)(b - a);

    return (int16_t)(a + (int16_t)(plfx_asr_i32(plfx_asr_i32(d * f_q15, 14) + 1, 1)));
}

void plfx_k_stripe(const int16_t *restrict lin, int32_t blocks, int16_t *restrict out)
{
    int32_t b;
    int32_t i;

    for (b = 0; b + 4 <= blocks; b += 4) {
        LANES(i)
        {
            const int16_t *p = lin + i * blocks + b;
            int16_t *q = out + b * PLFX_LANES + i;
            q[0] = p[0];
            q[PLFX_LANES] = p[1];
            q[2 * PLFX_LANES] = p[2];
            q[3 * PLFX_LANES] = p[3];
        }
    }
    for (; b < blocks; b++) {
        LANES(i)
        {
            out[b * PLFX_LANES + i] = lin[i * blocks + b];
        }
    }
}

void plfx_k_pads(int16_t *row, int32_t blocks, int32_t left, int32_t right,
                 int16_t first, int16_t last)
{
    int32_t t;

    for (t = 0; t < right; t++) { /* the block one segment on: lanes move down by one */
        int16_t *to = row + (blocks + t) * PLFX_LANES;
        memcpy(to, row + t * PLFX_LANES + 1, (PLFX_LANES - 1) * sizeof(int16_t));
        to[PLFX_LANES - 1] = last;
    }
    for (t = 1; t <= left; t++) {
        int16_t *to = row - t * PLFX_LANES;
        memcpy(to + 1, row + (blocks - t) * PLFX_LANES,
               (PLFX_LANES - 1) * sizeof(int16_t));
        to[0] = first;
    }
}

static inline void cost_set(uint16_t *restrict item, const int16_t *restrict c,
                            const int16_t *restrict v, int16_t f)
{
    int32_t i;

    LANES(i)
    {
        item[i] = (uint16_t)apart(c[i], mix(v[i], v[i + PLFX_LANES], f));
    }
}

static inline void cost_add(uint16_t *restrict item, const int16_t *restrict c,
                            const int16_t *restrict v, int16_t f)
{
    int32_t i;

    LANES(i)
    {
        item[i] = (uint16_t)(item[i] + apart(c[i], mix(v[i], v[i + PLFX_LANES], f)));
    }
}

void plfx_k_cost(uint16_t *restrict item, const int16_t *restrict c,
                 const int16_t *restrict base, const plfx_tap *restrict tap,
                 int32_t labels, int32_t first)
{
    int32_t l;

    if (first) {
        for (l = 0; l < labels; l++) {
            cost_set(item + l * PLFX_LANES, c, base + tap[l].off, tap[l].f_q15);
        }
    } else {
        for (l = 0; l < labels; l++) {
            cost_add(item + l * PLFX_LANES, c, base + tap[l].off, tap[l].f_q15);
        }
    }
}

/* Weighted rows in 16 + 4 bits: V <= 4095. */
static inline void cost_rows(uint16_t *restrict item, const int16_t *restrict c,
                             const int16_t *restrict p, const int16_t *restrict q,
                             const plfx_tap *a, const plfx_tap *b)
{
    uint16_t fa = (uint16_t)(a->f_q15 >> 11);
    uint16_t fb = (uint16_t)(b->f_q15 >> 11);
    uint16_t ga = (uint16_t)(16 - fa);
    uint16_t gb = (uint16_t)(16 - fb);
    uint32_t wa = a->w_q4;
    uint32_t wb = b->w_q4;
    int32_t i;

    LANES(i)
    {
        uint16_t u = (uint16_t)((uint16_t)p[i] * ga + (uint16_t)p[i + PLFX_LANES] * fa);
        uint16_t v = (uint16_t)((uint16_t)q[i] * gb + (uint16_t)q[i + PLFX_LANES] * fb);
        int16_t s = (int16_t)((u * wa + v * wb + 128u) >> 8);
        item[i] = (uint16_t)(item[i] + apart(c[i], s));
    }
}

void plfx_k_cost_2d(uint16_t *restrict item, const int16_t *restrict c,
                    const int16_t *restrict base, const plfx_tap *restrict upper,
                    const plfx_tap *restrict lower, int32_t labels, int32_t first)
{
    int32_t l;

    if (first) {
        memset(item, 0, (size_t)labels * PLFX_LANES * sizeof(uint16_t));
    }
    for (l = 0; l < labels; l++) {
        if (lower[l].w_q4 == 0) {
            cost_add(item + l * PLFX_LANES, c, base + upper[l].off, upper[l].f_q15);
        } else {
            cost_rows(item + l * PLFX_LANES, c, base + upper[l].off,
                      base + lower[l].off, upper + l, lower + l);
        }
    }
}

void plfx_k_scale(uint16_t *item, int32_t n, int32_t shift)
{
    int32_t q;

    for (q = 0; q < n; q++) {
        item[q] = (uint16_t)(item[q] >> shift);
    }
}

static void pair_exact(const plfx_pair_block *b, uint16_t *restrict col,
                       int16_t *restrict sum, const uint16_t *restrict leave)
{
    const int16_t *restrict right = b->right;
    const int16_t *restrict gone = b->right_gone;
    int16_t here[PLFX_LANES];
    int16_t there[PLFX_LANES];
    int32_t l;
    int32_t i;

    memcpy(here, b->left, sizeof here);
    memcpy(there, b->left_gone, sizeof there);
    for (l = 0; l < b->labels; l++) {
        LANES(i)
        {
            uint16_t c = (uint16_t)(col[i] + apart(here[i], right[i]) -
                                    apart(there[i], gone[i]));
            col[i] = c;
            sum[i] = (int16_t)(sum[i] + c - leave[i]);
        }
        col += PLFX_LANES;
        sum += PLFX_LANES;
        leave += PLFX_LANES;
        right += b->step;
        gone += b->gone_step;
    }
}

/* c >> s for 1 <= s <= 15 by a product: variable shifts exist for wider lanes only. */
static inline uint16_t scaled(uint16_t c, uint16_t factor)
{
    return (uint16_t)(((uint32_t)c * factor) >> 16);
}

/* The factor of a shift on every lane: a product with one number for all lanes would be
 * taken for a wide one. */
static inline void factor_of(uint16_t *m, int32_t shift)
{
    int32_t i;

    LANES(i)
    {
        m[i] = (uint16_t)(65536u >> shift);
    }
}

static void pair_scaled(const plfx_pair_block *b, uint16_t *restrict col,
                        int16_t *restrict sum, const uint16_t *restrict leave)
{
    const int16_t *restrict right = b->right;
    const int16_t *restrict gone = b->right_gone;
    uint16_t m[PLFX_LANES];
    int16_t here[PLFX_LANES];
    int16_t there[PLFX_LANES];
    int32_t l;
    int32_t i;

    factor_of(m, b->s2);
    memcpy(here, b->left, sizeof here);
    memcpy(there, b->left_gone, sizeof there);
    for (l = 0; l < b->labels; l++) {
        LANES(i)
        {
            uint16_t c = (uint16_t)(col[i] + apart(here[i], right[i]) -
                                    apart(there[i], gone[i]));
            col[i] = c;
            sum[i] = (int16_t)(sum[i] + scaled(c, m[i]) - scaled(leave[i], m[i]));
        }
        col += PLFX_LANES;
        sum += PLFX_LANES;
        leave += PLFX_LANES;
        right += b->step;
        gone += b->gone_step;
    }
}

/* Windows so large that single differences are scaled too: 12 bits, 17 lenses and
 * more. */
static void pair_coarse(const plfx_pair_block *b, uint16_t *restrict col,
                        int16_t *restrict sum, const uint16_t *restrict leave)
{
    const int16_t *restrict right = b->right;
    const int16_t *restrict gone = b->right_gone;
    const int16_t *restrict here = b->left;
    const int16_t *restrict there = b->left_gone;
    uint16_t k[PLFX_LANES];
    uint16_t m[PLFX_LANES];
    int32_t l;
    int32_t i;

    factor_of(k, b->s1);
    factor_of(m, b->s2);
    for (l = 0; l < b->labels; l++) {
        LANES(i)
        {
            uint16_t in = scaled((uint16_t)apart(here[i], right[i]), k[i]);
            uint16_t out = scaled((uint16_t)apart(there[i], gone[i]), k[i]);
            uint16_t c = (uint16_t)(col[i] + in - out);
            col[i] = c;
            sum[i] = (int16_t)(sum[i] + scaled(c, m[i]) - scaled(leave[i], m[i]));
        }
        col += PLFX_LANES;
        sum += PLFX_LANES;
        leave += PLFX_LANES;
        right += b->step;
        gone += b->gone_step;
    }
}

void plfx_k_pair(const plfx_pair_block *b)
{
    if (b->s2 == 0) { /* then s1 is 0 as well */
        pair_exact(b, b->col, b->sum, b->leave);
    } else if (b->s1 == 0) {
        pair_scaled(b, b->col, b->sum, b->leave);
    } else {
        pair_coarse(b, b->col, b->sum, b->leave);
    }
}

static void update_exact(uint16_t *restrict col, int16_t *restrict sum,
                         const uint16_t *restrict item, const uint16_t *restrict gone,
                         const uint16_t *restrict leave, int32_t n)
{
    int32_t q;

    for (q = 0; q < n; q++) {
        uint16_t c = (uint16_t)(col[q] + item[q] - gone[q]);
        col[q] = c;
        sum[q] = (int16_t)(sum[q] + c - leave[q]);
    }
}

static void update_scaled(uint16_t *restrict col, int16_t *restrict sum,
                          const uint16_t *restrict item, const uint16_t *restrict gone,
                          const uint16_t *restrict leave, int32_t n, int32_t s2)
{
    uint16_t m[PLFX_LANES];
    int32_t q;
    int32_t i;

    factor_of(m, s2);
    for (q = 0; q < n; q += PLFX_LANES) {
        LANES(i)
        {
            uint16_t c = (uint16_t)(col[q + i] + item[q + i] - gone[q + i]);
            col[q + i] = c;
            sum[q + i] =
                (int16_t)(sum[q + i] + scaled(c, m[i]) - scaled(leave[q + i], m[i]));
        }
    }
}

void plfx_k_update(uint16_t *col, int16_t *sum, const uint16_t *item,
                   const uint16_t *gone, const uint16_t *leave, int32_t n, int32_t s2)
{
    if (s2 == 0) {
        update_exact(col, sum, item, gone, leave, n);
    } else {
        update_scaled(col, sum, item, gone, leave, n, s2);
    }
}

static void slide_exact(int16_t *restrict sum, const uint16_t *restrict enter,
                        const uint16_t *restrict leave, int32_t n)
{
    int32_t q;

    for (q = 0; q < n; q++) {
        sum[q] = (int16_t)(sum[q] + enter[q] - leave[q]);
    }
}

static void slide_scaled(int16_t *restrict sum, const uint16_t *restrict enter,
                         const uint16_t *restrict leave, int32_t n, int32_t s2)
{
    uint16_t m[PLFX_LANES];
    int32_t q;
    int32_t i;

    factor_of(m, s2);
    for (q = 0; q < n; q += PLFX_LANES) {
        LANES(i)
        {
            sum[q + i] = (int16_t)(sum[q + i] + scaled(enter[q + i], m[i]) -
                                   scaled(leave[q + i], m[i]));
        }
    }
}

void plfx_k_slide(int16_t *sum, const uint16_t *enter, const uint16_t *leave, int32_t n,
                  int32_t s2)
{
    if (s2 == 0) {
        slide_exact(sum, enter, leave, n);
    } else {
        slide_scaled(sum, enter, leave, n, s2);
    }
}

/* Winner of each lane, first on ties; last_at: the last index with the same sum. */
static void race(const int16_t *restrict sum, const int16_t *restrict order,
                 int32_t labels, int16_t *restrict best, int16_t *restrict at,
                 int16_t *restrict last_at)
{
    int16_t b[PLFX_LANES];
    int16_t k[PLFX_LANES];
    int16_t e[PLFX_LANES];
    int32_t l;
    int32_t i;

    memcpy(b, sum, sizeof b);
    memcpy(k, order, sizeof k);
    memcpy(e, order, sizeof e);
    for (l = 1; l < labels; l++) {
        sum += PLFX_LANES;
        order += PLFX_LANES;
        LANES(i)
        {
            int16_t v = sum[i];
            int16_t t = order[i];
            int16_t less = (int16_t)(-(v < b[i]) & t);
            int16_t same = (int16_t)(~-(v > b[i]) & t);
            b[i] = v < b[i] ? v : b[i];
            k[i] = k[i] > less ? k[i] : less;
            e[i] = e[i] > same ? e[i] : same;
        }
    }
    memcpy(best, b, sizeof b);
    memcpy(at, k, sizeof k);
    memcpy(last_at, e, sizeof e);
}

/* Winner of each lane and the second best.  A new best makes the least of the labels
 * before its neighbour the second; a label right behind the best is its neighbour and
 * does not count.  `before` is the least of all labels but the last one; `won` is -1
 * where the last label became the best. */
static void race_second(const int16_t *restrict sum, const int16_t *restrict order,
                        int32_t labels, int16_t *restrict best, int16_t *restrict at,
                        int16_t *restrict second)
{
    int16_t b[PLFX_LANES];
    int16_t k[PLFX_LANES];
    int16_t before[PLFX_LANES];
    int16_t other[PLFX_LANES];
    int16_t won[PLFX_LANES];
    int32_t l;
    int32_t i;

    memcpy(b, sum, sizeof b);
    memcpy(k, order, sizeof k);
    LANES(i)
    {
        before[i] = INT16_MAX;
        other[i] = INT16_MAX;
        won[i] = -1;
    }
    for (l = 1; l < labels; l++) {
        sum += PLFX_LANES;
        order += PLFX_LANES;
        LANES(i)
        {
            int16_t v = sum[i];
            int16_t t = order[i];
            int16_t m = (int16_t)(-(v < b[i]));
            int16_t floor = (int16_t)(won[i] ^ INT16_MIN); /* greatest if beside */
            int16_t c = v > floor ? v : floor;
            int16_t u = other[i] < c ? other[i] : c;
            int16_t less = (int16_t)(m & t);
            other[i] = (int16_t)((m & before[i]) | (~m & u));
            before[i] = b[i];
            b[i] = v < b[i] ? v : b[i];
            k[i] = k[i] > less ? k[i] : less;
            won[i] = m;
        }
    }
    memcpy(best, b, sizeof b);
    memcpy(at, k, sizeof k);
    memcpy(second, other, sizeof other);
}

/* One bit of num/den, num < den < 2^15: num >= den - num is 2*num >= den in 16 bits. */
#define FIT_STEP(m, q, num, den)                                                       \
    m = (int16_t) - ((num) >= (int16_t)((den) - (num)));                               \
    q = (int16_t)(q + q - m);                                                          \
    num = (int16_t)(num + num - (m & (den)))

/* Vertex from the rises a (next label) and b (previous), as in select.c; vee is -1 for
 * the equiangular fit, 0 for the parabola.  -8 .. 8 sixteenths. */
static inline int16_t vertex_q4(uint16_t a, uint16_t b, int16_t vee)
{
    int16_t big = (int16_t)(-((int16_t)((uint16_t)(a | b) >> 14) > 0));
    int16_t x = (int16_t)((big & (a >> 2)) | (~big & a)); /* under 2^14 */
    int16_t y = (int16_t)((big & (b >> 2)) | (~big & b));
    int16_t hi = x > y ? x : y;
    int16_t lo = x > y ? y : x;
    int16_t num = (int16_t)(hi - lo);
    int16_t den = (int16_t)(hi + (lo & (int16_t)~vee));
    int16_t sign = (int16_t)(-(x > y));
    int16_t m = (int16_t)(-(num >= den));
    int16_t q = (int16_t)-m;

    num = (int16_t)(num - (m & den));
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    q = (int16_t)((int16_t)((q + 1) >> 1) & (int16_t)(-(den > 0)));
    return (int16_t)((q ^ sign) - sign);
}

/* (second - best)/(second + floor_cost) in steps of 2^-8, both first cut to a
 * quarter. */
static inline uint16_t margin(uint16_t best, uint16_t second, uint16_t floor_cost)
{
    uint16_t low = (uint16_t)((uint16_t)((second & 3u) + (floor_cost & 3u)) >> 2);
    int16_t num = (int16_t)((uint16_t)(second - best) >> 2);
    int16_t den = (int16_t)((second >> 2) + (floor_cost >> 2) + low);
    int16_t m = (int16_t)(-(num >= den));
    int16_t q = (int16_t)-m;

    num = (int16_t)(num - (m & den));
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    FIT_STEP(m, q, num, den);
    q = q > 255 ? 255 : q;
    return (uint16_t)(q << 8);
}

/* Labels and fractions of the winners, costs beside them taken from sum. */
static void fit_winners(const int16_t *restrict sum, const int16_t *restrict best,
                        const int16_t *restrict at, const int16_t *restrict tie,
                        int16_t last, int16_t vee, int16_t *restrict code)
{
    int16_t next[PLFX_LANES];
    int16_t before[PLFX_LANES];
    int32_t i;

    for (i = 0; i < PLFX_LANES; i++) {
        const int16_t *s = sum + at[i];
        next[i] = s[PLFX_LANES];
        before[i] = s[-PLFX_LANES];
    }
    LANES(i)
    {
        int16_t l = (int16_t)(at[i] >> PLFX_LANE_BITS);
        int16_t inner = (int16_t)(-(l > 0) & -(l < last));
        int16_t f = vertex_q4((uint16_t)(next[i] - best[i]),
                              (uint16_t)(before[i] - best[i]), vee);
        int16_t mark = (int16_t)(tie[i] & INT16_MIN);
        code[i] = (int16_t)((int16_t)(32 * l) + (int16_t)(f & inner) + 8 + mark);
    }
}

void plfx_k_select(const int16_t *sum, const int16_t *order, int32_t labels,
                   int32_t fit, const plfx_winners *out)
{
    int16_t best[PLFX_LANES];
    int16_t at[PLFX_LANES];
    int16_t rest[PLFX_LANES];
    int16_t tie[PLFX_LANES];
    uint16_t *restrict conf = out->conf;
    uint16_t floor_cost = out->floor_cost;
    int32_t i;

    if (conf) {
        race_second(sum, order, labels, best, at, rest);
        LANES(i)
        {
            tie[i] = (int16_t)(-(rest[i] == best[i]));
            conf[i] = margin((uint16_t)(best[i] + PLFX_BIAS),
                             (uint16_t)(rest[i] + PLFX_BIAS), floor_cost);
        }
    } else {
        race(sum, order, labels, best, at, rest);
        LANES(i)
        {
            tie[i] = (int16_t)(-((int16_t)(rest[i] - at[i]) > PLFX_LANES));
        }
    }
    fit_winners(sum, best, at, tie, (int16_t)(labels - 1), (int16_t)-fit, out->code);
}

void plfx_k_unstripe(const int16_t *restrict in, int32_t blocks, int32_t n,
                     int16_t *restrict out)
{
    int32_t i;
    int32_t b;

    for (i = 0; i < PLFX_LANES; i++) {
        int32_t end = plfx_min_i32(blocks, n - i * blocks);
        const int16_t *restrict p = in + i;
        int16_t *restrict q = out + i * blocks;
        for (b = 0; b + 4 <= end; b += 4) {
            q[0] = p[0];
            q[1] = p[PLFX_LANES];
            q[2] = p[2 * PLFX_LANES];
            q[3] = p[3 * PLFX_LANES];
            q += 4;
            p += 4 * PLFX_LANES;
        }
        for (; b < end; b++) {
            *q++ = *p;
            p += PLFX_LANES;
        }
    }
}
