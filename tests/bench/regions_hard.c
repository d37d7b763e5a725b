/* SPDX-License-Identifier: MIT
 * Regions on the reference camera under what goes wrong, and what integers cost.
 * usage: bench_regions_hard
 * - camera shake of +-0.5 mm along three axes and +-0.05 degree about three, taken off
 *   by four reference regions; its part that is left, without noise and with it;
 * - cables of three widths before the lens, glints, darkness: regions whose error is
 *   over three stated sigmas in a component must be flagged;
 * - the same estimate in double on the same frames: its scatter beside the core's.
 * Exit status 1 when a figure is over its limit. */
#include "ref_camera.h"

#define LENS_MM 1.125 /* 108 mm over 96 lenses, at 0.5 m */
#define FAR_MM  500.0
#define DEGREE  (PI / 180)

static int is_reference(int k)
{
    return k % 12 == 0 || k % 12 == 11;
}

static void shaken(motion *m, int t)
{
    double a[6];
    int k;

    for (k = 0; k < 6; k++) {
        a[k] = sin(0.31 * (k + 1) * t + k);
    }
    *m = still;
    m->x = (0.5 * a[0] + 0.05 * DEGREE * FAR_MM * a[3]) / LENS_MM;
    m->y = (0.5 * a[1] + 0.05 * DEGREE * FAR_MM * a[4]) / LENS_MM;
    m->d = 0.5 * MM * a[2];
    m->zoom = 0.5 / FAR_MM * a[2];
    m->turn = 0.05 * DEGREE * a[5];
    m->tilt = 0.05 * DEGREE * LENS_MM * MM * a[3];
}

/* rms before and after of in-plane and w. */
static int shake(double noise, double rms[4])
{
    plfx_roi_result before[REGIONS];
    int n = 0;
    int t;
    int k;

    noise_gain = noise;
    memset(rms, 0, 4 * sizeof *rms);
    for (t = 0; t < 25; t++) {
        plfx_roi_shake s;
        motion m;
        shaken(&m, t);
        if (look(&m)) {
            return 1;
        }
        memcpy(before, result, sizeof before);
        if (plfx_roi_shake_fit(&roi, result, &s)) {
            return 1;
        }
        plfx_roi_steady(&roi, &s, result);
        for (k = 0; k < REGIONS; k++) {
            if (result[k].flags == 0 && !is_reference(k)) {
                rms[0] += pow(before[k].u_q24 / 16777216.0, 2) +
                          pow(before[k].v_q24 / 16777216.0, 2);
                rms[1] += pow(result[k].u_q24 / 16777216.0, 2) +
                          pow(result[k].v_q24 / 16777216.0, 2);
                rms[2] += pow(before[k].w_q24 / 16777216.0 / MM, 2);
                rms[3] += pow(result[k].w_q24 / 16777216.0 / MM, 2);
                n++;
            }
        }
    }
    for (k = 0; k < 4; k++) {
        rms[k] = sqrt(rms[k] / n);
    }
    printf("  in-plane %.4f -> %.5f lens, w %.4f -> %.4f mm (%d valid)\n", rms[0],
           rms[1], rms[2], rms[3], n);
    noise_gain = 1;
    return 0;
}

static int shakes(void)
{
    double rms[4];
    int k;

    for (k = 0; k < REGIONS; k++) {
        roi.cfg.region[k].reference = (uint8_t)is_reference(k);
    }
    printf("shake of +-0.5 mm and +-0.05 degree, rms before and after\n");
    if (shake(1, rms)) {
        return 1;
    }
    judge("  in-plane left with noise, %", 100 * rms[1] / rms[0], 10);
    if (shake(0, rms)) {
        return 1;
    }
    judge("  in-plane left without noise, %", 100 * rms[1] / rms[0], 10);
    judge("  w left without noise, %", 100 * rms[3] / rms[2], 10);
    return 0;
}

typedef struct tally {
    int wrong, told, flagged, seen;
} tally;

static double over_sigma(int32_t value, uint32_t sigma, double truth)
{
    return fabs(value / 16777216.0 - truth) / (sigma / 16777216.0);
}

/* Regions that something between lenses a and b touches. */
static void count(const motion *m, double a, double b, tally *t)
{
    int k;

    for (k = 0; k < REGIONS; k++) {
        const plfx_roi_result *r = &result[k];
        int wrong;
        if (cfg.region[k].i + 4 < a || cfg.region[k].i - 4 > b) {
            continue;
        }
        wrong = r->u_q24 == PLFX_ROI_NONE ||
                over_sigma(r->u_q24, r->u_sigma_q24, m->x) > 3 ||
                over_sigma(r->v_q24, r->v_sigma_q24, m->y) > 3 ||
                over_sigma(r->w_q24, r->w_sigma_q24, m->d) > 3;
        t->seen++;
        t->flagged += r->flags != 0;
        t->wrong += wrong;
        t->told += wrong && r->flags != 0;
    }
}

static void report(const char *what, const tally *t)
{
    printf("%s: %d regions touched, %d flagged, %d over 3 sigma of which %d flagged\n",
           what, t->seen, t->flagged, t->wrong, t->told);
    judge("  over 3 sigma without a flag, %",
          t->wrong ? 100.0 * (t->wrong - t->told) / t->wrong : 0, 5);
}

static int cables(tally *sum)
{
    static const double width[3] = {0.5, 1.5, 4};
    int w;
    int t;

    for (w = 0; w < 3; w++) {
        tally one = {0, 0, 0, 0};
        char name[64];
        for (t = 0; t < 40; t++) {
            motion m = still;
            m.x = 0.1 * sin(0.7 * t);
            m.y = 0.1 * sin(1.1 * t);
            m.d = MM * sin(1.7 * t);
            m.width = width[w];
            m.cable = 3 + 2.27 * t;
            if (look(&m)) {
                return 1;
            }
            count(&m, m.cable - m.width / 2, m.cable + m.width / 2, &one);
        }
        (void)snprintf(name, sizeof name, "cable of %.1f lenses", width[w]);
        report(name, &one);
        sum->wrong += one.wrong;
        sum->told += one.told;
        sum->seen += one.seen;
        sum->flagged += one.flagged;
    }
    return 0;
}

static int lights(tally *sum)
{
    tally glint = {0, 0, 0, 0};
    tally lamp = {0, 0, 0, 0};
    int t;

    for (t = 0; t < 28; t++) {
        motion m = still;
        m.x = 0.1 * sin(0.7 * t);
        m.spot = t % 2 ? 0.3 : 1.0;
        m.spot_i = 3 + 3 * t;
        if (look(&m)) {
            return 1;
        }
        count(&m, m.spot_i, m.spot_i + 2, &glint);
        m.spot = 0;
        m.light = 1.0 / (1 + t); /* to 1/40: lamp on its way out */
        if (look(&m)) {
            return 1;
        }
        count(&m, 0, NX, &lamp);
    }
    report("glints of 3 lenses", &glint);
    report("a lamp that goes out", &lamp);
    sum->wrong += glint.wrong + lamp.wrong;
    sum->told += glint.told + lamp.told;
    sum->seen += glint.seen + lamp.seen;
    sum->flagged += glint.flagged + lamp.flagged;
    return 0;
}

/* Motion alone: the interpolator's error must stand in the stated one. */
static int motions(void)
{
    tally one = {0, 0, 0, 0};
    int t;

    for (t = 0; t < 25; t++) {
        motion m = still;
        m.x = 0.45 * sin(0.7 * t);
        m.y = 0.45 * sin(1.1 * t);
        m.d = MM * sin(1.7 * t);
        if (look(&m)) {
            return 1;
        }
        count(&m, 0, NX, &one);
    }
    printf("motion of 0.45 lens: %d regions, %d flagged, %d over 3 sigma\n", one.seen,
           one.flagged, one.wrong);
    judge("  over 3 sigma, %", 100.0 * one.wrong / one.seen, 5);
    return 0;
}

static int occlusions(void)
{
    tally sum = {0, 0, 0, 0};

    if (motions() || cables(&sum) || lights(&sum)) {
        return 1;
    }
    report("all of them", &sum);
    return 0;
}

/* The estimate in double: samples bilinear at exact places, gradients by the same six
 * taps a quarter of a lens to either side, without a constant and without the rest
 * state's own brightness, three unknowns. */
#define SIDE_X 7
#define SIDE_Y 9
#define WIDE_X (SIDE_X + 6)
#define WIDE_Y (SIDE_Y + 6)

static double rest_state[REGIONS][VIEWS][WIDE_Y][WIDE_X];
static double slope[REGIONS][VIEWS][SIDE_Y][SIDE_X][3];
static double inverse[REGIONS][3][3];

static double pixel(double x, double y)
{
    int a = (int)floor(x);
    int b = (int)floor(y);
    const uint16_t *p = raw + b * SW + a;

    x -= a;
    y -= b;
    return (p[0] * (1 - x) + p[1] * x) * (1 - y) +
           (p[SW] * (1 - x) + p[SW + 1] * x) * y;
}

static double seen(int k, int view, int y, int x)
{
    return pixel(centre_x(cfg.region[k].i - 3 + x) + cfg.at[view].u_q8 / 256.0,
                 centre_y(cfg.region[k].j - 4 + y) + cfg.at[view].v_q8 / 256.0);
}

static void rest_double(int frames)
{
    int k, v, y, x;

    for (k = 0; k < REGIONS; k++) {
        for (v = 0; v < VIEWS; v++) {
            for (y = 0; y < WIDE_Y; y++) {
                for (x = 0; x < WIDE_X; x++) {
                    rest_state[k][v][y][x] += seen(k, v, y - 3, x - 3) / frames;
                }
            }
        }
    }
}

/* R(. - 1/4) - R(. + 1/4) a lens: the taps at 1/4 of the core's interpolator. */
static double quarter(int k, int v, int y, int x, int dy, int dx)
{
    static const double tap[6] = {492, -2071, 14288, 4771, -1507, 411};
    double sum = 0;
    int n;

    for (n = 0; n < 6; n++) {
        int a = n - 2;
        sum += tap[n] * (rest_state[k][v][y + 3 - a * dy][x + 3 - a * dx] -
                         rest_state[k][v][y + 3 + a * dy][x + 3 + a * dx]);
    }
    return sum / 16384 / 0.5;
}

static void invert3(double n[3][3], double out[3][3])
{
    double det = 0;
    int a;
    int b;

    for (a = 0; a < 3; a++) {
        for (b = 0; b < 3; b++) {
            int c = (b + 1) % 3;
            int d = (b + 2) % 3;
            int e = (a + 1) % 3;
            int f = (a + 2) % 3;
            out[a][b] = n[c][e] * n[d][f] - n[c][f] * n[d][e];
        }
    }
    for (a = 0; a < 3; a++) {
        det += n[0][a] * out[a][0];
    }
    for (a = 0; a < 9; a++) {
        out[a / 3][a % 3] /= det;
    }
}

/* Gradients, made orthogonal to a constant in the bright and the dark half so that
 * neither a constant nor R itself is seen. */
static void learn_region(int k)
{
    double n[3][3];
    double mean = 0;
    double half[2][4]; /* dark, bright: count, R, and for an axis g */
    int v, y, x, a, b;

    for (v = 0; v < VIEWS; v++) {
        for (y = 0; y < SIDE_Y; y++) {
            for (x = 0; x < SIDE_X; x++) {
                double *g = slope[k][v][y][x];
                g[0] = quarter(k, v, y, x, 0, 1);
                g[1] = quarter(k, v, y, x, 1, 0);
                g[2] = cfg.at[v].u_q8 / 256.0 * g[0] + cfg.at[v].v_q8 / 256.0 * g[1];
                mean += rest_state[k][v][y + 3][x + 3] / (VIEWS * SIDE_X * SIDE_Y);
            }
        }
    }
    memset(n, 0, sizeof n);
    for (a = 0; a < 3; a++) {
        double alpha;
        double beta;
        double ref = 0;
        double sum = 0;
        memset(half, 0, sizeof half);
        for (v = 0; v < VIEWS * SIDE_Y * SIDE_X; v++) {
            double *g =
                slope[k][v / (SIDE_Y * SIDE_X)][v / SIDE_X % SIDE_Y][v % SIDE_X];
            double r = rest_state[k][v / (SIDE_Y * SIDE_X)][v / SIDE_X % SIDE_Y + 3]
                                 [v % SIDE_X + 3];
            half[r >= mean][0]++;
            half[r >= mean][1] += r;
            ref += g[a] * r;
            sum += g[a];
        }
        alpha = (ref - sum * half[0][1] / half[0][0]) /
                (half[1][1] - half[1][0] * half[0][1] / half[0][0]);
        beta = (sum - alpha * half[1][0]) / half[0][0];
        for (v = 0; v < VIEWS * SIDE_Y * SIDE_X; v++) {
            double *g =
                slope[k][v / (SIDE_Y * SIDE_X)][v / SIDE_X % SIDE_Y][v % SIDE_X];
            double r = rest_state[k][v / (SIDE_Y * SIDE_X)][v / SIDE_X % SIDE_Y + 3]
                                 [v % SIDE_X + 3];
            g[a] -= r >= mean ? alpha : beta;
        }
    }
    for (v = 0; v < VIEWS * SIDE_Y * SIDE_X; v++) {
        const double *g =
            slope[k][v / (SIDE_Y * SIDE_X)][v / SIDE_X % SIDE_Y][v % SIDE_X];
        for (a = 0; a < 3; a++) {
            for (b = 0; b < 3; b++) {
                n[a][b] += g[a] * g[b];
            }
        }
    }
    invert3(n, inverse[k]);
}

static double w_double(int k)
{
    double b[3] = {0, 0, 0};
    int v, y, x, a;

    for (v = 0; v < VIEWS; v++) {
        for (y = 0; y < SIDE_Y; y++) {
            for (x = 0; x < SIDE_X; x++) {
                double d = seen(k, v, y, x) - rest_state[k][v][y + 3][x + 3];
                for (a = 0; a < 3; a++) {
                    b[a] += slope[k][v][y][x][a] * d;
                }
            }
        }
    }
    return inverse[k][2][0] * b[0] + inverse[k][2][1] * b[1] + inverse[k][2][2] * b[2];
}

/* Both in double and in the core from the same 16 rest frames. */
static int learn_both(void)
{
    plfx_raw r = {(const uint8_t *)raw, (size_t)SW * SH * 2u, PLFX_RAW_U16, 12, SW, SH};
    plfx_roi_frame f = {&r, NULL};
    int t;
    int k;

    if (plfx_roi_init(&roi, &cfg, ws, plfx_roi_ws(&cfg))) {
        return 1;
    }
    for (t = 0; t < cfg.rest; t++) {
        draw(&still);
        rest_double(cfg.rest);
        if (plfx_roi_rest(&roi, &f)) {
            return 1;
        }
    }
    for (k = 0; k < REGIONS; k++) {
        learn_region(k);
    }
    return 0;
}

static int cost_of_integers(int frames)
{
    double gain[2][REGIONS], sum[2][REGIONS], square[2][REGIONS], ratio[REGIONS];
    motion m = still;
    int t;
    int k;
    int c;

    memset(sum, 0, sizeof sum);
    memset(square, 0, sizeof square);
    if (learn_both()) {
        return 1;
    }
    noise_gain = 0;
    for (t = 0; t < 2; t++) { /* what +-1 mm reads */
        m.d = t ? MM : -MM;
        if (look(&m)) {
            return 1;
        }
        for (k = 0; k < REGIONS; k++) {
            double w[2] = {result[k].w_q24 / 16777216.0, w_double(k)};
            for (c = 0; c < 2; c++) {
                gain[c][k] = t ? (w[c] - gain[c][k]) / (2 * MM) : w[c];
            }
        }
    }
    noise_gain = 1;
    for (t = 0; t < frames; t++) {
        if (look(&still)) {
            return 1;
        }
        for (k = 0; k < REGIONS; k++) {
            double w[2] = {result[k].w_q24 / 16777216.0, w_double(k)};
            for (c = 0; c < 2; c++) {
                sum[c][k] += w[c] / gain[c][k];
                square[c][k] += w[c] / gain[c][k] * w[c] / gain[c][k];
            }
        }
    }
    for (k = 0; k < REGIONS; k++) {
        double sd[2];
        for (c = 0; c < 2; c++) {
            sd[c] = sqrt(square[c][k] / frames - pow(sum[c][k] / frames, 2));
        }
        ratio[k] = sd[0] / sd[1];
    }
    printf("w noise of the core over double on the same %d frames: median %.4f\n",
           frames, median(ratio, REGIONS));
    judge("  integers cost, % (median region)", 100 * (ratio[REGIONS / 2] - 1), 5);
    judge("  in the worst region", 100 * (ratio[REGIONS - 1] - 1), 5);
    return 0;
}

int main(void)
{
    raw = plft_alloc((size_t)SW * SH, sizeof *raw);
    draw_texture();
    if (!raw || start(16)) {
        return 2;
    }
    cfg.residual_q8 = 640;
    roi.cfg.residual_q8 = 640; /* monitor's */
    if (shakes() || occlusions() || cost_of_integers(40)) {
        return 2;
    }
    return failures > 0;
}
