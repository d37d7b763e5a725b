/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "common/memory.h"

#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "plenofix/base.h"

void *plft_alloc(size_t n, size_t each)
{
    void *p = calloc(n > 0 ? n : 1, each);

    if (p == NULL) {
        plft_fail(PLFT_DATA, "out of memory: %zu x %zu bytes wanted", n, each);
    }
    return p;
}

void *plft_alloc_ws(size_t bytes)
{
    void *p = NULL;

    if (posix_memalign(&p, PLFX_ALIGN, bytes > 0 ? bytes : 1) != 0) {
        plft_fail(PLFT_DATA, "out of memory: %zu bytes wanted", bytes);
        return NULL;
    }
    return p;
}

char *plft_strdup(const char *text)
{
    size_t n = strlen(text) + 1;
    char *copy = (char *)plft_alloc(n, 1);

    if (copy != NULL) {
        memcpy(copy, text, n);
    }
    return copy;
}
