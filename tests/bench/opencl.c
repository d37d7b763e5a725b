/* SPDX-License-Identifier: MIT
 * Raw frames to maps on an OpenCL device beside the core, in one process: the all-view
 * sweep of a 12-bit packed frame.
 * usage: opencl [DEVICE [LENSES_X LENSES_Y VIEWS LABELS WINDOW]]
 * Prints frames a second one at a time and two in flight, and of every kernel its time
 * by the device's own clock, the least that it must read and write, and what share that
 * is of the device's own copying speed. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cl_state.h"
#include "plenofix/plenofix.h"

#define REPEATS 5
#define FRAMES  8           /* of the run with two in flight */
#define PITCH   16.9        /* pixels a lens */
#define COPY    (32u << 20) /* bytes of the copy that the kernels are held to */
#define MEGA    1e-6

static double seconds(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int argument(int argc, char **argv, int k, int otherwise)
{
    return argc > k ? atoi(argv[k]) : otherwise;
}

static void give_up(const char *what)
{
    fprintf(stderr, "opencl: %s\n", what);
    exit(1);
}

typedef struct scene {
    plfx_lut lut;
    plfx_raw raw;
    plfx_tone tone;
    plfx_plan plan;
    plfx_views views;
    plfx_map got, want;
} scene;

/* A square array; 289x193 lenses give a sensor of 4904x3280. */
static void make_table(scene *s, int nx, int ny)
{
    plfx_lut_desc d;
    void *blob;

    memset(&d, 0, sizeof d);
    d.sensor_w = (int32_t)(nx * PITCH) + 20;
    d.sensor_h = (int32_t)(ny * PITCH) + 19;
    d.sensor_bits = 12;
    d.lattice.nx = nx;
    d.lattice.ny = ny;
    d.lattice.origin.x_q16 = d.lattice.origin.y_q16 = 10 << 16;
    d.lattice.a.x_q22 = d.lattice.b.y_q22 = (int32_t)lround(PITCH * 4194304.0);
    d.radius_q8 = 7 * 256;
    blob = malloc(plfx_lut_bytes(&d));
    if (!blob || plfx_lut_write(&d, blob, plfx_lut_bytes(&d)) != PLFX_OK ||
        plfx_lut_open(&s->lut, blob, plfx_lut_bytes(&d)) != PLFX_OK) {
        give_up("no such table");
    }
}

static void make_plan(scene *s, int views, int labels, int window)
{
    plfx_cfg c;
    int side = 1;
    int k;

    memset(&c, 0, sizeof c);
    while (side * side < views) {
        side += 2;
    }
    c.fit = PLFX_FIT_VEE;
    c.window = (uint8_t)window;
    c.bits = 10;
    c.n = (uint8_t)views;
    c.ref = (uint8_t)(views / 2);
    c.labels = (uint16_t)labels;
    c.slope_min_q16 = -16384;
    c.slope_max_q16 = 16384;
    for (k = 0; k < views; k++) {
        c.at[k].u_q8 = (int16_t)(768 * (k % side - side / 2));
        c.at[k].v_q8 = (int16_t)(768 * (k / side - side / 2));
    }
    if (plfx_plan_init(&s->plan, &c, &s->lut, s->lut.lattice.nx, s->lut.lattice.ny) !=
        PLFX_OK) {
        give_up("the plan does not fit");
    }
}

static plfx_map map_of(const plfx_plan *p)
{
    size_t n = (size_t)p->nx * (size_t)p->ny;
    plfx_map m = {malloc(4 * n), malloc(2 * n), NULL, malloc(n), p->nx, p->ny, p->nx};

    return m;
}

static void make_frame(scene *s)
{
    size_t n = plfx_raw_bytes(PLFX_RAW_MONO12P, s->lut.sensor_w, s->lut.sensor_h);
    uint8_t *bytes = malloc(n);
    uint32_t random = 1;
    size_t i;

    for (i = 0; bytes && i < n; i++) {
        random = random * 1664525u + 1013904223u;
        bytes[i] = (uint8_t)(random >> 24);
    }
    s->raw.bytes = bytes;
    s->raw.size = n;
    s->raw.format = PLFX_RAW_MONO12P;
    s->raw.bits = 12;
    s->raw.w = s->lut.sensor_w;
    s->raw.h = s->lut.sensor_h;
    s->tone = plfx_tone_unity(10);
    s->views.nx = s->plan.nx;
    s->views.ny = s->plan.ny;
    s->views.n = s->plan.cfg.n;
    s->views.px =
        malloc(2 * (size_t)s->plan.nx * (size_t)s->plan.ny * (size_t)s->plan.cfg.n);
    s->got = map_of(&s->plan);
    s->want = map_of(&s->plan);
}

/* Best times of extraction and matching by one thread of the core. */
static void core_times(scene *s, double *extract, double *match)
{
    size_t n = plfx_sweep_ws(&s->plan);
    void *ws = NULL;
    int k;

    *extract = *match = 1e9;
    if (posix_memalign(&ws, PLFX_ALIGN, n) != 0) {
        give_up("no memory");
    }
    for (k = 0; k < REPEATS; k++) {
        double t0 = seconds();
        double t1;
        if (plfx_view_all(&s->lut, &s->raw, &s->tone, s->plan.cfg.at, 0, &s->views) !=
            PLFX_OK) {
            give_up("views");
        }
        t1 = seconds();
        if (plfx_sweep(&s->plan, &s->views, &s->want, ws, n) != PLFX_OK) {
            give_up("sweep");
        }
        *extract = fmin(*extract, t1 - t0);
        *match = fmin(*match, seconds() - t1);
    }
    free(ws);
}

static void submit(plfx_cl *cl, const scene *s)
{
    if (plfx_cl_submit(cl, s->raw.bytes, s->raw.size) != PLFX_OK) {
        give_up(cl->message);
    }
}

static void fetch(plfx_cl *cl, const scene *s)
{
    if (plfx_cl_fetch(cl, &s->got) != PLFX_OK) {
        give_up(cl->message);
    }
}

/* Best time of a frame from submission to its map, nothing else in flight. */
static double one_at_a_time(plfx_cl *cl, const scene *s)
{
    double best = 1e9;
    int k;

    for (k = 0; k < REPEATS + 1; k++) { /* the first one compiles */
        double t = seconds();
        submit(cl, s);
        fetch(cl, s);
        best = k > 0 ? fmin(best, seconds() - t) : best;
    }
    return best;
}

/* Time a frame when the next is uploaded while the last is worked on. */
static double two_in_flight(plfx_cl *cl, const scene *s)
{
    double t;
    int k;

    submit(cl, s);
    t = seconds();
    for (k = 0; k < FRAMES; k++) {
        submit(cl, s);
        fetch(cl, s);
    }
    t = (seconds() - t) / FRAMES;
    fetch(cl, s);
    return t;
}

/* Bytes a second that the device reads and writes when it copies; 0: no answer. */
static double copy_speed(plfx_cl *cl)
{
    cl_int e = CL_SUCCESS;
    cl_mem from = clCreateBuffer(cl->context, CL_MEM_READ_WRITE, COPY, NULL, &e);
    cl_mem to =
        e ? NULL : clCreateBuffer(cl->context, CL_MEM_READ_WRITE, COPY, NULL, &e);
    double best = 0;
    int k;

    for (k = 0; k < REPEATS && e == CL_SUCCESS; k++) {
        cl_event done = NULL;
        cl_ulong t0 = 0;
        cl_ulong t1 = 0;
        e = clEnqueueCopyBuffer(cl->queue_work, from, to, 0, 0, COPY, 0, NULL, &done);
        e = e ? e : clWaitForEvents(1, &done);
        e = e ? e
              : clGetEventProfilingInfo(done, CL_PROFILING_COMMAND_START, sizeof t0,
                                        &t0, NULL);
        e = e ? e
              : clGetEventProfilingInfo(done, CL_PROFILING_COMMAND_END, sizeof t1, &t1,
                                        NULL);
        best = e == CL_SUCCESS && t1 > t0 ? fmax(best, 2e9 * COPY / (double)(t1 - t0))
                                          : best;
        if (done) {
            clReleaseEvent(done);
        }
    }
    if (from) {
        clReleaseMemObject(from);
    }
    if (to) {
        clReleaseMemObject(to);
    }
    return best;
}

/* Bytes that kernel k must read and write for one frame of the sweep, each element
 * once a launch. */
static double bytes_of(int k, const plfx_cl *cl, const scene *s)
{
    double lenses = (double)s->plan.nx * s->plan.ny;
    double views = s->plan.cfg.n;
    double pixels = (double)s->raw.w * s->raw.h;
    double padded = 2.0 * cl->params[CL_STRIDE] * s->plan.ny; /* of one view */
    double costs = 2.0 * cl->params[CL_WIDE] * s->plan.ny * s->plan.cfg.labels;

    switch (k) {
    case K_UNPACK:
        return (double)s->raw.size + 2 * pixels;
    case K_EXTRACT: /* four pixels a sample, or the whole frame */
        return fmin(2 * pixels, 8 * views * lenses) + 2 * views * lenses + 9 * lenses;
    case K_PAD:
        return 2 * views * lenses + views * padded;
    case K_SAD_ITEMS: /* the sum is written a view, and read but for the first */
        return (views - 1) * (2 * padded + costs) + (views - 2) * costs;
    case K_SAD_COLUMNS:
        return 2 * costs;
    case K_SAD_WINNERS:
        return costs + 21 * lenses;
    case K_REF_COLUMNS:
        return 14 * lenses;
    case K_FUSE:
        return 16 * lenses;
    default:
        return 0;
    }
}

static void print_kernels(plfx_cl *cl, const scene *s, double match)
{
    double copy = copy_speed(cl);
    double sum = 0;
    double sweep = 0;
    int k;

    cl->timing = 1;
    memset(cl->kernel_ns, 0, sizeof cl->kernel_ns);
    submit(cl, s);
    fetch(cl, s);
    printf("copying: %.1f GB/s read and written\n", 1e-9 * copy);
    printf("  %-16s %9s %9s %8s %6s\n", "kernel", "ms", "MB", "GB/s", "share");
    for (k = 0; k < K_COUNT; k++) {
        double ns = (double)cl->kernel_ns[k];
        double speed = ns > 0 ? 1e9 * bytes_of(k, cl, s) / ns : 0;
        if (ns > 0) {
            printf("  %-16s %9.3f %9.2f %8.1f %5.0f%%\n", plfx_cl_kernel_name[k],
                   1e-6 * ns, MEGA * bytes_of(k, cl, s), 1e-9 * speed,
                   copy > 0 ? 100 * speed / copy : 0);
            sum += ns;
            sweep += k >= K_PAD ? ns : 0;
        }
    }
    printf("  %-16s %9.3f, of which the sweep %.3f: %.2f of the core's time\n",
           "all kernels", 1e-6 * sum, 1e-6 * sweep, 1e-9 * sweep / match);
}

static size_t differing(const plfx_map *a, const plfx_map *b)
{
    size_t n = (size_t)a->w * (size_t)a->h;
    size_t count = 0;
    size_t i;

    for (i = 0; i < n; i++) {
        count += a->slope_q16[i] != b->slope_q16[i] ||
                 a->conf_u16[i] != b->conf_u16[i] || a->flags[i] != b->flags[i];
    }
    return count;
}

static void report(plfx_cl *cl, scene *s, const char *name)
{
    double extract;
    double match;
    double one = one_at_a_time(cl, s);
    double two = two_in_flight(cl, s);

    core_times(s, &extract, &match);
    printf("%s: raw %dx%d 12 bits packed, %dx%d lenses, %d views, %d labels, "
           "window %d\n",
           name, (int)s->raw.w, (int)s->raw.h, (int)s->plan.nx, (int)s->plan.ny,
           s->plan.cfg.n, s->plan.cfg.labels, s->plan.cfg.window);
    printf("core, one thread: views %.1f ms, sweep %.1f ms\n", 1e3 * extract,
           1e3 * match);
    printf("device: %.2f ms a frame one at a time, ratio to the core %.2f; two in "
           "flight %.2f ms, %.1f frames/s\n",
           1e3 * one, one / (extract + match), 1e3 * two, 1 / two);
    printf("a frame: %.2f MB up, %.2f MB down; %.1f MB of device memory; %zu differing "
           "words\n",
           MEGA * (double)cl->input_bytes, 7 * MEGA * s->plan.nx * s->plan.ny,
           MEGA * (double)cl->bytes, differing(&s->got, &s->want));
    print_kernels(cl, s, match);
}

int main(int argc, char **argv)
{
    static plfx_cl cl;
    static scene s;
    int device = argument(argc, argv, 1, 0);
    plfx_cl_input input;
    plfx_cl_info info;

    make_table(&s, argument(argc, argv, 2, 289), argument(argc, argv, 3, 193));
    make_plan(&s, argument(argc, argv, 4, 25), argument(argc, argv, 5, 32),
              argument(argc, argv, 6, 9));
    make_frame(&s);
    if (plfx_cl_describe(device, &info) != PLFX_OK) {
        printf("skipped: no OpenCL device\n");
        return 77;
    }
    memset(&input, 0, sizeof input);
    input.lut = &s.lut;
    input.format = s.raw.format;
    input.bits = s.raw.bits;
    input.tone = s.tone;
    if (plfx_cl_open(&cl, device, &s.plan, &input) != PLFX_OK) {
        give_up(cl.message);
    }
    report(&cl, &s, info.name);
    plfx_cl_close(&cl);
    return differing(&s.got, &s.want) != 0;
}
