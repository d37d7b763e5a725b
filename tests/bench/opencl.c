/* SPDX-License-Identifier: MIT
 * The dense sweep on an OpenCL device beside the core, in one process.
 * usage: opencl [DEVICE [LENSES_X LENSES_Y VIEWS LABELS WINDOW]]
 * Prints time a frame, time of each kernel by the device's own clock, bytes moved. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cl_state.h"
#include "plenofix/plenofix.h"

#define REPEATS 5

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

static plfx_plan plan_of(int nx, int ny, int views, int labels, int window)
{
    plfx_cfg c;
    plfx_plan p;
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
    if (plfx_plan_init(&p, &c, NULL, nx, ny) != PLFX_OK) {
        fprintf(stderr, "the plan does not fit\n");
        exit(1);
    }
    return p;
}

static uint16_t *noise(size_t n)
{
    uint16_t *px = malloc(2 * n);
    uint32_t s = 1;
    size_t i;

    for (i = 0; px && i < n; i++) {
        s = s * 1664525u + 1013904223u;
        px[i] = (uint16_t)(s >> 22);
    }
    return px;
}

static double core_time(const plfx_plan *p, const plfx_views *v, const plfx_map *m)
{
    size_t n = plfx_sweep_ws(p);
    void *ws = NULL;
    double best = 1e9;
    int k;

    if (posix_memalign(&ws, PLFX_ALIGN, n) != 0) {
        exit(1);
    }

    for (k = 0; k < REPEATS; k++) {
        double t = seconds();
        if (plfx_sweep(p, v, m, ws, n) != PLFX_OK) {
            exit(1);
        }
        t = seconds() - t;
        best = t < best ? t : best;
    }
    free(ws);
    return best;
}

static double device_time(plfx_cl *cl, const plfx_views *v, const plfx_map *m)
{
    size_t n = 2 * (size_t)v->nx * (size_t)v->ny * (size_t)v->n;
    double best = 1e9;
    int k;

    for (k = 0; k < REPEATS + 1; k++) { /* the first one compiles */
        double t = seconds();
        if (plfx_cl_submit(cl, v->px, n) != PLFX_OK ||
            plfx_cl_fetch(cl, m) != PLFX_OK) {
            fprintf(stderr, "%s\n", cl->message);
            exit(1);
        }
        t = seconds() - t;
        best = k > 0 && t < best ? t : best;
    }
    return best;
}

static void print_kernels(plfx_cl *cl, const plfx_views *v, const plfx_map *m)
{
    int k;

    cl->timing = 1;
    memset(cl->kernel_ns, 0, sizeof cl->kernel_ns);
    if (plfx_cl_submit(cl, v->px, cl->input_bytes) != PLFX_OK ||
        plfx_cl_fetch(cl, m) != PLFX_OK) {
        exit(1);
    }
    for (k = 0; k < K_COUNT; k++) {
        if (cl->kernel_ns[k] > 0) {
            printf("  %-18s %9.3f ms\n", plfx_cl_kernel_name[k],
                   1e-6 * (double)cl->kernel_ns[k]);
        }
    }
}

static plfx_map map_of(const plfx_plan *p)
{
    size_t n = (size_t)p->nx * (size_t)p->ny;
    plfx_map m = {malloc(4 * n), malloc(2 * n), NULL, malloc(n), p->nx, p->ny, p->nx};

    return m;
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

int main(int argc, char **argv)
{
    int nx = argument(argc, argv, 2, 289);
    int ny = argument(argc, argv, 3, 193);
    int views = argument(argc, argv, 4, 25);
    plfx_plan p =
        plan_of(nx, ny, views, argument(argc, argv, 5, 32), argument(argc, argv, 6, 9));
    plfx_views v = {NULL, nx, ny, views};
    plfx_map got = map_of(&p);
    plfx_map want = map_of(&p);
    static plfx_cl cl;
    plfx_cl_input input;
    plfx_cl_info info;
    double core;
    double device;

    v.px = noise((size_t)nx * (size_t)ny * (size_t)views);
    memset(&input, 0, sizeof input);
    if (plfx_cl_describe(argument(argc, argv, 1, 0), &info) != PLFX_OK) {
        printf("skipped: no OpenCL device\n");
        return 77;
    }
    if (plfx_cl_open(&cl, argument(argc, argv, 1, 0), &p, &input) != PLFX_OK) {
        fprintf(stderr, "%s\n", cl.message);
        return 1;
    }
    core = core_time(&p, &v, &want);
    device = device_time(&cl, &v, &got);
    printf("%s: %dx%d lenses, %d views, %d labels, window %d\n", info.name, nx, ny,
           views, p.cfg.labels, p.cfg.window);
    printf("core %.3f ms, device %.3f ms a frame, ratio %.2f; %.2f MB in, %.2f MB out; "
           "%.1f MB held; %zu differing words\n",
           1e3 * core, 1e3 * device, device / core, 1e-6 * (double)cl.input_bytes,
           7e-6 * nx * ny, 1e-6 * (double)cl.bytes, differing(&got, &want));
    print_kernels(&cl, &v, &got);
    plfx_cl_close(&cl);
    return 0;
}
