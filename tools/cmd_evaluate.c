/* SPDX-License-Identifier: MIT
 * plenofix evaluate: a disparity map against its truth. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "common/args.h"
#include "common/colour.h"
#include "common/err.h"
#include "common/frame.h"
#include "common/json.h"
#include "common/memory.h"
#include "common/pfm.h"
#include "evaluate.h"

typedef struct options {
    const char *map, *truth;
    const char *mask, *errors, *confidence, *sigma;
    int border, json;
} options;

typedef struct job {
    options o;
    plft_map map, truth, confidence, sigma;
    uint8_t *mask, *use;
    float *error;
    plft_figures f;
    double by_confidence[PLFT_CURVE], by_sigma[PLFT_CURVE];
    double ratio;
} job;

static int parse(int argc, char **argv, options *o, int *helped)
{
    const plft_usage usage = {"evaluate", "DISP.pfm TRUTH.pfm [options]",
                              "Share of bad pixels (error over 0.07, 0.03, 0.01), mean "
                              "squared error and median\n"
                              "of a map against its truth; missing pixels are bad, "
                              "those without truth left out."};
    const plft_option table[] = {
        {"--mask", PLFT_TEXT, NULL, "M.png", 0, 0, "judge only where M is not black"},
        {"--border", PLFT_INT, NULL, "N", 0, 4096, "pixels left out at the rim (15)"},
        {"--errors", PLFT_TEXT, NULL, "E.png", 0, 0, "picture of the errors"},
        {"--confidence", PLFT_TEXT, NULL, "C.pfm", 0, 0,
         "also BadPix(0.07) of the 100, 90 .. 10 % of highest confidence"},
        {"--sigma", PLFT_TEXT, NULL, "S.pfm", 0, 0,
         "the same of least standard error, and scatter over it"},
        {"--json", PLFT_FLAG, NULL, NULL, 0, 0, "figures as JSON"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    plft_option t[sizeof table / sizeof table[0]];
    const char *names[2] = {NULL, NULL};
    int n = 0;
    int status;

    memcpy(t, table, sizeof table);
    t[0].target = &o->mask;
    t[1].target = &o->border;
    t[2].target = &o->errors;
    t[3].target = &o->confidence;
    t[4].target = &o->sigma;
    t[5].target = &o->json;
    status = plft_args(argc, argv, &usage, t, names, 2, &n, helped);
    if (status == 0 && !*helped && n != 2) {
        status = plft_fail(PLFT_USAGE, "evaluate wants two files: DISP.pfm TRUTH.pfm");
    }
    o->map = names[0];
    o->truth = names[1];
    return status;
}

static int same_size(const plft_map *a, int w, int h, const char *path,
                     const char *other)
{
    if (a->w == w && a->h == h) {
        return 0;
    }
    return plft_fail(PLFT_DATA, "%s is %dx%d but %s is %dx%d", path, a->w, a->h, other,
                     w, h);
}

static int read_like(plft_map *m, const char *path, const job *j)
{
    int status = path ? plft_pfm_read(m, path) : 0;

    if (status == 0 && path) {
        status = same_size(m, j->map.w, j->map.h, path, j->o.map);
    }
    return status;
}

static int read_mask(job *j)
{
    plft_frame frame = {NULL, 0, 0, 0, 0};
    size_t n = (size_t)j->map.w * (size_t)j->map.h;
    size_t i;
    int status = plft_frame_read(&frame, j->o.mask, 0);

    if (status == 0 && (frame.w != j->map.w || frame.h != j->map.h)) {
        status = plft_fail(PLFT_DATA, "%s is %dx%d but %s is %dx%d", j->o.mask, frame.w,
                           frame.h, j->o.map, j->map.w, j->map.h);
    }
    j->mask = status == 0 ? plft_alloc(n, 1) : NULL;
    if (j->mask != NULL) {
        plft_frame_to_grey(&frame);
        for (i = 0; i < n; i++) {
            j->mask[i] = frame.px[i] != 0;
        }
    } else if (status == 0) {
        status = PLFT_DATA;
    }
    plft_frame_free(&frame);
    return status;
}

static int load(job *j)
{
    int status = plft_pfm_read(&j->map, j->o.map);

    if (status == 0) {
        status = read_like(&j->truth, j->o.truth, j);
    }
    if (status == 0) {
        status = read_like(&j->confidence, j->o.confidence, j);
    }
    if (status == 0) {
        status = read_like(&j->sigma, j->o.sigma, j);
    }
    if (status == 0 && j->o.mask) {
        status = read_mask(j);
    }
    return status;
}

static int states_none(const float *sigma, const uint8_t *use, size_t n)
{
    size_t i;

    for (i = 0; i < n; i++) {
        if (use[i] && isfinite(sigma[i])) {
            return 0;
        }
    }
    return 1;
}

/* Trust by standard error: its negative. */
static int sparsify_by_sigma(job *j, size_t n)
{
    float *trust = plft_alloc(n, sizeof *trust);
    int status = trust == NULL ? PLFT_DATA : 0;
    size_t i;

    if (status == 0) {
        for (i = 0; i < n; i++) {
            trust[i] = -j->sigma.v[i];
        }
        status =
            plft_sparsify(j->error, j->use, trust, n, plft_thresholds[0], j->by_sigma);
        j->ratio = plft_scatter_ratio(j->error, j->use, j->sigma.v, n);
    }
    free(trust);
    return status;
}

static int judge(job *j)
{
    size_t n = (size_t)j->map.w * (size_t)j->map.h;
    int status;

    j->error = plft_alloc(n, sizeof *j->error);
    j->use = plft_alloc(n, 1);
    if (j->error == NULL || j->use == NULL) {
        return PLFT_DATA;
    }
    plft_errors(j->map.v, j->truth.v, j->mask, j->map.w, j->map.h, j->o.border,
                j->error, j->use, &j->f.untrue);
    status = plft_figures_of(j->error, j->use, n, &j->f);
    if (status == 0 && j->o.confidence) {
        status = plft_sparsify(j->error, j->use, j->confidence.v, n, plft_thresholds[0],
                               j->by_confidence);
    }
    if (status == 0 && j->o.sigma && states_none(j->sigma.v, j->use, n)) {
        return plft_fail(PLFT_DATA,
                         "%s: no standard error in it; not every method gives one",
                         j->o.sigma);
    }
    if (status == 0 && j->o.sigma) {
        status = sparsify_by_sigma(j, n);
    }
    return status;
}

/* Errors from -0.1 to 0.1; left-out pixels are grey. */
static int draw(const job *j)
{
    size_t n = (size_t)j->map.w * (size_t)j->map.h;
    float *v = plft_alloc(n, sizeof *v);
    int status;
    size_t i;

    if (v == NULL) {
        return PLFT_DATA;
    }
    for (i = 0; i < n; i++) {
        v[i] = j->use[i] ? j->error[i] : NAN;
    }
    status =
        plft_colour_png(j->o.errors, v, j->map.w, j->map.h, -0.1f, 0.1f, 0, "error");
    free(v);
    return status;
}

static json_t *curve_json(const double *curve)
{
    json_t *list = json_array();
    int k;

    for (k = 0; k < PLFT_CURVE; k++) {
        json_array_append_new(list, json_real(curve[k]));
    }
    return list;
}

static int print_json(const job *j)
{
    json_t *root = json_object();
    int status;

    json_object_set_new(root, "pixels", json_integer((json_int_t)j->f.pixels));
    json_object_set_new(root, "missing", json_integer((json_int_t)j->f.missing));
    json_object_set_new(root, "truth_missing", json_integer((json_int_t)j->f.untrue));
    json_object_set_new(root, "badpix_0.07", json_real(j->f.badpix[0]));
    json_object_set_new(root, "badpix_0.03", json_real(j->f.badpix[1]));
    json_object_set_new(root, "badpix_0.01", json_real(j->f.badpix[2]));
    json_object_set_new(root, "mse_x100", json_real(j->f.mse100));
    json_object_set_new(root, "q25_x100", json_real(j->f.q25_100));
    json_object_set_new(root, "median_x100", json_real(j->f.median100));
    json_object_set_new(root, "bias", json_real(j->f.bias));
    if (j->o.confidence) {
        json_object_set_new(root, "kept_by_confidence", curve_json(j->by_confidence));
    }
    if (j->o.sigma) {
        json_object_set_new(root, "kept_by_sigma", curve_json(j->by_sigma));
        json_object_set_new(root, "scatter_over_sigma", json_real(j->ratio));
    }
    status = plft_json_print(root);
    json_decref(root);
    return status;
}

static void print_curve(const char *name, const double *curve)
{
    int k;

    printf("kept by %-11s", name);
    for (k = 0; k < PLFT_CURVE; k++) {
        printf(" %d%%:%.2f", 100 - 10 * k, curve[k]);
    }
    printf("\n");
}

static int print_text(const job *j)
{
    int k;

    printf("pixels            %zu, not measured %zu, without truth %zu\n", j->f.pixels,
           j->f.missing, j->f.untrue);
    for (k = 0; k < PLFT_BADPIX; k++) {
        printf("BadPix(%.2f)      %.3f %%\n", plft_thresholds[k], j->f.badpix[k]);
    }
    printf("MSE x 100         %.4f\nQ25 x 100         %.4f\nmedian x 100      %.4f\n"
           "bias              %+.5f\n",
           j->f.mse100, j->f.q25_100, j->f.median100, j->f.bias);
    if (j->o.confidence) {
        print_curve("confidence", j->by_confidence);
    }
    if (j->o.sigma) {
        print_curve("sigma", j->by_sigma);
        printf("scatter / sigma   %.3f\n", j->ratio);
    }
    return 0;
}

int plft_cmd_evaluate(int argc, char **argv)
{
    job j;
    int helped = 0;
    int status;

    memset(&j, 0, sizeof j);
    j.o.border = 15;
    status = parse(argc, argv, &j.o, &helped);
    if (status == 0 && !helped) {
        status = load(&j);
        if (status == 0) {
            status = judge(&j);
        }
        if (status == 0 && j.o.errors) {
            status = draw(&j);
        }
        if (status == 0) {
            status = j.o.json ? print_json(&j) : print_text(&j);
        }
    }
    plft_map_free(&j.map);
    plft_map_free(&j.truth);
    plft_map_free(&j.confidence);
    plft_map_free(&j.sigma);
    free(j.mask);
    free(j.use);
    free(j.error);
    return status;
}
