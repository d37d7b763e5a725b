/* SPDX-License-Identifier: MIT
 * Broken on purpose: a loop that data ends, or not. */
#include <stdint.h>

int32_t plfx_planted(const uint8_t *p)
{
    int32_t n = 0;
    while (p[n] != 0u) {
        n++;
    }
    return n;
}
