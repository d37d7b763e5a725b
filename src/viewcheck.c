/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "plenofix/viewcheck.h"
#include "fix.h"

#define VIEWS_MAX   2048
#define STEP        4
#define BLOCK       8
#define NOISE_VIEWS 8
#define BINS        128 /* of block sums: 64 samples of 1/4 grey level a bin */

typedef struct tally {
    uint32_t mean, clipped; /* mean sample; clipped samples in 1024ths */
} tally;

static const uint16_t *row_of(const plfx_views *v, int32_t k, int32_t y)
{
    return v->px + ((size_t)y * (size_t)v->n + (size_t)k) * (size_t)v->nx;
}

static tally tally_of(const plfx_views *v, int32_t bits, int32_t k)
{
    uint64_t sum = 0;
    uint64_t clipped = 0;
    uint64_t n = 0;
    tally t;
    int32_t x;
    int32_t y;

    for (y = 0; y < v->ny; y += STEP) {
        const uint16_t *row = row_of(v, k, y);
        for (x = 0; x < v->nx; x += STEP) {
            sum += row[x];
            clipped += row[x] >= (1u << bits) - 1u;
            n++;
        }
    }
    t.mean = (uint32_t)(sum / n);
    t.clipped = (uint32_t)(1024u * clipped / n);
    return t;
}

/* Middle value of n, by counting; of two middle ones the first in order. */
static uint32_t middle(const uint32_t *v, int32_t n)
{
    uint32_t mid = 0;
    int32_t i;
    int32_t j;

    for (i = n - 1; i >= 0; i--) {
        int32_t less = 0;
        int32_t equal = 0;
        for (j = 0; j < n; j++) {
            less += v[j] < v[i];
            equal += v[j] == v[i];
        }
        if (2 * less <= n && 2 * (less + equal) >= n) {
            mid = v[i];
        }
    }
    return mid;
}

static uint8_t finding(tally t, tally mid)
{
    uint32_t f = 0;

    f |= 4u * t.mean < mid.mean ? PLFX_VIEW_DARK : 0u;
    f |= t.clipped > 256u && t.clipped > 2u * mid.clipped ? PLFX_VIEW_CLIPPED : 0u;
    f |= 2u * t.mean < mid.mean || 2u * t.mean > 3u * mid.mean + 8u ? PLFX_VIEW_ALIEN
                                                                    : 0u;
    return (uint8_t)f;
}

int32_t plfx_views_check(const plfx_views *views, int32_t bits, uint8_t *found,
                         uint32_t *work)
{
    uint32_t *mean = work;
    uint32_t *clipped;
    int32_t count = 0;
    tally mid;
    int32_t k;

    if (!views || !views->px || !found || !work || views->n < 3 ||
        views->n > VIEWS_MAX || views->nx < 1 || views->ny < 1 ||
        bits < PLFX_BITS_MIN || bits > PLFX_BITS_MAX) {
        return PLFX_E_ARG;
    }
    clipped = work + views->n;
    for (k = 0; k < views->n; k++) {
        tally t = tally_of(views, bits, k);
        mean[k] = t.mean;
        clipped[k] = t.clipped;
    }
    mid.mean = middle(mean, views->n);
    mid.clipped = middle(clipped, views->n);
    for (k = 0; k < views->n; k++) {
        tally t;
        t.mean = mean[k];
        t.clipped = clipped[k];
        found[k] = finding(t, mid);
        count += found[k] != 0;
    }
    return count;
}

/* Sum over a block of |second difference along both axes|: at most 64 * 16 * 4095. */
static uint32_t block_sum(const plfx_views *v, int32_t k, int32_t x0, int32_t y0)
{
    uint32_t sum = 0;
    int32_t x;
    int32_t y;

    for (y = y0; y < y0 + BLOCK; y++) {
        const uint16_t *a = row_of(v, k, y - 1);
        const uint16_t *b = row_of(v, k, y);
        const uint16_t *c = row_of(v, k, y + 1);
        for (x = x0; x < x0 + BLOCK; x++) {
            int32_t d = a[x - 1] - 2 * a[x] + a[x + 1] -
                        2 * (b[x - 1] - 2 * b[x] + b[x + 1]) + c[x - 1] - 2 * c[x] +
                        c[x + 1];
            sum += (uint32_t)(d < 0 ? -d : d);
        }
    }
    return sum;
}

/* Views that are looked at together, and which: i of m spread over n. */
static int32_t looked_at(const plfx_views *v, int32_t k)
{
    return k != PLFX_VIEWS_ALL ? 1 : v->n < NOISE_VIEWS ? v->n : NOISE_VIEWS;
}

/* Mean over the views of a block's sum. */
static uint32_t mean_sum(const plfx_views *v, int32_t k, int32_t x, int32_t y)
{
    int32_t m = looked_at(v, k);
    uint32_t sum = 0; /* under 2^25 */
    int32_t i;

    for (i = 0; i < m; i++) {
        sum += block_sum(v, k != PLFX_VIEWS_ALL ? k : i * v->n / m, x, y);
    }
    return sum / (uint32_t)m;
}

/* Of noise alone a block's mean scatters by 0.166 of it over the root of m views, and
 * its twentieth lies 0.27 over that root low, which is given back, q8. */
static uint32_t choice_q8(int32_t m)
{
    return 256u + 1120u / (uint32_t)plfx_isqrt_u64(256u * (uint64_t)m);
}

static int32_t noise_args_ok(const plfx_views *v, int32_t bits, int32_t k)
{
    return v && v->px && v->n >= 1 && k >= PLFX_VIEWS_ALL && k < v->n && v->nx >= 16 &&
           v->ny >= 16 && bits >= PLFX_BITS_MIN && bits <= PLFX_BITS_MAX;
}

int32_t plfx_views_noise_q4(const plfx_views *views, int32_t bits, int32_t k)
{
    uint32_t bin[BINS];
    uint32_t blocks = 0;
    uint32_t seen = 0;
    uint32_t i = 0;
    int32_t x;
    int32_t y;

    if (!noise_args_ok(views, bits, k)) {
        return 0;
    }
    memset(bin, 0, sizeof bin);
    for (y = 1; y + BLOCK < views->ny; y += BLOCK) {
        for (x = 1; x + BLOCK < views->nx; x += BLOCK) {
            /* quarters of a grey level of mean |d|: sum/64 * 4 / 2^(bits-8) */
            uint32_t q = mean_sum(views, k, x, y) >> (bits - 4);
            bin[q < BINS ? q : BINS - 1]++;
            blocks++;
        }
    }
    /* at most BINS */
    while (i < BINS - 1 && 20 * (seen + bin[i]) < blocks) {
        seen += bin[i++];
    }
    /* noise = 0.2089 of the mean; q quarters -> sixteenths: 4 * 0.2089 = 214/256 */
    i = (2 * i + 1) * 107;
    return (int32_t)(k != PLFX_VIEWS_ALL ? i >> 8
                                         : (i * choice_q8(looked_at(views, k))) >> 16);
}
