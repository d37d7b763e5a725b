/* SPDX-License-Identifier: MIT
 * Figures of the presets on scenes drawn here, and on a folder of views with truth.
 *
 *   bench_accuracy                        print scene,preset,noise,figure,value
 *   bench_accuracy --check ACCURACY.csv   compare: worse by over 5 % and 0.05 fails
 *   bench_accuracy --double               the same method in double beside fixed point
 *   bench_accuracy --views DIR RxC MIN:MAX TRUTH.pfm [NOISE]   onboard; and double
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

#define BORDER 15
#define VIEWS  9 /* a side */
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
    for (i = 0; i < n; i++) {
        m.slope[i] = (float)(map.slope_q16[i] / 65536.);
        m.sigma[i] = map.sigma_u20[i] == PLFX_SIGMA_NONE
                         ? NAN
                         : (float)(map.sigma_u20[i] / 1048576.);
        m.trust[i] = (float)(map.conf_u16[i] / 65536.);
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
    maps m = {plft_alloc(n, sizeof *m.slope), NULL, NULL};
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

static plft_figures judge(const light *l, const maps *m, double *ratio, double *excess)
{
    int side = l->views.nx;
    size_t n = (size_t)side * (size_t)l->views.ny;
    float *error = plft_alloc(n, sizeof *error);
    float *trust = plft_alloc(n, sizeof *trust);
    uint8_t *use = plft_alloc(n, 1);
    double by_conf[PLFT_CURVE];
    double by_sigma[PLFT_CURVE];
    plft_figures f;
    size_t i;

    memset(&f, 0, sizeof f);
    plft_errors(m->slope, l->truth, NULL, side, l->views.ny, BORDER, error, use,
                &f.untrue);
    (void)plft_figures_of(error, use, n, &f);
    *ratio = NAN;
    *excess = 0;
    if (m->sigma != NULL) {
        *ratio = plft_scatter_ratio(error, use, m->sigma, n);
        for (i = 0; i < n; i++) {
            trust[i] = -m->sigma[i];
        }
        (void)plft_sparsify(error, use, m->trust, n, plft_thresholds[0], by_conf);
        (void)plft_sparsify(error, use, trust, n, plft_thresholds[0], by_sigma);
        for (i = 0; i < PLFT_CURVE; i++) {
            *excess = fmax(*excess, by_sigma[i] - by_conf[i]);
        }
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
    if (value > old * 1.05 + 0.05) {
        printf("# %s was %.3f\n", key, old);
        return 1;
    }
    return 0;
}

static int emit(const char *stored, int seed, const char *preset, double noise,
                const char *figure, double value)
{
    char key[96];

    (void)snprintf(key, sizeof key, "drawn%d,%s,%g,%s,", seed, preset, noise, figure);
    printf("%s%.3f\n", key, value);
    return worse(stored, key, value);
}

static int scene_rows(const char *stored, int seed, int id, double noise)
{
    static const char *const names[] = NAMES;
    light l;
    maps m;
    plft_figures f;
    double ratio;
    double excess;
    int bad = 0;

    make_cfg(&l, id, SCENE_SIDE, -1.8, 1.8);
    draw(&l, (uint64_t)seed, noise);
    m = match(&l, noise);
    f = judge(&l, &m, &ratio, &excess);
    bad += emit(stored, seed, names[id], noise, "badpix_0.07", f.badpix[0]);
    bad += emit(stored, seed, names[id], noise, "badpix_0.03", f.badpix[1]);
    bad += emit(stored, seed, names[id], noise, "badpix_0.01", f.badpix[2]);
    bad += emit(stored, seed, names[id], noise, "mse_x100", f.mse100);
    if (id != PLFX_PRESET_STREAM) {
        bad += emit(stored, seed, names[id], noise, "scatter_over_sigma", ratio);
        bad += emit(stored, seed, names[id], noise, "sigma_over_margin", excess);
    }
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

static void compare_double(light *l, const char *name)
{
    maps m = match(l, 0);
    maps d = match_double(l);
    double ratio;
    double excess;
    plft_figures a = judge(l, &m, &ratio, &excess);
    plft_figures b = judge(l, &d, &ratio, &excess);

    print_pair(name, &a, &b);
    free(d.slope);
    release(l, &m);
}

static int run_double(void)
{
    char name[16];
    light l;
    int seed;

    for (seed = 1; seed <= 2; seed++) {
        make_cfg(&l, PLFX_PRESET_ONBOARD, SCENE_SIDE, -1.8, 1.8);
        draw(&l, (uint64_t)seed, 0);
        (void)snprintf(name, sizeof name, "drawn%d", seed);
        compare_double(&l, name);
    }
    return 0;
}

static int run_views(char **argv, double noise)
{
    plft_source source;
    plft_field field;
    plft_map truth;
    light l;
    double lo;
    double hi;

    memset(&source, 0, sizeof source);
    memset(&l, 0, sizeof l);
    source.dir = argv[0];
    source.grid = argv[1];
    source.pattern = "input_Cam*.png";
    if (sscanf(argv[2], "%lf:%lf", &lo, &hi) != 2 || plft_field_open(&field, &source) ||
        plft_pfm_read(&truth, argv[3])) {
        return 1;
    }
    l.cfg.bits = (uint8_t)field.bits;
    l.cfg.slope_min_q16 = (int32_t)lround(lo * 65536);
    l.cfg.slope_max_q16 = (int32_t)lround(hi * 65536);
    l.preset.id = PLFX_PRESET_ONBOARD;
    if (plft_preset_cfg(&l.preset, &field, 0, &l.cfg) ||
        plft_field_views(&field, l.cfg.at, l.cfg.n, &l.views)) {
        return 1;
    }
    l.truth = truth.v;
    if (noise > 0) {
        scene random;
        size_t n = (size_t)l.views.nx * (size_t)l.views.ny * (size_t)l.views.n;
        size_t i;
        maps m;
        double ratio;
        double excess;
        plft_figures f;
        random.seed = 1;
        for (i = 0; i < n; i++) {
            double v = floor(l.views.px[i] + noise * 4 * scene_gauss(&random) + 0.5);
            l.views.px[i] = (uint16_t)(v < 0 ? 0 : v > 1023 ? 1023 : v);
        }
        printf("noise measured %.3f, given %g\n",
               plfx_views_noise_q4(&l.views, l.cfg.bits, 0) / 16., noise);
        m = match(&l, noise);
        f = judge(&l, &m, &ratio, &excess);
        printf("%.3f %.3f %.3f %.4f scatter/sigma %.2f (BadPix .07 .03 .01, MSE)\n",
               f.badpix[0], f.badpix[1], f.badpix[2], f.mse100, ratio);
        release(&l, &m);
    } else {
        compare_double(&l, argv[0]);
    }
    plft_field_free(&field);
    return 0;
}

int main(int argc, char **argv)
{
    unsigned char *stored = NULL;
    size_t n = 0;
    int bad = 0;
    int seed;
    int noise;

    if (argc >= 6 && strcmp(argv[1], "--views") == 0) {
        return run_views(argv + 2, argc > 6 ? atof(argv[6]) : 0);
    }
    if (argc == 2 && strcmp(argv[1], "--double") == 0) {
        return run_double();
    }
    if (argc == 3 && strcmp(argv[1], "--check") == 0 &&
        plft_in_bytes(argv[2], &stored, &n) != 0) {
        return 1;
    }
    printf("scene,preset,noise,figure,value\n");
    for (seed = 1; seed <= 2; seed++) {
        for (noise = 0; noise <= 2; noise += 2) {
            bad += scene_rows((const char *)stored, seed, PLFX_PRESET_STREAM, noise);
            bad += scene_rows((const char *)stored, seed, PLFX_PRESET_ONBOARD, noise);
        }
        bad += scene_rows((const char *)stored, seed, PLFX_PRESET_PRECISE, 1);
    }
    free(stored);
    if (bad > 0) {
        printf("# %d figures are worse\n", bad);
    }
    return bad > 0;
}
