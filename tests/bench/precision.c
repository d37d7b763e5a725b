/* SPDX-License-Identifier: MIT
 * How exactly the precise preset measures a plane of smooth texture.
 *
 *   bench_precision [CURVE.png]
 *
 * Locking: no noise, slopes over a full period of the labels' and the samples' lattice;
 * bias of the map's inner part against slope, rms and largest, drawn into CURVE.png.
 * Noise: rms error of single samples over the Cramer-Rao bound of their window,
 *   var(D) >= sigma^2 / sum over window and views of (Tx u + Ty v)^2,
 * and the stated standard error over it.  Fails over 3e-4 rms, 1e-3 largest, 1.25. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/colour.h"
#include "common/frame.h"
#include "common/match.h"
#include "common/memory.h"
#include "preset.h"
#include "scene.h"

#define SIDE   80
#define MARGIN 24
#define GRID   9
#define SLOPES 32
#define PLOT_W 520
#define PLOT_H 300

static scene random_source;

/* Waves of 0.02 to 0.2 cycles a sample, 30 grey levels rms. */
static scene_surface smooth_texture(uint64_t seed)
{
    scene_surface s;
    double sum = 0;
    int i;

    memset(&s, 0, sizeof s);
    random_source.seed = seed;
    for (i = 0; i < SCENE_WAVES; i++) {
        double f = scene_random(&random_source, 0.02, 0.2);
        double a = scene_random(&random_source, 0, 6.283185307179586);
        s.fx[i] = 6.283185307179586 * f * cos(a);
        s.fy[i] = 6.283185307179586 * f * sin(a);
        s.phase[i] = scene_random(&random_source, 0, 6.283185307179586);
        s.size[i] = 30 * pow(f, -0.5);
        sum += pow(f, -1) / 2;
    }
    for (i = 0; i < SCENE_WAVES; i++) {
        s.size[i] /= sqrt(sum);
    }
    return s;
}

static double grey(const scene_surface *s, double x, double y)
{
    double g = 128;
    int i;

    for (i = 0; i < SCENE_WAVES; i++) {
        g += s->size[i] * sin(s->fx[i] * x + s->fy[i] * y + s->phase[i]);
    }
    return g;
}

/* sum over views of (Tx u + Ty v)^2 at a point. */
static double information(const scene_surface *s, const plfx_cfg *cfg, double x,
                          double y)
{
    double gx = 0;
    double gy = 0;
    double sum = 0;
    int i;

    for (i = 0; i < SCENE_WAVES; i++) {
        double c = s->size[i] * cos(s->fx[i] * x + s->fy[i] * y + s->phase[i]);
        gx += s->fx[i] * c;
        gy += s->fy[i] * c;
    }
    for (i = 0; i < cfg->n; i++) {
        double g = gx * cfg->at[i].u_q8 / 256. + gy * cfg->at[i].v_q8 / 256.;
        sum += g * g;
    }
    return sum;
}

static void fill_cfg(plfx_cfg *cfg, plfx_frame_cfg *frame)
{
    plfx_offset at[GRID * GRID];
    uint8_t use[GRID * GRID];
    int k;

    memset(cfg, 0, sizeof *cfg);
    if (plfx_preset(PLFX_PRESET_PRECISE, cfg, frame) != PLFX_OK) {
        exit(1);
    }
    for (k = 0; k < GRID * GRID; k++) {
        at[k].u_q8 = (int16_t)(256 * (k % GRID - GRID / 2));
        at[k].v_q8 = (int16_t)(256 * (k / GRID - GRID / 2));
    }
    (void)plfx_preset_views(PLFX_PRESET_PRECISE, at, GRID * GRID, GRID * GRID / 2, use);
    for (k = 0; k < GRID * GRID; k++) {
        if (use[k]) {
            cfg->ref = k == GRID * GRID / 2 ? cfg->n : cfg->ref;
            cfg->at[cfg->n++] = at[k];
        }
    }
    cfg->bits = 12;
    cfg->slope_min_q16 = -65536;
    cfg->slope_max_q16 = 98304;
    cfg->labels = 26;
}

/* Map of a plane of slope d, noise in grey levels. */
static void measure(const plfx_cfg *cfg, plfx_frame_cfg frame, const scene_surface *s,
                    double d, double noise, plfx_map *map)
{
    plfx_views v = {NULL, SIDE, SIDE, cfg->n};
    plfx_plan plan;
    size_t bytes;
    void *ws;
    int x;
    int y;
    int k;

    v.px = plft_alloc((size_t)SIDE * SIDE * cfg->n, 2);
    for (y = 0; y < SIDE; y++) {
        for (k = 0; k < cfg->n; k++) {
            for (x = 0; x < SIDE; x++) {
                double g = grey(s, x - d * cfg->at[k].u_q8 / 256.,
                                y - d * cfg->at[k].v_q8 / 256.);
                g += noise > 0 ? noise * scene_gauss(&random_source) : 0;
                v.px[(y * cfg->n + k) * SIDE + x] = (uint16_t)floor(16 * g + 0.5);
            }
        }
    }
    frame.noise_q4 = (uint16_t)lround(16 * noise);
    if (plfx_plan_init(&plan, cfg, NULL, SIDE, SIDE) != PLFX_OK) {
        exit(1);
    }
    bytes = plfx_frame_ws(&plan, &frame);
    ws = plft_alloc_ws(bytes);
    if (plfx_frame(&plan, &frame, &v, NULL, map, ws, bytes) != PLFX_OK) {
        exit(1);
    }
    free(ws);
    free(v.px);
}

static double mean_error(const plfx_map *map, double d)
{
    double sum = 0;
    int n = 0;
    int x;
    int y;

    for (y = MARGIN; y < SIDE - MARGIN; y++) {
        for (x = MARGIN; x < SIDE - MARGIN; x++) {
            sum += map->slope_q16[y * SIDE + x] / 65536. - d;
            n++;
        }
    }
    return sum / n;
}

static void dot(uint8_t *rgb, int x, int y, uint8_t r, uint8_t g, uint8_t b)
{
    if (x >= 0 && y >= 0 && x < PLOT_W && y < PLOT_H) {
        uint8_t *p = rgb + 3 * (y * PLOT_W + x);
        p[0] = r;
        p[1] = g;
        p[2] = b;
    }
}

/* Bias in 1e-4 against slope; grey lines at 0 and +-3e-4. */
static void draw(const char *path, const double *bias)
{
    static uint8_t rgb[PLOT_W * PLOT_H * 3];
    static const uint8_t black[3] = {0, 0, 0};
    int k;
    int i;

    memset(rgb, 255, sizeof rgb);
    for (i = 40; i < PLOT_W - 10; i++) {
        for (k = -1; k <= 1; k++) {
            dot(rgb, i, PLOT_H / 2 - k * 90, 190, 190, 190);
        }
    }
    for (k = 0; k + 1 < SLOPES; k++) {
        for (i = 0; i < 64; i++) {
            double b = bias[k] + (bias[k + 1] - bias[k]) * i / 64.;
            int x = 45 + (int)((k + i / 64.) * (PLOT_W - 60) / (SLOPES - 1));
            int y = PLOT_H / 2 - (int)lround(b / 3e-4 * 90);
            dot(rgb, x, y, 20, 60, 160);
            dot(rgb, x, y + 1, 20, 60, 160);
        }
    }
    plft_text(rgb, PLOT_W, PLOT_H, 4, PLOT_H / 2 - 95, "+3e-4", black);
    plft_text(rgb, PLOT_W, PLOT_H, 4, PLOT_H / 2 - 5, "0", black);
    plft_text(rgb, PLOT_W, PLOT_H, 4, PLOT_H / 2 + 85, "-3e-4", black);
    plft_text(rgb, PLOT_W, PLOT_H, 120, PLOT_H - 14,
              "slope 0.013 .. 0.982, bias of the map", black);
    (void)plft_png_write_rgb8(path, rgb, PLOT_W, PLOT_H);
}

static int locking(const plfx_cfg *cfg, const plfx_frame_cfg *frame, plfx_map *map,
                   const char *path)
{
    scene_surface s = smooth_texture(1);
    double bias[SLOPES];
    double sum = 0;
    double most = 0;
    int k;

    for (k = 0; k < SLOPES; k++) {
        double d = 0.013 + k / (double)SLOPES;
        measure(cfg, *frame, &s, d, 0, map);
        bias[k] = mean_error(map, d);
        sum += bias[k] * bias[k];
        most = fmax(most, fabs(bias[k]));
    }
    printf("locking: rms %.2e, largest %.2e\n", sqrt(sum / SLOPES), most);
    if (path != NULL) {
        draw(path, bias);
    }
    return sqrt(sum / SLOPES) > 3e-4 || most > 1e-3;
}

static int noisy(const plfx_cfg *cfg, const plfx_frame_cfg *frame, plfx_map *map,
                 double noise)
{
    double sum = 0;
    double stated = 0;
    int n = 0;
    int round;
    int x;
    int y;
    int i;

    for (round = 0; round < 3; round++) {
        scene_surface s = smooth_texture((uint64_t)round + 10);
        double d = 0.37 + 0.11 * round;
        measure(cfg, *frame, &s, d, noise, map);
        for (y = MARGIN; y < SIDE - MARGIN; y += 4) {
            for (x = MARGIN; x < SIDE - MARGIN; x += 4) {
                double a = 0;
                double bound;
                double e = map->slope_q16[y * SIDE + x] / 65536. - d;
                for (i = 0; i < 225; i++) {
                    a += information(&s, cfg, x + i % 15 - 7, y + i / 15 - 7);
                }
                bound = noise / sqrt(a);
                sum += e * e / (bound * bound);
                stated += map->sigma_u20[y * SIDE + x] / 1048576. / bound;
                n++;
            }
        }
    }
    printf("noise %g: rms over bound %.3f, stated error over bound %.3f\n", noise,
           sqrt(sum / n), stated / n);
    return sqrt(sum / n) > 1.25;
}

int main(int argc, char **argv)
{
    plfx_cfg cfg;
    plfx_frame_cfg frame;
    plfx_map map;
    int bad;

    fill_cfg(&cfg, &frame);
    if (plft_slopes_alloc(&map, SIDE, SIDE) != 0) {
        return 1;
    }
    bad = locking(&cfg, &frame, &map, argc > 1 ? argv[1] : NULL);
    bad += noisy(&cfg, &frame, &map, 1);
    bad += noisy(&cfg, &frame, &map, 3);
    plft_slopes_free(&map);
    return bad > 0;
}
