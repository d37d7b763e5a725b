/* SPDX-License-Identifier: MIT */
#ifndef PLENOFIX_TESTS_SQUARE_TABLE_H
#define PLENOFIX_TESTS_SQUARE_TABLE_H

#include <string.h>

#include "plenofix/lut.h"

/* nx x ny square lenses, `pitch` pixels wide, that fill a sensor of 12 bits. */
static inline plfx_lut_desc square_table(int32_t nx, int32_t ny, int32_t pitch)
{
    plfx_lut_desc d;

    memset(&d, 0, sizeof d);
    d.sensor_w = nx * pitch;
    d.sensor_h = ny * pitch;
    d.sensor_bits = 12;
    d.lattice.nx = nx;
    d.lattice.ny = ny;
    d.lattice.origin.x_q16 = (pitch / 2) << 16;
    d.lattice.origin.y_q16 = (pitch / 2) << 16;
    d.lattice.a.x_q22 = pitch << 22;
    d.lattice.b.y_q22 = pitch << 22;
    return d;
}

#endif
