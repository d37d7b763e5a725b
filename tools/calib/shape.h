/* SPDX-License-Identifier: MIT
 * The mean micro-image as a smooth function of the position in it.
 *
 * T(p), p in pixels from the lens centre, is a cubic B-spline on a grid of `per`
 * nodes a pixel, fitted by least squares to the pixels of many lenses.  Lenses at
 * different sub-pixel phases fill in what the pixel grid leaves out; where all have
 * the same phase the spline interpolates.  Its own centre of point symmetry then
 * says where in it the lens centre lies: no other definition of "centre" is free of
 * the shape. */
#ifndef PLFT_CALIB_SHAPE_H
#define PLFT_CALIB_SHAPE_H

#include "calib/grey.h"
#include "calib/lattice.h"

/* Sums of pixel windows by the sub-pixel phase of their lens. */
typedef struct plft_fold {
    int half, n;     /* window: 2*half + 1 = n pixels on a side */
    int phases;      /* on an axis */
    double *sum;     /* [phases^2][n*n] */
    double *fx, *fy; /* [phases^2] sum of phases, -0.5 .. 0.5, times gains */
    double *weight;  /* [phases^2] sum of gains */
} plft_fold;

typedef struct plft_shape {
    int half;        /* half width of the fitted window, pixels */
    int per, m;      /* nodes a pixel, nodes on a side */
    double *c;       /* [m][m] B-spline coefficients */
    int round;       /* `ring` describes T well enough to register against */
    int rings;       /* nodes of the radial profile */
    double *ring;    /* [rings] cubic B-spline of the mean over circles */
    double oval;     /* rms of T about its mean over circles, over T's contrast */
    plft_vec centre; /* of point symmetry, relative to where the lenses were thought */
    double centre_sigma; /* 1-sigma of it from what is not symmetric, px */
    double asymmetry;    /* rms of T(c+d) - T(c-d) over rms of T about its mean */
} plft_shape;

int plft_fold_init(plft_fold *fold, int half, int phases);
void plft_fold_free(plft_fold *fold);

/* Add the window around a lens thought to be at `at`, less its background; no effect
 * when it leaves the picture.  Lenses of one phase are often neighbours under one
 * light: without their gains (above 0) the mean would change with it from phase to
 * phase. */
void plft_fold_add(plft_fold *fold, const plft_grey *grey, plft_vec at, double base,
                   double gain);

/* Fit T; the centre is not touched.  0, or -1 (no lens added, memory). */
int plft_shape_fit(plft_shape *shape, const plft_fold *fold, int per);
void plft_shape_free(plft_shape *shape);

/* T and its gradient at p. */
double plft_shape_at(const plft_shape *shape, double x, double y);
void plft_shape_slope(const plft_shape *shape, double x, double y, double *value,
                      double *gx, double *gy);

/* What lenses are registered against: the mean of T over circles about its centre
 * where the micro-image is round, else its even part (T(c+d) + T(c-d))/2; value and
 * gradient at d.  Either is even, so that a lens finds its own centre of symmetry;
 * against T itself it would repeat whatever error of place went into T.  The circles
 * sample the profile at many radii even when all lenses have one sub-pixel phase. */
void plft_shape_even(const plft_shape *shape, double x, double y, double *value,
                     double *gx, double *gy);

/* Radial profile about the centre from the folded pixels; sets ring, oval and round. 0,
 * or -1 (memory). */
int plft_shape_round(plft_shape *shape, const plft_fold *fold, double radius);

/* Set centre and asymmetry: least squares of T(c+d) - T(c-d) over |d| <= radius, from
 * the current centre. */
void plft_shape_centre(plft_shape *shape, double radius);

#endif
