/* SPDX-License-Identifier: MIT
 * Row kernels that src/simd/ may stand in for: striping, a pair at whole samples, the
 * winners.  Plain loops over lanes that compilers turn into vector code; two labels a
 * turn halve the steps of pointers. */
#include "lanes.h"
#include "fix.h"

#include <string.h>

#if PLFX_KERNELS_C

#if PLFX_LANES >= 8
/* Sixteen blocks into runs of sixteen samples a lane.  Written out lane by lane, so
 * that compilers see a transpose of vectors. */
#define RUN        16
#define FROM_1(i)  run[(i)*RUN + b] = in[b * PLFX_LANES + (i)];
#define FROM_4(i)  FROM_1(i) FROM_1((i) + 1) FROM_1((i) + 2) FROM_1((i) + 3)
#define FROM_8(i)  FROM_4(i) FROM_4((i) + 4)
#define FROM_16(i) FROM_8(i) FROM_8((i) + 8)
#define INTO_1(i)  out[b * PLFX_LANES + (i)] = lin[(i)*blocks + b];
#define INTO_4(i)  INTO_1(i) INTO_1((i) + 1) INTO_1((i) + 2) INTO_1((i) + 3)
#define INTO_8(i)  INTO_4(i) INTO_4((i) + 4)
#define INTO_16(i) INTO_8(i) INTO_8((i) + 8)
#if PLFX_LANES == 8
#define FROM_ALL FROM_8(0)
#define INTO_ALL INTO_8(0)
#elif PLFX_LANES == 16
#define FROM_ALL FROM_16(0)
#define INTO_ALL INTO_16(0)
#else
#define FROM_ALL FROM_16(0) FROM_16(16)
#define INTO_ALL INTO_16(0) INTO_16(16)
#endif

void plfx_k_stripe(const int16_t *restrict lin, int32_t blocks, int16_t *restrict out)
{
    int32_t b;

    for (b = 0; b < blocks; b++) {
        INTO_ALL
    }
}

static void turn(const int16_t *restrict in, int16_t *restrict run)
{
    int32_t b;

    PLFX_LANE_LOOP(b, RUN)
    {
        FROM_ALL
    }
}

static void unstripe_run(const int16_t *in, int32_t blocks, int32_t b, int32_t n,
                         int16_t *out)
{
    int16_t run[PLFX_LANES * RUN];
    int32_t i;

    turn(in + b * PLFX_LANES, run);
    for (i = 0; i < PLFX_LANES; i++) {
        int32_t at = i * blocks + b;
        if (at + RUN <= n) {
            memcpy(out + at, run + i * RUN, RUN * sizeof(int16_t));
        } else if (at < n) {
            memcpy(out + at, run + i * RUN, (size_t)(n - at) * sizeof(int16_t));
        }
    }
}

/* Blocks by runs, the last one over blocks that are done already; the first block
 * left. */
static int32_t unstripe_runs(const int16_t *in, int32_t blocks, int32_t n, int16_t *out)
{
    int32_t b;

    if (blocks < RUN) {
        return 0;
    }
    for (b = 0; b + RUN <= blocks; b += RUN) {
        unstripe_run(in, blocks, b, n, out);
    }
    if (b < blocks) {
        unstripe_run(in, blocks, blocks - RUN, n, out);
    }
    return blocks;
}
#else
void plfx_k_stripe(const int16_t *restrict lin, int32_t blocks, int16_t *restrict out)
{
    int32_t b;
    int32_t i;

    for (b = 0; b < blocks; b++) {
        LANES(i)
        {
            out[b * PLFX_LANES + i] = lin[i * blocks + b];
        }
    }
}

/* NOLINTNEXTLINE(readability-non-const-parameter): the vector twin writes */
static int32_t unstripe_runs(const int16_t *in, int32_t blocks, int32_t n, int16_t *out)
{
    (void)in;
    (void)blocks;
    (void)n;
    (void)out;
    return 0;
}
#endif

void plfx_k_unstripe(const int16_t *restrict in, int32_t blocks, int32_t n,
                     int16_t *restrict out)
{
    int32_t first = unstripe_runs(in, blocks, n, out);
    int32_t i;
    int32_t b;

    for (i = 0; i < PLFX_LANES; i++) {
        int32_t end = plfx_min_i32(blocks, n - i * blocks);
        for (b = first; b < end; b++) {
            out[i * blocks + b] = in[b * PLFX_LANES + i];
        }
    }
}

/* Where the least sum of each lane stands: its first cell, and how many others are as
 * good (negative).  Nothing is copied or cleared: compilers do that in halves of
 * vectors, and whole ones would have to wait for them. */
#if PLFX_LANES > 1
static void find(const int16_t *restrict sum, const int16_t *restrict best,
                 const int16_t *restrict order, int32_t labels, int16_t *restrict at,
                 int16_t *restrict others)
{
    int16_t k[PLFX_LANES]; /* cells to the last, and equal ones so far */
    int16_t n[PLFX_LANES];
    int16_t cells = order[0];
    int32_t l;
    int32_t i;

    LANES(i)
    {
        n[i] = (int16_t)(-(sum[i] == best[i]));
        k[i] = (int16_t)(n[i] & order[i]);
    }
    for (l = 1; l + 1 < labels; l += 2) {
        sum += 2 * PLFX_LANES;
        order += 2 * PLFX_LANES;
        LANES(i)
        {
            int16_t m = (int16_t)(-(sum[i - PLFX_LANES] == best[i]));
            int16_t w = (int16_t)(-(sum[i] == best[i]));
            int16_t t = (int16_t)(m & order[i - PLFX_LANES]);
            int16_t u = (int16_t)(w & order[i]);
            t = t > u ? t : u;
            k[i] = k[i] > t ? k[i] : t;
            n[i] = (int16_t)(n[i] + m + w);
        }
    }
    if (l < labels) {
        LANES(i)
        {
            int16_t m = (int16_t)(-(sum[i + PLFX_LANES] == best[i]));
            int16_t t = (int16_t)(m & order[i + PLFX_LANES]);
            k[i] = k[i] > t ? k[i] : t;
            n[i] = (int16_t)(n[i] + m);
        }
    }
    LANES(i)
    {
        at[i] = (int16_t)(cells - k[i]);
        others[i] = (int16_t)(n[i] + 1);
    }
}
#endif

/* Winner of each lane and the second best.  A new best makes the least of the labels
 * before its neighbour the second; a label right behind the best is its neighbour and
 * does not count.  `before` is the least of all labels but the last one; `won` is -1
 * where the last label became the best. */
static void race_second(const int16_t *restrict sum, const int16_t *restrict order,
                        int32_t labels, int16_t *restrict at, int16_t *restrict second)
{
    int16_t b[PLFX_LANES];
    int16_t k[PLFX_LANES];
    int16_t before[PLFX_LANES];
    int16_t other[PLFX_LANES];
    int16_t won[PLFX_LANES];
    int16_t cells = order[0];
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
            other[i] = (int16_t)((m & before[i]) | (~m & u));
            before[i] = b[i];
            b[i] = v < b[i] ? v : b[i];
            k[i] = (int16_t)((m & t) | (~m & k[i]));
            won[i] = m;
        }
    }
    LANES(i)
    {
        at[i] = (int16_t)(cells - k[i]);
        second[i] = other[i];
    }
}

static void look_beside(const int16_t *restrict sum, plfx_won *restrict w)
{
    int32_t i;

    LANES(i) /* one by one: vectors of single loads cost more */
    {
        const int16_t *s = sum + w->at[i];
        w->next[i] = s[PLFX_LANES];
        w->before[i] = s[-PLFX_LANES];
    }
}

/* The winners by what the slide has left. */
#if PLFX_LANES > 1
static void by_lead(const int16_t *restrict sum, const plfx_lead *lead,
                    const int16_t *restrict order, int32_t labels, plfx_won *restrict w)
{
    (void)lead;
    find(sum, w->best, order, labels, w->at, w->tie);
    look_beside(sum, w);
}

/* From how many others are as good (negative) to ties; one behind makes none. */
static inline void settle(plfx_won *restrict w, int32_t labels)
{
    int16_t last = (int16_t)((labels - 1) * PLFX_LANES);
    int32_t i;

    LANES(i) /* all were written by look_beside() */
    {
        /* NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult) */
        int16_t beside = (int16_t)(-(w->next[i] == w->best[i]) & -(w->at[i] < last));
        w->tie[i] = (int16_t)(-(w->tie[i] < beside));
    }
}
#else
static void by_lead(const int16_t *restrict sum, const plfx_lead *restrict lead,
                    const int16_t *restrict order, int32_t labels, plfx_won *restrict w)
{
    (void)order;
    (void)labels;
    w->at[0] = lead->label;
    w->tie[0] = lead->tie;
    look_beside(sum, w);
}

static inline void settle(plfx_won *w, int32_t labels)
{
    (void)w;
    (void)labels;
}
#endif

static void by_race(const int16_t *restrict sum, const int16_t *restrict order,
                    int32_t labels, const plfx_winners *out, plfx_won *restrict w)
{
    int16_t rest[PLFX_LANES];
    int32_t i;

    race_second(sum, order, labels, w->at, rest);
    LANES(i)
    {
        w->tie[i] = (int16_t)(-2 * (rest[i] == w->best[i]));
    }
    if (out->best) {
        memcpy(out->best, w->best, PLFX_LANES * sizeof(int16_t));
        memcpy(out->rest, rest, sizeof rest);
    } else {
        plfx_won_rate(w->best, rest, out->floor_cost, out->conf);
    }
    look_beside(sum, w);
}

/* Winners of a block before their fit; their sums are known. */
static inline void find_winners(const int16_t *sum, const plfx_lead *lead,
                                const int16_t *order, int32_t labels,
                                const plfx_winners *out, plfx_won *restrict w)
{
    if (out->conf || out->best) {
        by_race(sum, order, labels, out, w);
    } else {
        by_lead(sum, lead, order, labels, w);
    }
}

void plfx_k_select(const int16_t *sum, const plfx_lead *lead, const int16_t *order,
                   int32_t labels, int32_t fit, const plfx_winners *out)
{
    plfx_won w;

    w.best = lead->least;
    find_winners(sum, lead, order, labels, out, &w);
    settle(&w, labels);
    plfx_won_fit(&w, labels, fit, out->code);
}

#if PLFX_LANES == 1
static inline int32_t magnitude(int32_t v)
{
    int32_t sign = -(int32_t)(v < 0);

    return (v ^ sign) - sign;
}

/* One lane: differences, sums and the winner in one loop, in whole registers.  Columns
 * and biased sums are exact in 16 bits, so that nothing is cut.  Steps and shifts that
 * are constants cost no register and no instruction. */
static inline void block_of(const plfx_whole_row *r, const plfx_walker *w, int32_t step,
                            int32_t gone_step, int32_t s1, int32_t s2)
{
    const int16_t *restrict right = w->right;
    const int16_t *restrict gone = w->right_gone;
    uint16_t *restrict col = w->col;
    int16_t *restrict sum = r->sum;
    const uint16_t *restrict leave = w->leave;
    const int16_t *end = sum + r->labels;
    const int16_t *won = sum;
    int32_t here = w->left[0];
    int32_t there = w->left_gone[0];
    int32_t least = INT16_MAX;
    int32_t tie = 0;

    do { /* labels: at most PLFX_LABELS_MAX, one at least */
        int32_t c = *col + (magnitude(here - *right) >> s1);
        int32_t s = *sum;
        c -= magnitude(there - *gone) >> s1;
        s += (c >> s2) - (*leave >> s2);
        *col = (uint16_t)c;
        *sum = (int16_t)s;
        right += step;
        gone += gone_step;
        col++;
        sum++;
        leave++;
        if (s < least) { /* a few times among the labels of a lens */
            least = s;
            won = sum;
            tie = 0;
        } else if (s == least) {
            tie |= sum > won + 1;
        }
    } while (sum < end);
    r->lead->least[0] = (int16_t)least;
    r->lead->label = (int16_t)(won - r->sum - 1);
    r->lead->tie = (int16_t)-tie;
}

/* Labels a column apart and sums exact or cut by 3 bits (12 bits, windows of 9) are the
 * usual case. */
void plfx_k_lane(const plfx_whole_row *r, const plfx_walker *w)
{
    int32_t fine = r->s1 == 0 && r->gone_step == r->step ? r->s2 : -1;

    if (fine == 0 && r->step == 1) {
        block_of(r, w, 1, 1, 0, 0);
    } else if (fine == 0 && r->step == -1) {
        block_of(r, w, -1, -1, 0, 0);
    } else if (fine == 3 && r->step == 1) {
        block_of(r, w, 1, 1, 0, 3);
    } else if (fine == 3 && r->step == -1) {
        block_of(r, w, -1, -1, 0, 3);
    } else {
        block_of(r, w, r->step, r->gone_step, r->s1, r->s2);
    }
}

void plfx_k_whole(const plfx_whole_row *r)
{
    plfx_walk_row(r);
}

#else
/* How finely sums are kept: scaled by s2, and single differences by s1 as well, for
 * windows of 17 lenses and more at 12 bits. */
enum { EXACT, SCALED, COARSE };

/* Factors of s1 and s2. */
typedef struct fine {
    uint16_t k[PLFX_LANES], m[PLFX_LANES];
} fine;

static inline void label_of(uint16_t *restrict col, int16_t *restrict sum,
                            const uint16_t *restrict leave,
                            const int16_t *restrict right, const int16_t *restrict gone,
                            const int16_t *restrict here, const int16_t *restrict there,
                            int16_t *restrict low, int32_t kind, const fine *f,
                            int32_t whole)
{
    int32_t i;

    LANES(i)
    {
        uint16_t in = (uint16_t)plfx_apart(here[i], right[i]);
        uint16_t out = (uint16_t)plfx_apart(there[i], gone[i]);
        uint16_t c;
        uint16_t t = 0;
        int16_t s;
        if (kind == COARSE) {
            in = plfx_scaled(in, f->k[i]);
            out = plfx_scaled(out, f->k[i]);
        }
        c = (uint16_t)(col[i] + in - out);
        if (whole) {
            t = leave[i];
        }
        s = (int16_t)(kind == EXACT
                          ? sum[i] + c - t
                          : sum[i] + plfx_scaled(c, f->m[i]) - plfx_scaled(t, f->m[i]));
        col[i] = c;
        sum[i] = s;
        if (whole) {
            low[i] = s < low[i] ? s : low[i];
        }
    }
}

/* All labels of a block, two a turn; no column leaves and none is least ahead of the
 * first whole window. */
static inline void block_of(const plfx_whole_row *r, const plfx_walker *w, int32_t kind,
                            const fine *f, plfx_lead *lead, int32_t whole)
{
    uint16_t *restrict col = w->col;
    int16_t *restrict sum = r->sum;
    const uint16_t *restrict leave = w->leave;
    const int16_t *restrict right = w->right;
    const int16_t *restrict gone = w->right_gone;
    int16_t here[PLFX_LANES];
    int16_t there[PLFX_LANES];
    int16_t low[PLFX_LANES];
    int32_t l;
    int32_t i;

    LANES(i) /* samples, no mere copies: see plfx_lead_end() */
    {
        here[i] = (int16_t)(w->left[i] & INT16_MAX);
        there[i] = (int16_t)(w->left_gone[i] & INT16_MAX);
    }
    plfx_lead_start(lead, low);
    for (l = 0; l + 1 < r->labels; l += 2) {
        label_of(col, sum, leave, right, gone, here, there, low, kind, f, whole);
        label_of(col + PLFX_LANES, sum + PLFX_LANES, leave + PLFX_LANES,
                 right + r->step, gone + r->gone_step, here, there, low, kind, f,
                 whole);
        col += 2 * PLFX_LANES;
        sum += 2 * PLFX_LANES;
        leave += 2 * PLFX_LANES;
        right += 2 * r->step;
        gone += 2 * r->gone_step;
    }
    if (l < r->labels) {
        label_of(col, sum, leave, right, gone, here, there, low, kind, f, whole);
    }
    if (whole) {
        plfx_lead_end(lead, low, r->sum);
    }
}

/* Where a block's winners find their least sums. */
static inline void led_by(plfx_won *won, const plfx_lead *lead)
{
    won->best = lead->least;
}

static inline void fit_one(const plfx_whole_row *r, plfx_won *won, int16_t *code)
{
    settle(won, r->labels);
    plfx_won_fit(won, r->labels, r->fit, code);
}

/* Winners are fitted a block later: vectors of cells just written one by one would have
 * to wait for them. */
static inline void row(const plfx_whole_row *r, int32_t kind)
{
    const plfx_whole_row k = *r; /* a copy: stores cannot change it */
    const int32_t n = plfx_blocks_of(r);
    const int32_t before = plfx_blocks_before(r);
    plfx_walker w = plfx_walk_start(r);
    plfx_lead lead[2];
    plfx_won won[2];
    fine f;
    int32_t b;

    plfx_factor_of(f.k, k.s1);
    plfx_factor_of(f.m, k.s2);
    led_by(won, lead);
    led_by(won + 1, lead + 1);
    for (b = 0; b < before; b++) {
        block_of(&k, &w, kind, &f, k.lead, 0);
        plfx_walk_on(&k, &w, b);
    }
    for (; b < n; b++) { /* with winners */
        plfx_winners out = plfx_out_of(&k, b);
        plfx_lead *led = lead + (b & 1);
        if (b < k.blocks) {
            block_of(&k, &w, kind, &f, led, 1);
            plfx_walk_on(&k, &w, b);
        } else {
            plfx_slide_on(&k, b, led);
        }
        find_winners(k.sum, led, k.order, k.labels, &out, won + (b & 1));
        if (b > before) {
            fit_one(&k, won + (~b & 1), out.code - PLFX_LANES);
        }
    }
    if (k.out) {
        fit_one(&k, won + (~b & 1), plfx_out_of(&k, b - 1).code);
    }
}

void plfx_k_whole(const plfx_whole_row *r)
{
    if (r->s2 == 0) { /* then s1 is 0 as well */
        row(r, EXACT);
    } else if (r->s1 == 0) {
        row(r, SCALED);
    } else {
        row(r, COARSE);
    }
}
#endif

#else
typedef int plfx_pair_elsewhere; /* a file is never empty */
#endif
