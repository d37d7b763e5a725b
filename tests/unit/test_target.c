/* SPDX-License-Identifier: MIT
 * What the core takes for granted of a compiler, held on every target. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "plenofix/plenofix.h"

static void negative_numbers_shift_arithmetically(void **state)
{
    volatile int32_t a = -5;
    volatile int64_t b = -5;
    (void)state;
    assert_int_equal(a >> 1, -3);
    assert_int_equal(b >> 1, -3);
    assert_int_equal(INT32_MIN >> 31, -1);
}

static void narrowing_keeps_the_low_bits(void **state)
{
    volatile uint32_t a = 0x1fffeu;
    (void)state;
    assert_int_equal((int16_t)a, -2);
    assert_int_equal((uint16_t)a, 0xfffe);
}

static void division_truncates_towards_zero(void **state)
{
    volatile int64_t a = -7;
    (void)state;
    assert_int_equal(a / 2, -3);
    assert_int_equal(a % 2, -1);
}

static void bytes_have_eight_bits(void **state)
{
    (void)state;
    assert_int_equal((unsigned char)-1, 255);
    assert_int_equal(sizeof(int32_t), 4);
    assert_int_equal(sizeof(int64_t), 8);
}

static void library_and_headers_are_of_one_version(void **state)
{
    (void)state;
    assert_int_equal(plfx_version(), PLFX_VERSION);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(negative_numbers_shift_arithmetically),
        cmocka_unit_test(narrowing_keeps_the_low_bits),
        cmocka_unit_test(division_truncates_towards_zero),
        cmocka_unit_test(bytes_have_eight_bits),
        cmocka_unit_test(library_and_headers_are_of_one_version),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
