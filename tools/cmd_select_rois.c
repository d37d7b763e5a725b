/* SPDX-License-Identifier: MIT
 * select-rois: regions with enough texture, for monitor. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "common/colour.h"
#include "common/err.h"
#include "common/json.h"
#include "common/memory.h"
#include "common/out.h"
#include "motion/pick.h"
#include "sim/rng.h"

#define COPIES 8  /* of a single frame, each with the camera's noise */
#define ROUNDS 16 /* of choosing */

typedef struct request {
    plft_source source;
    const char *out, *png, *region, *reference;
    plft_pick_wish wish;
    double sigma, radius, full_well, read_noise;
    int views, json;
    int ref[4]; /* first and last column, first and last row; -1: none */
} request;

typedef struct job {
    request r;
    plft_field field;
    plft_frame frame[PLFX_ROI_REST_MAX]; /* raw counts */
    plfx_raw raw[PLFX_ROI_REST_MAX];
    int frames;
    plft_pick pick[PLFX_ROI_MAX];
    int n, noisy; /* kept; given up for their standard error or the core's flags */
    plft_pick_places places;
} job;

/* ---- frames ---- */

static int read_frame(const job *j, const char *path, plft_frame *f)
{
    const plfx_lut *lut = &j->field.table.lut;
    int rc = plft_frame_read(f, path, j->r.source.bits);

    if (rc == 0) {
        plft_frame_to_grey(f);
        if (f->w != lut->sensor_w || f->h != lut->sensor_h) {
            rc = plft_fail(PLFT_DATA, "%s: %d x %d where the table %s is for %d x %d",
                           path, f->w, f->h, j->r.source.lut, lut->sensor_w,
                           lut->sensor_h);
            plft_frame_free(f);
        }
    }
    return rc;
}

/* Shot and read noise beside what the frame itself has. */
static void add_noise(const job *j, const plft_frame *from, plft_frame *to,
                      uint64_t stream)
{
    size_t n = (size_t)from->w * (size_t)from->h, k;
    double top = (double)((1 << from->bits) - 1);
    double e = j->r.full_well / top;

    for (k = 0; k < n; k++) {
        double noise =
            sqrt(from->px[k] / e + j->r.read_noise * j->r.read_noise / e / e);
        double v = from->px[k] + noise * plft_gauss(plft_key(1, stream, k));
        v = floor(v + 0.5);
        /* A clipped sample stays clipped. */
        to->px[k] = (uint16_t)(from->px[k] >= top || v > top ? top : v < 0 ? 0 : v);
    }
}

static int make_copies(job *j)
{
    int rc = 0;

    for (; rc == 0 && j->frames < COPIES; j->frames++) {
        plft_frame *to = &j->frame[j->frames];
        rc = plft_frame_alloc(to, (unsigned long)j->frame[0].w,
                              (unsigned long)j->frame[0].h, 1, "the frame");
        if (rc == 0) {
            to->bits = j->frame[0].bits;
            add_noise(j, &j->frame[0], to, (uint64_t)j->frames);
        }
    }
    if (rc == 0) { /* from its copies the first would differ by less */
        plft_frame spare = j->frame[0];
        add_noise(j, &spare, &j->frame[0], COPIES);
    }
    return rc;
}

static int read_frames(job *j, const char **path, int n)
{
    int rc = 0, k;

    for (; rc == 0 && j->frames < n; j->frames++) {
        rc = read_frame(j, path[j->frames], &j->frame[j->frames]);
        if (rc != 0) {
            return rc;
        }
    }
    rc = n == 1 ? make_copies(j) : 0;
    for (k = 0; k < j->frames; k++) {
        const plft_frame *f = &j->frame[k];
        j->raw[k].bytes = (const uint8_t *)f->px;
        j->raw[k].size = (size_t)f->w * (size_t)f->h * 2u;
        j->raw[k].format = PLFX_RAW_U16;
        j->raw[k].bits = (uint8_t)f->bits;
        j->raw[k].w = f->w;
        j->raw[k].h = f->h;
    }
    return rc;
}

/* ---- choice ---- */

static int reference(const job *j, const plft_pick *p)
{
    const int *r = j->r.ref;

    return p->i >= r[0] && p->j >= r[1] && p->i <= r[2] && p->j <= r[3];
}

static int is_good(const job *j, const plft_pick *p)
{
    return p->flags == 0 && p->sigma[0] <= j->r.sigma && p->sigma[1] <= j->r.sigma;
}

/* Keep what the core calls good; the number of the others, whose places are given
 * up. */
static int keep_good(job *j)
{
    int n = 0, bad, k;

    for (k = 0; k < j->n; k++) {
        if (is_good(j, &j->pick[k])) {
            j->pick[n++] = j->pick[k];
        } else {
            plft_pick_avoid(&j->places, &j->r.wish, &j->pick[k]);
        }
    }
    bad = j->n - n;
    j->noisy += bad;
    j->n = n;
    return bad;
}

static const char *advice(const job *j)
{
    if (j->noisy > 0) {
        return "raise --sigma, or keep several frames still";
    }
    return j->places.why.flat >= j->places.why.edge
               ? "put speckle on the surface, light it, or lower --texture"
               : "make --region smaller";
}

/* Why there is none. */
static int no_region(const job *j)
{
    const plft_pick_why *w = &j->places.why;
    const char *raw = j->r.source.raw;

    if (w->all == 0) {
        return plft_fail(PLFT_DATA,
                         "%s: no region: %d x %d lenses hold none of %d x %d with its "
                         "margin of %d; make --region smaller",
                         raw, j->field.nx, j->field.ny, j->r.wish.w, j->r.wish.h,
                         PLFX_ROI_MARGIN);
    }
    return plft_fail(PLFT_DATA,
                     "%s: no region: of %d places %d have a gradient under %g a lens "
                     "along some direction, %d lie across an edge in depth, %d on bad "
                     "lenses, %d are noisier than %g lens: %s",
                     raw, w->all, w->flat, j->r.wish.texture, w->edge, w->lens,
                     j->noisy, j->r.sigma, advice(j));
}

/* Choose anew without the places at which the core finds fault. */
static int choose(job *j, const char **path, int frames)
{
    double radius = j->r.radius > 0 ? j->r.radius : j->field.radius - 0.5;
    int rc = plft_pick_find(&j->field, &j->r.wish, &j->places);
    int bad = 1, round;

    rc = rc ? rc : read_frames(j, path, frames);
    for (round = 0; rc == 0 && bad > 0 && round < ROUNDS && j->places.n > 0; round++) {
        rc = plft_pick_choose(&j->places, &j->r.wish, j->pick, &j->n);
        rc = rc ? rc
                : plft_pick_check(&j->field.table.lut, j->raw, j->frames, j->r.views,
                                  fmax(radius, 1.0), &j->r.wish, j->pick, j->n);
        bad = rc ? 0 : keep_good(j);
    }
    return rc ? rc : j->n == 0 ? no_region(j) : 0;
}

/* ---- outputs ---- */

static int write_csv(const job *j)
{
    plft_out out = {NULL, NULL, NULL};
    int rc = plft_out_open(&out, j->r.out);
    int k;

    if (rc != 0) {
        return rc;
    }
    fprintf(out.file, "i,j,hx,hy,reference,texture,u_sigma_pitch,v_sigma_pitch,"
                      "w_sigma_slope,slope\n");
    for (k = 0; k < j->n; k++) {
        const plft_pick *p = &j->pick[k];
        fprintf(out.file, "%d,%d,%d,%d,%d,%.4f,%.3g,%.3g,%.3g,%.4f\n", p->i, p->j,
                j->r.wish.w / 2, j->r.wish.h / 2, reference(j, p), p->texture,
                p->sigma[0], p->sigma[1], p->sigma[2], p->slope);
    }
    return plft_out_commit(&out);
}

typedef struct canvas {
    uint8_t *rgb;
    int w, h, part; /* frame pixels a picture pixel */
} canvas;

static void grey_frame(const plft_frame *f, const canvas *c)
{
    double top = 1.0;
    size_t n = (size_t)f->w * (size_t)f->h, k;
    int x, y;

    for (k = 0; k < n; k++) {
        top = fmax(top, f->px[k]);
    }
    for (y = 0; y < c->h; y++) {
        for (x = 0; x < c->w; x++) {
            double v = f->px[(size_t)y * (size_t)c->part * (size_t)f->w +
                             (size_t)x * (size_t)c->part];
            memset(c->rgb + 3 * ((size_t)y * (size_t)c->w + (size_t)x),
                   (int)(255.0 * sqrt(v / top)), 3);
        }
    }
}

static void line(const canvas *c, double x0, double y0, double x1, double y1,
                 const uint8_t colour[3])
{
    int steps = (int)(fabs(x1 - x0) + fabs(y1 - y0)) + 1;
    int k, a;

    for (k = 0; k <= steps; k++) {
        for (a = 0; a < 4; a++) { /* two pixels wide */
            int x = (int)floor(x0 + (x1 - x0) * k / steps) + a % 2;
            int y = (int)floor(y0 + (y1 - y0) * k / steps) + a / 2;
            if (x >= 0 && y >= 0 && x < c->w && y < c->h) {
                memcpy(c->rgb + 3 * ((size_t)y * (size_t)c->w + (size_t)x), colour, 3);
            }
        }
    }
}

/* Corner (a, b) = +-1 of a region, picture pixels. */
static void corner(const job *j, const canvas *c, const plft_pick *p, int a, int b,
                   double xy[2])
{
    const plfx_lut *lut = &j->field.table.lut;
    plfx_point m = plfx_lut_centre(lut, p->i, p->j);
    double i = a * 0.5 * j->r.wish.w, k = b * 0.5 * j->r.wish.h;

    xy[0] = (m.x_q16 / 65536.0 +
             (i * lut->lattice.a.x_q22 + k * lut->lattice.b.x_q22) / 4194304.0) /
            c->part;
    xy[1] = (m.y_q16 / 65536.0 +
             (i * lut->lattice.a.y_q22 + k * lut->lattice.b.y_q22) / 4194304.0) /
            c->part;
}

static void draw_region(const job *j, const canvas *c, int k)
{
    static const uint8_t colours[2][3] = {{255, 220, 0}, {0, 230, 255}};
    static const int turn[5][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
    const plft_pick *p = &j->pick[k];
    const uint8_t *colour = colours[reference(j, p)];
    char text[16];
    double at[2], to[2];
    int s;

    corner(j, c, p, -1, -1, at);
    (void)snprintf(text, sizeof text, "%d", k);
    plft_text(c->rgb, c->w, c->h, (int)at[0] + 4, (int)at[1] + 4, text, colour);
    for (s = 1; s < 5; s++) {
        corner(j, c, p, turn[s][0], turn[s][1], to);
        line(c, at[0], at[1], to[0], to[1], colour);
        at[0] = to[0];
        at[1] = to[1];
    }
}

static int write_png(const job *j)
{
    const plft_frame *f = &j->field.frame;
    canvas c = {NULL, 0, 0, 1};
    int rc = PLFT_DATA;
    int k;

    c.part = (f->w + 2399) / 2400;
    c.w = f->w / c.part;
    c.h = f->h / c.part;
    c.rgb = plft_alloc(3 * (size_t)c.w * (size_t)c.h, 1);
    if (c.rgb != NULL) {
        grey_frame(f, &c);
        for (k = 0; k < j->n; k++) {
            draw_region(j, &c, k);
        }
        rc = plft_png_write_rgb8(j->r.png, c.rgb, c.w, c.h);
    }
    free(c.rgb);
    return rc;
}

static int print_json(const job *j)
{
    json_t *list = json_array();
    json_t *root;
    int rc, k;

    for (k = 0; k < j->n; k++) {
        const plft_pick *p = &j->pick[k];
        (void)json_array_append_new(
            list, json_pack("{s:i,s:i,s:i,s:i,s:b,s:f,s:[f,f],s:f,s:f}", "i", p->i, "j",
                            p->j, "hx", j->r.wish.w / 2, "hy", j->r.wish.h / 2,
                            "reference", reference(j, p), "texture", p->texture,
                            "uv_sigma_pitch", p->sigma[0], p->sigma[1], "w_sigma_slope",
                            p->sigma[2], "slope", p->slope));
    }
    root = json_pack("{s:s,s:i,s:o,s:{s:i,s:i,s:i,s:i,s:i,s:i}}", "output", j->r.out,
                     "frames", j->frames, "regions", list, "places", "all",
                     j->places.why.all, "flat", j->places.why.flat, "depth_edge",
                     j->places.why.edge, "bad_lenses", j->places.why.lens, "noisy",
                     j->noisy, "not_needed", j->places.n - j->n);
    rc = root ? plft_json_print(root) : plft_fail(PLFT_DATA, "out of memory");
    json_decref(root);
    return rc;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return x < y ? -1 : x > y;
}

static double median_of(const job *j, int what)
{
    double v[PLFX_ROI_MAX];
    int k;

    for (k = 0; k < j->n; k++) {
        v[k] = what < 3 ? j->pick[k].sigma[what] : j->pick[k].texture;
    }
    qsort(v, (size_t)j->n, sizeof *v, by_value);
    return v[j->n / 2];
}

static int report(const job *j, int named)
{
    if (j->n < j->r.wish.n) {
        plft_warn(
            "%d regions where %d were wanted: of %d places %d are too flat, %d lie "
            "across an edge in depth, %d on bad lenses, %d tried were too noisy",
            j->n, j->r.wish.n, j->places.why.all, j->places.why.flat,
            j->places.why.edge, j->places.why.lens, j->noisy);
    }
    if (j->r.json) {
        return print_json(j);
    }
    printf("%s: %d regions of %d x %d lenses, texture %.3g a lens, standard error "
           "(median) u %.3g v %.3g lens, w %.3g of slope%s\n",
           j->r.out, j->n, j->r.wish.w, j->r.wish.h, median_of(j, 3), median_of(j, 0),
           median_of(j, 1), median_of(j, 2),
           named == 1 ? ", for the noise of --full-well and --read-noise" : "");
    return 0;
}

static int run(job *j, const char **path, int n)
{
    int rc = plft_field_open(&j->field, &j->r.source);

    if (rc == 0 && j->field.table.lut.lattice.kind != PLFX_LATTICE_SQUARE) {
        rc = plft_fail(PLFT_DATA, "%s: regions want a square lattice", j->r.source.lut);
    }
    rc = rc ? rc : choose(j, path, n);
    rc = rc ? rc : write_csv(j);
    rc = rc || j->r.png == NULL ? rc : write_png(j);
    return rc ? rc : report(j, n);
}

/* ---- command line ---- */

static const plft_usage usage = {
    "select-rois", "RAW... --lut CAM.plut -o REGIONS.csv [options]",
    "Regions for monitor: patches of lenses on one surface with texture along both "
    "axes,\n"
    "spread over the picture, with the standard errors that the core states for them.\n"
    "Several frames of the scene at rest tell the camera's noise; of one it is "
    "assumed."};

static int numbers(const char *text, char mark, int *v, int n)
{
    char *end = NULL;
    int k;

    for (k = 0; k < n; k++) {
        long x = strtol(text, &end, 10);
        if (end == text || x < 0 || x > 32767 || *end != (k + 1 < n ? mark : '\0')) {
            return PLFT_USAGE;
        }
        v[k] = (int)x;
        text = end + 1;
    }
    return 0;
}

static int check(request *r, int n)
{
    int side[2] = {r->wish.w, r->wish.h};

    if (n < 1 || r->source.lut == NULL || r->out == NULL) {
        return plft_fail(PLFT_USAGE, "want %s",
                         n < 1                   ? "a raw frame"
                         : r->source.lut == NULL ? "--lut CAM.plut"
                                                 : "-o REGIONS.csv");
    }
    if (r->region != NULL &&
        (numbers(r->region, 'x', side, 2) || side[0] % 2 == 0 || side[1] % 2 == 0 ||
         side[0] < 3 || side[1] < 3 || side[0] > 2 * PLFX_ROI_HALF_MAX + 1 ||
         side[1] > 2 * PLFX_ROI_HALF_MAX + 1)) {
        return plft_fail(PLFT_USAGE,
                         "--region %s: want COLUMNSxROWS, each odd, 3 to %d", r->region,
                         2 * PLFX_ROI_HALF_MAX + 1);
    }
    r->wish.w = side[0];
    r->wish.h = side[1];
    if (r->reference != NULL && numbers(r->reference, ',', r->ref, 4)) {
        return plft_fail(PLFT_USAGE,
                         "--reference %s: want I0,J0,I1,J1, first and last lens",
                         r->reference);
    }
    if (r->views % 4 != 1) {
        return plft_fail(PLFT_USAGE, "--views %d: want 5, 9, 13, ...", r->views);
    }
    return plft_out_check(r->out) || plft_out_check(r->png) ? PLFT_DATA : 0;
}

static int parse(int argc, char **argv, request *r, const char **operand, int *n,
                 int *helped)
{
    const plft_option own[] = {
        {"-o", PLFT_TEXT, &r->out, "REGIONS.csv", 0, 0, "the regions"},
        {"--png", PLFT_TEXT, &r->png, "P.png", 0, 0, "the regions over the frame"},
        {"--regions", PLFT_INT, &r->wish.n, "N", 1, PLFX_ROI_MAX, "how many (24)"},
        {"--region", PLFT_TEXT, &r->region, "CxR", 0, 0, "lenses of a region (7x9)"},
        {"--gap", PLFT_INT, &r->wish.gap, "N", 0, 1000, "lenses between regions (0)"},
        {"--texture", PLFT_REAL, &r->wish.texture, "G", 0, 2,
         "least rms gradient a lens, part of the brightness (0.03)"},
        {"--sigma", PLFT_REAL, &r->sigma, "S", 0, 1,
         "largest standard error in the plane, lenses (0.02)"},
        {"--reference", PLFT_TEXT, &r->reference, "I0,J0,I1,J1", 0, 0,
         "regions whose centre lies there stand on rigid structure"},
        {"--views", PLFT_INT, &r->views, "N", 5, 97, "as of monitor (25)"},
        {"--radius", PLFT_REAL, &r->radius, "R", 1, 127, "as of monitor, pixels"},
        {"--full-well", PLFT_REAL, &r->full_well, "E", 100, 1e7,
         "electrons, for the noise of a single frame (30000)"},
        {"--read-noise", PLFT_REAL, &r->read_noise, "E", 0, 1e4,
         "electrons, the same (16)"},
        {"--json", PLFT_FLAG, &r->json, NULL, 0, 0, "print JSON"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    plft_option options[PLFT_OPTIONS_MAX];

    plft_source_options(options, own, &r->source, 0);
    return plft_args(argc, argv, &usage, options, operand, PLFX_ROI_REST_MAX, n,
                     helped);
}

int plft_cmd_select_rois(int argc, char **argv)
{
    const char *operand[PLFX_ROI_REST_MAX];
    job *j = plft_alloc(1, sizeof *j);
    int n = 0, helped = 0, rc, k;

    if (j == NULL) {
        return PLFT_DATA;
    }
    j->r.wish.n = 24;
    j->r.wish.w = 7;
    j->r.wish.h = 9;
    j->r.wish.texture = 0.03;
    j->r.sigma = 0.02;
    j->r.views = 25;
    j->r.full_well = 30000;
    j->r.read_noise = 16;
    j->r.ref[2] = j->r.ref[3] = -1;
    rc = parse(argc, argv, &j->r, operand, &n, &helped);
    if (rc == 0 && !helped) {
        rc = check(&j->r, n);
        j->r.source.raw = operand[0];
        rc = rc ? rc : run(j, operand, n);
    }
    for (k = 0; k < j->frames; k++) {
        plft_frame_free(&j->frame[k]);
    }
    free(j->places.list);
    plft_field_free(&j->field);
    free(j);
    return rc;
}
