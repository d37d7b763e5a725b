/* SPDX-License-Identifier: MIT
 * The matcher with 1, 2, 4, 8, 16 and 32 lanes, over random geometries: the same bits
 * as the build's own lane count, which test_sweep holds against the reference. */
#include "suite.h"
#include "ref.h"

#define MAX_NX       70
#define MAX_NY       26
#define MAX_N        6
#define CELLS        (MAX_NX * MAX_NY)
#define PLANES_CELLS CELLS
#define WS_BYTES     (1024 * 1024)

#include "planes.h"

#define LANES_OF(n)                                                                    \
    size_t n##_sweep_ws(const plfx_plan *plan);                                        \
    plfx_status n##_sweep(const plfx_plan *plan, const plfx_views *views,              \
                          const plfx_map *out, void *ws, size_t ws_size)
LANES_OF(lanes1);
LANES_OF(lanes2);
LANES_OF(lanes4);
LANES_OF(lanes8);
LANES_OF(lanes16);
LANES_OF(lanes32);
#if defined(LANES_AVX2)
LANES_OF(lanesavx2);
#endif

static const struct variant {
    size_t (*ws)(const plfx_plan *plan);
    plfx_status (*sweep)(const plfx_plan *plan, const plfx_views *views,
                         const plfx_map *out, void *ws, size_t ws_size);
} variants[] = {
    {lanes1_sweep_ws, lanes1_sweep},       {lanes2_sweep_ws, lanes2_sweep},
    {lanes4_sweep_ws, lanes4_sweep},       {lanes8_sweep_ws, lanes8_sweep},
    {lanes16_sweep_ws, lanes16_sweep},     {lanes32_sweep_ws, lanes32_sweep},
#if defined(LANES_AVX2)
    {lanesavx2_sweep_ws, lanesavx2_sweep}, /* the last: left out where it cannot run */
#endif
};

static uint16_t samples[CELLS * MAX_N];
static unsigned char memory[WS_BYTES + 64];

static unsigned char *workspace(void)
{
    return memory + (64 - (uintptr_t)memory % 64) % 64;
}

/* Pairs that move by whole columns have kernels of their own. */
static void make_whole(plfx_cfg *c, ref_rng *rng)
{
    c->n = 2;
    c->ref = 0;
    c->labels = (uint16_t)ref_range(rng, 3, 8);
    c->at[0].u_q8 = 0;
    c->at[0].v_q8 = 0;
    c->at[1].u_q8 = (int16_t)(ref_range(rng, 0, 1) ? 256 : -512);
    c->at[1].v_q8 = 0;
    c->slope_min_q16 = 65536 * ref_range(rng, -2, 1);
    c->slope_max_q16 = c->slope_min_q16 + 65536 * (c->labels - 1);
}

static plfx_cfg random_cfg(ref_rng *rng)
{
    int32_t across = ref_range(rng, 0, 1);
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.method = (uint8_t)ref_range(rng, 0, 1);
    c.cost = (uint8_t)(c.method == PLFX_METHOD_PAIRS ? ref_range(rng, 0, 1) : 0);
    c.fit = (uint8_t)ref_range(rng, 0, 1);
    c.fuse = (uint8_t)ref_range(rng, 0, 1);
    c.window = (uint8_t)(2 * ref_range(rng, 1, ref_range(rng, 0, 1) ? 4 : 11) + 1);
    c.bits = (uint8_t)ref_range(rng, 8, 12);
    c.n = (uint8_t)ref_range(rng, 2, MAX_N);
    c.ref = (uint8_t)ref_range(rng, 0, c.n - 1);
    c.labels = (uint16_t)ref_range(rng, 3, 12);
    c.texture = (uint16_t)(ref_range(rng, 0, 1) ? ref_range(rng, 1, 3000) : 0);
    c.unique_u16 = (uint16_t)(ref_range(rng, 0, 1) ? ref_range(rng, 0, 30000) : 0);
    c.slope_min_q16 = ref_range(rng, -60000, 30000);
    c.slope_max_q16 = c.slope_min_q16 + ref_range(rng, 1, 80000);
    for (int32_t k = 0; k < c.n; k++) {
        c.at[k].u_q8 = (int16_t)ref_range(rng, -1000, 1000);
        c.at[k].v_q8 = (int16_t)(across ? ref_range(rng, -700, 700) : 0);
    }
    if (ref_range(rng, 0, 2) == 0) {
        make_whole(&c, rng);
    }
    return c;
}

static void fill(ref_rng *rng, const plfx_plan *plan)
{
    int32_t top = (1 << plan->cfg.bits) - 1;
    int32_t kind = ref_range(rng, 0, 3);
    size_t n = (size_t)plan->nx * (size_t)plan->ny * plan->cfg.n;

    for (size_t i = 0; i < n; i++) {
        int32_t s = kind == 0   ? (ref_range(rng, 0, 1) ? top : 0)
                    : kind == 1 ? ref_range(rng, 0, 3)
                                : ref_range(rng, 0, top);
        samples[i] = (uint16_t)s;
    }
}

static void compare(const plfx_plan *plan, size_t v, unsigned seed)
{
    size_t n = (size_t)plan->nx * (size_t)plan->ny;

    for (size_t i = 0; i < n; i++) {
        if (got.slope[i] != want.slope[i] || got.conf[i] != want.conf[i] ||
            got.flags[i] != want.flags[i]) {
            fail_msg("variant %u seed %u sample %u of %dx%d: slope %d/%d conf %u/%u "
                     "flags %u/%u",
                     (unsigned)v, seed, (unsigned)i, (int)plan->nx, (int)plan->ny,
                     (int)got.slope[i], (int)want.slope[i], got.conf[i], want.conf[i],
                     got.flags[i], want.flags[i]);
        }
    }
}

static size_t usable(void)
{
    size_t n = sizeof variants / sizeof *variants;

#if defined(LANES_AVX2)
    n -= __builtin_cpu_supports("avx2") ? 0u : 1u;
#endif
    return n;
}

static int one_case(uint32_t seed)
{
    ref_rng rng = {seed};
    plfx_cfg cfg = random_cfg(&rng);
    plfx_plan plan;
    plfx_views views = {samples, ref_range(&rng, 3, MAX_NX), ref_range(&rng, 3, MAX_NY),
                        cfg.n};
    plfx_map g;
    plfx_map w;

    if (plfx_plan_init(&plan, &cfg, NULL, views.nx, views.ny) != PLFX_OK) {
        return 0;
    }
    plan.hex = ref_range(&rng, 0, 1);
    plan.odd_q4 = plan.hex ? ref_range(&rng, -9, 9) : 0;
    fill(&rng, &plan);
    g = map_of(&got, &plan);
    w = map_of(&want, &plan);
    assert_true(plfx_sweep_ws(&plan) <= WS_BYTES);
    assert_int_equal(plfx_sweep(&plan, &views, &w, workspace(), WS_BYTES), PLFX_OK);
    for (size_t v = 0; v < usable(); v++) {
        size_t need = variants[v].ws(&plan);
        assert_true(need <= WS_BYTES);
        memset(workspace(), (int)(seed & 255), need);
        memset(&got, 0x5a, sizeof got);
        assert_int_equal(variants[v].sweep(&plan, &views, &g, workspace(), need),
                         PLFX_OK);
        compare(&plan, v, seed);
    }
    return 1;
}

static void all_lanes_agree(void **state)
{
    int run = 0;

    (void)state;
    for (uint32_t seed = 1; seed <= 2000; seed++) {
        run += one_case(seed);
    }
    print_message("# %d geometries\n", run);
    assert_true(run >= 1000); /* the rest were plans that do not fit */
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(all_lanes_agree),
};

SUITE(tests)
