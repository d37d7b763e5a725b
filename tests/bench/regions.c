/* SPDX-License-Identifier: MIT
 * Regions on the reference camera: noise, bound, stated error and scale against their
 * limits.  usage: bench_regions [frames]; exit status 1 when one is over. */
#include "ref_camera.h"

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
    motion m = still;
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
        judge("  the lowest region's distance from 1", 1 - ratio[k][0], 0.25);
        judge("  the highest region's", ratio[k][REGIONS - 1] - 1, 0.25);
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
        motion m = still;
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
    int frames = argc > 1 ? atoi(argv[1]) : 160;

    int moves = frames < 30 ? frames : 30;

    raw = plft_alloc((size_t)SW * SH, sizeof *raw);
    draw_texture();
    if (!raw || start(16)) {
        return 2;
    }
    printf("workspace %zu bytes of %zu that the macro reserves, state %zu\n",
           plfx_roi_ws(&cfg), (size_t)PLFX_ROI_WS(REGIONS, 7u, 9u, VIEWS, 0, NX),
           sizeof roi);
    judge("multiply-adds a second at 200 Hz, millions",
          200e-6 * REGIONS * (VIEWS * (63.0 * 6 + 9 * 5) + 1450), 60);
    judge("static memory, MiB", (double)(plfx_roi_ws(&cfg) + sizeof roi) / 1048576, 1);
    if (still_noise(frames) || moving(moves, 0, "w of 2 mm") ||
        moving(moves, 0.05, "and 0.05 lens in the plane") ||
        moving(moves, 0.45, "and 0.45 lens in the plane") ||
        moving(moves, 1.5, "and 1.5 lenses in the plane")) {
        return 2;
    }
    return failures > 0;
}
