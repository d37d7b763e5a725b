/* SPDX-License-Identifier: MIT
 * Broken on purpose: reads past an array. */
#include <stdint.h>

int32_t plfx_planted(void);

int32_t plfx_planted(void)
{
    int32_t a[4] = {1, 2, 3, 4};
    int32_t s = 0;
    int32_t i;
    for (i = 0; i <= 4; i++) {
        s += a[i];
    }
    return s;
}
