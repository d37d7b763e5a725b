/* SPDX-License-Identifier: MIT
 * What a bench test says of regions: their noise floor at rest, the line between
 * commanded and measured steps. */
#ifndef PLFT_MOTION_BENCH_H
#define PLFT_MOTION_BENCH_H

#include "motion/series.h"

typedef struct plft_floor { /* of one region and axis; lens pitches or slope */
    int n;                  /* valid frames */
    double scatter;         /* standard deviation about the line of drift */
    double stated;          /* rms of the standard errors that the core gave */
    double drift;           /* over the record */
    double drift_sigma;
} plft_floor;

/* n < 3: all but n is NaN. */
plft_floor plft_floor_of(const plft_series *s, int k, int axis);

typedef struct plft_steps { /* commanded motion of one axis */
    const int *frame;       /* as counted by series.first */
    const double *mm;       /* NaN: this axis is not commanded */
    int n;
} plft_steps;

typedef struct plft_line {     /* measured = offset of the region + mm/mm_per_unit */
    double mm_per_unit, sigma; /* sigma from the scatter between regions */
    double range;              /* commanded, mm */
    double worst;              /* greatest mean residual of a step, mm */
    double noise;              /* scatter of the regions about the mean of a step, mm */
    int samples, missing;      /* region measurements used, flagged ones */
} plft_line;

/* Least squares over all regions; residual[n] (or NULL) becomes the mean residual of
 * each step, mm.  0, or PLFT_DATA with a message: too few steps or regions. */
int plft_line_fit(const plft_series *s, const plft_steps *steps, int axis,
                  plft_line *line, double *residual);

#endif
