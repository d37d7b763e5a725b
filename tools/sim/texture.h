/* SPDX-License-Identifier: MIT
 * Procedural textures: functions of material coordinates, drawn once into a periodic
 * tile of texels and kept as a summed-area table, so that the mean over a rectangle
 * (what a pixel sees through its lens) is exact and costs the same at any size. */
#ifndef PLFT_SIM_TEXTURE_H
#define PLFT_SIM_TEXTURE_H

#include <stdint.h>

typedef enum plft_pattern {
    PLFT_PATTERN_NONE = 0, /* uniform: the mean */
    PLFT_PATTERN_NOISE,    /* value noise, several octaves */
    PLFT_PATTERN_SPECKLE,  /* dark blobs on bright ground */
    PLFT_PATTERN_CHECKER,
    PLFT_PATTERN_DOMINO /* noise with the pips of a domino */
} plft_pattern;

typedef struct plft_texture_desc {
    plft_pattern pattern;
    double mean, contrast; /* reflectance; noise: rms, others: half swing; result is
                              kept in 0.02 .. 1 */
    double cell_mm;        /* coarsest octave, blob spacing, square of a checker */
    int octaves;           /* noise: each half as large as the one before */
    double persistence;    /* amplitude of an octave relative to the one before */
    double soft_mm;    /* Gaussian sigma over the pattern, at most 8 texels; 0: none */
    int pips[2];       /* domino: upper and lower half, 0 .. 6 */
    double face_mm[2]; /* domino: width and height */
    uint64_t seed;
} plft_texture_desc;

typedef struct plft_texture {
    int n;        /* texels on a side of the tile */
    int stride;   /* of the table */
    double texel; /* mm */
    double mean;
    double *sum; /* NULL: uniform */
} plft_texture;

#define PLFT_TEXTURE_PAD 64 /* widest rectangle, texels */

/* Draw a tile of n x n texels.  0, or -1 when memory is short. */
int plft_texture_make(plft_texture *t, const plft_texture_desc *desc, double texel_mm,
                      int n);

void plft_texture_free(plft_texture *t);

/* Mean over the rectangle of size (w,h) mm about (x,y) mm, sides kept within
 * 1/16 .. PLFT_TEXTURE_PAD - 2 texels. */
double plft_texture_box(const plft_texture *t, double x, double y, double w, double h);

#endif
