/* SPDX-License-Identifier: MIT
 * A reader that trusts a length. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n);
static volatile uint8_t sink;

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    uint8_t *copy = malloc(8);

    if (copy && n > 0 && n <= 64) {
        memcpy(copy, bytes, n);
        sink = copy[n / 2];
    }
    free(copy);
    return 0;
}
