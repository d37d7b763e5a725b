/* SPDX-License-Identifier: MIT
 * What a perfect measurement would give: per lens, along the ray through the middles of
 * lens and pupil. */
#ifndef PLFT_SIM_TRUTH_H
#define PLFT_SIM_TRUTH_H

#include "sim/scene.h"

/* slope, depth (mm) and object id, [ny][nx] each; NaN and 0 where the ray meets
 * nothing. */
void plft_truth_maps(const plft_scene *scene, float *slope, float *depth, uint16_t *id);

#endif
