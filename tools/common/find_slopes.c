/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/device.h"
#include "common/err.h"
#include "common/memory.h"
#include "common/match.h"

#define LABEL_STEP  0.25 /* lenses in the outermost view, */
#define COARSE_STEP 0.5  /* and of a search, which fits between labels */
#define LABELS_LO   9
#define LABELS_HI   96
#define SAMPLES_MIN 12
#define RAW_REACH   3.0  /* lenses in the inner view: over any camera's parallax */
#define ARRAY_REACH 12.0 /* pixels a view step */
#define CROWD       0.01 /* share of the samples at an end that asks for more range */
#define EXTENSIONS  3
#define SIDE_LEAST  192 /* of views of an array, folded for the search */
#define FOLD_WINDOW 5   /* on folded views: small things count too */
#define BINS        65536
#define TILE        16 /* samples on a side */
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
    to->fit = to->cost == PLFX_COST_SAD ? PLFX_FIT_VEE : PLFX_FIT_PARABOLA;
    to->fuse = PLFX_FUSE_MEDIAN;
    to->unique_u16 = 0;
}

static int measured(const plfx_map *map, size_t i)
{
    return map->slope_q16[i] != PLFX_SLOPE_NONE && (map->flags[i] & WEAK) == 0;
}

/* Value of rank `rank` among the counts of BINS bins. */
static int of_rank(const uint32_t *count, size_t rank)
{
    size_t seen = count[0];
    int k = 0;

    while (seen <= rank && k < BINS - 1) {
        seen += count[++k];
    }
    return k;
}

/* Confidences are compared with those nearby, so that what is less textured than the
 * rest is in the range too.  In 256ths. */
typedef struct bar {
    int across;      /* tiles in a row */
    uint8_t *least;  /* [tile] median of its good samples, half of the map's at least */
    uint32_t *count; /* [BINS] to work with */
} bar;

static int median_in(const plfx_map *map, uint32_t *count, int x0, int y0, int side)
{
    int x1 = x0 + side < map->w ? x0 + side : map->w;
    int y1 = y0 + side < map->h ? y0 + side : map->h;
    size_t m = 0;
    int x, y;

    memset(count, 0, 256 * sizeof *count);
    for (y = y0; y < y1; y++) {
        for (x = x0; x < x1; x++) {
            size_t i = (size_t)y * (size_t)map->stride + (size_t)x;
            count[map->conf_u16[i] >> 8] += (unsigned)measured(map, i);
            m += (size_t)measured(map, i);
        }
    }
    return m > 0 ? of_rank(count, m / 2) : 0;
}

static int raise_bar(bar *b, const plfx_map *map)
{
    int down = (map->h + TILE - 1) / TILE;
    int all, k;

    b->across = (map->w + TILE - 1) / TILE;
    b->least = (uint8_t *)plft_alloc((size_t)(b->across * down), 1);
    b->count = (uint32_t *)plft_alloc(BINS, sizeof *b->count);
    if (b->least == NULL || b->count == NULL) {
        return PLFT_DATA;
    }
    all = median_in(map, b->count, 0, 0, map->w > map->h ? map->w : map->h);
    for (k = 0; k < b->across * down; k++) {
        int here =
            median_in(map, b->count, k % b->across * TILE, k / b->across * TILE, TILE);
        b->least[k] = (uint8_t)(here > all / 2 ? here : all / 2);
    }
    return 0;
}

static int sure(const bar *b, const plfx_map *map, size_t i)
{
    int x = (int)(i % (size_t)map->w), y = (int)(i / (size_t)map->w);

    return map->conf_u16[i] >> 8 >= b->least[y / TILE * b->across + x / TILE];
}

/* Percentiles `cut` and 1 - cut of the sure samples, in slope units, of slopes
 * between *lo and *hi.  Number of samples. */
static size_t spread(const plfx_map *map, const bar *b, double cut, double *lo,
                     double *hi)
{
    double bin = (*hi - *lo) / (BINS - 1), first = *lo;
    size_t n = (size_t)map->w * (size_t)map->h, i, m = 0, off;

    memset(b->count, 0, BINS * sizeof *b->count);
    for (i = 0; i < n; i++) {
        if (measured(map, i) && sure(b, map, i)) {
            double k = (map->slope_q16[i] / 65536.0 - first) / bin + 0.5;
            b->count[k < 0.0 ? 0 : k > BINS - 1 ? BINS - 1 : (int)k]++;
            m++;
        }
    }
    if (m > 0) {
        off = (size_t)(cut * (double)(m - 1));
        *lo = first + bin * of_rank(b->count, off);
        *hi = first + bin * of_rank(b->count, m - 1 - off);
    }
    return m;
}

static int labels_for(double span, double r, double step)
{
    int n = (int)ceil(span * r / step) + 1;

    return n < LABELS_LO ? LABELS_LO : n > LABELS_HI ? LABELS_HI : n;
}

/* Share of the sure samples within a label of `end`. */
static double crowd(const plfx_map *map, const bar *b, double end, double label)
{
    size_t n = (size_t)map->w * (size_t)map->h, i, m = 0, near = 0;

    for (i = 0; i < n; i++) {
        if (map->slope_q16[i] != PLFX_SLOPE_NONE &&
            (map->flags[i] & PLFX_FLAG_TEXTURE) == 0 && sure(b, map, i)) {
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
    cfg->labels = (uint16_t)labels_for(hi - lo, baseline(cfg, 1) / fold, COARSE_STEP);
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

/* Replaces lo .. hi by what a map over them found, an end that many samples lie at
 * moved outwards.  *more: an end was. */
static int settle(const plfx_map *map, const bar *b, double label, double cut,
                  double *lo, double *hi, int *more)
{
    double lo0 = *lo, hi0 = *hi, pad;

    if (spread(map, b, cut, lo, hi) < SAMPLES_MIN) {
        return plft_fail(PLFT_DATA,
                         "the scene shows too little texture to find its slopes; "
                         "give --slopes MIN:MAX:N");
    }
    pad = fmax(label, 0.1 * (*hi - *lo));
    *lo -= pad;
    *hi += pad;
    if (crowd(map, b, lo0, label) > CROWD) {
        *lo = lo0 - 0.3 * (hi0 - lo0);
        *more = 1;
    }
    if (crowd(map, b, hi0, label) > CROWD) {
        *hi = hi0 + 0.3 * (hi0 - lo0);
        *more = 1;
    }
    return 0;
}

/* One coarse match over lo .. hi, which it replaces. */
static int narrow(const plft_field *field, plfx_cfg *cfg, double cut, double *lo,
                  double *hi, int *more, plft_times *times)
{
    plfx_map map = {NULL, NULL, NULL, NULL, 0, 0, 0};
    bar b = {0, NULL, NULL};
    int rc = coarse_map(field, cfg, *lo, *hi, &map, times);
    double t0 = plft_cpu_s();

    *more = 0;
    rc = rc != 0 ? rc : raise_bar(&b, &map);
    if (rc == 0) {
        rc = settle(&map, &b, (*hi - *lo) / (cfg->labels - 1), cut, lo, hi, more);
    }
    times->match += plft_cpu_s() - t0;
    free(b.least);
    free(b.count);
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
    *labels = labels_for(*hi - *lo, outer, LABEL_STEP);
    return rc;
}
