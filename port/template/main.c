/* SPDX-License-Identifier: MIT
 * The self-test as a program: prints what was found, exits 0 when that is nothing. */
#include "template.h"

#include <stdio.h>
#include <string.h>

#define SLOTS 4

static uint8_t memory[SLOTS * TEMPLATE_W * TEMPLATE_H]
    __attribute__((aligned(PLFX_ALIGN)));

static int line(const char *what, uint32_t n)
{
    printf("%-14s %u\n", what, (unsigned)n);
    return n != 0;
}

int main(void)
{
    plfx_clock clock = plfx_template_clock();
    plfx_block flash = plfx_template_flash();
    plfx_camera camera = plfx_template_camera();
    plfx_pool pool = {memory, TEMPLATE_W * TEMPLATE_H, SLOTS};
    plfx_template_report r;
    int bad = 0;

    memset(&r, 0, sizeof r);
    plfx_template_selftest_clock(&clock, &r);
    plfx_template_selftest_storage(&flash, &r);
    plfx_template_selftest_camera(&camera, &pool, 100, &r);
    bad |= line("clock back", r.clock_back);
    bad |= line("store errors", r.store_errors);
    bad |= line("wrong bytes", r.wrong_bytes);
    bad |= line("frame errors", r.frame_errors);
    bad |= line("frame outside", r.frame_outside);
    bad |= line("frame numbers", r.frame_numbers);
    bad |= line("frame times", r.frame_times);
    printf("%s\n", bad ? "not yet" : "sound");
    return bad;
}
