/* SPDX-License-Identifier: MIT */
#include "mend.h"

static int32_t missing(const plfx_lut *lut, int32_t i, int32_t j)
{
    return (plfx_lut_flags(lut, i, j) & PLFX_LENS_MISSING) != 0;
}

/* Between measured lenses `left` and `right`, -1 or nx where the row ends first. */
static uint16_t between(const uint16_t *row, int32_t left, int32_t right, int32_t nx)
{
    if (left < 0 && right >= nx) {
        return 0;
    }
    if (left < 0) {
        return row[right];
    }
    if (right >= nx) {
        return row[left];
    }
    return (uint16_t)(((uint32_t)row[left] + row[right] + 1u) >> 1);
}

void plfx_mend_row(const plfx_lut *lut, int32_t j, uint16_t *row)
{
    int32_t nx = lut->lattice.nx;
    int32_t left = -1; /* last measured lens */
    int32_t i;
    int32_t k;

    if (lut->flag.length == 0) {
        return;
    }
    for (i = 0; i <= nx; i++) { /* nx closes a run that reaches the end */
        if (i < nx && missing(lut, i, j)) {
            continue;
        }
        if (i - left > 1) {
            uint16_t v = between(row, left, i, nx);
            for (k = left + 1; k < i; k++) {
                row[k] = v;
            }
        }
        left = i;
    }
}
