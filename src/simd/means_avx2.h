/* SPDX-License-Identifier: MIT
 * Means of pixels in AVX2, sixteen at a time in 16 bits: the numbers of taps.h for
 * pixels of 12 bits and less. */
#ifndef PLENOFIX_SRC_SIMD_MEANS_AVX2_H
#define PLENOFIX_SRC_SIMD_MEANS_AVX2_H

#include <immintrin.h>

typedef __m256i lanes16;

#define LOAD(p)    _mm256_loadu_si256((const __m256i *)(const void *)(p))
#define ALL(n)     _mm256_set1_epi16((short)(n))
#define FLIP(a)    _mm256_xor_si256(a, ALL(-32768))
#define PLUS(a, b) _mm256_add_epi16(a, b)

/* Means of pixels p and their right neighbours q as along_run() of view_run.c: g is
 * f - 128 in the upper byte, up = 15 - bits. */
static inline lanes16 along(lanes16 p, lanes16 q, lanes16 g, __m128i up)
{
    lanes16 sum = _mm256_sll_epi16(PLUS(p, q), up);
    lanes16 less = _mm256_sll_epi16(_mm256_sub_epi16(q, p), up);

    return PLUS(sum, _mm256_mulhrs_epi16(less, g));
}

/* Means of two rows, f/256 of the lower one.  Pairs of products need signed samples:
 * both are taken 2^15 down, and the sum of weights brings the mean back. */
static inline lanes16 across(lanes16 upper, lanes16 lower, lanes16 f)
{
    lanes16 w = _mm256_sub_epi16(ALL(256), f);
    lanes16 u = FLIP(upper);
    lanes16 l = FLIP(lower);
    lanes16 half = _mm256_set1_epi32(128);
    lanes16 a =
        _mm256_madd_epi16(_mm256_unpacklo_epi16(u, l), _mm256_unpacklo_epi16(w, f));
    lanes16 b =
        _mm256_madd_epi16(_mm256_unpackhi_epi16(u, l), _mm256_unpackhi_epi16(w, f));

    a = _mm256_srai_epi32(_mm256_add_epi32(a, half), 8);
    b = _mm256_srai_epi32(_mm256_add_epi32(b, half), 8);
    return FLIP(_mm256_packs_epi32(a, b));
}

#endif
