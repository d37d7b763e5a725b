/* SPDX-License-Identifier: MIT
 * Broken on purpose: allocates memory. */
#include <stddef.h>

void *malloc(size_t n);

void *plfx_planted(size_t n)
{
    return malloc(n);
}
