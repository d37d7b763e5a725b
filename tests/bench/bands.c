/* SPDX-License-Identifier: MIT
 * Two bands of rows on two threads against one, as examples/two_threads.c cuts them,
 * and equal maps.  Two ratios, the best of many rounds taken in turn: of wall time,
 * which asks for two idle processors, and of processor time over that of the slower
 * band, which two busy ones blur less; it is what wall time becomes on an idle machine,
 * and is judged.
 *
 * usage: bench_bands [ROUNDS]    status 1 under 1.8 times the speed, or when maps
 * differ; status 77 (skipped) with one processor. */
#define _POSIX_C_SOURCE 200809L
#include <plenofix/plenofix.h>

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define NX      640
#define NY      480
#define LABELS  64
#define ASKED   1.8
#define SKIPPED 77

typedef struct band {
    const plfx_plan *plan;
    const plfx_views *views;
    const plfx_map *map;
    int32_t j0, j1;
    void *ws;
    size_t size;
} band;

typedef struct helper { /* a thread that waits for bands */
    pthread_barrier_t gate;
    band job;
    double cpu; /* ms of the last band */
    int ends, bad;
} helper;

static double ms_of(clockid_t clock)
{
    struct timespec t;

    clock_gettime(clock, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* 0 when the call fails; *cpu: processor time, ms. */
static int match(const band *b, double *cpu)
{
    double start = ms_of(CLOCK_THREAD_CPUTIME_ID);
    plfx_status status =
        plfx_sweep_rows(b->plan, b->views, b->j0, b->j1, b->map, b->ws, b->size);

    *cpu = ms_of(CLOCK_THREAD_CPUTIME_ID) - start;
    return status == PLFX_OK;
}

static void *help(void *argument)
{
    helper *h = argument;

    for (;;) { /* until told to end */
        pthread_barrier_wait(&h->gate);
        if (h->ends) {
            return NULL;
        }
        h->bad |= !match(&h->job, &h->cpu);
        pthread_barrier_wait(&h->gate);
    }
}

static plfx_status make_plan(plfx_plan *plan)
{
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.window = 9;
    c.bits = 8;
    c.n = 2;
    c.labels = LABELS;
    c.slope_max_q16 = (LABELS - 1) * 65536 / 16;
    c.at[1].u_q8 = 16 * 256;
    return plfx_plan_init(plan, &c, NULL, NX, NY);
}

static void draw(uint16_t *px)
{
    uint32_t seed = 1;

    for (int32_t j = 0; j < NY; j++) {
        uint16_t *a = px + (size_t)j * 2 * NX;
        for (int32_t i = 0; i < NX; i++) {
            seed = seed * 1664525u + 1013904223u;
            a[i] = (uint16_t)(seed >> 24);
        }
        for (int32_t i = 0; i < NX; i++) {
            a[NX + i] = a[i < 5 ? 0 : i - 5];
        }
    }
}

static void *workspace(size_t size)
{
    void *p = NULL;

    return posix_memalign(&p, PLFX_ALIGN, size) == 0 ? p : NULL;
}

typedef struct times {
    double one, two;         /* wall */
    double one_cpu, two_cpu; /* processor, of the slower band */
} times;

/* Both ways in turn; the map of one thread goes to `one`, of two to `two`. */
static int measure(helper *h, band whole, const plfx_map *two, int rounds, times *best)
{
    band upper = whole;

    upper.map = two;
    upper.j1 = NY / 2;
    for (int i = 0; i < rounds; i++) {
        double start = ms_of(CLOCK_MONOTONIC);
        double cpu = 0;
        int ok = match(&whole, &cpu);
        double middle = ms_of(CLOCK_MONOTONIC);
        best->one_cpu = fmin(best->one_cpu, cpu);
        pthread_barrier_wait(&h->gate);
        ok = match(&upper, &cpu) && ok;
        pthread_barrier_wait(&h->gate);
        best->one = fmin(best->one, middle - start);
        best->two = fmin(best->two, ms_of(CLOCK_MONOTONIC) - middle);
        best->two_cpu = fmin(best->two_cpu, fmax(cpu, h->cpu));
        if (!ok || h->bad) {
            return 0;
        }
    }
    return 1;
}

int main(int argc, char **argv)
{
    static uint16_t px[NX * NY * 2];
    static int32_t slopes[2][NX * NY];
    int rounds = argc > 1 ? atoi(argv[1]) : 300;
    plfx_views views = {px, NX, NY, 2};
    plfx_map one = {slopes[0], NULL, NULL, NULL, NX, NY, NX};
    plfx_map two = {slopes[1], NULL, NULL, NULL, NX, NY, NX};
    times best = {INFINITY, INFINITY, INFINITY, INFINITY};
    band whole = {NULL, &views, &one, 0, NY, NULL, 0};
    helper h;
    pthread_t thread;
    plfx_plan plan;
    int ok;

    if (sysconf(_SC_NPROCESSORS_ONLN) < 2) {
        printf("skipped: one processor\n");
        return SKIPPED;
    }
    draw(px);
    if (make_plan(&plan) != PLFX_OK) {
        return EXIT_FAILURE;
    }
    whole.plan = &plan;
    whole.size = plfx_sweep_ws(&plan);
    whole.ws = workspace(whole.size);
    h.job = whole;
    h.job.map = &two;
    h.job.j0 = NY / 2;
    h.job.ws = workspace(whole.size);
    h.ends = 0;
    h.bad = 0;
    if (!whole.ws || !h.job.ws || pthread_barrier_init(&h.gate, NULL, 2) != 0 ||
        pthread_create(&thread, NULL, help, &h) != 0) {
        return EXIT_FAILURE;
    }
    ok = measure(&h, whole, &two, rounds, &best);
    h.ends = 1;
    pthread_barrier_wait(&h.gate);
    pthread_join(thread, NULL);
    ok = ok && memcmp(slopes[0], slopes[1], sizeof slopes[0]) == 0;
    printf("wall: one thread %.3f ms, two bands %.3f ms, %.2f x; processor: %.3f ms, "
           "slower band %.3f ms, %.2f x (asked %.1f); maps %s\n",
           best.one, best.two, best.one / best.two, best.one_cpu, best.two_cpu,
           best.one_cpu / best.two_cpu, ASKED, ok ? "equal" : "DIFFER");
    free(whole.ws);
    free(h.job.ws);
    return ok && best.one_cpu / best.two_cpu >= ASKED ? EXIT_SUCCESS : EXIT_FAILURE;
}
