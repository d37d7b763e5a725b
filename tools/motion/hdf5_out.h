/* SPDX-License-Identifier: MIT
 * Series of displacements as HDF5, where the program was built with its library. */
#ifndef PLFT_HDF5_OUT_H
#define PLFT_HDF5_OUT_H

#include "plenofix/roi.h"

typedef struct plft_series {    /* what monitor measured */
    const double *time;         /* [rows], s */
    const double *series;       /* [rows][regions][3], NaN where not measured */
    const double *sigma;        /* the same */
    const unsigned char *flags; /* [rows][regions] */
    const plfx_roi_region *region;
    const double (*place)[3]; /* [regions], mm; NULL: not known */
    int rows, regions;
    double rate;
    const char *uv_unit, *w_unit;
} plft_series;

/* 1 when plft_hdf5_write() can. */
int plft_hdf5_built(void);

/* Datasets time, displacement, sigma, flags, region, place where it is known, with
 * units as attributes; written under a temporary name.  0 or PLFT_DATA. */
int plft_hdf5_write(const char *path, const plft_series *m);

#endif
