/* SPDX-License-Identifier: MIT
 * What moves in a simulated sequence: a cantilever wing, the camera, the light.
 *
 * The wing is a plate clamped at its left edge.  A mode displaces the point at
 * xi = a/span, eta = 2*b/chord - 1 towards the camera by q(t)*shape(xi, eta), 1 at the
 * tip: bending modes of the Euler-Bernoulli cantilever (roots 1.8751 and 4.6941), and
 * torsion, eta*sin(pi*xi/2).  q is the state of an oscillator driven by white noise,
 * advanced by its exact transition over steps of 1/16 frame in which the force is
 * constant. */
#ifndef PLFT_SIM_MOTION_H
#define PLFT_SIM_MOTION_H

#include <stdint.h>

#define PLFT_MODES_MAX    8
#define PLFT_STATIONS_MAX 64

typedef enum plft_shape_kind {
    PLFT_SHAPE_BEND1 = 0,
    PLFT_SHAPE_BEND2,
    PLFT_SHAPE_TORSION,
    PLFT_SHAPES
} plft_shape_kind;

typedef struct plft_bend { /* displacement of a plate now */
    double span, chord;    /* mm */
    double q[PLFT_SHAPES]; /* at the tip, mm; towards the camera */
} plft_bend;

/* Displacement of material point (a,b) mm, mm. */
double plft_bend_at(const plft_bend *bend, double a, double b);

typedef struct plft_mode {
    int shape; /* plft_shape_kind */
    double hz;
    double damping, damping_end; /* parts of critical, at the first and last frame */
    double rms;                  /* of q in the steady state at the first damping, mm */
    double x, v;                 /* state: mm, mm/s */
} plft_mode;

typedef struct plft_pose { /* of the camera against the world */
    double shift[3];       /* mm */
    double turn[3];        /* radians about X, Y, Z; small */
} plft_pose;

typedef struct plft_motion {
    int frames;          /* 0: none */
    int rest;            /* frames before them in which nothing moves */
    double rate, expose; /* frames a second; seconds of exposure */
    int blur;            /* instants averaged within the exposure */
    int modes;
    plft_mode mode[PLFT_MODES_MAX];
    double shake_mm, shake_rad, shake_hz; /* rms of each component */
    double flicker, flicker_hz;           /* relative amplitude of the lamp */
    int stations;
    int station[PLFT_STATIONS_MAX][2]; /* lens row and column at rest */
    uint64_t seed;
} plft_motion;

#define PLFT_SUBSTEPS 16 /* of a frame */

/* Start at rest, then run for `settle` seconds. */
void plft_motion_start(plft_motion *m, double settle);

/* Advance the modes by a sub-step; `n` counts sub-steps from the start for the noise,
 * `part` 0 .. 1 is the place in the record for the damping. */
void plft_motion_step(plft_motion *m, uint64_t n, double part);

/* Sum of the modes of each shape. */
void plft_motion_bend(const plft_motion *m, plft_bend *bend);

/* Pose of the camera and brightness of the lamp at a time. */
plft_pose plft_motion_pose(const plft_motion *m, double t);
double plft_motion_lamp(const plft_motion *m, double t);

#endif
