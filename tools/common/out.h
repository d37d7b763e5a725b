/* SPDX-License-Identifier: MIT
 * Output files that are whole or absent: written under a temporary name in the target's
 * folder, then renamed. */
#ifndef PLFT_OUT_H
#define PLFT_OUT_H

#include <stdio.h>

typedef struct plft_out {
    FILE *file;
    char *path, *temp;
} plft_out;

/* 0, or PLFT_DATA with a message (folder missing, read-only ...). */
int plft_out_open(plft_out *out, const char *path);

/* Flush, check, rename.  On failure (disk full) removes the temporary and says so. */
int plft_out_commit(plft_out *out);

/* Drop the temporary.  No effect after a commit or on a zeroed struct. */
void plft_out_abort(plft_out *out);

/* Would plft_out_open() succeed?  For commands that compute long before they write.
 * NULL is fine: an output that was not asked for. */
int plft_out_check(const char *path);

/* Whole file in one call. */
int plft_out_bytes(const char *path, const void *bytes, size_t n);

/* Whole file read into malloc'd memory, a zero byte after its end.  0 or PLFT_DATA. */
int plft_in_bytes(const char *path, unsigned char **bytes, size_t *n);

#endif
