/* SPDX-License-Identifier: MIT
 * A stream whose lens table comes row by row: the map of the table read in place, to
 * the bit, and rows that come too late, too early or out of order. */
#include "stream_scene.h"

static unsigned char bare[16384]; /* the table without what is fed */

/* Rows of the table out of the arrays that it was written from. */
static plfx_lens_row lens_row(const scene *sc, int32_t j)
{
    size_t at = (size_t)j * (size_t)sc->lut.lattice.nx;
    plfx_lens_row row = {NULL, NULL, NULL};

    row.resid_q12 = sc->lut.resi.length ? scene_resid + 2 * at : NULL;
    row.flags = sc->lut.flag.length ? scene_flags + at : NULL;
    row.lens_gain_u13 = sc->lut.gain.length ? scene_gain + at : NULL;
    return row;
}

/* The table of a fed stream: residuals and flags gone, gains of lenses overwritten. */
static plfx_lut without_rows(const scene *sc)
{
    plfx_lut lut = sc->lut;
    size_t lenses = 2 * (size_t)lut.lattice.nx * (size_t)lut.lattice.ny;

    memcpy(bare, blob, sizeof bare);
    if (lut.gain.length) {
        memset(bare + lut.gain.offset + lut.gain.length - lenses, 0xa5, lenses);
    }
    lut.blob = bare;
    lut.resi.length = 0;
    lut.flag.length = 0;
    return lut;
}

static void supply(plfx_stream *s, const scene *sc, int32_t *next)
{
    int32_t j = plfx_stream_wants(s);

    while (j >= 0) {
        plfx_lens_row row = lens_row(sc, j);
        int32_t ready = 0;
        assert_int_equal(plfx_stream_feed(s, j, &row, &ready), PLFX_OK);
        pop_all(s, next, ready);
        j = plfx_stream_wants(s);
    }
}

static void feed_all(plfx_stream *s, const scene *sc, int32_t *next)
{
    supply(s, sc, next);
    for (int32_t y = 0; y < sc->raw.h; y++) {
        plfx_raw_row row;
        int32_t ready = 0;
        assert_int_equal(plfx_raw_row_at(&sc->sent, y, &row), PLFX_OK);
        assert_int_equal(plfx_stream_push(s, y, &row, &ready), PLFX_OK);
        pop_all(s, next, ready);
        supply(s, sc, next);
    }
}

/* The map of the table in place, by the stream itself. */
static void in_place(const scene *sc, const plfx_stream_cfg *fed)
{
    plfx_stream_cfg c = *fed;
    plfx_stream s;
    int32_t next = c.j0;

    c.fed = 0;
    c.lut = &sc->lut;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    feed(&s, sc, 0, sc->raw.h, &next);
    assert_int_equal(plfx_stream_finish(&s), PLFX_OK);
    want = got;
}

static void fed_once(const scene *sc, ref_rng *rng, int32_t profile, unsigned seed)
{
    plfx_lut lut = without_rows(sc);
    plfx_stream_cfg c = stream_cfg(sc, profile);
    plfx_stream s;
    int32_t next;
    size_t need;

    c.fed = 1;
    c.lut = &lut;
    c.open_rows = ref_range(rng, c.open_rows, PLFX_STREAM_OPEN_MAX);
    if (ref_range(rng, 0, 2) == 0) {
        c.j0 = ref_range(rng, 0, sc->plan.ny - 1);
        c.j1 = ref_range(rng, c.j0 + 1, sc->plan.ny);
    }
    in_place(sc, &c);
    need = plfx_stream_ws(&c);
    assert_in_range(need, 1, WS_BYTES);
    c.fed = 0;
    assert_true(need <= plfx_stream_ws(&c) + PLFX_STREAM_FED_WS((size_t)sc->plan.nx,
                                                                (size_t)c.open_rows));
    c.fed = 1;
    memset(workspace(), (int)(seed & 255), need + 64);
    memset(&got, 0x5a, sizeof got);
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), need), PLFX_OK);
    for (int32_t round = 0; round < 2; round++) { /* the table comes with every frame */
        next = c.j0;
        feed_all(&s, sc, &next);
        assert_int_equal(plfx_stream_finish(&s), PLFX_OK);
        compare(sc, c.j0, c.j1, profile, seed);
        assert_int_equal(plfx_stream_reset(&s), PLFX_OK);
    }
    for (size_t i = 0; i < 64; i++) {
        assert_int_equal(workspace()[need + i], seed & 255);
    }
}

static void equals_the_table_in_place(void **state)
{
    int run = 0;

    (void)state;
    for (uint32_t seed = 1; seed <= 300; seed++) {
        ref_rng rng = {seed};
        scene sc;
        if (make(&sc, (int32_t)(seed % 4), &rng)) { /* every kind */
            fed_once(&sc, &rng, (int32_t)(seed & 1), seed);
            run++;
        }
    }
    print_message("# %d geometries\n", run);
    assert_true(run >= 250);
}

static void order_of_rows(void **state)
{
    scene sc = some_scene(SUMS);
    plfx_lut lut = without_rows(&sc);
    plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_FAST);
    plfx_lens_row row = lens_row(&sc, 0);
    plfx_raw_row raw;
    plfx_stream s;
    int32_t ready = 0;
    int32_t first = -1;
    int32_t last = -1;

    (void)state;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    assert_int_equal(plfx_stream_wants(&s), -1); /* read in place */
    assert_int_equal(plfx_stream_feed(&s, 0, &row, &ready), PLFX_E_STATE);
    c.fed = 2;
    assert_int_equal(plfx_stream_ws(&c), 0);
    c.fed = 1;
    c.lut = &lut;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    plfx_stream_rows(&s, &first, &last);
    assert_true(first == 0 && last == sc.raw.h - 1);
    assert_int_equal(plfx_stream_wants(&s), 0);
    assert_int_equal(plfx_stream_wants(NULL), -1);
    assert_int_equal(plfx_raw_row_at(&sc.sent, 0, &raw), PLFX_OK);
    assert_int_equal(plfx_stream_push(&s, 0, &raw, &ready),
                     PLFX_E_STATE); /* no table */
    assert_int_equal(plfx_stream_feed(&s, 1, &row, &ready), PLFX_E_STATE);
    assert_int_equal(plfx_stream_feed(&s, -1, &row, &ready), PLFX_E_STATE);
    assert_int_equal(plfx_stream_feed(&s, 0, NULL, &ready), PLFX_E_ARG);
    assert_int_equal(plfx_stream_feed(&s, 0, &row, NULL), PLFX_E_ARG);
    assert_int_equal(plfx_stream_feed(&s, 0, &row, &ready), PLFX_OK);
    assert_int_equal(plfx_stream_feed(&s, 0, &row, &ready), PLFX_E_STATE); /* twice */
}

/* A stream that no init has seen. */
static void no_stream(void **state)
{
    plfx_lens_row row = {NULL, NULL, NULL};
    plfx_stream s;
    int32_t ready = 0;

    (void)state;
    memset(&s, 0, sizeof s);
    assert_int_equal(plfx_stream_wants(&s), -1);
    assert_int_equal(plfx_stream_feed(&s, 0, &row, &ready), PLFX_E_ARG);
    assert_int_equal(plfx_stream_feed(NULL, 0, &row, &ready), PLFX_E_ARG);
}

/* Rows without a measured lens wait for nothing; rows that begin or end before the one
 * above them are refused; a band stops where a row of the table is wanted. */
static void rows_of_the_sensor(void **state)
{
    static uint8_t gone[MAX_NX];
    static int16_t moved[2 * MAX_NX];
    scene sc = some_scene(SUMS);
    plfx_lut lut = without_rows(&sc);
    plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_SMALL);
    plfx_raw band = sc.raw;
    plfx_lens_row row = {NULL, gone, NULL};
    plfx_stream s;
    int32_t ready = 0;
    int32_t used = 0;

    (void)state;
    memset(gone, PLFX_LENS_MISSING, sizeof gone);
    c.fed = 1;
    c.lut = &lut;
    c.open_rows = 2;
    c.format = PLFX_RAW_U16;
    c.bits = sc.raw.bits;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    assert_int_equal(plfx_stream_feed(&s, 0, &row, &ready), PLFX_OK);
    row.flags = NULL;
    assert_int_equal(plfx_stream_feed(&s, 1, &row, &ready), PLFX_OK);
    assert_int_equal(plfx_stream_wants(&s), -1);
    assert_int_equal(plfx_stream_push_band(&s, 0, &band, &used, &ready), PLFX_OK);
    assert_true(used > 0 && used < band.h);
    assert_int_equal(plfx_stream_reset(&s), PLFX_OK);
    for (int32_t i = 0; i < sc.plan.nx; i++) {
        moved[2 * i + 1] = 8 * 4096 - 1; /* row 0 stands 8 px lower than it should, */
    }
    row.resid_q12 = moved;
    assert_int_equal(plfx_stream_feed(&s, 0, &row, &ready), PLFX_OK);
    for (int32_t i = 0; i < sc.plan.nx; i++) {
        moved[2 * i + 1] = -8 * 4096; /* row 1 higher, */
    }
    assert_int_equal(plfx_stream_feed(&s, 1, &row, &ready), PLFX_E_RANGE);
    for (int32_t i = 0; i < sc.plan.nx; i++) {
        moved[2 * i + 1] = 0;
    }
    assert_int_equal(plfx_stream_wants(&s), 1); /* and is still wanted */
}

/* A waiting map row comes first; then a band stops at the sensor row behind which the
 * table is wanted, and takes none before it has come. */
static void a_band_stops_for_the_table(void **state)
{
    scene sc = some_scene(SUMS);
    plfx_lut lut = without_rows(&sc);
    plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_SMALL);
    plfx_raw band = sc.raw;
    plfx_lens_row row = lens_row(&sc, 0);
    plfx_stream s;
    int32_t ready = 0;
    int32_t used = 0;
    int32_t next = 0;
    int32_t y;

    (void)state;
    c.fed = 1;
    c.lut = &lut;
    c.format = PLFX_RAW_U16;
    c.bits = sc.raw.bits;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    supply(&s, &sc, &next);
    assert_int_equal(plfx_stream_push_band(&s, 0, &band, &used, &ready), PLFX_OK);
    assert_true(ready > 0); /* rows too near the border for a window */
    assert_int_equal(plfx_stream_wants(&s), -1);
    assert_int_equal(plfx_stream_feed(&s, 0, &row, &ready), PLFX_E_STATE);
    pop_all(&s, &next, ready);
    y = used;
    band.bytes += (size_t)y * (size_t)band.w * sizeof(uint16_t);
    band.size -= (size_t)y * (size_t)band.w * sizeof(uint16_t);
    band.h -= y;
    assert_int_equal(plfx_stream_push_band(&s, y, &band, &used, &ready), PLFX_OK);
    assert_int_equal(ready, 0);
    assert_true(used > 0 && used < band.h);
    assert_true(plfx_stream_wants(&s) > 0);
    y += used;
    assert_int_equal(plfx_stream_push_band(&s, y, &band, &used, &ready), PLFX_E_STATE);
    assert_int_equal(used, 0);
}

/* A lens of row 0 that reaches far down and a row 1 that stands high, but not above
 * row 0: it would end first. */
static void a_row_that_ends_before_the_one_above(void **state)
{
    static int16_t moved[2 * MAX_NX];
    scene sc = some_scene(SUMS);
    plfx_lut lut = without_rows(&sc);
    plfx_stream_cfg c = stream_cfg(&sc, PLFX_PROFILE_SMALL);
    plfx_lens_row row = {moved, NULL, NULL};
    plfx_stream s;
    int32_t lowest = 0;
    int32_t ready = 0;
    int32_t i;

    (void)state;
    c.fed = 1;
    c.lut = &lut;
    c.open_rows = 2;
    for (i = 1; i < sc.plan.nx; i++) {
        lowest =
            plfx_lut_centre(&lut, i, 0).y_q16 > plfx_lut_centre(&lut, lowest, 0).y_q16
                ? i
                : lowest;
    }
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    memset(moved, 0, sizeof moved);
    moved[2 * lowest + 1] = 8 * 4096 - 1;
    assert_int_equal(plfx_stream_feed(&s, 0, &row, &ready), PLFX_OK);
    for (i = 0; i < sc.plan.nx; i++) {
        moved[2 * i + 1] = -7 * 4096;
    }
    assert_int_equal(plfx_stream_feed(&s, 1, &row, &ready), PLFX_E_RANGE);
    memset(moved, 0, sizeof moved);
    moved[2 * lowest + 1] = 8 * 4096 - 1;
    assert_int_equal(plfx_stream_feed(&s, 1, &row, &ready), PLFX_OK);
}

/* With one row open where the table needs more, a lens row asks for sensor rows that
 * went by. */
static void too_few_open_rows(void **state)
{
    plfx_status status = PLFX_OK;
    scene sc;
    plfx_lut lut;
    plfx_stream_cfg c;
    plfx_stream s;

    (void)state;
    for (uint32_t seed = 1; seed < 300; seed++) {
        ref_rng rng = {seed};
        if (make(&sc, SUMS, &rng) &&
            plfx_stream_open_rows(&sc.lut, &sc.plan, &sc.tone) > 1) {
            break;
        }
    }
    lut = without_rows(&sc);
    c = stream_cfg(&sc, PLFX_PROFILE_SMALL);
    assert_true(c.open_rows > 1);
    c.open_rows = 1;
    c.fed = 1;
    c.lut = &lut;
    assert_int_equal(plfx_stream_init(&s, &c, workspace(), WS_BYTES), PLFX_OK);
    for (int32_t y = 0; y < sc.raw.h && status == PLFX_OK; y++) {
        plfx_raw_row raw;
        int32_t ready = 0;
        int32_t next = s.j;
        int32_t j = plfx_stream_wants(&s);
        if (j >= 0) {
            plfx_lens_row row = lens_row(&sc, j);
            status = plfx_stream_feed(&s, j, &row, &ready);
            pop_all(&s, &next, ready);
        }
        if (status == PLFX_OK && plfx_stream_wants(&s) < 0) {
            assert_int_equal(plfx_raw_row_at(&sc.sent, y, &raw), PLFX_OK);
            assert_int_equal(plfx_stream_push(&s, y, &raw, &ready), PLFX_OK);
            pop_all(&s, &next, ready);
        }
    }
    assert_int_equal(status, PLFX_E_RANGE);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(equals_the_table_in_place),
    cmocka_unit_test(order_of_rows),
    cmocka_unit_test(no_stream),
    cmocka_unit_test(rows_of_the_sensor),
    cmocka_unit_test(a_band_stops_for_the_table),
    cmocka_unit_test(a_row_that_ends_before_the_one_above),
    cmocka_unit_test(too_few_open_rows),
};

SUITE(tests)
