/* SPDX-License-Identifier: MIT
 * Point clouds: binary little-endian PLY. */
#ifndef PLFT_PLY_H
#define PLFT_PLY_H

#include <stddef.h>

typedef struct plft_point3 {
    float x, y, z, confidence, sigma;
} plft_point3;

/* comment: one line for the header, units say.  0 or PLFT_DATA. */
int plft_ply_write(const char *path, const plft_point3 *points, size_t n,
                   const char *comment);

#endif
