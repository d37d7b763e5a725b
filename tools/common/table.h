/* SPDX-License-Identifier: MIT
 * Lens tables as files. */
#ifndef PLFT_TABLE_H
#define PLFT_TABLE_H

#include <stddef.h>

#include "plenofix/lut.h"

typedef struct plft_table {
    unsigned char *blob; /* malloc'd; `lut` points into it */
    size_t size;
    plfx_lut lut;
} plft_table;

/* 0 or PLFT_DATA with a message. */
int plft_table_read(plft_table *table, const char *path);

/* Write a description as a .plut file.  0 or PLFT_DATA. */
int plft_table_write(const char *path, const plfx_lut_desc *desc);

/* Usable radius that suits a lens pitch, sensor pixels: the lens without its outer
 * 2.5 px, where neighbours bleed in, but at least 0.3 of the pitch. */
double plft_usable_radius(double pitch);

void plft_table_free(plft_table *table);

#endif
