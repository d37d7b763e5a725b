/* SPDX-License-Identifier: MIT
 * Published films of things that vibrate.  usage: bench_vibration DATA_FOLDER
 * vib_building: a dot on each floor is followed as a region; each ring-down after a
 * release must read 8.05 to 8.40 Hz at the top, 7.95 to 8.39 on the floor below, with
 * damping and standard errors.
 * vib_guitar: frequencies of three open strings from the brightness of single pixels;
 * ratios of neighbours against those of a spectrum of the film and, for the two that
 * are in tune with each other, of the notes.
 * Exit status 1 when a figure is over its limit, 77 without the data. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/memory.h"
#include "plenofix/modal.h"
#include "plenofix/roi.h"

#define PI 3.14159265358979323846

static int failures;

static unsigned char *load(const char *folder, const char *name, size_t size)
{
    unsigned char *bytes = plft_alloc(size, 1);
    char path[512];
    FILE *f;

    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    f = fopen(path, "rb");
    if (!f || !bytes || fread(bytes, 1, size, f) != size) {
        printf("skipped: no %s\n", path);
        exit(77);
    }
    (void)fclose(f);
    return bytes;
}

static void judge(const char *what, double value, double low, double high)
{
    int ok = value >= low && value <= high;

    printf("  %-44s %9.4f (%.3f to %.3f)%s\n", what, value, low, high,
           ok ? "" : "  OUT");
    failures += !ok;
}

#define BW     240
#define BH     256
#define FRAMES 260
#define FPS    22.674

static plfx_roi_cfg cfg;
static plfx_roi roi;

/* Horizontal place of the dot of floor k in every frame, px; NaN where flagged. */
static int follow(const unsigned char *film, double (*x)[FRAMES])
{
    static const int at[3][2] = {{134, 17}, {138, 96}, {144, 155}};
    static uint16_t px[BW * BH];
    plfx_image m = {px, BW, BH, BW};
    plfx_roi_frame f = {NULL, &m};
    plfx_roi_result out[3];
    void *ws;
    int t;
    int k;

    cfg.nx = BW;
    cfg.ny = BH;
    cfg.bits = 8;
    cfg.tone = plfx_tone_unity(8);
    cfg.views = 1;
    cfg.regions = 3;
    for (k = 0; k < 3; k++) {
        cfg.region[k].i = (int16_t)at[k][0];
        cfg.region[k].j = (int16_t)at[k][1];
        cfg.region[k].hx = 16;
        cfg.region[k].hy = 12;
    }
    cfg.rest = 8;
    cfg.steps = 1;
    cfg.seek = 16;
    cfg.residual_q8 = 65535; /* paper and rods move at their own */
    ws = plft_alloc_ws(plfx_roi_ws(&cfg));
    if (plfx_roi_init(&roi, &cfg, ws, plfx_roi_ws(&cfg))) {
        return 1;
    }
    for (t = 0; t < FRAMES; t++) {
        for (k = 0; k < BW * BH; k++) {
            px[k] = film[(size_t)t * BW * BH + (size_t)k];
        }
        if (t < 8) {
            if (plfx_roi_rest(&roi, &f)) {
                return 1;
            }
        } else if (plfx_roi_measure(&roi, &f, out)) {
            return 1;
        }
        for (k = 0; k < 3; k++) {
            x[k][t] = t < 8 ? 0 : out[k].flags ? NAN : out[k].u_q24 / 16777216.0;
            if (plfx_roi_aim(&roi, k, 0, 0)) {
                return 1; /* it swings about its rest: seek there */
            }
        }
    }
    free(ws);
    return 0;
}

/* The mode in frames first .. first+n-1, their mean taken off. */
static plfx_mode ring_down(const double *x, int first, int n)
{
    static plfx_modal m;
    plfx_modal_cfg c = {22674, 8200000, 2, 1024, 16};
    plfx_mode mode = {0, 0, 0, 0, 0, 0, 0, PLFX_MODE_LOST};
    double mean = 0;
    int t;

    for (t = 0; t < n; t++) {
        mean += (isnan(x[first + t]) ? 0 : x[first + t]) / n;
    }
    if (plfx_modal_init(&m, &c) == PLFX_OK) {
        m.primed = 1; /* the mean is off already */
        for (t = 0; t < n; t++) {
            if (isnan(x[first + t])) {
                plfx_modal_gap(&m, 1);
            } else {
                (void)plfx_modal_push(&m, (int16_t)lround(256 * (x[first + t] - mean)));
            }
        }
        if (plfx_modal_read(&m, 16, &mode)) {
            mode.flags = PLFX_MODE_LOST;
        }
    }
    return mode;
}

static int building(const char *folder)
{
    /* frames from which the swing is within the 16 px that regions are sought over */
    static const int swing[3] = {93, 158, 239};
    static const char *const floor_name[2] = {"top", "floor 2"};
    static double x[3][FRAMES];
    unsigned char *film = load(folder, "vib_building/targets_260x256x240_u8.bin",
                               (size_t)FRAMES * BW * BH);
    int k;
    int r;

    if (follow(film, x)) {
        return 1;
    }
    for (r = 0; r < 3; r++) {
        for (k = 0; k < 2; k++) {
            plfx_mode m = ring_down(x[k], swing[r] - 1, 22);
            printf("building, pull %d, %s: %.3f +- %.3f Hz, damping %.2f +- %.2f %%, "
                   "%.1f s%s\n",
                   r + 1, floor_name[k], m.freq_uhz / 1e6, m.freq_sigma_uhz / 1e6,
                   m.damp_ppm / 1e4, m.damp_sigma_ppm / 1e4, m.record_ms / 1e3,
                   m.flags & PLFX_MODE_GAP ? ", with a gap" : "");
            judge("Hz", m.freq_uhz / 1e6, k ? 7.95 : 8.05, k ? 8.39 : 8.40);
        }
    }
    free(film);
    return 0;
}

#define GW     192
#define GH     48
#define GN     300
#define PIXELS 24

/* Power of a pixel's brightness at f Hz. */
static double power(const unsigned char *film, int p, double f)
{
    double re = 0;
    double im = 0;
    int t;

    for (t = 0; t < GN; t++) {
        double h = 0.5 - 0.5 * cos(2 * PI * t / GN);
        double v = h * film[(size_t)t * GW * GH + (size_t)p];
        re += v * cos(2 * PI * f * t / 600);
        im += v * sin(2 * PI * f * t / 600);
    }
    return re * re + im * im;
}

/* Frequency near `about`, the mean over the pixels that it moves most. */
static double tone(const unsigned char *film, double about)
{
    static double best[PIXELS];
    static int at[PIXELS];
    static plfx_modal m;
    double sum = 0;
    double weight = 0;
    int k;
    int p;
    int t;

    memset(best, 0, sizeof best);
    for (p = 0; p < GW * GH; p++) {
        double e = power(film, p, about);
        for (k = PIXELS - 1; k >= 0 && e > best[k]; k--) {
            if (k < PIXELS - 1) {
                best[k + 1] = best[k];
                at[k + 1] = at[k];
            }
            best[k] = e;
            at[k] = p;
        }
    }
    for (k = 0; k < PIXELS; k++) {
        plfx_modal_cfg c = {600000, 0, 20, 1024, 8};
        plfx_mode mode;
        c.freq_uhz = (uint32_t)lround(about * 1e6);
        if (plfx_modal_init(&m, &c)) {
            return 0;
        }
        for (t = 0; t < GN; t++) {
            (void)plfx_modal_push(
                &m, (int16_t)(128 * film[(size_t)t * GW * GH + (size_t)at[k]]));
        }
        if (plfx_modal_read(&m, 16, &mode) == PLFX_OK &&
            (mode.flags & PLFX_MODE_VALID)) {
            sum += mode.freq_uhz / 1e6 * best[k];
            weight += best[k];
        }
    }
    return weight > 0 ? sum / weight : 0;
}

static void guitar(const char *folder)
{
    static const double about[3] = {81.0, 108.5, 143.5};
    static const double note[3] = {82.41, 110.00, 146.83};
    static const double film_hz[3] = {80.93, 108.47, 143.41};
    unsigned char *film =
        load(folder, "vib_guitar/guitar_luma_300x48x192_u8.bin", (size_t)GN * GW * GH);
    double f[3];
    int k;

    for (k = 0; k < 3; k++) {
        f[k] = tone(film, about[k]);
        printf("guitar: %.3f Hz (note %.2f, spectrum of the film %.2f)\n", f[k],
               note[k], film_hz[k]);
    }
    for (k = 1; k < 3; k++) {
        double r = f[k] / f[k - 1];
        printf("ratio of strings %d and %d: %.4f\n", k + 1, k, r);
        if (k == 1) { /* the third string is 1 % flat against the second */
            judge("over the notes' ratio", r * note[k - 1] / note[k], 0.995, 1.005);
        }
        judge("over the spectrum's", r * film_hz[k - 1] / film_hz[k], 0.995, 1.005);
    }
    free(film);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        (void)fprintf(stderr, "usage: bench_vibration DATA_FOLDER\n");
        return 2;
    }
    if (building(argv[1])) {
        return 2;
    }
    guitar(argv[1]);
    return failures > 0;
}
