/* SPDX-License-Identifier: MIT
 * The goldens of every stage (tests/golden) on this target. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "golden/golden.h"

static void crc_is_the_standard_one(void **state)
{
    const char text[] = "123456789";
    golden_crc c;
    int32_t i;

    (void)state;
    golden_begin(&c);
    for (i = 0; i < 9; i++) {
        golden_add(&c, (uint32_t)(unsigned char)text[i], 1);
    }
    assert_int_equal(golden_end(&c), 0xcbf43926u);
}

static void every_stage_gives_its_golden(void **state)
{
    size_t bad = 0;
    size_t k;

    (void)state;
    for (k = 0; k < golden_count; k++) {
        uint32_t crc = golden_stages[k].run();
        if (crc != golden_stages[k].crc) {
            print_message("# golden %s: 0x%08x, want 0x%08x\n", golden_stages[k].name,
                          (unsigned)crc, (unsigned)golden_stages[k].crc);
            bad++;
        }
    }
    assert_int_equal(bad, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crc_is_the_standard_one),
        cmocka_unit_test(every_stage_gives_its_golden),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
