/* SPDX-License-Identifier: MIT
 * A sum that may overflow. */
#include <stdint.h>

/*@ assigns \nothing;
    ensures \result == a + b; */
static inline int32_t planted_sum(int32_t a, int32_t b);

static inline int32_t planted_sum(int32_t a, int32_t b)
{
    return a + b;
}
