/* SPDX-License-Identifier: MIT
 * Arithmetic of one lane in 16 bits, as the vector units of all targets have it. */
#ifndef PLENOFIX_SRC_LANES_H
#define PLENOFIX_SRC_LANES_H

#include "kernels.h"
#include "scalar.h"

#include <stddef.h>
#include <string.h>

#define LANES(i) PLFX_LANE_LOOP(i, PLFX_LANES)

static inline int16_t plfx_apart(int16_t a, int16_t b)
{
    int16_t hi = a > b ? a : b;
    int16_t lo = a > b ? b : a;

    return (int16_t)(hi - lo);
}

/* c >> s for 1 <= s <= 15 by a product: variable shifts exist for wider lanes only. */
static inline uint16_t plfx_scaled(uint16_t c, uint16_t factor)
{
    return (uint16_t)(((uint32_t)c * factor) >> 16);
}

/* The factor of a shift on every lane: a product with one number for all lanes would be
 * taken for a wide one. */
static inline void plfx_factor_of(uint16_t *m, int32_t shift)
{
    int32_t i;

    LANES(i)
    {
        m[i] = (uint16_t)(65536u >> shift);
    }
}

/* Sum s of label l on lane i against the least so far, low[lane]. */
#if PLFX_LANES > 1
static inline void plfx_lead_meet(plfx_lead *lead, int16_t *low, int32_t i, int16_t s,
                                  int32_t l)
{
    (void)lead;
    (void)l;
    low[i] = s < low[i] ? s : low[i];
}
#else
static inline void plfx_lead_meet(plfx_lead *lead, int16_t *low, int32_t i, int16_t s,
                                  int32_t l)
{
    if (s <= low[i]) { /* seldom, a few times among the labels of a lens */
        if (s < low[i]) {
            lead->label = (int16_t)l;
            lead->tie = 0;
            low[i] = s;
        } else if (l > lead->label + 1) {
            lead->tie = -1;
        }
    }
}
#endif

static inline void plfx_lead_start(plfx_lead *lead, int16_t *low)
{
    int32_t i;

    LANES(i)
    {
        low[i] = INT16_MAX;
    }
#if PLFX_LANES == 1
    lead->label = 0;
    lead->tie = 0;
#else
    (void)lead;
#endif
}

/* `some`: sums of one label, in low already.  A mere copy would be made in halves of
 * vectors, and who reads them whole would have to wait. */
static inline void plfx_lead_end(plfx_lead *lead, const int16_t *low,
                                 const int16_t *some)
{
    int32_t i;

    LANES(i)
    {
        lead->least[i] = low[i] < some[i] ? low[i] : some[i];
    }
}

#if PLFX_LANES <= 2
/* Few lanes divide. */
static inline int16_t plfx_lane_vertex_q4(uint16_t a, uint16_t b, int16_t vee)
{
    return (int16_t)plfx_vertex_q4(a, b, vee);
}

static inline uint16_t plfx_lane_margin(uint16_t best, uint16_t second,
                                        uint16_t floor_cost)
{
    return (uint16_t)plfx_margin_u16(best, second, floor_cost);
}
#else
/* One bit of num/den, num < den < 2^15: where 2*num - den is negative it is the greater
 * number without its sign.  p gathers -1 for every bit that is 0. */
#define PLFX_FIT_STEP(p, num, den)                                                     \
    twice = (uint16_t)((num) + (num));                                                 \
    less = (uint16_t)(twice - (den));                                                  \
    num = less < twice ? less : twice;                                                 \
    p = (int16_t)((p) + (p) - ((num) == twice))

/* Vertex from the rises a (next label) and b (previous), as in select.c; vee is -1 for
 * the equiangular fit, 0 for the parabola.  -8 .. 8 sixteenths. */
static inline int16_t plfx_lane_vertex_q4(uint16_t a, uint16_t b, int16_t vee)
{
    int16_t big = (int16_t)(-((int16_t)((uint16_t)(a | b) >> 14) > 0));
    int16_t x = (int16_t)((big & (a >> 2)) | (~big & a)); /* under 2^14 */
    int16_t y = (int16_t)((big & (b >> 2)) | (~big & b));
    int16_t hi = x > y ? x : y;
    int16_t lo = x > y ? y : x;
    uint16_t den = (uint16_t)(hi + (lo & (int16_t)~vee));
    uint16_t num = (uint16_t)(hi - lo); /* den or less */
    int16_t sign = (int16_t)(-(x > y));
    int16_t whole = (int16_t)(-(num == den));
    int16_t some = (int16_t)(-((int16_t)den > 0));
    int16_t q = 0;
    uint16_t twice;
    uint16_t less;

    num = (uint16_t)(num & ~whole);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den); /* q + 15 sixteenths, and a half: (q + 16) >> 1 */
    q = (int16_t)((q + 16) >> 1);
    q = (int16_t)(((whole & 8) | (~whole & q)) & some);
    return (int16_t)((q ^ sign) - sign);
}

/* (second - best)/(second + floor_cost) in steps of 2^-8, both first cut to a
 * quarter. */
static inline uint16_t plfx_lane_margin(uint16_t best, uint16_t second,
                                        uint16_t floor_cost)
{
    uint16_t low = (uint16_t)((uint16_t)((second & 3u) + (floor_cost & 3u)) >> 2);
    uint16_t num = (uint16_t)((uint16_t)(second - best) >> 2);
    uint16_t den = (uint16_t)((second >> 2) + (floor_cost >> 2) + low);
    int16_t whole = (int16_t)(-(num >= den)); /* then equal: 255 */
    int16_t q = 0;
    uint16_t twice;
    uint16_t less;

    num = (uint16_t)(num & ~whole);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    PLFX_FIT_STEP(q, num, den);
    q = (int16_t)((q + 255) | (whole & 255));
    return (uint16_t)(q << 8);
}

#endif

/* A block on its way along a row of a pair. */
typedef struct plfx_walker {
    uint16_t *col;
    const uint16_t *leave;
    const int16_t *left, *right, *left_gone, *right_gone;
} plfx_walker;

static inline plfx_walker plfx_walk_start(const plfx_whole_row *r)
{
    plfx_walker w = {r->col, r->zero, r->left, r->right, r->left_gone, r->right_gone};

    return w;
}

/* From block b to the next. */
static inline void plfx_walk_on(const plfx_whole_row *r, plfx_walker *w, int32_t b)
{
    ptrdiff_t cells = (ptrdiff_t)r->labels * PLFX_LANES;

    w->col += cells;
    if (b + 1 >= r->window) {
        w->leave = w->col - cells * r->window;
    }
    w->left += PLFX_LANES;
    w->right += PLFX_LANES;
    w->left_gone += r->gone_next;
    w->right_gone += r->gone_next;
}

/* Where winners of block b go, b from window - 1 on. */
static inline plfx_winners plfx_out_of(const plfx_whole_row *r, int32_t b)
{
    ptrdiff_t at = (ptrdiff_t)(b + 1 - r->window) * PLFX_LANES;
    plfx_winners out = *r->out;

    out.code += at;
    out.conf = out.conf ? out.conf + at : NULL;
    return out;
}

/* Blocks to visit: with winners also those a segment on, whose windows reach into the
 * next one.  One lane has no next segment. */
static inline int32_t plfx_blocks_of(const plfx_whole_row *r)
{
    return r->blocks + (r->out && PLFX_LANES > 1 ? r->window - 1 : 0);
}

/* Blocks ahead of the first winners. */
static inline int32_t plfx_blocks_before(const plfx_whole_row *r)
{
    return r->out ? r->window - 1 : r->blocks; /* window: at most blocks */
}

/* Block b, a segment on. */
static inline void plfx_slide_on(const plfx_whole_row *r, int32_t b, plfx_lead *lead)
{
    ptrdiff_t cells = (ptrdiff_t)r->labels * PLFX_LANES;

    plfx_k_slide(r->sum, r->col + (b - r->blocks) * cells + 1,
                 r->col + (b - r->window) * cells, r->labels, r->s2, lead);
}

#if PLFX_LANES <= 2
/* All labels of one block, in a function of its own so that registers suffice. */
void plfx_k_lane(const plfx_whole_row *r, const plfx_walker *w);

static inline void plfx_walk_row(const plfx_whole_row *r)
{
    plfx_walker w = plfx_walk_start(r);
    plfx_winners out = {NULL, NULL, 0, NULL, NULL};
    int32_t b;

    if (r->out) {
        out = *r->out;
    }
    for (b = 0; b < plfx_blocks_of(r); b++) {
        if (b < r->blocks) {
            plfx_k_lane(r, &w);
            plfx_walk_on(r, &w, b);
        } else {
            plfx_slide_on(r, b, r->lead);
        }
        if (out.code && b >= r->window - 1) {
            plfx_k_select(r->sum, r->lead, r->order, r->labels, r->fit, &out);
            out.code += PLFX_LANES;
            out.conf += out.conf ? PLFX_LANES : 0;
        }
    }
}
#endif

/* A winner of each lane: cell, least sum and those beside it. */
typedef struct plfx_won {
    const int16_t *best;
    int16_t at[PLFX_LANES], next[PLFX_LANES], before[PLFX_LANES];
    int16_t tie[PLFX_LANES]; /* -1: another label is as good */
} plfx_won;

/* Codes of the winners. */
static inline void plfx_won_fit(const plfx_won *restrict w, int32_t labels, int32_t fit,
                                int16_t *restrict code)
{
    const int16_t *restrict best = w->best;
    int16_t last = (int16_t)(labels - 1);
    int16_t vee = (int16_t)-fit;
    int32_t i;

    LANES(i)
    {
        /* Every lane has a winner. */
        /* NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult) */
        int16_t l = (int16_t)(w->at[i] >> PLFX_LANE_BITS);
        int16_t inner = (int16_t)(-(l > 0) & -(l < last));
        int16_t f = plfx_lane_vertex_q4((uint16_t)(w->next[i] - best[i]),
                                        (uint16_t)(w->before[i] - best[i]), vee);
        int16_t mark = (int16_t)(w->tie[i] & INT16_MIN);
        code[i] = (int16_t)((int16_t)(32 * l) + (int16_t)(f & inner) + 8 + mark);
    }
}

/* Confidences of the winners over the second best sums. */
static inline void plfx_won_rate(const int16_t *restrict best,
                                 const int16_t *restrict rest, uint16_t floor_cost,
                                 uint16_t *restrict conf)
{
    int32_t i;

    LANES(i)
    {
        conf[i] = plfx_lane_margin((uint16_t)(best[i] + PLFX_BIAS),
                                   (uint16_t)(rest[i] + PLFX_BIAS), floor_cost);
    }
}

#endif
