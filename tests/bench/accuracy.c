/* SPDX-License-Identifier: MIT
 * Figures of the presets on scenes drawn here, and on a folder of views with truth.
 *
 *   bench_accuracy                        print scene,preset,noise,figure,value
 *   bench_accuracy --check ACCURACY.csv [DATA]
 *                     compare: worse by over 5 % and 0.05 fails; with DATA/hci4d_cotton
 *                     too, where it is
 *   bench_accuracy --double [DATA]        the same method in double beside fixed point:
 *                     fails over 0.1 point of BadPix(0.07) or 1 of BadPix(0.01)
 *   bench_accuracy --where                bad samples of the onboard preset by their
 *                     distance to a jump of the truth
 *   bench_accuracy --sigma [SEED]         true scatter over stated standard error on
 *                     scenes that nothing was set by, a line a noise: of all samples,
 *                     by fifths of the stated error, by scene with texture enough (no
 *                     flag TEXTURE); and what is left of BadPix 0.07, 0.03, 0.01, mean
 *                     over the shares kept, by it and by the margin.  Fails
 *                     when all samples, or over a quarter of the scenes, lie beyond
 *                     0.75 .. 1.25, and where the margin leaves fewer
 *
 * Scatter is 1.4826 times the median of |error| / stated error: samples on the wrong
 * surface, a few percent, are told by confidence and flags. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/field.h"
#include "common/match.h"
#include "common/memory.h"
#include "common/out.h"
#include "common/pfm.h"
#include "evaluate.h"
#include "plenofix/viewcheck.h"
#include "preset.h"
#include "ref_double.h"
#include "scene.h"

#define BORDER       15
#define VIEWS        9 /* a side */
#define SIGMA_FIRST  21
#define SIGMA_SCENES 8
#define NAMES                                                                          \
    {                                                                                  \
        "stream", "onboard", "precise"                                                 \
    }

typedef struct light { /* views of one scene for one preset */
    plfx_cfg cfg;
    plft_preset preset;
    plfx_views views;
    float *truth;
} light;

typedef struct maps {
    float *slope, *sigma, *trust;
    uint8_t *flags;
} maps;

static void make_cfg(light *l, int id, int side, double lo, double hi)
{
    plfx_offset at[VIEWS * VIEWS];
    uint8_t use[VIEWS * VIEWS];
    int k;

    memset(&l->cfg, 0, sizeof l->cfg);
    for (k = 0; k < VIEWS * VIEWS; k++) {
        at[k].u_q8 = (int16_t)(256 * (VIEWS / 2 - k % VIEWS));
        at[k].v_q8 = (int16_t)(256 * (VIEWS / 2 - k / VIEWS));
    }
    l->cfg.bits = 10;
    l->cfg.slope_min_q16 = (int32_t)lround(lo * 65536);
    l->cfg.slope_max_q16 = (int32_t)lround(hi * 65536);
    l->preset.id = id;
    if (plfx_preset(id, &l->cfg, &l->preset.frame) != PLFX_OK) {
        exit(1);
    }
    (void)plfx_preset_views(id, at, VIEWS * VIEWS, VIEWS * VIEWS / 2, use);
    for (k = 0; k < VIEWS * VIEWS; k++) {
        if (use[k]) {
            l->cfg.ref = k == VIEWS * VIEWS / 2 ? l->cfg.n : l->cfg.ref;
            l->cfg.at[l->cfg.n++] = at[k];
        }
    }
    l->cfg.labels = (uint16_t)plfx_preset_labels(
        id, l->cfg.slope_min_q16, l->cfg.slope_max_q16, 256 * (VIEWS / 2));
    l->views.nx = side;
    l->views.ny = side;
    l->views.n = l->cfg.n;
    l->views.px = plft_alloc((size_t)side * (size_t)side * l->cfg.n, 2);
    l->truth = plft_alloc((size_t)side * (size_t)side, sizeof *l->truth);
}

static void draw(light *l, uint64_t seed, double noise)
{
    static scene c;
    int side = l->views.nx;
    int x;
    int y;
    int k;

    scene_make(&c, seed);
    for (y = 0; y < side; y++) {
        for (x = 0; x < side; x++) {
            double d;
            (void)scene_ray(&c, x, y, 0, 0, &d);
            l->truth[y * side + x] = (float)d;
            for (k = 0; k < l->cfg.n; k++) {
                double g = scene_pixel(&c, x, y, l->cfg.at[k].u_q8 / 256.,
                                       l->cfg.at[k].v_q8 / 256.);
                double v = floor((g + noise * scene_gauss(&c)) * 4 + 0.5);
                l->views
                    .px[((size_t)y * l->cfg.n + (size_t)k) * (size_t)side + (size_t)x] =
                    (uint16_t)(v < 0      ? 0
                               : v > 1023 ? 1023
                                          : v);
            }
        }
    }
}

static maps match(light *l, double noise)
{
    size_t n = (size_t)l->views.nx * (size_t)l->views.ny;
    plfx_plan plan;
    plfx_map map;
    maps m;
    size_t bytes;
    void *ws;
    size_t i;

    l->preset.frame.noise_q4 = (uint16_t)lround(16 * noise);
    if (plfx_plan_init(&plan, &l->cfg, NULL, l->views.nx, l->views.ny) != PLFX_OK ||
        plft_slopes_alloc(&map, l->views.nx, l->views.ny) != 0) {
        exit(1);
    }
    bytes = plfx_frame_ws(&plan, &l->preset.frame);
    ws = plft_alloc_ws(bytes);
    if (plfx_frame(&plan, &l->preset.frame, &l->views, NULL, &map, ws, bytes) !=
        PLFX_OK) {
        exit(1);
    }
    m.slope = plft_alloc(n, sizeof *m.slope);
    m.sigma = plft_alloc(n, sizeof *m.sigma);
    m.trust = plft_alloc(n, sizeof *m.trust);
    m.flags = plft_alloc(n, 1);
    for (i = 0; i < n; i++) {
        m.slope[i] = (float)(map.slope_q16[i] / 65536.);
        m.sigma[i] = map.sigma_u20[i] == PLFX_SIGMA_NONE
                         ? NAN
                         : (float)(map.sigma_u20[i] / 1048576.);
        m.trust[i] = (float)(map.conf_u16[i] / 65536.);
        m.flags[i] = map.flags[i];
    }
    free(ws);
    plft_slopes_free(&map);
    return m;
}

static maps match_double(light *l)
{
    size_t n = (size_t)l->views.nx * (size_t)l->views.ny;
    plfx_plan plan;
    plfx_frame_state s;
    double *slope = plft_alloc(n, sizeof *slope);
    maps m = {plft_alloc(n, sizeof *m.slope), NULL, NULL, NULL};
    void *ws;
    size_t i;

    l->preset.frame.noise_q4 = 0;
    if (plfx_plan_init(&plan, &l->cfg, NULL, l->views.nx, l->views.ny) != PLFX_OK ||
        plfx_frame_derive(&s, &plan, &l->preset.frame, NULL) != PLFX_OK) {
        exit(1);
    }
    ws = plft_alloc_ws(plfx_frame_carve(&s, NULL));
    (void)plfx_frame_carve(&s, ws);
    plfx_frame_tables(&s, NULL);
    plfx_frame_load(&s, &l->views);
    ref_frame(&s, slope);
    for (i = 0; i < n; i++) {
        m.slope[i] = (float)slope[i];
    }
    free(ws);
    free(slope);
    return m;
}

/* Mean over the curve's shares kept, 90 .. 10 %. */
static double curve_mean(const double *curve)
{
    double sum = 0;
    int k;

    for (k = 1; k < PLFT_CURVE; k++) {
        sum += curve[k] / (PLFT_CURVE - 1);
    }
    return sum;
}

typedef struct left { /* bad pixels, percent, mean over the shares kept */
    double sigma[PLFT_BADPIX], margin[PLFT_BADPIX];
} left;

static double mean_of(const double *v)
{
    double sum = 0;
    int k;

    for (k = 0; k < PLFT_BADPIX; k++) {
        sum += v[k] / PLFT_BADPIX;
    }
    return sum;
}

static plft_figures judge(const light *l, const maps *m, double *ratio, left *kept)
{
    int side = l->views.nx;
    size_t n = (size_t)side * (size_t)l->views.ny;
    float *error = plft_alloc(n, sizeof *error);
    float *trust = plft_alloc(n, sizeof *trust);
    uint8_t *use = plft_alloc(n, 1);
    double curve[PLFT_CURVE];
    plft_figures f;
    size_t i;
    int k;

    memset(&f, 0, sizeof f);
    plft_errors(m->slope, l->truth, NULL, side, l->views.ny, BORDER, error, use,
                &f.untrue);
    (void)plft_figures_of(error, use, n, &f);
    *ratio = NAN;
    memset(kept, 0, sizeof *kept);
    for (k = 0; k < PLFT_BADPIX && m->sigma != NULL; k++) {
        *ratio = plft_scatter_ratio(error, use, m->sigma, n);
        for (i = 0; i < n; i++) {
            trust[i] = -m->sigma[i];
        }
        (void)plft_sparsify(error, use, trust, n, plft_thresholds[k], curve);
        kept->sigma[k] = curve_mean(curve);
        (void)plft_sparsify(error, use, m->trust, n, plft_thresholds[k], curve);
        kept->margin[k] = curve_mean(curve);
    }
    free(error);
    free(trust);
    free(use);
    return f;
}

static void release(light *l, maps *m)
{
    free(m->slope);
    free(m->sigma);
    free(m->trust);
    free(m->flags);
    free(l->views.px);
    free(l->truth);
}

/* Compare with a stored figure: 1 when it is missing or was better. */
static int worse(const char *stored, const char *key, double value)
{
    const char *at = stored ? strstr(stored, key) : NULL;
    double old;

    if (stored == NULL) {
        return 0;
    }
    if (at == NULL) {
        printf("# %s is not in the table\n", key);
        return 1;
    }
    old = atof(at + strlen(key));
    if (strstr(key, "scatter") != NULL) { /* best at 1 */
        old = fabs(old - 1);
        value = fabs(value - 1);
    }
    if (value > old * 1.05 + 0.05) {
        printf("# %s was %.3f\n", key, old);
        return 1;
    }
    return 0;
}

static int emit(const char *stored, const char *row, const char *figure, double value)
{
    char key[96];

    (void)snprintf(key, sizeof key, "%s,%s,", row, figure);
    printf("%s%.3f\n", key, value);
    return worse(stored, key, value);
}

static int emit_figures(const char *stored, const char *name, int id, double noise,
                        const light *l, const maps *m)
{
    static const char *const names[] = NAMES;
    char row[64];
    double ratio;
    left kept;
    plft_figures f = judge(l, m, &ratio, &kept);
    int bad = 0;

    (void)snprintf(row, sizeof row, "%s,%s,%g", name, names[id], noise);
    bad += emit(stored, row, "badpix_0.07", f.badpix[0]);
    bad += emit(stored, row, "badpix_0.03", f.badpix[1]);
    bad += emit(stored, row, "badpix_0.01", f.badpix[2]);
    bad += emit(stored, row, "mse_x100", f.mse100);
    if (id != PLFX_PRESET_STREAM) {
        bad += emit(stored, row, "scatter_over_sigma", ratio);
        bad += emit(stored, row, "left_by_sigma", mean_of(kept.sigma));
    }
    (void)emit(NULL, row, "left_by_margin", mean_of(kept.margin));
    return bad;
}

static int scene_rows(const char *stored, const char *name, int seed, int id,
                      double noise)
{
    light l;
    maps m;
    int bad;

    make_cfg(&l, id, SCENE_SIDE, -1.8, 1.8);
    draw(&l, (uint64_t)seed, noise);
    m = match(&l, noise);
    bad = emit_figures(stored, name, id, noise, &l, &m);
    release(&l, &m);
    return bad;
}

static void print_pair(const char *name, const plft_figures *a, const plft_figures *b)
{
    printf(
        "%s fixed %.3f %.3f %.3f %.4f double %.3f %.3f %.3f %.4f (BadPix .07 .03 .01, "
        "MSE)\n",
        name, a->badpix[0], a->badpix[1], a->badpix[2], a->mse100, b->badpix[0],
        b->badpix[1], b->badpix[2], b->mse100);
}

static int compare_double(light *l, const char *name)
{
    maps m = match(l, 0);
    maps d = match_double(l);
    double ratio;
    left kept;
    plft_figures a = judge(l, &m, &ratio, &kept);
    plft_figures b = judge(l, &d, &ratio, &kept);

    print_pair(name, &a, &b);
    free(d.slope);
    release(l, &m);
    return a.badpix[0] > b.badpix[0] + 0.1 || a.badpix[2] > b.badpix[2] + 1;
}

static int open_cotton(light *l, int id, const char *data)
{
    char path[512];
    plft_source source;
    plft_field field;
    plft_map truth;

    (void)snprintf(path, sizeof path, "%s/hci4d_cotton/gt_disp_lowres.pfm", data);
    if (access(path, R_OK) != 0) {
        printf("# cotton is left out: no %s\n", path);
        return 1;
    }
    if (plft_pfm_read(&truth, path)) {
        exit(1);
    }
    (void)snprintf(path, sizeof path, "%s/hci4d_cotton", data);
    memset(&source, 0, sizeof source);
    memset(l, 0, sizeof *l);
    source.dir = path;
    source.grid = "9x9";
    source.pattern = "input_Cam*.png";
    if (plft_field_open(&field, &source)) {
        exit(1);
    }
    l->cfg.bits = (uint8_t)field.bits;
    l->cfg.slope_min_q16 = -104858; /* 1.6 */
    l->cfg.slope_max_q16 = 104858;
    l->preset.id = id;
    if (plft_preset_cfg(&l->preset, &field, 0, &l->cfg) ||
        plft_field_views(&field, l->cfg.at, l->cfg.n, &l->views)) {
        exit(1);
    }
    l->truth = truth.v;
    plft_field_free(&field);
    return 0;
}

static void add_noise(light *l, double noise)
{
    scene random;
    size_t n = (size_t)l->views.nx * (size_t)l->views.ny * (size_t)l->views.n;
    double top = (1 << l->cfg.bits) - 1;
    size_t i;

    random.seed = 1;
    for (i = 0; i < n; i++) {
        double v =
            floor(l->views.px[i] + noise * top / 255 * scene_gauss(&random) + 0.5);
        l->views.px[i] = (uint16_t)(v < 0 ? 0 : v > top ? top : v);
    }
}

static int cotton_rows(const char *stored, const char *data)
{
    int bad = 0;
    int noise;

    for (noise = 0; noise <= 2; noise++) {
        light l;
        maps m;
        if (open_cotton(&l, PLFX_PRESET_ONBOARD, data)) {
            return 0;
        }
        add_noise(&l, noise);
        m = match(&l, noise);
        bad += emit_figures(stored, "cotton", PLFX_PRESET_ONBOARD, noise, &l, &m);
        release(&l, &m);
    }
    { /* as the command has it, which measures the noise */
        light l;
        maps m;
        (void)open_cotton(&l, PLFX_PRESET_ONBOARD, data);
        m = match(&l, plfx_views_noise_q4(&l.views, l.cfg.bits, PLFX_VIEWS_ALL) / 16.0);
        bad += emit_figures(stored, "cotton_measured", PLFX_PRESET_ONBOARD, 0, &l, &m);
        release(&l, &m);
    }
    {
        light l;
        maps m;
        (void)open_cotton(&l, PLFX_PRESET_STREAM, data);
        m = match(&l, 0);
        bad += emit_figures(stored, "cotton", PLFX_PRESET_STREAM, 0, &l, &m);
        release(&l, &m);
    }
    return bad;
}

static int run_double(const char *data)
{
    char name[16];
    light l;
    int bad = 0;
    int seed;

    for (seed = 1; seed <= 2; seed++) {
        make_cfg(&l, PLFX_PRESET_ONBOARD, SCENE_SIDE, -1.8, 1.8);
        draw(&l, (uint64_t)seed, 0);
        (void)snprintf(name, sizeof name, "drawn%d", seed);
        bad += compare_double(&l, name);
    }
    if (data != NULL && open_cotton(&l, PLFX_PRESET_ONBOARD, data) == 0) {
        bad += compare_double(&l, "cotton");
    }
    return bad > 0;
}

typedef struct sample {
    double sigma, ratio;
} sample;

static int by_sigma(const void *a, const void *b)
{
    const sample *x = a;
    const sample *y = b;

    return (x->sigma > y->sigma) - (x->sigma < y->sigma);
}

static int by_ratio(const void *a, const void *b)
{
    const sample *x = a;
    const sample *y = b;

    return (x->ratio > y->ratio) - (x->ratio < y->ratio);
}

static double scatter(sample *s, size_t n)
{
    qsort(s, n, sizeof *s, by_ratio);
    return n > 0 ? 1.4826 * s[n / 2].ratio : NAN;
}

/* Samples inside the border, appended to list. */
static size_t sample_map(const light *l, const maps *m, sample *list)
{
    int side = l->views.nx;
    size_t n = 0;
    int x;
    int y;

    for (y = BORDER; y < side - BORDER; y++) {
        for (x = BORDER; x < side - BORDER; x++) {
            int i = y * side + x;
            list[n].sigma = (double)m->sigma[i];
            list[n].ratio =
                fabs((double)m->slope[i] - (double)l->truth[i]) / (double)m->sigma[i];
            n++;
        }
    }
    return n;
}

/* Scatter over stated error where the map says that texture is enough. */
static double scene_scatter(const light *l, const maps *m)
{
    static sample list[SCENE_SIDE * SCENE_SIDE];
    size_t n = 0;
    int side = l->views.nx;
    int x;
    int y;

    for (y = BORDER; y < side - BORDER; y++) {
        for (x = BORDER; x < side - BORDER; x++) {
            int i = y * side + x;
            if ((m->flags[i] & PLFX_FLAG_TEXTURE) == 0) {
                list[n++].ratio = fabs((double)m->slope[i] - (double)l->truth[i]) /
                                  (double)m->sigma[i];
            }
        }
    }
    return scatter(list, n);
}

static void print_left(const left *kept)
{
    int k;

    printf("BadPix left by sigma, margin");
    for (k = 0; k < PLFT_BADPIX; k++) {
        printf(" %.2f %.2f", kept->sigma[k], kept->margin[k]);
    }
    printf("\n");
}

static void print_fifths(const sample *list, size_t n)
{
    size_t i;

    for (i = 0; i < 5; i++) {
        static sample part[SIGMA_SCENES * SCENE_SIDE * SCENE_SIDE];
        size_t from = n * i / 5;
        size_t to = n * (i + 1) / 5;
        memcpy(part, list + from, (to - from) * sizeof *part);
        printf(" %.4f:%.2f", list[(from + to) / 2].sigma, scatter(part, to - from));
    }
}

static int within(double ratio)
{
    return ratio > 0.75 && ratio < 1.25;
}

/* *good: scenes within 25 %. */
static int sigma_line(double noise, int first, int *good)
{
    static sample list[SIGMA_SCENES * SCENE_SIDE * SCENE_SIDE];
    double of_scene[SIGMA_SCENES];
    left sum;
    double all;
    size_t n = 0;
    int bad = 0;
    int seed;
    int k;

    memset(&sum, 0, sizeof sum);
    for (seed = 0; seed < SIGMA_SCENES; seed++) {
        light l;
        maps m;
        left kept;
        double ratio;
        make_cfg(&l, PLFX_PRESET_ONBOARD, SCENE_SIDE, -1.8, 1.8);
        draw(&l, (uint64_t)(seed + first), noise);
        m = match(&l, noise);
        (void)judge(&l, &m, &ratio, &kept);
        of_scene[seed] = scene_scatter(&l, &m);
        for (k = 0; k < PLFT_BADPIX; k++) {
            sum.sigma[k] += kept.sigma[k] / SIGMA_SCENES;
            sum.margin[k] += kept.margin[k] / SIGMA_SCENES;
        }
        n += sample_map(&l, &m, list + n);
        release(&l, &m);
    }
    qsort(list, n, sizeof *list, by_sigma);
    printf("noise %-4g fifths", noise);
    print_fifths(list, n);
    printf(" scenes");
    for (seed = 0; seed < SIGMA_SCENES; seed++) {
        printf(" %.2f", of_scene[seed]);
        *good += within(of_scene[seed]);
    }
    all = scatter(list, n);
    printf(" all %.3f; ", all);
    print_left(&sum);
    for (k = 0; k < PLFT_BADPIX; k++) {
        bad += sum.sigma[k] > sum.margin[k];
    }
    return bad > 0 || !within(all);
}

static int run_sigma(int first)
{
    static const double noise[] = {0, 0.5, 1, 2, 4};
    int count = (int)(sizeof noise / sizeof noise[0]);
    int good = 0;
    int bad = 0;
    int i;

    for (i = 0; i < count; i++) {
        bad += sigma_line(noise[i], first, &good);
    }
    count *= SIGMA_SCENES;
    printf("%d of %d scenes within 25 %%\n", good, count);
    return bad > 0 || 4 * good < 3 * count;
}

static int drawn_rows(const char *stored)
{
    char name[16];
    int bad = 0;
    int seed;
    int noise;

    for (seed = 1; seed <= 2; seed++) {
        (void)snprintf(name, sizeof name, "drawn%d", seed);
        for (noise = 0; noise <= 2; noise += 2) {
            bad += scene_rows(stored, name, seed, PLFX_PRESET_STREAM, noise);
            bad += scene_rows(stored, name, seed, PLFX_PRESET_ONBOARD, noise);
        }
        bad += scene_rows(stored, name, seed, PLFX_PRESET_PRECISE, 1);
    }
    return bad;
}

#define JUMP 0.1 /* of the truth */

/* Samples to the next jump of the truth, at most `most`; more when there is none. */
static int to_jump(const light *l, int x, int y, int most)
{
    const float *at = l->truth + y * l->views.nx + x;
    int near = most + 1;
    int i;
    int j;

    for (j = -most; j <= most; j++) {
        for (i = -most; i <= most; i++) {
            int d = abs(i) > abs(j) ? abs(i) : abs(j);
            if (d < near &&
                fabs((double)at[j * l->views.nx + i] - (double)*at) > JUMP) {
                near = d;
            }
        }
    }
    return near;
}

/* Where bad samples lie: all of them, and within 2 and 5 samples of a jump. */
static int run_where(void)
{
    int seed;

    for (seed = 1; seed <= 2; seed++) {
        int bad[3] = {0, 0, 0};
        light l;
        maps m;
        int x;
        int y;
        make_cfg(&l, PLFX_PRESET_ONBOARD, SCENE_SIDE, -1.8, 1.8);
        draw(&l, (uint64_t)seed, 0);
        m = match(&l, 0);
        for (y = BORDER; y < SCENE_SIDE - BORDER; y++) {
            for (x = BORDER; x < SCENE_SIDE - BORDER; x++) {
                int i = y * SCENE_SIDE + x;
                int off =
                    fabs((double)m.slope[i] - (double)l.truth[i]) > plft_thresholds[0];
                int near = off ? to_jump(&l, x, y, 5) : 0;
                bad[0] += off;
                bad[1] += off && near <= 2;
                bad[2] += off && near <= 5;
            }
        }
        printf("drawn%d: %d bad samples, %d within 2 of a jump, %d within 5\n", seed,
               bad[0], bad[1], bad[2]);
        release(&l, &m);
    }
    return 0;
}

int main(int argc, char **argv)
{
    unsigned char *stored = NULL;
    size_t n = 0;
    int bad;

    if (argc >= 2 && strcmp(argv[1], "--sigma") == 0) {
        return run_sigma(argc > 2 ? atoi(argv[2]) : SIGMA_FIRST);
    }
    if (argc >= 2 && strcmp(argv[1], "--where") == 0) {
        return run_where();
    }
    if (argc >= 2 && strcmp(argv[1], "--double") == 0) {
        return run_double(argc > 2 ? argv[2] : NULL);
    }
    if (argc >= 3 && strcmp(argv[1], "--check") == 0 &&
        plft_in_bytes(argv[2], &stored, &n) != 0) {
        return 1;
    }
    printf("scene,preset,noise,figure,value\n");
    bad = drawn_rows((const char *)stored);
    if (argc >= 4) {
        bad += cotton_rows((const char *)stored, argv[3]);
    }
    free(stored);
    if (bad > 0) {
        printf("# %d figures are worse\n", bad);
    }
    return bad > 0;
}
