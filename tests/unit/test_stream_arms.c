/* SPDX-License-Identifier: MIT
 * Arms of views in the stream against plfx_view_all() and plfx_frame(): the same bits
 * over random tables, views, settings, packings and regions of rows. */
#include "stream_run.h"
#include "frame_state.h"

static plfx_status match_views(const scene *sc, const plfx_views *v, const plfx_map *m)
{
    return plfx_frame(&sc->plan, &sc->frame, v, NULL, m, workspace(), WS_BYTES);
}

/* Arms as frame.h divides them. */
static size_t bound_of(const plfx_stream_cfg *c)
{
    const plfx_plan *p = c->plan;
    plfx_frame_state s;
    size_t most = 0;

    assert_int_equal(plfx_frame_derive(&s, p, c->frame, NULL), PLFX_OK);
    for (int32_t a = 0; a < PLFX_ARMS_MAX; a++) {
        most = (size_t)s.arm_n[a] > most ? (size_t)s.arm_n[a] : most;
    }
    return PLFX_STREAM_ARMS_WS(
        (size_t)p->nx, c->format == PLFX_RAW_U16 ? 0u : (size_t)c->lut->sensor_w,
        (size_t)p->cfg.n, (size_t)s.arms, most, (size_t)p->cfg.labels,
        (size_t)p->cfg.window, (size_t)p->reach_x,
        2u * (size_t)p->reach_y + (c->frame->gweight_q4 > 0 ? 2u : 0u),
        (size_t)c->frame->median1, (size_t)c->open_rows,
        c->profile == PLFX_PROFILE_FAST);
}

static void equals_whole_frame(void **state)
{
    (void)state;
    assert_true(stream_all(ARMS, 600) >= 500); /* others do not fit */
}

static void refused(const plfx_stream_cfg *c)
{
    plfx_stream s;

    assert_int_equal(plfx_stream_ws(c), 0);
    assert_int_equal(plfx_stream_init(&s, c, workspace(), WS_BYTES), PLFX_E_ARG);
}

/* What needs a whole frame, or is nothing at all. */
static void settings_that_do_not_stream(void **state)
{
    scene sc = some_scene(ARMS);
    plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_SMALL);
    plfx_frame_cfg good = sc.frame;
    plfx_stream s;
    size_t need = plfx_stream_ws(&c);

    (void)state;
    assert_int_equal(plfx_stream_init(&s, &c, workspace() + 8, WS_BYTES - 8),
                     PLFX_E_SIZE);
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need - 1), PLFX_E_SIZE);
    sc.frame.paths = 5;
    refused(&c);
    sc.frame = good;
    sc.frame.taps = 4;
    refused(&c);
    sc.frame = good;
    sc.frame.median2 = 3;
    refused(&c);
    sc.frame = good;
    sc.frame.noise_q4 = 12;
    refused(&c);
    sc.frame = good;
    sc.frame.keep = 5;
    refused(&c);
    sc.frame = good;
    c.frame = NULL;
    refused(&c);
}

/* The stream preset: 8 views on the axes. */
static void memory_of_the_large_frame(void **state)
{
    (void)state;
    for (int32_t profile = 0; profile < 2; profile++) {
        plfx_cfg g = large_cfg();
        plfx_stream_cfg c;
        scene sc;
        size_t need;
        memset(&sc, 0, sizeof sc);
        sc.kind = ARMS;
        assert_int_equal(plfx_preset(PLFX_PRESET_STREAM, &g, &sc.frame), PLFX_OK);
        g.n = 9;
        for (int32_t k = 0; k < 8; k++) {
            int16_t d = (int16_t)((k % 2 ? 6 : 3) * (k / 2 % 2 ? 256 : -256));
            g.at[k + 1].u_q8 = k < 4 ? d : 0;
            g.at[k + 1].v_q8 = k < 4 ? 0 : d;
        }
        c = large_stream(&sc, &g, profile);
        need = plfx_stream_ws(&c);
        print_message("# 8 views by arms, %s: %u bytes, bound %u\n",
                      profile ? "fast" : "small", (unsigned)need,
                      (unsigned)bound_of(&c));
        assert_in_range(need, 1, 128 * 1024);
        assert_in_range(bound_of(&c), need, need * 105 / 100);
    }
}

static void workspace_is_needed(void **state)
{
    (void)state;
    all_of_the_workspace_is_needed(ARMS);
}

/* Slopes alone, and each other plane alone, are those of the whole map. */
static void maps_with_less(void **state)
{
    scene sc = some_scene(ARMS);
    plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_FAST);

    (void)state;
    whole_frame(&sc);
    for (int32_t part = 0; part < 4; part++) {
        plfx_stream s;
        memset(&got, 0x5a, sizeof got);
        assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
        for (int32_t y = 0; y < sc.raw.h; y++) {
            plfx_raw_row row;
            int32_t ready = 0;
            assert_int_equal(plfx_raw_row_at(&sc.sent, y, &row), PLFX_OK);
            assert_int_equal(plfx_stream_push(&s, y, &row, &ready), PLFX_OK);
            while (ready > 0) {
                int32_t j = 0;
                plfx_map line = line_of(&sc.plan, s.j);
                line.conf_u16 = part == 1 ? line.conf_u16 : NULL;
                line.sigma_u20 = part == 2 ? line.sigma_u20 : NULL;
                line.flags = part == 3 ? line.flags : NULL;
                assert_int_equal(plfx_stream_pop(&s, &j, &line, &ready), PLFX_OK);
            }
        }
        for (int32_t i = 0; i < sc.plan.nx * sc.plan.ny; i++) {
            assert_int_equal(got.slope[i], want.slope[i]);
            assert_int_equal(got.conf[i], part == 1 ? want.conf[i] : 0x5a5a);
            assert_int_equal(got.sigma[i], part == 2 ? want.sigma[i] : 0x5a5a);
            assert_int_equal(got.flags[i], part == 3 ? want.flags[i] : 0x5a);
        }
    }
}

/* Sums of arms are no sum of views. */
static void sweep_refuses_arms(void **state)
{
    scene sc = some_scene(ARMS);
    plfx_views v = {samples, sc.plan.nx, sc.plan.ny, sc.plan.cfg.n};
    plfx_map m = map_of(&want, &sc.plan);

    (void)state;
    assert_int_equal(plfx_sweep(&sc.plan, &v, &m, workspace(), WS_BYTES), PLFX_E_ARG);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(equals_whole_frame),
    cmocka_unit_test(settings_that_do_not_stream),
    cmocka_unit_test(memory_of_the_large_frame),
    cmocka_unit_test(workspace_is_needed),
    cmocka_unit_test(maps_with_less),
    cmocka_unit_test(sweep_refuses_arms),
};

SUITE(tests)
