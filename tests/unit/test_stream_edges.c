/* SPDX-License-Identifier: MIT
 * Tables at the edge of what a stream takes: rows without a lens, rows that wait for
 * each other, rows that go back, lenses at the last row of the sensor. */
#include "suite.h"

#include "plenofix/stream.h"
#include "plenofix/sweep.h"

#define NX   12
#define NY   12
#define LENS 4
#define W    (NX * LENS + 8)
#define H    (NY * LENS + 48)
#define ROOM 150000

static uint64_t memory[ROOM / 8];
static uint16_t frame[W * H], samples[NX * NY * 3];
static uint8_t blob[1024], flags[NX * NY];
static int16_t resid[NX * NY * 2]; /* q12 pixels: x, y of a lens */
static plfx_lut_desc desc;
static plfx_lut lut;
static plfx_plan plan;
static plfx_tone tone;
static int32_t whole[NX * NY], got[NX * NY];

static void describe(void)
{
    int32_t k;

    memset(flags, 0, sizeof flags);
    memset(resid, 0, sizeof resid);
    memset(&desc, 0, sizeof desc);
    desc.sensor_w = W;
    desc.sensor_h = H;
    desc.sensor_bits = 12;
    desc.lattice.nx = NX;
    desc.lattice.ny = NY;
    desc.lattice.origin.x_q16 = 4 << 16;
    desc.lattice.origin.y_q16 = 8 << 16;
    desc.lattice.a.x_q22 = LENS << 22;
    desc.lattice.b.y_q22 = LENS << 22;
    desc.flags = flags;
    desc.resid_q12 = resid;
    tone = plfx_tone_unity(10);
    for (k = 0; k < W * H; k++) {
        frame[k] = (uint16_t)((uint32_t)k * 2654435761u >> 20 & 4095u);
    }
}

/* Rows that have to be open at once; 0: the table is not one for streams. */
static int32_t open_rows(void)
{
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.window = 3;
    c.bits = 10;
    c.n = 3;
    c.labels = 5;
    c.slope_min_q16 = -65536;
    c.slope_max_q16 = 65536;
    c.at[1].u_q8 = 256;
    c.at[2].v_q8 = 200;
    assert_int_equal(plfx_lut_write(&desc, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_plan_init(&plan, &c, &lut, NX, NY), PLFX_OK);
    return plfx_stream_open_rows(&lut, &plan, &tone);
}

static plfx_stream_cfg stream_cfg(int32_t profile, int32_t open)
{
    plfx_stream_cfg c;

    memset(&c, 0, sizeof c);
    c.plan = &plan;
    c.lut = &lut;
    c.tone = tone;
    c.profile = (uint8_t)profile;
    c.format = PLFX_RAW_U16;
    c.bits = 12;
    c.open_rows = open;
    c.j1 = NY;
    return c;
}

static void pop(plfx_stream *s, int32_t ready, int32_t *rows)
{
    while (ready > 0) {
        plfx_map row = {got + *rows * NX, NULL, NULL, NULL, NX, 1, NX};
        int32_t j;
        assert_int_equal(plfx_stream_pop(s, &j, &row, &ready), PLFX_OK);
        assert_int_equal(j, *rows);
        (*rows)++;
    }
}

/* Both profiles give the map of the whole frame. */
static void stream_equals_whole(int32_t open)
{
    plfx_raw raw = {(const uint8_t *)frame, sizeof frame, PLFX_RAW_U16, 12, W, H};
    plfx_views v = {samples, NX, NY, 3};
    plfx_map m = {whole, NULL, NULL, NULL, NX, NY, NX};
    int32_t profile;

    assert_int_equal(plfx_view_all(&lut, &raw, &tone, plan.cfg.at, 0, &v), PLFX_OK);
    assert_int_equal(plfx_sweep(&plan, &v, &m, aligned(memory), ROOM - 64), PLFX_OK);
    for (profile = 0; profile < 2; profile++) {
        plfx_stream_cfg c = stream_cfg(profile, open);
        plfx_stream s;
        int32_t rows = 0;
        int32_t y;
        assert_int_equal(plfx_stream_init(&s, &c, aligned(memory), ROOM - 64), PLFX_OK);
        memset(got, 0x5a, sizeof got);
        for (y = 0; y < H; y++) {
            plfx_raw_row row;
            int32_t ready = 0;
            assert_int_equal(plfx_raw_row_at(&raw, y, &row), PLFX_OK);
            assert_int_equal(plfx_stream_push(&s, y, &row, &ready), PLFX_OK);
            pop(&s, ready, &rows);
        }
        assert_int_equal(rows, NY);
        assert_int_equal(plfx_stream_finish(&s), PLFX_OK);
        assert_memory_equal(got, whole, sizeof got);
    }
}

static void rows_without_a_lens_are_passed(void **state)
{
    int32_t k;

    (void)state;
    describe();
    k = open_rows();
    assert_in_range(k, 1, PLFX_STREAM_OPEN_MAX);
    stream_equals_whole(k);
    memset(flags + 3 * NX, PLFX_LENS_MISSING, 2 * NX);
    assert_in_range(open_rows(), 1, k);
    stream_equals_whole(k);
}

/* The last lens row lies on the last rows of the sensor and beyond. */
static void lenses_at_the_last_row(void **state)
{
    int32_t down;

    (void)state;
    for (down = 0; down < 4; down++) {
        describe();
        desc.lattice.origin.y_q16 = (H - 1 - (NY - 1) * LENS + down - 1) * 65536 - 9000;
        stream_equals_whole(open_rows());
    }
}

/* A tilt makes rows wait for each other; too few open ones are refused. */
static void rows_that_overlap_are_open_together(void **state)
{
    plfx_stream_cfg c;
    plfx_stream s;
    int32_t open;

    (void)state;
    describe();
    desc.lattice.a.y_q22 = 2 << 20; /* half a pixel a lens, six a row */
    open = open_rows();
    assert_in_range(open, 2, PLFX_STREAM_OPEN_MAX);
    stream_equals_whole(open);
    c = stream_cfg(0, open - 1);
    assert_true(plfx_stream_ws(&c) > 0);
    assert_int_equal(plfx_stream_init(&s, &c, aligned(memory), ROOM - 64),
                     PLFX_E_RANGE);
    desc.lattice.a.y_q22 = LENS << 22; /* eleven rows a row */
    desc.lattice.origin.y_q16 = 0;
    assert_int_equal(open_rows(), 0);
    c = stream_cfg(0, PLFX_STREAM_OPEN_MAX);
    assert_int_equal(plfx_stream_init(&s, &c, aligned(memory), ROOM - 64),
                     PLFX_E_RANGE);
}

/* One lens far up in its row begins before the row above it does; one far down ends
 * after the row below; rows in the order from below do both. */
static void rows_that_go_back_are_refused(void **state)
{
    (void)state;
    describe();
    resid[2 * (3 * NX + 5) + 1] = -7 * 4096;
    assert_int_equal(open_rows(), 0);
    describe();
    resid[2 * (3 * NX + 5) + 1] = 7 * 4096;
    assert_int_equal(open_rows(), 0);
    describe();
    desc.lattice.origin.y_q16 = (8 + (NY - 1) * LENS) << 16;
    desc.lattice.b.y_q22 = -LENS * (1 << 22);
    assert_int_equal(open_rows(), 0);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(rows_without_a_lens_are_passed),
    cmocka_unit_test(lenses_at_the_last_row),
    cmocka_unit_test(rows_that_overlap_are_open_together),
    cmocka_unit_test(rows_that_go_back_are_refused),
};

SUITE(tests)
