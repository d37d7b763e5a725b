/* SPDX-License-Identifier: MIT
 * What monitor measured as one page without references to other files. */
#ifndef PLFT_MOTION_REPORT_H
#define PLFT_MOTION_REPORT_H

#include "motion/find.h"
#include "motion/hdf5_out.h"
#include "plenofix/modal.h"

typedef struct plft_mode_line {
    double hz;      /* looked for */
    plfx_mode mode; /* found, flags LOST otherwise */
    double rms;     /* in `unit` */
    int region;
} plft_mode_line;

typedef struct plft_series_report {
    const plft_series *motion;
    const plft_spectrum *spectrum;
    const plft_mode_line *line;
    int modes, axis;
    unsigned lost, late, flagged;
    const char *table;
} plft_series_report;

/* 0 or PLFT_DATA. */
int plft_series_report_write(const char *path, const plft_series_report *r);

#endif
