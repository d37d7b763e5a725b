/* SPDX-License-Identifier: MIT
 * optics: the line 1/d = inv0 + gain*D through targets at known distances. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "common/args.h"
#include "common/csv.h"
#include "common/err.h"
#include "common/json.h"
#include "common/out.h"

typedef struct line {
    double inv0, gain;             /* dioptres */
    double inv0_sigma, gain_sigma; /* 1-sigma; 0 with two targets */
    double rms_mm, worst_mm;
    double near_mm, far_mm; /* the targets' range */
} line;

typedef struct targets {
    const plft_csv *csv;
    int slope, distance; /* columns */
} targets;

static double slope_at(const targets *t, size_t k)
{
    return t->csv->v[k * (size_t)t->csv->cols + (size_t)t->slope];
}

static double metres_at(const targets *t, size_t k)
{
    return t->csv->v[k * (size_t)t->csv->cols + (size_t)t->distance] / 1000.0;
}

static int find_columns(targets *t, const char *path)
{
    size_t k;

    t->slope = plft_csv_column(t->csv, "slope");
    t->distance = plft_csv_column(t->csv, "distance_mm");
    if (t->csv->header == NULL && t->csv->cols == 2) {
        t->slope = 0;
        t->distance = 1;
    }
    if (t->slope < 0 || t->distance < 0 || t->slope >= t->csv->cols ||
        t->distance >= t->csv->cols) {
        return plft_fail(PLFT_DATA, "%s: want columns slope,distance_mm", path);
    }
    for (k = 0; k < t->csv->rows; k++) {
        if (!(fabs(slope_at(t, k)) <= 32.0) ||
            !(metres_at(t, k) > 0.001 && metres_at(t, k) < 1e5)) {
            return plft_fail(
                PLFT_DATA,
                "%s: target %zu: want a slope and a distance from the main "
                "lens in millimetres",
                path, k + 1);
        }
    }
    return 0;
}

/* Least squares of the error in distance: that of 1/d times d^2. */
static int fit(const targets *t, line *l)
{
    double s0 = 0, s1 = 0, s2 = 0, t0 = 0, t1 = 0, det, sum = 0;
    size_t k, n = t->csv->rows;

    for (k = 0; k < n; k++) {
        double x = slope_at(t, k), d = metres_at(t, k), w = pow(d, 4);
        s0 += w;
        s1 += w * x;
        s2 += w * x * x;
        t0 += w / d;
        t1 += w * x / d;
    }
    det = s0 * s2 - s1 * s1;
    if (n < 2 || !(det > 1e-9 * s0 * s2)) {
        return PLFT_DATA;
    }
    l->inv0 = (s2 * t0 - s1 * t1) / det;
    l->gain = (s0 * t1 - s1 * t0) / det;
    l->near_mm = l->far_mm = 1000.0 * metres_at(t, 0);
    for (k = 0; k < n; k++) {
        double inv = l->inv0 + l->gain * slope_at(t, k);
        double e = 1000.0 * (1.0 / inv - metres_at(t, k));
        sum += e * e;
        l->worst_mm = fmax(l->worst_mm, fabs(e));
        l->near_mm = fmin(l->near_mm, 1000.0 * metres_at(t, k));
        l->far_mm = fmax(l->far_mm, 1000.0 * metres_at(t, k));
    }
    l->rms_mm = sqrt(sum / (double)n);
    if (n > 2) { /* residuals' variance in metres^2 is that of a unit weight */
        const double variance = 1e-6 * sum / (double)(n - 2);
        l->inv0_sigma = sqrt(variance * s2 / det);
        l->gain_sigma = sqrt(variance * s0 / det);
    }
    return 0;
}

/* What a hundredth of slope is at a distance: |gain| d^2, mm. */
static double resolution_mm(const line *l, double mm)
{
    return 0.01 * fabs(l->gain) * mm * mm / 1000.0;
}

static int write_line(const line *l, const char *path)
{
    json_t *root = json_pack(
        "{s:f,s:f,s:f,s:f,s:f,s:f,s:[ff],s:[ff]}", "inv0", l->inv0, "gain", l->gain,
        "inv0_sigma", l->inv0_sigma, "gain_sigma", l->gain_sigma, "rms_mm", l->rms_mm,
        "worst_mm", l->worst_mm, "range_mm", l->near_mm, l->far_mm, "mm_per_hundredth",
        resolution_mm(l, l->near_mm), resolution_mm(l, l->far_mm));
    int rc = root == NULL ? plft_fail(PLFT_DATA, "out of memory")
                          : plft_json_write(path, root);

    json_decref(root);
    return rc;
}

static int run(const char *csv_path, const char *out)
{
    plft_csv csv;
    targets t;
    line l;
    int rc = plft_csv_read(&csv, csv_path);

    memset(&l, 0, sizeof l);
    if (rc != 0) {
        return rc;
    }
    t.csv = &csv;
    rc = find_columns(&t, csv_path);
    if (rc == 0 && fit(&t, &l) != 0) {
        rc = plft_fail(PLFT_DATA, "%s: want two targets of different slopes, or more",
                       csv_path);
    }
    rc = rc != 0 ? rc : write_line(&l, out);
    if (rc == 0) {
        printf(
            "%s: 1/d = %.5f %+.5f D dioptres; %zu targets, error %.3f mm rms, %.3f mm "
            "at most\n",
            out, l.inv0, l.gain, csv.rows, l.rms_mm, l.worst_mm);
        if (csv.rows > 2) {
            printf("1-sigma %.5f and %.5f dioptres\n", l.inv0_sigma, l.gain_sigma);
        }
        printf(
            "from %.1f to %.1f mm; a hundredth of slope is %.3f mm near, %.3f mm far\n",
            l.near_mm, l.far_mm, resolution_mm(&l, l.near_mm),
            resolution_mm(&l, l.far_mm));
    }
    plft_csv_free(&csv);
    return rc;
}

static const plft_usage usage = {"optics", "TARGETS.csv -o O.json",
                                 "The line from slope to distance, fitted to targets: "
                                 "rows \"slope,distance_mm\", the\n"
                                 "distance from the main lens.  Two targets or more; "
                                 "the error in distance is least."};

int plft_cmd_optics(int argc, char **argv)
{
    const char *out = NULL;
    const char *operand[1] = {NULL};
    int n, helped, rc;
    const plft_option options[] = {
        {"-o", PLFT_TEXT, &out, "O.json", 0, 0, "the optics, for depth --optics"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};

    rc = plft_args(argc, argv, &usage, options, operand, 1, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    if (n != 1 || out == NULL) {
        return plft_fail(PLFT_USAGE, "want TARGETS.csv and -o O.json");
    }
    rc = plft_out_check(out);
    return rc != 0 ? rc : run(operand[0], out);
}
