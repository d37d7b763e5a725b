/* SPDX-License-Identifier: MIT
 * A lens table in a file, mapped instead of read. */
#ifndef PLENOFIX_PORT_TABLE_H
#define PLENOFIX_PORT_TABLE_H

#include "plenofix/lut.h"

typedef struct plfx_posix_table {
    plfx_lut lut;
    void *map;
    size_t size;
} plfx_posix_table;

/* PLFX_OK, PLFX_E_ARG, PLFX_E_IO (errno says why), PLFX_E_SIZE and PLFX_E_FORMAT (no
 * whole, valid table). */
plfx_status plfx_posix_table_open(plfx_posix_table *t, const char *path) PLFX_MUST_USE;

/* Ends the mapping; t->lut must not be used afterwards.  Twice does no harm. */
void plfx_posix_table_close(plfx_posix_table *t);

#endif
