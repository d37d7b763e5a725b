/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "common/field.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/band_pass.h"
#include "common/err.h"
#include "common/folder.h"
#include "common/memory.h"
#include "common/field_raw.h"
#include "common/views_json.h"

static int parse_grid(const char *text, int *rows, int *cols)
{
    char rest;

    if (sscanf(text, "%dx%d%c", rows, cols, &rest) != 2 || *rows < 1 || *cols < 1 ||
        *rows > 64 || *cols > 64 || *rows * *cols < 2) {
        return plft_fail(PLFT_USAGE, "--grid %s: want ROWSxCOLUMNS, 2 to 64 x 64 views",
                         text);
    }
    return 0;
}

/* The convention of the HCI benchmark: a point of disparity d is seen in view (r,c)
 * at x - d (c - cc), y - d (r - rc).  With u = -(c - cc), v = -(r - rc) that is x +
 * d u. */
static int grid_offsets(plft_field *field, const char *dir, const plft_names *names,
                        int rows, int cols)
{
    int k;

    field->ready = (plft_ready *)plft_alloc((size_t)names->n, sizeof *field->ready);
    if (field->ready == NULL) {
        return PLFT_DATA;
    }
    field->n_ready = names->n;
    for (k = 0; k < names->n; k++) {
        field->ready[k].path = plft_join(dir, names->name[k]);
        if (field->ready[k].path == NULL) {
            return PLFT_DATA;
        }
        field->ready[k].at.u_q8 = (int16_t)((cols / 2 - k % cols) * 256);
        field->ready[k].at.v_q8 = (int16_t)((rows / 2 - k / cols) * 256);
    }
    field->radius = (cols > 1 ? cols - 1 : rows - 1) / 2;
    field->radius = field->radius < 1.0 ? 1.0 : field->radius;
    field->reach = 64.0;
    return 0;
}

static int open_grid(plft_field *field, const plft_source *s)
{
    plft_names names;
    int rows, cols, rc;

    rc = parse_grid(s->grid, &rows, &cols);
    if (rc != 0) {
        return rc;
    }
    rc = plft_folder_numbered(&names, s->dir, s->pattern);
    if (rc != 0) {
        return rc;
    }
    if (names.n != rows * cols) {
        rc = plft_fail(PLFT_DATA,
                       "%s: %d numbered PNG files%s where --grid %s wants %d; move the "
                       "others away or give --pattern",
                       s->dir, names.n, s->pattern != NULL ? " of that pattern" : "",
                       s->grid, rows * cols);
    } else {
        if (names.ignored > 0) {
            plft_warn("%s: ignored are %d PNG files without a number at their end, or "
                      "not of the pattern: %s",
                      s->dir, names.ignored, names.some);
        }
        rc = grid_offsets(field, s->dir, &names, rows, cols);
    }
    plft_names_free(&names);
    return rc;
}

/* Size of the views, from the first. */
static int ready_size(plft_field *field, int view_bits)
{
    plft_frame f;
    int rc = plft_frame_read(&f, field->ready[0].path, 0);

    if (rc != 0) {
        return rc;
    }
    if (field->nx == 0) {
        field->nx = f.w;
        field->ny = f.h;
        field->bits = view_bits != 0 ? view_bits : f.bits > 8 ? 12 : 10;
    }
    if (f.w > PLFX_LENSES_MAX || f.h > PLFX_LENSES_MAX) {
        rc = plft_fail(PLFT_DATA, "%s: %d x %d; a view may have %d on a side",
                       field->ready[0].path, f.w, f.h, PLFX_LENSES_MAX);
    }
    plft_frame_free(&f);
    return rc;
}

static int open_dir(plft_field *field, const plft_source *s)
{
    char *json = plft_join(s->dir, "views.json");
    int rc;

    if (json == NULL) {
        return PLFT_DATA;
    }
    field->scale = 1;
    if (s->grid == NULL && access(json, F_OK) == 0) {
        rc = plft_views_json_read(field, s->dir);
    } else if (s->grid == NULL) {
        rc = plft_fail(PLFT_USAGE, "%s: no views.json in it; give --grid ROWSxCOLUMNS",
                       s->dir);
    } else {
        rc = open_grid(field, s);
    }
    free(json);
    return rc != 0 ? rc : ready_size(field, s->view_bits);
}

int plft_field_open(plft_field *field, const plft_source *s)
{
    int rc;

    memset(field, 0, sizeof *field);
    if (s->dir != NULL && s->raw != NULL) {
        return plft_fail(PLFT_USAGE, "give a raw frame or --views-dir, not both");
    }
    if (s->dir == NULL && s->raw == NULL) {
        return plft_fail(PLFT_USAGE, "want a raw frame, or --views-dir DIR");
    }
    if (s->raw != NULL && s->lut == NULL) {
        return plft_fail(PLFT_USAGE,
                         "want --lut CAM.plut, the lens table; make it with "
                         "plenofix calibrate");
    }
    rc = s->dir != NULL ? open_dir(field, s) : plft_field_open_raw(field, s);
    if (rc != 0) {
        plft_field_free(field);
    }
    return rc;
}

void plft_field_rescale(plft_field *field, double slope)
{
    int k;

    while (field->lut == NULL && field->ready != NULL && slope / field->scale > 7.0 &&
           field->scale < 4) {
        field->scale *= 2;
        for (k = 0; k < field->n_ready; k++) {
            field->ready[k].at.u_q8 = (int16_t)(field->ready[k].at.u_q8 * 2);
            field->ready[k].at.v_q8 = (int16_t)(field->ready[k].at.v_q8 * 2);
        }
    }
}

/* u in 1/256, halves away from zero. */
static int16_t to_q8(double u)
{
    long q = lround(u * 256.0);

    return (int16_t)(q < -32768 ? -32768 : q > 32767 ? 32767 : q);
}

/* Sensor pixels, or view steps times the scale. */
static long apart(plfx_offset a, plfx_offset b)
{
    long du = (long)a.u_q8 - b.u_q8, dv = (long)a.v_q8 - b.v_q8;

    return du * du + dv * dv;
}

plfx_offset plft_field_offset(const plft_field *field, double u, double v)
{
    double scale = field->scale > 0 ? field->scale : 1;
    plfx_offset want, best;
    int k;

    want.u_q8 = to_q8(u * scale);
    want.v_q8 = to_q8(v * scale);
    if (field->ready == NULL) {
        return want;
    }
    best = field->ready[0].at;
    for (k = 1; k < field->n_ready; k++) {
        if (apart(field->ready[k].at, want) < apart(best, want)) {
            best = field->ready[k].at;
        }
    }
    return best;
}

static const plft_ready *find_ready(const plft_field *field, plfx_offset at)
{
    int k;

    for (k = 0; k + 1 < field->n_ready; k++) {
        if (apart(field->ready[k].at, at) == 0) {
            break;
        }
    }
    return &field->ready[k];
}

/* Foreign pictures become view samples of field->bits: luma and depth in one
 * rounding.  What is saturated stays so: 255 of 8 bits is not 1020 of 1023. */
static uint16_t view_sample(const plft_frame *f, size_t i, int bits)
{
    const uint16_t *p = f->px + (size_t)f->channels * i;
    uint64_t luma = f->channels == 3 ? 299u * (uint64_t)p[0] + 587u * (uint64_t)p[1] +
                                           114u * (uint64_t)p[2]
                                     : 1000u * (uint64_t)p[0];
    uint64_t one = (uint64_t)1000u << f->bits;
    uint64_t s = ((luma << bits) + one / 2) / one;
    uint64_t max = ((uint64_t)1 << bits) - 1u;

    return (uint16_t)(luma < 1000u * (((uint64_t)1 << f->bits) - 1u) && s < max ? s
                                                                                : max);
}

static int load_ready(const plft_field *field, const plft_ready *r,
                      const plfx_views *to, int k)
{
    plft_frame f;
    int x, y;
    /* Views of our own hold samples of field->bits in a 16-bit file. */
    int rc = plft_frame_read(&f, r->path, field->lut != NULL ? field->bits : 0);

    if (rc != 0) {
        return rc;
    }
    if (f.w != field->nx || f.h != field->ny) {
        rc = plft_fail(PLFT_DATA, "%s: %d x %d where the first view has %d x %d",
                       r->path, f.w, f.h, field->nx, field->ny);
    }
    for (y = 0; y < f.h && rc == 0; y++) {
        uint16_t *row =
            to->px + ((size_t)y * (size_t)to->n + (size_t)k) * (size_t)to->nx;
        for (x = 0; x < f.w; x++) {
            row[x] = view_sample(&f, (size_t)y * (size_t)f.w + (size_t)x, field->bits);
        }
    }
    plft_frame_free(&f);
    return rc;
}

int plft_field_views(const plft_field *field, const plfx_offset *at, int n,
                     plfx_views *views)
{
    int k, rc = 0;

    views->nx = field->nx;
    views->ny = field->ny;
    views->n = n;
    views->px = (uint16_t *)plft_alloc(
        (size_t)field->nx * (size_t)field->ny * (size_t)n, sizeof *views->px);
    if (views->px == NULL) {
        return PLFT_DATA;
    }
    for (k = 0; k < n && rc == 0; k++) {
        rc = field->ready != NULL
                 ? load_ready(field, find_ready(field, at[k]), views, k)
                 : plft_field_extract(field, at[k], views, k);
    }
    if (rc == 0 && field->band_pass) {
        rc = plft_band_pass(views, field->bits);
    }
    if (rc != 0) {
        free(views->px);
        views->px = NULL;
    }
    return rc;
}

void plft_field_free(plft_field *field)
{
    int k;

    for (k = 0; k < field->n_ready; k++) {
        free(field->ready[k].path);
    }
    free(field->ready);
    free(field->lens);
    plft_frame_free(&field->frame);
    plft_frame_free(&field->white);
    plft_table_free(&field->table);
    memset(field, 0, sizeof *field);
}
