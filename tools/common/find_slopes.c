/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/device.h"
#include "common/err.h"
#include "common/memory.h"
#include "common/match.h"

#define LABEL_STEP  0.25 /* lenses in the outermost view */
#define LABELS_LO   9
#define LABELS_HI   96
#define SAMPLES_MIN 12
#define RAW_REACH   3.0  /* lenses in the inner view: over any camera's parallax */
#define ARRAY_REACH 12.0 /* pixels a view step */
#define CROWD       0.01 /* share of the samples at an end that asks for more range */
#define EXTENSIONS  3
#define SIDE_LEAST  192 /* of views of an array, folded for the search */
#define FOLD_WINDOW 5   /* on folded views: small things count too */
#define WEAK                                                                           \
    (PLFX_FLAG_TEXTURE | PLFX_FLAG_EDGE | PLFX_FLAG_RANGE_END | PLFX_FLAG_UNIQUE)

/* A pair of views: |offset| from the reference, in u. */
static double baseline(const plfx_cfg *cfg, int k)
{
    return hypot(cfg->at[k].u_q8 - cfg->at[0].u_q8, cfg->at[k].v_q8 - cfg->at[0].v_q8) /
           256.0;
}

/* Keep the views of the shortest (or longest) baseline. */
static void keep_ring(plfx_cfg *to, const plfx_cfg *from, int inner)
{
    double r = baseline(from, 1);
    int k, n = 1;

    for (k = 2; k < from->n; k++) {
        double b = baseline(from, k);
        r = inner ? fmin(r, b) : fmax(r, b);
    }
    *to = *from;
    for (k = 1; k < from->n; k++) {
        if (fabs(baseline(from, k) - r) < 1.0 / 256.0) {
            to->at[n++] = from->at[k];
        }
    }
    to->n = (uint8_t)n;
    to->method = PLFX_METHOD_PAIRS;
    to->cost = PLFX_COST_ZNCC;
    to->fit = PLFX_FIT_PARABOLA;
    to->fuse = PLFX_FUSE_MEDIAN;
    to->unique_u16 = 0;
}

static int by_slope(const void *a, const void *b)
{
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;

    return (x > y) - (x < y);
}

static int by_conf(const void *a, const void *b)
{
    return (int)*(const uint16_t *)a - (int)*(const uint16_t *)b;
}

/* Median confidence of the good samples. */
static uint16_t middle(const plfx_map *map, size_t n)
{
    uint16_t *c = (uint16_t *)plft_alloc(n, sizeof *c);
    uint16_t mid;
    size_t i, m = 0;

    if (c == NULL) {
        return 0;
    }
    for (i = 0; i < n; i++) {
        if (map->slope_q16[i] != PLFX_SLOPE_NONE && (map->flags[i] & WEAK) == 0) {
            c[m++] = map->conf_u16[i];
        }
    }
    qsort(c, m, sizeof *c, by_conf);
    mid = m > 0 ? c[m / 2] : 0;
    free(c);
    return mid;
}

/* Percentiles `cut` and 1 - cut of the better half of the samples, in slope units.
 * Number of samples. */
static size_t spread(const plfx_map *map, double cut, double *lo, double *hi)
{
    size_t n = (size_t)map->w * (size_t)map->h, i, m = 0, off;
    uint16_t mid = middle(map, n);
    int32_t *s = (int32_t *)plft_alloc(n, sizeof *s);

    if (s == NULL) {
        return 0;
    }
    for (i = 0; i < n; i++) {
        if (map->slope_q16[i] != PLFX_SLOPE_NONE && (map->flags[i] & WEAK) == 0 &&
            map->conf_u16[i] >= mid) {
            s[m++] = map->slope_q16[i];
        }
    }
    qsort(s, m, sizeof *s, by_slope);
    if (m > 0) {
        off = (size_t)(cut * (double)(m - 1));
        *lo = s[off] / 65536.0;
        *hi = s[m - 1 - off] / 65536.0;
    }
    free(s);
    return m;
}

static int labels_for(double span, double r)
{
    int n = (int)ceil(span * r / LABEL_STEP) + 1;

    return n < LABELS_LO ? LABELS_LO : n > LABELS_HI ? LABELS_HI : n;
}

/* Share of the confident samples within a label of `end`. */
static double crowd(const plfx_map *map, double end, double label)
{
    size_t n = (size_t)map->w * (size_t)map->h, i, m = 0, near = 0;
    uint16_t least = middle(map, n);

    for (i = 0; i < n; i++) {
        if (map->slope_q16[i] != PLFX_SLOPE_NONE && map->conf_u16[i] >= least &&
            (map->flags[i] & PLFX_FLAG_TEXTURE) == 0) {
            m++;
            near += fabs(map->slope_q16[i] / 65536.0 - end) < label;
        }
    }
    return m > 0 ? (double)near / (double)m : 0.0;
}

/* Large views of an array are searched at 1/fold of their size. */
static int fold_of(const plft_field *field)
{
    int side = field->nx < field->ny ? field->nx : field->ny;
    int fold = 1;

    while (field->lut == NULL && side / (2 * fold) >= SIDE_LEAST) {
        fold *= 2;
    }
    return fold;
}

/* Means of fold x fold samples: into the same memory, which no row outruns. */
static void fold_views(plfx_views *v, int fold)
{
    int nx = v->nx / fold, ny = v->ny / fold, i, k, x, y;
    unsigned area = (unsigned)(fold * fold);

    for (i = 0; i < nx * ny * v->n; i++) {
        unsigned sum = area / 2;
        x = i % nx;
        k = i / nx % v->n;
        for (y = 0; y < fold; y++) {
            const uint16_t *row =
                v->px +
                ((size_t)(i / nx / v->n * fold + y) * (size_t)v->n + (size_t)k) *
                    (size_t)v->nx +
                (size_t)(x * fold);
            int j;
            for (j = 0; j < fold; j++) {
                sum += row[j];
            }
        }
        v->px[i] = (uint16_t)(sum / area);
    }
    v->nx = nx;
    v->ny = ny;
}

static int match_folded(const plfx_plan *plan, const plft_field *field, int fold,
                        const plfx_map *map, plft_times *times)
{
    double t0 = plft_cpu_s(), t1;
    plfx_views views;
    int rc = plft_field_views(field, plan->cfg.at, plan->cfg.n, &views);

    t1 = plft_cpu_s();
    times->extract += t1 - t0;
    if (rc == 0) {
        fold_views(&views, fold);
        rc = plft_device_match(field->device, plan, &views, map);
        free(views.px);
    }
    times->match += plft_cpu_s() - t1;
    return rc;
}

/* Match over lo .. hi with the views of `cfg`. */
static int coarse_map(const plft_field *field, plfx_cfg *cfg, double lo, double hi,
                      plfx_map *map, plft_times *times)
{
    int fold = fold_of(field);
    plft_field small = *field;
    plfx_plan plan;
    size_t i;
    int rc;

    small.nx /= fold;
    small.ny /= fold;
    small.scale *= fold;
    cfg->labels = (uint16_t)labels_for(hi - lo, baseline(cfg, 1) / fold);
    cfg->slope_min_q16 = (int32_t)lround(lo / fold * 65536.0);
    cfg->slope_max_q16 = (int32_t)lround(hi / fold * 65536.0);
    cfg->window =
        fold > 1 && cfg->window > FOLD_WINDOW ? (uint8_t)FOLD_WINDOW : cfg->window;
    rc = plft_plan(&plan, cfg, &small);
    rc = rc != 0 ? rc : plft_slopes_alloc(map, small.nx, small.ny);
    if (rc != 0 || fold == 1) {
        return rc != 0 ? rc : plft_match(&plan, field, map, times);
    }
    rc = match_folded(&plan, field, fold, map, times);
    for (i = 0; rc == 0 && i < (size_t)small.nx * (size_t)small.ny; i++) {
        if (map->slope_q16[i] != PLFX_SLOPE_NONE) {
            map->slope_q16[i] *= fold;
        }
    }
    return rc;
}

/* One coarse match over lo .. hi: replaces them by what was found there, an end that
 * many samples lie at moved outwards.  *more: an end was. */
static int narrow(const plft_field *field, plfx_cfg *cfg, double cut, double *lo,
                  double *hi, int *more, plft_times *times)
{
    plfx_map map = {NULL, NULL, NULL, NULL, 0, 0, 0};
    double lo0 = *lo, hi0 = *hi, label = 0.0, pad;
    size_t m = 0;
    int rc = coarse_map(field, cfg, *lo, *hi, &map, times);

    *more = 0;
    if (rc == 0) {
        label = (hi0 - lo0) / (cfg->labels - 1);
        m = spread(&map, cut, lo, hi);
    }
    if (rc == 0 && m < SAMPLES_MIN) {
        rc = plft_fail(PLFT_DATA,
                       "the scene shows too little texture to find its slopes; "
                       "give --slopes MIN:MAX:N");
    }
    if (rc == 0) {
        pad = fmax(2.0 * label, 0.1 * (*hi - *lo));
        *lo -= pad;
        *hi += pad;
        if (crowd(&map, lo0, label) > CROWD) {
            *lo = lo0 - 0.3 * (hi0 - lo0);
            *more = 1;
        }
        if (crowd(&map, hi0, label) > CROWD) {
            *hi = hi0 + 0.3 * (hi0 - lo0);
            *more = 1;
        }
    }
    plft_slopes_free(&map);
    return rc;
}

/* Slopes worth a look at a baseline: shifts of at most a third of the map. */
static double widest(const plft_field *field, double r)
{
    double reach = field->lut != NULL ? RAW_REACH / r : ARRAY_REACH / field->scale;
    int side = field->nx < field->ny ? field->nx : field->ny;

    return fmin(fmin(reach, side / 3.0 / r), 7.9);
}

int plft_find_slopes(const plft_field *field, const plfx_cfg *cfg, double *lo,
                     double *hi, int *labels, plft_times *times)
{
    plfx_cfg coarse;
    double limit, outer, least;
    int rc, more = 1, k;

    keep_ring(&coarse, cfg, 1);
    limit = widest(field, baseline(&coarse, 1));
    *lo = -limit;
    *hi = limit;
    rc = narrow(field, &coarse, 0.01, lo, hi, &more, times);
    keep_ring(&coarse, cfg, 0);
    outer = baseline(&coarse, 1);
    least = -widest(field, outer) * 2.0;
    for (k = 0, more = 1; k < EXTENSIONS && more && rc == 0; k++) {
        *lo = fmax(fmax(*lo, least), -7.9);
        *hi = fmin(fmin(*hi, -least), 7.9);
        rc = narrow(field, &coarse, 0.005, lo, hi, &more, times);
    }
    *lo = fmax(*lo, -8.0);
    *hi = fmin(*hi, 8.0);
    *labels = labels_for(*hi - *lo, outer);
    return rc;
}
