/* SPDX-License-Identifier: MIT
 * Lens centres as a smooth function of column and row. */
#ifndef PLFT_CALIB_MODEL_H
#define PLFT_CALIB_MODEL_H

#include "calib/locate.h"

#define PLFT_TERMS 11 /* 1, s, t, odd row, s2, st, t2, s3, s2t, st2, t3 */

/* Spots of a block of lenses: lens (i,j) at spot[(j - j0)*nx + (i - i0)]. */
typedef struct plft_field {
    int kind, i0, j0, nx, ny;
    plft_spot *spot;
} plft_field;

typedef struct plft_model {
    int kind;
    int use[PLFT_TERMS];  /* which terms are in */
    int terms, order;     /* how many; 1 lattice only, 2, 3 */
    double ic, jc, scale; /* s = (i + half - ic)/scale, t = (j - jc)/scale */
    double cx[PLFT_TERMS], cy[PLFT_TERMS];
    double cov[PLFT_TERMS * PLFT_TERMS]; /* of a coordinate's coefficients, px^2 */
    float whole; /* least part seen of a spot that may take part */
    int lenses;  /* that took part */
    double rms;  /* of their residuals, per axis, px */
    double tau;  /* what of it the spots' own noise does not explain, px */
    double chi;  /* residual over expected sigma, rms */
} plft_model;

plft_vec plft_model_at(const plft_model *model, int i, int j);

/* One row of the model: polynomials in s = start + i*step, for many lenses. */
typedef struct plft_row {
    double start, step, x[4], y[4];
} plft_row;

void plft_model_row(const plft_model *model, int j, plft_row *row);
plft_vec plft_row_at(const plft_row *row, int i);

/* 1-sigma of a modelled centre's coordinate at lens (i,j), px. */
double plft_model_sigma(const plft_model *model, int i, int j);

/* Exactly the lattice, as a model. */
void plft_model_from_lattice(plft_model *model, const plft_lattice *lattice,
                             double scale);

/* Weighted least squares over spots without PLFX_LENS_MISSING, with outliers beyond
 * `cut` robust deviations left out and flagged PLFX_LENS_INTERP (others lose it).
 * Terms beyond the lattice come in where the Bayes information criterion wants them,
 * up to `order`.  0, or -1 when fewer than 9 lenses or one row only take part. */
int plft_model_fit(plft_model *model, const plft_field *field, int order, double cut);

/* Plane lattice nearest to the model over lenses i0.. of the field: steps and origin of
 * lens (0,0). */
void plft_model_lattice(const plft_model *model, const plft_field *field,
                        plft_lattice *lattice);

#endif
