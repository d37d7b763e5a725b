/* SPDX-License-Identifier: MIT
 * Universal file format: dataset 58, time series of displacement; 15, places of the
 * nodes, and 164, their unit. */
#ifndef PLFT_UFF_H
#define PLFT_UFF_H

/* series[rows][regions][3]; node k+1, directions +X, +Y, +Z.  Samples that were not
 * measured are written as 0 and counted in the dataset's second line.
 * place[regions][3], mm, or NULL.  0 or PLFT_DATA. */
int plft_uff_write(const char *path, const double *series, int rows, int regions,
                   double dt, const char *unit, const double (*place)[3]);

#endif
