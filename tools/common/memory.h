/* SPDX-License-Identifier: MIT
 * Memory of the tools: checked sizes, zeroed, one message when there is none. */
#ifndef PLFT_MEMORY_H
#define PLFT_MEMORY_H

#include <stddef.h>

/* n elements of `each` bytes, zeroed, to be freed by free(); n = 0 gives one element.
 * NULL after a message when n*each overflows or memory is short. */
void *plft_alloc(size_t n, size_t each);

/* The same, aligned to PLFX_ALIGN, for workspaces. */
void *plft_alloc_ws(size_t bytes);

/* Copy of a string, or NULL after a message. */
char *plft_strdup(const char *text);

#endif
