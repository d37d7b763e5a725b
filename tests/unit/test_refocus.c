/* SPDX-License-Identifier: MIT */
#include "suite.h"
#include "ref.h"

#define NX 70
#define NY 9
static uint16_t samples[NX * NY * 3], out[NX * NY];

static plfx_plan plan_of(void)
{
    plfx_cfg c;
    plfx_plan p;

    memset(&c, 0, sizeof c);
    c.window = 3;
    c.bits = 12;
    c.n = 3;
    c.labels = 3;
    c.slope_max_q16 = 65536;
    c.at[1].u_q8 = 512;
    c.at[2].v_q8 = -512;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, NY), PLFX_OK);
    return p;
}

static void equals_reference(void **state)
{
    ref_rng rng = {21};
    plfx_plan p = plan_of();
    plfx_views v = {samples, NX, NY, 3};
    plfx_image image = {out, NX, NY, NX};

    (void)state;
    for (size_t i = 0; i < NX * NY * 3; i++) {
        samples[i] = (uint16_t)ref_range(&rng, 0, 4095);
    }
    for (int32_t l = 0; l < 3; l++) {
        assert_int_equal(plfx_refocus(&p, &v, l * 32768, &image), PLFX_OK);
        for (int32_t j = 0; j < NY; j++) {
            for (int32_t i = 0; i < NX; i++) {
                uint32_t sum = 1;
                for (int32_t k = 0; k < 3; k++) {
                    sum += ref_sample(&p, &v, k, l, i, j);
                }
                assert_int_equal(out[j * NX + i], sum / 3);
            }
        }
    }
}

static void bad_arguments(void **state)
{
    plfx_plan p = plan_of();
    plfx_views v = {samples, NX, NY, 3};
    plfx_image image = {out, NX, NY, NX};

    (void)state;
    assert_int_equal(plfx_refocus(NULL, &v, 0, &image), PLFX_E_ARG);
    assert_int_equal(plfx_refocus(&p, NULL, 0, &image), PLFX_E_ARG);
    assert_int_equal(plfx_refocus(&p, &v, 0, NULL), PLFX_E_ARG);
    assert_int_equal(plfx_refocus(&p, &v, (8 << 16) + 1, &image), PLFX_E_ARG);
    assert_int_equal(plfx_refocus(&p, &v, -(8 << 16) - 1, &image), PLFX_E_ARG);
    assert_int_equal(plfx_refocus(&p, &v, 8 << 16, &image), PLFX_OK);
    assert_int_equal(plfx_refocus(&p, &v, -(8 << 16), &image), PLFX_OK);
    image.stride = NX - 1;
    assert_int_equal(plfx_refocus(&p, &v, 0, &image), PLFX_E_ARG);
    image.stride = NX;
    image.w = NX - 1;
    assert_int_equal(plfx_refocus(&p, &v, 0, &image), PLFX_E_ARG);
    image.w = NX;
    image.h = NY + 1;
    assert_int_equal(plfx_refocus(&p, &v, 0, &image), PLFX_E_ARG);
    image.h = NY;
    image.px = NULL;
    assert_int_equal(plfx_refocus(&p, &v, 0, &image), PLFX_E_ARG);
    image.px = out;
    v.px = NULL;
    assert_int_equal(plfx_refocus(&p, &v, 0, &image), PLFX_E_ARG);
    v.px = samples;
    v.nx--;
    assert_int_equal(plfx_refocus(&p, &v, 0, &image), PLFX_E_ARG);
    v.nx++;
    v.ny--;
    assert_int_equal(plfx_refocus(&p, &v, 0, &image), PLFX_E_ARG);
    v.ny++;
    v.n--;
    assert_int_equal(plfx_refocus(&p, &v, 0, &image), PLFX_E_ARG);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(equals_reference),
    cmocka_unit_test(bad_arguments),
};

SUITE(tests)
