/* SPDX-License-Identifier: MIT
 * Figures of a domino scene: bench_dominoes SCENE.json DIR TABLE, DIR as written by
 * `plenofix simulate`, TABLE calibrated from its frames.  Exit status 1 when a figure
 * misses its limit. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/csv.h"
#include "common/err.h"
#include "common/frame.h"
#include "common/field.h"
#include "common/json.h"
#include "common/match.h"
#include "common/memory.h"
#include "common/pfm.h"
#include "plenofix/plenofix.h"

#define FACES_MAX 16
#define EDGE      5  /* lenses kept off depth edges and the border */
#define WIDE      24 /* lenses: least width of a face that counts */
#define WINDOW    9
#define CLIP      0.1
#define LABELS    31
#define INNER_MIN 25 /* lenses well inside a face that counts */
#define ACROSS    4  /* views of one axis besides the centre */

typedef struct bench {
    json_t *scene;
    plft_field field; /* the frame, dark subtracted, white divided out */
    plft_frame ids;
    plft_map truth, depth;
    plfx_optics optics;
    uint8_t *inner; /* [ny][nx] id of the face that a lens lies well inside; else 0 */
    int face[FACES_MAX], faces;
    int band; /* id of the untextured object, 0: none */
    double u; /* the usable radius of the table: R - 2.5 px */
    int missed;
} bench;

typedef struct result { /* a map of slopes and confidence */
    int32_t *slope;
    uint16_t *conf;
} result;

/* ---- statistics ---- */

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return x < y ? -1 : x > y;
}

static double median(double *v, int n)
{
    if (n == 0) {
        return NAN;
    }
    qsort(v, (size_t)n, sizeof *v, by_value);
    return n & 1 ? v[n / 2] : 0.5 * (v[n / 2 - 1] + v[n / 2]);
}

/* 1.4826 times the median distance from the median; sorts v. */
static double spread(double *v, int n)
{
    double m = median(v, n);
    int i;

    for (i = 0; i < n; i++) {
        v[i] = fabs(v[i] - m);
    }
    return 1.4826 * median(v, n);
}

/* ---- the table of figures ---- */

static void figure(bench *b, const char *what, double got, const char *limit, int ok)
{
    printf("  %-58s %9.5f   %-9s %s\n", what, got, limit, ok ? "pass" : "FAIL");
    b->missed += !ok;
}

static void note(const char *what, double got)
{
    printf("  %-58s %9.5f\n", what, got);
}

/* ---- input ---- */

static int path_of(char *path, size_t size, const char *dir, const char *file)
{
    int n = snprintf(path, size, "%s/%s", dir, file);

    return n < 0 || (size_t)n >= size ? plft_fail(PLFT_DATA, "%s: path too long", dir)
                                      : 0;
}

static int load_frames(bench *b, const char *dir, const char *table)
{
    static const char *const files[3] = {"scene.png", "white.png", "dark.png"};
    char path[4][4096];
    plft_source source;
    int k;

    for (k = 0; k < 3; k++) {
        if (path_of(path[k], sizeof path[k], dir, files[k])) {
            return PLFT_DATA;
        }
    }
    memset(&source, 0, sizeof source);
    source.raw = path[0];
    source.white = path[1];
    source.dark = path[2];
    source.lut = table;
    source.bits = 12;
    return plft_field_open(&b->field, &source) ||
           path_of(path[3], sizeof path[3], dir, "objects.png") ||
           plft_frame_read(&b->ids, path[3], 8);
}

static int load_truth(bench *b, const char *dir)
{
    char path[4096];
    json_t *resolved;
    double inv0 = 0.0;
    double gain = 0.0;

    if (path_of(path, sizeof path, dir, "slope.pfm") ||
        plft_pfm_read(&b->truth, path) ||
        path_of(path, sizeof path, dir, "depth_mm.pfm") ||
        plft_pfm_read(&b->depth, path) ||
        path_of(path, sizeof path, dir, "scene_resolved.json") ||
        plft_json_read(&resolved, path)) {
        return PLFT_DATA;
    }
    if (plft_json_real(resolved, "inv0", -128, 128, 1, &inv0, path) ||
        plft_json_real(resolved, "gain", -1e4, 1e4, 1, &gain, path)) {
        return PLFT_DATA;
    }
    json_decref(resolved);
    b->optics.inv0_q24 = (int32_t)lround(inv0 * 16777216.0);
    b->optics.gain_q24 = llround(gain * 16777216.0);
    if (b->truth.w != b->field.nx || b->truth.h != b->field.ny) {
        return plft_fail(PLFT_DATA, "the table has %dx%d lenses, the scene %dx%d",
                         b->field.nx, b->field.ny, b->truth.w, b->truth.h);
    }
    return 0;
}

/* ---- faces ---- */

static int alone(const bench *b, int i, int j)
{
    int nx = b->truth.w;
    int ny = b->truth.h;
    int x, y;

    if (i < EDGE || j < EDGE || i >= nx - EDGE || j >= ny - EDGE) {
        return 0;
    }
    for (y = j - EDGE; y <= j + EDGE; y++) {
        for (x = i - EDGE; x <= i + EDGE; x++) {
            if (b->ids.px[y * nx + x] != b->ids.px[j * nx + i]) {
                return 0;
            }
        }
    }
    return 1;
}

/* Longest run of an object in a lens row. */
static int width_of(const bench *b, int id)
{
    int nx = b->truth.w;
    int widest = 0;
    int run = 0;
    int k;

    for (k = 0; k < nx * b->truth.h; k++) {
        run = b->ids.px[k] == id ? (k % nx == 0 ? 1 : run + 1) : 0;
        widest = run > widest ? run : widest;
    }
    return widest;
}

static int textured(const bench *b, int id)
{
    const json_t *object =
        json_array_get(json_object_get(b->scene, "objects"), (size_t)(id - 1));
    const char *pattern = json_string_value(
        json_object_get(json_object_get(object, "texture"), "pattern"));

    return pattern == NULL || strcmp(pattern, "none") != 0;
}

static const char *name_of(const bench *b, int id)
{
    const json_t *object =
        json_array_get(json_object_get(b->scene, "objects"), (size_t)(id - 1));
    const char *name = json_string_value(json_object_get(object, "name"));

    return name != NULL ? name : "?";
}

/* Mark the lenses well inside any object; returns 0 or PLFT_DATA. */
static int find_inner(bench *b)
{
    int nx = b->truth.w;
    int ny = b->truth.h;
    int i, j;

    b->inner = plft_alloc((size_t)nx * (size_t)ny, 1);
    if (b->inner == NULL) {
        return PLFT_DATA;
    }
    for (j = 0; j < ny; j++) {
        for (i = 0; i < nx; i++) {
            b->inner[j * nx + i] =
                (uint8_t)(alone(b, i, j) ? b->ids.px[j * nx + i] : 0);
        }
    }
    return 0;
}

static int inner_of(const bench *b, int id)
{
    int n = 0;
    int k;

    for (k = 0; k < b->truth.w * b->truth.h; k++) {
        n += b->inner[k] == id;
    }
    return n;
}

static int find_faces(bench *b)
{
    int objects = (int)json_array_size(json_object_get(b->scene, "objects"));
    int id;

    if (find_inner(b)) {
        return PLFT_DATA;
    }
    for (id = 1; id <= objects && b->faces < FACES_MAX; id++) {
        if (!textured(b, id)) {
            b->band = id;
        } else if (width_of(b, id) >= WIDE && inner_of(b, id) >= INNER_MIN) {
            b->face[b->faces++] = id;
        }
    }
    return 0;
}

/* ---- measurement ---- */

static int measure(const bench *b, const plfx_cfg *cfg, result *out)
{
    size_t n = (size_t)b->truth.w * (size_t)b->truth.h;
    plft_times times = {0.0, 0.0, 0.0, 0.0};
    plfx_plan plan;
    plfx_map map;

    memset(&map, 0, sizeof map);
    out->slope = map.slope_q16 = plft_alloc(n, sizeof *map.slope_q16);
    out->conf = map.conf_u16 = plft_alloc(n, sizeof *map.conf_u16);
    map.w = map.stride = b->truth.w;
    map.h = b->truth.h;
    if (out->slope == NULL || out->conf == NULL) {
        return PLFT_DATA;
    }
    return plft_plan(&plan, cfg, &b->field) ||
           plft_match(&plan, &b->field, &map, &times);
}

static void drop(result *r)
{
    free(r->slope);
    free(r->conf);
}

static void put_view(plfx_cfg *cfg, double u, double v)
{
    cfg->at[cfg->n].u_q8 = (int16_t)lround(u * 256.0);
    cfg->at[cfg->n].v_q8 = (int16_t)lround(v * 256.0);
    cfg->n++;
}

/* Centre first.  Shifts are rounded to sixteenths of a lens; labels two of them apart
 * at offset u lie on that grid, and 31 reach beyond the truth of the scenes. */
static plfx_cfg pairs(double u, plfx_fuse_rule fuse)
{
    double top = (LABELS - 1) / 2 / (8.0 * u);
    plfx_cfg cfg;

    memset(&cfg, 0, sizeof cfg);
    cfg.method = PLFX_METHOD_PAIRS;
    cfg.cost = PLFX_COST_ZNCC;
    cfg.fit = PLFX_FIT_PARABOLA;
    cfg.fuse = (uint8_t)fuse;
    cfg.window = WINDOW;
    cfg.bits = 12;
    cfg.labels = LABELS;
    cfg.slope_min_q16 = (int32_t)lround(-65536.0 * top);
    cfg.slope_max_q16 = -cfg.slope_min_q16;
    put_view(&cfg, 0.0, 0.0);
    return cfg;
}

static plfx_cfg binocular(double u)
{
    plfx_cfg cfg = pairs(u, PLFX_FUSE_MEDIAN);

    put_view(&cfg, u, 0.0);
    return cfg;
}

static plfx_cfg plenoptic(double u, int axes, plfx_fuse_rule fuse)
{
    static const double part[ACROSS] = {-1.0, -0.5, 0.5, 1.0};
    plfx_cfg cfg = pairs(u, fuse);
    int k;

    for (k = 0; k < ACROSS; k++) {
        put_view(&cfg, part[k] * u, 0.0);
    }
    for (k = 0; k < ACROSS && axes > 1; k++) {
        put_view(&cfg, 0.0, part[k] * u);
    }
    return cfg;
}

static plfx_cfg gradient(double step)
{
    plfx_cfg cfg = pairs(step, PLFX_FUSE_MEDIAN);

    cfg.method = PLFX_METHOD_GRADIENT;
    put_view(&cfg, -step, 0.0);
    put_view(&cfg, step, 0.0);
    put_view(&cfg, 0.0, -step);
    put_view(&cfg, 0.0, step);
    return cfg;
}

/* ---- judgement ---- */

static double error_of(const bench *b, const result *r, int k)
{
    return r->slope[k] / 65536.0 - (double)b->truth.v[k];
}

/* Errors of a face into e; the number of lenses in *all. */
static int errors(const bench *b, const result *r, int id, double *e, int *all)
{
    int n = b->truth.w * b->truth.h;
    int got = 0;
    int k;

    *all = 0;
    for (k = 0; k < n; k++) {
        if (b->inner[k] == id) {
            (*all)++;
            if (r->slope[k] != PLFX_SLOPE_NONE) {
                e[got++] = error_of(b, r, k);
            }
        }
    }
    return got;
}

typedef struct score {
    double rms, share, noise;
} score;

static score score_of(const bench *b, const result *r, double *e)
{
    score s = {0.0, 0.0, 0.0};
    double noise[FACES_MAX];
    double square = 0.0;
    long got = 0;
    long all = 0;
    int f, k;

    for (f = 0; f < b->faces; f++) {
        int lenses;
        int n = errors(b, r, b->face[f], e, &lenses);
        for (k = 0; k < n; k++) {
            double c = fabs(e[k]) > CLIP ? CLIP : e[k];
            square += c * c;
        }
        got += n;
        all += lenses;
        noise[f] = spread(e, n);
    }
    s.rms = sqrt(square / (double)(got > 0 ? got : 1));
    s.share = (double)got / (double)(all > 0 ? all : 1);
    s.noise = median(noise, b->faces);
    return s;
}

static int scored(const bench *b, const plfx_cfg *cfg, double *e, score *s)
{
    result r;
    int rc = measure(b, cfg, &r);

    if (rc == 0) {
        *s = score_of(b, &r, e);
    }
    drop(&r);
    return rc;
}

/* Calibration against the truth: lenses found and distance of their centres. */
static int judge_table(bench *b, const char *dir)
{
    char path[4096];
    plft_csv csv;
    double sum = 0.0;
    size_t k;
    int lost = 0;

    if (path_of(path, sizeof path, dir, "centres.csv") || plft_csv_read(&csv, path)) {
        return PLFT_DATA;
    }
    for (k = 0; k < csv.rows; k++) {
        const double *row = csv.v + 4 * k;
        plfx_point p = plfx_lut_centre(b->field.lut, (int32_t)row[1], (int32_t)row[0]);
        uint32_t flags = plfx_lut_flags(b->field.lut, (int32_t)row[1], (int32_t)row[0]);
        double dx = p.x_q16 / 65536.0 - row[2];
        double dy = p.y_q16 / 65536.0 - row[3];
        lost += (flags & (PLFX_LENS_MISSING | PLFX_LENS_INTERP)) != 0;
        sum += sqrt(dx * dx + dy * dy);
    }
    figure(b, "calibration: lenses not found", lost, "0", lost == 0);
    sum /= (double)csv.rows;
    figure(b, "calibration: mean error of a centre, px", sum, "<= 0.02", sum <= 0.02);
    plft_csv_free(&csv);
    return 0;
}

static int judge_stereo(bench *b, double *e)
{
    plfx_cfg two = binocular(b->u);
    plfx_cfg all = plenoptic(b->u, 2, PLFX_FUSE_MEDIAN);
    plfx_cfg paper = plenoptic(b->u, 1, PLFX_FUSE_CORRELATION);
    plfx_cfg both = plenoptic(b->u, 2, PLFX_FUSE_CORRELATION);
    score s2, s8, sp, sb;

    if (scored(b, &two, e, &s2) || scored(b, &all, e, &s8) ||
        scored(b, &paper, e, &sp) || scored(b, &both, e, &sb)) {
        return PLFT_DATA;
    }
    figure(b, "binocular: rms of slope error", s2.rms, "<= 0.025", s2.rms <= 0.025);
    figure(b, "binocular: share measured", s2.share, ">= 0.9", s2.share >= 0.9);
    note("binocular: noise", s2.noise);
    figure(b, "plenoptic, median of 8 pairs: rms", s8.rms, "<= 0.01", s8.rms <= 0.01);
    note("plenoptic, median of 8 pairs: share measured", s8.share);
    note("plenoptic, median of 8 pairs: noise", s8.noise);
    figure(b, "plenoptic noise over binocular noise", s8.noise / s2.noise, "<= 0.5",
           s8.noise <= 0.5 * s2.noise);
    note("correlation weights, horizontal pairs alone: rms", sp.rms);
    note("correlation weights, horizontal pairs alone: noise", sp.noise);
    note("correlation weights, all pairs: rms", sb.rms);
    note("correlation weights, all pairs: noise", sb.noise);
    return 0;
}

/* Median over a face of |depth/truth - 1|. */
static double depth_error(const bench *b, const result *r, int id, double *e)
{
    int n = b->truth.w * b->truth.h;
    int got = 0;
    int k;

    for (k = 0; k < n; k++) {
        if (b->inner[k] == id && r->slope[k] != PLFX_SLOPE_NONE) {
            uint32_t um = plfx_depth_um(plfx_inv_depth_q24(&b->optics, r->slope[k]));
            e[got++] = um / 1000.0 / (double)b->depth.v[k] - 1.0;
        }
    }
    return median(e, got);
}

static int judge_depth(bench *b, double *e)
{
    plfx_cfg cfg = plenoptic(b->u, 2, PLFX_FUSE_MEDIAN);
    char what[80];
    result r;
    int f;

    if (measure(b, &cfg, &r)) {
        return PLFT_DATA;
    }
    for (f = 0; f < b->faces; f++) {
        double off = 100.0 * depth_error(b, &r, b->face[f], e);
        (void)snprintf(what, sizeof what, "depth of %.30s: median error, %%",
                       name_of(b, b->face[f]));
        figure(b, what, off, "+-0.5", fabs(off) <= 0.5);
    }
    drop(&r);
    return 0;
}

/* Median confidence of an object, or of all faces (id 0). */
static double confidence(const bench *b, const result *r, int id, double *e)
{
    int n = b->truth.w * b->truth.h;
    int got = 0;
    int k;

    for (k = 0; k < n; k++) {
        if (id ? b->inner[k] == id : b->inner[k] != 0 && b->inner[k] != b->band) {
            e[got++] = r->conf[k] / 65536.0;
        }
    }
    return median(e, got);
}

static void judge_sign(bench *b, const result *r, double *e)
{
    double slope[FACES_MAX] = {0.0};
    char what[80];
    int f, k, lenses;

    for (f = 0; f < b->faces; f++) {
        int n = errors(b, r, b->face[f], e, &lenses);
        double off = median(e, n);
        for (k = 0; k < b->truth.w * b->truth.h && b->inner[k] != b->face[f]; k++) {
        }
        slope[f] = (double)b->truth.v[k];
        (void)snprintf(what, sizeof what, "gradient on %.30s (slope %+.4f)",
                       name_of(b, b->face[f]), slope[f]);
        figure(b, what, slope[f] + off, "sign", (slope[f] + off) * slope[f] > 0.0);
    }
}

static int judge_gradient(bench *b, double step, double *e)
{
    plfx_cfg cfg = gradient(step);
    result r;
    double square = 0.0;
    double band, all;
    long got = 0;
    int k;

    if (measure(b, &cfg, &r)) {
        return PLFT_DATA;
    }
    judge_sign(b, &r, e);
    for (k = 0; k < b->truth.w * b->truth.h; k++) {
        int face = b->inner[k] != 0 && b->inner[k] != b->band;
        if (face && r.slope[k] != PLFX_SLOPE_NONE &&
            fabs((double)b->truth.v[k]) * step <= 0.3) {
            square += error_of(b, &r, k) * error_of(b, &r, k);
            got++;
        }
    }
    square = sqrt(square / (double)(got > 0 ? got : 1));
    figure(b, "gradient: rms where |slope|*step <= 0.3", square, "<= 0.02",
           square <= 0.02);
    if (b->band) {
        band = confidence(b, &r, b->band, e);
        all = confidence(b, &r, 0, e);
        figure(b, "gradient: confidence of the untextured band, of the rest",
               band / all, "< 1/3", band < all / 3.0);
    }
    drop(&r);
    return 0;
}

static int run(bench *b, char **argv)
{
    double *e;
    int rc;

    if (plft_json_read(&b->scene, argv[1]) || load_frames(b, argv[2], argv[3]) ||
        load_truth(b, argv[2]) || find_faces(b)) {
        return PLFT_DATA;
    }
    b->u = b->field.radius;
    printf("%s: %dx%d lenses, %d faces, u = %.2f px\n", argv[1], b->truth.w, b->truth.h,
           b->faces, b->u);
    e = plft_alloc((size_t)b->truth.w * (size_t)b->truth.h, sizeof *e);
    if (e == NULL) {
        return PLFT_DATA;
    }
    rc = judge_table(b, argv[2]) || judge_stereo(b, e) || judge_depth(b, e) ||
         judge_gradient(b, 1.5, e);
    free(e);
    return rc ? PLFT_DATA : b->missed != 0;
}

int main(int argc, char **argv)
{
    bench b;
    int rc;

    if (argc != 4) {
        return plft_fail(PLFT_USAGE, "bench_dominoes SCENE.json DIR TABLE");
    }
    memset(&b, 0, sizeof b);
    rc = run(&b, argv);
    json_decref(b.scene);
    free(b.inner);
    plft_field_free(&b.field);
    plft_frame_free(&b.ids);
    plft_map_free(&b.truth);
    plft_map_free(&b.depth);
    return rc;
}
