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

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(sound_board_passes),
    cmocka_unit_test(broken_boards_are_told),
};

SUITE(tests)
