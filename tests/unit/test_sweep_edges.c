/* SPDX-License-Identifier: MIT
 * plfx_sweep() where its row kernels change their way: views above each other, rows
 * of whole runs of blocks, maps without confidence. */
#include "suite.h"
#include "ref.h"

#define NX           256 /* 16 blocks of 16 lanes, 32 of 8 */
#define NY           9
#define N            3
#define WS_BYTES     (384 * 1024)
#define PLANES_CELLS (NX * NY)

#include "planes.h"

static uint16_t samples[NX * NY * N];
static uint64_t memory[WS_BYTES / 8];

/* A sweep, pairs, or pairs by correlation, at whole columns. */
static plfx_cfg cfg_of(int32_t way, uint16_t labels)
{
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.method = way == 0 ? PLFX_METHOD_SWEEP : PLFX_METHOD_PAIRS;
    c.cost = way == 2 ? PLFX_COST_ZNCC : PLFX_COST_SAD;
    c.window = 3;
    c.bits = 8;
    c.n = 2;
    c.labels = labels;
    c.slope_min_q16 = -65536;
    c.slope_max_q16 = 65536 * (labels - 2);
    c.at[1].u_q8 = 256;
    return c;
}

static void sweep(const plfx_plan *plan, planes *to)
{
    plfx_views v = {samples, plan->nx, plan->ny, plan->cfg.n};
    plfx_map m = map_of(to, plan);

    assert_int_equal(plfx_sweep(plan, &v, &m, aligned(memory), WS_BYTES - 64), PLFX_OK);
}

static void against_reference(const plfx_plan *plan, uint32_t seed)
{
    plfx_views v = {samples, plan->nx, plan->ny, plan->cfg.n};
    plfx_map w = map_of(&want, plan);
    size_t n = (size_t)plan->nx * (size_t)plan->ny;
    size_t i;

    sweep(plan, &got);
    ref_sweep(plan, &v, &w);
    for (i = 0; i < n; i++) {
        if (got.slope[i] != want.slope[i] || got.conf[i] != want.conf[i] ||
            got.flags[i] != want.flags[i]) {
            fail_msg("seed %u sample %u method %d cost %d", (unsigned)seed, (unsigned)i,
                     plan->cfg.method, plan->cfg.cost);
        }
    }
}

static void fill(uint32_t seed, uint16_t top)
{
    ref_rng rng = {seed};

    for (size_t i = 0; i < NX * NY * N; i++) {
        samples[i] = (uint16_t)ref_range(&rng, 0, top);
    }
}

/* No view lies apart along the rows: texture counts across them alone. */
static void views_above_each_other(void **state)
{
    (void)state;
    for (int32_t way = 0; way < 3; way++) {
        for (uint32_t seed = 1; seed <= 4; seed++) {
            plfx_cfg c = cfg_of(way, 5);
            plfx_plan plan;
            c.n = N;
            c.at[1].u_q8 = 0;
            c.at[1].v_q8 = (int16_t)(100 * seed);
            c.at[2].v_q8 = (int16_t)(-90 * (int32_t)seed);
            c.texture = 400;
            c.slope_max_q16 = 65536;
            fill(seed, (uint16_t)(seed % 2 ? 255 : 60));
            assert_int_equal(plfx_plan_init(&plan, &c, NULL, 24, NY), PLFX_OK);
            against_reference(&plan, seed);
        }
    }
}

static void rows_of_whole_runs(void **state)
{
    (void)state;
    for (int32_t way = 0; way < 3; way++) {
        for (int32_t nx = NX - 16; nx <= NX; nx += 8) {
            plfx_cfg c = cfg_of(way, 4);
            plfx_plan plan;
            fill((uint32_t)nx, 255);
            assert_int_equal(plfx_plan_init(&plan, &c, NULL, nx, 5), PLFX_OK);
            against_reference(&plan, (uint32_t)nx);
        }
    }
}

/* A map of slopes alone is that of the whole map, for labels even and odd, with and
 * without a limit on confidence. */
static void maps_without_confidence(void **state)
{
    (void)state;
    for (int32_t way = 0; way < 3; way++) {
        for (uint16_t labels = 3; labels <= 8; labels++) {
            for (int32_t unique = 0; unique <= 20000; unique += 20000) {
                plfx_cfg c = cfg_of(way, labels);
                plfx_views v = {samples, 40, NY, 2};
                plfx_plan plan;
                plfx_map bare = {got.slope, NULL, NULL, NULL, 40, NY, 40};
                c.unique_u16 = (uint16_t)unique;
                fill(labels, 255);
                assert_int_equal(plfx_plan_init(&plan, &c, NULL, 40, NY), PLFX_OK);
                sweep(&plan, &want);
                assert_int_equal(
                    plfx_sweep(&plan, &v, &bare, aligned(memory), WS_BYTES - 64),
                    PLFX_OK);
                assert_memory_equal(got.slope, want.slope, 40 * NY * sizeof(int32_t));
            }
        }
    }
}

/* What lies behind the last label of a block is none.  It holds a sum of 2^15, which
 * at lens END - 1 is the least sum of label 0 alone: farther labels see brighter
 * columns. */
static void nothing_behind_the_labels_counts(void **state)
{
    enum { W = 40, END = 20 };

    (void)state;
    for (uint16_t labels = 4; labels <= 9; labels++) {
        plfx_cfg c = cfg_of(0, labels);
        plfx_views v = {samples, W, NY, 2};
        plfx_plan plan;
        plfx_map bare = {got.slope, NULL, NULL, NULL, W, NY, W};
        c.bits = 12;
        c.slope_min_q16 = 0;
        c.slope_max_q16 = 65536 * (labels - 1);
        for (int32_t i = 0; i < W * NY; i++) { /* rows of two views in turn */
            int32_t x = i % W;
            int32_t odd = x % 3 == 0 && i / W % 3 == 0;
            size_t at = (size_t)(2 * (i / W) * W + x);
            samples[at] = 0;
            samples[at + W] = (uint16_t)(x > END ? 4095 : 3641 - odd);
        }
        assert_int_equal(plfx_plan_init(&plan, &c, NULL, W, NY), PLFX_OK);
        assert_int_equal(plfx_sweep(&plan, &v, &bare, aligned(memory), WS_BYTES - 64),
                         PLFX_OK);
        for (int32_t y = 1; y < NY - 1; y++) {
            assert_int_equal(got.slope[y * W + END - 1], 0);
        }
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(views_above_each_other),
    cmocka_unit_test(rows_of_whole_runs),
    cmocka_unit_test(maps_without_confidence),
    cmocka_unit_test(nothing_behind_the_labels_counts),
};

SUITE(tests)
