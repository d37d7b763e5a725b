/* SPDX-License-Identifier: MIT
 * Where one lens' micro-image lies: least squares of background + gain * T(x - centre)
 * over the pixels of a disc, T the mean micro-image (calib/shape.h).
 *
 * The linear step from the nearest of 8 x 8 tabulated phases has only a cubic error in
 * the remaining sixteenth of a pixel, because T is nearly even: under 1e-4 px. */
#ifndef PLFT_CALIB_LOCATE_H
#define PLFT_CALIB_LOCATE_H

#include "calib/shape.h"

/* Normal equations of background, gain, gain * dx, gain * dy over a mask. */
typedef struct plft_normal {
    double inverse[16];         /* of the 4 x 4 matrix */
    double count, sum, squares; /* pixels; sums of T and of T^2 */
} plft_normal;

typedef struct plft_bank {
    int half, n;          /* window: 2*half + 1 = n pixels on a side */
    int stride, len;      /* of a window's rows; of a window, a multiple of 8 */
    int phases;           /* steps of 1/phases pixel from -0.5 to 0.5, both ends */
    double radius;        /* of the disc of pixels that count */
    float *solve, *basis; /* [(phases+1)^2][4][len]: pseudo-inverse; 1, T, -Tx, -Ty */
    plft_normal *fit;     /* [(phases+1)^2] over the disc */
    float *mask;          /* [len] 1 inside the disc */
    double count;         /* pixels of the disc */
    double peak;          /* T at the centre minus its lowest value in the disc */
} plft_bank;

/* One lens.  All zero (rms HUGE_VAL) when nothing could be measured. */
typedef struct plft_spot {
    double x, y;     /* centre, pixels of the grey picture */
    float gain;      /* contrast against the mean micro-image */
    float base;      /* background, sample values */
    float rms;       /* of the residual, sample values */
    float match;     /* correlation with the shape, 0 .. 1 */
    float sigma;     /* standard error of x and of y (the larger), pixels */
    float seen;      /* part of the disc's pixels that were used, 0 .. 1 */
    uint8_t clipped; /* clipped pixels in the inner half, at most 255 */
    uint8_t flags;   /* PLFX_LENS_* */
} plft_spot;

/* Tabulate the shape about its centre for a disc of `radius` pixels.  0, or -1. */
int plft_bank_init(plft_bank *bank, const plft_shape *shape, double radius);
void plft_bank_free(plft_bank *bank);

enum { PLFT_LOCATE_SCRATCH = 3 };

/* Find the spot near `guess`, at most `reach` pixels from it.  Pixels off the picture,
 * clipped, or off the model by 4 times the residual are left out.
 * `scratch` holds of PLFT_LOCATE_SCRATCH * bank->len floats. */
void plft_locate(const plft_bank *bank, const plft_grey *grey, plft_vec guess,
                 double reach, float *scratch, plft_spot *spot);

#endif
