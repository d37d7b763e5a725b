/* SPDX-License-Identifier: MIT */
#include "depth_out.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/colour.h"
#include "common/err.h"
#include "common/frame.h"
#include "common/memory.h"
#include "common/out.h"
#include "common/pfm.h"
#include "common/ply.h"
#include "common/square.h"

int plft_depth_check_paths(const plft_depth_paths *p)
{
    const char *all[8];
    size_t i, k;

    all[0] = p->slope;
    all[1] = p->confidence;
    all[2] = p->sigma;
    all[3] = p->flags;
    all[4] = p->png;
    all[5] = p->png16;
    all[6] = p->ply;
    all[7] = p->depth_mm;
    for (i = 0; i < 8; i++) {
        for (k = 0; k < i && all[i] != NULL; k++) {
            if (all[k] != NULL && strcmp(all[i], all[k]) == 0) {
                return plft_fail(PLFT_USAGE, "%s is named for two outputs", all[i]);
            }
        }
        if (plft_out_check(all[i]) != 0) {
            return PLFT_DATA;
        }
    }
    return 0;
}

/* Slope in the light field's unit, NaN where none. */
static float slope_of(const plft_field *field, const plfx_map *map, size_t i)
{
    int32_t s = map->slope_q16[i];

    return s == PLFX_SLOPE_NONE ? (float)NAN : (float)(s / 65536.0 * field->scale);
}

static float sigma_of(const plft_field *field, const plfx_map *map, size_t i)
{
    return map->sigma_u20[i] == PLFX_SIGMA_NONE
               ? (float)NAN
               : (float)(map->sigma_u20[i] / 1048576.0 * field->scale);
}

static int write_colour(const plft_field *field, const float *v, const char *path)
{
    plft_square sq;
    float *flat;
    int rc = plft_square_init(&sq, field->lut != NULL ? &field->lut->lattice : NULL,
                              field->nx, field->ny);

    if (rc != 0) {
        return rc;
    }
    flat = (float *)plft_alloc((size_t)sq.w * (size_t)sq.h, sizeof *flat);
    rc = flat == NULL ? PLFT_DATA : 0;
    if (rc == 0) {
        plft_square_map(&sq, v, field->nx, flat);
        rc = plft_colour_png(path, flat, sq.w, sq.h, 0.0f, 0.0f, 0,
                             field->lut != NULL ? "slope, lens pitches per pixel"
                                                : "slope, pixels per view");
    }
    free(flat);
    plft_square_free(&sq);
    return rc;
}

/* Grey: 1 .. 65535 from the least to the greatest slope, 0 where none. */
static int write_grey(const plft_field *field, const float *v, const char *path)
{
    size_t i, n = (size_t)field->nx * (size_t)field->ny;
    float lo = INFINITY, hi = -INFINITY;
    plft_frame f;
    int rc = plft_frame_alloc(&f, (unsigned long)field->nx, (unsigned long)field->ny, 1,
                              path);

    if (rc != 0) {
        return rc;
    }
    for (i = 0; i < n; i++) {
        lo = v[i] < lo ? v[i] : lo;
        hi = v[i] > hi ? v[i] : hi;
    }
    for (i = 0; i < n; i++) {
        float t = hi > lo ? (v[i] - lo) / (hi - lo) : 0.5f;
        f.px[i] = isnan(v[i]) ? 0
                              : (uint16_t)(1.5f + t * 65534.0f > 65535.0f
                                               ? 65535
                                               : 1.5f + t * 65534.0f);
    }
    f.bits = 16;
    rc = plft_png_write(path, &f);
    plft_frame_free(&f);
    return rc;
}

static int write_flags(const plft_field *field, const plfx_map *map, const char *path)
{
    size_t i, n = (size_t)field->nx * (size_t)field->ny;
    plft_frame f;
    int rc = plft_frame_alloc(&f, (unsigned long)field->nx, (unsigned long)field->ny, 1,
                              path);

    if (rc != 0) {
        return rc;
    }
    for (i = 0; i < n; i++) {
        f.px[i] = map->flags[i];
    }
    f.bits = 8;
    rc = plft_png_write(path, &f);
    plft_frame_free(&f);
    return rc;
}

/* Slope in the unit in which the optics were given. */
static int32_t scaled_slope(const plft_field *field, int32_t s)
{
    return s == PLFX_SLOPE_NONE ? s : s * field->scale;
}

static float depth_mm(const plft_field *field, const plft_optics *o, int32_t slope)
{
    uint32_t um;

    if (slope == PLFX_SLOPE_NONE) {
        return (float)NAN;
    }
    um = plfx_depth_um(plfx_inv_depth_q24(&o->line, scaled_slope(field, slope)));
    return um == UINT32_MAX ? (float)INFINITY : (float)(um / 1000.0);
}

/* Position of lens (i,j) from the middle of the array, in lens pitches. */
static void lens_xy(const plft_field *field, int i, int j, double *x, double *y)
{
    const plfx_lattice *l;
    double pitch, s;

    *x = i - (field->nx - 1) / 2.0;
    *y = j - (field->ny - 1) / 2.0;
    if (field->lut == NULL) {
        return;
    }
    l = &field->lut->lattice;
    pitch = plfx_lut_pitch_q16(field->lut) * 64.0; /* q22 */
    s = j % 2 != 0 ? 1.0 : 0.0;
    {
        double col = *x, row = *y;
        *x = (col * l->a.x_q22 + row * l->b.x_q22 + s * l->odd.x_q22) / pitch;
        *y = (col * l->a.y_q22 + row * l->b.y_q22 + s * l->odd.y_q22) / pitch;
    }
}

/* With the whole optics: x, y, z in millimetres, through the middle of the main lens
 * (the image is inverted: x and y as in the picture).  With 1/d alone: x, y in lens
 * pitches, z in millimetres.  Without: z is minus the slope, so that near is up. */
static int write_ply(const plft_field *field, const plfx_map *map, const plft_optics *o,
                     const char *path)
{
    int metric = o != NULL && o->f_mm > 0.0 && o->pitch_mm > 0.0;
    size_t n = 0;
    plft_point3 *p =
        (plft_point3 *)plft_alloc((size_t)field->nx * (size_t)field->ny, sizeof *p);
    int i, j, rc;

    if (p == NULL) {
        return PLFT_DATA;
    }
    for (j = 0; j < field->ny; j++) {
        for (i = 0; i < field->nx; i++) {
            size_t at = (size_t)j * (size_t)field->nx + (size_t)i;
            double x, y;
            float z = o != NULL ? depth_mm(field, o, map->slope_q16[at])
                                : -slope_of(field, map, at);
            if (!isfinite(z)) {
                continue;
            }
            lens_xy(field, i, j, &x, &y);
            p[n].x = (float)(metric ? x * o->pitch_mm * (double)z / o->f_mm : x);
            p[n].y = (float)(metric ? y * o->pitch_mm * (double)z / o->f_mm : y);
            p[n].z = z;
            p[n].confidence = (float)(map->conf_u16[at] / 65536.0);
            p[n].sigma = sigma_of(field, map, at);
            n++;
        }
    }
    rc = plft_ply_write(path, p, n,
                        metric ? "x y z in mm; sigma in slope"
                        : o != NULL
                            ? "x y in lens pitches, z in mm; sigma in slope"
                            : "x y in lens pitches, z minus slope; sigma in slope");
    free(p);
    return rc;
}

static int write_plane(const plft_field *field, const plfx_map *map,
                       const plft_optics *o, const char *path, char what)
{
    size_t i, n = (size_t)field->nx * (size_t)field->ny;
    float *v = (float *)plft_alloc(n, sizeof *v);
    int rc;

    if (v == NULL) {
        return PLFT_DATA;
    }
    for (i = 0; i < n; i++) {
        switch (what) {
        case 'c':
            v[i] = (float)(map->conf_u16[i] / 65536.0);
            break;
        case 's':
            v[i] = sigma_of(field, map, i);
            break;
        case 'd':
            v[i] = depth_mm(field, o, map->slope_q16[i]);
            break;
        default:
            v[i] = slope_of(field, map, i);
            break;
        }
    }
    rc = what == 'p'   ? write_colour(field, v, path)
         : what == 'g' ? write_grey(field, v, path)
                       : plft_pfm_write(path, v, field->nx, field->ny);
    free(v);
    return rc;
}

int plft_depth_write(const plft_field *field, const plfx_map *map, const plft_optics *o,
                     const plft_depth_paths *p)
{
    int rc = 0;

    rc = p->confidence != NULL ? write_plane(field, map, o, p->confidence, 'c') : rc;
    rc = rc == 0 && p->sigma != NULL ? write_plane(field, map, o, p->sigma, 's') : rc;
    rc = rc == 0 && p->depth_mm != NULL ? write_plane(field, map, o, p->depth_mm, 'd')
                                        : rc;
    rc = rc == 0 && p->flags != NULL ? write_flags(field, map, p->flags) : rc;
    rc = rc == 0 && p->png != NULL ? write_plane(field, map, o, p->png, 'p') : rc;
    rc = rc == 0 && p->png16 != NULL ? write_plane(field, map, o, p->png16, 'g') : rc;
    rc = rc == 0 && p->ply != NULL ? write_ply(field, map, o, p->ply) : rc;
    /* The map last: where it stands, everything stands. */
    return rc == 0 ? write_plane(field, map, o, p->slope, 'm') : rc;
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;

    return (x > y) - (x < y);
}

int plft_depth_count(const plft_field *field, const plfx_map *map,
                     plft_depth_stats *stats)
{
    size_t i, n = (size_t)field->nx * (size_t)field->ny, m = 0;
    float *v = (float *)plft_alloc(n, sizeof *v);
    int bit;

    memset(stats, 0, sizeof *stats);
    stats->lo = stats->median = stats->hi = (double)NAN;
    if (v == NULL) {
        return PLFT_DATA;
    }
    for (i = 0; i < n; i++) {
        if (map->slope_q16[i] != PLFX_SLOPE_NONE) {
            v[m++] = slope_of(field, map, i);
        }
        for (bit = 0; bit < 7; bit++) {
            stats->flags[bit] += map->flags[i] >> bit & 1;
        }
    }
    qsort(v, m, sizeof *v, by_value);
    stats->lenses = (long)n;
    stats->measured = (long)m;
    if (m > 0) {
        stats->lo = (double)v[(m - 1) / 100];
        stats->median = (double)v[m / 2];
        stats->hi = (double)v[m - 1 - (m - 1) / 100];
    }
    free(v);
    return 0;
}
