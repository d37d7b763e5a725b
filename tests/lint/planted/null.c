/* SPDX-License-Identifier: MIT
 * Broken on purpose: follows a pointer that may be null. */
#include <stddef.h>

int plfx_planted(const int *p, int n);

int plfx_planted(const int *p, int n)
{
    const int *q = NULL;
    if (n > 3) {
        q = p;
    }
    return *q;
}
