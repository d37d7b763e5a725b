/* SPDX-License-Identifier: MIT
 * Arms of views in the stream against plfx_view_all() and plfx_frame(): the same bits
 * over random tables, views, settings, packings and regions of rows. */
#include "stream_scene.h"
#include "frame_state.h"

static uint16_t samples[CELLS * MAX_N];

static void whole_frame(const scene *sc)
{
    plfx_views v = {samples, sc->plan.nx, sc->plan.ny, sc->plan.cfg.n};
    plfx_map m = map_of(&want, &sc->plan);

    assert_int_equal(
        plfx_view_all(&sc->lut, &sc->raw, &sc->tone, sc->plan.cfg.at, sc->white, &v),
        PLFX_OK);
    assert_true(plfx_frame_ws(&sc->plan, &sc->frame) <= WS_BYTES);
    assert_int_equal(
        plfx_frame(&sc->plan, &sc->frame, &v, NULL, &m, workspace(), WS_BYTES),
        PLFX_OK);
}

/* The bound of the macro for a configuration: arms as frame.h divides them. */
static size_t bound_of(const plfx_plan *p, const plfx_stream_cfg *c)
{
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

/* One frame, or the middle of one after an abandoned start. */
static void stream_once(const scene *sc, ref_rng *rng, int32_t profile, unsigned seed)
{
    plfx_stream_cfg c = stream_cfg(sc, profile);
    plfx_stream s;
    int32_t next;
    int32_t first = 0;
    int32_t last;
    size_t need;

    if (ref_range(rng, 0, 1) == 0) {
        c.j0 = ref_range(rng, 0, sc->plan.ny - 1);
        c.j1 = ref_range(rng, c.j0 + 1, sc->plan.ny);
    }
    need = plfx_stream_ws(&c);
    assert_in_range(need, 1, WS_BYTES);
    assert_true(bound_of(&sc->plan, &c) >= need);
    memset(workspace(), (int)(seed & 255), need + 64);
    memset(&got, 0x5a, sizeof got);
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_OK);
    next = c.j0;
    if (ref_range(rng, 0, 2) == 0) {
        feed(&s, sc, 0, sc->raw.h / 2, &next);
        assert_int_equal(plfx_stream_reset(&s), PLFX_OK);
        next = c.j0;
    }
    plfx_stream_rows(&s, &first, &last);
    if (c.format == PLFX_RAW_U16 && ref_range(rng, 0, 1)) {
        feed_bands(&s, sc, &next);
    } else {
        feed(&s, sc, first < sc->raw.h ? first : 0, sc->raw.h, &next);
    }
    assert_int_equal(next, c.j1);
    assert_int_equal(plfx_stream_finish(&s), PLFX_OK);
    for (size_t i = 0; i < 64; i++) {
        assert_int_equal(workspace()[need + i], seed & 255);
    }
    compare(sc, c.j0, c.j1, profile, seed);
}

static int one_case(uint32_t seed)
{
    ref_rng rng = {seed};
    scene sc;

    sc.kind = ARMS;
    if (!make(&sc, &rng) || plfx_stream_open_rows(&sc.lut, &sc.plan, &sc.tone) == 0 ||
        plfx_frame_ws(&sc.plan, &sc.frame) == 0) {
        return 0;
    }
    whole_frame(&sc);
    stream_once(&sc, &rng, PLFX_PROFILE_SMALL, seed);
    stream_once(&sc, &rng, PLFX_PROFILE_FAST, seed);
    return 1;
}

static void equals_whole_frame(void **state)
{
    int run = 0;

    (void)state;
    for (uint32_t seed = 1; seed <= 600; seed++) {
        run += one_case(seed);
    }
    print_message("# %d geometries, two profiles each\n", run);
    assert_true(run >= 500); /* the rest were plans or tables that do not fit */
}

/* The first seed whose scene fits. */
static scene some_scene(void)
{
    scene sc;

    sc.kind = ARMS;
    for (uint32_t seed = 1; seed < 100; seed++) {
        ref_rng rng = {seed};
        if (make(&sc, &rng) && plfx_stream_open_rows(&sc.lut, &sc.plan, &sc.tone) > 0 &&
            plfx_frame_ws(&sc.plan, &sc.frame) > 0) {
            return sc;
        }
    }
    fail_msg("no scene");
    return sc;
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
    scene sc = some_scene();
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
    sc.frame.noise_q4 = 7;
    refused(&c);
    sc.frame = good;
    sc.frame.keep = 5;
    refused(&c);
    sc.frame = good;
    c.frame = NULL;
    refused(&c);
}

/* 16 megapixels, the stream preset: 8 views on the axes, 17 slopes. */
static plfx_stream_cfg big(plfx_lut *lut, plfx_plan *plan, plfx_frame_cfg *frame,
                           int32_t profile)
{
    plfx_stream_cfg c;
    plfx_cfg g;

    memset(lut, 0, sizeof *lut);
    memset(&g, 0, sizeof g);
    assert_int_equal(plfx_preset(PLFX_PRESET_STREAM, &g, frame), PLFX_OK);
    lut->sensor_w = 4904;
    lut->sensor_h = 3280;
    lut->lattice.nx = 289;
    lut->lattice.ny = 193;
    lut->lattice.a.x_q22 = q22(16.93);
    lut->lattice.b.y_q22 = q22(16.93);
    g.bits = 12;
    g.n = 9;
    g.labels = 17;
    g.slope_min_q16 = -10000;
    g.slope_max_q16 = 10000;
    for (int32_t k = 0; k < 8; k++) {
        int16_t d = (int16_t)((k % 2 ? 6 : 3) * (k / 2 % 2 ? 256 : -256));
        g.at[k + 1].u_q8 = k < 4 ? d : 0;
        g.at[k + 1].v_q8 = k < 4 ? 0 : d;
    }
    assert_int_equal(plfx_plan_init(plan, &g, lut, 289, 193), PLFX_OK);
    memset(&c, 0, sizeof c);
    c.plan = plan;
    c.lut = lut;
    c.frame = frame;
    c.tone = plfx_tone_unity(12);
    c.profile = (uint8_t)profile;
    c.format = PLFX_RAW_U16;
    c.bits = 12;
    c.open_rows = 2;
    c.j1 = 193;
    return c;
}

static void memory_of_the_large_frame(void **state)
{
    plfx_frame_cfg frame;
    plfx_plan plan;
    plfx_lut lut;

    (void)state;
    for (int32_t profile = 0; profile < 2; profile++) {
        plfx_stream_cfg c = big(&lut, &plan, &frame, profile);
        size_t need = plfx_stream_ws(&c);
        size_t most = bound_of(&plan, &c);
        print_message("# 8 views by arms, %s: %u bytes, bound %u\n",
                      profile ? "fast" : "small", (unsigned)need, (unsigned)most);
        assert_in_range(need, 1, 128 * 1024);
        assert_true(need <= most && 100 * most <= 105 * need);
    }
}

/* The last 64 bytes of a workspace are used: no smaller one would do. */
static void workspace_is_needed(void **state)
{
    scene sc = some_scene();

    (void)state;
    for (int32_t profile = 0; profile < 2; profile++) {
        plfx_stream_cfg c = stream_cfg(&sc, profile);
        size_t need = plfx_stream_ws(&c);
        int32_t next = 0;
        size_t touched = 0;
        plfx_stream s;
        memset(workspace(), 0x77, need);
        assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_OK);
        feed(&s, &sc, 0, sc.raw.h, &next);
        for (size_t i = 0; i < need; i++) {
            touched = workspace()[i] != 0x77 ? i + 1 : touched;
        }
        assert_in_range(touched, need - 64, need);
    }
}

/* Slopes alone, and each other plane alone, are those of the whole map. */
static void maps_with_less(void **state)
{
    scene sc = some_scene();
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
    scene sc = some_scene();
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
