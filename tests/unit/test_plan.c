/* SPDX-License-Identifier: MIT */
#include "suite.h"
#include "plenofix/plenofix.h"
#include "rows.h"

static plfx_cfg good(void)
{
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.window = 9;
    c.bits = 10;
    c.n = 3;
    c.labels = 17;
    c.slope_min_q16 = -16384;
    c.slope_max_q16 = 16384;
    c.at[1].u_q8 = 6 * 256;
    c.at[2].v_q8 = 6 * 256;
    return c;
}

static plfx_lut lattice(int32_t kind)
{
    plfx_lut l;

    memset(&l, 0, sizeof l);
    l.lattice.kind = kind;
    l.lattice.nx = 40;
    l.lattice.ny = 30;
    l.lattice.a.x_q22 = 10 << 22;
    l.lattice.b.y_q22 = kind == PLFX_LATTICE_HEX ? 36323395 : 10 << 22; /* 8.66 px */
    l.lattice.odd.x_q22 = kind == PLFX_LATTICE_HEX ? 5 << 22 : 0;
    return l;
}

static void labels_span_the_range(void **state)
{
    plfx_cfg c = good();
    plfx_plan p;

    (void)state;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 40, 30), PLFX_OK);
    assert_int_equal(plfx_plan_slope_q16(&p, 0), -16384);
    assert_int_equal(plfx_plan_slope_q16(&p, 16 * 16), 16384);
    assert_int_equal(plfx_plan_slope_q16(&p, 16 * 8), 0);
    assert_int_equal(plfx_plan_slope_q16(&p, 16 * 8 + 8), 1024);
}

static void shifts_follow_the_offsets(void **state)
{
    plfx_cfg c = good();
    plfx_plan p;
    plfx_shift s;

    (void)state;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 40, 30), PLFX_OK);
    s = plfx_plan_shift(&p, 1, 16); /* 0.25 * 6 px = 1.5 columns */
    assert_int_equal(s.kx, 1);
    assert_int_equal(s.fx_q4, 8);
    assert_int_equal(s.ky, 0);
    s = plfx_plan_shift(&p, 2, 0);
    assert_int_equal(s.ky, -2);
    assert_int_equal(s.fy_q4, 8);
    assert_int_equal(s.kx, 0);
    assert_int_equal(p.reach_x, 2);
    assert_int_equal(p.reach_y, 2);
}

static void hexagonal_rows_are_closer(void **state)
{
    plfx_cfg c = good();
    plfx_lut l = lattice(PLFX_LATTICE_HEX);
    plfx_plan p;

    (void)state;
    assert_int_equal(plfx_plan_init(&p, &c, &l, 40, 30), PLFX_OK);
    assert_int_equal(p.hex, 1);
    assert_int_equal(p.odd_q4, 8);
    assert_in_range(p.col_q16, 65530, 65542);
    assert_in_range(p.row_q16, 75660, 75690); /* 2/sqrt(3) */
    l = lattice(PLFX_LATTICE_SQUARE);
    assert_int_equal(plfx_plan_init(&p, &c, &l, 40, 30), PLFX_OK);
    assert_int_equal(p.row_q16, 65536);
    assert_int_equal(p.odd_q4, 0);
}

static void sums_fit_16_bits(void **state)
{
    plfx_plan p;

    (void)state;
    for (int bits = 8; bits <= 12; bits++) {
        for (int n = 2; n < 17; n++) {
            for (int w = 3; w <= 29; w += 2) {
                plfx_cfg c = good();
                uint32_t cost = (uint32_t)((n - 1) * ((1 << bits) - 1));
                c.bits = (uint8_t)bits;
                c.n = (uint8_t)n;
                c.window = (uint8_t)w;
                for (int k = 1; k < n; k++) {
                    c.at[k].u_q8 = (int16_t)(100 * k);
                }
                assert_int_equal(plfx_plan_init(&p, &c, NULL, 40, 30), PLFX_OK);
                cost = (uint32_t)w * (cost >> p.sad_shift1);
                assert_true(cost <= 65535);
                assert_true((uint32_t)w * (cost >> p.sad_shift2) <= 65535);
            }
        }
    }
}

#define REFUSED(field, value)                                                          \
    do {                                                                               \
        plfx_cfg c_ = good();                                                          \
        c_.field = (value);                                                            \
        assert_int_equal(plfx_plan_init(&p, &c_, NULL, 40, 30), PLFX_E_ARG);           \
    } while (0)

static void bad_configurations(void **state)
{
    plfx_plan p;
    plfx_cfg c = good();

    (void)state;
    memset(&p, 0x5a, sizeof p);
    REFUSED(method, PLFX_METHOD_ARMS + 1);
    REFUSED(method, PLFX_METHOD_GRADIENT); /* three views are not a cross */
    REFUSED(cost, PLFX_COST_ZNCC);         /* not with SWEEP */
    REFUSED(fit, 2);
    REFUSED(fuse, 2);
    REFUSED(window, 8);
    REFUSED(window, 1);
    REFUSED(window, 33);
    REFUSED(window, 31); /* taller than the map */
    REFUSED(bits, 7);
    REFUSED(bits, 13);
    REFUSED(n, 1);
    REFUSED(n, PLFX_VIEWS_MAX + 1);
    REFUSED(ref, 3);
    REFUSED(labels, 2);
    REFUSED(labels, PLFX_LABELS_MAX + 1);
    REFUSED(slope_min_q16, 16384);
    REFUSED(slope_min_q16, -(32 << 16) - 1);
    REFUSED(slope_max_q16, (32 << 16) + 1);
    REFUSED(at[1].u_q8, 0); /* equal to the reference */
    assert_int_equal(plfx_plan_init(NULL, &c, NULL, 40, 30), PLFX_E_ARG);
    assert_int_equal(plfx_plan_init(&p, NULL, NULL, 40, 30), PLFX_E_ARG);
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 0, 30), PLFX_E_ARG);
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 40, 0), PLFX_E_ARG);
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 4097, 30), PLFX_E_ARG);
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 40, 4097), PLFX_E_ARG);
    for (size_t i = 0; i < sizeof p; i++) {
        assert_int_equal(((unsigned char *)&p)[i], 0x5a);
    }
}

static void beyond_the_range(void **state)
{
    plfx_cfg c = good();
    plfx_lut l = lattice(PLFX_LATTICE_SQUARE);
    plfx_plan p;

    (void)state;
    c.slope_max_q16 = 8 << 16; /* 48 columns of 40 */
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 40, 30), PLFX_E_RANGE);
    c = good();
    c.at[2].u_q8 = 512;
    c.at[1].v_q8 = 6 * 256;
    c.at[1].u_q8 = 0;
    c.slope_max_q16 = 6 << 16; /* 36 rows of 30 */
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 40, 30), PLFX_E_RANGE);
    c = good();
    c.bits = 12;
    c.n = 18; /* 17 * 4095 > 65535 */
    for (int k = 1; k < 18; k++) {
        c.at[k].u_q8 = (int16_t)(100 * k);
    }
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 40, 30), PLFX_E_RANGE);
    c = good();
    assert_int_equal(plfx_plan_init(&p, &c, &l, 41, 30), PLFX_E_ARG);
    assert_int_equal(plfx_plan_init(&p, &c, &l, 40, 31), PLFX_E_ARG);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(labels_span_the_range),
    cmocka_unit_test(shifts_follow_the_offsets),
    cmocka_unit_test(hexagonal_rows_are_closer),
    cmocka_unit_test(sums_fit_16_bits),
    cmocka_unit_test(bad_configurations),
    cmocka_unit_test(beyond_the_range),
};

SUITE(tests)
