/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "table.h"

#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static plfx_status map_file(plfx_posix_table *t, int file)
{
    struct stat about;

    if (fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) {
        return PLFX_E_IO;
    }
    if (about.st_size <= 0) {
        return PLFX_E_SIZE;
    }
    t->size = (size_t)about.st_size;
    t->map = mmap(NULL, t->size, PROT_READ, MAP_PRIVATE, file, 0);
    if (t->map == MAP_FAILED) {
        t->map = NULL;
        return PLFX_E_IO;
    }
    return plfx_lut_open(&t->lut, t->map, t->size);
}

plfx_status plfx_posix_table_open(plfx_posix_table *t, const char *path)
{
    plfx_status status;
    int file;

    if (!t || !path) {
        return PLFX_E_ARG;
    }
    memset(t, 0, sizeof *t);
    file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return PLFX_E_IO;
    }
    status = map_file(t, file);
    (void)close(file);
    if (status != PLFX_OK) {
        plfx_posix_table_close(t);
    }
    return status;
}

void plfx_posix_table_close(plfx_posix_table *t)
{
    if (t && t->map) {
        (void)munmap(t->map, t->size);
        t->map = NULL;
    }
}
