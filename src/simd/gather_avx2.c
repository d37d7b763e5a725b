/* SPDX-License-Identifier: MIT
 * The taps of gather_fast.c in AVX2: sixteen lenses in a vector, in the order 0, 8, 1,
 * 9 .. 7, 15 while they are mixed.  Chosen by the build (-Dkernels=avx2); the same
 * bits. */
#include "../gather_row.h"

#if defined(PLFX_KERNELS_AVX2)

#include "means_avx2.h"

/* Eight lenses in each. */
typedef struct halves {
    lanes16 a, b;
} halves;

static inline halves places(const int32_t *c, int32_t shift)
{
    lanes16 s = _mm256_set1_epi32(shift);
    halves h = {_mm256_add_epi32(LOAD(c), s), _mm256_add_epi32(LOAD(c + 8), s)};

    return h;
}

/* Lower and upper 16 bits of each lens. */
static inline lanes16 lower(halves h)
{
    return _mm256_blend_epi16(h.a, _mm256_slli_epi32(h.b, 16), 0xaa);
}

static inline lanes16 upper(halves h)
{
    return _mm256_blend_epi16(_mm256_srli_epi32(h.a, 16), h.b, 0xaa);
}

/* Pixels at whole x with their right neighbours above them. */
static inline halves pixels(const uint16_t *px, halves x)
{
    const int *two = (const int *)(const void *)px;
    halves h = {_mm256_i32gather_epi32(two, _mm256_srai_epi32(x.a, 16), 2),
                _mm256_i32gather_epi32(two, _mm256_srai_epi32(x.b, 16), 2)};

    return h;
}

/* From the order of lenses to that of the halves and back. */
static inline lanes16 shuffled(lanes16 v)
{
    const lanes16 turn =
        _mm256_setr_epi8(0, 1, 8, 9, 2, 3, 10, 11, 4, 5, 12, 13, 6, 7, 14, 15, 0, 1, 8,
                         9, 2, 3, 10, 11, 4, 5, 12, 13, 6, 7, 14, 15);

    return _mm256_shuffle_epi8(_mm256_permute4x64_epi64(v, 0xd8), turn);
}

static inline lanes16 in_order(lanes16 v)
{
    const lanes16 turn =
        _mm256_setr_epi8(0, 1, 4, 5, 8, 9, 12, 13, 2, 3, 6, 7, 10, 11, 14, 15, 0, 1, 4,
                         5, 8, 9, 12, 13, 2, 3, 6, 7, 10, 11, 14, 15);

    return _mm256_permute4x64_epi64(_mm256_shuffle_epi8(v, turn), 0xd8);
}

/* What a displacement along y means for the lenses in this row: their second tap, no
 * first one (ones); the second one's weight. */
typedef struct turn {
    lanes16 second, not_first, w;
} turn;

static inline turn turn_of(const plfx_gather_row *v, halves y)
{
    lanes16 last = ALL(plfx_min_i32(v->to, INT16_MAX));
    lanes16 row = upper(y);
    turn t;

    t.second = _mm256_cmpeq_epi16(row, ALL(v->before));
    t.not_first = _mm256_or_si256(_mm256_cmpgt_epi16(ALL(v->from), row),
                                  _mm256_cmpgt_epi16(row, last));
    t.w = _mm256_srli_epi16(lower(y), 8);
    return t;
}

/* One view.  Lenses without a tap keep their numbers. */
static inline void mix(const uint16_t *px, halves x, __m128i up, const turn *t,
                       uint16_t *to)
{
    halves two = pixels(px, x);
    lanes16 g = FLIP(_mm256_and_si256(lower(x), ALL(-256)));
    lanes16 h = along(lower(two), upper(two), g, up);
    lanes16 s = shuffled(LOAD(to));

    s = _mm256_blendv_epi8(s, across(s, h, t->w), t->second);
    s = _mm256_blendv_epi8(h, s, t->not_first);
    _mm256_storeu_si256((__m256i *)(void *)to, in_order(s));
}

void plfx_gather_narrow(const plfx_gather *g, const plfx_gather_row *v,
                        const plfx_gather_block *b, const int32_t *cx,
                        const int32_t *cy, uint16_t *to)
{
    const plfx_point *shift = g->shift;
    const uint16_t *px = v->px;
    size_t nx = (size_t)g->lut->lattice.nx;
    __m128i up = _mm_cvtsi32_si128(7 - v->down);
    int32_t n = g->n;
    const plfx_point *turned = NULL; /* the view that t was made for */
    turn t = {ALL(0), ALL(0), ALL(0)};
    int32_t k;

    for (k = 0; k < n; k++) {
        plfx_point s = shift[k];
        if (!plfx_gather_meets(v, b, s.y_q16, s.y_q16)) {
            continue;
        }
        if (!turned || turned->y_q16 != s.y_q16) {
            t = turn_of(v, places(cy, s.y_q16));
            turned = shift + k;
        }
        mix(px, places(cx, s.x_q16), up, &t, to + (size_t)k * nx);
    }
}

#else
typedef int plfx_no_gather_avx2; /* a file is never empty */
#endif
