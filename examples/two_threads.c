/* SPDX-License-Identifier: MIT
 * Two threads match one frame: each takes a band of map rows with a workspace of its
 * own and writes into the same map.  The result is that of one thread, to the bit.
 *
 *   cc -O3 two_threads.c $(pkg-config --cflags --libs plenofix) -lpthread */
#define _POSIX_C_SOURCE 200112L
#include <plenofix/plenofix.h>

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NX     320
#define NY     240
#define LABELS 17
#define BANDS  2

typedef struct band {
    const plfx_plan *plan;
    const plfx_views *views;
    const plfx_map *map;
    int32_t j0, j1;
    plfx_status status;
} band;

/* Workspaces need PLFX_ALIGN: take a little more and round up. */
static void *match_band(void *argument)
{
    band *b = argument;
    size_t size = plfx_sweep_ws(b->plan);
    unsigned char *raw = malloc(size + PLFX_ALIGN);

    b->status = PLFX_E_SIZE;
    if (raw) {
        unsigned char *ws =
            raw + (PLFX_ALIGN - (uintptr_t)raw % PLFX_ALIGN) % PLFX_ALIGN;
        b->status = plfx_sweep_rows(b->plan, b->views, b->j0, b->j1, b->map, ws, size);
    }
    free(raw);
    return NULL;
}

/* Two views of a textured plane, one column apart for each label. */
static plfx_status make_plan(plfx_plan *plan)
{
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.method = PLFX_METHOD_SWEEP;
    c.cost = PLFX_COST_SAD;
    c.fit = PLFX_FIT_VEE;
    c.window = 9;
    c.bits = 10;
    c.n = 2;
    c.labels = LABELS;
    c.slope_max_q16 = 2 * 65536;
    c.at[1].u_q8 = 8 * 256;
    return plfx_plan_init(plan, &c, NULL, NX, NY);
}

static void draw(uint16_t *px)
{
    uint32_t seed = 1;

    for (int32_t j = 0; j < NY; j++) {
        uint16_t *a = px + (size_t)j * 2 * NX;
        for (int32_t i = 0; i < NX; i++) {
            seed = seed * 1664525u + 1013904223u;
            a[i] = (uint16_t)(seed >> 22);
        }
        for (int32_t i = 0; i < NX; i++) {
            a[NX + i] = a[i < 5 ? 0 : i - 5]; /* five columns: slope 5/8 */
        }
    }
}

static int run(int32_t bands, const plfx_plan *plan, const plfx_views *views,
               const plfx_map *map)
{
    pthread_t thread[BANDS];
    band b[BANDS];
    int ok = 1;

    for (int32_t k = 0; k < bands; k++) {
        b[k].plan = plan;
        b[k].views = views;
        b[k].map = map;
        b[k].j0 = NY * k / bands;
        b[k].j1 = NY * (k + 1) / bands;
        if (pthread_create(&thread[k], NULL, match_band, &b[k]) != 0) {
            return 0;
        }
    }
    for (int32_t k = 0; k < bands; k++) {
        pthread_join(thread[k], NULL);
        ok = ok && b[k].status == PLFX_OK;
    }
    return ok;
}

int main(void)
{
    static uint16_t px[NX * NY * 2];
    static int32_t one[NX * NY], two[NX * NY];
    plfx_views views = {px, NX, NY, 2};
    plfx_map map = {one, NULL, NULL, NULL, NX, NY, NX};
    plfx_plan plan;

    draw(px);
    if (make_plan(&plan) != PLFX_OK || !run(1, &plan, &views, &map)) {
        return EXIT_FAILURE;
    }
    map.slope_q16 = two;
    if (!run(BANDS, &plan, &views, &map)) {
        return EXIT_FAILURE;
    }
    printf("slope at the middle: %.4f; bands %s\n", one[NY / 2 * NX + NX / 2] / 65536.0,
           memcmp(one, two, sizeof one) == 0 ? "equal" : "DIFFER");
    return memcmp(one, two, sizeof one) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
