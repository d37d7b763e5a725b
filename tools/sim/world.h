/* SPDX-License-Identifier: MIT
 * What the camera looks at: textured rectangles in space; a ray takes the nearest.
 * X right, Y down in the picture, Z away from the main lens, mm. */
#ifndef PLFT_SIM_WORLD_H
#define PLFT_SIM_WORLD_H

#include "sim/motion.h"
#include "sim/texture.h"

typedef struct plft_quad {
    double o[3];           /* material point (0,0) */
    double e1[3], e2[3];   /* unit vectors of the material axes, at right angles */
    double n[3];           /* e1 x e2 */
    double w, h;           /* extent along e1, e2, mm; 0: without end */
    double shift[2];       /* texture coordinates of (0,0), mm */
    int texture;           /* index into the textures */
    int id;                /* in the map of objects; 1 .. 255 */
    const plft_bend *bend; /* lifts the surface against n; NULL: flat */
    double home[3], swing[3], swing_hz; /* o = home + swing*sin(2*pi*hz*t) */
    double rgb[3]; /* reflectance of the three colours, times the texture */
} plft_quad;

typedef struct plft_world {
    plft_quad *quad;
    int quads;
    plft_texture *texture;
    int textures;
    double sky; /* radiance where a ray meets nothing */
} plft_world;

/* A ray X(z) = p + z*d through the pupil at z = 0. */
typedef struct plft_ray {
    double px, py, dx, dy;
} plft_ray;

typedef struct plft_hit {
    const plft_quad *quad; /* NULL: nothing */
    double z;              /* mm */
    double a, b;           /* material coordinates, mm */
} plft_hit;

/* Complete n from e1, e2. */
void plft_quad_ready(plft_quad *q);

plft_hit plft_world_trace(const plft_world *world, const plft_ray *ray);

/* Mean of the texture about a hit over what shifting the ray by +-side/2 in X and Y
 * sweeps on the surface. */
double plft_world_shade(const plft_world *world, const plft_hit *hit,
                        const plft_ray *ray, double side);

/* Put swinging surfaces where they are at time t, s. */
void plft_world_swing(plft_world *world, double t);

void plft_world_free(plft_world *world);

#endif
