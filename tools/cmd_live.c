/* SPDX-License-Identifier: MIT
 * live: camera to map, frame by frame, by the streaming driver. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "camera/source.h"
#include "camera/whole.h"
#include "commands.h"
#include "common/args.h"
#include "common/colour.h"
#include "common/device.h"
#include "common/err.h"
#include "common/match.h"
#include "common/memory.h"
#include "common/pfm.h"
#include "common/table.h"
#include "plenofix/plenofix.h"

#define PANEL_W 64
#define PANEL_H 20

typedef struct request {
    plft_wish wish;
    const char *lut, *png, *pfm, *slopes, *device;
    double radius;
    int views, window;
    int method; /* plft_method; -1: rows in a stream */
} request;

typedef struct job {
    plft_table table;
    plfx_cfg cfg;
    plfx_plan plan;
    plfx_stream_cfg stream_cfg;
    plfx_stream stream;
    void *ws;
    uint16_t *grey; /* of a mosaic */
    plft_whole whole;
    plfx_map map; /* of whole frames; its slopes are those below */
    int32_t *slope;
    float *v;
    float lo, hi; /* slopes searched */
    int shown;    /* panels drawn so far */
} job;

static double now(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int parse_slopes(const request *r, job *j)
{
    char rest;
    double lo;
    double hi;
    int n;

    if (r->slopes == NULL ||
        sscanf(r->slopes, "%lf:%lf:%d%c", &lo, &hi, &n, &rest) != 3 || !(lo < hi) ||
        lo < -8 || hi > 8 || n < PLFX_LABELS_MIN || n > PLFX_LABELS_MAX) {
        return plft_fail(PLFT_USAGE,
                         "--slopes %s: want MIN:MAX:N from -8 to 8, N %d to %d; "
                         "plenofix depth finds and prints them",
                         r->slopes ? r->slopes : "", PLFX_LABELS_MIN, PLFX_LABELS_MAX);
    }
    j->cfg.slope_min_q16 = (int32_t)lround(lo * 65536.0);
    j->cfg.slope_max_q16 = (int32_t)lround(hi * 65536.0);
    j->cfg.labels = (uint16_t)n;
    j->lo = (float)lo;
    j->hi = (float)hi;
    return 0;
}

/* Views in a row, the middle one the reference. */
static int fill_stream(const request *r, job *j)
{
    double radius = r->radius > 0 ? r->radius : j->table.lut.radius_q8 / 256.0;
    int views = r->views ? r->views : 5;
    int k;

    if (views % 2 == 0 || views > 15) {
        return plft_fail(PLFT_USAGE, "--views %d: want an odd number, 3 to 15", views);
    }
    j->cfg.method = PLFX_METHOD_SWEEP;
    j->cfg.cost = PLFX_COST_SAD;
    j->cfg.fit = PLFX_FIT_VEE;
    j->cfg.window = (uint8_t)(r->window ? r->window : 9);
    j->cfg.bits = 8;
    j->cfg.n = (uint8_t)views;
    j->cfg.ref = (uint8_t)(views / 2);
    j->cfg.texture = 8;
    for (k = 0; k < views; k++) {
        double u = radius * (2.0 * k / (views - 1) - 1.0);
        j->cfg.at[k].u_q8 = (int16_t)lround(256.0 * u);
    }
    return 0;
}

/* Whole frames, by what depth would do. */
static int fill_whole(const request *r, job *j)
{
    plft_whole *w = &j->whole;

    w->lut = r->lut;
    w->wish.method = r->method;
    w->wish.n = r->views;
    w->wish.radius = r->radius;
    w->lo = j->cfg.slope_min_q16 / 65536.0;
    w->hi = j->cfg.slope_max_q16 / 65536.0;
    w->labels = j->cfg.labels;
    w->window = r->window;
    return plft_device_parse(&w->device, r->device);
}

static int fill_cfg(const request *r, job *j)
{
    if (r->window && r->window % 2 == 0) {
        return plft_fail(PLFT_USAGE, "--window %d: want an odd number", r->window);
    }
    if (r->method < 0 && r->device != NULL) {
        return plft_fail(PLFT_USAGE, "--device: wants a --method too");
    }
    return r->method < 0 ? fill_stream(r, j) : fill_whole(r, j);
}

static int prepare_stream(job *j, const plft_camera *c)
{
    plfx_stream_cfg *s = &j->stream_cfg;
    const plfx_lut *t = &j->table.lut;
    size_t n;

    s->plan = &j->plan;
    s->lut = t;
    s->tone = plfx_tone_unity(j->cfg.bits);
    s->profile = PLFX_PROFILE_FAST;
    s->white = 1;
    s->format = c->cfg.bayer ? PLFX_RAW_U16 : c->cfg.format;
    s->bits = c->cfg.bits;
    if (c->cfg.bayer) { /* a 2x2 mean is centred half a pixel right and down */
        s->tone.dx_q8 = s->tone.dy_q8 = -128;
    }
    s->open_rows = plfx_stream_open_rows(t, &j->plan, &s->tone);
    s->j0 = 0;
    s->j1 = t->lattice.ny;
    n = plfx_stream_ws(s);
    if (s->open_rows == 0 || n == 0) {
        return plft_fail(PLFT_DATA,
                         "lens rows of the table are not in the sensor's order");
    }
    j->ws = plft_alloc_ws(n);
    if (j->ws == NULL) {
        return PLFT_DATA;
    }
    return plfx_stream_init(&j->stream, s, j->ws, n) == PLFX_OK
               ? 0
               : plft_fail(PLFT_DATA, "this table cannot be streamed");
}

static int prepare(const request *r, job *j, const plft_camera *c)
{
    const plfx_lattice *l = &j->table.lut.lattice;
    size_t n = (size_t)l->nx * (size_t)l->ny;
    int rc = plft_camera_suits(c, &j->table.lut, r->lut);

    rc = rc != 0 ? rc : plft_slopes_alloc(&j->map, l->nx, l->ny);
    j->slope = j->map.slope_q16;
    j->v = plft_alloc(n, sizeof *j->v);
    if (rc != 0 || j->v == NULL || r->method >= 0) {
        return rc != 0 || j->v != NULL ? rc : PLFT_DATA;
    }
    if (plfx_plan_init(&j->plan, &j->cfg, &j->table.lut, j->table.lut.lattice.nx,
                       j->table.lut.lattice.ny) != PLFX_OK) {
        return plft_fail(PLFT_USAGE,
                         "these views and slopes reach beyond the map; fewer "
                         "views or smaller slopes");
    }
    j->grey = plft_alloc((size_t)c->cfg.w * 3, sizeof *j->grey);
    return j->grey ? prepare_stream(j, c) : PLFT_DATA;
}

/* Row y of the frame; of a mosaic its grey. */
static plfx_status row_at(job *j, const plfx_camera_frame *f, int32_t y,
                          plfx_raw_row *row)
{
    int32_t w = f->raw.w;
    uint16_t *line[3] = {j->grey, j->grey + w, j->grey + 2 * w};
    plfx_status status = plfx_raw_row_at(&f->raw, y, row);
    int32_t k;

    if (status != PLFX_OK || f->bayer == PLFX_BAYER_NONE) {
        return status;
    }
    y = y + 1 < f->raw.h ? y : y - 1;
    for (k = 0; status == PLFX_OK && k < 2; k++) {
        status = plfx_raw_row_at(&f->raw, y + k, row);
        if (status == PLFX_OK) {
            status = plfx_raw_unpack(row, 0, w, line[k]);
        }
    }
    if (status == PLFX_OK) {
        status = plfx_raw_bayer_grey(line[0], line[1], w, line[2]);
    }
    row->bytes = (const uint8_t *)line[2];
    row->format = PLFX_RAW_U16;
    row->bit = 0;
    return status;
}

static plfx_status pop_all(job *j, int32_t ready)
{
    int32_t nx = j->table.lut.lattice.nx;
    plfx_status status = PLFX_OK;

    while (status == PLFX_OK && ready > 0) { /* at most the rows of the map */
        plfx_map line;
        int32_t at;
        memset(&line, 0, sizeof line);
        line.w = line.stride = nx;
        line.h = 1;
        line.slope_q16 = j->slope + (size_t)j->stream.j * (size_t)nx;
        status = plfx_stream_pop(&j->stream, &at, &line, &ready);
    }
    return status;
}

static int stream_frame(job *j, const plfx_camera_frame *f)
{
    plfx_status status = plfx_stream_reset(&j->stream);
    int32_t first = 0;
    int32_t last = -1;
    int32_t y;

    plfx_stream_rows(&j->stream, &first, &last);
    for (y = first; status == PLFX_OK && y <= last; y++) {
        plfx_raw_row row;
        int32_t ready = 0;
        status = row_at(j, f, y, &row);
        if (status == PLFX_OK) {
            status = plfx_stream_push(&j->stream, y, &row, &ready);
        }
        if (status == PLFX_OK) {
            status = pop_all(j, ready);
        }
    }
    if (status == PLFX_OK) {
        status = plfx_stream_finish(&j->stream);
    }
    return status == PLFX_OK ? 0 : plft_fail(PLFT_DATA, "the frame cannot be matched");
}

static double to_float(job *j)
{
    size_t n = (size_t)j->table.lut.lattice.nx * (size_t)j->table.lut.lattice.ny;
    size_t measured = 0;
    size_t i;

    for (i = 0; i < n; i++) {
        int none = j->slope[i] == PLFX_SLOPE_NONE;
        j->v[i] = none ? NAN : (float)(j->slope[i] / 65536.0);
        measured += !none;
    }
    return 100.0 * (double)measured / (double)n;
}

/* The map in characters, near to far; redrawn in place. */
static void draw_panel(job *j)
{
    static const char shade[] = "@%#*+=-:.";
    int32_t nx = j->table.lut.lattice.nx;
    int32_t ny = j->table.lut.lattice.ny;
    int x;
    int y;

    if (j->shown++ > 0) {
        printf("\033[%dA", PANEL_H + 1);
    }
    for (y = 0; y < PANEL_H; y++) {
        for (x = 0; x < PANEL_W; x++) {
            float s = j->v[(size_t)(y * ny / PANEL_H) * (size_t)nx +
                           (size_t)(x * nx / PANEL_W)];
            float t = (s - j->lo) / (j->hi - j->lo) * 9.0f;
            putchar(isnan(s) ? ' ' : shade[t < 0 ? 0 : t > 8 ? 8 : (int)t]);
        }
        printf("\033[K\n");
    }
}

static int show(const request *r, job *j, const plfx_camera_frame *f, double seconds)
{
    int32_t nx = j->table.lut.lattice.nx;
    int32_t ny = j->table.lut.lattice.ny;
    double measured = to_float(j);
    int rc = 0;

    if (isatty(STDOUT_FILENO)) {
        draw_panel(j);
    }
    printf("frame %u: %.1f %% measured, %.1f ms, %u dropped%s\n", f->sequence, measured,
           1000.0 * seconds, f->dropped, isatty(STDOUT_FILENO) ? "\033[K" : "");
    (void)fflush(stdout);
    if (r->png) {
        rc = plft_colour_png(r->png, j->v, nx, ny, j->lo, j->hi, 0, "slope");
    }
    if (rc == 0 && r->pfm) {
        rc = plft_pfm_write(r->pfm, j->v, nx, ny);
    }
    return rc;
}

static int run(const request *r, job *j, plft_camera *c)
{
    int rc = prepare(r, j, c);
    int n = 0;

    while (rc == 0 && (r->wish.frames == 0 || n < r->wish.frames)) {
        double t0;
        plfx_camera_frame f;
        rc = plft_camera_next(c, &f);
        if (rc != 0) {
            break;
        }
        t0 = now();
        rc = r->method < 0 ? stream_frame(j, &f)
                           : plft_whole_map(&j->whole, &f, c->name, &j->map);
        rc = rc != 0 ? rc : show(r, j, &f, now() - t0);
        plft_camera_release(c, &f);
        n++;
    }
    if (rc < 0 && n == 0) {
        return plft_fail(PLFT_DATA, "%s holds no whole frame", c->name);
    }
    return rc < 0 ? 0 : rc;
}

int plft_cmd_live(int argc, char **argv)
{
    static const plft_usage usage = {
        "live", "CAMERA --lut CAM.plut --slopes MIN:MAX:N [options]",
        "Maps of a camera or recording as they come: a panel in the terminal, the "
        "latest "
        "map\nas a picture.  Ctrl-C ends it."};
    static const char *operand[1];
    plft_option options[PLFT_SOURCE_OPTIONS + 11];
    request r;
    job j;
    plft_camera c;
    int helped = 0;
    int rc;

    memset(&r, 0, sizeof r);
    memset(&j, 0, sizeof j);
    plft_wish_none(&r.wish);
    r.wish.speed = 1;
    r.method = -1;
    {
        const plft_option own[] = {
            {"--lut", PLFT_TEXT, &r.lut, "CAM.plut", 0, 0, "lens table"},
            {"--slopes", PLFT_TEXT, &r.slopes, "MIN:MAX:N", 0, 0, "slopes searched"},
            {"--method", PLFT_WORD, &r.method, PLFT_METHODS, 0, 0,
             "whole frames, with the answers of depth; rows as they come"},
            {"--device", PLFT_TEXT, &r.device, "cpu|cl[:N]", 0, 0,
             "where --method is computed; cpu"},
            {"--views", PLFT_INT, &r.views, "N", 2, PLFX_VIEWS_MAX,
             "of rows: in a row, odd, 5; of --method: as depth"},
            {"--window", PLFT_INT, &r.window, "N", PLFX_WINDOW_MIN, PLFX_WINDOW_MAX,
             "lenses on a side, odd; 9, with --method as depth"},
            {"--radius", PLFT_REAL, &r.radius, "R", 0.1, 127,
             "of the outermost views, pixels; the table's"},
            {"-o", PLFT_TEXT, &r.png, "LATEST.png", 0, 0,
             "the latest map, false colours"},
            {"--pfm", PLFT_TEXT, &r.pfm, "LATEST.pfm", 0, 0, "the latest map, numbers"},
            {"--speed", PLFT_REAL, &r.wish.speed, "X", 0, 1000,
             "of a recording: 1 real time, 0 without waiting"},
            {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
        memcpy(options + plft_wish_options(options, &r.wish), own, sizeof own);
    }
    rc = plft_args(argc, argv, &usage, options, operand, 1, &r.wish.n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    if (r.lut == NULL) {
        return plft_fail(PLFT_USAGE, "want --lut CAM.plut");
    }
    r.wish.names = operand;
    rc = parse_slopes(&r, &j);
    rc = rc != 0 ? rc : plft_table_read(&j.table, r.lut);
    rc = rc != 0 ? rc : fill_cfg(&r, &j);
    if (rc == 0) {
        rc = plft_camera_start(&c, &r.wish);
        if (rc == 0) {
            rc = run(&r, &j, &c);
            plft_camera_report(&c);
            plft_camera_stop(&c);
        }
    }
    plft_table_free(&j.table);
    free(j.ws);
    free(j.grey);
    plft_slopes_free(&j.map);
    free(j.v);
    return rc;
}
