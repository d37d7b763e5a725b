/* SPDX-License-Identifier: MIT
 * views: sub-aperture views as pictures, with what `depth` needs to take them up. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "common/args.h"
#include "common/arrange.h"
#include "common/colour.h"
#include "common/err.h"
#include "common/folder.h"
#include "common/memory.h"
#include "common/progress.h"
#include "common/square.h"
#include "common/views_json.h"

#define SHEET_MAX  1600 /* pixels of width, about */
#define SHEET_MIN  500
#define SHEET_GAP  2
#define SHEET_TEXT 10 /* rows above each view */

typedef struct request {
    plft_source source;
    plft_views_wish wish;
    const char *dir, *views;
    int axes;
} request;

typedef struct sheet { /* contact sheet, RGB */
    uint8_t *rgb;
    int cols, rows, cell_w, cell_h, w, h;
    int shrink, grow; /* one of them is 1 */
} sheet;

static void row_to_frame(const plfx_views *v, int k, plft_frame *f)
{
    int y;

    for (y = 0; y < v->ny; y++) {
        memcpy(f->px + (size_t)y * (size_t)v->nx,
               v->px + ((size_t)y * (size_t)v->n + (size_t)k) * (size_t)v->nx,
               (size_t)v->nx * sizeof *f->px);
    }
}

static int sheet_init(sheet *s, const plft_square *sq, int n)
{
    s->cols = 1;
    while (s->cols * s->cols < n) {
        s->cols++;
    }
    s->rows = (n + s->cols - 1) / s->cols;
    s->shrink = (s->cols * sq->w + SHEET_MAX - 1) / SHEET_MAX;
    s->grow = (SHEET_MIN + s->cols * sq->w - 1) / (s->cols * sq->w);
    s->cell_w = (sq->w + s->shrink - 1) / s->shrink * s->grow;
    s->cell_h = (sq->h + s->shrink - 1) / s->shrink * s->grow;
    s->w = s->cols * (s->cell_w + SHEET_GAP);
    s->h = s->rows * (s->cell_h + SHEET_TEXT + SHEET_GAP);
    s->rgb = (uint8_t *)plft_alloc((size_t)s->w * (size_t)s->h, 3);
    return s->rgb != NULL ? 0 : PLFT_DATA;
}

/* Mean of the picture's samples under one pixel of the sheet, 8 bits. */
static int shrunk(const plft_square *sq, const uint16_t *flat, int bits, int x, int y,
                  int s)
{
    unsigned sum = 0, n = 0;
    int dx, dy;

    for (dy = 0; dy < s && y * s + dy < sq->h; dy++) {
        for (dx = 0; dx < s && x * s + dx < sq->w; dx++) {
            sum += flat[(size_t)(y * s + dy) * (size_t)sq->w + (size_t)(x * s + dx)];
            n++;
        }
    }
    return n > 0 ? (int)((sum / n) >> (bits - 8)) : 0;
}

static int sheet_add(sheet *s, const plft_square *sq, const plft_frame *f,
                     plfx_offset at, int k)
{
    static const uint8_t white[3] = {255, 255, 255};
    int x0 = k % s->cols * (s->cell_w + SHEET_GAP);
    int y0 = k / s->cols * (s->cell_h + SHEET_TEXT + SHEET_GAP) + SHEET_TEXT;
    uint16_t *flat =
        (uint16_t *)plft_alloc((size_t)sq->w * (size_t)sq->h, sizeof *flat);
    char text[32];
    int x, y;

    if (flat == NULL) {
        return PLFT_DATA;
    }
    plft_square_view(sq, f->px, f->w, flat);
    for (y = 0; y < s->cell_h; y++) {
        for (x = 0; x < s->cell_w; x++) {
            uint8_t *p =
                s->rgb + 3 * ((size_t)(y0 + y) * (size_t)s->w + (size_t)(x0 + x));
            memset(p, shrunk(sq, flat, f->bits, x / s->grow, y / s->grow, s->shrink),
                   3);
        }
    }
    (void)snprintf(text, sizeof text, "%.3g, %.3g", at.u_q8 / 256.0, at.v_q8 / 256.0);
    plft_text(s->rgb, s->w, s->h, x0 + 2, y0 - SHEET_TEXT + 1, text, white);
    free(flat);
    return 0;
}

static int write_view(const plft_field *field, const char *dir, plfx_offset at, int k,
                      plft_frame *f)
{
    plfx_views one;
    char name[32], *path;
    int rc = plft_field_views(field, &at, 1, &one);

    if (rc != 0) {
        return rc;
    }
    row_to_frame(&one, 0, f);
    free(one.px);
    plft_view_name(name, sizeof name, k);
    path = plft_join(dir, name);
    rc = path == NULL ? PLFT_DATA : plft_png_write(path, f);
    free(path);
    return rc;
}

static int write_sheet(const sheet *s, const char *dir)
{
    char *path = plft_join(dir, "contact-sheet.png");
    int rc = path == NULL ? PLFT_DATA : plft_png_write_rgb8(path, s->rgb, s->w, s->h);

    free(path);
    return rc;
}

static int write_all(const plft_field *field, const char *dir, const plfx_offset *at,
                     int n)
{
    plft_square sq = {0, 0, NULL, NULL};
    sheet s = {NULL, 0, 0, 0, 0, 0, 0, 1, 1};
    plft_frame f;
    int k, rc;

    rc = plft_frame_alloc(&f, (unsigned long)field->nx, (unsigned long)field->ny, 1,
                          dir);
    f.bits = field->bits;
    rc = rc != 0 ? rc
                 : plft_square_init(&sq, &field->lut->lattice, field->nx, field->ny);
    rc = rc != 0 ? rc : sheet_init(&s, &sq, n);
    for (k = 0; k < n && rc == 0; k++) {
        rc = write_view(field, dir, at[k], k, &f);
        rc = rc != 0 ? rc : sheet_add(&s, &sq, &f, at[k], k);
        plft_progress("views", (double)(k + 1) / n);
    }
    rc = rc != 0 ? rc : write_sheet(&s, dir);
    /* Last: a folder with views.json is whole. */
    rc = rc != 0 ? rc : plft_views_json_write(field, dir, at, n);
    free(s.rgb);
    plft_square_free(&sq);
    plft_frame_free(&f);
    return rc;
}

static int choose(request *r, const plft_field *field, plfx_offset **at, int *n)
{
    char rest;

    if (r->views != NULL && strcmp(r->views, "all") == 0) {
        return plft_arrange_all(field, r->wish.radius, at, n);
    }
    if (r->views != NULL && (sscanf(r->views, "%d%c", &r->wish.n, &rest) != 1 ||
                             r->wish.n < 2 || r->wish.n > PLFX_VIEWS_MAX)) {
        return plft_fail(PLFT_USAGE, "--views %s: want all, or 2 to %d", r->views,
                         PLFX_VIEWS_MAX);
    }
    *at = (plfx_offset *)plft_alloc(PLFX_VIEWS_MAX, sizeof **at);
    r->wish.u_only = r->axes;
    return *at == NULL ? PLFT_DATA : plft_arrange(field, &r->wish, *at, n);
}

static int run(request *r)
{
    plft_field field;
    plfx_offset *at = NULL;
    int n = 0, rc;

    rc = plft_field_open(&field, &r->source);
    if (rc != 0) {
        return rc;
    }
    rc = choose(r, &field, &at, &n);
    rc = rc != 0 ? rc : plft_folder_make(r->dir);
    rc = rc != 0 ? rc : write_all(&field, r->dir, at, n);
    if (rc == 0) {
        printf("%s: %d views of %d x %d, %d bits\n", r->dir, n, field.nx, field.ny,
               field.bits);
    }
    free(at);
    plft_field_free(&field);
    return rc;
}

static const plft_usage usage = {
    "views", "RAW --lut CAM.plut -o DIR [options]",
    "Sub-aperture views, one sample a lens, as PNG files of 16 bits, with views.json "
    "that\n"
    "says where each looks (depth --views-dir DIR takes it up) and a contact sheet.  "
    "Views\n"
    "of hexagonal arrays are lens-indexed too; the contact sheet is resampled."};

int plft_cmd_views(int argc, char **argv)
{
    request r;
    const char *operand[1] = {NULL};
    int n, helped, rc;
    const plft_option own[] = {
        {"-o", PLFT_TEXT, &r.dir, "DIR", 0, 0, "folder for the views"},
        {"--views", PLFT_TEXT, &r.views, "N|all", 0, 0,
         "rings of 4 and the centre; all: every whole pixel of the lens; 9"},
        {"--method", PLFT_WORD, &r.wish.method, PLFT_METHODS, 0, 0,
         "the views that depth --method takes; plenoptic"},
        {"--axes", PLFT_WORD, &r.axes, "uv|u", 0, 0, "u: none off the u axis"},
        {"--adjacent", PLFT_FLAG, &r.wish.adjacent, NULL, 0, 0,
         "only the views one step from the centre"},
        {"--radius", PLFT_REAL, &r.wish.radius, "R", 0.1, 127,
         "of the outermost views, pixels; the table's"},
        {"--step", PLFT_REAL, &r.wish.step, "S", 0.1, 127,
         "of gradient and --adjacent, pixels; a third of R"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    plft_option options[PLFT_OPTIONS_MAX];

    memset(&r, 0, sizeof r);
    plft_source_options(options, own, &r.source, 0);
    r.wish.method = PLFT_PLENOPTIC;
    rc = plft_args(argc, argv, &usage, options, operand, 1, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    r.source.raw = operand[0];
    return r.dir != NULL ? run(&r) : plft_fail(PLFT_USAGE, "want -o DIR");
}
