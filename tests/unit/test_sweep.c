/* SPDX-License-Identifier: MIT
 * plfx_sweep() against the brute-force reference, and its properties. */
#include "suite.h"
#include "ref.h"
#include "rows.h"
#include "sweep_state.h"

#define MAX_SIDE     24
#define MAX_CELLS    (MAX_SIDE * MAX_SIDE)
#define PLANES_CELLS MAX_CELLS
#define MAX_N        5
#define WS_BYTES     (512 * 1024)

#include "planes.h"

static uint16_t samples[MAX_CELLS * MAX_N];
static unsigned char ws_memory[WS_BYTES + 64];

static unsigned char *workspace(void)
{
    return aligned(ws_memory);
}

/* Views apart by whole columns along the labels: kernels of their own. */
static void make_whole(plfx_cfg *c, ref_rng *rng)
{
    c->labels = (uint16_t)ref_range(rng, 3, 7);
    for (int32_t k = 0; k < c->n; k++) {
        c->at[k].u_q8 = (int16_t)(256 * ref_range(rng, -2, 2));
        c->at[k].v_q8 = 0;
    }
    c->at[c->ref].u_q8 = 0;
    if (c->n > 2 && ref_range(rng, 0, 1)) { /* one pair of another kind among them */
        int32_t k = (c->ref + 1) % c->n;
        c->at[k].v_q8 = (int16_t)(100 * ref_range(rng, 0, 3));
        c->at[k].u_q8 = (int16_t)(c->at[k].u_q8 + 77);
    }
    c->slope_min_q16 = 65536 * ref_range(rng, -2, 1);
    c->slope_max_q16 = c->slope_min_q16 + 65536 * (c->labels - 1);
}

static plfx_cfg random_cfg(ref_rng *rng)
{
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.method = (uint8_t)ref_range(rng, 0, 1);
    c.cost = (uint8_t)(c.method == PLFX_METHOD_PAIRS ? ref_range(rng, 0, 1) : 0);
    c.fit = (uint8_t)ref_range(rng, 0, 1);
    c.fuse = (uint8_t)ref_range(rng, 0, 1);
    c.window = (uint8_t)(2 * ref_range(rng, 1, 3) + 1);
    c.bits = (uint8_t)ref_range(rng, 8, 12);
    c.n = (uint8_t)ref_range(rng, 2, MAX_N);
    c.ref = (uint8_t)ref_range(rng, 0, c.n - 1);
    c.labels = (uint16_t)ref_range(rng, 3, 9);
    c.texture = (uint16_t)(ref_range(rng, 0, 2) == 0 ? ref_range(rng, 0, 3000) : 0);
    c.unique_u16 = (uint16_t)(ref_range(rng, 0, 2) == 0 ? ref_range(rng, 0, 20000) : 0);
    c.slope_min_q16 = ref_range(rng, -40000, 0);
    c.slope_max_q16 = c.slope_min_q16 + ref_range(rng, 100, 60000);
    for (int32_t k = 0; k < c.n; k++) {
        c.at[k].u_q8 = (int16_t)ref_range(rng, -1000, 1000);
        c.at[k].v_q8 =
            (int16_t)(ref_range(rng, 0, 1) ? ref_range(rng, -1000, 1000) : 0);
    }
    if (ref_range(rng, 0, 3) == 0) {
        make_whole(&c, rng);
        c.bits =
            (uint8_t)(c.cost == PLFX_COST_ZNCC && ref_range(rng, 0, 2) ? 8 : c.bits);
    }
    return c;
}

/* Smooth, noisy, constant and extreme blocks in turn. */
static plfx_views random_views(ref_rng *rng, const plfx_plan *plan)
{
    plfx_views v = {samples, plan->nx, plan->ny, plan->cfg.n};
    int32_t top = (1 << plan->cfg.bits) - 1;
    int32_t kind = ref_range(rng, 0, 4);
    int32_t level = ref_range(rng, 0, top);
    size_t n = (size_t)v.nx * (size_t)v.ny * (size_t)v.n;

    for (size_t i = 0; i < n; i++) {
        int32_t s = kind == 0   ? level
                    : kind == 1 ? (ref_range(rng, 0, 1) ? top : 0)
                    : kind == 2 ? level + ref_range(rng, -3, 3)
                                : ref_range(rng, 0, top);
        samples[i] = (uint16_t)(s < 0 ? 0 : s > top ? top : s);
    }
    return v;
}

static void compare(const plfx_plan *plan, uint32_t seed)
{
    for (int32_t i = 0; i < plan->nx * plan->ny; i++) {
        if (got.slope[i] != want.slope[i] || got.conf[i] != want.conf[i] ||
            got.flags[i] != want.flags[i]) {
            fail_msg(
                "seed %u (%d,%d) of %dx%d method %d cost %d: slope %d/%d conf %u/%u "
                "flags %u/%u",
                (unsigned)seed, (int)(i % plan->nx), (int)(i / plan->nx), (int)plan->nx,
                (int)plan->ny, plan->cfg.method, plan->cfg.cost, (int)got.slope[i],
                (int)want.slope[i], got.conf[i], want.conf[i], got.flags[i],
                want.flags[i]);
        }
        assert_int_equal(got.sigma[i], PLFX_SIGMA_NONE);
    }
}

static int one_case(uint32_t seed)
{
    ref_rng rng = {seed};
    plfx_cfg cfg = random_cfg(&rng);
    plfx_plan plan;
    plfx_views views;
    plfx_map g;
    plfx_map w;

    if (plfx_plan_init(&plan, &cfg, NULL, ref_range(&rng, 7, MAX_SIDE),
                       ref_range(&rng, 7, 12)) != PLFX_OK) {
        return 0;
    }
    plan.hex = ref_range(&rng, 0, 1);
    plan.odd_q4 = plan.hex ? ref_range(&rng, -9, 9) : 0;
    plan.row_q16 = plan.hex ? 75674 : 65536;
    views = random_views(&rng, &plan);
    g = map_of(&got, &plan);
    w = map_of(&want, &plan);
    assert_true(plfx_sweep_ws(&plan) <= WS_BYTES);
    memset(workspace(), (int)(seed & 255), plfx_sweep_ws(&plan));
    assert_int_equal(plfx_sweep(&plan, &views, &g, workspace(), plfx_sweep_ws(&plan)),
                     PLFX_OK);
    ref_sweep(&plan, &views, &w);
    compare(&plan, seed);
    return 1;
}

static void equals_reference(void **state)
{
    int run = 0;

    (void)state;
    for (uint32_t seed = 1; seed <= 400; seed++) {
        run += one_case(seed);
    }
    assert_true(run > 200); /* the rest were plans that do not fit */
}

/* Bands of any height, and rows outside a band untouched. */
static void bands_equal_the_whole(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 200; seed++) {
        ref_rng rng = {seed};
        plfx_cfg cfg = random_cfg(&rng);
        plfx_plan plan;
        plfx_views v;
        plfx_map g;
        plfx_map w;
        if (plfx_plan_init(&plan, &cfg, NULL, ref_range(&rng, 7, MAX_SIDE), 12) !=
            PLFX_OK) {
            continue;
        }
        v = random_views(&rng, &plan);
        g = map_of(&got, &plan);
        w = map_of(&want, &plan);
        assert_int_equal(plfx_sweep(&plan, &v, &w, workspace(), WS_BYTES), PLFX_OK);
        memset(&got, 0x5a, sizeof got);
        for (int32_t j = 0; j < 12;) {
            int32_t end = ref_range(&rng, j, 12);
            assert_int_equal(
                plfx_sweep_rows(&plan, &v, j, end, &g, workspace(), WS_BYTES), PLFX_OK);
            for (int32_t i = end * plan.nx; i < 12 * plan.nx; i++) {
                assert_int_equal(got.flags[i], 0x5a);
            }
            j = end;
        }
        compare(&plan, seed);
        assert_int_equal(plfx_sweep_rows(&plan, &v, -1, 3, &g, workspace(), WS_BYTES),
                         PLFX_E_ARG);
        assert_int_equal(plfx_sweep_rows(&plan, &v, 4, 3, &g, workspace(), WS_BYTES),
                         PLFX_E_ARG);
        assert_int_equal(plfx_sweep_rows(&plan, &v, 4, 13, &g, workspace(), WS_BYTES),
                         PLFX_E_ARG);
    }
}

static plfx_plan pair_plan(int32_t method, int32_t cost, int32_t sign)
{
    plfx_cfg c;
    plfx_plan plan;

    memset(&c, 0, sizeof c);
    c.method = (uint8_t)method;
    c.cost = (uint8_t)cost;
    c.window = 5;
    c.bits = 10;
    c.n = 2;
    c.labels = 9;
    c.slope_min_q16 = -65536;
    c.slope_max_q16 = 65536;
    c.at[1].u_q8 = (int16_t)(sign * 1024); /* 4 px: a label is one column */
    assert_int_equal(plfx_plan_init(&plan, &c, NULL, MAX_SIDE, 12), PLFX_OK);
    return plan;
}

static void shifted_views(int32_t shift)
{
    ref_rng rng = {7};

    for (int32_t j = 0; j < 12; j++) {
        uint16_t *a = samples + (size_t)j * 2 * MAX_SIDE;
        for (int32_t i = 0; i < MAX_SIDE; i++) {
            a[i] = (uint16_t)ref_range(&rng, 0, 1023);
        }
        for (int32_t i = 0; i < MAX_SIDE; i++) {
            int32_t from = i - shift;
            a[MAX_SIDE + i] = from >= 0 && from < MAX_SIDE ? a[from] : 0;
        }
    }
}

/* The image moves by +2 columns for +4 px of u: slope +1/2, seen from either side. */
static void shift_gives_slope(void **state)
{
    (void)state;
    for (int32_t cost = 0; cost < 2; cost++) {
        for (int32_t sign = -1; sign <= 1; sign += 2) {
            plfx_plan plan = pair_plan(PLFX_METHOD_PAIRS, cost, sign);
            plfx_views v = {samples, MAX_SIDE, 12, 2};
            plfx_map m = map_of(&got, &plan);
            shifted_views(2);
            assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_OK);
            assert_int_equal(got.slope[5 * MAX_SIDE + 10], sign * 32768);
            assert_true(got.conf[5 * MAX_SIDE + 10] > 32768);
        }
    }
}

/* Zero-mean NCC does not see gain and offset. */
static void zncc_ignores_gain(void **state)
{
    plfx_plan plan = pair_plan(PLFX_METHOD_PAIRS, PLFX_COST_ZNCC, 1);
    plfx_views v = {samples, MAX_SIDE, 12, 2};
    plfx_map m = map_of(&got, &plan);

    (void)state;
    shifted_views(1);
    for (int32_t j = 0; j < 12; j++) {
        uint16_t *b = samples + (size_t)j * 2 * MAX_SIDE + MAX_SIDE;
        for (int32_t i = 0; i < MAX_SIDE; i++) {
            b[i] = (uint16_t)(b[i] / 2 + 300);
        }
    }
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_OK);
    for (int32_t x = 5; x < MAX_SIDE - 5; x++) {
        assert_in_range(got.slope[6 * MAX_SIDE + x] + 65536, 65536 + 16384 - 3000,
                        65536 + 16384 + 3000);
    }
}

static void workspace_is_exact(void **state)
{
    plfx_plan plan = pair_plan(PLFX_METHOD_SWEEP, PLFX_COST_SAD, 1);
    plfx_views v = {samples, MAX_SIDE, 12, 2};
    plfx_map m = map_of(&got, &plan);
    size_t need = plfx_sweep_ws(&plan);
    unsigned char *ws = workspace();

    (void)state;
    shifted_views(1);
    memset(ws + need, 0xa5, 64);
    assert_int_equal(plfx_sweep(&plan, &v, &m, ws, need), PLFX_OK);
    for (int i = 0; i < 64; i++) {
        assert_int_equal(ws[need + (size_t)i], 0xa5);
    }
    got.slope[0] = 12345;
    assert_int_equal(plfx_sweep(&plan, &v, &m, ws, need - 1), PLFX_E_SIZE);
    assert_int_equal(plfx_sweep(&plan, &v, &m, ws + 1, need + 63), PLFX_E_SIZE);
    assert_int_equal(plfx_sweep(&plan, &v, &m, NULL, need), PLFX_E_SIZE);
    assert_int_equal(got.slope[0], 12345);
}

static void bad_arguments(void **state)
{
    plfx_plan plan = pair_plan(PLFX_METHOD_SWEEP, PLFX_COST_SAD, 1);
    plfx_views v = {samples, MAX_SIDE, 12, 2};
    plfx_map m = map_of(&got, &plan);
    plfx_plan other = plan;

    (void)state;
    assert_int_equal(plfx_sweep(NULL, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    assert_int_equal(plfx_sweep(&plan, NULL, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    assert_int_equal(plfx_sweep(&plan, &v, NULL, workspace(), WS_BYTES), PLFX_E_ARG);
    other.cfg.method = PLFX_METHOD_GRADIENT;
    assert_int_equal(plfx_sweep(&other, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    v.n = 3;
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    v.n = 2;
    v.nx--;
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    v.nx++;
    v.ny--;
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    v.ny++;
    v.px = NULL;
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    v.px = samples;
    m.slope_q16 = NULL;
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    m.slope_q16 = got.slope;
    m.w--;
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    m.w++;
    m.h++;
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
    m.h--;
    m.stride--;
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
}

/* Planes other than the slope may be missing. */
static void optional_planes(void **state)
{
    plfx_plan plan = pair_plan(PLFX_METHOD_SWEEP, PLFX_COST_SAD, 1);
    plfx_views v = {samples, MAX_SIDE, 12, 2};
    plfx_map m = map_of(&got, &plan);
    plfx_map bare = {want.slope, NULL, NULL, NULL, plan.nx, plan.ny, plan.nx};

    (void)state;
    shifted_views(1);
    assert_int_equal(plfx_sweep(&plan, &v, &m, workspace(), WS_BYTES), PLFX_OK);
    assert_int_equal(plfx_sweep(&plan, &v, &bare, workspace(), WS_BYTES), PLFX_OK);
    assert_memory_equal(got.slope, want.slope,
                        sizeof(int32_t) * (size_t)(plan.nx * plan.ny));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(bands_equal_the_whole), cmocka_unit_test(equals_reference),
    cmocka_unit_test(shift_gives_slope),     cmocka_unit_test(zncc_ignores_gain),
    cmocka_unit_test(workspace_is_exact),    cmocka_unit_test(bad_arguments),
    cmocka_unit_test(optional_planes),
};

SUITE(tests)
