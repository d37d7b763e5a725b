/* SPDX-License-Identifier: MIT
 * Small symmetric systems. */
#ifndef PLFT_CALIB_LINALG_H
#define PLFT_CALIB_LINALG_H

#define PLFT_SPD_MAX 32

/* Invert the symmetric positive definite m[n][n] in place (Cholesky), n <=
 * PLFT_SPD_MAX. 0, or -1 when a pivot falls under 1e-12 of its diagonal: m is then
 * undefined. */
int plft_spd_invert(double *m, int n);

/* x = m*v for square m[n][n]; x must not be v. */
void plft_mat_vec(const double *m, const double *v, int n, double *x);

/* The k-th smallest of v[n], 0 <= k < n, n > 0; reorders v. */
double plft_select(double *v, int n, int k);

/* Median (the lower of the middle two); reorders v; 0 when n is 0. */
double plft_median(double *v, int n);

#endif
