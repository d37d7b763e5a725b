/* SPDX-License-Identifier: MIT
 * The kernels of kernels_pair.c in AVX2: sixteen lanes of 16 bits.  Chosen by the
 * build (-Dkernels=avx2); the same bits. */
#include "lanes.h"

#if defined(PLFX_KERNELS_AVX2)

#include <immintrin.h>
#include <stddef.h>

typedef __m256i lanes16;

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

static inline lanes16 apart(lanes16 a, const int16_t *b)
{
    return _mm256_abs_epi16(SUB(a, LOAD(b))); /* samples: 12 bits, no overflow */
}

/* One label: differences `in` enter and `out` leave; the new sum. */
static inline lanes16 label_exact(uint16_t *col, int16_t *sum, const uint16_t *leave,
                                  lanes16 in, lanes16 out)
{
    lanes16 c = ADD(SUB(in, out), LOAD(col));
    lanes16 s = ADD(SUB(c, LOAD(leave)), LOAD(sum));

    STORE(col, c);
    STORE(sum, s);
    return s;
}

static inline lanes16 label_scaled(uint16_t *col, int16_t *sum, const uint16_t *leave,
                                   lanes16 in, lanes16 out, __m128i s2)
{
    lanes16 c = ADD(SUB(in, out), LOAD(col));
    lanes16 s =
        ADD(SUB(_mm256_srl_epi16(c, s2), _mm256_srl_epi16(LOAD(leave), s2)), LOAD(sum));

    STORE(col, c);
    STORE(sum, s);
    return s;
}

static inline lanes16 label_coarse(uint16_t *col, int16_t *sum, const uint16_t *leave,
                                   lanes16 in, lanes16 out, __m128i s2, __m128i s1)
{
    lanes16 c =
        ADD(SUB(_mm256_srl_epi16(in, s1), _mm256_srl_epi16(out, s1)), LOAD(col));
    lanes16 s =
        ADD(SUB(_mm256_srl_epi16(c, s2), _mm256_srl_epi16(LOAD(leave), s2)), LOAD(sum));

    STORE(col, c);
    STORE(sum, s);
    return s;
}

/* The same walk along the labels for each of the three, two labels a turn. */
#define WALK(ONE)                                                                      \
    const ptrdiff_t step = b->step; /* copies: stores cannot change them */            \
    const ptrdiff_t gone_step = b->gone_step;                                          \
    const int16_t *right = b->right;                                                   \
    const int16_t *gone = b->right_gone;                                               \
    const uint16_t *leave = b->leave;                                                  \
    uint16_t *col = b->col;                                                            \
    int16_t *sum = b->sum;                                                             \
    const lanes16 here = LOAD(b->left);                                                \
    const lanes16 there = LOAD(b->left_gone);                                          \
    lanes16 low = ALL(INT16_MAX);                                                      \
    const ptrdiff_t n = (ptrdiff_t)b->labels * 16;                                     \
    ptrdiff_t at;                                                                      \
    for (at = 0; at + 16 < n; at += 32) {                                              \
        lanes16 s = ONE(at, right, gone);                                              \
        lanes16 t = ONE(at + 16, right + step, gone + gone_step);                      \
        low = MIN(low, MIN(s, t));                                                     \
        right += 2 * step;                                                             \
        gone += 2 * gone_step;                                                         \
    }                                                                                  \
    if (at < n) {                                                                      \
        low = MIN(low, ONE(at, right, gone));                                          \
    }                                                                                  \
    STORE(b->lead->least, low)
#define AT(at)     col + (at), sum + (at), leave + (at)
#define BOTH(r, g) apart(here, r), apart(there, g)

static void pair_exact(const plfx_pair_block *b)
{
#define EXACT(at, r, g) label_exact(AT(at), BOTH(r, g))
    WALK(EXACT);
}

static void pair_scaled(const plfx_pair_block *b)
{
#define SCALED(at, r, g) label_scaled(AT(at), BOTH(r, g), s2)
    const __m128i s2 = _mm_cvtsi32_si128(b->s2);
    WALK(SCALED);
}

static void pair_coarse(const plfx_pair_block *b)
{
#define COARSE(at, r, g) label_coarse(AT(at), BOTH(r, g), s2, s1)
    const __m128i s2 = _mm_cvtsi32_si128(b->s2);
    const __m128i s1 = _mm_cvtsi32_si128(b->s1);
    WALK(COARSE);
}

void plfx_k_pair(const plfx_pair_block *b)
{
    if (b->s2 == 0) { /* then s1 is 0 as well */
        pair_exact(b);
    } else if (b->s1 == 0) {
        pair_scaled(b);
    } else {
        pair_coarse(b);
    }
}

/* 16-bit cells at eight offsets by loads of 32 bits, of which the upper (shift 16) or
 * the lower half counts: none of them leaves the sums and their two spare labels. */
static inline __m256i gathered(const int16_t *base, __m256i at, int32_t shift)
{
    __m256i v = _mm256_i32gather_epi32((const int *)(const void *)base, at, 2);

    return _mm256_srli_epi32(_mm256_slli_epi32(v, 16 - shift), 16);
}

static inline void look_beside(const int16_t *sum, lanes16 at, plfx_won *w)
{
    __m256i zero = _mm256_setzero_si256();
    __m256i lo = _mm256_unpacklo_epi16(at, zero); /* at < 2^15 */
    __m256i hi = _mm256_unpackhi_epi16(at, zero);

    STORE(w->at, at);
    STORE(w->next,
          _mm256_packus_epi32(gathered(sum + 15, lo, 16), gathered(sum + 15, hi, 16)));
    STORE(w->before,
          _mm256_packus_epi32(gathered(sum - 16, lo, 0), gathered(sum - 16, hi, 0)));
}

/* Where the least sums stand: cells from the first of them to the last cell of all,
 * and how many there are (negative). */
static inline lanes16 find(const int16_t *sum, lanes16 b, const int16_t *order,
                           int32_t n, lanes16 *count)
{
    lanes16 k = _mm256_setzero_si256();
    lanes16 c = _mm256_setzero_si256();
    int32_t at;

    for (at = 0; at + 48 < n; at += 64) {
        lanes16 m0 = SAME(b, LOAD(sum + at));
        lanes16 m1 = SAME(b, LOAD(sum + at + 16));
        lanes16 m2 = SAME(b, LOAD(sum + at + 32));
        lanes16 m3 = SAME(b, LOAD(sum + at + 48));
        lanes16 t0 = MAX(AND(m0, LOAD(order + at)), AND(m1, LOAD(order + at + 16)));
        lanes16 t1 =
            MAX(AND(m2, LOAD(order + at + 32)), AND(m3, LOAD(order + at + 48)));
        k = MAX(k, MAX(t0, t1));
        c = ADD(c, ADD(ADD(m0, m1), ADD(m2, m3)));
    }
    for (; at < n; at += 16) {
        lanes16 m = SAME(b, LOAD(sum + at));
        k = MAX(k, AND(m, LOAD(order + at)));
        c = ADD(c, m);
    }
    *count = c;
    return k;
}

/* Least over the labels that are no neighbours of the winner. */
static inline lanes16 second_best(const int16_t *sum, const int16_t *order, int32_t n,
                                  lanes16 left)
{
    lanes16 rest = ALL(INT16_MAX);
    int32_t at;

    for (at = 0; at < n; at += 16) {
        lanes16 away = _mm256_abs_epi16(SUB(LOAD(order + at), left));
        lanes16 beside = OVER(ALL(17), away); /* a label is 16 cells */
        lanes16 least = SUB(beside, ALL(INT16_MIN));
        rest = MIN(rest, MAX(LOAD(sum + at), least));
    }
    return rest;
}

void plfx_k_select(const int16_t *sum, const plfx_lead *lead, const int16_t *order,
                   int32_t labels, int32_t fit, const plfx_winners *out)
{
    int32_t n = labels * 16;
    lanes16 best = LOAD(lead->least);
    lanes16 count;
    lanes16 left = find(sum, best, order, n, &count);
    plfx_won w;

    STORE(w.best, best);
    look_beside(sum, SUB(ALL(n), left), &w);
    if (out->conf || out->best) {
        int16_t rest[16];
        lanes16 second = second_best(sum, order, n, left);
        STORE(rest, second);
        STORE(w.tie, SAME(second, best));
        if (out->best) {
            STORE(out->best, best);
            STORE(out->rest, second);
        } else {
            plfx_won_rate(w.best, rest, out->floor_cost, out->conf);
        }
    } else { /* a neighbour behind that is as good makes no tie */
        lanes16 beside = AND(SAME(LOAD(w.next), best), OVER(left, ALL(16)));
        STORE(w.tie, OVER(beside, ADD(count, ALL(1))));
    }
    plfx_won_fit(&w, labels, fit, out->code);
}

#else
typedef int plfx_no_avx2; /* a file is never empty */
#endif
