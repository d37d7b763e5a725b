/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/out.h"

/* Files over this are no frame, table or list of ours. */
#define FILE_MAX ((size_t)1 << 31)

static int grow(unsigned char **bytes, size_t *room)
{
    size_t more = *room == 0 ? (size_t)1 << 16 : *room * 2;
    unsigned char *p = (unsigned char *)realloc(*bytes, more + 1);

    if (p == NULL) {
        return plft_fail(PLFT_DATA, "out of memory: %zu bytes wanted", more);
    }
    *bytes = p;
    *room = more;
    return 0;
}

static int read_all(FILE *file, const char *path, unsigned char **bytes, size_t *n)
{
    size_t room = 0, got = 1;

    for (*n = 0; got > 0; *n += got) {
        if (*n == room && grow(bytes, &room) != 0) {
            return PLFT_DATA;
        }
        if (room > FILE_MAX) {
            return plft_fail(PLFT_DATA, "%s: over 2 GiB; not a file of this program",
                             path);
        }
        got = fread(*bytes + *n, 1, room - *n, file);
    }
    if (ferror(file)) {
        return plft_fail(PLFT_DATA, "cannot read %s: %s", path, strerror(errno));
    }
    (*bytes)[*n] = 0;
    return 0;
}

int plft_in_bytes(const char *path, unsigned char **bytes, size_t *n)
{
    FILE *file = fopen(path, "rb");
    int rc;

    *bytes = NULL;
    *n = 0;
    if (file == NULL) {
        return plft_fail(PLFT_DATA, "cannot read %s: %s; check the path", path,
                         strerror(errno));
    }
    rc = read_all(file, path, bytes, n);
    (void)fclose(file);
    if (rc != 0) {
        free(*bytes);
        *bytes = NULL;
    }
    return rc;
}
