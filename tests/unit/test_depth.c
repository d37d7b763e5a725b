/* SPDX-License-Identifier: MIT */
#include "suite.h"
#include "ref.h"

/* inv0 0.5 dioptres (focus at 2 m), gain -2.2 dioptres a unit slope. */
static const plfx_optics optics = {8388608, -36909875};

static void focus_plane(void **state)
{
    (void)state;
    assert_int_equal(plfx_inv_depth_q24(&optics, 0), 8388608);
    assert_int_equal(plfx_depth_um(8388608), 2000000);
}

static void near_is_negative(void **state)
{
    (void)state;
    assert_true(plfx_depth_um(plfx_inv_depth_q24(&optics, -6554)) < 2000000);
    assert_true(plfx_depth_um(plfx_inv_depth_q24(&optics, 6554)) > 2000000);
}

static void against_double(void **state)
{
    ref_rng rng = {5};

    (void)state;
    for (int i = 0; i < 5000; i++) {
        int32_t s = ref_range(&rng, -60000, 12000);
        double inv =
            optics.inv0_q24 / 16777216.0 + optics.gain_q24 / 16777216.0 * (s / 65536.0);
        double got = plfx_depth_um(plfx_inv_depth_q24(&optics, s));
        double want = 1e6 / inv;
        assert_true(got - want < want * 1e-5 + 1 && want - got < want * 1e-5 + 1);
    }
}

static void limits(void **state)
{
    int32_t s[3] = {PLFX_SLOPE_NONE, 0, 40000};
    uint32_t um[3] = {1, 1, 1};
    plfx_optics steep = {0, (int64_t)1 << 38};

    (void)state;
    assert_int_equal(plfx_depth_um(0), UINT32_MAX);
    assert_int_equal(plfx_depth_um(-5), UINT32_MAX);
    assert_int_equal(plfx_depth_um(1), UINT32_MAX);
    assert_int_equal(plfx_depth_um(INT32_MAX), 7813);
    assert_int_equal(plfx_inv_depth_q24(&steep, 1 << 20), INT32_MAX);
    assert_int_equal(plfx_inv_depth_q24(&steep, -(1 << 20)), INT32_MIN);
    plfx_depth_row(&optics, s, 3, um);
    assert_int_equal(um[0], 0);
    assert_int_equal(um[1], 2000000);
    assert_int_equal(um[2], UINT32_MAX); /* beyond infinity */
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(focus_plane),
    cmocka_unit_test(near_is_negative),
    cmocka_unit_test(against_double),
    cmocka_unit_test(limits),
};

SUITE(tests)
