/* SPDX-License-Identifier: MIT
 * Lens-indexed planes resampled to a square grid of one lens pitch, for pictures: maps
 * of hexagonal arrays are otherwise drawn sheared and 15 % too tall. */
#ifndef PLFT_SQUARE_H
#define PLFT_SQUARE_H

#include <stddef.h>
#include <stdint.h>

#include "plenofix/lut.h"

typedef struct plft_square {
    int w, h;
    float *col; /* [h][w] lens column and */
    int *line;  /* [h] lens row to read; malloc'd */
} plft_square;

/* lattice NULL: square, one to one.  0 or PLFT_DATA. */
int plft_square_init(plft_square *sq, const plfx_lattice *lattice, int nx, int ny);

/* Nearest lens: for maps, whose neighbours must not be mixed. */
void plft_square_map(const plft_square *sq, const float *v, int nx, float *out);

/* Linear along the rows, nearest row: for views. */
void plft_square_view(const plft_square *sq, const uint16_t *v, int nx, uint16_t *out);

void plft_square_free(plft_square *sq);

#endif
