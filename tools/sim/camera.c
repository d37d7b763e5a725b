/* SPDX-License-Identifier: MIT
 * Geometry of a simulated plenoptic camera. */
#include "sim/camera.h"

#include <math.h>
#include <stdlib.h>

#include "sim/rng.h"

#define ROW_HEX 0.86602540378443864676 /* sqrt(3)/2: row spacing in pitches */

static double row_step(const plft_camera *cam)
{
    return cam->hex ? ROW_HEX : 1.0;
}

static double odd_shift(const plft_camera *cam, int j)
{
    return cam->hex ? ((j & 1) ? 0.25 : -0.25) : 0.0;
}

static void place_lens(plft_camera *cam, int i, int j, uint64_t seed)
{
    size_t at = (size_t)j * (size_t)cam->nx + (size_t)i;
    double x = (i - 0.5 * (cam->nx - 1) + odd_shift(cam, j)) * cam->pitch;
    double y = (j - 0.5 * (cam->ny - 1)) * row_step(cam) * cam->pitch;
    double c = cos(cam->rotation);
    double s = sin(cam->rotation);

    cam->centre[2 * at] = c * x - s * y + cam->offset_x +
                          cam->jitter * plft_gauss(plft_key(seed, 101, at));
    cam->centre[2 * at + 1] = s * x + c * y + cam->offset_y +
                              cam->jitter * plft_gauss(plft_key(seed, 102, at));
}

/* A sensor that holds every micro-image cell whole: its half is the farthest centre and
 * half a pitch. */
static int size_for(const plft_camera *cam, int axis)
{
    double k = (1.0 + cam->f_mu / cam->L) / cam->pixel;
    size_t n = (size_t)cam->nx * (size_t)cam->ny;
    double far = 0.0;
    size_t i;

    for (i = 0; i < n; i++) {
        double at = fabs(cam->centre[2 * i + (size_t)axis]) * k;
        far = at > far ? at : far;
    }
    return 2 * (int)ceil(far + 0.5 * plft_camera_pitch_px(cam));
}

int plft_camera_ready(plft_camera *cam, uint64_t seed)
{
    size_t n = (size_t)cam->nx * (size_t)cam->ny;
    size_t k;
    int i, j;

    cam->L = 1.0 / (1.0 / cam->F - 1.0 / cam->focus);
    cam->centre = calloc(2 * n, sizeof *cam->centre);
    cam->gain = malloc(n * sizeof *cam->gain);
    if (!cam->centre || !cam->gain) {
        plft_camera_free(cam);
        return -1;
    }
    for (k = 0; k < n; k++) {
        cam->gain[k] = 1.0;
    }
    for (j = 0; j < cam->ny; j++) {
        for (i = 0; i < cam->nx; i++) {
            place_lens(cam, i, j, seed);
        }
    }
    cam->w = cam->w ? cam->w : size_for(cam, 0);
    cam->h = cam->h ? cam->h : size_for(cam, 1);
    return 0;
}

void plft_camera_free(plft_camera *cam)
{
    free(cam->centre);
    free(cam->gain);
    cam->centre = NULL;
    cam->gain = NULL;
}

double plft_camera_pitch_px(const plft_camera *cam)
{
    return cam->pitch * (1.0 + cam->f_mu / cam->L) / cam->pixel;
}

double plft_camera_radius_px(const plft_camera *cam)
{
    return cam->pupil_r * cam->f_mu / (cam->L * cam->pixel);
}

void plft_camera_spot(const plft_camera *cam, int i, int j, double *x, double *y)
{
    const double *c = cam->centre + 2 * ((size_t)j * (size_t)cam->nx + (size_t)i);
    double k = (1.0 + cam->f_mu / cam->L) / cam->pixel;

    *x = c[0] * k + 0.5 * (cam->w - 1);
    *y = c[1] * k + 0.5 * (cam->h - 1);
}

void plft_camera_nearest(const plft_camera *cam, double sx, double sy, int *i, int *j)
{
    double k = 1.0 / (1.0 + cam->f_mu / cam->L);
    double x = sx * k - cam->offset_x;
    double y = sy * k - cam->offset_y;
    double c = cos(cam->rotation);
    double s = sin(cam->rotation);
    double u = (c * x + s * y) / cam->pitch;
    double v = (-s * x + c * y) / cam->pitch;

    *j = (int)floor(v / row_step(cam) + 0.5 * cam->ny);
    *i = (int)floor(u + 0.5 * cam->nx - odd_shift(cam, *j));
}

double plft_camera_slope(const plft_camera *cam, double z)
{
    double gain = -cam->f_mu * cam->pitch / (cam->L * cam->L * cam->pixel);

    return (1.0 / z - 1.0 / cam->focus) / gain;
}
