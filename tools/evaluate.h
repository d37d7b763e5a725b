/* SPDX-License-Identifier: MIT
 * A map against its truth: the figures of the 4D Light Field Benchmark (Honauer et al.
 * 2016) and sparsification by a measure of trust. */
#ifndef PLFT_EVALUATE_H
#define PLFT_EVALUATE_H

#include <stddef.h>
#include <stdint.h>

#define PLFT_BADPIX 3  /* thresholds: 0.07, 0.03, 0.01 */
#define PLFT_CURVE  10 /* shares kept: 100, 90 .. 10 % */

typedef struct plft_figures {
    size_t pixels;              /* inside mask and border, with a finite truth */
    size_t missing;             /* of these, not measured: bad at every threshold */
    size_t untrue;              /* of these positions, truth not finite: left out */
    double badpix[PLFT_BADPIX]; /* percent with |error| > threshold */
    double mse100;              /* 100 x mean squared error of the measured */
    double q25_100;             /* 100 x 25th percentile of |error| */
    double median100;           /* 100 x median |error| */
    double bias;                /* median error */
} plft_figures;

extern const double plft_thresholds[PLFT_BADPIX];

/* error[i] = map - truth inside the border and mask (NULL: all; else 0 is out).  What
 * is left out gets use[i] = 0; a missing measurement has error NaN and use 1. */
void plft_errors(const float *map, const float *truth, const uint8_t *mask, int w,
                 int h, int border, float *error, uint8_t *use, size_t *untrue);

/* 0, or PLFT_DATA when no pixel is left. */
int plft_figures_of(const float *error, const uint8_t *use, size_t n, plft_figures *f);

/* BadPix (threshold `limit`) of the share kept by trust, greatest first: curve[k] keeps
 * 100 - 10k percent.  A NaN trust counts least.  0 or PLFT_DATA. */
int plft_sparsify(const float *error, const uint8_t *use, const float *trust, size_t n,
                  double limit, double curve[PLFT_CURVE]);

/* 1.4826 x median |error|/sigma over finite pairs: 1 when sigma tells the truth. */
double plft_scatter_ratio(const float *error, const uint8_t *use, const float *sigma,
                          size_t n);

#endif
