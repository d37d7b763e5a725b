/* SPDX-License-Identifier: MIT
 * Displacement of regions over a whole recording, in memory. */
#ifndef PLFT_MOTION_SERIES_H
#define PLFT_MOTION_SERIES_H

#include "camera/source.h"
#include "common/table.h"
#include "plenofix/roi.h"

typedef struct plft_series_wish {
    const char *table, *regions;
    const char *const *names; /* a folder, pictures or a recording */
    int n, bits, rest, views;
    double radius; /* of the views, px; 0: the table's less 1/2 */
} plft_series_wish;

typedef struct plft_series {
    plfx_roi_cfg cfg; /* cfg.lut points into `table` */
    plft_table table;
    plfx_roi_result *at; /* [frames][cfg.regions], frames after the rest state */
    int frames, first;   /* first: number of frame 0, the rest frames counted */
    size_t room;         /* frames that fit */
} plft_series;

/* Options of a wish into table[0..PLFT_SERIES_OPTIONS). */
#define PLFT_SERIES_OPTIONS 6
void plft_series_options(struct plft_option *table, plft_series_wish *wish);

/* Measure every frame.  0, PLFT_USAGE or PLFT_DATA; free it either way. */
int plft_series_take(plft_series *s, const plft_series_wish *wish);

/* Component 0 .. 2 of region k in frame t: lens pitches, slope.  NaN when flagged. */
double plft_series_value(const plft_series *s, int t, int k, int axis);

/* Its standard error; NaN when flagged. */
double plft_series_sigma(const plft_series *s, int t, int k, int axis);

void plft_series_free(plft_series *s);

#endif
