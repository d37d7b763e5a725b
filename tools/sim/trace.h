/* SPDX-License-Identifier: MIT
 * Light on the sensor: expected signal of each pixel, 1 where all rays of a pixel pass
 * the pupil and come from a perfect white. */
#ifndef PLFT_SIM_TRACE_H
#define PLFT_SIM_TRACE_H

#include <stddef.h>
#include <stdint.h>

#include "sim/camera.h"
#include "sim/world.h"

typedef enum plft_bayer_phase {
    PLFT_BAYER_NONE = 0,
    PLFT_BAYER_RGGB,
    PLFT_BAYER_GRBG,
    PLFT_BAYER_GBRG,
    PLFT_BAYER_BGGR
} plft_bayer_phase;

typedef struct plft_trace {
    const plft_camera *cam;
    const plft_world *world; /* NULL: a white target */
    const plft_pose *pose;   /* of the camera; NULL: at rest */
    double pupil_r;          /* mm; cam->pupil_r, or a stopped-down one */
    int rays;                /* on a side: rays*rays a pixel and lens, 1 .. 8 */
    int bayer;               /* plft_bayer_phase */
    double colour[3];        /* response of the three colours; mosaic only */
} plft_trace;

/* Colour (0 red, 1 green, 2 blue) of pixel (x,y) of a mosaic. */
int plft_bayer_colour(int bayer, int x, int y);

/* Fraction of the rays from the whole aperture of a lens to the whole of a pixel that
 * pass the pupil, for the middle ray's crossing (ux,uy) and lens centre (cx,cy), mm. */
double plft_trace_cover(const plft_trace *t, double ux, double uy, double cx,
                        double cy);

/* The ray of object space that leaves lens point (ax,ay) for sensor point (sx,sy);
 * (cx,cy) is the centre of the lens. */
plft_ray plft_trace_ray(const plft_camera *cam, double ax, double ay, double cx,
                        double cy, double sx, double sy);

/* The same ray in the world of a moved camera. */
plft_ray plft_pose_ray(const plft_pose *pose, const plft_ray *ray);

/* Camera coordinates of a point of the world. */
void plft_pose_inverse(const plft_pose *pose, const double world[3], double out[3]);

/* Side of the square that a lens aperture of side `lens` and a pixel of side `pixel`
 * (mm) blur a point of depth z over. */
double plft_trace_side(const plft_camera *cam, double z, double lens, double pixel);

/* Expected signal of pixel (x,y), microlens blur apart. */
double plft_trace_pixel(const plft_trace *t, int x, int y);

/* The whole frame, [h][w]; the blur of cam->blur applied.  0, or -1 when memory is
 * short. */
int plft_trace_frame(const plft_trace *t, double *signal);

/* What of a frame does not change while things move: which lens lights which pixel, how
 * much of it passes, and the rays that look. */
typedef struct plft_beam {
    uint32_t pixel, rays; /* index y*w + x; how many */
    double light;
    double part; /* side of a ray's share of lens and pixel */
} plft_beam;

typedef struct plft_beams {
    plft_beam *beam; /* of a pixel one behind the other */
    plft_ray *ray;   /* of the beams, one behind the other; camera at rest */
    size_t n, rays;
    size_t room, ray_room;
} plft_beams;

/* Of the pixels that mask[y*w + x] names; NULL: all.  0, or -1 when memory is short. */
int plft_beams_make(plft_beams *b, const plft_trace *t, const uint8_t *mask);

/* As plft_trace_frame(), bit by bit, for the trace that the beams were made of; its
 * pose and what moves in its world are free.  Pixels off the mask become 0. */
int plft_beams_frame(const plft_beams *b, const plft_trace *t, double *signal);

void plft_beams_free(plft_beams *b);

#endif
