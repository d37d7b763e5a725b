/* SPDX-License-Identifier: MIT
 * Geometry of a simulated plenoptic camera.
 *
 * Lateral coordinates in mm on the sensor side, x right and y down as in the raw file.
 * The thin main lens (focal length F) stands at distance L before the lens array, which
 * it images onto the plane at focus_mm: 1/L = 1/F - 1/focus.  The sensor lies one
 * microlens focal length f_mu behind the array.  A ray that leaves point a of the lens
 * at c and reaches the sensor at s has crossed the pupil at
 *   U = a - L*(s - c)/f_mu
 * and the micro-image of lens c is centred at c*(1 + f_mu/L).  Object coordinates are
 * turned by 180 degrees (X right, Y down in the picture), the way cameras store their
 * frames: at depth z the ray passes X(z) = -U + (a*focus/L + U)*z/focus. */
#ifndef PLFT_SIM_CAMERA_H
#define PLFT_SIM_CAMERA_H

#include <stdint.h>

typedef struct plft_camera {
    double F, focus;           /* mm */
    double pupil_r;            /* mm */
    double stop_r, stop_z;     /* a second stop stop_z mm before the pupil; 0: none */
    double f_mu, pitch;        /* mm; pitch of the lenses, not of the micro-images */
    double pixel;              /* mm */
    double rotation;           /* of the array, radians, x towards y */
    double offset_x, offset_y; /* of the array from the optical axis, mm */
    double fill;               /* side of a lens aperture in pitches, 0 .. 1 */
    double jitter;             /* rms of a lens centre about the lattice, mm */
    double blur;               /* Gaussian blur on the sensor (microlens), px */
    int hex;                   /* 1: odd rows shifted by half a pitch */
    int nx, ny;                /* lenses */
    int w, h;                  /* sensor, px */
    double L;                  /* derived: array to pupil, mm */
    double *centre;            /* derived: [ny][nx][2] lens centres, mm */
    double *gain;              /* [ny][nx] transmission of a lens, 0 .. 1 */
} plft_camera;

/* Derive L and the centres; a sensor size of 0 becomes the lattice's.  0, or -1 when
 * memory is short. */
int plft_camera_ready(plft_camera *cam, uint64_t seed);

void plft_camera_free(plft_camera *cam);

/* Pitch of the micro-images, px. */
double plft_camera_pitch_px(const plft_camera *cam);

/* Radius of a micro-image, px. */
double plft_camera_radius_px(const plft_camera *cam);

/* Micro-image centre of lens (i,j), sensor px. */
void plft_camera_spot(const plft_camera *cam, int i, int j, double *x, double *y);

/* Lens whose micro-image is nearest to a sensor point in mm; may lie off the array. */
void plft_camera_nearest(const plft_camera *cam, double sx, double sy, int *i, int *j);

/* Slope of a point at depth z mm, lens pitches per pixel: (1/z - 1/focus)/gain with
 * gain = -f_mu*pitch/(L^2*pixel). */
double plft_camera_slope(const plft_camera *cam, double z);

#endif
