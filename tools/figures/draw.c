/* SPDX-License-Identifier: MIT
 * figures zoom, map, sheet: pictures for the page of the demo. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/colour.h"
#include "common/csv.h"
#include "common/err.h"
#include "common/frame.h"
#include "common/memory.h"
#include "common/pfm.h"
#include "figures/figures.h"

#define LINE  14 /* height of a caption, px */
#define GAP   8
#define CROSS 4 /* arm of a cross, px */

typedef struct picture {
    uint8_t *rgb;
    int w, h;
} picture;

static int new_picture(picture *p, int w, int h)
{
    p->w = w;
    p->h = h;
    p->rgb = plft_alloc(3 * (size_t)w * (size_t)h, 1);
    if (p->rgb == NULL) {
        return PLFT_DATA;
    }
    memset(p->rgb, 255, 3 * (size_t)w * (size_t)h);
    return 0;
}

static void dot(picture *p, int x, int y, uint8_t r, uint8_t g, uint8_t b)
{
    uint8_t *at;

    if (x >= 0 && y >= 0 && x < p->w && y < p->h) {
        at = p->rgb + 3 * ((size_t)y * (size_t)p->w + (size_t)x);
        at[0] = r;
        at[1] = g;
        at[2] = b;
    }
}

static int by_value(const void *a, const void *b)
{
    uint16_t x = *(const uint16_t *)a;
    uint16_t y = *(const uint16_t *)b;

    return x < y ? -1 : x > y;
}

/* The value that 99.5 % of the samples do not exceed. */
static int white_of(const plft_frame *f)
{
    size_t n = (size_t)f->w * (size_t)f->h * (size_t)f->channels;
    uint16_t *copy = plft_alloc(n, sizeof *copy);
    int white = 1;

    if (copy != NULL) {
        memcpy(copy, f->px, n * sizeof *copy);
        qsort(copy, n, sizeof *copy, by_value);
        white = copy[n - 1 - n / 200];
    }
    free(copy);
    return white > 0 ? white : 1;
}

/* Display level of sample (x,y), channel c, a square root against the dark. */
static uint8_t level(const plft_frame *f, int x, int y, int c, int white)
{
    size_t at = ((size_t)y * (size_t)f->w + (size_t)x) * (size_t)f->channels;
    double v = (double)f->px[at + (size_t)(c % f->channels)] / white;

    return (uint8_t)(255.0 * sqrt(v > 1.0 ? 1.0 : v) + 0.5);
}

typedef struct part { /* of a frame, in its pixels */
    int x, y, w, h, scale;
} part;

static void enlarge(picture *p, const plft_frame *f, const part *a)
{
    int white = white_of(f);
    int x, y;

    for (y = 0; y < p->h; y++) {
        for (x = 0; x < p->w; x++) {
            int fx = a->x + x / a->scale;
            int fy = a->y + y / a->scale;
            dot(p, x, y, level(f, fx, fy, 0, white), level(f, fx, fy, 1, white),
                level(f, fx, fy, 2, white));
        }
    }
}

/* A red cross at every lens centre of the file ("row,col,x,y"). */
static int crosses(picture *p, const char *path, const part *a)
{
    plft_csv csv;
    size_t k;
    int d;

    if (plft_csv_read(&csv, path)) {
        return PLFT_DATA;
    }
    for (k = 0; k < csv.rows && csv.cols >= 4; k++) {
        const double *row = csv.v + k * (size_t)csv.cols;
        int x = (int)floor((row[2] + 0.5 - a->x) * a->scale);
        int y = (int)floor((row[3] + 0.5 - a->y) * a->scale);
        for (d = -CROSS; d <= CROSS; d++) {
            dot(p, x + d, y, 230, 30, 30);
            dot(p, x, y + d, 230, 30, 30);
        }
    }
    plft_csv_free(&csv);
    return 0;
}

/* Cut `a` to the frame; w or h of 0 mean all of it. */
static void fit(part *a, const plft_frame *f)
{
    a->x = a->x < 0 || a->x >= f->w ? 0 : a->x;
    a->y = a->y < 0 || a->y >= f->h ? 0 : a->y;
    a->w = a->w <= 0 || a->w > f->w - a->x ? f->w - a->x : a->w;
    a->h = a->h <= 0 || a->h > f->h - a->y ? f->h - a->y : a->h;
    a->scale = a->scale < 1 ? 1 : a->scale;
}

int plft_figure_zoom(int argc, char **argv)
{
    plft_frame f;
    picture p = {NULL, 0, 0};
    part a;
    int rc;

    if (argc != 8 && argc != 9) {
        return plft_fail(PLFT_USAGE, "zoom: want IN OUT X Y W H SCALE [CENTRES]");
    }
    if (plft_frame_read(&f, argv[1], 0)) {
        return PLFT_DATA;
    }
    a.x = atoi(argv[3]);
    a.y = atoi(argv[4]);
    a.w = atoi(argv[5]);
    a.h = atoi(argv[6]);
    a.scale = atoi(argv[7]);
    fit(&a, &f);
    rc = new_picture(&p, a.w * a.scale, a.h * a.scale);
    if (rc == 0) {
        enlarge(&p, &f, &a);
        rc = argc == 9 ? crosses(&p, argv[8], &a) : 0;
    }
    rc = rc ? rc : plft_png_write_rgb8(argv[2], p.rgb, p.w, p.h);
    free(p.rgb);
    plft_frame_free(&f);
    return rc;
}

int plft_figure_map(int argc, char **argv)
{
    plft_map map;
    int rc;

    if (argc != 6) {
        return plft_fail(PLFT_USAGE, "map: want IN.pfm OUT.png LO HI LABEL");
    }
    if (plft_pfm_read(&map, argv[1])) {
        return PLFT_DATA;
    }
    rc = plft_colour_png(argv[2], map.v, map.w, map.h, strtof(argv[3], NULL),
                         strtof(argv[4], NULL), 0, argv[5]);
    plft_map_free(&map);
    return rc;
}

/* Place a file with its caption at (x,y). */
static int place(picture *sheet, const char *path, const char *label, int x, int y)
{
    static const uint8_t black[3] = {0, 0, 0};
    plft_frame f;
    int i, j;

    if (plft_frame_read(&f, path, 8)) {
        return PLFT_DATA;
    }
    plft_text(sheet->rgb, sheet->w, sheet->h, x, y + 2, label, black);
    for (j = 0; j < f.h; j++) {
        for (i = 0; i < f.w; i++) {
            size_t at = ((size_t)j * (size_t)f.w + (size_t)i) * (size_t)f.channels;
            size_t last = (size_t)f.channels - 1;
            dot(sheet, x + i, y + LINE + j, (uint8_t)f.px[at],
                (uint8_t)f.px[at + (last > 0)], (uint8_t)f.px[at + last]);
        }
    }
    plft_frame_free(&f);
    return 0;
}

/* Largest width and height of the n files at argv[0], argv[2] ... */
static int largest(char **argv, int n, int *w, int *h)
{
    plft_frame f;
    int k;

    *w = *h = 0;
    for (k = 0; k < n; k++) {
        if (plft_frame_read(&f, argv[2 * k], 8)) {
            return PLFT_DATA;
        }
        *w = f.w > *w ? f.w : *w;
        *h = f.h > *h ? f.h : *h;
        plft_frame_free(&f);
    }
    return 0;
}

/* Width of a column, height of all rows. */
static int layout(char **argv, int n, int columns, int *w, int *height)
{
    int k, h, unused;

    *height = GAP;
    if (largest(argv, n, w, &unused)) {
        return PLFT_DATA;
    }
    for (k = 0; k < n; k += columns) {
        if (largest(argv + 2 * k, n - k < columns ? n - k : columns, &unused, &h)) {
            return PLFT_DATA;
        }
        *height += h + GAP + LINE;
    }
    *w += GAP;
    return 0;
}

static int fill(picture *p, char **argv, int n, int columns, int w)
{
    int y = GAP / 2;
    int k, i, h, unused;

    for (k = 0; k < n; k += columns) {
        int row = n - k < columns ? n - k : columns;
        if (largest(argv + 2 * k, row, &unused, &h)) {
            return PLFT_DATA;
        }
        for (i = 0; i < row; i++) {
            if (place(p, argv[2 * (k + i)], argv[2 * (k + i) + 1], GAP + i * w, y)) {
                return PLFT_DATA;
            }
        }
        y += h + GAP + LINE;
    }
    return 0;
}

int plft_figure_sheet(int argc, char **argv)
{
    picture p = {NULL, 0, 0};
    int n = (argc - 3) / 2;
    int columns = argc > 2 ? atoi(argv[2]) : 0;
    int w, height, rc;

    if (n < 1 || argc % 2 == 0 || columns < 1) {
        return plft_fail(PLFT_USAGE, "sheet: want OUT COLUMNS {IN LABEL}...");
    }
    columns = columns > n ? n : columns;
    rc = layout(argv + 3, n, columns, &w, &height);
    rc = rc ? rc : new_picture(&p, GAP + columns * w, height);
    rc = rc ? rc : fill(&p, argv + 3, n, columns, w);
    rc = rc ? rc : plft_png_write_rgb8(argv[1], p.rgb, p.w, p.h);
    free(p.rgb);
    return rc;
}
