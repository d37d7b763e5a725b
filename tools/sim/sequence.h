/* SPDX-License-Identifier: MIT
 * Frames of a scene in motion, with the truth of each. */
#ifndef PLFT_SIM_SEQUENCE_H
#define PLFT_SIM_SEQUENCE_H

#include "sim/scene.h"

/* Write frame_00000.png ... and motion.csv into a folder.  Moves the scene.  0 or
 * PLFT_DATA. */
int plft_sequence_write(plft_scene *scene, const char *folder);

#endif
