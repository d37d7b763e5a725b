/* SPDX-License-Identifier: MIT
 * Where the numbers of a lens row stand: in the blob, or, fed by rows, in a ring of
 * `held` rows: first all residuals, then all flags, then all gains. */
#ifndef PLENOFIX_SRC_LUT_ROWS_H
#define PLENOFIX_SRC_LUT_ROWS_H

#include "plenofix/lut.h"

#define PLFX_LUT_ROW_BYTES 7u /* of a lens: 4 residual, 1 flags, 2 gain */

static inline const uint8_t *plfx_lut_fed(const plfx_lut *lut, int32_t j,
                                          uint32_t before, uint32_t bytes)
{
    size_t nx = (size_t)lut->lattice.nx;

    return lut->rows +
           nx * (before * (size_t)lut->held + bytes * (size_t)(j % lut->held));
}

static inline const uint8_t *plfx_lut_resi_row(const plfx_lut *lut, int32_t j)
{
    size_t at = 4u * (size_t)j * (size_t)lut->lattice.nx;

    return lut->rows ? plfx_lut_fed(lut, j, 0, 4) : lut->blob + lut->resi.offset + at;
}

static inline const uint8_t *plfx_lut_flag_row(const plfx_lut *lut, int32_t j)
{
    size_t at = (size_t)j * (size_t)lut->lattice.nx;

    return lut->rows ? plfx_lut_fed(lut, j, 4, 1) : lut->blob + lut->flag.offset + at;
}

/* Centres along a row of lenses, without a product a lens. */
typedef struct plfx_lut_walk {
    int64_t x_q22, y_q22; /* of the next from the origin, without residual, half a q16
                             step added */
    const uint8_t *resi;  /* its residual, NULL without */
} plfx_lut_walk;

void plfx_lut_walk_from(const plfx_lut *lut, int32_t i, int32_t j, plfx_lut_walk *w);

/* plfx_lut_centre() of the next lens of the row. */
plfx_point plfx_lut_walk_on(const plfx_lut *lut, plfx_lut_walk *w);

/* `lenses`: where the blob's gains of lenses begin. */
static inline const uint8_t *plfx_lut_gains_row(const plfx_lut *lut, int32_t j,
                                                const uint8_t *lenses)
{
    size_t at = 2u * (size_t)j * (size_t)lut->lattice.nx;

    return lut->rows ? plfx_lut_fed(lut, j, 5, 2) : lenses + at;
}

#endif
