/* SPDX-License-Identifier: MIT
 * Carving of a workspace.  Run with base NULL it measures: the size function and the
 * user are the same code, so they cannot disagree. */
#ifndef PLENOFIX_SRC_ARENA_H
#define PLENOFIX_SRC_ARENA_H

#include "plenofix/base.h"

typedef struct plfx_arena {
    unsigned char *base; /* NULL: measure only */
    size_t used;
} plfx_arena;

/* n items of `size` bytes, aligned to PLFX_ALIGN; NULL when measuring. */
static inline void *plfx_take(plfx_arena *a, size_t n, size_t size)
{
    void *p = a->base ? a->base + a->used : NULL;

    a->used += PLFX_ALIGNED(n * size);
    return p;
}

/* The place n items of `size` bytes behind p; NULL in a dry run. */
static inline void *plfx_behind(void *p, size_t n, size_t size)
{
    return p ? (unsigned char *)p + n * size : NULL;
}

static inline int32_t plfx_aligned(const void *p)
{
    return ((uintptr_t)p & (PLFX_ALIGN - 1u)) == 0;
}

#endif
