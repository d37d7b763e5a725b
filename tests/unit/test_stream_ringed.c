/* SPDX-License-Identifier: MIT
 * Streams of methods that keep rows of the views: pairs by normalised correlation
 * against plfx_sweep(), the gradient against plfx_gradient(), the same bits. */
#include "stream_scene.h"
#include "plenofix/gradient.h"
#include "plenofix/sweep.h"

static uint16_t samples[CELLS * MAX_N];

static void whole_frame(const scene *sc)
{
    plfx_views v = {samples, sc->plan.nx, sc->plan.ny, sc->plan.cfg.n};
    plfx_map m = map_of(&want, &sc->plan);
    plfx_status status;

    assert_int_equal(
        plfx_view_all(&sc->lut, &sc->raw, &sc->tone, sc->plan.cfg.at, sc->white, &v),
        PLFX_OK);
    if (sc->kind == GRADIENT) {
        status = plfx_gradient(&sc->plan, &v, &m, workspace(), WS_BYTES);
    } else {
        status = plfx_sweep(&sc->plan, &v, &m, workspace(), WS_BYTES);
    }
    assert_int_equal(status, PLFX_OK);
}

/* The bound of the macro for a configuration. */
static size_t bound_of(const scene *sc, const plfx_stream_cfg *c)
{
    const plfx_plan *p = &sc->plan;
    size_t packed_w = c->format == PLFX_RAW_U16 ? 0u : (size_t)sc->lut.sensor_w;

    if (sc->kind == GRADIENT) {
        return PLFX_STREAM_GRADIENT_WS((size_t)p->nx, packed_w, (size_t)p->cfg.window,
                                       (size_t)c->open_rows,
                                       c->profile == PLFX_PROFILE_FAST);
    }
    return PLFX_STREAM_NCC_WS(
        (size_t)p->nx, packed_w, (size_t)p->cfg.n, (size_t)p->cfg.labels,
        (size_t)p->cfg.window, (size_t)p->reach_x, (size_t)p->reach_y,
        (size_t)c->open_rows, c->profile == PLFX_PROFILE_FAST, (size_t)PLFX_LANES);
}

/* A whole frame, a band of it, or either after an abandoned start. */
static void stream_once(const scene *sc, ref_rng *rng, int32_t profile, unsigned seed)
{
    plfx_stream_cfg c = stream_cfg(sc, profile);
    plfx_stream s;
    int32_t next, first = 0, last;
    size_t need;

    if (ref_range(rng, 0, 2) == 0) {
        c.j0 = ref_range(rng, 0, sc->plan.ny - 1);
        c.j1 = ref_range(rng, c.j0 + 1, sc->plan.ny);
    }
    need = plfx_stream_ws(&c);
    assert_in_range(need, 1, WS_BYTES);
    assert_true(need <= bound_of(sc, &c));
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
    feed(&s, sc, first < sc->raw.h ? first : 0, sc->raw.h, &next);
    assert_int_equal(next, c.j1);
    assert_int_equal(plfx_stream_finish(&s), PLFX_OK);
    for (size_t i = 0; i < 64; i++) {
        assert_int_equal(workspace()[need + i], seed & 255);
    }
    compare(sc, c.j0, c.j1, profile, seed);
}

static int run(int32_t kind, uint32_t seeds)
{
    int n = 0;

    for (uint32_t seed = 1; seed <= seeds; seed++) {
        ref_rng rng = {seed};
        scene sc;
        sc.kind = kind;
        if (make(&sc, &rng) && plfx_stream_open_rows(&sc.lut, &sc.plan, &sc.tone) > 0) {
            whole_frame(&sc);
            stream_once(&sc, &rng, (int32_t)(seed & 1), seed);
            n++;
        }
    }
    print_message("# %d geometries\n", n);
    return n;
}

static void correlation_equals_whole_frame(void **state)
{
    (void)state;
    assert_true(run(NCC, 300) >= 250); /* the rest were plans that do not fit */
}

static void gradient_equals_whole_frame(void **state)
{
    (void)state;
    assert_true(run(GRADIENT, 300) >= 250);
}

/* The first seed whose scene fits. */
static scene some_scene(int32_t kind)
{
    scene sc;

    sc.kind = kind;
    for (uint32_t seed = 1; seed < 100; seed++) {
        ref_rng rng = {seed};
        if (make(&sc, &rng) && plfx_stream_open_rows(&sc.lut, &sc.plan, &sc.tone) > 0) {
            return sc;
        }
    }
    fail_msg("no scene");
    return sc;
}

/* The last 64 bytes of a workspace are used, and one byte less is refused. */
static void workspace_is_needed(void **state)
{
    (void)state;
    for (int32_t kind = NCC; kind <= GRADIENT; kind++) {
        scene sc = some_scene(kind);
        plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_FAST);
        size_t need = plfx_stream_ws(&c);
        int32_t next = 0;
        plfx_stream s;
        int touched = 0;
        assert_int_equal(plfx_stream_init(&s, &c, workspace(), need - 1), PLFX_E_SIZE);
        memset(workspace(), 0xa5, need);
        assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_OK);
        feed(&s, &sc, 0, sc.raw.h, &next);
        for (size_t i = need - 64; i < need; i++) {
            touched |= workspace()[i] != 0xa5;
        }
        assert_true(touched);
    }
}

/* Five views, 17 slopes, window 9 of the 16-megapixel frame: what README states. */
static void memory_of_a_large_frame(void **state)
{
    static const char *const name[2] = {"correlation", "gradient"};
    scene sc;

    (void)state;
    for (int32_t kind = NCC; kind <= GRADIENT; kind++) {
        plfx_cfg g;
        plfx_stream_cfg c;
        memset(&sc, 0, sizeof sc);
        memset(&g, 0, sizeof g);
        sc.kind = kind;
        sc.lut.sensor_w = 4904;
        sc.lut.sensor_h = 3280;
        sc.lut.lattice.nx = 289;
        sc.lut.lattice.ny = 193;
        sc.lut.lattice.a.x_q22 = q22(16.93);
        sc.lut.lattice.b.y_q22 = q22(16.93);
        g.window = 9;
        g.bits = 12;
        g.labels = 17;
        g.slope_min_q16 = -10000;
        g.slope_max_q16 = 10000;
        g.n = 5;
        if (kind == NCC) {
            g.method = PLFX_METHOD_PAIRS;
            g.cost = PLFX_COST_ZNCC;
            g.ref = 2;
        } else {
            g.method = PLFX_METHOD_GRADIENT;
        }
        for (int32_t k = 0; k < 5; k++) {
            g.at[k].u_q8 = (int16_t)(kind == NCC ? 768 * (k - 2)
                                     : k == 2    ? 768
                                     : k == 1    ? -768
                                                 : 0);
            g.at[k].v_q8 = (int16_t)(kind == NCC ? 0
                                     : k == 4    ? 768
                                     : k == 3    ? -768
                                                 : 0);
        }
        assert_int_equal(plfx_plan_init(&sc.plan, &g, &sc.lut, 289, 193), PLFX_OK);
        memset(&c, 0, sizeof c);
        c.plan = &sc.plan;
        c.lut = &sc.lut;
        c.tone = plfx_tone_unity(12);
        c.format = PLFX_RAW_U16;
        c.bits = 12;
        c.open_rows = 1;
        c.j1 = 193;
        print_message("# %s: %u bytes, bound %u\n", name[kind - NCC],
                      (unsigned)plfx_stream_ws(&c), (unsigned)bound_of(&sc, &c));
        assert_in_range(plfx_stream_ws(&c), 1, bound_of(&sc, &c));
    }
}

/* A map with fewer rows than a window and its stencil: all of it is border. */
static void no_row_holds_a_stencil(void **state)
{
    int32_t tried = 0;

    (void)state;
    for (uint32_t seed = 1; seed < 3000 && tried < 3; seed++) {
        ref_rng rng = {seed};
        scene sc;
        sc.kind = GRADIENT;
        if (make(&sc, &rng) && sc.plan.ny == sc.plan.cfg.window &&
            plfx_stream_open_rows(&sc.lut, &sc.plan, &sc.tone) > 0) {
            whole_frame(&sc);
            stream_once(&sc, &rng, PLFX_PROFILE_SMALL, seed);
            tried++;
        }
    }
    assert_int_equal(tried, 3);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(correlation_equals_whole_frame),
    cmocka_unit_test(gradient_equals_whole_frame),
    cmocka_unit_test(workspace_is_needed),
    cmocka_unit_test(memory_of_a_large_frame),
    cmocka_unit_test(no_row_holds_a_stencil),
};

SUITE(tests)
