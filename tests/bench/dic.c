/* SPDX-License-Identifier: MIT
 * In-plane tracking on published speckle images.  usage: bench_dic DATA_FOLDER
 * Prints sample 5 (known rigid shift), 14 (commanded sinusoids), 12 (a published
 * solution), each against its limit; exit status 1 when one is over it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/csv.h"
#include "common/frame.h"
#include "common/memory.h"
#include "plenofix/roi.h"

static int failures;

static int load(plft_frame *f, const char *folder, const char *name)
{
    char path[1024];

    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    memset(f, 0, sizeof *f);
    return plft_frame_read(f, path, 0);
}

static plfx_roi roi;
static void *ws;
static plfx_roi_result result[PLFX_ROI_MAX];

/* Subsets centred at xy, half size r, rest state from one frame. */
static int begin(const plft_frame *rest, const int (*xy)[2], int n, int r, int seek)
{
    static plfx_roi_cfg c;
    plfx_image m = {rest->px, rest->w, rest->h, rest->w};
    plfx_roi_frame f = {NULL, &m};
    int k;

    memset(&c, 0, sizeof c);
    c.nx = rest->w;
    c.ny = rest->h;
    c.bits = 8;
    c.tone = plfx_tone_unity(8);
    c.views = 1;
    c.regions = n;
    c.rest = 1;
    c.steps = 4;
    c.seek = seek;
    c.residual_q8 = 65535;
    for (k = 0; k < n; k++) {
        c.region[k].i = (int16_t)xy[k][0];
        c.region[k].j = (int16_t)xy[k][1];
        c.region[k].hx = (uint8_t)r;
        c.region[k].hy = (uint8_t)r;
    }
    free(ws);
    ws = plft_alloc_ws(plfx_roi_ws(&c));
    return plfx_roi_init(&roi, &c, ws, plfx_roi_ws(&c)) || plfx_roi_rest(&roi, &f);
}

static int look(const plft_frame *frame)
{
    plfx_image m = {frame->px, frame->w, frame->h, frame->w};
    plfx_roi_frame f = {NULL, &m};

    return plfx_roi_measure(&roi, &f, result);
}

static void judge(const char *what, double value, double limit)
{
    printf("%-44s %.5f px (limit %.4f)%s\n", what, value, limit,
           value <= limit ? "" : "  OVER");
    failures += !(value <= limit);
}

typedef struct tally {
    double sum, square, sigma;
    int n;
} tally;

static void add(tally *t, double e, uint32_t sigma_q24)
{
    t->sum += e;
    t->square += e * e;
    t->sigma += sigma_q24 / 16777216.0;
    t->n++;
}

static int sample5(const char *folder)
{
    static const struct {
        const char *name;
        double shift;
    } frame[2] = {{"x0.10_y0.10_n2_c100_r20.png", 0.1},
                  {"x0.00_y0.00_n2_c75_r10.png", 0}};
    plft_frame rest;
    plft_frame now;
    int s;
    int k;

    if (load(&rest, folder, "reference.png")) {
        return 1;
    }
    for (s = 0; s < 2; s++) {
        tally x = {0, 0, 0, 0};
        tally y = {0, 0, 0, 0};
        int part;
        if (load(&now, folder, frame[s].name)) {
            return 1;
        }
        for (part = 0; part < 3; part++) {
            int xy[48][2];
            for (k = 0; k < 48; k++) {
                xy[k][0] = 40 + 36 * (k % 12);
                xy[k][1] = 40 + 36 * (k / 12 + 4 * part);
            }
            if (begin(&rest, (const int(*)[2])xy, 48, 17, 0) || look(&now)) {
                return 1;
            }
            for (k = 0; k < 48; k++) {
                if (result[k].flags == 0) {
                    add(&x, result[k].u_q24 / 16777216.0 - frame[s].shift,
                        result[k].u_sigma_q24);
                    add(&y, result[k].v_q24 / 16777216.0 - frame[s].shift,
                        result[k].v_sigma_q24);
                }
            }
        }
        printf("sample 5 shift %.2f: x %+.4f +- %.4f (stated %.4f), y %+.4f +- %.4f "
               "(%.4f),"
               " %d subsets\n",
               frame[s].shift, x.sum / x.n,
               sqrt(x.square / x.n - x.sum / x.n * x.sum / x.n), x.sigma / x.n,
               y.sum / y.n, sqrt(y.square / y.n - y.sum / y.n * y.sum / y.n),
               y.sigma / y.n, x.n);
        judge("sample 5 rms x", sqrt(x.square / x.n), 0.006);
        judge("sample 5 rms y", sqrt(y.square / y.n), 0.006);
        plft_frame_free(&now);
    }
    plft_frame_free(&rest);
    return 0;
}

/* 31 x 31 subsets, mean over the columns of subsets, against the commanded shift. */
static int sample14(const char *folder)
{
    static const char *const names[3] = {"L1.png", "L3.png", "L5.png"};
    plft_csv command;
    plft_frame rest;
    char path[1024];
    int s;

    (void)snprintf(path, sizeof path, "%s/command.csv", folder);
    if (load(&rest, folder, "reference.png") || plft_csv_read(&command, path)) {
        return 1;
    }
    for (s = 0; s < 3; s++) {
        plft_frame now;
        double square = 0;
        int n = 0;
        int x;
        if (load(&now, folder, names[s])) {
            return 1;
        }
        for (x = 40; x < 2008; x += 8) {
            int xy[16][2];
            double mean = 0;
            double want = 0;
            int good = 0;
            int k;
            for (k = 0; k < 16; k++) {
                xy[k][0] = x;
                xy[k][1] = 40 + 33 * k;
            }
            if (begin(&rest, (const int(*)[2])xy, 16, 15, 0) || look(&now)) {
                return 1;
            }
            for (k = 0; k < 16; k++) {
                if (result[k].flags == 0) {
                    mean += result[k].u_q24 / 16777216.0;
                    good++;
                }
            }
            want = command.v[(size_t)x * (size_t)command.cols + (size_t)(1 + 2 * s)];
            if (good) {
                square += (mean / good - want) * (mean / good - want);
                n++;
            }
        }
        printf("sample 14 %s: %d columns of subsets\n", names[s], n);
        judge("sample 14 rms against the command", sqrt(square / n), 0.006);
        plft_frame_free(&now);
    }
    plft_csv_free(&command);
    plft_frame_free(&rest);
    return 0;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Rows of a published solution: x, y, displacement, displacement.  */
static int solution(double (*row)[4], const char *folder, const char *name)
{
    char path[1024];
    char line[512];
    FILE *f;
    int n = 0;

    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    f = fopen(path, "r");
    while (f && fgets(line, sizeof line, f) && n < 1024) {
        n += sscanf(line, "%lf,%lf,%lf,%lf", &row[n][0], &row[n][1], &row[n][2],
                    &row[n][3]) == 4;
    }
    if (f) {
        (void)fclose(f);
    }
    return n;
}

static int sample12(const char *folder)
{
    static const char *const steps[5] = {"01", "02", "05", "08", "11"};
    static double row[1024][4];
    static double dx[1024], dy[1024];
    plft_frame rest;
    plft_frame now[5];
    char name[64];
    int n = 0;
    int m = solution(row, folder, "DICe_solution_11.txt");
    int s;
    int k;

    if (load(&rest, folder, "oht_cfrp_00.png")) {
        return 1;
    }
    for (s = 0; s < 5; s++) {
        (void)snprintf(name, sizeof name, "oht_cfrp_%s.png", steps[s]);
        if (load(&now[s], folder, name)) {
            return 1;
        }
    }
    for (k = 0; k < m; k++) {
        int xy[1][2];
        xy[0][0] = (int)floor(row[k][0] + 0.5);
        xy[0][1] = (int)floor(row[k][1] + 0.5);
        if (begin(&rest, (const int(*)[2])xy, 1, 13, 12)) {
            return 1;
        }
        for (s = 0; s < 5; s++) {
            if (look(&now[s])) {
                return 1;
            }
        }
        if (result[0].flags == 0) {
            dx[n] = fabs(result[0].u_q24 / 16777216.0 - row[k][2]);
            dy[n] = fabs(result[0].v_q24 / 16777216.0 - row[k][3]);
            n++;
        }
    }
    qsort(dx, (size_t)n, sizeof *dx, compare);
    qsort(dy, (size_t)n, sizeof *dy, compare);
    printf("sample 12 frame 11: %d of %d subsets\n", n, m);
    judge("sample 12 median |x - published|", dx[n / 2], 0.01);
    judge("sample 12 median |y - published|", dy[n / 2], 0.01);
    for (s = 0; s < 5; s++) {
        plft_frame_free(&now[s]);
    }
    plft_frame_free(&rest);
    return 0;
}

int main(int argc, char **argv)
{
    char path[3][512];
    FILE *f;

    if (argc != 2) {
        fprintf(stderr, "usage: bench_dic DATA_FOLDER\n");
        return 2;
    }
    (void)snprintf(path[0], sizeof path[0], "%s/dic_sample5", argv[1]);
    (void)snprintf(path[1], sizeof path[1], "%s/dic_sample14", argv[1]);
    (void)snprintf(path[2], sizeof path[2], "%s/dic_sample12_real_oht_cfrp", argv[1]);
    (void)strncat(path[0], "/README.md", sizeof path[0] - strlen(path[0]) - 1);
    f = fopen(path[0], "r");
    if (!f) {
        printf("skipped: no speckle images in %s\n", argv[1]);
        return 77;
    }
    (void)fclose(f);
    path[0][strlen(path[0]) - strlen("/README.md")] = '\0';
    if (sample5(path[0]) || sample14(path[1]) || sample12(path[2])) {
        return 2;
    }
    free(ws);
    return failures > 0;
}
