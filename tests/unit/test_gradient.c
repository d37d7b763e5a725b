/* SPDX-License-Identifier: MIT */
#include "suite.h"
#include "ref.h"

#include <math.h>

#define NX 40
#define NY 24
static uint16_t samples[NX * NY * 5];
static int32_t slope[NX * NY];
static uint16_t conf[NX * NY], sigma[NX * NY];
static uint8_t flags[NX * NY];
static unsigned char memory[NX * 48 + 16 * 128 + 64 + 16 * NX * 2];

static unsigned char *workspace(void)
{
    return aligned(memory);
}

static plfx_map map(void)
{
    plfx_map m = {slope, conf, sigma, flags, NX, NY, NX};

    return m;
}

static plfx_plan plan_of(int step_q8)
{
    plfx_cfg c;
    plfx_plan p;

    memset(&c, 0, sizeof c);
    c.method = PLFX_METHOD_GRADIENT;
    c.window = 7;
    c.bits = 12;
    c.n = 5;
    c.labels = 3;
    c.slope_max_q16 = 65536;
    c.at[1].u_q8 = (int16_t)-step_q8;
    c.at[2].u_q8 = (int16_t)step_q8;
    c.at[3].v_q8 = (int16_t)-step_q8;
    c.at[4].v_q8 = (int16_t)step_q8;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, NY), PLFX_OK);
    return p;
}

static double texture(double x, double y)
{
    return 2000 + 500 * sin(0.7 * x + 0.3 * y) + 400 * sin(0.5 * y - 0.4 * x + 1);
}

/* Views of a plane of slope d at offsets of `step` sensor pixels, column scale and
 * odd-row displacement of the lattice. */
static void render(const plfx_plan *p, double d, double step, double odd)
{
    static const int du[5] = {0, -1, 1, 0, 0};
    static const int dv[5] = {0, 0, 0, -1, 1};
    double row = 65536.0 / p->row_q16; /* row spacing in pitches */

    for (int j = 0; j < NY; j++) {
        for (int k = 0; k < 5; k++) {
            for (int i = 0; i < NX; i++) {
                double x = i + (j % 2 ? odd : 0) - d * step * du[k];
                double y = j * row - d * step * dv[k];
                samples[(j * 5 + k) * NX + i] = (uint16_t)(texture(x, y) + 0.5);
            }
        }
    }
}

static void expect(double d, double tolerance)
{
    for (int j = 4; j < NY - 4; j++) {
        for (int i = 4; i < NX - 4; i++) {
            double got = slope[j * NX + i] / 65536.0;
            if (fabs(got - d) > tolerance) {
                fail_msg("(%d,%d): %f, not %f", i, j, got, d);
            }
        }
    }
}

static void planes(void **state)
{
    static const double d[] = {-0.15, -0.05, 0, 0.08, 0.15};
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    for (size_t i = 0; i < 5; i++) {
        render(&p, d[i], 2, 0);
        assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                         PLFX_OK);
        expect(d[i], 0.004);
    }
    assert_int_equal(flags[0], PLFX_FLAG_EDGE);
    assert_int_equal(slope[3 * NX + 10], PLFX_SLOPE_NONE);
    assert_int_equal(flags[4 * NX + 4], 0);
    assert_int_equal(flags[4 * NX + NX - 4], PLFX_FLAG_EDGE);
    assert_int_equal(sigma[0], PLFX_SIGMA_NONE);
}

/* A ramp of one count a column and one of sixteen, displaced by a column for two
 * pixels: window sums within 31 bits and beyond. */
static void faint_and_steep_ramps_have_one_slope(void **state)
{
    static const int32_t du[5] = {0, -1, 1, 0, 0};
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    for (int32_t steep = 1; steep <= 16; steep += 15) {
        for (int32_t i = 0; i < NX * NY * 5; i++) {
            samples[i] = (uint16_t)(1000 + steep * (i % NX - du[i / NX % 5]));
        }
        assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                         PLFX_OK);
        expect(0.5, 0.01);
    }
}

static void hexagonal_plane(void **state)
{
    plfx_plan p = plan_of(256);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    p.hex = 1;
    p.odd_q4 = 8;
    p.row_q16 = 75674;
    render(&p, 0.1, 1, 0.5);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    expect(0.1, 0.01);
}

static void opposite_order_negates(void **state)
{
    plfx_plan p = plan_of(-512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    render(&p, 0.1, -2, 0);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    expect(0.1, 0.003);
}

static void flat_is_missing(void **state)
{
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    for (size_t i = 0; i < sizeof samples / sizeof samples[0]; i++) {
        samples[i] = 4095;
    }
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    assert_int_equal(slope[10 * NX + 10], PLFX_SLOPE_NONE);
    assert_int_equal(flags[10 * NX + 10], PLFX_FLAG_TEXTURE);
    assert_int_equal(conf[10 * NX + 10], 0);
}

/* Views without any relation: no overflow, slope within its limits. */
static void extremes(void **state)
{
    ref_rng rng = {9};
    plfx_plan p = plan_of(1);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    for (size_t i = 0; i < sizeof samples / sizeof samples[0]; i++) {
        samples[i] = (uint16_t)(ref_range(&rng, 0, 1) * 4095);
    }
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    for (int i = 0; i < NX * NY; i++) {
        assert_true(slope[i] == PLFX_SLOPE_NONE ||
                    (slope[i] >= -(8 << 16) && slope[i] <= 8 << 16));
    }
}

static void low_confidence_is_missing(void **state)
{
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    p.cfg.unique_u16 = 65535;
    render(&p, 0.1, 2, 0);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    assert_int_equal(slope[10 * NX + 10], PLFX_SLOPE_NONE);
}

static void bad_arguments(void **state)
{
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();
    size_t n = plfx_gradient_ws(&p);
    plfx_cfg c = p.cfg;

    (void)state;
    assert_true(n <= sizeof memory - 64);
    assert_int_equal(plfx_gradient(NULL, &v, &m, workspace(), n), PLFX_E_ARG);
    assert_int_equal(plfx_gradient(&p, NULL, &m, workspace(), n), PLFX_E_ARG);
    assert_int_equal(plfx_gradient(&p, &v, NULL, workspace(), n), PLFX_E_ARG);
    assert_int_equal(plfx_gradient(&p, &v, &m, NULL, n), PLFX_E_SIZE);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), n - 1), PLFX_E_SIZE);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace() + 1, n), PLFX_E_SIZE);
    v.n = 4;
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), n), PLFX_E_ARG);
    c.at[4].v_q8 = 100;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, NY), PLFX_E_ARG);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(planes),
    cmocka_unit_test(faint_and_steep_ramps_have_one_slope),
    cmocka_unit_test(hexagonal_plane),
    cmocka_unit_test(opposite_order_negates),
    cmocka_unit_test(flat_is_missing),
    cmocka_unit_test(extremes),
    cmocka_unit_test(low_confidence_is_missing),
    cmocka_unit_test(bad_arguments),
};

SUITE(tests)
