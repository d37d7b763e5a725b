/* SPDX-License-Identifier: MIT
 * What `depth` writes. */
#ifndef PLFT_DEPTH_OUT_H
#define PLFT_DEPTH_OUT_H

#include "common/optics.h"
#include "common/field.h"
#include "plenofix/image.h"

typedef struct plft_depth_paths {
    const char *slope, *confidence, *sigma, *flags, *png, *png16, *ply, *depth_mm;
} plft_depth_paths;

typedef struct plft_depth_stats {
    long lenses, measured;
    long flags[7];         /* samples with each PLFX_FLAG_*, bit by bit */
    double lo, median, hi; /* 1st, 50th and 99th percentile of the slopes; NaN: none */
} plft_depth_stats;

/* Can all of them be written, to different files?  0, PLFT_DATA or PLFT_USAGE. */
int plft_depth_check_paths(const plft_depth_paths *paths);

/* optics may be NULL.  0 or PLFT_DATA. */
int plft_depth_write(const plft_field *field, const plfx_map *map,
                     const plft_optics *optics, const plft_depth_paths *paths);

int plft_depth_count(const plft_field *field, const plfx_map *map,
                     plft_depth_stats *stats);

#endif
