/* SPDX-License-Identifier: MIT
 * The reference camera of the region benches: 96 x 20 lenses of 17.04 px, 24 regions of
 * 7 x 9 lenses, a cross of 24 views and the centre, 12 bits, 30000 electrons, 16 of
 * read noise. Frames are drawn from a formula: pixel (u,v) of lens (i,j) sees the
 * texture at (i - x - D*u, j - y - D*v). */
#ifndef PLFX_BENCH_REF_CAMERA_H
#define PLFX_BENCH_REF_CAMERA_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/memory.h"
#include "plenofix/roi.h"

#define PI      3.14159265358979323846
#define NX      96
#define NY      20
#define PITCH   17.04
#define SW      1645
#define SH      349
#define FINE    32 /* texture samples a lens */
#define PAD     4  /* lenses of texture around the array */
#define TW      ((NX + 2 * PAD) * FINE)
#define TH      ((NY + 2 * PAD) * FINE)
#define FULL    30000.0
#define READ    16.0
#define MM      0.00146 /* slope of a millimetre of depth at 0.5 m */
#define VIEWS   25
#define REGIONS 24

static float texture[TH * TW];
static double noise_gain = 1; /* 0: noise-free frames */
static uint16_t *raw;
static uint8_t *blob;
static plfx_lut lut;
static plfx_roi_cfg cfg;
static plfx_roi roi;
static void *ws;
static plfx_roi_result result[REGIONS];
static int failures;
static uint64_t rng = 88172645463325252u;

static double uniform(void)
{
    rng ^= rng << 13;
    rng ^= rng >> 7;
    rng ^= rng << 17;
    return (double)(rng >> 11) / 9007199254740992.0;
}

/* Box and Muller's pair, one after the other. */
static double gauss(void)
{
    static double other;
    static int kept;
    double r;
    double a;

    kept = !kept;
    if (!kept) {
        return other;
    }
    r = sqrt(-2.0 * log(uniform() + 1e-300));
    a = 2.0 * PI * uniform();
    other = r * sin(a);
    return r * cos(a);
}

/* A lens sees the mean over its aperture: a box of one lens, along rows or columns. */
static void blur(float *p, int n, int step)
{
    static double sum[TW + TH + 1];
    int k;

    sum[0] = 0;
    for (k = 0; k < n; k++) {
        sum[k + 1] = sum[k] + p[(size_t)k * (size_t)step];
    }
    for (k = 0; k < n; k++) {
        int a = k - FINE / 2 < 0 ? 0 : k - FINE / 2;
        int b = k + FINE / 2 > n ? n : k + FINE / 2;
        p[(size_t)k * (size_t)step] = (float)((sum[b] - sum[a]) / (b - a));
    }
}

/* Speckle of about three lenses: 60 waves of 0.08 .. 1/3 cycles a lens. */
static void draw_texture(void)
{
    double k[60][3];
    int n;
    int y;
    int x;

    for (n = 0; n < 60; n++) {
        double f = 0.08 + (1.0 / 3.0 - 0.08) * uniform();
        double a = 2.0 * PI * uniform();
        k[n][0] = 2.0 * PI * f * cos(a) / FINE;
        k[n][1] = 2.0 * PI * f * sin(a) / FINE;
        k[n][2] = 2.0 * PI * uniform();
    }
    for (y = 0; y < TH; y++) {
        for (x = 0; x < TW; x++) {
            double v = 0;
            for (n = 0; n < 60; n++) {
                v += cos(k[n][0] * x + k[n][1] * y + k[n][2]);
            }
            texture[y * TW + x] = (float)(0.5 + 0.42 * tanh(v / 6.0));
        }
    }
    for (y = 0; y < TH; y++) {
        blur(texture + (size_t)y * TW, TW, 1);
    }
    for (x = 0; x < TW; x++) {
        blur(texture + x, TH, TW);
    }
}

/* Texture at lens coordinates. */
static double at(double i, double j)
{
    double x = (i + PAD) * FINE;
    double y = (j + PAD) * FINE;
    int a = (int)floor(x);
    int b = (int)floor(y);
    const float *p;

    a = a < 0 ? 0 : a > TW - 2 ? TW - 2 : a;
    b = b < 0 ? 0 : b > TH - 2 ? TH - 2 : b;
    x -= a;
    y -= b;
    p = texture + b * TW + a;
    return (p[0] * (1 - x) + p[1] * x) * (1 - y) +
           (p[TW] * (1 - x) + p[TW + 1] * x) * y;
}

typedef struct motion { /* of the scene: displacement, slope, turn, light */
    double x, y, d, turn, light;
    double tilt;  /* d grows by this a lens from the middle */
    double zoom;  /* about the middle */
    double cable; /* middle of a bar, lenses; its width, 0: none */
    double width;
    double spot; /* brightness of a glint over lenses spot_i .. spot_i+2 */
    int spot_i;
} motion;

static const motion still = {0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0};

static double centre_x(int i)
{
    return 10.0 + PITCH * i;
}

static double centre_y(int j)
{
    return 12.0 + PITCH * j;
}

static void draw(const motion *m)
{
    int x;
    int y;

    for (y = 0; y < SH; y++) {
        int j = (int)floor((y - 12.0) / PITCH + 0.5);
        double v = y - centre_y(j);
        for (x = 0; x < SW; x++) {
            int i = (int)floor((x - 10.0) / PITCH + 0.5);
            double u = x - centre_x(i);
            double d = m->d + m->tilt * (i - NX / 2.0);
            double px =
                i - m->x - d * u + m->turn * (j - NY / 2.0) - m->zoom * (i - NX / 2.0);
            double py =
                j - m->y - d * v - m->turn * (i - NX / 2.0) - m->zoom * (j - NY / 2.0);
            double hidden = 0.5 + m->width / 2 - fabs(i - m->cable - 0.05 * u);
            double s = u * u + v * v > 64.0 ? 0.02 : at(px, py);
            double e;
            hidden = m->width == 0 || hidden < 0 ? 0 : hidden > 1 ? 1 : hidden;
            s = s * (1 - hidden) + 0.15 * hidden;
            if (m->spot > 0 && i >= m->spot_i && i < m->spot_i + 3) {
                s += m->spot;
            }
            e = 0.8 * FULL * m->light * s;
            e += noise_gain * sqrt(e + READ * READ) * gauss();
            e = floor(e / FULL * 4095.0 + 0.5);
            raw[y * SW + x] = (uint16_t)(e < 0 ? 0 : e > 4095 ? 4095 : e);
        }
    }
}

static int start(int rest)
{
    plfx_lut_desc d;
    plfx_raw r = {(const uint8_t *)raw, (size_t)SW * SH * 2u, PLFX_RAW_U16, 12, SW, SH};
    plfx_roi_frame f = {&r, NULL};
    int k;

    memset(&d, 0, sizeof d);
    d.sensor_w = SW;
    d.sensor_h = SH;
    d.sensor_bits = 12;
    d.lattice.kind = PLFX_LATTICE_SQUARE;
    d.lattice.nx = NX;
    d.lattice.ny = NY;
    d.lattice.origin.x_q16 = 10 << 16;
    d.lattice.origin.y_q16 = 12 << 16;
    d.lattice.a.x_q22 = (int32_t)(PITCH * 4194304.0);
    d.lattice.b.y_q22 = (int32_t)(PITCH * 4194304.0);
    d.radius_q8 = 8 * 256;
    free(blob);
    blob = plft_alloc(plfx_lut_bytes(&d), 1);
    if (plfx_lut_write(&d, blob, plfx_lut_bytes(&d)) ||
        plfx_lut_open(&lut, blob, plfx_lut_bytes(&d))) {
        return 1;
    }
    memset(&cfg, 0, sizeof cfg);
    cfg.lut = &lut;
    cfg.tone = plfx_tone_unity(12);
    cfg.views = VIEWS;
    for (k = 1; k <= 6; k++) {
        cfg.at[4 * k - 3].u_q8 = (int16_t)(256 * k);
        cfg.at[4 * k - 2].u_q8 = (int16_t)(-256 * k);
        cfg.at[4 * k - 1].v_q8 = (int16_t)(256 * k);
        cfg.at[4 * k].v_q8 = (int16_t)(-256 * k);
    }
    cfg.regions = REGIONS;
    for (k = 0; k < REGIONS; k++) {
        cfg.region[k].i = (int16_t)(7 + 81 * (k % 12) / 11);
        cfg.region[k].j = (int16_t)(k < 12 ? 7 : 12);
        cfg.region[k].hx = 3;
        cfg.region[k].hy = 4;
    }
    cfg.rest = rest;
    cfg.steps = 2;
    cfg.residual_q8 = 640;
    free(ws);
    ws = plft_alloc_ws(plfx_roi_ws(&cfg));
    if (plfx_roi_init(&roi, &cfg, ws, plfx_roi_ws(&cfg))) {
        return 1;
    }
    for (k = 0; k < rest; k++) {
        draw(&still);
        if (plfx_roi_rest(&roi, &f)) {
            return 1;
        }
    }
    return 0;
}

static int look(const motion *m)
{
    plfx_raw r = {(const uint8_t *)raw, (size_t)SW * SH * 2u, PLFX_RAW_U16, 12, SW, SH};
    plfx_roi_frame f = {&r, NULL};

    draw(m);
    return plfx_roi_measure(&roi, &f, result);
}

static void judge(const char *what, double value, double limit)
{
    printf("%-52s %9.5f (limit %.4f)%s\n", what, value, limit,
           value <= limit ? "" : "  OVER");
    failures += !(value <= limit);
}

static double median(double *v, int n)
{
    int a;
    int b;

    for (a = 1; a < n; a++) {
        for (b = a; b > 0 && v[b] < v[b - 1]; b--) {
            double t = v[b];
            v[b] = v[b - 1];
            v[b - 1] = t;
        }
    }
    return v[n / 2];
}

#endif
