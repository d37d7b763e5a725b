/* SPDX-License-Identifier: MIT
 * The stream against plfx_view_all() and plfx_sweep(): the same bits for both
 * profiles, any packing, region of rows, lattice, tilt and set of views; and its
 * order of calls. */
#include "stream_scene.h"

static uint16_t samples[CELLS * MAX_N];

static void whole_frame(const scene *sc)
{
    plfx_views v = {samples, sc->plan.nx, sc->plan.ny, sc->plan.cfg.n};
    plfx_map m = map_of(&want, &sc->plan);

    assert_int_equal(
        plfx_view_all(&sc->lut, &sc->raw, &sc->tone, sc->plan.cfg.at, sc->white, &v),
        PLFX_OK);
    assert_true(plfx_sweep_ws(&sc->plan) <= WS_BYTES);
    assert_int_equal(plfx_sweep(&sc->plan, &v, &m, workspace(), WS_BYTES), PLFX_OK);
}

/* The bound of the macro for a configuration. */
static size_t bound_of(const scene *sc, const plfx_stream_cfg *c)
{
    const plfx_plan *p = &sc->plan;
    int32_t across = 0;

    for (int32_t k = 0; k < p->cfg.n; k++) {
        across |= p->dv_q8[k] != 0;
    }
    return PLFX_STREAM_WS(
        (size_t)p->nx, c->format == PLFX_RAW_U16 ? 0u : (size_t)sc->lut.sensor_w,
        (size_t)p->cfg.n, p->cfg.method == PLFX_METHOD_PAIRS ? p->cfg.n - 1u : 0u,
        (size_t)p->cfg.labels, (size_t)p->cfg.window, (size_t)p->reach_x,
        across ? 2u * ((size_t)p->reach_y + 1u) : 0u, (size_t)c->open_rows,
        c->profile == PLFX_PROFILE_FAST, p->cfg.texture > 0, (size_t)PLFX_LANES);
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

    if (ref_range(rng, 0, 2) == 0) {
        c.j0 = ref_range(rng, 0, sc->plan.ny - 1);
        c.j1 = ref_range(rng, c.j0 + 1, sc->plan.ny);
    }
    need = plfx_stream_ws(&c);
    assert_in_range(need, 1, WS_BYTES);
    assert_true(bound_of(sc, &c) >= need);
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

    sc.kind = SUMS;
    if (!make(&sc, &rng) || plfx_stream_open_rows(&sc.lut, &sc.plan, &sc.tone) == 0) {
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
    for (uint32_t seed = 1; seed <= 1100; seed++) {
        run += one_case(seed);
    }
    print_message("# %d geometries, two profiles each\n", run);
    assert_true(run >= 1000); /* the rest were plans or tables that do not fit */
}

/* The first seed whose scene fits. */
static scene some_scene(void)
{
    scene sc;

    sc.kind = SUMS;
    for (uint32_t seed = 1; seed < 100; seed++) {
        ref_rng rng = {seed};
        if (make(&sc, &rng) && plfx_stream_open_rows(&sc.lut, &sc.plan, &sc.tone) > 0) {
            return sc;
        }
    }
    fail_msg("no scene");
    return sc;
}

static void bad_configuration(void **state)
{
    scene sc = some_scene();
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

/* The frame of the guide: 16 megapixels, views along u, 17 slopes, window 9.
 * Nothing of the table's content is read. */
static plfx_stream_cfg big(plfx_lut *lut, plfx_plan *plan, int32_t n, int32_t profile)
{
    plfx_stream_cfg c;
    plfx_cfg g;

    memset(lut, 0, sizeof *lut);
    memset(&g, 0, sizeof g);
    lut->sensor_w = 4904;
    lut->sensor_h = 3280;
    lut->lattice.nx = 289;
    lut->lattice.ny = 193;
    lut->lattice.a.x_q22 = q22(16.93);
    lut->lattice.b.y_q22 = q22(16.93);
    g.window = 9;
    g.bits = 12;
    g.n = (uint8_t)n;
    g.ref = (uint8_t)(n / 2);
    g.labels = 17;
    g.slope_min_q16 = -10000;
    g.slope_max_q16 = 10000;
    for (int32_t k = 0; k < n; k++) {
        g.at[k].u_q8 = (int16_t)(6 * 256 * (2 * k - (n - 1)) / (n - 1));
    }
    assert_int_equal(plfx_plan_init(plan, &g, lut, 289, 193), PLFX_OK);
    memset(&c, 0, sizeof c);
    c.plan = plan;
    c.lut = lut;
    c.tone = plfx_tone_unity(12);
    c.profile = (uint8_t)profile;
    c.format = PLFX_RAW_U16;
    c.bits = 12;
    c.open_rows = 1;
    c.j1 = 193;
    return c;
}

static void memory_of_the_large_frame(void **state)
{
    static const size_t limit[4] = {40 * 1024, 64 * 1024, 128 * 1024, 136 * 1024};
    plfx_plan plan;
    plfx_lut lut;

    (void)state;
    for (int32_t i = 0; i < 4; i++) {
        int32_t n = i % 2 ? 9 : 5;
        plfx_stream_cfg c = big(&lut, &plan, n, i / 2);
        size_t need = plfx_stream_ws(&c);
        size_t most =
            PLFX_STREAM_WS((size_t)289, 0u, (size_t)n, 0u, 17u, 9u,
                           (size_t)plan.reach_x, 0u, 1u, i / 2, 0, (size_t)PLFX_LANES);
        print_message("# %d views, %s: %u bytes, bound %u\n", (int)n,
                      i / 2 ? "fast" : "small", (unsigned)need, (unsigned)most);
        assert_true(need > 0 && need <= most && 10 * most <= 11 * need);
        if (PLFX_LANES <= 16) {
            assert_true(need <= limit[i]);
        }
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

/* Bands and rows of the wrong width leave the stream as it was. */
static void wrong_stride(void **state)
{
    scene sc = some_scene();
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
    scene sc = some_scene();
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
