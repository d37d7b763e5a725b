/* SPDX-License-Identifier: MIT
 * Recordings and bare files as cameras, and tables mapped from files. */
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "../unit/suite.h"
#include "scratch.h"
#include "posix/clock.h"
#include "posix/replay.h"
#include "posix/table.h"

#include <fcntl.h>

#define W       20
#define H       9
#define PAYLOAD (W * H)
#define SLOT    192

static uint8_t memory[3 * SLOT];
static uint64_t fake_ns; /* a clock that the test moves */

static uint64_t fake_now(void *context)
{
    (void)context;
    return fake_ns;
}

static plfx_status fake_sleep(void *context, uint64_t ns)
{
    (void)context;
    fake_ns = ns;
    return PLFX_OK;
}

static plfx_clock fake_clock(void)
{
    plfx_clock c = {NULL, fake_now, fake_sleep, PLFX_CLOCK_MONOTONIC};

    return c;
}

static plfx_pool pool_of(int32_t slots)
{
    plfx_pool p = {memory, SLOT, slots};

    return p;
}

static void record(const char *path, const uint64_t *times_ms, uint32_t n)
{
    plfx_recording_info info = {W, H, PLFX_RAW_U8, 8, 0, 0, 0};
    uint8_t pixels[PAYLOAD];
    plfx_recording r;
    plfx_camera_frame f;
    uint32_t k;

    (void)unlink(path);
    assert_int_equal(plfx_recording_create(&r, path, &info), PLFX_OK);
    for (k = 0; k < n; k++) {
        memset(&f, 0, sizeof f);
        memset(pixels, (int)k + 1, sizeof pixels);
        pixels[PAYLOAD - 1] = 99;
        f.raw.bytes = pixels;
        f.raw.size = PAYLOAD;
        f.raw.bits = 8;
        f.raw.w = W;
        f.raw.h = f.rows = H;
        f.clock = PLFX_CLOCK_CAMERA;
        f.time_ns = times_ms[k] * 1000000u;
        f.sequence = k;
        assert_int_equal(plfx_recording_add(&r, &f), PLFX_OK);
    }
    plfx_recording_close(&r);
}

static void start(plfx_replay *r, const char *path, int32_t slots)
{
    plfx_camera_cfg cfg;
    plfx_pool pool = pool_of(slots);

    memset(&cfg, 0, sizeof cfg);
    fake_ns = 7000000000u;
    assert_int_equal(r->camera.open(r, &cfg, &pool), PLFX_OK);
    assert_int_equal(cfg.w, W);
    assert_int_equal(cfg.h, H);
    assert_int_equal(r->camera.start(r), PLFX_OK);
    (void)path;
}

static void frames_come_in_their_own_time(void **state)
{
    static const uint64_t times[] = {100, 140, 180, 150, 190};
    static const uint64_t due[] = {0, 40, 80, 80, 120}; /* the clock jumps back at 3 */
    plfx_camera_count count;
    plfx_replay r;
    plfx_camera_frame f;
    uint32_t k;

    (void)state;
    record(scratch("a"), times, 5);
    plfx_replay_init(&r, scratch("a"), fake_clock());
    start(&r, NULL, 2);
    for (k = 0; k < 5; k++) {
        assert_int_equal(r.camera.acquire(&r, 1000, &f), PLFX_OK);
        assert_int_equal(fake_ns, 7000000000u + due[k] * 1000000u);
        assert_int_equal(f.raw.bytes[0], k + 1);
        assert_ptr_equal(f.raw.bytes, memory + f.slot * SLOT);
        assert_int_equal(r.camera.release(&r, &f), PLFX_OK);
    }
    assert_int_equal(r.camera.acquire(&r, 1000, &f), PLFX_E_DEVICE);
    r.camera.count(&r, &count);
    assert_int_equal(count.good, 5);
    assert_int_equal(count.back, 1);
    assert_int_equal(r.camera.stop(&r), PLFX_OK);
    r.camera.close(&r);
}

static void waiting_ends_at_the_timeout(void **state)
{
    static const uint64_t times[] = {0, 500};
    plfx_replay r;
    plfx_camera_frame f;

    (void)state;
    record(scratch("b"), times, 2);
    plfx_replay_init(&r, scratch("b"), fake_clock());
    r.speed_q8 = 512; /* twice as fast: due after 250 ms */
    start(&r, NULL, 2);
    assert_int_equal(r.camera.acquire(&r, 10, &f), PLFX_OK);
    assert_int_equal(r.camera.acquire(&r, 200, &f), PLFX_E_TIMEOUT);
    assert_int_equal(fake_ns, 7200000000u);
    assert_int_equal(r.camera.acquire(&r, 200, &f), PLFX_OK);
    assert_int_equal(fake_ns, 7250000000u);
    r.camera.close(&r);
}

static void taken_slots_are_not_given_again(void **state)
{
    static const uint64_t times[] = {0, 0, 0, 0};
    plfx_camera_count count;
    plfx_replay r;
    plfx_camera_frame f[3];

    (void)state;
    record(scratch("c"), times, 4);
    plfx_replay_init(&r, scratch("c"), fake_clock());
    start(&r, NULL, 2);
    assert_int_equal(r.camera.acquire(&r, 0, &f[0]), PLFX_OK);
    assert_int_equal(r.camera.acquire(&r, 0, &f[1]), PLFX_OK);
    assert_int_equal(r.camera.acquire(&r, 0, &f[2]), PLFX_E_STATE);
    assert_int_equal(f[0].raw.bytes[0], 1);
    assert_int_equal(r.camera.release(&r, &f[0]), PLFX_OK);
    assert_int_equal(r.camera.release(&r, &f[0]), PLFX_E_ARG);
    assert_int_equal(r.camera.acquire(&r, 0, &f[2]), PLFX_OK);
    assert_int_equal(f[2].raw.bytes[0], 3); /* none was skipped */
    r.camera.count(&r, &count);
    assert_int_equal(count.starved, 1);
    r.camera.close(&r);
}

static void bands_arrive_row_by_row(void **state)
{
    static const uint64_t times[] = {0, 1};
    plfx_replay r;
    plfx_camera_frame f;
    int file;

    (void)state;
    record(scratch("d"), times, 2);
    plfx_replay_init(&r, scratch("d"), fake_clock());
    r.bands = 1;
    start(&r, NULL, 2);
    memset(memory, 0xee, sizeof memory);
    assert_int_equal(r.camera.acquire(&r, 9, &f), PLFX_OK);
    assert_int_equal(f.rows, 0);
    assert_int_equal(r.camera.rows(&r, &f, 4, 9), PLFX_OK);
    assert_int_equal(f.rows, 4);
    assert_int_equal(f.raw.bytes[4 * W - 1], 1);
    assert_int_equal(f.raw.bytes[4 * W], 0xee);
    assert_int_equal(r.camera.rows(&r, &f, H + 1, 9), PLFX_E_STATE);
    assert_int_equal(r.camera.rows(&r, &f, H, 9), PLFX_OK);
    assert_int_equal(f.raw.bytes[PAYLOAD - 1], 99);
    assert_int_equal(r.camera.release(&r, &f), PLFX_OK);
    assert_int_equal(r.camera.acquire(&r, 9, &f), PLFX_OK);
    file = open(scratch("d"), O_WRONLY); /* the second frame goes bad meanwhile */
    assert_int_equal(pwrite(file, "x", 1, 4096 + 512 + 64 + 7), 1);
    assert_int_equal(close(file), 0);
    assert_int_equal(r.camera.rows(&r, &f, 2, 9), PLFX_OK);
    assert_int_equal(r.camera.rows(&r, &f, H, 9), PLFX_E_FORMAT);
    r.camera.close(&r);
}

static void damaged_frames_are_counted_not_shown(void **state)
{
    static const uint64_t times[] = {0, 0, 0};
    plfx_camera_count count;
    plfx_replay r;
    plfx_camera_frame f;
    int file;

    (void)state;
    record(scratch("e"), times, 3);
    file = open(scratch("e"), O_WRONLY);
    assert_int_equal(pwrite(file, "x", 1, 4096 + 512 + 64 + 7), 1);
    assert_int_equal(close(file), 0);
    plfx_replay_init(&r, scratch("e"), fake_clock());
    start(&r, NULL, 3);
    assert_int_equal(r.camera.acquire(&r, 0, &f), PLFX_OK);
    assert_int_equal(r.camera.acquire(&r, 0, &f), PLFX_E_TIMEOUT);
    assert_int_equal(r.camera.acquire(&r, 0, &f), PLFX_OK);
    assert_int_equal(f.raw.bytes[0], 3);
    r.camera.count(&r, &count);
    assert_int_equal(count.incomplete, 1);
    r.camera.close(&r);
}

static void bare_files_play_too(void **state)
{
    plfx_camera_cfg cfg;
    plfx_pool pool = pool_of(3);
    plfx_replay r;
    plfx_camera_frame f;
    uint8_t two[2 * PAYLOAD];
    int k;

    (void)state;
    memset(two, 5, PAYLOAD);
    memset(two + PAYLOAD, 6, PAYLOAD);
    k = open(scratch("f"), O_WRONLY | O_CREAT, 0600);
    assert_int_equal(write(k, two, sizeof two), sizeof two);
    assert_int_equal(close(k), 0);
    plfx_replay_init(&r, scratch("f"), fake_clock());
    r.bare = 1;
    r.loop = 1;
    memset(&cfg, 0, sizeof cfg);
    assert_int_equal(r.camera.open(&r, &cfg, &pool), PLFX_E_ARG); /* no size */
    cfg.w = W;
    cfg.h = H;
    cfg.bits = 8;
    cfg.rate_mhz = 20000;
    fake_ns = 1;
    assert_int_equal(r.camera.open(&r, &cfg, &pool), PLFX_OK);
    assert_int_equal(r.camera.start(&r), PLFX_OK);
    for (k = 0; k < 6; k++) {
        assert_int_equal(r.camera.acquire(&r, 100, &f), PLFX_OK);
        assert_int_equal(f.raw.bytes[PAYLOAD - 1], 5 + k % 2);
        assert_int_equal(f.time_ns, k % 2 * 50000000);
        assert_int_equal(f.sequence, k); /* goes on where the file begins anew */
        assert_int_equal(r.camera.release(&r, &f), PLFX_OK);
    }
    r.camera.close(&r);
}

static void bad_cameras_are_refused(void **state)
{
    static const uint64_t times[] = {0};
    plfx_camera_cfg cfg;
    plfx_pool pool = pool_of(2);
    plfx_replay r;
    plfx_camera_frame f;

    (void)state;
    memset(&cfg, 0, sizeof cfg);
    plfx_replay_init(&r, scratch("absent"), fake_clock());
    assert_int_equal(r.camera.open(&r, &cfg, &pool), PLFX_E_DEVICE);
    record(scratch("g"), times, 1);
    plfx_replay_init(&r, scratch("g"), fake_clock());
    pool.slot_size = PAYLOAD - 1;
    assert_int_equal(r.camera.open(&r, &cfg, &pool), PLFX_E_SIZE);
    pool.slot_size = SLOT;
    cfg.w = W + 1; /* another size than the file's */
    assert_int_equal(r.camera.open(&r, &cfg, &pool), PLFX_E_ARG);
    assert_int_equal(r.camera.start(&r), PLFX_E_STATE);
    assert_int_equal(r.camera.acquire(&r, 0, &f), PLFX_E_STATE);
    assert_int_equal(r.camera.stop(&r), PLFX_E_STATE);
}

static void monotonic_clock_goes_on(void **state)
{
    plfx_clock c = plfx_posix_monotonic();
    uint64_t from = c.now_ns(c.context);

    (void)state;
    assert_int_equal(c.sleep_until(c.context, from + 3000000u), PLFX_OK);
    assert_true(c.now_ns(c.context) >= from + 3000000u);
}

static void tables_are_mapped(void **state)
{
    uint8_t blob[256];
    plfx_posix_table t;
    plfx_lut_desc d;
    size_t n;
    int file;

    (void)state;
    memset(&d, 0, sizeof d);
    d.sensor_w = d.sensor_h = 100;
    d.sensor_bits = 10;
    d.camera_id = 5;
    d.lattice.nx = d.lattice.ny = 9;
    d.lattice.a.x_q22 = d.lattice.b.y_q22 = 10 * 4194304;
    n = plfx_lut_bytes(&d);
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    file = open(scratch("t"), O_WRONLY | O_CREAT, 0600);
    assert_int_equal(write(file, blob, n), n);
    assert_int_equal(plfx_posix_table_open(&t, scratch("t")), PLFX_OK);
    assert_int_equal(t.lut.camera_id, 5);
    plfx_posix_table_close(&t);
    plfx_posix_table_close(&t);
    assert_int_equal(pwrite(file, "x", 1, 20), 1);
    assert_int_equal(close(file), 0);
    assert_int_equal(plfx_posix_table_open(&t, scratch("t")), PLFX_E_FORMAT);
    assert_int_equal(truncate(scratch("t"), 0), 0);
    assert_int_equal(plfx_posix_table_open(&t, scratch("t")), PLFX_E_SIZE);
    assert_int_equal(plfx_posix_table_open(&t, scratch("none")), PLFX_E_IO);
    assert_int_equal(plfx_posix_table_open(&t, scratch_folder), PLFX_E_IO);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(frames_come_in_their_own_time),
    cmocka_unit_test(waiting_ends_at_the_timeout),
    cmocka_unit_test(taken_slots_are_not_given_again),
    cmocka_unit_test(bands_arrive_row_by_row),
    cmocka_unit_test(damaged_frames_are_counted_not_shown),
    cmocka_unit_test(bare_files_play_too),
    cmocka_unit_test(bad_cameras_are_refused),
    cmocka_unit_test(monotonic_clock_goes_on),
    cmocka_unit_test(tables_are_mapped),
};

int main(void)
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, scratch_make, scratch_drop);
}
