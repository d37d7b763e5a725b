/* SPDX-License-Identifier: MIT
 * Broken on purpose: a goto backwards and octal. */
#include <stdint.h>

int32_t plfx_planted(int32_t v);

int32_t plfx_planted(int32_t v)
{
    int32_t n = 010;
again:
    n++;
    if (n < v) {
        goto again;
    }
    return n;
}
