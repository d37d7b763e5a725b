/* SPDX-License-Identifier: MIT
 * A sequence of PNG or TIFF files as a camera. */
#ifndef PLFT_PICTURES_H
#define PLFT_PICTURES_H

#include "plenofix/port.h"

#define PLFT_PICTURES_SLOTS 32

typedef struct plft_pictures {
    plfx_camera camera;
    const char *const *paths;
    int n, bits;      /* bits 0: as the files */
    plfx_clock clock; /* for a rate in the configuration */
    plfx_camera_cfg cfg;
    plfx_pool pool;
    plfx_camera_count count;
    unsigned char taken[PLFT_PICTURES_SLOTS];
    int next, running;
    uint64_t began_ns;
} plft_pictures;

void plft_pictures_init(plft_pictures *p, const char *const *paths, int n, int bits,
                        plfx_clock clock);

#endif
