/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "evaluate.h"

#define W 20
#define H 10
#define N (W * H)

/* Ten columns inside a border of 5, all rows but the border: no rows left above 10. */
static void border_and_mask_leave_out(void **state)
{
    float map[N] = {0};
    float truth[N] = {0};
    uint8_t mask[N];
    float error[N];
    uint8_t use[N];
    size_t untrue;
    int i;
    int used = 0;

    (void)state;
    memset(mask, 1, sizeof mask);
    mask[5 * W + 7] = 0;
    truth[5 * W + 8] = NAN;
    plft_errors(map, truth, mask, W, H, 4, error, use, &untrue);
    for (i = 0; i < N; i++) {
        used += use[i];
    }
    assert_int_equal(used, 12 * 2 - 2);
    assert_int_equal(untrue, 1);
}

static void figures_by_hand(void **state)
{
    /* errors 0, .02, -.05, .08 and a missing one */
    const float error[6] = {0.f, 0.02f, -0.05f, 0.08f, NAN, 9.f};
    const uint8_t use[6] = {1, 1, 1, 1, 1, 0};
    plft_figures f;

    (void)state;
    memset(&f, 0, sizeof f);
    assert_int_equal(plft_figures_of(error, use, 6, &f), 0);
    assert_int_equal(f.pixels, 5);
    assert_int_equal(f.missing, 1);
    assert_true(fabs(f.badpix[0] - 40) < 1e-9);
    assert_true(fabs(f.badpix[1] - 60) < 1e-9);
    assert_true(fabs(f.badpix[2] - 80) < 1e-9);
    assert_true(fabs(f.mse100 - 100 * (0.0004 + 0.0025 + 0.0064) / 4) < 1e-6);
    assert_true(fabs(f.q25_100 - 2) < 1e-5);
    assert_true(fabs(f.bias - 0.02) < 1e-6);
}

static void nothing_to_compare_is_an_error(void **state)
{
    const float error[2] = {NAN, 0.f};
    const uint8_t use[2] = {1, 0};
    plft_figures f;

    (void)state;
    memset(&f, 0, sizeof f);
    assert_int_equal(plft_figures_of(error, use, 2, &f), 1);
}

static void trust_orders_the_curve(void **state)
{
    float error[10];
    float trust[10];
    uint8_t use[10];
    double curve[PLFT_CURVE];
    int i;

    (void)state;
    for (i = 0; i < 10; i++) { /* the least trusted three are bad */
        error[i] = i < 3 ? 1.f : 0.f;
        trust[i] = (float)i;
        use[i] = 1;
    }
    trust[0] = NAN;
    assert_int_equal(plft_sparsify(error, use, trust, 10, 0.07, curve), 0);
    assert_true(fabs(curve[0] - 30) < 1e-9);
    assert_true(fabs(curve[1] - 100.0 * 2 / 9) < 1e-9);
    assert_true(fabs(curve[3]) < 1e-9);
    assert_true(fabs(curve[9]) < 1e-9);
}

static void true_sigma_has_ratio_one(void **state)
{
    float error[1000];
    float sigma[1000];
    uint8_t use[1000];
    int i;

    (void)state;
    for (i = 0; i < 1000; i++) { /* |error| uniform to 2 x 0.6745 sigma: median there */
        sigma[i] = 0.5f;
        error[i] = (float)(0.5 * 2 * 0.6745 * i / 999.0);
        use[i] = 1;
    }
    assert_true(fabs(plft_scatter_ratio(error, use, sigma, 1000) - 1) < 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(border_and_mask_leave_out),
        cmocka_unit_test(figures_by_hand),
        cmocka_unit_test(nothing_to_compare_is_an_error),
        cmocka_unit_test(trust_orders_the_curve),
        cmocka_unit_test(true_sigma_has_ratio_one),
    };

    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
