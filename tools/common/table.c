/* SPDX-License-Identifier: MIT */
#include "common/table.h"

#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"
#include "common/out.h"

int plft_table_read(plft_table *table, const char *path)
{
    int rc;

    memset(table, 0, sizeof *table);
    rc = plft_in_bytes(path, &table->blob, &table->size);
    if (rc != 0) {
        return rc;
    }
    switch (plfx_lut_open(&table->lut, table->blob, table->size)) {
    case PLFX_OK:
        return 0;
    case PLFX_E_SIZE:
        rc = plft_fail(PLFT_DATA, "%s: a lens table cut short; copy it again", path);
        break;
    default:
        rc = plft_fail(PLFT_DATA,
                       "%s: no lens table, or a damaged one; make it again with "
                       "plenofix calibrate or import-centres",
                       path);
        break;
    }
    plft_table_free(table);
    return rc;
}

int plft_table_write(const char *path, const plfx_lut_desc *desc)
{
    size_t n = plfx_lut_bytes(desc);
    uint8_t *blob = n > 0 ? (uint8_t *)plft_alloc(n, 1) : NULL;
    int rc;

    if (n == 0 || blob == NULL || plfx_lut_write(desc, blob, n) != PLFX_OK) {
        free(blob);
        return plft_fail(PLFT_DATA, "%s: the lattice does not fit a lens table", path);
    }
    rc = plft_out_bytes(path, blob, n);
    free(blob);
    return rc;
}

double plft_usable_radius(double pitch)
{
    double inner = pitch / 2.0 - 2.5;

    return inner > 0.3 * pitch ? inner : 0.3 * pitch;
}

void plft_table_free(plft_table *table)
{
    free(table->blob);
    memset(table, 0, sizeof *table);
}
