/* SPDX-License-Identifier: MIT
 * Broken on purpose: a frame over the budget. */
#include <stdint.h>
#include <string.h>

uint8_t plfx_planted(const uint8_t *p, int32_t n)
{
    uint8_t copy[2000];
    memcpy(copy, p, sizeof copy);
    return copy[n];
}
