/* SPDX-License-Identifier: MIT
 * Broken on purpose: computes in floating point behind a macro. */
#include <stdint.h>

#define PLANTED_HALF (1.0 / 2.0)

int32_t plfx_planted(int32_t v)
{
    return (int32_t)(v * PLANTED_HALF);
}
