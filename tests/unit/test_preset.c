/* SPDX-License-Identifier: MIT
 * Presets: settings, choice of views, number of labels. */
#include "limits.h"

#include "plenofix/preset.h"

#define SIDE 9 /* views on a side of the square of views */
#define N    (SIDE * SIDE)
#define REF  (N / 2)

static plfx_offset at[N];

/* A square of views, `step` apart, offset (du, dv) from the centre. */
static void lay(int32_t step, int32_t du, int32_t dv)
{
    int32_t k;

    for (k = 0; k < N; k++) {
        at[k].u_q8 = (int16_t)((k % SIDE - SIDE / 2) * step + du);
        at[k].v_q8 = (int16_t)((k / SIDE - SIDE / 2) * step + dv);
    }
}

static void settings(void **state)
{
    int32_t id;

    (void)state;
    for (id = 0; id < PLFX_PRESETS; id++) {
        plfx_frame_cfg frame;
        plfx_cfg cfg;
        mark(&cfg, sizeof cfg);
        mark(&frame, sizeof frame);
        assert_int_equal(plfx_preset(id, &cfg, &frame), PLFX_OK);
        assert_int_equal(cfg.method, PLFX_METHOD_ARMS);
        assert_int_equal(cfg.cost, PLFX_COST_SAD);
        assert_int_equal(cfg.window, 5);
        assert_in_range(frame.keep, 1, frame.arms);
        assert_true(cfg.n == 0x5a && cfg.labels == 0x5a5a && cfg.bits == 0x5a);
        assert_true(marked(cfg.at, sizeof cfg.at));
    }
}

static void settings_of_nothing(void **state)
{
    plfx_frame_cfg frame;
    plfx_cfg cfg;

    (void)state;
    mark(&cfg, sizeof cfg);
    mark(&frame, sizeof frame);
    assert_int_equal(plfx_preset(-1, &cfg, &frame), PLFX_E_ARG);
    assert_int_equal(plfx_preset(PLFX_PRESETS, &cfg, &frame), PLFX_E_ARG);
    assert_int_equal(plfx_preset(0, NULL, &frame), PLFX_E_ARG);
    assert_int_equal(plfx_preset(0, &cfg, NULL), PLFX_E_ARG);
    assert_true(marked(&cfg, sizeof cfg) && marked(&frame, sizeof frame));
}

/* Is view k of the square on one of the eight rays? */
static int32_t on_ray(int32_t k)
{
    int32_t u = abs(k % SIDE - SIDE / 2);
    int32_t v = abs(k / SIDE - SIDE / 2);

    return u == 0 || v == 0 || u == v;
}

static void star_of_a_square(void **state)
{
    static const int32_t ids[2] = {PLFX_PRESET_ONBOARD, PLFX_PRESET_PRECISE};
    int32_t round;
    int32_t k;

    (void)state;
    for (round = 0; round < 2; round++) {
        uint8_t use[N];
        lay(200, 37, -11); /* the reference need not be at the centre */
        assert_int_equal(plfx_preset_views(ids[round], at, N, REF, use), 33);
        for (k = 0; k < N; k++) {
            assert_int_equal(use[k], on_ray(k));
        }
    }
}

/* One tenth beside a ray is on it, a little more is not. */
static void star_has_a_width(void **state)
{
    static const plfx_offset around[8] = {{0, 0},        {1000, 100},   {1000, 101},
                                          {-100, -1000}, {-101, -1000}, {1000, 900},
                                          {899, -1000},  {-1000, 900}};
    static const uint8_t want[8] = {1, 1, 0, 1, 0, 1, 0, 1};
    uint8_t use[8];

    (void)state;
    assert_int_equal(plfx_preset_views(PLFX_PRESET_ONBOARD, around, 8, 0, use), 5);
    assert_memory_equal(use, want, 8);
}

/* Fewer than four views on the rays: all are used. */
static void star_too_thin(void **state)
{
    static const plfx_offset around[6] = {{0, 0},      {1000, 0},   {0, 1000},
                                          {1000, 300}, {300, 1000}, {1000, 1000}};
    uint8_t use[6];
    int32_t k;

    (void)state;
    assert_int_equal(plfx_preset_views(PLFX_PRESET_PRECISE, around, 6, 0, use), 6);
    for (k = 0; k < 6; k++) {
        assert_int_equal(use[k], 1);
    }
}

/* Two views on each half axis: the farthest and the one half as far. */
static void axes_of_a_square(void **state)
{
    uint8_t use[N];
    int32_t count = 0;
    int32_t k;

    (void)state;
    lay(256, 0, 0);
    assert_int_equal(plfx_preset_views(PLFX_PRESET_STREAM, at, N, REF, use), 9);
    for (k = 0; k < N; k++) {
        int32_t u = abs(k % SIDE - SIDE / 2);
        int32_t v = abs(k / SIDE - SIDE / 2);
        count += use[k];
        assert_int_equal(use[k], u * v == 0 && (u + v) % 2 == 0);
    }
    assert_int_equal(count, 9);
}

/* A corner has two half axes; a lone pair has one, with one view on it. */
static void axes_that_are_missing(void **state)
{
    static const plfx_offset pair[2] = {{50, 0}, {-50, 0}};
    static const plfx_offset off[2] = {{0, 0}, {100, 100}};
    uint8_t use[N];

    (void)state;
    lay(256, 0, 0);
    assert_int_equal(plfx_preset_views(PLFX_PRESET_STREAM, at, N, 0, use), 5);
    assert_true(use[0] && use[4] && use[8] && use[4 * SIDE] && use[8 * SIDE]);
    assert_int_equal(plfx_preset_views(PLFX_PRESET_STREAM, pair, 2, 1, use), 2);
    assert_int_equal(plfx_preset_views(PLFX_PRESET_STREAM, off, 2, 0, use), 1);
    assert_true(use[0] && !use[1]);
}

static void views_of_nothing(void **state)
{
    static plfx_offset many[2049];
    static uint8_t use[2049];

    (void)state;
    mark(use, sizeof use);
    assert_int_equal(plfx_preset_views(-1, at, N, REF, use), 0);
    assert_int_equal(plfx_preset_views(PLFX_PRESETS, at, N, REF, use), 0);
    assert_int_equal(plfx_preset_views(0, NULL, N, REF, use), 0);
    assert_int_equal(plfx_preset_views(0, at, N, REF, NULL), 0);
    assert_int_equal(plfx_preset_views(0, at, 1, 0, use), 0);
    assert_int_equal(plfx_preset_views(0, many, 2049, 0, use), 0);
    assert_int_equal(plfx_preset_views(0, at, N, -1, use), 0);
    assert_int_equal(plfx_preset_views(0, at, N, N, use), 0);
    assert_true(marked(use, sizeof use));
    assert_int_equal(plfx_preset_views(1, many, 2048, 2047, use), 2048);
}

/* Steps of 0.4 and 0.5 lens pitches (102 and 128 of 256), ends included. */
static void labels(void **state)
{
    const int32_t one = 65536;

    (void)state;
    assert_int_equal(plfx_preset_labels(PLFX_PRESET_STREAM, -one, one, 1024), 17);
    assert_int_equal(plfx_preset_labels(PLFX_PRESET_STREAM, -one, one + 1, 1024), 18);
    assert_int_equal(plfx_preset_labels(PLFX_PRESET_ONBOARD, 0, 2 * one, 1020), 21);
    assert_int_equal(plfx_preset_labels(PLFX_PRESET_PRECISE, 0, 2 * one, 1021), 22);
    assert_int_equal(plfx_preset_labels(PLFX_PRESET_STREAM, 0, 1, 1), PLFX_LABELS_MIN);
    assert_int_equal(plfx_preset_labels(0, -32 * one, 32 * one, 32767),
                     PLFX_LABELS_MAX);
    assert_int_equal(plfx_preset_labels(-1, 0, one, 1024), PLFX_LABELS_MIN);
    assert_int_equal(plfx_preset_labels(PLFX_PRESETS, 0, one, 1024), PLFX_LABELS_MIN);
    assert_int_equal(plfx_preset_labels(0, one, one, 1024), PLFX_LABELS_MIN);
    assert_int_equal(plfx_preset_labels(0, 0, one, 0), PLFX_LABELS_MIN);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(settings),
    cmocka_unit_test(settings_of_nothing),
    cmocka_unit_test(star_of_a_square),
    cmocka_unit_test(star_has_a_width),
    cmocka_unit_test(star_too_thin),
    cmocka_unit_test(axes_of_a_square),
    cmocka_unit_test(axes_that_are_missing),
    cmocka_unit_test(views_of_nothing),
    cmocka_unit_test(labels),
};

SUITE(tests)
