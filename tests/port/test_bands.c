/* SPDX-License-Identifier: MIT
 * A map made while its frame still arrives: bands of a replay into the stream. */
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "../unit/suite.h"
#include "scratch.h"
#include "posix/replay.h"

#include "plenofix/plenofix.h"

#define W     320
#define H     240
#define NX    20
#define NY    15
#define VIEWS 5
#define BYTES (2u * W * H)
#define BAND  29 /* rows; divides nothing */

static uint8_t blob[256];
static uint8_t pixels[BYTES];
static uint8_t memory[2][PLFX_ALIGNED(BYTES)] __attribute__((aligned(PLFX_ALIGN)));
static uint8_t work[1u << 20] __attribute__((aligned(PLFX_ALIGN)));
static plfx_lut lut;
static plfx_plan plan;

static void prepare(void)
{
    plfx_lut_desc d;
    plfx_cfg cfg;
    int k;

    memset(&d, 0, sizeof d);
    d.sensor_w = W;
    d.sensor_h = H;
    d.sensor_bits = 12;
    d.lattice.nx = NX;
    d.lattice.ny = NY;
    d.lattice.origin.x_q16 = d.lattice.origin.y_q16 = 8 << 16;
    d.lattice.a.x_q22 = d.lattice.b.y_q22 = 15 * 4194304 + 3000000;
    d.radius_q8 = 6 * 256;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, sizeof blob), PLFX_OK);
    memset(&cfg, 0, sizeof cfg);
    cfg.fit = PLFX_FIT_VEE;
    cfg.window = 3;
    cfg.bits = 8;
    cfg.ref = VIEWS / 2;
    cfg.n = VIEWS;
    cfg.labels = 9;
    cfg.slope_min_q16 = -6000;
    cfg.slope_max_q16 = 6000;
    for (k = 0; k < VIEWS; k++) {
        cfg.at[k].u_q8 = (int16_t)((k - VIEWS / 2) * 600);
    }
    assert_int_equal(plfx_plan_init(&plan, &cfg, &lut, NX, NY), PLFX_OK);
}

static plfx_raw frame_of(uint32_t k)
{
    plfx_raw raw = {pixels, BYTES, PLFX_RAW_U16LE, 12, W, H};
    uint32_t i;

    for (i = 0; i < BYTES; i += 2) {
        uint32_t v = ((i * 37u) ^ (i / 640u * (91u + k))) * 2654435761u >> 20;
        pixels[i] = (uint8_t)v;
        pixels[i + 1] = (uint8_t)(v >> 8);
    }
    return raw;
}

static void record(const char *path)
{
    plfx_recording_info info = {W, H, PLFX_RAW_U16LE, 12, 0, 0, 0};
    plfx_recording r;
    uint32_t k;

    assert_int_equal(plfx_recording_create(&r, path, &info), PLFX_OK);
    for (k = 0; k < 2; k++) {
        plfx_camera_frame f;
        memset(&f, 0, sizeof f);
        f.raw = frame_of(k);
        f.rows = H;
        assert_int_equal(plfx_recording_add(&r, &f), PLFX_OK);
    }
    plfx_recording_close(&r);
}

static void whole_map(const plfx_raw *raw, int32_t *slope)
{
    static uint16_t px[VIEWS * NX * NY];
    plfx_views views = {px, NX, NY, VIEWS};
    plfx_tone tone = plfx_tone_unity(8);
    plfx_map map;

    memset(&map, 0, sizeof map);
    map.slope_q16 = slope;
    map.w = map.stride = NX;
    map.h = NY;
    assert_int_equal(plfx_view_all(&lut, raw, &tone, plan.cfg.at, 0, &views), PLFX_OK);
    assert_int_equal(plfx_sweep(&plan, &views, &map, work, sizeof work), PLFX_OK);
}

static void pop(plfx_stream *s, int32_t ready, int32_t *slope)
{
    plfx_map row;
    int32_t j;

    memset(&row, 0, sizeof row);
    row.w = row.stride = NX;
    row.h = 1;
    while (ready > 0) { /* at most the rows of the map */
        row.slope_q16 = slope + (size_t)s->j * NX;
        assert_int_equal(plfx_stream_pop(s, &j, &row, &ready), PLFX_OK);
    }
}

/* Rows from..to-1 of the frame, as they have come. */
static void push(plfx_stream *s, const plfx_camera_frame *f, int32_t from, int32_t to,
                 int32_t *slope)
{
    while (from < to) { /* at most one round a row */
        plfx_raw band = f->raw;
        int32_t used = 0;
        int32_t ready = 0;
        band.bytes += (size_t)from * W * 2u;
        band.h = to - from;
        band.size = (size_t)band.h * W * 2u;
        assert_int_equal(plfx_stream_push_band(s, from, &band, &used, &ready), PLFX_OK);
        assert_true(used > 0);
        pop(s, ready, slope);
        from += used;
    }
}

static void start_stream(plfx_stream *s)
{
    static plfx_stream_cfg cfg;

    cfg.plan = &plan;
    cfg.lut = &lut;
    cfg.tone = plfx_tone_unity(8);
    cfg.format = PLFX_RAW_U16LE;
    cfg.bits = 12;
    cfg.open_rows = plfx_stream_open_rows(&lut, &plan, &cfg.tone);
    cfg.j1 = NY;
    assert_int_equal(plfx_stream_init(s, &cfg, work, sizeof work), PLFX_OK);
}

static void bands_of_a_replay_give_the_whole_frame_s_map(void **state)
{
    static int32_t got[2][NX * NY];
    static int32_t want[NX * NY];
    plfx_clock none = {NULL, NULL, NULL, PLFX_CLOCK_NONE};
    plfx_pool pool = {memory[0], sizeof memory[0], 2};
    plfx_camera_cfg cfg;
    plfx_stream s;
    plfx_replay r;
    uint32_t k;

    (void)state;
    prepare();
    record(scratch("a"));
    plfx_replay_init(&r, scratch("a"), none);
    r.bands = 1;
    memset(&cfg, 0, sizeof cfg);
    assert_int_equal(r.camera.open(&r, &cfg, &pool), PLFX_OK);
    assert_int_equal(r.camera.start(&r), PLFX_OK);
    start_stream(&s);
    for (k = 0; k < 2; k++) {
        plfx_camera_frame f;
        int32_t early = 0;
        assert_int_equal(r.camera.acquire(&r, 0, &f), PLFX_OK);
        while (f.rows < H) { /* at most H / BAND + 1 rounds */
            int32_t had = f.rows;
            int32_t next = had + BAND < H ? had + BAND : H;
            assert_int_equal(r.camera.rows(&r, &f, next, 0), PLFX_OK);
            push(&s, &f, had, next, got[k]);
            early = next < H ? s.j : early;
        }
        assert_true(early >= NY / 2); /* rows of the map before the end of the frame */
        assert_int_equal(plfx_stream_finish(&s), PLFX_OK);
        assert_int_equal(plfx_stream_reset(&s), PLFX_OK);
        assert_int_equal(r.camera.release(&r, &f), PLFX_OK);
    }
    r.camera.close(&r);
    for (k = 0; k < 2; k++) {
        plfx_raw raw = frame_of(k);
        whole_map(&raw, want);
        assert_memory_equal(got[k], want, sizeof want);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(bands_of_a_replay_give_the_whole_frame_s_map),
};

int main(void)
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, scratch_make, scratch_drop);
}
