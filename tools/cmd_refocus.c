/* SPDX-License-Identifier: MIT
 * refocus: the picture that a camera focused on a slope would have taken. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "common/args.h"
#include "common/arrange.h"
#include "common/err.h"
#include "common/match.h"
#include "common/memory.h"
#include "common/out.h"
#include "common/square.h"
#include "plenofix/refocus.h"

#define NO_SLOPE 1e9

typedef struct request {
    plft_source source;
    const char *out;
    double slope, radius;
} request;

/* As many views as a plan takes, spread evenly over those of the lens. */
static int choose(const plft_field *field, const request *r, plfx_cfg *cfg)
{
    plfx_offset *all = NULL;
    int n = 0, k, take;
    int rc = plft_arrange_all(field, r->radius, &all, &n);

    if (rc == 0) {
        take = n < PLFX_VIEWS_MAX ? n : PLFX_VIEWS_MAX;
        for (k = 0; k < take; k++) {
            cfg->at[k] = all[(long)k * n / take];
        }
        cfg->n = (uint8_t)take;
        rc = take >= 2
                 ? 0
                 : plft_fail(PLFT_USAGE, "--radius %g: holds one view only", r->radius);
    }
    free(all);
    return rc;
}

/* Pairs, since a summed cost of so many views would not fit: labels are not used. */
static void fill_cfg(const plft_field *field, double slope, plfx_cfg *cfg)
{
    double s = slope / field->scale;

    cfg->method = PLFX_METHOD_PAIRS;
    cfg->cost = PLFX_COST_SAD;
    cfg->window = PLFX_WINDOW_MIN;
    cfg->bits = (uint8_t)field->bits;
    cfg->labels = PLFX_LABELS_MIN;
    cfg->slope_min_q16 =
        (int32_t)lround(fmin(s - 1.0 / 256.0, 8.0 - 1.0 / 128.0) * 65536.0);
    cfg->slope_min_q16 = cfg->slope_min_q16 < -524288 ? -524288 : cfg->slope_min_q16;
    cfg->slope_max_q16 = cfg->slope_min_q16 + 512;
}

static int write_picture(const plft_field *field, const uint16_t *px, const char *path)
{
    plft_square sq;
    plft_frame f;
    int rc = plft_square_init(&sq, field->lut != NULL ? &field->lut->lattice : NULL,
                              field->nx, field->ny);

    if (rc != 0) {
        return rc;
    }
    rc = plft_frame_alloc(&f, (unsigned long)sq.w, (unsigned long)sq.h, 1, path);
    if (rc == 0) {
        plft_square_view(&sq, px, field->nx, f.px);
        f.bits = field->bits;
        rc = plft_png_write(path, &f);
        plft_frame_free(&f);
    }
    plft_square_free(&sq);
    return rc;
}

static int refocus(const plft_field *field, const plfx_plan *plan, double slope,
                   const char *path)
{
    plfx_views views;
    plfx_image image;
    int rc = plft_field_views(field, plan->cfg.at, plan->cfg.n, &views);

    if (rc != 0) {
        return rc;
    }
    image.w = image.stride = field->nx;
    image.h = field->ny;
    image.px =
        (uint16_t *)plft_alloc((size_t)image.w * (size_t)image.h, sizeof *image.px);
    rc = image.px == NULL ? PLFT_DATA : 0;
    if (rc == 0 &&
        plfx_refocus(plan, &views, (int32_t)lround(slope / field->scale * 65536.0),
                     &image) != PLFX_OK) {
        rc = plft_fail(PLFT_USAGE, "--slope %g: out of range, -8 to 8", slope);
    }
    rc = rc != 0 ? rc : write_picture(field, image.px, path);
    free(image.px);
    free(views.px);
    return rc;
}

static int run(const request *r)
{
    plft_field field;
    plfx_cfg cfg;
    plfx_plan plan;
    int rc = plft_field_open(&field, &r->source);

    if (rc != 0) {
        return rc;
    }
    memset(&cfg, 0, sizeof cfg);
    plft_field_rescale(&field, fabs(r->slope));
    rc = choose(&field, r, &cfg);
    fill_cfg(&field, r->slope, &cfg);
    rc = rc != 0 ? rc : plft_plan(&plan, &cfg, &field);
    rc = rc != 0 ? rc : refocus(&field, &plan, r->slope, r->out);
    if (rc == 0) {
        printf("%s: %d views at slope %g\n", r->out, cfg.n, r->slope);
    }
    plft_field_free(&field);
    return rc;
}

static const plft_usage usage = {
    "refocus", "RAW --lut CAM.plut --slope S -o R.png [options]",
    "Shift and sum of all views: sharp where the slope is S, soft elsewhere.  Square\n"
    "pixels of one lens pitch."};

int plft_cmd_refocus(int argc, char **argv)
{
    request r;
    const char *operand[1] = {NULL};
    int n, helped, rc;
    const plft_option own[] = {
        {"-o", PLFT_TEXT, &r.out, "R.png", 0, 0, "the picture"},
        {"--slope", PLFT_REAL, &r.slope, "S", -28, 28, "what shall be sharp"},
        {"--radius", PLFT_REAL, &r.radius, "R", 0.1, 127,
         "of the outermost views, pixels; the table's"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    plft_option options[PLFT_OPTIONS_MAX];

    memset(&r, 0, sizeof r);
    plft_source_options(options, own, &r.source, 1);
    r.slope = NO_SLOPE;
    rc = plft_args(argc, argv, &usage, options, operand, 1, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    r.source.raw = operand[0];
    if (r.out == NULL) {
        return plft_fail(PLFT_USAGE, "want -o R.png");
    }
    if (r.slope >= NO_SLOPE) {
        return plft_fail(PLFT_USAGE, "want --slope S");
    }
    rc = plft_out_check(r.out);
    return rc != 0 ? rc : run(&r);
}
