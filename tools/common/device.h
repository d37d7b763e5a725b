/* SPDX-License-Identifier: MIT
 * Where maps are made: the core, or an OpenCL device with the same answers. */
#ifndef PLFT_DEVICE_H
#define PLFT_DEVICE_H

#include "plenofix/plan.h"
#include "plenofix/view.h"

#define PLFT_CPU (-1)

/* "cpu", "cl" or "cl:N"; NULL is cpu.  *device becomes PLFT_CPU or N.  0, PLFT_USAGE,
 * or PLFT_DATA when there is no such device. */
int plft_device_parse(int *device, const char *text);

/* Match a block of views on a device.  0 or PLFT_DATA with a message. */
int plft_device_match(int device, const plfx_plan *plan, const plfx_views *views,
                      const plfx_map *map);

typedef struct plft_device_frame { /* a raw frame of right-justified 16-bit samples */
    const plfx_lut *lut;
    const uint16_t *px;
    int bits; /* significant ones */
    plfx_tone tone;
    int white; /* 1: by the table's gains */
} plft_device_frame;

/* The same from a raw frame, on an OpenCL device, which does all of it: unpack, views,
 * match.  0 or PLFT_DATA with a message. */
int plft_device_raw(int device, const plfx_plan *plan, const plft_device_frame *frame,
                    const plfx_map *map);

#endif
