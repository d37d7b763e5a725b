/* SPDX-License-Identifier: MIT
 * plan: field, noise, memory, work and data rate of a camera that is not built yet. */
#include <stdio.h>
#include <stdlib.h>

#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/json.h"
#include "motion/plan.h"
#include "plenofix/packet.h"
#include "plenofix/roi.h"

typedef struct request {
    plft_plan_camera c;
    plft_plan_use u;
    const char *optics, *lenses, *region;
    int json;
} request;

/* "96x20" */
static int parse_pair(const char *text, const char *option, int lo, int hi, int *a,
                      int *b)
{
    char *end;
    long x = strtol(text, &end, 10);
    long y = end != text && *end == 'x' ? strtol(end + 1, &end, 10) : 0;

    if (*end != '\0' || x < lo || x > hi || y < lo || y > hi) {
        return plft_fail(PLFT_USAGE, "%s %s: want COLUMNSxROWS, each %d to %d", option,
                         text, lo, hi);
    }
    *a = (int)x;
    *b = (int)y;
    return 0;
}

static int read_optics(plft_plan_camera *c, const char *path)
{
    json_t *root;
    int rc = plft_json_read(&root, path);

    if (rc != 0) {
        return rc;
    }
    rc = plft_json_real(root, "F_mm", 1, 5000, 1, &c->F, path) ||
                 plft_json_real(root, "focus_mm", 2, 1e7, 1, &c->focus, path) ||
                 plft_json_real(root, "f_mu_mm", 0.01, 100, 1, &c->f_mu, path) ||
                 plft_json_real(root, "pixel_mm", 5e-4, 0.1, 1, &c->pixel, path) ||
                 plft_json_real(root, "pitch_mm", 0.005, 10, 1, &c->pitch, path)
             ? PLFT_DATA
             : 0;
    json_decref(root);
    return rc;
}

static void print_view(const plft_plan_result *p, const request *r)
{
    double n = r->c.f_number > 0 ? r->c.f_number : p->matched;

    printf("sensor      %d x %d pixels, %d x %d lenses of %.3f pixels, micro-images of "
           "%.2f\n",
           p->sensor_w, p->sensor_h, r->c.nx, r->c.ny, p->pitch_px, p->spot_px);
    printf("optics      F %g mm focused at %g mm, array %.3f mm behind, f/%.3g; lenses "
           "f/%.3g\n",
           r->c.F, r->c.focus, p->L, n, p->matched);
    printf("field       %.4g x %.4g mm, a lens spans %.4g mm\n", p->w_mm, p->h_mm,
           p->lens_mm);
    printf("views       %d out to %.3g pixels, %.0f %% of the pupil\n", r->u.views,
           p->radius, 100.0 * p->kappa);
}

static void print_noise(const plft_plan_result *p, const request *r)
{
    printf("regions     %d of %d x %d lenses, %.3g x %.3g mm\n", r->u.regions, r->u.w,
           r->u.h, r->u.w * p->lens_mm, r->u.h * p->lens_mm);
    printf("sigma u, v  %.3g mm (%.3g lens), 1/%.0f of the field\n", p->sigma_u_mm,
           p->sigma_lens, p->w_mm / p->sigma_u_mm);
    printf(
        "sigma w     %.3g mm (%.3g of slope, %.3g lens between the end views), 1/%.0f "
        "of the field\n",
        p->sigma_w_mm, p->sigma_slope, p->delta, p->w_mm / p->sigma_w_mm);
    printf(
        "            a region and frame at rest, texture %g a lens, %.0f electrons\n",
        r->u.texture, r->u.light * r->c.full_well);
    printf("scale       --mm-per-lens %.6g --mm-per-slope %.6g; w to +-%.3g mm\n",
           p->lens_mm, p->mm_slope, p->reach_mm);
}

static void print_cost(const plft_plan_result *p, const request *r)
{
    printf("memory      regions %zu bytes, state %zu, trackers %zu; lens table %zu "
           "(%zu with a correction a lens)\n",
           p->workspace, p->state, p->trackers, p->table,
           p->table + 4u * (size_t)r->c.nx * (size_t)r->c.ny);
    printf("work        %.0f multiply-adds a frame, %.1f million a second\n",
           p->frame_ops, p->ops / 1e6);
    printf("data        raw %.4g Mbit/s; records of all regions %.1f kbit/s\n",
           p->raw_bits / 1e6, p->wide_bits / 1e3);
    printf("link        %.1f kbit/s carry %d regions every %d frames with %d modes: "
           "%.1f kbit/s\n",
           r->u.link / 1e3, p->thin_regions, p->thin_every, r->u.modes,
           p->thin_bits / 1e3);
}

static void warn_of(const plft_plan_result *p)
{
    if (p->spot_px > 1.02 * p->pitch_px) {
        plft_warn("micro-images overlap: their edges mix neighbours; stop down to "
                  "f/%.3g",
                  p->matched);
    }
    if (p->spot_px < 0.7 * p->pitch_px) {
        plft_warn("the lenses use %.0f %% of their width: open the main lens to f/%.3g",
                  100.0 * p->spot_px / p->pitch_px, p->matched);
    }
}

static int print_json(const plft_plan_result *p, const request *r)
{
    json_t *root = json_pack(
        "{s:[i,i],s:[i,i],s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f}",
        "sensor_px", p->sensor_w, p->sensor_h, "lenses", r->c.nx, r->c.ny, "pitch_px",
        p->pitch_px, "micro_image_px", p->spot_px, "array_mm", p->L, "field_w_mm",
        p->w_mm, "field_h_mm", p->h_mm, "lens_mm", p->lens_mm, "radius_px", p->radius,
        "pupil_used", p->kappa, "sigma_u_lens", p->sigma_lens, "sigma_u_mm",
        p->sigma_u_mm, "sigma_slope", p->sigma_slope, "sigma_delta_lens", p->delta,
        "sigma_w_mm", p->sigma_w_mm, "mm_per_slope", p->mm_slope);
    json_t *cost =
        json_pack("{s:f,s:I,s:I,s:I,s:I,s:f,s:f,s:f,s:f,s:f,s:i,s:i}", "reach_w_mm",
                  p->reach_mm, "table_bytes", (json_int_t)p->table, "workspace_bytes",
                  (json_int_t)p->workspace, "state_bytes", (json_int_t)p->state,
                  "tracker_bytes", (json_int_t)p->trackers, "multiply_adds_frame",
                  p->frame_ops, "multiply_adds_s", p->ops, "raw_bit_s", p->raw_bits,
                  "records_bit_s", p->wide_bits, "link_used_bit_s", p->thin_bits,
                  "link_regions", p->thin_regions, "link_every", p->thin_every);
    int rc = root == NULL || cost == NULL || json_object_update(root, cost) != 0
                 ? plft_fail(PLFT_DATA, "out of memory")
                 : plft_json_print(root);

    json_decref(cost);
    json_decref(root);
    return rc;
}

static const plft_usage usage = {
    "plan", "(--optics O.json | --focal F --focus D ...) --lenses CxR [options]",
    "What a camera would see before it is built: field, standard errors of a region's\n"
    "displacement, memory, work, data rate.  Lengths in mm."};

static int parse(int argc, char **argv, request *r, int *helped)
{
    plft_plan_camera *c = &r->c;
    plft_plan_use *u = &r->u;
    const plft_option options[] = {
        {"--optics", PLFT_TEXT, &r->optics, "O.json", 0, 0,
         "F_mm, focus_mm, f_mu_mm, pixel_mm, pitch_mm"},
        {"--focal", PLFT_REAL, &c->F, "F", 1, 5000, "focal length of the main lens"},
        {"--focus", PLFT_REAL, &c->focus, "D", 2, 1e7,
         "distance of the plane in focus"},
        {"--lens-focal", PLFT_REAL, &c->f_mu, "X", 0.01, 100,
         "focal length of the small lenses (0.5)"},
        {"--lens-pitch", PLFT_REAL, &c->pitch, "X", 0.005, 10, "their pitch (0.125)"},
        {"--pixel", PLFT_REAL, &c->pixel, "X", 5e-4, 0.1, "pixel (0.0074)"},
        {"--lenses", PLFT_TEXT, &r->lenses, "CxR", 0, 0, "columns and rows of lenses"},
        {"--f-number", PLFT_REAL, &c->f_number, "N", 0.5, 200,
         "of the main lens, L over pupil (that of the small lenses)"},
        {"--rate", PLFT_REAL, &c->rate, "HZ", 1, 8000, "frames a second (200)"},
        {"--bits", PLFT_INT, &c->bits, "N", 8, 16, "a pixel (12)"},
        {"--full-well", PLFT_REAL, &c->full_well, "E", 100, 1e7, "electrons (30000)"},
        {"--read-noise", PLFT_REAL, &c->read_noise, "E", 0, 1e4, "electrons (16)"},
        {"--light", PLFT_REAL, &u->light, "P", 0.01, 1,
         "mean brightness, part of the full well (0.4)"},
        {"--texture", PLFT_REAL, &u->texture, "G", 0.001, 2,
         "rms gradient a lens, part of the brightness; select-rois tells it (0.27)"},
        {"--regions", PLFT_INT, &u->regions, "N", 1, PLFX_ROI_MAX, "regions (24)"},
        {"--region", PLFT_TEXT, &r->region, "CxR", 0, 0, "lenses of a region (7x9)"},
        {"--views", PLFT_INT, &u->views, "N", 5, 97, "centre and cross of views (25)"},
        {"--radius", PLFT_REAL, &u->radius, "R", 1, 127,
         "of the cross, pixels (3 less than half a lens)"},
        {"--rest", PLFT_INT, &u->rest, "N", 1, PLFX_ROI_REST_MAX,
         "frames of the rest state (8)"},
        {"--modes", PLFT_INT, &u->modes, "N", 0, 8, "tracked in each region (3)"},
        {"--link", PLFT_INT, &u->link, "BITS", 100, 1e9, "telemetry, bit/s (57600)"},
        {"--json", PLFT_FLAG, &r->json, NULL, 0, 0, "print JSON"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    const char *none[1];
    int n;
    int rc = plft_args(argc, argv, &usage, options, none, 0, &n, helped);

    return rc;
}

/* The file first, so that options change single numbers of it. */
static int resolve(int argc, char **argv, request *r, int *helped)
{
    request named = *r;
    int rc = parse(argc, argv, &named, helped);

    if (rc != 0 || *helped) {
        return rc;
    }
    if (named.optics != NULL) {
        rc = read_optics(&r->c, named.optics);
        rc = rc ? rc : parse(argc, argv, r, helped);
    } else {
        *r = named;
    }
    if (rc == 0 && (r->c.F <= 0 || r->c.focus <= 0)) {
        rc =
            plft_fail(PLFT_USAGE, "plan: want --optics O.json, or --focal and --focus");
    }
    if (rc != 0) {
        return rc;
    }
    if (r->lenses == NULL) {
        return plft_fail(PLFT_USAGE, "plan: want --lenses COLUMNSxROWS");
    }
    rc = parse_pair(r->lenses, "--lenses", 2, 4096, &r->c.nx, &r->c.ny);
    if (rc == 0 && r->region != NULL) {
        rc = parse_pair(r->region, "--region", 3, 2 * PLFX_ROI_HALF_MAX + 1, &r->u.w,
                        &r->u.h);
    }
    return rc;
}

int plft_cmd_plan(int argc, char **argv)
{
    request r = {{0, 0, 0.5, 0.125, 0.0074, 0, 0, 0, 200, 12, 30000, 16},
                 {0, 25, 24, 7, 9, 8, 3, 0.4, 0.27, 57600},
                 NULL,
                 NULL,
                 NULL,
                 0};
    plft_plan_result p;
    int helped = 0;
    int rc = resolve(argc, argv, &r, &helped);

    if (rc != 0 || helped) {
        return rc;
    }
    rc = plft_plan_make(&p, &r.c, &r.u);
    if (rc != 0) {
        return rc;
    }
    warn_of(&p);
    if (r.json) {
        return print_json(&p, &r);
    }
    print_view(&p, &r);
    print_noise(&p, &r);
    print_cost(&p, &r);
    return 0;
}
