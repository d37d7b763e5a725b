/* SPDX-License-Identifier: MIT */
#ifndef PLFT_SIM_SCENE_WORLD_H
#define PLFT_SIM_SCENE_WORLD_H

#include "sim/scene.h"
#include "sim/scene_keys.h"

/* Side faces of a box carry their object's id plus this. */
#define PLFT_ID_SIDE 128

/* Read "objects" and "sky" and draw their textures.  0 or PLFT_DATA. */
int plft_scene_world(plft_scene *scene, const plft_node *root);

#endif
