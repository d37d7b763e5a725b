/* SPDX-License-Identifier: MIT
 * Streams of methods that keep rows of the views: pairs by normalised correlation
 * against plfx_sweep(), the gradient against plfx_gradient(), the same bits. */
#include "stream_run.h"
#include "plenofix/gradient.h"
#include "plenofix/sweep.h"

static plfx_status match_views(const scene *sc, const plfx_views *v, const plfx_map *m)
{
    return sc->kind == GRADIENT ? plfx_gradient(&sc->plan, v, m, workspace(), WS_BYTES)
                                : plfx_sweep(&sc->plan, v, m, workspace(), WS_BYTES);
}

static size_t bound_of(const plfx_stream_cfg *c)
{
    const plfx_plan *p = c->plan;
    size_t packed_w = c->format == PLFX_RAW_U16 ? 0u : (size_t)c->lut->sensor_w;

    if (p->cfg.method == PLFX_METHOD_GRADIENT) {
        return PLFX_STREAM_GRADIENT_WS((size_t)p->nx, packed_w, (size_t)p->cfg.window,
                                       (size_t)c->open_rows,
                                       c->profile == PLFX_PROFILE_FAST);
    }
    return PLFX_STREAM_NCC_WS(
        (size_t)p->nx, packed_w, (size_t)p->cfg.n, (size_t)p->cfg.labels,
        (size_t)p->cfg.window, (size_t)p->reach_x, (size_t)p->reach_y,
        (size_t)c->open_rows, c->profile == PLFX_PROFILE_FAST, (size_t)PLFX_LANES);
}

static void correlation_equals_whole_frame(void **state)
{
    (void)state;
    assert_true(stream_all(NCC, 300) >= 250); /* others do not fit */
}

static void gradient_equals_whole_frame(void **state)
{
    (void)state;
    assert_true(stream_all(GRADIENT, 300) >= 250);
}

static void workspace_is_needed(void **state)
{
    (void)state;
    all_of_the_workspace_is_needed(NCC);
    all_of_the_workspace_is_needed(GRADIENT);
}

/* Five views along u, or a cross of them. */
static void memory_of_a_large_frame(void **state)
{
    static const char *const name[2] = {"correlation", "gradient"};
    static const int16_t across[5][2] = {
        {0, 0}, {-768, 0}, {768, 0}, {0, -768}, {0, 768}};

    (void)state;
    for (int32_t kind = NCC; kind <= GRADIENT; kind++) {
        plfx_cfg g = large_cfg();
        plfx_stream_cfg c;
        scene sc;
        size_t need;
        memset(&sc, 0, sizeof sc);
        g.method = kind == NCC ? PLFX_METHOD_PAIRS : PLFX_METHOD_GRADIENT;
        g.cost = kind == NCC ? PLFX_COST_ZNCC : PLFX_COST_SAD;
        g.n = 5;
        g.ref = kind == NCC ? 2 : 0;
        for (int32_t k = 0; k < 5; k++) {
            g.at[k].u_q8 = kind == NCC ? (int16_t)(768 * (k - 2)) : across[k][0];
            g.at[k].v_q8 = kind == NCC ? 0 : across[k][1];
        }
        c = large_stream(&sc, &g, PLFX_PROFILE_SMALL);
        need = plfx_stream_ws(&c);
        print_message("# %s: %u bytes, bound %u\n", name[kind - NCC], (unsigned)need,
                      (unsigned)bound_of(&c));
        assert_in_range(bound_of(&c), need, need * 5 / 4);
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
        if (make(&sc, GRADIENT, &rng) && sc.plan.ny == sc.plan.cfg.window) {
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
