/* SPDX-License-Identifier: MIT
 * Running a preset of the core on a light field. */
#ifndef PLFT_PRESET_H
#define PLFT_PRESET_H

#include "common/field.h"
#include "common/match.h"
#include "plenofix/preset.h"

#define PLFT_PRESET_NAMES "stream|onboard|precise"

typedef struct plft_preset {
    int id;               /* plfx_preset_id */
    double noise;         /* grey levels of an 8-bit scale; below 0: measured */
    plfx_frame_cfg frame; /* filled by plft_preset_cfg() */
    int left_out;         /* views that plft_preset_match() did not use */
} plft_preset;

/* The preset's views of the light field within `radius` (0: the light field's own), the
 * centre first, and its fields of cfg; labels from cfg's slopes.  0, PLFT_USAGE or
 * PLFT_DATA. */
int plft_preset_cfg(plft_preset *p, const plft_field *field, double radius,
                    plfx_cfg *cfg);

/* Extract and match; a dark, clipped or alien view is named and left out. */
int plft_preset_match(plft_preset *p, const plfx_plan *plan, const plft_field *field,
                      const plfx_map *map, plft_times *times);

#endif
