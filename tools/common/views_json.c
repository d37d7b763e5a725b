/* SPDX-License-Identifier: MIT */
#include "common/views_json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/folder.h"
#include "common/json.h"
#include "common/memory.h"

#define UNITS "sensor pixels from the lens centre, v a quarter turn after u"
#define SIGN  "positive slope: the image moves with the offset"

void plft_view_name(char *to, size_t room, int k)
{
    (void)snprintf(to, room, "view_%03d.png", k);
}

/* Two integers of an array. */
static int pair(const json_t *object, const char *key, double limit, int32_t *x,
                int32_t *y, const char *name)
{
    const json_t *a = json_object_get(object, key);
    double v[2];
    size_t k;

    for (k = 0; k < 2; k++) {
        const json_t *item = json_array_get(a, k);
        v[k] = json_number_value(item);
        if (!json_is_integer(item) || fabs(v[k]) > limit || json_array_size(a) != 2) {
            return plft_fail(PLFT_DATA, "%s: \"%s\" must be two whole numbers", name,
                             key);
        }
    }
    *x = (int32_t)v[0];
    *y = (int32_t)v[1];
    return 0;
}

static int whole(const json_t *object, const char *key, double lo, double hi, int *to,
                 const char *name)
{
    double v = 0.0;
    int rc = plft_json_real(object, key, lo, hi, 1, &v, name);

    *to = (int)v;
    return rc;
}

static int read_lattice(plfx_lattice *l, const json_t *o, const char *name)
{
    const double q22 = 2147483647.0;
    int kind = 0, nx = 0, ny = 0;

    if (whole(o, "kind", 0, 1, &kind, name) != 0 ||
        whole(o, "nx", 1, PLFX_LENSES_MAX, &nx, name) != 0 ||
        whole(o, "ny", 1, PLFX_LENSES_MAX, &ny, name) != 0 ||
        pair(o, "origin_q16", q22, &l->origin.x_q16, &l->origin.y_q16, name) != 0 ||
        pair(o, "a_q22", q22, &l->a.x_q22, &l->a.y_q22, name) != 0 ||
        pair(o, "b_q22", q22, &l->b.x_q22, &l->b.y_q22, name) != 0 ||
        pair(o, "odd_q22", q22, &l->odd.x_q22, &l->odd.y_q22, name) != 0) {
        return PLFT_DATA;
    }
    l->kind = kind;
    l->nx = nx;
    l->ny = ny;
    if ((int64_t)l->a.x_q22 * l->b.y_q22 == (int64_t)l->a.y_q22 * l->b.x_q22) {
        return plft_fail(PLFT_DATA, "%s: the lattice steps are parallel", name);
    }
    return 0;
}

static int words(const json_t *root, const char *key, const char *want,
                 const char *name)
{
    const char *got = json_string_value(json_object_get(root, key));

    if (got == NULL || strcmp(got, want) != 0) {
        return plft_fail(PLFT_DATA,
                         "%s: \"%s\" must read \"%s\"; this program knows no "
                         "other convention",
                         name, key, want);
    }
    return 0;
}

static int read_view(plft_ready *to, const json_t *o, const char *dir, const char *name)
{
    const char *file = json_string_value(json_object_get(o, "file"));
    double u = 0.0, v = 0.0;

    if (file == NULL || file[0] == '\0' || strchr(file, '/') != NULL) {
        return plft_fail(PLFT_DATA, "%s: a view without a \"file\" of its folder",
                         name);
    }
    if (plft_json_real(o, "u", -127.0, 127.0, 1, &u, name) != 0 ||
        plft_json_real(o, "v", -127.0, 127.0, 1, &v, name) != 0) {
        return PLFT_DATA;
    }
    to->at.u_q8 = (int16_t)lround(u * 256.0);
    to->at.v_q8 = (int16_t)lround(v * 256.0);
    to->path = plft_join(dir, file);
    return to->path != NULL ? 0 : PLFT_DATA;
}

static int read_views(plft_field *field, const json_t *list, const char *dir,
                      const char *name)
{
    size_t k, n = json_array_size(list);
    int rc = 0;

    if (n < 2 || n > 4096) {
        return plft_fail(PLFT_DATA, "%s: \"views\" must list 2 to 4096 views", name);
    }
    field->ready = (plft_ready *)plft_alloc(n, sizeof *field->ready);
    if (field->ready == NULL) {
        return PLFT_DATA;
    }
    field->n_ready = (int)n;
    for (k = 0; k < n && rc == 0; k++) {
        rc = read_view(&field->ready[k], json_array_get(list, k), dir, name);
    }
    return rc;
}

static int read_lenses(plft_field *field, const json_t *root, const char *dir)
{
    const char *file = json_string_value(json_object_get(root, "lenses"));
    plft_frame f;
    char *path;
    size_t i, n = (size_t)field->nx * (size_t)field->ny;
    int rc;

    if (file == NULL) {
        return 0;
    }
    path = plft_join(dir, file);
    field->lens = (uint8_t *)plft_alloc(n, 1);
    rc = path == NULL || field->lens == NULL ? PLFT_DATA : plft_frame_read(&f, path, 0);
    if (rc == 0) {
        if (f.w != field->nx || f.h != field->ny || f.channels != 1) {
            rc = plft_fail(PLFT_DATA, "%s: not of the size of the lattice", path);
        }
        for (i = 0; i < n && rc == 0; i++) {
            field->lens[i] = (uint8_t)f.px[i];
        }
        plft_frame_free(&f);
    }
    free(path);
    return rc;
}

static int read_root(plft_field *field, const json_t *root, const char *dir,
                     const char *name)
{
    const json_t *lattice = json_object_get(root, "lattice");

    if (words(root, "units", UNITS, name) != 0 ||
        words(root, "sign", SIGN, name) != 0 ||
        whole(root, "bits", PLFX_BITS_MIN, PLFX_BITS_MAX, &field->bits, name) != 0 ||
        plft_json_real(root, "radius", 0.1, 127.0, 1, &field->radius, name) != 0) {
        return PLFT_DATA;
    }
    if (!json_is_object(lattice)) {
        return plft_fail(PLFT_DATA, "%s: \"lattice\" is missing", name);
    }
    if (read_lattice(&field->shell.lattice, lattice, name) != 0) {
        return PLFT_DATA;
    }
    field->lut = &field->shell;
    field->nx = field->shell.lattice.nx;
    field->ny = field->shell.lattice.ny;
    field->reach = plfx_lut_pitch_q16(field->lut) / 131072.0;
    if (read_lenses(field, root, dir) != 0) {
        return PLFT_DATA;
    }
    return read_views(field, json_object_get(root, "views"), dir, name);
}

int plft_views_json_read(plft_field *field, const char *dir)
{
    char *path = plft_join(dir, "views.json");
    json_t *root = NULL;
    int rc = path != NULL ? plft_json_read(&root, path) : PLFT_DATA;

    if (rc == 0) {
        rc = read_root(field, root, dir, path);
        json_decref(root);
    }
    free(path);
    return rc;
}

static json_t *lattice_json(const plfx_lattice *l)
{
    return json_pack("{s:i,s:i,s:i,s:[i,i],s:[i,i],s:[i,i],s:[i,i]}", "kind", l->kind,
                     "nx", l->nx, "ny", l->ny, "origin_q16", l->origin.x_q16,
                     l->origin.y_q16, "a_q22", l->a.x_q22, l->a.y_q22, "b_q22",
                     l->b.x_q22, l->b.y_q22, "odd_q22", l->odd.x_q22, l->odd.y_q22);
}

static int write_lenses(const plft_field *field, const char *dir)
{
    plft_frame f;
    char *path = plft_join(dir, "lenses.png");
    size_t i, n = (size_t)field->nx * (size_t)field->ny;
    int rc = path == NULL ? PLFT_DATA
                          : plft_frame_alloc(&f, (unsigned long)field->nx,
                                             (unsigned long)field->ny, 1, "lenses");

    if (rc == 0) {
        f.bits = 8;
        for (i = 0; i < n; i++) {
            f.px[i] = field->lens[i];
        }
        rc = plft_png_write(path, &f);
        plft_frame_free(&f);
    }
    free(path);
    return rc;
}

int plft_views_json_write(const plft_field *field, const char *dir,
                          const plfx_offset *at, int n)
{
    json_t *views = json_array();
    json_t *root;
    char *path = plft_join(dir, "views.json");
    int k, rc;

    for (k = 0; k < n; k++) {
        char file[32];
        plft_view_name(file, sizeof file, k);
        (void)json_array_append_new(views, json_pack("{s:s,s:f,s:f}", "file", file, "u",
                                                     at[k].u_q8 / 256.0, "v",
                                                     at[k].v_q8 / 256.0));
    }
    root = json_pack("{s:s,s:s,s:i,s:f,s:o}", "units", UNITS, "sign", SIGN, "bits",
                     field->bits, "radius", field->radius, "lattice",
                     lattice_json(&field->lut->lattice));
    rc = root == NULL || path == NULL ? PLFT_DATA : 0;
    if (rc == 0 && field->lens != NULL) {
        rc = write_lenses(field, dir);
        (void)json_object_set_new(root, "lenses", json_string("lenses.png"));
    }
    if (rc == 0) {
        (void)json_object_set(root, "views", views);
        rc = plft_json_write(path, root);
    }
    json_decref(views);
    json_decref(root);
    free(path);
    return rc;
}
