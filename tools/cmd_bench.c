/* SPDX-License-Identifier: MIT
 * plenofix bench: time and memory of the core's kernels on made input, one thread. */
#define _POSIX_C_SOURCE 200112L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

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

typedef struct result {
    const char *name;
    double ms, per_cell_ns; /* a cell: one sample and, for matchers, one label */
    size_t bytes;           /* workspace */
} result;

typedef struct bench {
    int rounds, json;
    const char *only; /* NULL: all cases */
    json_t *list;
} bench;

/* Processor time of this thread, ms. */
static double now_ms(void)
{
    struct timespec t;

    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int report(bench *b, const result *r)
{
    if (b->json) {
        return json_array_append_new(b->list, json_pack("{s:s,s:f,s:f,s:I}", "name",
                                                        r->name, "ms", r->ms,
                                                        "ns_per_cell", r->per_cell_ns,
                                                        "bytes", (json_int_t)r->bytes));
    }
    printf("%-34s %9.3f ms %8.3f ns/cell %9.1f KiB\n", r->name, r->ms, r->per_cell_ns,
           (double)r->bytes / 1024.0);
    return 0;
}

static int wanted(const bench *b, const char *name)
{
    return b->only == NULL || strcmp(b->only, name) == 0;
}

static uint32_t noise(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 16;
}

typedef struct match_case {
    const char *name;
    int w, h, labels, window, bits, ncc;
} match_case;

/* Two views of a slanted noise plane; label l is l whole columns. */
static void draw_pair(uint16_t *px, const match_case *c)
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

static int plan_pair(plfx_plan *plan, const match_case *c)
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

static int run_match(bench *b, const match_case *c)
{
    size_t cells = (size_t)c->w * (size_t)c->h;
    uint16_t *px = plft_alloc(2 * cells, sizeof *px);
    int32_t *slope = plft_alloc(cells, sizeof *slope);
    plfx_views v = {px, c->w, c->h, 2};
    plfx_map m = {slope, NULL, NULL, NULL, c->w, c->h, c->w};
    result r = {c->name, NAN, 0, 0};
    void *ws = NULL;
    plfx_plan plan;

    if (px && slope && plan_pair(&plan, c)) {
        r.bytes = plfx_sweep_ws(&plan);
        ws = plft_alloc_ws(r.bytes);
    }
    if (ws) {
        draw_pair(px, c);
        r.ms = time_sweep(&plan, &v, &m, ws, r.bytes, b->rounds);
        r.per_cell_ns = 1e6 * r.ms / (double)cells / c->labels;
    }
    free(ws);
    free(slope);
    free(px);
    return isnan(r.ms) ? plft_fail(PLFT_DATA, "%s does not run", c->name)
                       : report(b, &r);
}

typedef struct camera {
    plfx_lut lut;
    uint8_t *blob;
    uint16_t *frame;
} camera;

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

static int open_camera(camera *c)
{
    plfx_lut_desc d;
    uint32_t state = 1;
    size_t n = (size_t)SENSOR_W * SENSOR_H;
    size_t bytes;

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

typedef struct stream_case {
    const char *name;
    int n, profile; /* n = 0: by arms */
} stream_case;

static int run_stream(bench *b, const camera *c, const stream_case *k)
{
    result r = {k->name, NAN, 0, 0};
    plfx_stream_cfg cfg;
    plfx_frame_cfg frame;
    plfx_stream s;
    plfx_plan plan;
    void *ws = NULL;

    memset(&cfg, 0, sizeof cfg);
    if (k->n > 0 ? plan_views(&plan, c, k->n) : plan_arms(&plan, c, &frame)) {
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
        r.per_cell_ns = 1e6 * r.ms / (LENSES_X * LENSES_Y * 17.0);
    }
    free(ws);
    return isnan(r.ms) ? plft_fail(PLFT_DATA, "%s does not run", k->name)
                       : report(b, &r);
}

static int run_decode(bench *b, const camera *c, const char *name, int side)
{
    int n = side * side;
    size_t cells = (size_t)LENSES_X * LENSES_Y * (size_t)n;
    plfx_views v = {plft_alloc(cells, sizeof(uint16_t)), LENSES_X, LENSES_Y, n};
    plfx_raw raw = {(const uint8_t *)c->frame,
                    2 * (size_t)SENSOR_W * SENSOR_H,
                    PLFX_RAW_U16,
                    12,
                    SENSOR_W,
                    SENSOR_H};
    plfx_tone tone = plfx_tone_unity(12);
    result r = {name, INFINITY, 0, 0};
    plfx_offset at[13 * 13];

    for (int k = 0; k < n; k++) {
        at[k].u_q8 = (int16_t)(256 * (k % side - side / 2));
        at[k].v_q8 = (int16_t)(256 * (k / side - side / 2));
    }
    for (int i = 0; v.px && i < b->rounds; i++) {
        double start = now_ms();
        if (plfx_view_all(&c->lut, &raw, &tone, at, 0, &v) != PLFX_OK) {
            break;
        }
        r.ms = fmin(r.ms, now_ms() - start);
    }
    free(v.px);
    r.per_cell_ns = 1e6 * r.ms / (double)cells;
    return isinf(r.ms) ? plft_fail(PLFT_DATA, "%s does not run", name) : report(b, &r);
}

static int run_cameras(bench *b)
{
    static const stream_case streams[] = {
        {"stream 5 views small", 5, PLFX_PROFILE_SMALL},
        {"stream 5 views fast", 5, PLFX_PROFILE_FAST},
        {"stream 9 views small", 9, PLFX_PROFILE_SMALL},
        {"stream 9 views fast", 9, PLFX_PROFILE_FAST},
        {"stream 8 views by arms", 0, PLFX_PROFILE_FAST}};
    camera c = {.blob = NULL};
    int rc = open_camera(&c) ? 0 : PLFT_DATA;

    for (size_t k = 0; rc == 0 && k < sizeof streams / sizeof streams[0]; k++) {
        rc = wanted(b, streams[k].name) ? run_stream(b, &c, &streams[k]) : 0;
    }
    if (rc == 0 && wanted(b, "decode 13x13 views")) {
        rc = run_decode(b, &c, "decode 13x13 views", 13);
    }
    free(c.blob);
    free(c.frame);
    return rc;
}

static int run_all(bench *b)
{
    static const match_case matches[] = {
        {"SAD 640x480 16 labels 9x9", 640, 480, 16, 9, 8, 0},
        {"SAD 640x480 32 labels 9x9", 640, 480, 32, 9, 8, 0},
        {"SAD 640x480 64 labels 9x9", 640, 480, 64, 9, 8, 0},
        {"SAD 640x480 16 labels 5x5", 640, 480, 16, 5, 8, 0},
        {"SAD 640x480 16 labels 21x21", 640, 480, 16, 21, 8, 0},
        {"SAD 640x480 16 labels 9x9 12 bit", 640, 480, 16, 9, 12, 0},
        {"NCC 640x480 17 labels 9x9", 640, 480, 17, 9, 8, 1}};
    int rc = 0;

    for (size_t k = 0; rc == 0 && k < sizeof matches / sizeof matches[0]; k++) {
        rc = wanted(b, matches[k].name) ? run_match(b, &matches[k]) : 0;
    }
    return rc == 0 ? run_cameras(b) : rc;
}

int plft_cmd_bench(int argc, char **argv)
{
    const plft_usage usage = {
        "bench", "[options]",
        "Time and workspace of the core on made input, one thread: the least processor "
        "time of some rounds."};
    bench b = {5, 0, NULL, NULL};
    int n;
    int helped;
    int rc;
    const plft_option options[] = {
        {"--rounds", PLFT_INT, &b.rounds, "N", 1, 1000, "rounds of each case (5)"},
        {"--only", PLFT_TEXT, &b.only, "NAME", 0, 0, "one case, by its name"},
        {"--json", PLFT_FLAG, &b.json, NULL, 0, 0, "print as JSON"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};

    rc = plft_args(argc, argv, &usage, options, NULL, 0, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    b.list = json_array();
    rc = run_all(&b);
    if (rc == 0 && b.json) {
        rc = plft_json_print(b.list);
    }
    json_decref(b.list);
    return rc;
}
