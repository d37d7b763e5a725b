/* SPDX-License-Identifier: MIT
 * Views of memory that the caller owns: images, blocks of sub-aperture views, maps.
 * Maps and views are lens-indexed: one sample a lens, row and column of the lattice, on
 * hexagonal lattices too.  Row 0 is lens row 0, the top of the raw file. */
#ifndef PLENOFIX_IMAGE_H
#define PLENOFIX_IMAGE_H

#include "plenofix/base.h"

typedef struct plfx_image { /* a plane of 16-bit samples */
    uint16_t *px;
    int32_t w, h, stride; /* samples, rows, elements */
} plfx_image;

/* A block of n sub-aperture views of nx x ny lenses in banded layout: sample (i,j) of
 * view k lies at px[((size_t)j * n + k) * nx + i]. */
typedef struct plfx_views {
    uint16_t *px;      /* 0 .. 2^bits - 1, bits as in the plan that reads them */
    int32_t nx, ny, n; /* lenses, lens rows, views */
} plfx_views;

#define PLFX_SLOPE_NONE INT32_MIN /* nothing was measured */
#define PLFX_SIGMA_NONE 65535u

/* Why a sample is missing or weak. */
#define PLFX_FLAG_TEXTURE   1u  /* too little texture to match */
#define PLFX_FLAG_SATURATED 2u  /* the raw samples were clipped */
#define PLFX_FLAG_OCCLUDED  4u  /* views disagree */
#define PLFX_FLAG_EDGE      8u  /* the window leaves a view in use */
#define PLFX_FLAG_LENS      16u /* dim, missing or interpolated lens */
#define PLFX_FLAG_RANGE_END 32u /* the winner is the first or last label */
#define PLFX_FLAG_UNIQUE    64u /* second best too near the best */

typedef struct plfx_map { /* a measured field; any plane but slope_q16 may be NULL */
    int32_t *slope_q16;   /* lens pitches per sensor pixel of view offset, or NONE */
    uint16_t *conf_u16;   /* 0 .. 1 - 2^-16; 0 where nothing was measured */
    uint16_t *sigma_u20;  /* standard error of the slope, 2^-20; PLFX_SIGMA_NONE */
    uint8_t *flags;       /* PLFX_FLAG_* */
    int32_t w, h, stride; /* one stride for all planes */
} plfx_map;

#endif
