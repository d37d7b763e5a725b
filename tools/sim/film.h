/* SPDX-License-Identifier: MIT
 * The frames of a scene with motion, one after the other, and the truth of each. */
#ifndef PLFT_SIM_FILM_H
#define PLFT_SIM_FILM_H

#include "common/frame.h"
#include "sim/scene.h"
#include "sim/trace.h"

typedef struct plft_station { /* a material point, followed from its place at rest */
    plft_hit rest;
    double at[3]; /* camera coordinates, mm */
    double col, row, slope;
} plft_station;

typedef struct plft_instant { /* means over an exposure */
    double time;              /* of its middle, s */
    double lamp;
    double q[PLFT_SHAPES]; /* modes at the tip, mm */
    plft_pose pose;
    double move[PLFT_STATIONS_MAX][4]; /* w mm, columns, rows, slope */
} plft_instant;

typedef struct plft_film {
    plft_scene *scene;
    const uint8_t *mask; /* [h][w] pixels that are drawn; NULL: all */
    plft_beams beams;
    double *signal, *sum; /* [h][w] */
    plft_frame frame;     /* the newest, counts; 0 off the mask */
    plft_station station[PLFT_STATIONS_MAX];
    uint64_t steps; /* sub-steps taken */
    int n, stills;  /* frames taken, those of them at rest */
} plft_film;

/* Start in the steady state of the modes.  0 or PLFT_DATA; close it either way. */
int plft_film_open(plft_film *film, plft_scene *scene, const uint8_t *mask);

/* The next frame into film->frame, and its truth; the first motion.rest frames show the
 * scene at rest.  0 or PLFT_DATA. */
int plft_film_next(plft_film *film, plft_instant *truth);

void plft_film_close(plft_film *film);

#endif
