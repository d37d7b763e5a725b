/* SPDX-License-Identifier: MIT */
#include "motion/plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/frame.h"
#include "common/memory.h"
#include "common/table.h"
#include "plenofix/modal.h"
#include "plenofix/packet.h"
#include "plenofix/roi.h"

#define BILINEAR (4.0 / 9.0) /* variance of a bilinear sample, mean over its places */

void plft_plan_cross(double (*at)[2], int views, double radius)
{
    int arm = (views - 1) / 4;
    int k;

    memset(at, 0, (size_t)views * sizeof *at);
    for (k = 1; k <= arm; k++) {
        double d = radius * k / arm;
        at[4 * k - 3][0] = d;
        at[4 * k - 2][0] = -d;
        at[4 * k - 1][1] = d;
        at[4 * k][1] = -d;
    }
}

/* ---- geometry ---- */

static int shape_ok(const plft_plan_result *p, const plft_plan_camera *c)
{
    if (!(c->focus > 1.02 * c->F)) {
        return plft_fail(PLFT_USAGE,
                         "plan: the plane in focus at %g mm must lie beyond the focal "
                         "length %g mm",
                         c->focus, c->F);
    }
    if (!(p->pitch_px >= 4.0 && p->pitch_px <= 100.0)) {
        return plft_fail(PLFT_USAGE,
                         "plan: a lens of %g mm over pixels of %g mm is %.3g pixels "
                         "wide: want 4 to 100",
                         c->pitch, c->pixel, p->pitch_px);
    }
    if (p->spot_px > 1.3 * p->pitch_px || p->spot_px < 0.2 * p->pitch_px) {
        return plft_fail(
            PLFT_USAGE,
            "plan: at f/%.3g a micro-image of %.3g pixels stands in a lens "
            "of %.3g: want an f-number near f_mu/pitch = %.3g",
            c->f_number > 0 ? c->f_number : p->matched, p->spot_px, p->pitch_px,
            p->matched);
    }
    if (c->nx * p->pitch_px > PLFT_SIDE_MAX || c->ny * p->pitch_px > PLFT_SIDE_MAX) {
        return plft_fail(PLFT_USAGE,
                         "plan: %d x %d lenses of %.3g pixels: a sensor of over %d "
                         "pixels on a side",
                         c->nx, c->ny, p->pitch_px, PLFT_SIDE_MAX);
    }
    return 0;
}

static int geometry(plft_plan_result *p, const plft_plan_camera *c, double radius)
{
    double n;
    int rc;

    p->L = 1.0 / (1.0 / c->F - 1.0 / c->focus);
    p->matched = c->f_mu / c->pitch;
    n = c->f_number > 0 ? c->f_number : p->matched;
    p->pitch_px = c->pitch * (1.0 + c->f_mu / p->L) / c->pixel;
    p->spot_px = c->f_mu / (n * c->pixel);
    rc = shape_ok(p, c);
    if (rc != 0) {
        return rc;
    }
    p->radius = radius > 0 ? radius : plft_usable_radius(p->pitch_px) - 0.5;
    p->kappa = 2.0 * p->radius / p->spot_px;
    if (p->kappa > 1.0 || p->radius < 1.0) {
        return plft_fail(PLFT_USAGE,
                         "plan: views out to %.3g pixels: want 1 to %.3g, the radius "
                         "of a micro-image",
                         p->radius, 0.5 * p->spot_px);
    }
    p->sensor_w = (int)ceil(c->nx * p->pitch_px);
    p->sensor_h = (int)ceil(c->ny * p->pitch_px);
    p->lens_mm = c->pitch * c->focus / p->L;
    p->w_mm = c->nx * p->lens_mm;
    p->h_mm = c->ny * p->lens_mm;
    return 0;
}

/* ---- noise ---- */

/* Cubic B-spline of the offset, 1 at 0 and 0 from 2 pixels on. */
static double shared(double d)
{
    d = fabs(d);
    return d >= 2.0   ? 0.0
           : d >= 1.0 ? pow(2.0 - d, 3.0) / 4.0
                      : 1.0 - 1.5 * d * d + 0.75 * d * d * d;
}

/* Sums over views for a gradient alike along both axes: of the squared responses, and
 * of their products times the correlation of noise.  slope 0: in-plane along u. */
static void responses(const double (*at)[2], int views, int slope, double *square,
                      double *joint)
{
    int a, b;

    *square = 0.0;
    *joint = 0.0;
    for (a = 0; a < views; a++) {
        for (b = 0; b < views; b++) {
            double r = shared(at[a][0] - at[b][0]) * shared(at[a][1] - at[b][1]);
            double q = slope ? at[a][0] * at[b][0] + at[a][1] * at[b][1] : 1.0;
            *joint += r * q;
            *square += a == b ? q : 0.0;
        }
    }
}

static void noise(plft_plan_result *p, const plft_plan_camera *c,
                  const plft_plan_use *u)
{
    double e = u->light * c->full_well;
    double sample = BILINEAR * (e + c->read_noise * c->read_noise) / (e * e);
    double per = sample / (u->w * u->h * u->texture * u->texture);
    double at[PLFX_VIEWS_MAX][2];
    double square, joint;
    double n = c->f_number > 0 ? c->f_number : p->matched;
    double reduction = c->focus / p->L;

    plft_plan_cross(at, u->views, p->radius);
    responses((const double(*)[2])at, u->views, 0, &square, &joint);
    p->sigma_lens = sqrt(per * joint) / square;
    responses((const double(*)[2])at, u->views, 1, &square, &joint);
    p->sigma_slope = sqrt(per * joint) / square;
    p->sigma_u_mm = p->lens_mm * p->sigma_lens;
    p->delta = 2.0 * p->radius * p->sigma_slope;
    p->sigma_w_mm = c->pitch * n / p->kappa * reduction * reduction * p->delta;
    p->mm_slope = -p->sigma_w_mm / p->sigma_slope;
    p->reach_mm = 0.5 / p->radius * -p->mm_slope;
}

/* ---- memory, work, data ---- */

/* A table of nothing but the lattice, opened. */
static unsigned char *plain_table(plfx_lut *lut, const plft_plan_result *p,
                                  const plft_plan_camera *c, size_t *bytes)
{
    unsigned char *blob;
    plfx_lut_desc d;

    memset(&d, 0, sizeof d);
    d.sensor_w = p->sensor_w;
    d.sensor_h = p->sensor_h;
    d.sensor_bits = c->bits;
    d.lattice.kind = PLFX_LATTICE_SQUARE;
    d.lattice.nx = c->nx;
    d.lattice.ny = c->ny;
    d.lattice.origin.x_q16 = (int32_t)(p->pitch_px * 32768.0);
    d.lattice.origin.y_q16 = d.lattice.origin.x_q16;
    d.lattice.a.x_q22 = (int32_t)(p->pitch_px * 4194304.0);
    d.lattice.b.y_q22 = d.lattice.a.x_q22;
    d.radius_q8 = (int32_t)(256.0 * plft_usable_radius(p->pitch_px));
    *bytes = plfx_lut_bytes(&d);
    blob = plft_alloc(*bytes, 1);
    if (blob != NULL && (*bytes == 0 || plfx_lut_write(&d, blob, *bytes) != PLFX_OK ||
                         plfx_lut_open(lut, blob, *bytes) != PLFX_OK)) {
        free(blob);
        blob = NULL;
        (void)plft_fail(PLFT_USAGE, "plan: %d x %d lenses do not fit a lens table",
                        c->nx, c->ny);
    }
    return blob;
}

static int memory(plft_plan_result *p, const plft_plan_camera *c,
                  const plft_plan_use *u)
{
    plfx_roi_cfg *cfg = plft_alloc(1, sizeof *cfg);
    plfx_lut lut;
    unsigned char *blob = cfg != NULL ? plain_table(&lut, p, c, &p->table) : NULL;
    int k;

    if (blob == NULL) {
        free(cfg);
        return PLFT_USAGE;
    }
    cfg->lut = &lut;
    cfg->tone = plfx_tone_unity(12);
    cfg->views = u->views;
    cfg->regions = u->regions;
    cfg->rest = u->rest;
    cfg->steps = 2;
    cfg->residual_q8 = 640;
    for (k = 0; k < u->regions; k++) {
        cfg->region[k].hx = (uint8_t)(u->w / 2);
        cfg->region[k].hy = (uint8_t)(u->h / 2);
    }
    p->workspace = plfx_roi_ws(cfg);
    p->state = sizeof(plfx_roi) + (size_t)u->regions * sizeof(plfx_roi_result);
    p->trackers = (size_t)u->regions * (size_t)u->modes * sizeof(plfx_modal);
    free(blob);
    free(cfg);
    return p->workspace > 0 ? 0
                            : plft_fail(PLFT_USAGE, "plan: out of the core's range");
}

/* Multiply-adds as stated in roi.h and modal.h: 6 a sample, 5 a row of a view, 1450 a
 * solution; 2 a sample of a tracker (its thinned samples are few). */
static void work(plft_plan_result *p, const plft_plan_camera *c, const plft_plan_use *u)
{
    p->frame_ops =
        u->regions * ((6.0 * u->w + 5.0) * u->h * u->views + 1450.0 + 2.0 * u->modes);
    p->ops = p->frame_ops * c->rate;
}

static int data(plft_plan_result *p, const plft_plan_camera *c, const plft_plan_use *u)
{
    uint32_t rate_mhz = (uint32_t)lround(1000.0 * c->rate);
    plfx_packet_rate fit;

    p->raw_bits = (double)p->sensor_w * p->sensor_h * c->bits * c->rate;
    if (plfx_packet_fit(UINT32_MAX, rate_mhz, u->regions, u->modes, &fit) != PLFX_OK) {
        return plft_fail(PLFT_USAGE, "plan: no packet holds these regions and modes");
    }
    p->wide_bits = fit.bits_s;
    if (plfx_packet_fit((uint32_t)u->link, rate_mhz, u->regions, u->modes, &fit) !=
        PLFX_OK) {
        return plft_fail(PLFT_USAGE, "plan: --link %d carries not one region", u->link);
    }
    p->thin_bits = fit.bits_s;
    p->thin_every = fit.every;
    p->thin_regions = fit.count;
    return 0;
}

static int use_ok(const plft_plan_camera *c, const plft_plan_use *u)
{
    int w = u->w + 2 * PLFX_ROI_MARGIN;
    int h = u->h + 2 * PLFX_ROI_MARGIN;

    if (u->w % 2 == 0 || u->h % 2 == 0) {
        return plft_fail(PLFT_USAGE, "plan: regions of %d x %d lenses: want odd sides",
                         u->w, u->h);
    }
    if (w > c->nx || h > c->ny) {
        return plft_fail(
            PLFT_USAGE,
            "plan: a region of %d x %d lenses and its margin of %d want %d "
            "x %d lenses; the array has %d x %d",
            u->w, u->h, PLFX_ROI_MARGIN, w, h, c->nx, c->ny);
    }
    if ((double)u->regions * u->w * u->h > (double)c->nx * c->ny) {
        return plft_fail(PLFT_USAGE,
                         "plan: %d regions of %d x %d lenses on %d x %d lenses overlap",
                         u->regions, u->w, u->h, c->nx, c->ny);
    }
    if (u->views % 4 != 1) {
        return plft_fail(PLFT_USAGE, "plan: --views %d: want 5, 9, 13, ...", u->views);
    }
    return 0;
}

int plft_plan_make(plft_plan_result *p, const plft_plan_camera *c,
                   const plft_plan_use *u)
{
    int rc;

    memset(p, 0, sizeof *p);
    rc = geometry(p, c, u->radius);
    rc = rc ? rc : use_ok(c, u);
    rc = rc ? rc : memory(p, c, u);
    if (rc == 0) {
        noise(p, c, u);
        work(p, c, u);
        rc = data(p, c, u);
    }
    return rc;
}
