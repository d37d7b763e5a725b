/* SPDX-License-Identifier: MIT
 * plenofix bench: time, instructions, memory of the core on made input, one thread. */
#define _POSIX_C_SOURCE 200112L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench_count.h"
#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/json.h"
#include "common/memory.h"
#include "plenofix/plenofix.h"

#define SENSOR_W 4904 /* the sensor of the published plenoptic frames: 16 megapixels */
#define SENSOR_H 3280
#define LENSES_X 289
#define LENSES_Y 193

typedef struct camera {
    plfx_lut lut;
    uint8_t *blob; /* NULL: not made yet */
    uint16_t *frame;
} camera;

typedef struct result {
    const char *name;
    plft_counted functions; /* what is timed */
    double ms, cells;       /* a cell: one sample and, for matchers, one label */
    size_t bytes;           /* workspace */
} result;

typedef struct bench {
    int rounds, json, count, names;
    const char *only; /* NULL: all cases */
    json_t *list;
    camera camera;
} bench;

typedef struct bench_case {
    const char *name;
    int (*run)(bench *b, const struct bench_case *c);
    int w, h, labels, window, bits, ncc; /* matchers */
    int n, profile;                      /* camera: views (0: by arms) */
} bench_case;

static const char *const sweeps[] = {"plfx_sweep", NULL};
static const char *const gradients[] = {"plfx_gradient", NULL};
static const char *const streams[] = {"plfx_stream_push", "plfx_stream_pop", NULL};
static const char *const decodes[] = {"plfx_view_all", NULL};

/* Processor time of this thread, ms. */
static double now_ms(void)
{
    struct timespec t;

    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static json_t *as_json(const bench *b, const result *r, double instructions)
{
    json_t *row =
        json_pack("{s:s,s:f,s:f,s:I}", "name", r->name, "ms", r->ms, "ns_per_cell",
                  1e6 * r->ms / r->cells, "bytes", (json_int_t)r->bytes);

    if (row != NULL && b->count) {
        (void)json_object_set_new(row, "instructions_per_cell",
                                  json_real(instructions / r->cells));
    }
    return row;
}

static void heading(const bench *b)
{
    printf("%-34s %9s %8s %s%9s\n", "case", "ms", "ns/cell",
           b->count ? "ins/cell " : "", "KiB");
}

static void as_text(const bench *b, const result *r, double instructions)
{
    printf("%-34s %9.3f %8.3f ", r->name, r->ms, 1e6 * r->ms / r->cells);
    if (b->count) {
        printf("%8.2f ", instructions / r->cells);
    }
    printf("%9.1f\n", (double)r->bytes / 1024.0);
    (void)fflush(stdout); /* the next case may take long */
}

/* A case that ran; ms is not finite where it did not. */
static int report(bench *b, const result *r)
{
    double instructions = 0;
    int rc;

    if (!isfinite(r->ms)) {
        return plft_fail(PLFT_DATA,
                         "bench: '%s' does not run: is there too little memory?",
                         r->name);
    }
    rc = b->count ? plft_count(r->name, r->functions, &instructions) : 0;
    if (rc == 0 && b->json) {
        (void)json_array_append_new(b->list, as_json(b, r, instructions));
    } else if (rc == 0) {
        as_text(b, r, instructions);
    }
    return rc;
}

static uint32_t noise(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 16;
}

/* Two views of a slanted noise plane; label l is l whole columns. */
static void draw_pair(uint16_t *px, const bench_case *c)
{
    uint32_t state = 1;
    uint32_t mask = (1u << c->bits) - 1u;

    for (int y = 0; y < c->h; y++) {
        uint16_t *a = px + (size_t)y * 2 * (size_t)c->w;
        for (int x = 0; x < c->w; x++) {
            a[x] = (uint16_t)(noise(&state) & mask);
        }
        for (int x = 0; x < c->w; x++) {
            int from = x + (c->labels - 1) * y / c->h;
            a[c->w + x] = a[from < c->w ? from : c->w - 1];
        }
    }
}

static int plan_pair(plfx_plan *plan, const bench_case *c)
{
    plfx_cfg g;

    memset(&g, 0, sizeof g);
    g.method = c->ncc ? PLFX_METHOD_PAIRS : PLFX_METHOD_SWEEP;
    g.cost = c->ncc ? PLFX_COST_ZNCC : PLFX_COST_SAD;
    g.window = (uint8_t)c->window;
    g.bits = (uint8_t)c->bits;
    g.n = 2;
    g.labels = (uint16_t)c->labels;
    g.at[1].u_q8 = -16 * 256; /* a label is 1/16 of slope: one column */
    g.slope_max_q16 = (c->labels - 1) * 4096;
    return plfx_plan_init(plan, &g, NULL, c->w, c->h) == PLFX_OK;
}

static double time_sweep(const plfx_plan *plan, const plfx_views *v, const plfx_map *m,
                         void *ws, size_t size, int rounds)
{
    double best = INFINITY;

    for (int i = 0; i < rounds; i++) {
        double start = now_ms();
        if (plfx_sweep(plan, v, m, ws, size) != PLFX_OK) {
            return NAN;
        }
        best = fmin(best, now_ms() - start);
    }
    return best;
}

static int run_match(bench *b, const bench_case *c)
{
    size_t cells = (size_t)c->w * (size_t)c->h;
    uint16_t *px = plft_alloc(2 * cells, sizeof *px);
    int32_t *slope = plft_alloc(cells, sizeof *slope);
    plfx_views v = {px, c->w, c->h, 2};
    plfx_map m = {slope, NULL, NULL, NULL, c->w, c->h, c->w};
    result r = {c->name, sweeps, NAN, (double)cells * c->labels, 0};
    void *ws = NULL;
    plfx_plan plan;

    if (px && slope && plan_pair(&plan, c)) {
        r.bytes = plfx_sweep_ws(&plan);
        ws = plft_alloc_ws(r.bytes);
    }
    if (ws) {
        draw_pair(px, c);
        r.ms = time_sweep(&plan, &v, &m, ws, r.bytes, b->rounds);
    }
    free(ws);
    free(slope);
    free(px);
    return report(b, &r);
}

static int plan_gradient(plfx_plan *plan, const bench_case *c)
{
    static const int du[5] = {0, -1, 1, 0, 0};
    static const int dv[5] = {0, 0, 0, -1, 1};
    plfx_cfg g;

    memset(&g, 0, sizeof g);
    g.method = PLFX_METHOD_GRADIENT;
    g.window = (uint8_t)c->window;
    g.bits = (uint8_t)c->bits;
    g.n = 5;
    g.labels = PLFX_LABELS_MIN;
    g.slope_max_q16 = 65536;
    for (int k = 0; k < 5; k++) {
        g.at[k].u_q8 = (int16_t)(256 * du[k]);
        g.at[k].v_q8 = (int16_t)(256 * dv[k]);
    }
    return plfx_plan_init(plan, &g, NULL, c->w, c->h) == PLFX_OK;
}

static double time_gradient(const plfx_plan *plan, const plfx_views *v,
                            const plfx_map *m, void *ws, size_t size, int rounds)
{
    double best = INFINITY;

    for (int i = 0; i < rounds; i++) {
        double start = now_ms();
        if (plfx_gradient(plan, v, m, ws, size) != PLFX_OK) {
            return NAN;
        }
        best = fmin(best, now_ms() - start);
    }
    return best;
}

/* Slopes alone, of five views of noise. */
static int run_gradient(bench *b, const bench_case *c)
{
    size_t cells = (size_t)c->w * (size_t)c->h;
    uint16_t *px = plft_alloc(5 * cells, sizeof *px);
    int32_t *slope = plft_alloc(cells, sizeof *slope);
    plfx_views v = {px, c->w, c->h, 5};
    plfx_map m = {slope, NULL, NULL, NULL, c->w, c->h, c->w};
    result r = {c->name, gradients, NAN, (double)cells, 0};
    uint32_t state = 1;
    void *ws = NULL;
    plfx_plan plan;

    if (px && slope && plan_gradient(&plan, c)) {
        r.bytes = plfx_gradient_ws(&plan);
        ws = plft_alloc_ws(r.bytes);
    }
    if (ws) {
        for (size_t i = 0; i < 5 * cells; i++) {
            px[i] = (uint16_t)(noise(&state) & ((1u << c->bits) - 1u));
        }
        r.ms = time_gradient(&plan, &v, &m, ws, r.bytes, b->rounds);
    }
    free(ws);
    free(slope);
    free(px);
    return report(b, &r);
}

static void describe(plfx_lut_desc *d)
{
    double turn = 0.05 * 3.14159265358979 / 180;
    double pitch = 16.93;

    memset(d, 0, sizeof *d);
    d->sensor_w = SENSOR_W;
    d->sensor_h = SENSOR_H;
    d->sensor_bits = 12;
    d->lattice.nx = LENSES_X;
    d->lattice.ny = LENSES_Y;
    d->lattice.origin.x_q16 = 12 * 65536;
    d->lattice.origin.y_q16 = 9 * 65536;
    d->lattice.a.x_q22 = (int32_t)lround(pitch * 4194304);
    d->lattice.a.y_q22 = (int32_t)lround(pitch * turn * 4194304);
    d->lattice.b.x_q22 = -d->lattice.a.y_q22;
    d->lattice.b.y_q22 = d->lattice.a.x_q22;
    d->radius_q8 = 7 * 256;
}

/* The frame of noise and its table, made once; 0 where there is no memory. */
static int open_camera(camera *c)
{
    plfx_lut_desc d;
    uint32_t state = 1;
    size_t n = (size_t)SENSOR_W * SENSOR_H;
    size_t bytes;

    if (c->blob != NULL) {
        return 1;
    }
    describe(&d);
    bytes = plfx_lut_bytes(&d);
    c->blob = plft_alloc(bytes, 1);
    c->frame = plft_alloc(n, sizeof *c->frame);
    if (!c->blob || !c->frame || plfx_lut_write(&d, c->blob, bytes) != PLFX_OK ||
        plfx_lut_open(&c->lut, c->blob, bytes) != PLFX_OK) {
        return 0;
    }
    for (size_t i = 0; i < n; i++) {
        c->frame[i] = (uint16_t)(noise(&state) & 4095u);
    }
    return 1;
}

static int plan_views(plfx_plan *plan, const camera *c, int n)
{
    plfx_cfg g;

    memset(&g, 0, sizeof g);
    g.window = 9;
    g.bits = 12;
    g.n = (uint8_t)n;
    g.ref = (uint8_t)(n / 2);
    g.labels = 17;
    g.fit = PLFX_FIT_VEE;
    for (int k = 0; k < n; k++) { /* -6 .. 6 px along u */
        g.at[k].u_q8 = (int16_t)(6 * 256 * (2 * k - (n - 1)) / (n - 1));
    }
    g.slope_min_q16 = -10000;
    g.slope_max_q16 = 10000;
    return plfx_plan_init(plan, &g, &c->lut, LENSES_X, LENSES_Y) == PLFX_OK;
}

/* The stream preset: 8 views on the axes around the reference. */
static int plan_arms(plfx_plan *plan, const camera *c, plfx_frame_cfg *frame)
{
    plfx_cfg g;

    memset(&g, 0, sizeof g);
    if (plfx_preset(PLFX_PRESET_STREAM, &g, frame) != PLFX_OK) {
        return 0;
    }
    g.bits = 12;
    g.n = 9;
    g.labels = 17;
    for (int k = 0; k < 4; k++) { /* 3 and 6 px */
        int16_t d = (int16_t)((k % 2 ? 6 : 3) * (k / 2 ? 256 : -256));
        g.at[1 + k].u_q8 = d;
        g.at[5 + k].v_q8 = d;
    }
    g.slope_min_q16 = -10000;
    g.slope_max_q16 = 10000;
    return plfx_plan_init(plan, &g, &c->lut, LENSES_X, LENSES_Y) == PLFX_OK;
}

/* One frame through the stream; 0 when a call fails. */
/* NOLINTNEXTLINE(readability-non-const-parameter): rows of the map are written to it */
static int stream_frame(plfx_stream *s, const camera *c, int32_t *slope)
{
    plfx_map row = {slope, NULL, NULL, NULL, LENSES_X, 1, LENSES_X};

    if (plfx_stream_reset(s) != PLFX_OK) {
        return 0;
    }
    for (int y = 0; y < SENSOR_H; y++) {
        const uint16_t *px = c->frame + (size_t)y * SENSOR_W;
        plfx_raw_row raw = {(const uint8_t *)px, PLFX_RAW_U16, 12, 0, SENSOR_W};
        int32_t ready = 0;
        int32_t j = 0;
        if (plfx_stream_push(s, y, &raw, &ready) != PLFX_OK) {
            return 0;
        }
        while (ready > 0) {
            if (plfx_stream_pop(s, &j, &row, &ready) != PLFX_OK) {
                return 0;
            }
        }
    }
    return plfx_stream_finish(s) == PLFX_OK;
}

static double time_stream(plfx_stream *s, const camera *c, int rounds)
{
    int32_t *slope = plft_alloc(LENSES_X, sizeof *slope);
    double best = INFINITY;

    for (int i = 0; slope && i < rounds; i++) {
        double start = now_ms();
        if (!stream_frame(s, c, slope)) {
            best = NAN;
            break;
        }
        best = fmin(best, now_ms() - start);
    }
    free(slope);
    return best;
}

static int run_stream(bench *b, const bench_case *k)
{
    const camera *c = &b->camera;
    result r = {k->name, streams, NAN, LENSES_X * LENSES_Y * 17.0, 0};
    plfx_stream_cfg cfg;
    plfx_frame_cfg frame;
    plfx_stream s;
    plfx_plan plan;
    void *ws = NULL;

    memset(&cfg, 0, sizeof cfg);
    if (open_camera(&b->camera) &&
        (k->n > 0 ? plan_views(&plan, c, k->n) : plan_arms(&plan, c, &frame))) {
        cfg.plan = &plan;
        cfg.frame = k->n > 0 ? NULL : &frame;
        cfg.lut = &c->lut;
        cfg.tone = plfx_tone_unity(12);
        cfg.profile = (uint8_t)k->profile;
        cfg.format = PLFX_RAW_U16;
        cfg.bits = 12;
        cfg.open_rows = plfx_stream_open_rows(&c->lut, &plan, &cfg.tone);
        cfg.j1 = LENSES_Y;
        r.bytes = plfx_stream_ws(&cfg);
        ws = r.bytes > 0 ? plft_alloc_ws(r.bytes) : NULL;
    }
    if (ws && plfx_stream_init(&s, &cfg, ws, r.bytes) == PLFX_OK) {
        r.ms = time_stream(&s, c, b->rounds);
    }
    free(ws);
    return report(b, &r);
}

static double time_decode(const camera *c, const plfx_views *v, const plfx_offset *at,
                          int rounds)
{
    plfx_raw raw = {(const uint8_t *)c->frame,
                    2 * (size_t)SENSOR_W * SENSOR_H,
                    PLFX_RAW_U16,
                    12,
                    SENSOR_W,
                    SENSOR_H};
    plfx_tone tone = plfx_tone_unity(12);
    double best = INFINITY;

    for (int i = 0; i < rounds; i++) {
        double start = now_ms();
        if (plfx_view_all(&c->lut, &raw, &tone, at, 0, v) != PLFX_OK) {
            return NAN;
        }
        best = fmin(best, now_ms() - start);
    }
    return best;
}

static int run_decode(bench *b, const bench_case *k)
{
    size_t cells = (size_t)LENSES_X * LENSES_Y * (size_t)k->n;
    plfx_views v = {plft_alloc(cells, sizeof(uint16_t)), LENSES_X, LENSES_Y, k->n};
    result r = {k->name, decodes, NAN, (double)cells, 0};
    plfx_offset at[13 * 13];

    for (int i = 0; i < k->n; i++) {
        at[i].u_q8 = (int16_t)(256 * (i % 13 - 6));
        at[i].v_q8 = (int16_t)(256 * (i / 13 - 6));
    }
    if (v.px && open_camera(&b->camera)) {
        r.ms = time_decode(&b->camera, &v, at, b->rounds);
    }
    free(v.px);
    return report(b, &r);
}

#define SAD(labels, window, bits) run_match, 640, 480, labels, window, bits, 0, 0, 0
#define NCC(labels)               run_match, 640, 480, labels, 9, 8, 1, 0, 0
#define CAMERA(run, n, profile)   run, 0, 0, 0, 0, 0, 0, n, PLFX_PROFILE_##profile

static const bench_case cases[] = {
    {"SAD 640x480 16 labels 9x9", SAD(16, 9, 8)},
    {"SAD 640x480 32 labels 9x9", SAD(32, 9, 8)},
    {"SAD 640x480 64 labels 9x9", SAD(64, 9, 8)},
    {"SAD 640x480 16 labels 5x5", SAD(16, 5, 8)},
    {"SAD 640x480 16 labels 21x21", SAD(16, 21, 8)},
    {"SAD 640x480 16 labels 9x9 12 bit", SAD(16, 9, 12)},
    {"NCC 640x480 17 labels 9x9", NCC(17)},
    {"NCC 640x480 64 labels 9x9", NCC(64)},
    {"gradient 289x193 5 views 9x9", run_gradient, 289, 193, 0, 9, 12, 0, 0, 0},
    {"stream 5 views small", CAMERA(run_stream, 5, SMALL)},
    {"stream 5 views fast", CAMERA(run_stream, 5, FAST)},
    {"stream 9 views small", CAMERA(run_stream, 9, SMALL)},
    {"stream 9 views fast", CAMERA(run_stream, 9, FAST)},
    {"stream 8 views by arms", CAMERA(run_stream, 0, FAST)},
    {"decode 13x13 views", CAMERA(run_decode, 169, FAST)},
};
#define CASES (sizeof cases / sizeof cases[0])

static int is_wanted(const bench *b, const bench_case *c)
{
    return b->only == NULL || strcmp(b->only, c->name) == 0;
}

/* Names of the cases, all of them or the one that is wanted. */
static int print_names(const bench *b)
{
    int n = 0;

    for (size_t k = 0; k < CASES; k++) {
        if (is_wanted(b, &cases[k])) {
            if (b->names) {
                puts(cases[k].name);
            }
            n++;
        }
    }
    return n > 0 ? 0
                 : plft_fail(PLFT_USAGE, "bench: no case '%s': --list prints the names",
                             b->only);
}

static int run_all(bench *b)
{
    int rc = b->count ? plft_count_ready() : 0;

    if (rc == 0 && !b->json) {
        heading(b);
    }
    for (size_t k = 0; rc == 0 && k < CASES; k++) {
        rc = is_wanted(b, &cases[k]) ? cases[k].run(b, &cases[k]) : 0;
    }
    free(b->camera.blob);
    free(b->camera.frame);
    return rc == 0 && b->json ? plft_json_print(b->list) : rc;
}

int plft_cmd_bench(int argc, char **argv)
{
    const plft_usage usage = {"bench", "[options]",
                              "Time, instructions and workspace of the core on made "
                              "input, one thread: the least\n"
                              "processor time of some rounds. ns/cell and ins/cell are "
                              "of a cell: one sample of\n"
                              "the map and, where labels are searched, one label; of a "
                              "decoded view one sample.\n"
                              "Streams take a raw frame of 16 megapixels to the map of "
                              "289x193 lenses, 17 labels."};
    bench b;
    int n;
    int helped;
    int rc;
    const plft_option options[] = {
        {"--rounds", PLFT_INT, &b.rounds, "N", 1, 1000, "rounds of each case (5)"},
        {"--only", PLFT_TEXT, &b.only, "NAME", 0, 0, "one case, by its name"},
        {"--list", PLFT_FLAG, &b.names, NULL, 0, 0, "print the names and run nothing"},
        {"--instructions", PLFT_FLAG, &b.count, NULL, 0, 0,
         "count instructions as well, by valgrind; a minute or two"},
        {"--json", PLFT_FLAG, &b.json, NULL, 0, 0, "print as JSON"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};

    memset(&b, 0, sizeof b);
    b.rounds = 5;
    rc = plft_args(argc, argv, &usage, options, NULL, 0, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    rc = print_names(&b);
    if (rc != 0 || b.names) {
        return rc;
    }
    b.list = json_array();
    rc = run_all(&b);
    json_decref(b.list);
    return rc;
}
