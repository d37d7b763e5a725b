/* SPDX-License-Identifier: MIT */
#include "motion/series.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/err.h"
#include "common/folder.h"
#include "common/memory.h"
#include "motion/plan.h"
#include "motion/regions.h"

void plft_series_options(plft_option *table, plft_series_wish *w)
{
    const plft_option own[PLFT_SERIES_OPTIONS] = {
        {"--lut", PLFT_TEXT, &w->table, "CAM.plut", 0, 0, "lens table"},
        {"--regions", PLFT_TEXT, &w->regions, "R.csv", 0, 0, "regions, as of monitor"},
        {"--bits", PLFT_INT, &w->bits, "N", 8, 16, "significant bits of 16-bit files"},
        {"--rest", PLFT_INT, &w->rest, "N", 1, PLFX_ROI_REST_MAX,
         "frames of the rest state (8)"},
        {"--views", PLFT_INT, &w->views, "N", 5, 97, "centre and cross of views (25)"},
        {"--radius", PLFT_REAL, &w->radius, "R", 1, 127, "of the cross, pixels"}};

    memcpy(table, own, sizeof own);
}

static int configure(plft_series *s, const plft_series_wish *w)
{
    double at[PLFX_VIEWS_MAX][2];
    double radius;
    int rc = plft_table_read(&s->table, w->table);
    int k;

    rc = rc ? rc : plft_regions_read(&s->cfg, w->regions);
    if (rc != 0) {
        return rc;
    }
    radius = w->radius > 0 ? w->radius : s->table.lut.radius_q8 / 256.0 - 0.5;
    plft_plan_cross(at, 4 * ((w->views - 1) / 4) + 1, fmax(radius, 1.0));
    s->cfg.lut = &s->table.lut;
    s->cfg.tone = plfx_tone_unity(12);
    s->cfg.views = 4 * ((w->views - 1) / 4) + 1;
    for (k = 0; k < s->cfg.views; k++) {
        s->cfg.at[k].u_q8 = (int16_t)lround(256.0 * at[k][0]);
        s->cfg.at[k].v_q8 = (int16_t)lround(256.0 * at[k][1]);
    }
    s->cfg.rest = w->rest;
    s->cfg.steps = 2;
    s->cfg.residual_q8 = 640;
    return 0;
}

/* ---- frames ---- */

static int make_room(plft_series *s)
{
    size_t one = (size_t)s->cfg.regions * sizeof *s->at;
    plfx_roi_result *more;

    if ((size_t)s->frames < s->room) {
        return 0;
    }
    s->room = s->room ? 2 * s->room : 256;
    more = realloc(s->at, s->room * one);
    if (more == NULL) {
        return plft_fail(PLFT_DATA, "out of memory after %d frames", s->frames);
    }
    s->at = more;
    return 0;
}

static int take(plft_series *s, plfx_roi *roi, const plfx_camera_frame *f, int number)
{
    plfx_roi_frame frame = {&f->raw, NULL};
    plfx_status status;

    if (f->raw.w != s->table.lut.sensor_w || f->raw.h != s->table.lut.sensor_h) {
        return plft_fail(PLFT_DATA, "frame %d: %d x %d where the table is for %d x %d",
                         number, (int)f->raw.w, (int)f->raw.h, s->table.lut.sensor_w,
                         s->table.lut.sensor_h);
    }
    if (roi->rested < s->cfg.rest) {
        s->first = number + 1;
        status = plfx_roi_rest(roi, &frame);
    } else {
        if (make_room(s)) {
            return PLFT_DATA;
        }
        status = plfx_roi_measure(roi, &frame,
                                  s->at + (size_t)s->frames * (size_t)s->cfg.regions);
        s->frames++;
    }
    return status == PLFX_OK ? 0 : plft_fail(PLFT_DATA, "frame %d: cut short", number);
}

static int roll(plft_series *s, plfx_roi *roi, const plft_wish *wish)
{
    plfx_camera_frame f;
    plft_camera c;
    int number = 0;
    int rc = plft_camera_start(&c, wish);

    if (rc != 0) {
        return rc;
    }
    if (c.cfg.bayer != 0) {
        rc = plft_fail(PLFT_USAGE, "%s: regions want a grey sensor", c.name);
    }
    while (rc == 0 && (rc = plft_camera_next(&c, &f)) == 0) {
        rc = take(s, roi, &f, number++);
        plft_camera_release(&c, &f);
    }
    plft_camera_report(&c);
    plft_camera_stop(&c);
    return rc < 0 ? 0 : rc;
}

static int measure(plft_series *s, const plft_wish *wish)
{
    size_t size = plfx_roi_ws(&s->cfg);
    plfx_roi *roi = plft_alloc(1, sizeof *roi);
    void *ws = plft_alloc_ws(size > 0 ? size : 1);
    plfx_status status = PLFX_E_SIZE;
    int rc = PLFT_DATA;

    if (roi != NULL && ws != NULL) {
        status = plfx_roi_init(roi, &s->cfg, ws, size);
        rc = status == PLFX_OK ? roll(s, roi, wish)
             : status == PLFX_E_RANGE
                 ? plft_fail(PLFT_DATA, "regions want a square lattice")
                 : plft_fail(PLFT_DATA, "regions or views out of range");
    }
    free(ws);
    free(roi);
    return rc;
}

/* The pictures of a folder in the order of their numbers. */
static int of_folder(const char *folder, char ***paths, int *n)
{
    plft_names names;
    int rc = plft_folder_numbered(&names, folder, NULL);
    int k;

    if (rc != 0) {
        return rc;
    }
    *paths = plft_alloc((size_t)names.n, sizeof **paths);
    for (k = 0; *paths != NULL && k < names.n; k++) {
        (*paths)[k] = plft_join(folder, names.name[k]);
        rc = (*paths)[k] == NULL ? PLFT_DATA : rc;
        *n = k + 1;
    }
    plft_names_free(&names);
    return *paths != NULL ? rc : PLFT_DATA;
}

int plft_series_take(plft_series *s, const plft_series_wish *w)
{
    struct stat st;
    plft_wish wish;
    char **paths = NULL;
    int n = 0, rc, k;

    memset(s, 0, sizeof *s);
    if (w->n < 1 || w->table == NULL || w->regions == NULL) {
        return plft_fail(PLFT_USAGE, "want %s",
                         w->n < 1 ? "frames: a folder, pictures or a recording"
                         : w->table == NULL ? "--lut CAM.plut"
                                            : "--regions R.csv");
    }
    plft_wish_none(&wish);
    wish.bits = w->bits;
    wish.names = w->names;
    wish.n = w->n;
    rc = configure(s, w);
    if (rc == 0 && w->n == 1 && stat(w->names[0], &st) == 0 && S_ISDIR(st.st_mode)) {
        rc = of_folder(w->names[0], &paths, &n);
        wish.names = (const char *const *)paths;
        wish.n = n;
    }
    rc = rc ? rc : measure(s, &wish);
    for (k = 0; k < n; k++) {
        free(paths[k]);
    }
    free(paths);
    return rc;
}

/* ---- values ---- */

static const plfx_roi_result *result(const plft_series *s, int t, int k)
{
    return s->at + (size_t)t * (size_t)s->cfg.regions + (size_t)k;
}

double plft_series_value(const plft_series *s, int t, int k, int axis)
{
    const plfx_roi_result *r = result(s, t, k);
    int32_t v = axis == 0 ? r->u_q24 : axis == 1 ? r->v_q24 : r->w_q24;

    return r->flags || v == PLFX_ROI_NONE ? (double)NAN : ldexp(v, -24);
}

double plft_series_sigma(const plft_series *s, int t, int k, int axis)
{
    const plfx_roi_result *r = result(s, t, k);
    uint32_t v = axis == 0   ? r->u_sigma_q24
                 : axis == 1 ? r->v_sigma_q24
                             : r->w_sigma_q24;

    return r->flags ? (double)NAN : ldexp(v, -24);
}

void plft_series_free(plft_series *s)
{
    free(s->at);
    plft_table_free(&s->table);
    memset(s, 0, sizeof *s);
}
