/* SPDX-License-Identifier: MIT */
#include "common/colour.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/font.h"
#include "common/frame.h"
#include "common/memory.h"

#define BAR_W      16 /* pixels */
#define NUMBER_GAP 10 /* from the bar: its tick must not read as a minus */
#define GAP        10
#define TEXT_W     62 /* ten characters */
#define MARGIN     16 /* above and below: a label, half a number */
#define TICKS      5

/* Lightness rises evenly from knot to knot. */
static const uint8_t knots[9][3] = {{20, 22, 82},   {38, 46, 132},  {44, 82, 146},
                                    {44, 113, 142}, {42, 143, 128}, {78, 171, 98},
                                    {142, 194, 64}, {208, 211, 50}, {252, 236, 88}};

void plft_colour(float t, uint8_t rgb[3])
{
    float at, f;
    int k, c;

    if (isnan(t)) {
        memset(rgb, 128, 3);
        return;
    }
    at = 8.0f * (t < 0.0f ? 0.0f : t > 1.0f ? 1.0f : t);
    k = at >= 8.0f ? 7 : (int)at;
    f = at - (float)k;
    for (c = 0; c < 3; c++) {
        rgb[c] = (uint8_t)(0.5f + (float)knots[k][c] * (1.0f - f) +
                           (float)knots[k + 1][c] * f);
    }
}

void plft_text(uint8_t *rgb, int w, int h, int x, int y, const char *text,
               const uint8_t colour[3])
{
    for (; *text != '\0'; text++, x += PLFT_FONT_W) {
        int drop, row, col;
        const uint8_t *g = plft_glyph(*text, &drop);
        for (row = 0; row < 7; row++) {
            for (col = 0; col < 5; col++) {
                int px = x + col, py = y + row + drop;
                if ((g[row] >> (4 - col) & 1) != 0 && px >= 0 && py >= 0 && px < w &&
                    py < h) {
                    memcpy(rgb + 3 * ((size_t)py * (size_t)w + (size_t)px), colour, 3);
                }
            }
        }
    }
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;

    return (x > y) - (x < y);
}

/* 1st and 99th percentile of the finite values; 0 .. 1 when there are none. */
static int robust_range(const float *v, size_t n, float *lo, float *hi)
{
    float *sorted = (float *)plft_alloc(n, sizeof *sorted);
    size_t i, m = 0;

    if (sorted == NULL) {
        return PLFT_DATA;
    }
    for (i = 0; i < n; i++) {
        if (isfinite(v[i])) {
            sorted[m++] = v[i];
        }
    }
    qsort(sorted, m, sizeof *sorted, by_value);
    *lo = m > 0 ? sorted[(m - 1) / 100] : 0.0f;
    *hi = m > 0 ? sorted[m - 1 - (m - 1) / 100] : 1.0f;
    if (!(*hi > *lo)) { /* a constant map still needs a bar */
        float pad = fabsf(*lo) * 0.01f + 1e-6f;
        *lo -= pad;
        *hi += pad;
    }
    free(sorted);
    return 0;
}

static int auto_scale(int w)
{
    int scale = 400 / w + (400 % w != 0);

    return scale < 1 ? 1 : scale > 16 ? 16 : scale;
}

typedef struct canvas {
    uint8_t *rgb;
    int w, h;
} canvas;

static void put(const canvas *c, int x, int y, const uint8_t rgb[3])
{
    memcpy(c->rgb + 3 * ((size_t)y * (size_t)c->w + (size_t)x), rgb, 3);
}

static void draw_map(const canvas *c, const float *v, int w, int h, float lo, float hi,
                     int scale)
{
    int x, y;

    for (y = 0; y < h * scale; y++) {
        for (x = 0; x < w * scale; x++) {
            uint8_t rgb[3];
            float s = v[(size_t)(y / scale) * (size_t)w + (size_t)(x / scale)];
            plft_colour((s - lo) / (hi - lo), rgb);
            put(c, x, y + MARGIN, rgb);
        }
    }
}

/* Digits that tell five numbers of the range apart. */
static int decimals(float lo, float hi)
{
    int d = 2 - (int)floorf(log10f(hi - lo));

    return d < 0 ? 0 : d > 6 ? 6 : d;
}

static void draw_bar(const canvas *c, int x0, float lo, float hi)
{
    static const uint8_t black[3] = {0, 0, 0};
    int tall = c->h - 2 * MARGIN;
    int x, y, k;

    for (y = 0; y < tall; y++) {
        uint8_t rgb[3];
        plft_colour(tall > 1 ? 1.0f - (float)y / (float)(tall - 1) : 0.0f, rgb);
        for (x = 0; x < BAR_W; x++) {
            put(c, x0 + x, y + MARGIN, rgb);
        }
    }
    for (k = 0; k < TICKS; k++) {
        float t = (float)k / (TICKS - 1);
        char text[24];
        y = MARGIN + (int)((1.0f - t) * (float)(tall - 1));
        (void)snprintf(text, sizeof text, "%.*f", decimals(lo, hi),
                       (double)(lo + t * (hi - lo)));
        for (x = 0; x < 3; x++) {
            put(c, x0 + BAR_W + x, y, black);
        }
        plft_text(c->rgb, c->w, c->h, x0 + BAR_W + NUMBER_GAP, y - 3, text, black);
    }
}

int plft_colour_png(const char *path, const float *v, int w, int h, float lo, float hi,
                    int scale, const char *label)
{
    static const uint8_t black[3] = {0, 0, 0};
    int tall;
    canvas c;
    int rc;

    if (!(lo < hi) && robust_range(v, (size_t)w * (size_t)h, &lo, &hi) != 0) {
        return PLFT_DATA;
    }
    scale = scale > 0 ? scale : auto_scale(w);
    tall = h * scale < 60 ? 60 : h * scale; /* room for the numbers */
    c.w = w * scale + GAP + BAR_W + NUMBER_GAP + TEXT_W;
    c.h = tall + 2 * MARGIN;
    c.rgb = (uint8_t *)plft_alloc((size_t)c.w * (size_t)c.h, 3);
    if (c.rgb == NULL) {
        return PLFT_DATA;
    }
    memset(c.rgb, 255, 3 * (size_t)c.w * (size_t)c.h);
    draw_map(&c, v, w, h, lo, hi, scale);
    draw_bar(&c, w * scale + GAP, lo, hi);
    plft_text(c.rgb, c.w, c.h, 2, 4, label, black);
    rc = plft_png_write_rgb8(path, c.rgb, c.w, c.h);
    free(c.rgb);
    return rc;
}
