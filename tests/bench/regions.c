/* SPDX-License-Identifier: MIT
 * Regions on the reference camera: 96 x 20 lenses of 17.04 px, 24 regions of 7 x 9
 * lenses, a cross of 24 views and the centre, 12 bits, 30000 electrons, 16 of read
 * noise. Frames are drawn from a formula: pixel (u,v) of lens (i,j) sees the texture at
 * (i - x - D*u, j - y - D*v).  usage: bench_regions [frames]
 * Prints noise, bound, stated error and scale against their limits;
 * exit status 1 when one is over. */
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

static double gauss(void)
{
    return sqrt(-2.0 * log(uniform() + 1e-300)) * cos(2.0 * PI * uniform());
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

typedef struct motion { /* of the scene: displacement and slope, its tilt, light */
    double x, y, d, turn, light;
    double slope_x; /* d grows by this a lens from the left */
    int cable;      /* a bar hides lenses cable .. cable+3; -1 none */
} motion;

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
            double d = m->d + m->slope_x * i;
            double px = i - m->x - d * u + m->turn * (j - NY / 2.0);
            double py = j - m->y - d * v - m->turn * (i - NX / 2.0);
            double s = u * u + v * v > 64.0 ? 0.02 : at(px, py);
            double e;
            if (m->cable >= 0 && i >= m->cable && i < m->cable + 4) {
                s = 0.15 + 0.1 * ((i + j) % 2);
            }
            e = 0.8 * FULL * m->light * s;
            e += noise_gain * (sqrt(e) * gauss() + READ * gauss());
            e = floor(e / FULL * 4095.0 + 0.5);
            raw[y * SW + x] = (uint16_t)(e < 0 ? 0 : e > 4095 ? 4095 : e);
        }
    }
}

static int start(int rest)
{
    const motion still = {0, 0, 0, 0, 1, 0, -1};
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
    cfg.residual_q8 = 512;
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

/* The bound for region k: independent samples, noise of a bilinear sample, gradients of
 * the true texture. */
static double bound(int k, double p[3])
{
    double n[3] = {0, 0, 0};
    int i;
    int j;
    int view;

    for (j = cfg.region[k].j - 4; j <= cfg.region[k].j + 4; j++) {
        for (i = cfg.region[k].i - 3; i <= cfg.region[k].i + 3; i++) {
            double gx = (at(i + 0.1, j) - at(i - 0.1, j)) / 0.2;
            double gy = (at(i, j + 0.1) - at(i, j - 0.1)) / 0.2;
            double e = 0.8 * FULL * at(i, j);
            double var = (e + READ * READ) / (0.64 * FULL * FULL) * 4.0 / 9.0;
            for (view = 0; view < VIEWS; view++) {
                double g =
                    cfg.at[view].u_q8 / 256.0 * gx + cfg.at[view].v_q8 / 256.0 * gy;
                n[0] += gx * gx / var;
                n[1] += gy * gy / var;
                n[2] += g * g / var;
            }
        }
    }
    for (i = 0; i < 3; i++) {
        p[i] = 1 / sqrt(n[i]);
    }
    return p[2];
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

typedef struct series { /* error of a component over frames */
    double sum, square, sigma, tt, te, oo;
    int n;
} series;

static void add(series *s, double value, double truth, uint32_t sigma_q24)
{
    double e = value - truth;

    s->sum += e;
    s->square += e * e;
    s->sigma += sigma_q24 / 16777216.0;
    s->tt += truth * truth;
    s->te += truth * value;
    s->n++;
}

static double scatter(const series *s)
{
    return sqrt(s->square / s->n - s->sum / s->n * s->sum / s->n);
}

static int still_noise(int frames)
{
    static series s[REGIONS][3];
    double w[REGIONS], over[REGIONS], ratio[3][REGIONS], u[REGIONS];
    double worst = 0;
    motion m = {0, 0, 0, 0, 1, 0, -1};
    int t;
    int k;

    memset(s, 0, sizeof s);
    for (t = 0; t < frames; t++) {
        if (look(&m)) {
            return 1;
        }
        for (k = 0; k < REGIONS; k++) {
            if (result[k].flags) {
                printf("region %d flagged %d residual %d\n", k, result[k].flags,
                       result[k].residual_q8);
                continue;
            }
            add(&s[k][0], result[k].u_q24 / 16777216.0, 0, result[k].u_sigma_q24);
            add(&s[k][1], result[k].v_q24 / 16777216.0, 0, result[k].v_sigma_q24);
            add(&s[k][2], result[k].w_q24 / 16777216.0, 0, result[k].w_sigma_q24);
        }
    }
    for (k = 0; k < REGIONS; k++) {
        double b[3];
        int c;
        (void)bound(k, b);
        w[k] = scatter(&s[k][2]) / MM;
        u[k] = scatter(&s[k][0]);
        over[k] = scatter(&s[k][2]) / b[2];
        worst = over[k] > worst ? over[k] : worst;
        for (c = 0; c < 3; c++) {
            ratio[c][k] = s[k][c].sigma / s[k][c].n / scatter(&s[k][c]);
        }
    }
    judge("w noise, median region, mm", median(w, REGIONS), 0.15);
    judge("in-plane noise, median region, lenses", median(u, REGIONS), 0.0015);
    judge("w noise over the bound, median", median(over, REGIONS), 1.3);
    judge("w noise over the bound, worst", worst, 1.5);
    for (k = 0; k < 3; k++) {
        double r = median(ratio[k], REGIONS);
        printf("stated over real scatter, %c: %.3f (range %.3f .. %.3f)\n", "uvw"[k], r,
               ratio[k][0], ratio[k][REGIONS - 1]);
        judge("  its distance from 1", fabs(r - 1), 0.25);
    }
    return 0;
}

/* Motion in w and in the plane; truth is known. */
static int moving(int frames, double in_plane, const char *name)
{
    static series s[3];
    int valid = 0;
    int t;
    int k;

    memset(s, 0, sizeof s);
    for (t = 0; t < frames; t++) {
        motion m = {0, 0, 0, 0, 1, 0, -1};
        m.x = in_plane * sin((in_plane > 1 ? 0.2 : 0.7) * t);
        m.y = in_plane * sin((in_plane > 1 ? 0.25 : 1.1) * t);
        m.d = 2 * MM * sin(1.7 * t);
        if (look(&m)) {
            return 1;
        }
        for (k = 0; k < REGIONS; k++) {
            if (result[k].flags == 0) {
                add(&s[0], result[k].u_q24 / 16777216.0, m.x, 0);
                add(&s[1], result[k].v_q24 / 16777216.0, m.y, 0);
                add(&s[2], result[k].w_q24 / 16777216.0, m.d, 0);
                valid++;
            }
        }
    }
    printf("%s: %d of %d valid; rms u %.5f v %.5f lens, w %.4f mm\n", name, valid,
           frames * REGIONS, sqrt(s[0].square / s[0].n), sqrt(s[1].square / s[1].n),
           sqrt(s[2].square / s[2].n) / MM);
    judge("  scale of w off by, %", 100 * fabs(s[2].te / s[2].tt - 1), 1.0);
    if (in_plane > 0) {
        judge("  scale of u off by, %", 100 * fabs(s[0].te / s[0].tt - 1), 1.0);
    }
    judge("  invalid, %", 100.0 - 100.0 * valid / (frames * REGIONS), 1.0);
    return 0;
}

int main(int argc, char **argv)
{
    int frames = argc > 1 ? atoi(argv[1]) : 40;

    raw = plft_alloc((size_t)SW * SH, sizeof *raw);
    draw_texture();
    if (!raw || start(16)) {
        return 2;
    }
    printf("workspace %zu bytes\n", plfx_roi_ws(&cfg));
    if (still_noise(frames) || moving(frames / 2, 0, "w of 2 mm") ||
        moving(frames / 2, 0.05, "and 0.05 lens in the plane") ||
        moving(frames / 2, 0.45, "and 0.45 lens in the plane") ||
        moving(frames / 2, 1.5, "and 1.5 lenses in the plane")) {
        return 2;
    }
    return failures > 0;
}
