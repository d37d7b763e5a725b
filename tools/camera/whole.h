/* SPDX-License-Identifier: MIT
 * Maps of whole frames of a camera, as plenofix depth makes them of a file. */
#ifndef PLFT_WHOLE_H
#define PLFT_WHOLE_H

#include "common/arrange.h"
#include "plenofix/port.h"
#include "plenofix/image.h"

typedef struct plft_whole {
    const char *lut; /* path of the table */
    plft_views_wish wish;
    double lo, hi; /* slopes searched */
    int labels;
    int window; /* 0: depth's own */
    int device; /* PLFT_CPU or an OpenCL device */
} plft_whole;

/* Slopes of a frame into map (the table's lenses; all planes but sigma given).  0,
 * PLFT_DATA or PLFT_USAGE with a message. */
int plft_whole_map(const plft_whole *whole, const plfx_camera_frame *frame,
                   const char *name, const plfx_map *map);

#endif
