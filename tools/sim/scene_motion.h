/* SPDX-License-Identifier: MIT */
#ifndef PLFT_SIM_SCENE_MOTION_H
#define PLFT_SIM_SCENE_MOTION_H

#include "sim/scene.h"
#include "sim/scene_keys.h"

/* Read "motion"; without it scene->motion.frames stays 0.  0 or PLFT_DATA. */
int plft_scene_motion(plft_scene *scene, const plft_node *root);

#endif
