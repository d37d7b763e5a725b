/* SPDX-License-Identifier: MIT
 * Broken on purpose: narrows without saying so. */
#include <stdint.h>

int16_t plfx_planted(int32_t v);

int16_t plfx_planted(int32_t v)
{
    return v * 2;
}
