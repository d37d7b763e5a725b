/* SPDX-License-Identifier: MIT
 * The stream against plfx_view_all() and plfx_sweep(): the same bits for both
 * profiles, any packing, region of rows, lattice, tilt and set of views; and its
 * order of calls. */
#include "stream_run.h"

static plfx_status match_views(const scene *sc, const plfx_views *v, const plfx_map *m)
{
    return plfx_sweep(&sc->plan, v, m, workspace(), WS_BYTES);
}

static size_t bound_of(const plfx_stream_cfg *c)
{
    const plfx_plan *p = c->plan;
    int32_t across = 0;

    for (int32_t k = 0; k < p->cfg.n; k++) {
        across |= p->dv_q8[k] != 0;
    }
    return PLFX_STREAM_WS(
        (size_t)p->nx, c->format == PLFX_RAW_U16 ? 0u : (size_t)c->lut->sensor_w,
        (size_t)p->cfg.n, p->cfg.method == PLFX_METHOD_PAIRS ? p->cfg.n - 1u : 0u,
        (size_t)p->cfg.labels, (size_t)p->cfg.window, (size_t)p->reach_x,
        across ? 2u * ((size_t)p->reach_y + 1u) : 0u, (size_t)c->open_rows,
        c->profile == PLFX_PROFILE_FAST, p->cfg.texture > 0, (size_t)PLFX_LANES);
}

static void equals_whole_frame(void **state)
{
    (void)state;
    assert_true(stream_all(SUMS, 1100) >= 1000); /* others do not fit */
}

static void bad_configuration(void **state)
{
    scene sc = some_scene(SUMS);
    plfx_stream_cfg good = stream_cfg(&sc, PLFX_PROFILE_SMALL);
    plfx_stream_cfg c = good;
    size_t need = plfx_stream_ws(&good);
    plfx_plan zncc = sc.plan;
    plfx_stream s;

    (void)state;
    assert_int_equal(plfx_stream_init(NULL, &c, workspace(), need), PLFX_E_ARG);
    assert_int_equal(plfx_stream_init(&s, NULL, workspace(), need), PLFX_E_ARG);
    assert_int_equal(plfx_stream_init(&s, &c, NULL, need), PLFX_E_SIZE);
    assert_int_equal(plfx_stream_init(&s, &c, workspace() + 1, need + 63), PLFX_E_SIZE);
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need - 1), PLFX_E_SIZE);
    c.j1 = c.j0;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_E_ARG);
    c = good;
    c.j1 = sc.plan.ny + 1;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_E_ARG);
    c = good;
    c.open_rows = 0;
    assert_int_equal(plfx_stream_ws(&c), 0);
    c.open_rows = PLFX_STREAM_OPEN_MAX + 1;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_E_ARG);
    c = good;
    c.tone.bits = (uint8_t)(c.tone.bits == 8 ? 9 : 8);
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_E_ARG);
    c = good;
    c.format = PLFX_RAW_FORMATS;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_E_ARG);
    c = good;
    c.profile = 2;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_E_ARG);
    c = good;
    zncc.cfg.method = PLFX_METHOD_SWEEP; /* of pairs alone */
    zncc.cfg.cost = PLFX_COST_ZNCC;
    c.plan = &zncc;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_E_ARG);
}

/* Views along u. */
static void memory_of_the_large_frame(void **state)
{
    static const size_t limit[4] = {40 * 1024, 64 * 1024, 128 * 1024, 136 * 1024};

    (void)state;
    for (int32_t i = 0; i < 4; i++) {
        plfx_cfg g = large_cfg();
        plfx_stream_cfg c;
        scene sc;
        size_t need;
        memset(&sc, 0, sizeof sc);
        g.n = i % 2 ? 9 : 5;
        g.ref = g.n / 2;
        for (int32_t k = 0; k < g.n; k++) {
            g.at[k].u_q8 = (int16_t)(6 * 256 * (2 * k - (g.n - 1)) / (g.n - 1));
        }
        c = large_stream(&sc, &g, i / 2);
        need = plfx_stream_ws(&c);
        print_message("# %d views, %s: %u bytes, bound %u\n", (int)g.n,
                      i / 2 ? "fast" : "small", (unsigned)need, (unsigned)bound_of(&c));
        assert_in_range(bound_of(&c), need, need * 11 / 10);
        if (PLFX_LANES <= 16) {
            assert_in_range(need, 1, limit[i]);
        }
    }
}

static void workspace_is_needed(void **state)
{
    (void)state;
    all_of_the_workspace_is_needed(SUMS);
}

/* Bands and rows of the wrong width leave the stream as it was. */
static void wrong_stride(void **state)
{
    scene sc = some_scene(SUMS);
    plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_SMALL);
    plfx_raw band = sc.sent;
    int32_t used = 0;
    int32_t ready = 0;
    int32_t next = 0;
    plfx_stream s;

    (void)state;
    whole_frame(&sc);
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    feed(&s, &sc, 0, 20, &next);
    band.w--;
    assert_int_equal(plfx_stream_push_band(&s, 20, &band, &used, &ready), PLFX_E_ARG);
    band.w += 2;
    assert_int_equal(plfx_stream_push_band(&s, 20, &band, &used, &ready), PLFX_E_ARG);
    feed(&s, &sc, 20, sc.raw.h, &next);
    assert_int_equal(next, sc.plan.ny);
    compare(&sc, 0, sc.plan.ny, PLFX_PROFILE_SMALL, 0);
}

static void order_of_calls(void **state)
{
    scene sc = some_scene(SUMS);
    plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_FAST);
    plfx_map line = line_of(&sc.plan, 0);
    plfx_raw_row row;
    plfx_raw_row bad;
    plfx_raw band = sc.sent;
    plfx_stream s;
    int32_t ready = 0;
    int32_t used = 0;
    int32_t j = -7;

    (void)state;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    assert_int_equal(plfx_raw_row_at(&sc.sent, 0, &row), PLFX_OK);
    bad = row;
    bad.width--;
    assert_int_equal(plfx_stream_push(&s, 0, &bad, &ready), PLFX_E_ARG);
    assert_int_equal(plfx_stream_push(&s, -1, &row, &ready), PLFX_E_ARG);
    assert_int_equal(plfx_stream_push(&s, sc.raw.h, &row, &ready), PLFX_E_ARG);
    assert_int_equal(plfx_stream_push(&s, sc.raw.h - 1, &row, &ready), PLFX_E_STATE);
    band.h = 0;
    assert_int_equal(plfx_stream_push_band(&s, 0, &band, &used, &ready), PLFX_E_ARG);
    assert_int_equal(plfx_stream_push(&s, 0, &row, &ready), PLFX_OK);
    assert_int_equal(ready, sc.plan.cfg.window / 2); /* the rows without a window */
    assert_int_equal(plfx_stream_push(&s, 1, &row, &ready), PLFX_E_STATE);
    while (ready > 0) {
        assert_int_equal(plfx_stream_pop(&s, &j, &line, &ready), PLFX_OK);
    }
    assert_int_equal(plfx_stream_pop(&s, &j, &line, &ready), PLFX_E_STATE);
    assert_int_equal(plfx_stream_push(&s, 2, &row, &ready), PLFX_E_STATE);
    assert_int_equal(plfx_stream_push(&s, 0, &row, &ready), PLFX_E_STATE);
    assert_int_equal(plfx_stream_push(&s, 1, &row, &ready), PLFX_OK);
    assert_int_equal(plfx_stream_finish(&s), PLFX_E_STATE);
    line.h = 2;
    assert_int_equal(plfx_stream_pop(&s, &j, &line, &ready), PLFX_E_ARG);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(equals_whole_frame),
    cmocka_unit_test(bad_configuration),
    cmocka_unit_test(memory_of_the_large_frame),
    cmocka_unit_test(workspace_is_needed),
    cmocka_unit_test(wrong_stride),
    cmocka_unit_test(order_of_calls),
};

SUITE(tests)
