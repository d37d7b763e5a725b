/* SPDX-License-Identifier: MIT
 * Row kernels with Arm's DSP instructions (Armv7E-M, Cortex-M4 and M7): two lanes of 16
 * bits a word.  Chosen by the build (-Dkernels=dsp); the same bits.  A comparison is a
 * subtraction that sets a flag a lane, a choice the selection by these flags. */
#include "lanes.h"

#if defined(PLFX_KERNELS_DSP)

#include "scalar.h"

#include <arm_acle.h>

#define ONES 0x00010001u

static inline uint32_t get(const void *p)
{
    uint32_t v;

    memcpy(&v, p, sizeof v);
    return v;
}

static inline void put(void *p, uint32_t v)
{
    memcpy(p, &v, sizeof v);
}

/* |a - b| of samples. */
static inline uint32_t apart(uint32_t a, uint32_t b)
{
    uint32_t over = __usub16(a, b);
    uint32_t under = __usub16(b, a);

    return __sel(under, over); /* the flags are those of b >= a */
}

/* Least sums and the first and the last label that has them, counted down from the
 * number of labels to 1. */
typedef struct race {
    uint32_t least, first, last, label;
} race;

static inline race start(int32_t labels)
{
    race r = {0x7fff7fffu, 0, 0, 0};

    r.label = (uint32_t)labels * ONES;
    r.first = r.label;
    r.last = r.label;
    return r;
}

static inline void meet(race *r, uint32_t s)
{
    (void)__ssub16((int16x2_t)s, (int16x2_t)r->least); /* flags: s >= least */
    r->first = __sel(r->first, r->label);
    r->least = __sel(r->least, s);
    (void)__ssub16((int16x2_t)r->least, (int16x2_t)s); /* flags: s is the least */
    r->last = __sel(r->label, r->last);
    r->label -= ONES;
}

static inline void finish(const race *r, int32_t labels, plfx_lead *lead)
{
    uint32_t n = (uint32_t)labels * ONES;

    put(lead->least, r->least);
    put(lead->first, n - r->first);
    put(lead->last, n - r->last);
}

/* v >> s on both lanes; mask: what stays of a lane, twice. */
static inline uint32_t scaled(uint32_t v, int32_t s, uint32_t mask)
{
    return (v >> s) & mask;
}

static inline uint32_t mask_of(int32_t s)
{
    return (0xffffu >> s) * ONES;
}

static inline uint32_t enter(uint16_t *col, uint32_t in, uint32_t out)
{
    uint32_t c = __uadd16(get(col), __usub16(in, out));

    put(col, c);
    return c;
}

static inline void total(int16_t *sum, uint32_t in, uint32_t out, race *r)
{
    uint32_t s = __uadd16(get(sum), __usub16(in, out));

    put(sum, s);
    meet(r, s);
}

/* Steps and shifts known to the compiler cost no register and no instruction. */
static inline void block_of(const plfx_whole_row *row, const plfx_walker *w,
                            int32_t step, int32_t gone_step, int32_t s1, int32_t s2)
{
    race r = start(row->labels);
    /* In memory, one load each: pointers kept there would cost a load and a store. */
    volatile uint32_t here = get(w->left);
    volatile uint32_t there = get(w->left_gone);
    const int16_t *right = w->right;
    const int16_t *gone = w->right_gone;
    const uint16_t *leave = w->leave;
    uint16_t *col = w->col;
    int16_t *sum = row->sum;
    uint32_t m1 = mask_of(s1);
    uint32_t m2 = mask_of(s2);

    __asm__("" : "+r"(m2)); /* in a register: then shift and mask are one instruction */
    do {                    /* labels: at least one */
        uint32_t in = scaled(apart(here, get(right)), s1, m1);
        uint32_t out = scaled(apart(there, get(gone)), s1, m1);
        uint32_t c = enter(col, in, out);
        total(sum, scaled(c, s2, m2), scaled(get(leave), s2, m2), &r);
        right += step;
        gone += gone_step;
        leave += 2;
        col += 2;
        sum += 2;
    } while (r.label != 0);
    finish(&r, row->labels, row->lead);
}

/* Labels a column apart and sums exact or cut by 3 bits (12 bits, windows of 9) are the
 * usual case. */
void plfx_k_lane(const plfx_whole_row *r, const plfx_walker *w)
{
    int32_t fine = r->s1 == 0 && r->gone_step == r->step ? r->s2 : -1;

    if (fine == 0 && r->step == 2) {
        block_of(r, w, 2, 2, 0, 0);
    } else if (fine == 0 && r->step == -2) {
        block_of(r, w, -2, -2, 0, 0);
    } else if (fine == 3 && r->step == 2) {
        block_of(r, w, 2, 2, 0, 3);
    } else if (fine == 3 && r->step == -2) {
        block_of(r, w, -2, -2, 0, 3);
    } else {
        block_of(r, w, r->step, r->gone_step, r->s1, r->s2);
    }
}

void plfx_k_whole(const plfx_whole_row *r)
{
    plfx_walk_row(r);
}

void plfx_k_update(const plfx_update_block *b)
{
    race r = start(b->labels);
    uint32_t mask = mask_of(b->s2);
    int32_t q;

    for (q = 0; q < 2 * b->labels; q += 2) {
        uint32_t c = enter(b->col + q, get(b->item + q), get(b->gone + q));
        total(b->sum + q, scaled(c, b->s2, mask),
              scaled(get(b->leave + q), b->s2, mask), &r);
    }
    finish(&r, b->labels, b->lead);
}

void plfx_k_slide(int16_t *sum, const uint16_t *in, const uint16_t *leave,
                  int32_t labels, int32_t s2, plfx_lead *lead)
{
    race r = start(labels);
    uint32_t mask = mask_of(s2);
    int32_t q;

    for (q = 0; q < 2 * labels; q += 2) {
        total(sum + q, scaled(get(in + q), s2, mask), scaled(get(leave + q), s2, mask),
              &r);
    }
    finish(&r, labels, lead);
}

void plfx_k_stripe(const int16_t *restrict lin, int32_t blocks, int16_t *restrict out)
{
    int32_t b;

    for (b = 0; b < blocks; b++) {
        out[2 * b] = lin[b];
        out[2 * b + 1] = lin[blocks + b];
    }
}

void plfx_k_unstripe(const int16_t *restrict in, int32_t blocks, int32_t n,
                     int16_t *restrict out)
{
    int32_t b;

    for (b = 0; b < blocks; b++) {
        if (b < n) {
            out[b] = in[2 * b];
        }
        if (blocks + b < n) {
            out[blocks + b] = in[2 * b + 1];
        }
    }
}

/* Least sum over the labels that are no neighbours of the winner, one lane. */
static int16_t second_best(const int16_t *sum, int32_t labels, int32_t won)
{
    int16_t rest = INT16_MAX;
    int32_t l;

    for (l = 0; l < labels; l++) {
        if ((l < won - 1 || l > won + 1) && sum[2 * l] < rest) {
            rest = sum[2 * l];
        }
    }
    return rest;
}

void plfx_k_select(const int16_t *sum, const plfx_lead *lead, const int16_t *order,
                   int32_t labels, int32_t fit, const plfx_winners *out)
{
    plfx_won w;
    int16_t rest[2];
    int32_t i;

    (void)order;
    w.best = lead->least;
    for (i = 0; i < 2; i++) {
        int32_t l = lead->first[i];
        const int16_t *s = sum + 2 * l + i;
        w.at[i] = (int16_t)(2 * l + i);
        w.next[i] = s[2];
        w.before[i] = s[-2];
        w.tie[i] = (int16_t)(-(lead->last[i] > l + 1));
        if (out->conf || out->best) {
            rest[i] = second_best(sum + i, labels, l);
            w.tie[i] = (int16_t)(-(rest[i] == w.best[i]));
        }
    }
    if (out->best) {
        memcpy(out->best, w.best, sizeof lead->least);
        memcpy(out->rest, rest, sizeof rest);
    } else if (out->conf) {
        plfx_won_rate(w.best, rest, out->floor_cost, out->conf);
    }
    plfx_won_fit(&w, labels, fit, out->code);
}

#else
typedef int plfx_no_dsp; /* a file is never empty */
#endif
