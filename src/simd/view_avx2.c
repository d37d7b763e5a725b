/* SPDX-License-Identifier: MIT
 * The runs of view_run.c in AVX2: the sixteen views of a lens in a vector.  Chosen by
 * the build (-Dkernels=avx2); the same bits. */
#include "../view_run.h"

#if defined(PLFX_KERNELS_AVX2)

#include "means_avx2.h"

#define LENSES PLFX_RUN_LENSES
#define VIEWS  PLFX_RUN_VIEWS

#define AHEAD    (2 * 8 * 17) /* pixels of the block after the next, about */
#define COUNT(n) _mm_cvtsi32_si128(n)

/* What all lenses of a run share. */
typedef struct shared {
    lanes16 sx, sy, black, gain, top, clipped;
    lanes16 half, carry; /* of the tone: a half, or the bit that is shifted out */
    __m128i up, down;
} shared;

static inline shared share(const plfx_view_run *r)
{
    int32_t down = r->curve.down - 16;
    shared s;

    s.sx = LOAD(r->x_u16);
    s.sy = LOAD(r->y_u16);
    s.black = ALL(r->curve.black);
    s.gain = ALL(r->curve.gain);
    s.top = ALL(r->curve.top);
    s.clipped = ALL(r->curve.clipped);
    s.carry = ALL(down == 0 ? 1 : 0);
    s.half = ALL(down == 0 ? 0 : (1 << down) >> 1);
    s.up = COUNT(7 - r->down);
    s.down = COUNT(down);
    return s;
}

/* plfx_toned() where down is 16 or more: of the 29 bits of the product the upper 16
 * count, and for 16 the next one. */
static inline lanes16 toned(const shared *s, lanes16 v)
{
    lanes16 lit = _mm256_subs_epu16(v, s->black);
    lanes16 high = _mm256_mulhi_epu16(lit, s->gain);
    lanes16 next = _mm256_srli_epi16(_mm256_mullo_epi16(lit, s->gain), 15);
    lanes16 full = _mm256_cmpeq_epi16(_mm256_max_epu16(v, s->clipped), v);

    high = PLUS(PLUS(high, s->half), _mm256_and_si256(next, s->carry));
    high = _mm256_srl_epi16(high, s->down);
    return _mm256_min_epu16(_mm256_or_si256(high, full), s->top);
}

static inline lanes16 means(plfx_view_run r, const shared *s, int32_t l)
{
    int32_t x = r.x_q16[l];
    int32_t y = r.y_q16[l];
    const uint16_t *px = r.px + (ptrdiff_t)plfx_asr_i32(y + r.first.y_q16, 16) * r.w +
                         plfx_asr_i32(x + r.first.x_q16, 16);
    lanes16 g = _mm256_and_si256(PLUS(ALL(x), s->sx), ALL(-256));
    lanes16 f = _mm256_srli_epi16(PLUS(ALL(y), s->sy), 8);

    _mm_prefetch((const char *)(const void *)(px + AHEAD), _MM_HINT_T0);
    g = FLIP(g);
    return across(along(LOAD(px), LOAD(px + 1), g, s->up),
                  along(LOAD(px + r.w), LOAD(px + r.w + 1), g, s->up), f);
}

static void tone_plainly(const plfx_view_run *r, uint16_t (*restrict tile)[VIEWS])
{
    int32_t i;
    int32_t l;

    for (l = 0; l < LENSES; l++) {
        for (i = 0; i < VIEWS; i++) {
            tile[l][i] = (uint16_t)plfx_toned(r->curve, tile[l][i]);
        }
    }
}

void plfx_view_tile(const plfx_view_run *r, uint16_t (*restrict tile)[VIEWS])
{
    int32_t fast = r->toned && r->curve.down >= 16;
    shared s = share(r);
    plfx_view_run own = *r;
    int32_t l;

    for (l = 0; l < LENSES; l++) {
        lanes16 v = means(own, &s, l);
        if (fast) {
            v = toned(&s, v);
        }
        _mm256_storeu_si256((__m256i *)(void *)tile[l], v);
    }
    if (r->toned && !fast) {
        tone_plainly(r, tile);
    }
}

/* Rows of eight lenses from eight lenses of sixteen views: r[i] holds views i and
 * i + 8. */
static inline void turn(lanes16 *r)
{
    lanes16 a[LENSES];
    int32_t i;

#pragma GCC unroll 4
    for (i = 0; i < 4; i++) {
        a[2 * i] = _mm256_unpacklo_epi16(r[2 * i], r[2 * i + 1]);
        a[2 * i + 1] = _mm256_unpackhi_epi16(r[2 * i], r[2 * i + 1]);
    }
#pragma GCC unroll 2
    for (i = 0; i < 2; i++) {
        r[4 * i] = _mm256_unpacklo_epi32(a[4 * i], a[4 * i + 2]);
        r[4 * i + 1] = _mm256_unpackhi_epi32(a[4 * i], a[4 * i + 2]);
        r[4 * i + 2] = _mm256_unpacklo_epi32(a[4 * i + 1], a[4 * i + 3]);
        r[4 * i + 3] = _mm256_unpackhi_epi32(a[4 * i + 1], a[4 * i + 3]);
    }
#pragma GCC unroll 4
    for (i = 0; i < 4; i++) {
        a[2 * i] = _mm256_unpacklo_epi64(r[i], r[i + 4]);
        a[2 * i + 1] = _mm256_unpackhi_epi64(r[i], r[i + 4]);
    }
#pragma GCC unroll 8
    for (i = 0; i < 8; i++) {
        r[i] = a[i];
    }
}

static inline void put(uint16_t *to, __m128i v)
{
    _mm_storeu_si128((__m128i *)(void *)to, v);
    PLFX_WILL_WRITE(to + PLFX_RUN_AHEAD);
}

static inline void put_rows(lanes16 *r, int32_t n, uint16_t *restrict to, size_t step)
{
    int32_t i;

    turn(r);
    for (i = 0; i < n && i < 8; i++) {
        put(to + (size_t)i * step, _mm256_castsi256_si128(r[i]));
    }
    for (i = 8; i < n; i++) {
        put(to + (size_t)i * step, _mm256_extracti128_si256(r[i - 8], 1));
    }
}

void plfx_view_turn(uint16_t (*restrict tile)[VIEWS], int32_t n, uint16_t *restrict to,
                    size_t step)
{
    lanes16 r[LENSES];
    int32_t l;

    for (l = 0; l < LENSES; l++) {
        r[l] = LOAD(tile[l]);
    }
    put_rows(r, n, to, step);
}

#endif
