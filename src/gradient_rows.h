/* SPDX-License-Identifier: MIT
 * Rows of the least-squares gradient: derivatives of a row of lenses and sums of their
 * products over windows, in vectors.  The numbers are those of NUMERICS.md. */
#ifndef PLENOFIX_SRC_GRADIENT_ROWS_H
#define PLENOFIX_SRC_GRADIENT_ROWS_H

#include "arena.h"
#include "gradient_scalar.h"

enum { PLFX_G_CENTRE, PLFX_G_LEFT, PLFX_G_RIGHT, PLFX_G_UP, PLFX_G_DOWN, PLFX_G_VIEWS };

/* Rows y-1, y, y+1 of each view. */
typedef struct plfx_strips {
    const uint16_t *px[PLFX_G_VIEWS][3];
} plfx_strips;

/* Derivatives of a row, q4 counts: 12 bits, sign and fraction stay under 2^15. */
typedef struct plfx_slants {
    int16_t *ix, *iu, *iy, *iv; /* [nx] each */
} plfx_slants;

/* Sums over the window's rows, [nx] each; a product is under 2^30. */
typedef struct plfx_slant_sums {
    int64_t *num; /* col xu + row yv, as plfx_gradient_slope_q16() takes them: q12 */
    int64_t *xx, *yy, *xy;
} plfx_slant_sums;

/* Lenses 1 .. nx-2 of a row from rows y-1, y, y+1 of each view; samples of 12 bits.
 * spare: [2][nx]. */
void plfx_gradient_slants(const plfx_strips *in, int32_t nx, uint32_t *spare,
                          const plfx_slants *out);

/* Columns 1 .. nx-2: products of the row `in` enter, those of `out` leave; a row of
 * zeros changes nothing.  col_q12, row_q12: the lattice's ratios. */
void plfx_gradient_columns(const plfx_slant_sums *sum, const plfx_slants *in,
                           const plfx_slants *out, int32_t nx, int32_t col_q12,
                           int32_t row_q12);

#endif
