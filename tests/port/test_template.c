/* SPDX-License-Identifier: MIT
 * The template's self-test: silent on a sound board, loud on broken ones. */
#include "../unit/suite.h"
#include "ram/ram.h"
#include "template/template.h"

static uint8_t memory[4 * TEMPLATE_W * TEMPLATE_H];
static uint64_t step_back;

static plfx_pool pool_of(void)
{
    plfx_pool p = {memory, TEMPLATE_W * TEMPLATE_H, 4};

    return p;
}

static void sound_board_passes(void **state)
{
    plfx_template_report r;
    plfx_template_report none;
    plfx_clock clock = plfx_template_clock();
    plfx_block flash = plfx_template_flash();
    plfx_camera camera = plfx_template_camera();
    plfx_pool pool = pool_of();

    (void)state;
    memset(&r, 0, sizeof r);
    memset(&none, 0, sizeof none);
    plfx_template_selftest_clock(&clock, &r);
    plfx_template_selftest_storage(&flash, &r);
    plfx_template_selftest_camera(&camera, &pool, 100, &r);
    assert_memory_equal(&r, &none, sizeof r);
}

static uint64_t backwards(void *context)
{
    (void)context;
    return step_back--;
}

static plfx_status torn_acquire(void *context, uint32_t timeout_ms,
                                plfx_camera_frame *f)
{
    plfx_camera good = plfx_template_camera();
    plfx_status status = good.acquire(context, timeout_ms, f);

    f->sequence = 7;          /* stands still */
    f->time_ns = step_back--; /* goes back */
    f->raw.bytes = (const uint8_t *)&step_back;
    return status;
}

static void broken_boards_are_told(void **state)
{
    static uint8_t bytes[8192];
    static uint8_t worn[8192];
    plfx_template_report r;
    plfx_clock clock = plfx_template_clock();
    plfx_camera camera = plfx_template_camera();
    plfx_pool pool = pool_of();
    plfx_ram ram;

    (void)state;
    memset(&r, 0, sizeof r);
    step_back = 1u << 20;
    clock.now_ns = backwards;
    plfx_template_selftest_clock(&clock, &r);
    assert_int_equal(r.clock_back, 1000);
    assert_int_equal(plfx_ram_init(&ram, bytes, worn, 8192, 1024, 16), PLFX_OK);
    ram.fault = PLFX_RAM_FAIL_EVER;
    ram.when = 5;
    plfx_template_selftest_storage(&ram.block, &r);
    assert_true(r.store_errors > 0);
    camera.acquire = torn_acquire;
    plfx_template_selftest_camera(&camera, &pool, 10, &r);
    assert_int_equal(r.frame_outside, 10);
    assert_int_equal(r.frame_numbers, 9);
    assert_int_equal(r.frame_times, 9);
    pool.slot_size = 5;
    plfx_template_selftest_camera(&camera, &pool, 10, &r);
    assert_int_equal(r.frame_errors, 1);
}

/* The template's camera, whose operation `when` fails, once or for ever. */
static struct faulty {
    plfx_camera good;
    uint32_t count, when;
    int32_t ever, closed, running;
} faulty;

static int32_t grief(void)
{
    uint32_t now = faulty.count++;

    return faulty.ever ? now >= faulty.when : now == faulty.when;
}

static plfx_status faulty_open(void *c, plfx_camera_cfg *cfg, const plfx_pool *pool)
{
    return grief() ? PLFX_E_DEVICE : faulty.good.open(c, cfg, pool);
}

static plfx_status faulty_start(void *c)
{
    plfx_status s = grief() ? PLFX_E_DEVICE : faulty.good.start(c);

    faulty.running = s == PLFX_OK;
    return s;
}

static plfx_status faulty_acquire(void *c, uint32_t ms, plfx_camera_frame *f)
{
    assert_true(faulty.running); /* nothing is asked of a camera that did not start */
    return grief() ? PLFX_E_TIMEOUT : faulty.good.acquire(c, ms, f);
}

static plfx_status faulty_release(void *c, const plfx_camera_frame *f)
{
    plfx_status s = faulty.good.release(c, f);

    return grief() ? PLFX_E_IO : s;
}

static plfx_status faulty_stop(void *c)
{
    faulty.running = 0;
    return grief() ? PLFX_E_DEVICE : faulty.good.stop(c);
}

static void faulty_close(void *c)
{
    faulty.closed++;
    faulty.good.close(c);
}

static uint32_t errors_of(uint32_t when, int32_t ever)
{
    plfx_template_report r;
    plfx_pool pool = pool_of();
    plfx_camera camera;

    memset(&r, 0, sizeof r);
    memset(&faulty, 0, sizeof faulty);
    faulty.good = camera = plfx_template_camera();
    faulty.when = when;
    faulty.ever = ever;
    camera.open = faulty_open;
    camera.start = faulty_start;
    camera.acquire = faulty_acquire;
    camera.release = faulty_release;
    camera.stop = faulty_stop;
    camera.close = faulty_close;
    plfx_template_selftest_camera(&camera, &pool, 6, &r);
    assert_int_equal(faulty.running, 0);
    assert_int_equal(r.frame_outside + r.frame_numbers + r.frame_times, 0);
    return r.frame_errors;
}

static void failing_camera_is_told_and_closed(void **state)
{
    uint32_t total;
    uint32_t when;

    (void)state;
    assert_int_equal(errors_of(UINT32_MAX, 0), 0);
    total = faulty.count; /* open, start, 6 frames taken and given back, stop */
    assert_int_equal(total, 15);
    for (when = 0; when < total; when++) {
        assert_int_equal(errors_of(when, 0), 1);
        assert_int_equal(faulty.closed, when != 0); /* all but one that never opened */
        assert_in_range(errors_of(when, 1), 1, 7);
        assert_int_equal(faulty.closed, when != 0);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(sound_board_passes),
    cmocka_unit_test(broken_boards_are_told),
    cmocka_unit_test(failing_camera_is_told_and_closed),
};

SUITE(tests)
