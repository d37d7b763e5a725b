/* SPDX-License-Identifier: MIT
 * A stream beside the same method over a whole frame.  The test that includes this says
 * what the method is and which macro bounds its workspace. */
#ifndef PLENOFIX_TEST_STREAM_RUN_H
#define PLENOFIX_TEST_STREAM_RUN_H

#include "stream_scene.h"

static uint16_t samples[CELLS * MAX_N];

/* By the test: the map of whole views, and the macro of plfx_stream_ws(). */
static plfx_status match_views(const scene *sc, const plfx_views *v, const plfx_map *m);
static size_t bound_of(const plfx_stream_cfg *c);

static void whole_frame(const scene *sc)
{
    plfx_views v = {samples, sc->plan.nx, sc->plan.ny, sc->plan.cfg.n};
    plfx_map m = map_of(&want, &sc->plan);

    assert_int_equal(
        plfx_view_all(&sc->lut, &sc->raw, &sc->tone, sc->plan.cfg.at, sc->white, &v),
        PLFX_OK);
    assert_int_equal(match_views(sc, &v, &m), PLFX_OK);
}

/* Some rows of every third stream, all of the others. */
static void some_rows(plfx_stream_cfg *c, ref_rng *rng)
{
    if (ref_range(rng, 0, 2) == 0) {
        c->j0 = ref_range(rng, 0, c->plan->ny - 1);
        c->j1 = ref_range(rng, c->j0 + 1, c->plan->ny);
    }
}

/* A frame that is left in the middle. */
static void abandon(plfx_stream *s, const scene *sc)
{
    int32_t next = s->cfg.j0;

    feed(s, sc, 0, sc->raw.h / 2, &next);
    assert_int_equal(plfx_stream_reset(s), PLFX_OK);
}

/* A frame, after an abandoned one now and then, by rows or bands. */
static void stream_frame(plfx_stream *s, const scene *sc, ref_rng *rng)
{
    int32_t next = s->cfg.j0;
    int32_t first = 0;
    int32_t last;

    if (ref_range(rng, 0, 2) == 0) {
        abandon(s, sc);
    }
    plfx_stream_rows(s, &first, &last);
    if (s->cfg.format == PLFX_RAW_U16 && ref_range(rng, 0, 1)) {
        feed_bands(s, sc, &next);
    } else {
        feed(s, sc, first < sc->raw.h ? first : 0, sc->raw.h, &next);
    }
    assert_int_equal(next, s->cfg.j1);
    assert_int_equal(plfx_stream_finish(s), PLFX_OK);
}

static void stream_once(const scene *sc, ref_rng *rng, int32_t profile, unsigned seed)
{
    plfx_stream_cfg c = stream_cfg(sc, profile);
    plfx_stream s;
    size_t need;

    some_rows(&c, rng);
    need = plfx_stream_ws(&c);
    assert_in_range(need, 1, WS_BYTES);
    assert_in_range(bound_of(&c), need, WS_BYTES);
    memset(workspace(), (int)(seed & 255), need + 64);
    memset(&got, 0x5a, sizeof got);
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_OK);
    stream_frame(&s, sc, rng);
    for (size_t i = 0; i < 64; i++) {
        assert_int_equal(workspace()[need + i], seed & 255);
    }
    compare(sc, c.j0, c.j1, profile, seed);
}

/* Scenes of a kind, both profiles of each; how many of the seeds had one. */
static int stream_all(int32_t kind, uint32_t seeds)
{
    int n = 0;

    for (uint32_t seed = 1; seed <= seeds; seed++) {
        ref_rng rng = {seed};
        scene sc;
        if (make(&sc, kind, &rng)) {
            whole_frame(&sc);
            stream_once(&sc, &rng, PLFX_PROFILE_SMALL, seed);
            stream_once(&sc, &rng, PLFX_PROFILE_FAST, seed);
            n++;
        }
    }
    print_message("# %d geometries, two profiles each\n", n);
    return n;
}

/* The last 64 bytes of a workspace are used, and one byte less is refused. */
static void all_of_the_workspace_is_needed(int32_t kind)
{
    scene sc = some_scene(kind);

    for (int32_t profile = 0; profile < 2; profile++) {
        plfx_stream_cfg c = stream_cfg(&sc, profile);
        size_t need = plfx_stream_ws(&c);
        size_t touched = 0;
        int32_t next = 0;
        plfx_stream s;
        assert_int_equal(plfx_stream_init(&s, &c, workspace(), need - 1), PLFX_E_SIZE);
        memset(workspace(), 0x77, need);
        assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_OK);
        feed(&s, &sc, 0, sc.raw.h, &next);
        for (size_t i = 0; i < need; i++) {
            touched = workspace()[i] != 0x77 ? i + 1 : touched;
        }
        assert_in_range(touched, need - 64, need);
    }
}

/* Settings for the frame that README speaks of: 16 megapixels, 289x193 lenses, slopes
 * of 17 labels.  Nothing of the table's content is read. */
static plfx_cfg large_cfg(void)
{
    plfx_cfg g;

    memset(&g, 0, sizeof g);
    g.window = 9;
    g.bits = 12;
    g.labels = 17;
    g.slope_min_q16 = -10000;
    g.slope_max_q16 = 10000;
    return g;
}

static plfx_stream_cfg large_stream(scene *sc, const plfx_cfg *g, int32_t profile)
{
    sc->lut.sensor_w = 4904;
    sc->lut.sensor_h = 3280;
    sc->lut.lattice.nx = 289;
    sc->lut.lattice.ny = 193;
    sc->lut.lattice.a.x_q22 = q22(16.93);
    sc->lut.lattice.b.y_q22 = q22(16.93);
    assert_int_equal(plfx_plan_init(&sc->plan, g, &sc->lut, 289, 193), PLFX_OK);
    sc->tone = plfx_tone_unity(12);
    sc->sent.format = PLFX_RAW_U16;
    sc->sent.bits = 12;
    return stream_cfg(sc, profile);
}

#endif
