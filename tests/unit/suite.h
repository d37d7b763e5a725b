/* SPDX-License-Identifier: MIT
 * What every CMocka file of this project includes. */
#ifndef PLENOFIX_TESTS_SUITE_H
#define PLENOFIX_TESTS_SUITE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The first place in memory where a workspace may start; 63 bytes at most are lost. */
static inline void *aligned(void *memory)
{
    uint8_t *p = memory;

    return p + (64u - (uintptr_t)p % 64u) % 64u;
}

/* main() of a file: TAP on stdout, one group. */
#define SUITE(tests)                                                                   \
    int main(void)                                                                     \
    {                                                                                  \
        cmocka_set_message_output(CM_OUTPUT_TAP);                                      \
        return cmocka_run_group_tests(tests, NULL, NULL);                              \
    }

#endif
