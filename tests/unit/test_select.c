/* SPDX-License-Identifier: MIT
 * Winner, fit, margin, reciprocal root, and the helpers of fix.h. */
#include "suite.h"
#include "ref.h"
#include "kernels.h"
#include "rows.h"
#include "fix.h"

#include <math.h>

static void shifts_are_floors(void **state)
{
    (void)state;
    assert_int_equal(plfx_asr_i32(-1, 1), -1);
    assert_int_equal(plfx_asr_i32(-5, 1), -3);
    assert_int_equal(plfx_asr_i64(-((int64_t)1 << 40), 39), -2);
    assert_int_equal(plfx_round_shift_i64(-3, 1), -1);
    assert_int_equal(plfx_round_shift_i64(3, 1), 2);
    assert_int_equal(plfx_div_round_i64(5, 2), 3);
    assert_int_equal(plfx_div_round_i64(-5, 2), -3);
    assert_int_equal(plfx_sat_i32((int64_t)1 << 40), INT32_MAX);
    assert_int_equal(plfx_sat_i32(-((int64_t)1 << 40)), INT32_MIN);
    assert_int_equal(plfx_sat_i32(-7), -7);
    assert_int_equal(plfx_clamp_i32(7, 0, 5), 5);
    assert_int_equal(plfx_clamp_i32(-7, 0, 5), 0);
}

static void roots(void **state)
{
    ref_rng rng = {3};

    (void)state;
    for (uint32_t v = 0; v < 70000; v++) {
        uint32_t r = plfx_isqrt_u64(v);
        assert_true((uint64_t)r * r <= v && (uint64_t)(r + 1) * (r + 1) > v);
    }
    assert_int_equal(plfx_isqrt_u64(UINT64_MAX), UINT32_MAX);
    for (int i = 0; i < 64; i++) {
        assert_int_equal(plfx_log2_u64((uint64_t)1 << i), i);
        assert_int_equal(plfx_log2_u64(((uint64_t)1 << i) | (((uint64_t)1 << i) - 1)),
                         i);
    }
    for (int i = 0; i < 20000; i++) {
        uint64_t v =
            ((uint64_t)ref_next(&rng) << 20 | ref_next(&rng)) >> ref_range(&rng, 0, 51);
        plfx_rsqrt r = plfx_rsqrt_u64(v);
        if (v == 0) {
            assert_int_equal(r.g, 0);
        } else {
            double want = ldexp(1.0 / sqrt((double)v), 29 + r.exp);
            assert_true(fabs(r.g - want) < want * 6.1e-5);
            assert_in_range(r.g, 16384, 32768);
        }
    }
}

static void fits(void **state)
{
    uint16_t c[5] = {50, 30, 10, 14, 60};
    plfx_winner w = plfx_select(c, 5, 1, PLFX_FIT_PARABOLA);

    (void)state;
    assert_int_equal(w.label, 2);
    assert_int_equal(w.second, 50);
    assert_int_equal(w.frac_q4, 5); /* 8 * 16/24 = 5.33 */
    assert_int_equal(w.end, 0);
    w = plfx_select(c, 5, 1, PLFX_FIT_VEE);
    assert_int_equal(w.frac_q4, 6); /* 8 * 16/20 = 6.4 */
    c[1] = 14;
    c[3] = 30;
    assert_int_equal(plfx_select(c, 5, 1, PLFX_FIT_VEE).frac_q4, -6);
}

static void ends_and_ties(void **state)
{
    uint16_t rising[4] = {1, 5, 9, 9};
    uint16_t falling[4] = {9, 9, 5, 1};
    uint16_t flat[4] = {7, 7, 7, 7};
    uint16_t three[3] = {7, 2, 7};
    plfx_winner w = plfx_select(rising, 4, 1, PLFX_FIT_VEE);

    (void)state;
    assert_int_equal(w.end, 1);
    assert_int_equal(w.frac_q4, 0);
    assert_int_equal(w.tie, 0);
    w = plfx_select(falling, 4, 1, PLFX_FIT_VEE);
    assert_int_equal(w.label, 3);
    assert_int_equal(w.end, 1);
    assert_int_equal(w.frac_q4, 0);
    w = plfx_select(flat, 4, 1, PLFX_FIT_VEE);
    assert_int_equal(w.label, 0);
    assert_int_equal(w.tie, 1);
    w = plfx_select(three, 3, 1, PLFX_FIT_VEE);
    assert_int_equal(w.second, w.best); /* no label is apart from the winner */
    assert_int_equal(w.tie, 0);
}

/* Extreme costs: the division never leaves its range. */
static void extremes(void **state)
{
    static const uint16_t v[] = {0, 1, 2, 16383, 16384, 32767, 32768, 65534, 65535};

    (void)state;
    for (size_t i = 0; i < sizeof v / sizeof v[0]; i++) {
        for (size_t j = 0; j < sizeof v / sizeof v[0]; j++) {
            uint16_t c[3] = {v[i], 0, v[j]};
            for (int32_t f = 0; f < 2; f++) {
                plfx_winner w = plfx_select(c, 3, 1, f);
                assert_true(w.frac_q4 >= -8 && w.frac_q4 <= 8);
            }
        }
    }
}

static void margins(void **state)
{
    (void)state;
    assert_int_equal(plfx_margin_u16(100, 100, 4), 0);
    assert_int_equal(plfx_margin_u16(0, 65535, 4), (255 << 8));
    assert_int_equal(plfx_margin_u16(0, 400, 400), 128 << 8);
    assert_int_equal(plfx_margin_u16(0, 0, 0), 0);
}

/* No rise at all is no fraction; a vertex by one side. */
static void vertices(void **state)
{
    (void)state;
    assert_int_equal(plfx_vertex_q4(0, 0, PLFX_FIT_PARABOLA), 0);
    assert_int_equal(plfx_vertex_q4(0, 0, PLFX_FIT_VEE), 0);
    assert_int_equal(plfx_vertex_q4(0, 9, PLFX_FIT_VEE), 8);
    assert_int_equal(plfx_vertex_q4(65535, 0, PLFX_FIT_PARABOLA), -8);
}

/* Baselines squared in 1/64 px^2 are held within 16 bits, from 1 on. */
static void weights_of_baselines(void **state)
{
    static plfx_plan plan;

    (void)state;
    plan.du_q8[0] = 256;
    plan.dv_q8[0] = -256;
    plan.du_q8[1] = 1;
    plan.dv_q8[2] = -8192;
    plan.du_q8[3] = 65535;
    plan.dv_q8[3] = 65535;
    assert_int_equal(plfx_baseline_weight(&plan, 0), 128);
    assert_int_equal(plfx_baseline_weight(&plan, 1), 1);
    assert_int_equal(plfx_baseline_weight(&plan, 2), 65535);
    assert_int_equal(plfx_baseline_weight(&plan, 3), 65535);
}

#if PLFX_LANES > 1
#define MOST 70 /* blocks: runs of 16 four times, and what they leave */

/* Rows into stripes and back, the samples asked for and none behind them. */
static void stripes_turn_back(void **state)
{
    static int16_t lin[MOST * PLFX_LANES];
    static int16_t striped[MOST * PLFX_LANES];
    static int16_t back[MOST * PLFX_LANES + 1];
    int32_t blocks;
    int32_t i;

    (void)state;
    for (i = 0; i < MOST * PLFX_LANES; i++) {
        lin[i] = (int16_t)(i * 29 - 20000);
    }
    for (blocks = 1; blocks <= MOST; blocks++) {
        int32_t all = blocks * PLFX_LANES;
        int32_t less;
        plfx_k_stripe(lin, blocks, striped);
        for (i = 0; i < all; i++) {
            assert_int_equal(striped[i], lin[i % PLFX_LANES * blocks + i / PLFX_LANES]);
        }
        for (less = 0; less < all && less < 40; less++) {
            memset(back, 0x55, sizeof back);
            plfx_k_unstripe(striped, blocks, all - less, back);
            assert_memory_equal(back, lin, (size_t)(all - less) * sizeof(int16_t));
            assert_int_equal(back[all - less], 0x5555);
        }
    }
}
#endif

static const struct CMUnitTest tests[] = {
#if PLFX_LANES > 1
    cmocka_unit_test(stripes_turn_back),
#endif
    cmocka_unit_test(shifts_are_floors),
    cmocka_unit_test(roots),
    cmocka_unit_test(fits),
    cmocka_unit_test(ends_and_ties),
    cmocka_unit_test(extremes),
    cmocka_unit_test(margins),
    cmocka_unit_test(vertices),
    cmocka_unit_test(weights_of_baselines),
};

SUITE(tests)
