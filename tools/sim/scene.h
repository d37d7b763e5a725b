/* SPDX-License-Identifier: MIT
 * Scene files of `plenofix simulate` (examples/scenes/README.md lists every key). */
#ifndef PLFT_SIM_SCENE_H
#define PLFT_SIM_SCENE_H

#include <jansson.h>

#include "sim/camera.h"
#include "sim/motion.h"
#include "sim/sensor.h"
#include "sim/world.h"

#define PLFT_FRAME_DOTS  1u /* stopped down, white target */
#define PLFT_FRAME_WHITE 2u
#define PLFT_FRAME_DARK  4u
#define PLFT_FRAME_SCENE 8u

typedef struct plft_scene {
    uint64_t seed;
    unsigned frames;  /* PLFT_FRAME_* */
    int rays;         /* on a side, a pixel and lens */
    int bayer;        /* plft_bayer_phase */
    double colour[3]; /* response of the mosaic's colours */
    double stopped_r; /* pupil radius of the dots, mm */
    plft_camera cam;
    plft_sensor sensor;
    plft_world world;
    plft_motion motion; /* frames 0: a still */
    plft_bend bend;     /* of the wing, moved by the sequence */
} plft_scene;

/* Read and derive everything.  Unknown keys are refused.  0 or PLFT_DATA with a
 * message; on failure nothing is left to free. */
int plft_scene_read(plft_scene *scene, const char *path);

void plft_scene_free(plft_scene *scene);

#endif
