/* SPDX-License-Identifier: MIT
 * The kernels of kernels_pair.c in AVX2: sixteen lanes of 16 bits.  Chosen by the
 * build (-Dkernels=avx2); the same bits. */
#include "lanes.h"

#if defined(PLFX_KERNELS_AVX2)

#include <immintrin.h>
#include <stddef.h>

typedef __m256i lanes16;

/* Once into each variant of a row, so that its constants stay where they are. */
#define ALWAYS static inline __attribute__((always_inline))

/* A value that the compiler must take as it finds it. */
#define HOLD(v) __asm__("" : "+r"(v))

/* Constants in memory: operands, where each made anew takes three instructions. */
#define SIXTEEN(n)                                                                     \
    {                                                                                  \
        n, n, n, n, n, n, n, n, n, n, n, n, n, n, n, n                                 \
    }
static const int16_t constants[][16] = {SIXTEEN(1),      SIXTEEN(8),
                                        SIXTEEN(15),     SIXTEEN(16),
                                        SIXTEEN(-16384), SIXTEEN(INT16_MIN)};
enum { ONE, EIGHT, FIFTEEN, LABEL, HIGH, MARK };
#define CONSTANT(k, name) LOAD((k) + 16 * (name))

#define LOAD(p)     _mm256_loadu_si256((const __m256i *)(const void *)(p))
#define STORE(p, v) _mm256_storeu_si256((__m256i *)(void *)(p), v)
#define ADD(a, b)   _mm256_add_epi16(a, b)
#define SUB(a, b)   _mm256_sub_epi16(a, b)
#define AND(a, b)   _mm256_and_si256(a, b)
#define MIN(a, b)   _mm256_min_epi16(a, b)
#define MAX(a, b)   _mm256_max_epi16(a, b)
#define SAME(a, b)  _mm256_cmpeq_epi16(a, b)
#define OVER(a, b)  _mm256_cmpgt_epi16(a, b)
#define ALL(n)      _mm256_set1_epi16((short)(n))

/* Eight runs of eight samples, `from` apart, into eight vectors, `to` apart. */
static inline void turn_8x8(const int16_t *in, int32_t from, int16_t *out, int32_t to)
{
    __m128i r[8];
    __m128i a[8];
    int32_t i;

#pragma GCC unroll 8
    for (i = 0; i < 8; i++) {
        r[i] = _mm_loadu_si128((const __m128i *)(const void *)(in + i * from));
    }
#pragma GCC unroll 4
    for (i = 0; i < 4; i++) {
        a[2 * i] = _mm_unpacklo_epi16(r[2 * i], r[2 * i + 1]);
        a[2 * i + 1] = _mm_unpackhi_epi16(r[2 * i], r[2 * i + 1]);
    }
#pragma GCC unroll 2
    for (i = 0; i < 2; i++) {
        r[4 * i] = _mm_unpacklo_epi32(a[4 * i], a[4 * i + 2]);
        r[4 * i + 1] = _mm_unpackhi_epi32(a[4 * i], a[4 * i + 2]);
        r[4 * i + 2] = _mm_unpacklo_epi32(a[4 * i + 1], a[4 * i + 3]);
        r[4 * i + 3] = _mm_unpackhi_epi32(a[4 * i + 1], a[4 * i + 3]);
    }
#pragma GCC unroll 4
    for (i = 0; i < 4; i++) {
        __m128i lo = _mm_unpacklo_epi64(r[i], r[i + 4]);
        __m128i hi = _mm_unpackhi_epi64(r[i], r[i + 4]);
        _mm_storeu_si128((__m128i *)(void *)(out + 2 * i * to), lo);
        _mm_storeu_si128((__m128i *)(void *)(out + (2 * i + 1) * to), hi);
    }
}

static void stripe_8(const int16_t *lin, int32_t blocks, int32_t b, int16_t *out)
{
    turn_8x8(lin + b, blocks, out + b * 16, 16);
    turn_8x8(lin + 8 * blocks + b, blocks, out + b * 16 + 8, 16);
}

void plfx_k_stripe(const int16_t *restrict lin, int32_t blocks, int16_t *restrict out)
{
    int32_t b;
    int32_t i;

    for (b = 0; b + 8 <= blocks; b += 8) {
        stripe_8(lin, blocks, b, out);
    }
    if (blocks >= 8) {
        stripe_8(lin, blocks, blocks - 8, out);
        return;
    }
    for (b = 0; b < blocks; b++) {
        for (i = 0; i < 16; i++) {
            out[b * 16 + i] = lin[i * blocks + b];
        }
    }
}

/* Blocks b .. b+7, all of whose samples but those of the last lanes are wanted. */
static void unstripe_8(const int16_t *in, int32_t blocks, int32_t b, int32_t n,
                       int16_t *out)
{
    int16_t run[16 * 8];
    int32_t i;

    turn_8x8(in + b * 16, 16, run, 8);
    turn_8x8(in + b * 16 + 8, 16, run + 64, 8);
    for (i = 0; i < 16; i++) {
        int32_t at = i * blocks + b;
        if (at + 8 <= n) {
            memcpy(out + at, run + i * 8, 8 * sizeof(int16_t));
        } else if (at < n) {
            memcpy(out + at, run + i * 8, (size_t)(n - at) * sizeof(int16_t));
        }
    }
}

void plfx_k_unstripe(const int16_t *restrict in, int32_t blocks, int32_t n,
                     int16_t *restrict out)
{
    int32_t b;
    int32_t i;

    for (b = 0; b + 8 <= blocks; b += 8) {
        if (15 * blocks + b + 8 <= n) {
            turn_8x8(in + b * 16, 16, out + b, blocks);
            turn_8x8(in + b * 16 + 8, 16, out + 8 * blocks + b, blocks);
        } else {
            unstripe_8(in, blocks, b, n, out);
        }
    }
    if (blocks >= 8) {
        unstripe_8(in, blocks, blocks - 8, n, out);
        return;
    }
    for (i = 0; i < 16; i++) {
        for (b = 0; b < blocks && i * blocks + b < n; b++) {
            out[i * blocks + b] = in[b * 16 + i];
        }
    }
}

ALWAYS lanes16 apart(lanes16 a, const int16_t *b)
{
    return _mm256_abs_epi16(SUB(a, LOAD(b))); /* samples: 12 bits, no overflow */
}

/* Least sums of a block, where they stand (cells), and those beside them. */
typedef struct trio {
    lanes16 at, best, next, before;
} trio;

/* Sums at 16 cells, each with a sample of a neighbouring lane: the even lanes with the
 * next one's, the odd ones with the one's before.  Extracts and inserts would share one
 * port of Intel's cores; on AMD's Zen 3 they would be the quicker way. */
ALWAYS lanes16 gather(const int16_t *sum, lanes16 even, lanes16 odd)
{
    const int *lo = (const int *)(const void *)sum;
    const int *hi = (const int *)(const void *)(sum - 1);

    return _mm256_blend_epi16(_mm256_i32gather_epi32(lo, even, 2),
                              _mm256_i32gather_epi32(hi, odd, 2), 0xaa);
}

ALWAYS trio look_beside(const int16_t *sum, lanes16 best, lanes16 at)
{
    lanes16 even = AND(at, _mm256_set1_epi32(0xffff));
    lanes16 odd = _mm256_srli_epi32(at, 16);
    trio t;

    t.at = at;
    t.best = best;
    t.next = gather(sum + 16, even, odd);
    t.before = gather(sum - 16, even, odd);
    return t;
}

/* Where the least sums stand: cells from the first of them to the last cell of all,
 * and how many there are (negative).  Eight labels a turn. */
ALWAYS lanes16 find(const int16_t *sum, lanes16 b, const int16_t *order, ptrdiff_t n,
                    lanes16 *count)
{
    const int16_t *end = sum + n;
    lanes16 k = _mm256_setzero_si256();
    lanes16 c = _mm256_setzero_si256();

#define FIND(q)                                                                        \
    lanes16 m##q = SAME(b, LOAD(sum + (q)*16));                                        \
    lanes16 t##q = AND(m##q, LOAD(order + (q)*16))
    while (end - sum >= 8 * 16) {
        FIND(0);
        FIND(1);
        FIND(2);
        FIND(3);
        FIND(4);
        FIND(5);
        FIND(6);
        FIND(7);
        k = MAX(k, MAX(MAX(MAX(t0, t1), MAX(t2, t3)), MAX(MAX(t4, t5), MAX(t6, t7))));
        c = ADD(c, ADD(ADD(ADD(m0, m1), ADD(m2, m3)), ADD(ADD(m4, m5), ADD(m6, m7))));
        sum += 8 * 16;
        order += 8 * 16;
    }
    while (sum < end) {
        FIND(0);
        k = MAX(k, t0);
        c = ADD(c, m0);
        sum += 16;
        order += 16;
    }
    *count = c;
    return k;
}

/* Least over the labels that are no neighbours of the winner. */
static inline lanes16 second_best(const int16_t *sum, const int16_t *order, ptrdiff_t n,
                                  lanes16 left)
{
    lanes16 rest = ALL(INT16_MAX);
    ptrdiff_t at;

    for (at = 0; at < n; at += 16) {
        lanes16 away = _mm256_abs_epi16(SUB(LOAD(order + at), left));
        lanes16 beside = OVER(ALL(17), away); /* a label is 16 cells */
        lanes16 least = SUB(beside, ALL(INT16_MIN));
        rest = MIN(rest, MAX(LOAD(sum + at), least));
    }
    return rest;
}

/* One bit of num/den as PLFX_FIT_STEP() of lanes.h finds it. */
#define BIT(q, num, den)                                                               \
    twice = ADD(num, num);                                                             \
    num = _mm256_min_epu16(SUB(twice, den), twice);                                    \
    q = ADD(ADD(q, q), SAME(num, twice))

/* plfx_lane_vertex_q4(): 8*(next - before) over the rise, sixteenths. */
ALWAYS lanes16 vertex(trio t, lanes16 vee, const int16_t *k)
{
    lanes16 x = SUB(t.next, t.best);
    lanes16 y = SUB(t.before, t.best);
    lanes16 high = _mm256_or_si256(x, y);
    lanes16 num;
    lanes16 den;
    lanes16 twice;
    lanes16 q;

    if (!_mm256_testz_si256(high, CONSTANT(k, HIGH))) { /* seldom */
        lanes16 big = OVER(_mm256_srli_epi16(high, 14), _mm256_setzero_si256());
        x = _mm256_blendv_epi8(x, _mm256_srli_epi16(x, 2), big);
        y = _mm256_blendv_epi8(y, _mm256_srli_epi16(y, 2), big);
    }
    den = ADD(MAX(x, y), _mm256_andnot_si256(vee, MIN(x, y))); /* x, y under 2^14 */
    x = SUB(y, x);
    num = _mm256_abs_epi16(x);
    twice = ADD(num, num);
    num = _mm256_min_epu16(SUB(twice, den), twice);
    q = SAME(num, twice);
    BIT(q, num, den);
    BIT(q, num, den);
    BIT(q, num, den);
    q = _mm256_srai_epi16(ADD(q, CONSTANT(k, LABEL)), 1);
    return _mm256_sign_epi16(q, x);
}

/* Codes as plfx_won_fit() writes them; tie: the mark of kernels.h on lanes of ones. */
ALWAYS void store_codes(trio t, lanes16 tie, int32_t labels, int32_t fit, int16_t *code,
                        const int16_t *k)
{
    lanes16 f = vertex(t, ALL(-fit), k);
    lanes16 l = _mm256_slli_epi16(_mm256_srli_epi16(t.at, 4), 5);

    f = AND(f,
            AND(OVER(t.at, CONSTANT(k, FIFTEEN)), OVER(ALL(16 * (labels - 1)), t.at)));
    f = ADD(ADD(f, l), CONSTANT(k, EIGHT)); /* under 2^14 */
    STORE(code, _mm256_or_si256(f, AND(tie, CONSTANT(k, MARK))));
}

/* Confidences, or the two sums; ones where the second is as good. */
static lanes16 rate(const int16_t *sum, const int16_t *order, ptrdiff_t n, lanes16 best,
                    lanes16 left, const plfx_winners *out)
{
    lanes16 second = second_best(sum, order, n, left);

    if (out->best) {
        STORE(out->best, best);
        STORE(out->rest, second);
    } else {
        int16_t first[16];
        int16_t rest[16];
        STORE(first, best);
        STORE(rest, second);
        plfx_won_rate(first, rest, out->floor_cost, out->conf);
    }
    return SAME(second, best);
}

ALWAYS void select_lanes(const int16_t *sum, lanes16 best, const int16_t *order,
                         int32_t labels, int32_t fit, const plfx_winners *out)
{
    const int16_t *k = constants[0];
    ptrdiff_t n = (ptrdiff_t)labels * 16;
    lanes16 count;
    lanes16 left = find(sum, best, order, n, &count);
    trio t = look_beside(sum, best, SUB(ALL(n), left));
    lanes16 tie;

    HOLD(k);
    if (out->conf || out->best) {
        tie = rate(sum, order, n, best, left, out);
    } else { /* a neighbour behind that is as good makes no tie */
        lanes16 beside = AND(SAME(t.next, best), OVER(left, CONSTANT(k, LABEL)));
        tie = OVER(beside, ADD(count, CONSTANT(k, ONE)));
    }
    store_codes(t, tie, labels, fit, out->code, k);
}

void plfx_k_select(const int16_t *sum, const plfx_lead *lead, const int16_t *order,
                   int32_t labels, int32_t fit, const plfx_winners *out)
{
    select_lanes(sum, LOAD(lead->least), order, labels, fit, out);
}

/* How finely sums are kept: scaled by s2, and single differences by s1 as well. */
enum { EXACT, SCALED, COARSE };

/* Factors of 2^(16 - s): their products' upper halves are shifts, which by a variable
 * would take two ports each. */
typedef struct fine {
    lanes16 k1, k2;
} fine;
#define SCALE(v, k) _mm256_mulhi_epu16(v, k)

/* One label: differences `in` enter and `out` leave; the new sum.  No column leaves
 * (NULL) ahead of the first whole window. */
ALWAYS lanes16 label(uint16_t *col, int16_t *sum, const uint16_t *leave, lanes16 in,
                     lanes16 out, int32_t kind, fine f)
{
    lanes16 c;
    lanes16 s;

    if (kind == COARSE) {
        in = SCALE(in, f.k1);
        out = SCALE(out, f.k1);
    }
    c = ADD(SUB(in, out), LOAD(col));
    s = kind == EXACT ? c : SCALE(c, f.k2);
    if (leave) {
        lanes16 t = LOAD(leave);
        s = SUB(s, kind == EXACT ? t : SCALE(t, f.k2));
    }
    s = ADD(s, LOAD(sum));
    STORE(col, c);
    STORE(sum, s);
    return s;
}

/* One label whose columns are up to date; the new sum. */
ALWAYS lanes16 slide_label(int16_t *sum, const uint16_t *in, const uint16_t *out,
                           int32_t kind, fine f)
{
    lanes16 c = LOAD(in);
    lanes16 t = LOAD(out);
    lanes16 s;

    if (kind != EXACT) {
        c = SCALE(c, f.k2);
        t = SCALE(t, f.k2);
    }
    s = ADD(SUB(c, t), LOAD(sum));
    STORE(sum, s);
    return s;
}

/* All labels of a block, eight a turn; the least sums, of whole windows.  Both views
 * move by `step`, 16 or -16, or as r says where it is 0. */
ALWAYS lanes16 block(const plfx_whole_row *r, const plfx_walker *w, ptrdiff_t step,
                     int32_t kind, fine f, int32_t whole)
{
    const uint16_t *end = w->col + (ptrdiff_t)r->labels * 16;
    const ptrdiff_t up = step ? step : r->step;
    const ptrdiff_t gone_up = step ? step : r->gone_step;
    const lanes16 here = LOAD(w->left);
    const lanes16 there = LOAD(w->left_gone);
    const int16_t *right = w->right;
    const int16_t *gone = w->right_gone;
    const uint16_t *leave = w->leave;
    uint16_t *col = w->col;
    int16_t *sum = r->sum;
    lanes16 low = ALL(INT16_MAX);

#define TAKE(q)                                                                        \
    label(col + (q)*16, sum + (q)*16, whole ? leave + (q)*16 : NULL,                   \
          apart(here, right + (q)*up), apart(there, gone + (q)*gone_up), kind, f)
#define STEP(labels)                                                                   \
    col += (labels)*16;                                                                \
    sum += (labels)*16;                                                                \
    leave += (labels)*16;                                                              \
    right += (labels)*up;                                                              \
    gone += (labels)*gone_up;                                                          \
    HOLD(right);                                                                       \
    HOLD(gone)
    while (end - col >= 8 * 16) {
        lanes16 a = MIN(TAKE(0), TAKE(1));
        lanes16 b = MIN(TAKE(2), TAKE(3));
        low = MIN(low, MIN(a, b));
        a = MIN(TAKE(4), TAKE(5));
        b = MIN(TAKE(6), TAKE(7));
        low = MIN(low, MIN(a, b));
        STEP(8);
    }
    while (col < end) {
        low = MIN(low, TAKE(0));
        STEP(1);
    }
    return low;
}

/* Block b, a segment on: the least sums. */
ALWAYS lanes16 slide(const plfx_whole_row *r, int32_t b, int32_t kind, fine f)
{
    const ptrdiff_t cells = (ptrdiff_t)r->labels * 16;
    const uint16_t *in = r->col + (b - r->blocks) * cells + 1;
    const uint16_t *out = r->col + (b - r->window) * cells;
    int16_t *sum = r->sum;
    const int16_t *end = sum + cells;
    lanes16 low = ALL(INT16_MAX);

#define MOVE(q) slide_label(sum + (q)*16, in + (q)*16, out + (q)*16, kind, f)
    while (end - sum >= 8 * 16) {
        lanes16 a = MIN(MOVE(0), MOVE(1));
        lanes16 c = MIN(MOVE(2), MOVE(3));
        low = MIN(low, MIN(a, c));
        a = MIN(MOVE(4), MOVE(5));
        c = MIN(MOVE(6), MOVE(7));
        low = MIN(low, MIN(a, c));
        sum += 8 * 16;
        in += 8 * 16;
        out += 8 * 16;
    }
    while (sum < end) {
        low = MIN(low, MOVE(0));
        sum += 16;
        in += 16;
        out += 16;
    }
    return low;
}

ALWAYS void row(const plfx_whole_row *r, int32_t kind, ptrdiff_t step)
{
    const plfx_whole_row k = *r; /* a copy: stores cannot change it */
    const fine f = {ALL(65536 >> k.s1), ALL(65536 >> k.s2)}; /* used where s > 0 */
    const int32_t n = plfx_blocks_of(r);
    const int32_t before = plfx_blocks_before(r);
    plfx_walker w = plfx_walk_start(r);
    int32_t b;

    for (b = 0; b < before; b++) {
        (void)block(&k, &w, step, kind, f, 0);
        plfx_walk_on(&k, &w, b);
    }
    for (; b < n; b++) { /* with winners */
        lanes16 low;
        plfx_winners out;
        if (b < k.blocks) {
            low = block(&k, &w, step, kind, f, 1);
            plfx_walk_on(&k, &w, b);
        } else {
            low = slide(&k, b, kind, f);
        }
        out = plfx_out_of(&k, b);
        select_lanes(k.sum, low, k.order, k.labels, k.fit, &out);
    }
}

/* Labels one column apart, the usual case, know their steps. */
#define BY_STEP(name, kind)                                                            \
    static void name(const plfx_whole_row *r)                                          \
    {                                                                                  \
        if (r->step == 16 && r->gone_step == 16) {                                     \
            row(r, kind, 16);                                                          \
        } else if (r->step == -16 && r->gone_step == -16) {                            \
            row(r, kind, -16);                                                         \
        } else {                                                                       \
            row(r, kind, 0);                                                           \
        }                                                                              \
    }
BY_STEP(row_exact, EXACT)
BY_STEP(row_scaled, SCALED)

static void row_coarse(const plfx_whole_row *r)
{
    row(r, COARSE, 0);
}

void plfx_k_whole(const plfx_whole_row *r)
{
    if (r->s2 == 0) { /* then s1 is 0 as well */
        row_exact(r);
    } else if (r->s1 == 0) {
        row_scaled(r);
    } else {
        row_coarse(r);
    }
}

#else
typedef int plfx_no_avx2; /* a file is never empty */
#endif
