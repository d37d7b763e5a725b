/* SPDX-License-Identifier: MIT
 * Views judged before they are matched. */
#include "limits.h"
#include "ref.h"

#include "plenofix/viewcheck.h"

#define NX   48
#define NY   40
#define N    5
#define SEED 0x5eedu
#define FULL 1023u /* 10 bits */

static uint16_t px[NX * NY * N];
static plfx_views views = {px, NX, NY, N};
static uint8_t found[N];
static uint32_t work[2 * N];

static uint16_t *row(int32_t k, int32_t j)
{
    return px + ((size_t)j * N + (size_t)k) * NX;
}

static void fill_view(int32_t k, uint32_t v)
{
    int32_t i;
    int32_t j;

    for (j = 0; j < NY; j++) {
        for (i = 0; i < NX; i++) {
            row(k, j)[i] = (uint16_t)v;
        }
    }
}

static void fill_all(uint32_t v)
{
    int32_t k;

    for (k = 0; k < N; k++) {
        fill_view(k, v);
    }
}

static int32_t check(void)
{
    return plfx_views_check(&views, 10, found, work);
}

static void like_views_pass(void **state)
{
    int32_t k;

    (void)state;
    for (k = 0; k < N; k++) {
        fill_view(k, (uint32_t)(400 + 20 * k));
    }
    assert_int_equal(check(), 0);
    for (k = 0; k < N; k++) {
        assert_int_equal(found[k], 0);
    }
}

/* Limits of the header from both sides; the median view has 400. */
static void means_apart(void **state)
{
    static const struct {
        uint32_t v, finding;
    } table[] = {{100, PLFX_VIEW_ALIEN},
                 {99, PLFX_VIEW_ALIEN | PLFX_VIEW_DARK},
                 {200, 0},
                 {199, PLFX_VIEW_ALIEN},
                 {604, 0},
                 {605, PLFX_VIEW_ALIEN},
                 {0, PLFX_VIEW_ALIEN | PLFX_VIEW_DARK}};
    size_t k;

    (void)state;
    for (k = 0; k < COUNT(table); k++) {
        fill_all(400);
        fill_view(3, table[k].v);
        assert_int_equal(check(), table[k].finding != 0);
        assert_int_equal(found[3], table[k].finding);
        assert_int_equal(found[0], 0);
    }
}

/* 120 samples are looked at: every fourth of every fourth row. */
static void clipped_views(void **state)
{
    int32_t k;
    int32_t i;

    (void)state;
    fill_all(900);
    for (i = 0; i < NX; i++) {
        row(2, 0)[i] = FULL; /* 12, 24 and 36 of 120 */
        row(2, 4)[i] = FULL;
    }
    assert_int_equal(check(), 0); /* a fifth */
    for (i = 0; i < NX; i++) {
        row(2, 8)[i] = FULL;
    }
    assert_int_equal(check(), 1);
    assert_int_equal(found[2], PLFX_VIEW_CLIPPED);
    for (k = 0; k < N; k++) {
        for (i = 0; i < NX; i++) {
            row(k, 0)[i] = FULL; /* 3 of 10 rows, view 2 has 5 */
            row(k, 12)[i] = FULL;
            row(k, 16)[i] = FULL;
        }
    }
    assert_int_equal(check(), 0); /* not twice the median's share */
}

/* Two means below, two above: the median is the middle one wherever it stands. */
static void the_median_stands_anywhere(void **state)
{
    static const uint32_t level[N] = {10, 400, 20, 1000, 900};
    int32_t turn;
    int32_t k;

    (void)state;
    for (turn = 0; turn < N; turn++) {
        for (k = 0; k < N; k++) {
            fill_view((k + turn) % N, level[k]);
        }
        assert_int_equal(check(), 4);
        for (k = 0; k < N; k++) {
            assert_int_equal(found[(k + turn) % N] == 0, k == 1);
        }
    }
}

typedef struct check_args {
    plfx_views views;
    int32_t bits;
    uint8_t *found;
    uint32_t *work;
} check_args;

static int32_t call_check(void *args)
{
    const check_args *a = args;
    int32_t status;

    mark(found, sizeof found);
    mark(work, sizeof work);
    status = plfx_views_check(&a->views, a->bits, a->found, a->work);
    assert_true(status >= 0 ||
                (marked(found, sizeof found) && marked(work, sizeof work)));
    return status < 0 ? status : PLFX_OK;
}

static void limits_of_check(void **state)
{
#define C(field, value, status) LIMIT(check_args, field, value, status)
    static const limit table[] = {
        C(views.px, 0, PLFX_E_ARG),
        C(views.n, 2, PLFX_E_ARG),
        C(views.n, 3, PLFX_OK),
        C(views.n, 2049, PLFX_E_ARG),
        C(views.nx, 0, PLFX_E_ARG),
        C(views.nx, 1, PLFX_OK),
        C(views.ny, 0, PLFX_E_ARG),
        C(views.ny, 1, PLFX_OK),
        C(bits, PLFX_BITS_MIN - 1, PLFX_E_ARG),
        C(bits, PLFX_BITS_MIN, PLFX_OK),
        C(bits, PLFX_BITS_MAX, PLFX_OK),
        C(bits, PLFX_BITS_MAX + 1, PLFX_E_ARG),
        C(found, 0, PLFX_E_ARG),
        C(work, 0, PLFX_E_ARG),
    };
#undef C
    check_args a = {views, 10, found, work};

    (void)state;
    limits(&a, sizeof a, table, COUNT(table), call_check);
    assert_int_equal(plfx_views_check(NULL, 10, found, work), PLFX_E_ARG);
}

/* Roughly normal, zero mean, variance 1 (sum of 12 uniform numbers). */
static double normal(ref_rng *rng)
{
    double sum = -6;
    int32_t i;

    for (i = 0; i < 12; i++) {
        sum += ref_range(rng, 0, 9999) / 10000.0;
    }
    return sum;
}

static void noise_into(int32_t k, int32_t bits, double sigma_grey, double ramp)
{
    ref_rng rng = {SEED + (uint32_t)k - 1};
    double unit = (double)(1 << (bits - 8));
    int32_t i;
    int32_t j;

    for (j = 0; j < NY; j++) {
        for (i = 0; i < NX; i++) {
            double v = (100 + ramp * i + ramp * j + sigma_grey * normal(&rng)) * unit;
            row(k, j)[i] = (uint16_t)(v < 0            ? 0
                                      : v > 255 * unit ? 255 * unit
                                                       : v + 0.5);
        }
    }
}

/* Of white noise the smoothest of few blocks reads up to a third less. */
static void noise_is_measured(void **state)
{
    static const double sigma[] = {1, 2, 4, 8};
    int32_t bits;
    size_t k;

    (void)state;
    for (bits = 8; bits <= 12; bits++) {
        for (k = 0; k < COUNT(sigma); k++) {
            int32_t got;
            noise_into(1, bits, sigma[k], 0.8);
            got = plfx_views_noise_q4(&views, bits, 1);
            if (got < 16 * sigma[k] * 0.65 || got > 16 * sigma[k] * 1.1) {
                fail_msg("%d bits, noise %d/16: %d (seed %x)", (int)bits,
                         (int)(16 * sigma[k]), (int)got, SEED);
            }
        }
    }
}

/* What chance takes off of five views is given back. */
static void noise_of_all_views(void **state)
{
    static const double sigma[] = {0.5, 1, 2, 4};
    size_t k;
    int32_t i;

    (void)state;
    for (k = 0; k < COUNT(sigma); k++) {
        int32_t got;
        for (i = 0; i < N; i++) {
            noise_into(i, 12, sigma[k], 0.8);
        }
        got = plfx_views_noise_q4(&views, 12, PLFX_VIEWS_ALL);
        if (got < 16 * sigma[k] * 0.85 || got > 16 * sigma[k] * 1.1) {
            fail_msg("noise %d/16: %d (seed %x)", (int)(16 * sigma[k]), (int)got, SEED);
        }
    }
}

/* A plane has no second difference; noise of full scale ends the scale. */
static void noise_of_extremes(void **state)
{
    ref_rng rng = {SEED};
    size_t i;

    (void)state;
    fill_all(77);
    assert_int_equal(plfx_views_noise_q4(&views, 10, 0), 0);
    for (i = 0; i < COUNT(px); i++) {
        px[i] = (uint16_t)(ref_range(&rng, 0, 1) * 4095);
    }
    assert_int_equal(plfx_views_noise_q4(&views, 12, 4), (2 * 127 + 1) * 107 / 256);
}

typedef struct noise_args {
    plfx_views views;
    int32_t bits, k;
} noise_args;

/* A refused call measures nothing; the views here have noise. */
static int32_t call_noise(void *args)
{
    const noise_args *a = args;

    return plfx_views_noise_q4(&a->views, a->bits, a->k) > 0;
}

static void limits_of_noise(void **state)
{
#define C(field, value, status) LIMIT(noise_args, field, value, status)
    static const limit table[] = {
        C(views.px, 0, 0),
        C(views.n, 0, 0),
        C(k, PLFX_VIEWS_ALL - 1, 0),
        C(k, PLFX_VIEWS_ALL, 1),
        C(k, N, 0),
        C(k, N - 1, 1),
        C(views.nx, 15, 0),
        C(views.ny, 15, 0),
        C(views.ny, 16, 1),
        C(bits, PLFX_BITS_MIN - 1, 0),
        C(bits, PLFX_BITS_MAX, 1),
        C(bits, PLFX_BITS_MAX + 1, 0),
    };
#undef C
    noise_args a = {views, 12, 2};
    ref_rng rng = {SEED};
    size_t i;

    (void)state;
    for (i = 0; i < COUNT(px); i++) {
        px[i] = (uint16_t)ref_range(&rng, 0, 4095);
    }
    limits(&a, sizeof a, table, COUNT(table), call_noise);
    assert_int_equal(plfx_views_noise_q4(NULL, 10, 0), 0);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(like_views_pass),    cmocka_unit_test(means_apart),
    cmocka_unit_test(clipped_views),      cmocka_unit_test(the_median_stands_anywhere),
    cmocka_unit_test(limits_of_check),    cmocka_unit_test(noise_is_measured),
    cmocka_unit_test(noise_of_all_views), cmocka_unit_test(noise_of_extremes),
    cmocka_unit_test(limits_of_noise),
};

SUITE(tests)
