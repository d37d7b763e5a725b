/* SPDX-License-Identifier: MIT
 * A lens lattice in double precision: conventions, orientation, indexing.
 *
 * Centre of lens (i,j): origin + i*a + j*b + (j odd ? odd : 0), as in plenofix/lut.h.
 * a is the lattice direction nearest to +x.  A hexagonal array whose columns, not rows,
 * are straight has no such direction within 15 degrees: it is turned, a points down
 * (+y) and b to the left (-x), so that a table always stores straight rows and v runs
 * with the rows. */
#ifndef PLFT_CALIB_LATTICE_H
#define PLFT_CALIB_LATTICE_H

#include "plenofix/lut.h"

#define PLFT_LATTICE_AUTO (-1)

typedef struct plft_vec {
    double x, y;
} plft_vec;

typedef struct plft_lattice {
    int kind;   /* PLFX_LATTICE_* */
    int turned; /* straight columns stored as rows */
    int nx, ny; /* 0 while the extent is unknown */
    plft_vec origin, a, b, odd;
} plft_lattice;

/* Centre of lens (i,j) in pixels; any integers. */
plft_vec plft_lattice_at(const plft_lattice *lattice, int i, int j);

/* Distance between nearest lens centres. */
double plft_lattice_pitch(const plft_lattice *lattice);

/* The pitch of the regular lattice with the same lenses an area: one number without
 * favour to an axis. */
double plft_lattice_mean_pitch(const plft_lattice *lattice);

/* Angle of the rows in degrees: a against +x, against +y when turned. */
double plft_lattice_rotation(const plft_lattice *lattice);

/* The two shortest independent vectors of the lattice spanned by *v1 and *v2, |v1| <=
 * |v2|, angle between them 60 to 90 degrees. */
void plft_basis_reduce(plft_vec *v1, plft_vec *v2);

/* Steps from any basis: kind by the angle (hexagonal under 75 degrees) unless `want` is
 * PLFX_LATTICE_SQUARE or _HEX.  Sets kind, turned, a, b, odd; the rest is zeroed.
 * 0, or -1 when the basis fits neither kind (angle or lengths 12 % off). */
int plft_lattice_orient(plft_vec v1, plft_vec v2, int want, plft_lattice *lattice);

/* The plane coordinates of p in steps: *s columns and *t rows, p = origin + s*a + t*b.
 */
void plft_lattice_coords(const plft_lattice *lattice, plft_vec p, double *s, double *t);

/* Lens nearest to p (exact for the lattice kinds stored here). */
void plft_lattice_nearest(const plft_lattice *lattice, plft_vec p, int *i, int *j);

/* Fixed-point form, rounded; 0, or -1 when a step or the origin is out of range. */
int plft_lattice_quantise(const plft_lattice *lattice, plfx_lattice *out);

#endif
