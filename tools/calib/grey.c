/* SPDX-License-Identifier: MIT
 * Frames into one clean picture. */
#include "calib/grey.h"

#include <stdlib.h>
#include <string.h>

#define PEDESTAL 1024
#define HOT      1310 /* 2 % of full scale */
#define LANES    8

static int same_kind(plft_grey *g, int w, int h, int bits)
{
    if (g->frames == 0) {
        g->w = w;
        g->h = h;
        g->bits = bits;
    }
    return g->w == w && g->h == h && g->bits == bits;
}

void plft_grey_take(plft_grey *g, uint16_t *px, int w, int h, int bits)
{
    memset(g, 0, sizeof *g);
    g->px = px;
    g->w = w;
    g->h = h;
    g->bits = bits;
    g->frames = 1;
}

int plft_grey_add(plft_grey *g, const uint16_t *px, int w, int h, int bits)
{
    const size_t n = (size_t)w * (size_t)h;
    const uint32_t top = (1u << bits) - 1u;
    size_t k;

    if (!same_kind(g, w, h, bits)) {
        return -1;
    }
    if (g->frames == 0) {
        g->sum = calloc(n, sizeof *g->sum);
        g->px = malloc(n * sizeof *g->px);
    }
    if (g->sum == NULL || g->px == NULL) {
        return -1;
    }
    for (k = 0; k < n; k++) { /* once clipped, clipped: the top bit marks it */
        g->sum[k] += px[k];
        g->sum[k] |= px[k] >= top ? 0x80000000u : 0u;
    }
    g->frames++;
    return 0;
}

/* One frame without a dark one: the samples, left aligned. */
static void align(plft_grey *g, size_t n, int shift, unsigned top)
{
    uint16_t *px = g->px;
    uint32_t clipped = 0;
    size_t k;

    for (k = 0; k < n; k++) {
        const unsigned full = px[k] >= top;
        px[k] = (uint16_t)(full != 0u ? PLFT_SATURATED : (unsigned)px[k] << shift);
        clipped += full;
    }
    g->saturated += clipped;
}

/* One sample: mean, dark, pedestal, 16 bits.  Rounded once. */
static uint16_t level(uint32_t sum, uint32_t frames, int shift, int32_t dark,
                      int32_t ped)
{
    uint64_t scaled = (uint64_t)sum << shift;
    int32_t v = (int32_t)((scaled + frames / 2u) / frames) - dark + ped;

    return (uint16_t)(v < 0 ? 0 : v > 65534 ? 65534 : v);
}

static void mosaic_rows(plft_grey *g)
{
    int x, y;

    for (y = 0; y < g->h;
         y++) { /* in place: a pixel needs itself and later ones only */
        uint16_t *r0 = g->px + (size_t)y * (size_t)g->w;
        uint16_t *r1 = y + 1 < g->h ? r0 + g->w : r0;
        for (x = 0; x + 1 < g->w; x++) {
            uint32_t clipped = r0[x] == 65535u || r0[x + 1] == 65535u ||
                               r1[x] == 65535u || r1[x + 1] == 65535u;
            uint32_t s = (uint32_t)r0[x] + r0[x + 1] + r1[x] + r1[x + 1];
            r0[x] = (uint16_t)(clipped ? PLFT_SATURATED : (s + 2u) >> 2);
        }
        if (g->w > 1) {
            r0[g->w - 1] = r0[g->w - 2];
        }
    }
    if (g->h > 1) {
        memcpy(g->px + (size_t)(g->h - 1) * (size_t)g->w,
               g->px + (size_t)(g->h - 2) * (size_t)g->w, (size_t)g->w * sizeof *g->px);
    }
}

int plft_grey_is_mosaic(const plft_grey *g)
{
    double mean[4] = {0}, low, high;
    int x, y, k;

    for (y = 0; y + 1 < g->h; y += 2) {
        const uint16_t *r0 = g->px + (size_t)y * (size_t)g->w, *r1 = r0 + g->w;
        for (x = 0; x + 1 < g->w; x += 2) {
            mean[0] += r0[x];
            mean[1] += r0[x + 1];
            mean[2] += r1[x];
            mean[3] += r1[x + 1];
        }
    }
    low = high = mean[0];
    for (k = 1; k < 4; k++) {
        low = mean[k] < low ? mean[k] : low;
        high = mean[k] > high ? mean[k] : high;
    }
    return high - low > 0.08 * high;
}

void plft_grey_merge_mosaic(plft_grey *g)
{
    mosaic_rows(g);
    g->shift = 0.5;
}

int plft_grey_finish(plft_grey *g, const uint16_t *dark)
{
    const size_t n = (size_t)g->w * (size_t)g->h;
    const int shift = 16 - g->bits;
    const uint32_t top = (1u << g->bits) - 1u, frames = (uint32_t)g->frames;
    const int32_t ped = dark != NULL ? PEDESTAL : 0;
    size_t k;

    if (g->px == NULL || g->frames == 0) {
        return -1;
    }
    if (g->sum == NULL && frames == 1u && dark == NULL) {
        align(g, n, shift, top);
        return 0;
    }
    for (k = 0; k < n; k++) {
        uint32_t sum = g->sum != NULL ? g->sum[k] : g->px[k];
        int clipped = g->sum != NULL ? (sum & 0x80000000u) != 0u : sum >= top;
        int32_t d = dark != NULL ? (int32_t)dark[k] << shift : 0;
        g->saturated += clipped;
        g->dark_level += d;
        g->px[k] = clipped ? (uint16_t)PLFT_SATURATED
                           : level(sum & 0x7fffffffu, frames, shift, d, ped);
    }
    free(g->sum);
    g->sum = NULL;
    g->dark_level /= (double)n;
    g->pedestal = ped;
    return 0;
}

/* Highest, second highest, lowest and sum of the eight neighbours of r1[x]. */
static void around(const uint16_t *r0, const uint16_t *r1, const uint16_t *r2, int x,
                   int32_t *second, int32_t *low, int32_t *sum)
{
    const int32_t v[8] = {r0[x - 1], r0[x],     r0[x + 1], r1[x - 1],
                          r1[x + 1], r2[x - 1], r2[x],     r2[x + 1]};
    int32_t first = 0;
    int k;

    *second = *sum = 0;
    *low = 65535;
    for (k = 0; k < 8; k++) {
        *sum += v[k];
        *low = v[k] < *low ? v[k] : *low;
        if (v[k] > first) {
            *second = first;
            first = v[k];
        } else if (v[k] > *second) {
            *second = v[k];
        }
    }
}

/* Mean of the neighbours where r1[x] stands out of them, else r1[x]. */
static int mended(const uint16_t *r0, const uint16_t *r1, const uint16_t *r2, int x)
{
    int32_t second, low, sum;

    around(r0, r1, r2, x, &second, &low, &sum);
    return r1[x] - second > 3 * (second - low) + HOT ? sum / 8 : -1;
}

/* Where in a row a pixel is HOT over all neighbours but the highest: mark 1. */
static void suspect(const uint16_t *restrict r0, const uint16_t *restrict r1,
                    const uint16_t *restrict r2, int w, uint16_t *restrict mark)
{
    int x, k;

    for (x = 1; x + 1 < w; x++) {
        const uint16_t v[8] = {r0[x - 1], r0[x],     r0[x + 1], r1[x - 1],
                               r1[x + 1], r2[x - 1], r2[x],     r2[x + 1]};
        uint16_t first = 0, second = 0;
        for (k = 0; k < 8; k++) {
            const uint16_t less = v[k] < first ? v[k] : first;
            second = less > second ? less : second;
            first = v[k] > first ? v[k] : first;
        }
        mark[x] = (uint16_t)(r1[x] > HOT ? r1[x] - HOT : 0) > second ? 1 : 0;
    }
}

static void hot_row(plft_grey *g, const uint16_t *r0, const uint16_t *r1, int y,
                    uint16_t *mark)
{
    uint16_t *row = g->px + (size_t)y * (size_t)g->w;
    const uint16_t *r2 = row + g->w;
    int x;

    suspect(r0, r1, r2, g->w, mark);
    for (x = 1; x + 1 < g->w; x++) {
        static const uint16_t none[LANES] = {0};
        int v;
        while (x + LANES < g->w && memcmp(mark + x, none, sizeof none) == 0) {
            x += LANES;
        }
        v = mark[x] != 0 && x + 1 < g->w ? mended(r0, r1, r2, x) : -1;
        if (v >= 0) {
            row[x] = (uint16_t)v;
            g->hot++;
        }
    }
}

void plft_grey_drop_hot(plft_grey *g)
{
    const size_t w = (size_t)g->w;
    uint16_t *r0, *r1, *swap, *rows;
    int y;

    rows = g->w < 3 || g->h < 3 ? NULL : calloc(3u * w, sizeof *rows);
    if (rows == NULL) {
        return;
    }
    r0 = rows;
    r1 = rows + w;
    memcpy(r0, g->px, w * sizeof *r0);
    for (y = 1; y + 1 < g->h; y++) { /* r0, r1: rows y-1, y as they came */
        memcpy(r1, g->px + (size_t)y * w, w * sizeof *r1);
        hot_row(g, r0, r1, y, rows + 2u * w);
        swap = r0;
        r0 = r1;
        r1 = swap;
    }
    free(rows);
}

void plft_grey_free(plft_grey *g)
{
    free(g->px);
    free(g->sum);
    memset(g, 0, sizeof *g);
}
