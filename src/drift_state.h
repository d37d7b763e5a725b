/* SPDX-License-Identifier: MIT
 * One lens against the mean micro-image (drift_lens.c), for drift.c. */
#ifndef PLENOFIX_SRC_DRIFT_STATE_H
#define PLENOFIX_SRC_DRIFT_STATE_H

#include "plenofix/lut.h"
#include "plenofix/raw.h"

#define DRIFT_PITCH_MAX 256 /* pixels: a window has at most 263^2 < 2^17 samples */

/* Windows are [n][n], n = 2*half + 1, lens centre in the middle; a disc counts. */
typedef struct plfx_drift_window {
    const plfx_raw *raw;
    int32_t half, n;
    int32_t cells;         /* samples of the disc */
    int16_t *span;         /* [n] half chord of the disc, -1: none */
    uint16_t *row;         /* [n+4] a row of pixels */
    uint16_t *ring;        /* [8][n] rows sampled along x */
    uint16_t *px;          /* [n][n] the lens */
    uint32_t *sum;         /* [n][n] of lenses */
    int16_t *kx, *ky;      /* [n][n] odd: sum(kx w) tells the displacement along x */
    int16_t *even;         /* [n][n] E */
    int32_t folded;        /* lenses in `sum`, at most 2^12 */
    int32_t to_px_q16;     /* sum(kx w)/sum(E w) times this: pixels */
    int64_t level;         /* sum(E w) of the mean lens */
    int64_t even_sum;      /* sum(E): what rounding has left */
    uint32_t even_norm;    /* root of sum(E^2) */
    int64_t asymmetry_q40; /* variance of the common centre, px^2 */
} plfx_drift_window;

typedef struct plfx_drift_lens {
    int32_t dx_q20, dy_q20; /* from where it was sampled */
    int32_t ok;
} plfx_drift_lens;

/* Samples around (x,y), q12 pixels, into px; 0 when they leave the frame. */
int32_t plfx_drift_sample(const plfx_drift_window *w, int32_t x_q12, int32_t y_q12);

/* sum += px. */
void plfx_drift_fold(plfx_drift_window *w);

/* Kernels from `sum`; 0 when it has no structure. */
int32_t plfx_drift_kernels(plfx_drift_window *w);

/* The lens in px: by centroid, or against the kernels. */
plfx_drift_lens plfx_drift_centroid(const plfx_drift_window *w);
plfx_drift_lens plfx_drift_match(const plfx_drift_window *w);

/* n * 2^up / d rounded down in magnitude, up >= 0; |n| < 2^62, d > 0.  Bits that do not
 * fit are cut from d; quotients saturate at 2^62. */
int64_t plfx_drift_ratio(int64_t n, int64_t d, int32_t up);

#endif
