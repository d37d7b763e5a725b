/* SPDX-License-Identifier: MIT
 * self-test: noise floor of a still target, line between commanded and measured
 * steps. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "common/csv.h"
#include "common/err.h"
#include "common/json.h"
#include "common/memory.h"
#include "common/out.h"
#include "motion/bench.h"

#define OPERANDS  100000
#define LEAST     30   /* frames of a noise floor */
#define AGREE     0.25 /* of the stated standard error with the scatter */
#define FLAGGED   0.01 /* share of measurements */
#define SURE      4.0  /* standard errors that make a drift or a bend real */
#define LINEAR    0.01 /* of the range of the steps */
#define SCALE     0.01 /* standard error of a scale */
#define OFF_MODEL 0.03 /* of the scale that optics foretell */

typedef struct request {
    plft_series_wish series;
    const char *steps, *out;
    double mm_lens, mm_slope;
    int json, step;
} request;

typedef struct job {
    request r;
    plft_series s;
    plft_floor floor[PLFX_ROI_MAX][3];
    char why[256]; /* empty: passed */
} job;

static void fault(job *j, const char *what)
{
    size_t n = strlen(j->why);

    (void)snprintf(j->why + n, sizeof j->why - n, "%s%s", n > 0 ? "; " : "", what);
}

static int verdict(const job *j, const char *test)
{
    if (j->why[0] == '\0') {
        printf("%s: PASS\n", test);
        return 0;
    }
    printf("%s: FAIL: %s\n", test, j->why);
    return PLFT_DATA;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return x < y ? -1 : x > y;
}

static double median(double *v, int n)
{
    qsort(v, (size_t)n, sizeof *v, by_value);
    return n > 0 ? v[n / 2] : (double)NAN;
}

/* ---- noise ---- */

enum { SCATTER, STATED, RATIO, DRIFT, DRIFT_SIGMAS };

/* Median over the regions that were measured. */
static double of_regions(const job *j, int axis, int what)
{
    double v[PLFX_ROI_MAX];
    int n = 0, k;

    for (k = 0; k < j->s.cfg.regions; k++) {
        const plft_floor *f = &j->floor[k][axis];
        double x = what == SCATTER  ? f->scatter
                   : what == STATED ? f->stated
                   : what == RATIO  ? f->stated / f->scatter
                   : what == DRIFT  ? fabs(f->drift) / f->stated
                                    : fabs(f->drift) / f->drift_sigma;
        if (isfinite(x)) {
            v[n++] = x;
        }
    }
    return median(v, n);
}

static double flagged_share(const plft_series *s)
{
    double n = 0;
    int t, k;

    for (t = 0; t < s->frames; t++) {
        for (k = 0; k < s->cfg.regions; k++) {
            n += isnan(plft_series_value(s, t, k, 0));
        }
    }
    return n / ((double)s->frames * s->cfg.regions);
}

static void judge_noise(job *j)
{
    double flagged = flagged_share(&j->s);
    char text[96];
    int a;

    if (flagged > FLAGGED) {
        (void)snprintf(text, sizeof text, "%.1f %% of the measurements are flagged",
                       100.0 * flagged);
        fault(j, text);
    }
    for (a = 0; a < 3; a++) {
        double ratio = of_regions(j, a, RATIO);
        if (isnan(ratio)) {
            (void)snprintf(text, sizeof text, "%c was not measured", "uvw"[a]);
            fault(j, text);
        } else if (fabs(ratio - 1.0) > AGREE) {
            (void)snprintf(text, sizeof text,
                           "the stated error of %c is %.2f times its scatter", "uvw"[a],
                           ratio);
            fault(j, text);
        }
        if (of_regions(j, a, DRIFT) > 1.0 && of_regions(j, a, DRIFT_SIGMAS) > SURE) {
            (void)snprintf(
                text, sizeof text,
                "%c drifts by %.1f standard errors: the target or the camera "
                "moves",
                "uvw"[a], of_regions(j, a, DRIFT));
            fault(j, text);
        }
    }
}

static int write_noise(const job *j)
{
    plft_out out = {NULL, NULL, NULL};
    int rc = plft_out_open(&out, j->r.out);
    int k, a;

    if (rc != 0) {
        return rc;
    }
    fprintf(out.file, "region,i,j,axis,frames,scatter,stated,drift,drift_sigma\n");
    for (k = 0; k < j->s.cfg.regions; k++) {
        for (a = 0; a < 3; a++) {
            const plft_floor *f = &j->floor[k][a];
            fprintf(out.file, "%d,%d,%d,%d,%d", k, j->s.cfg.region[k].i,
                    j->s.cfg.region[k].j, a, f->n);
            if (f->n > 2) {
                fprintf(out.file, ",%.5g,%.5g,%.5g,%.5g\n", f->scatter, f->stated,
                        f->drift, f->drift_sigma);
            } else {
                fprintf(out.file, ",,,,\n");
            }
        }
    }
    return plft_out_commit(&out);
}

static double unit(const job *j, int axis)
{
    double mm = axis == 2 ? fabs(j->r.mm_slope) : j->r.mm_lens;

    return mm > 0 ? mm : 1.0;
}

static const char *unit_name(const job *j, int axis)
{
    if (axis == 2) {
        return j->r.mm_slope != 0 ? "mm" : "slope";
    }
    return j->r.mm_lens > 0 ? "mm" : "lens";
}

static int noise_json(const job *j)
{
    json_t *axes = json_array();
    json_t *root;
    int rc, a;

    for (a = 0; a < 3; a++) {
        char name[2] = {"uvw"[a], '\0'};
        (void)json_array_append_new(
            axes, json_pack("{s:s,s:s,s:f,s:f,s:f,s:f}", "axis", name, "unit",
                            unit_name(j, a), "scatter",
                            of_regions(j, a, SCATTER) * unit(j, a), "stated",
                            of_regions(j, a, STATED) * unit(j, a), "ratio",
                            of_regions(j, a, RATIO), "drift_sigmas",
                            of_regions(j, a, DRIFT_SIGMAS)));
    }
    root = json_pack("{s:s,s:b,s:s,s:i,s:i,s:f,s:o}", "test", "noise", "pass",
                     j->why[0] == '\0', "why", j->why, "frames", j->s.frames, "regions",
                     j->s.cfg.regions, "flagged", flagged_share(&j->s), "axes", axes);
    rc = root ? plft_json_print(root) : plft_fail(PLFT_DATA, "out of memory");
    json_decref(root);
    return rc ? rc : j->why[0] == '\0' ? 0 : PLFT_DATA;
}

static int noise(job *j)
{
    int rc = 0, k, a;

    if (j->s.frames < LEAST) {
        return plft_fail(PLFT_DATA,
                         "%d frames behind the rest state: want %d of a still "
                         "target at least",
                         j->s.frames, LEAST);
    }
    for (k = 0; k < j->s.cfg.regions; k++) {
        for (a = 0; a < 3; a++) {
            j->floor[k][a] = plft_floor_of(&j->s, k, a);
        }
    }
    judge_noise(j);
    rc = j->r.out ? write_noise(j) : 0;
    if (rc != 0 || j->r.json) {
        return rc ? rc : noise_json(j);
    }
    printf("%d frames, %d regions, %.2f %% flagged; medians of the regions:\n",
           j->s.frames, j->s.cfg.regions, 100.0 * flagged_share(&j->s));
    for (a = 0; a < 3; a++) {
        printf(
            "%c  scatter %.4g %s, stated %.4g (%.2f times), drift %.2f of it over the "
            "record\n",
            "uvw"[a], of_regions(j, a, SCATTER) * unit(j, a), unit_name(j, a),
            of_regions(j, a, STATED) * unit(j, a), of_regions(j, a, RATIO),
            of_regions(j, a, DRIFT));
    }
    return verdict(j, "noise");
}

/* ---- steps ---- */

typedef struct command { /* the file of steps */
    plft_csv csv;
    int *frame;
    double *mm[3]; /* per axis, NULL: no column */
} command;

static double *column(const plft_csv *csv, int c)
{
    double *v = plft_alloc(csv->rows, sizeof *v);
    size_t r;

    for (r = 0; v != NULL && r < csv->rows; r++) {
        v[r] = csv->v[r * (size_t)csv->cols + (size_t)c];
    }
    return v;
}

static int read_steps(command *c, const char *path)
{
    static const char *const names[3] = {"u_mm", "v_mm", "w_mm"};
    int frame, a, axes = 0;
    size_t r;
    int rc = plft_csv_read(&c->csv, path);

    if (rc != 0) {
        return rc;
    }
    frame = plft_csv_column(&c->csv, "frame");
    c->frame = plft_alloc(c->csv.rows, sizeof *c->frame);
    for (a = 0; a < 3; a++) {
        int at = plft_csv_column(&c->csv, names[a]);
        c->mm[a] = at >= 0 ? column(&c->csv, at) : NULL;
        axes += at >= 0;
    }
    if (frame < 0 || axes == 0) {
        return plft_fail(PLFT_DATA, "%s: want columns frame and u_mm, v_mm or w_mm",
                         path);
    }
    for (r = 0; c->frame != NULL && r < c->csv.rows; r++) {
        double v = c->csv.v[r * (size_t)c->csv.cols + (size_t)frame];
        if (!(v >= 0 && v < 1e9 && v == floor(v))) {
            return plft_fail(PLFT_DATA,
                             "%s: row %zu: want the number of a frame, from "
                             "0",
                             path, r + 1);
        }
        c->frame[r] = (int)v;
    }
    return c->frame != NULL ? 0 : PLFT_DATA;
}

static void judge_line(job *j, int a, const plft_line *l)
{
    double model = a == 2 ? j->r.mm_slope : j->r.mm_lens;
    char text[128];

    if (!(l->sigma < SCALE * fabs(l->mm_per_unit))) {
        (void)snprintf(text, sizeof text,
                       "the scale of %c is known to %.2g %% only: larger or more steps",
                       "uvw"[a], 100.0 * l -> sigma / fabs(l->mm_per_unit));
        fault(j, text);
    }
    if (l->worst > LINEAR * l->range &&
        l->worst > SURE * l->noise / sqrt((double)j->s.cfg.regions)) {
        (void)snprintf(text, sizeof text, "a step of %c lies %.2g mm off the line",
                       "uvw"[a], l -> worst);
        fault(j, text);
    }
    if (l->missing > FLAGGED * (l->samples + l->missing)) {
        (void)snprintf(text, sizeof text, "%d measurements of %c are flagged",
                       l->missing, "uvw"[a]);
        fault(j, text);
    }
    if (model != 0 && fabs(l->mm_per_unit / model - 1.0) > OFF_MODEL) {
        (void)snprintf(text, sizeof text,
                       "the scale of %c is %.1f %% off the one that was named",
                       "uvw"[a], 100.0 * (l->mm_per_unit / model - 1.0));
        fault(j, text);
    }
}

static json_t *line_json(int a, const plft_line *l)
{
    char name[2] = {"uvw"[a], '\0'};

    return json_pack("{s:s,s:f,s:f,s:f,s:f,s:f,s:i,s:i}", "axis", name,
                     a == 2 ? "mm_per_slope" : "mm_per_lens", l->mm_per_unit, "sigma",
                     isfinite(l->sigma) ? l->sigma : 0.0, "range_mm", l->range,
                     "worst_mm", l->worst, "noise_mm", l->noise, "measurements",
                     l->samples, "flagged", l->missing);
}

static void print_line(int a, const plft_line *l)
{
    printf(
        "%c  %.6g +- %.2g mm a %s, over %.4g mm off the line by %.2g mm at most (%.2f "
        "%%), noise %.3g mm\n",
        "uvw"[a], l -> mm_per_unit, l -> sigma, a == 2 ? "unit of slope" : "lens",
        l->range, l->worst, 100.0 * l->worst / l->range, l->noise);
}

static int write_steps(const job *j, const command *c, double *const residual[3])
{
    plft_out out = {NULL, NULL, NULL};
    int rc = plft_out_open(&out, j->r.out);
    size_t r;
    int a;

    if (rc != 0) {
        return rc;
    }
    fprintf(out.file, "frame,axis,commanded_mm,residual_mm\n");
    for (r = 0; r < c->csv.rows; r++) {
        for (a = 0; a < 3; a++) {
            if (residual[a] != NULL && isfinite(residual[a][r])) {
                fprintf(out.file, "%d,%d,%.6g,%.5g\n", c->frame[r], a, c->mm[a][r],
                        residual[a][r]);
            }
        }
    }
    return plft_out_commit(&out);
}

static int step_report(job *j, const command *c, const plft_line line[3])
{
    json_t *axes = json_array();
    json_t *root;
    int rc, a;

    for (a = 0; a < 3; a++) {
        if (c->mm[a] != NULL) {
            judge_line(j, a, &line[a]);
            (void)json_array_append_new(axes, line_json(a, &line[a]));
            if (!j->r.json) {
                print_line(a, &line[a]);
            }
        }
    }
    if (!j->r.json) {
        json_decref(axes);
        printf("for monitor:");
        if (c->mm[0] != NULL || c->mm[1] != NULL) {
            printf(" --mm-per-lens %.7g", line[c->mm[0] ? 0 : 1].mm_per_unit);
        }
        if (c->mm[2] != NULL) {
            printf(" --mm-per-slope %.7g", line[2].mm_per_unit);
        }
        printf("\n");
        return verdict(j, "step");
    }
    root = json_pack("{s:s,s:b,s:s,s:i,s:o}", "test", "step", "pass", j->why[0] == '\0',
                     "why", j->why, "regions", j->s.cfg.regions, "axes", axes);
    rc = root ? plft_json_print(root) : plft_fail(PLFT_DATA, "out of memory");
    json_decref(root);
    return rc ? rc : j->why[0] == '\0' ? 0 : PLFT_DATA;
}

static int step(job *j, const command *c)
{
    double *residual[3] = {NULL, NULL, NULL};
    plft_line line[3];
    int rc = 0, a;

    for (a = 0; a < 3 && rc == 0; a++) {
        if (c->mm[a] != NULL) {
            plft_steps steps = {c->frame, c->mm[a], (int)c->csv.rows};
            residual[a] = plft_alloc(c->csv.rows, sizeof **residual);
            rc = residual[a] ? plft_line_fit(&j->s, &steps, a, &line[a], residual[a])
                             : PLFT_DATA;
        }
    }
    rc = rc || j->r.out == NULL ? rc : write_steps(j, c, residual);
    for (a = 0; a < 3; a++) {
        free(residual[a]);
    }
    return rc ? rc : step_report(j, c, line);
}

static int run(job *j)
{
    command c;
    int a;
    int rc = 0;

    memset(&c, 0, sizeof c);
    if (j->r.step) {
        rc = j->r.steps
                 ? read_steps(&c, j->r.steps)
                 : plft_fail(PLFT_USAGE, "self-test step: want --steps STEPS.csv");
    }
    rc = rc ? rc : plft_series_take(&j->s, &j->r.series);
    rc = rc ? rc : j->r.step ? step(j, &c) : noise(j);
    free(c.frame);
    for (a = 0; a < 3; a++) {
        free(c.mm[a]);
    }
    plft_csv_free(&c.csv);
    return rc;
}

static const plft_usage usage = {
    "self-test",
    "noise|step FRAME...|FOLDER|FLIGHT.plxr --lut CAM.plut --regions R.csv [options]",
    "noise: frames of a still target; scatter of each region beside the error that is\n"
    "stated, and drift.  step: frames of a target moved by known steps (--steps, "
    "columns\n"
    "frame,u_mm,v_mm,w_mm; w towards the camera; frames count from 0); scale and\n"
    "linearity.  The last line is the verdict; exit status 1 when it is FAIL."};

static int parse(int argc, char **argv, request *r, const char **operands, int *helped)
{
    const plft_option own[] = {
        {"--steps", PLFT_TEXT, &r->steps, "STEPS.csv", 0, 0, "commanded steps"},
        {"--mm-per-lens", PLFT_REAL, &r->mm_lens, "X", 1e-6, 1e6,
         "scale of u and v as it should be"},
        {"--mm-per-slope", PLFT_REAL, &r->mm_slope, "X", -1e9, 1e9,
         "scale of w as it should be"},
        {"-o", PLFT_TEXT, &r->out, "T.csv", 0, 0, "every region, or every step"},
        {"--json", PLFT_FLAG, &r->json, NULL, 0, 0, "print JSON"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    plft_option options[PLFT_SERIES_OPTIONS + sizeof own / sizeof own[0]];
    int n = 0;
    int rc;

    plft_series_options(options, &r->series);
    memcpy(options + PLFT_SERIES_OPTIONS, own, sizeof own);
    rc = plft_args(argc, argv, &usage, options, operands, OPERANDS, &n, helped);
    if (rc != 0 || *helped) {
        return rc;
    }
    r->step = n > 0 && strcmp(operands[0], "step") == 0;
    if (n == 0 || (!r->step && strcmp(operands[0], "noise") != 0)) {
        return plft_fail(PLFT_USAGE, "self-test: want noise or step before the frames");
    }
    r->series.names = operands + 1;
    r->series.n = n - 1;
    return plft_out_check(r->out);
}

int plft_cmd_self_test(int argc, char **argv)
{
    const char **operands = plft_alloc(OPERANDS, sizeof *operands);
    job *j = plft_alloc(1, sizeof *j);
    int helped = 0;
    int rc = PLFT_DATA;

    if (operands != NULL && j != NULL) {
        j->r.series.rest = 8;
        j->r.series.views = 25;
        rc = parse(argc, argv, &j->r, operands, &helped);
        rc = rc || helped ? rc : run(j);
        plft_series_free(&j->s);
    }
    free(operands);
    free(j);
    return rc;
}
