/* SPDX-License-Identifier: MIT */
#include "sim/truth.h"

#include <math.h>

#include "sim/trace.h"

static plft_hit look(const plft_scene *scene, const double c[2])
{
    double spot = 1.0 + scene->cam.f_mu / scene->cam.L;
    plft_ray ray =
        plft_trace_ray(&scene->cam, c[0], c[1], c[0], c[1], c[0] * spot, c[1] * spot);

    return plft_world_trace(&scene->world, &ray);
}

void plft_truth_maps(const plft_scene *scene, float *slope, float *depth, uint16_t *id)
{
    const plft_camera *cam = &scene->cam;
    size_t n = (size_t)cam->nx * (size_t)cam->ny;
    size_t k;

    for (k = 0; k < n; k++) {
        plft_hit hit = look(scene, cam->centre + 2 * k);
        int seen = hit.quad != NULL;
        slope[k] = seen ? (float)plft_camera_slope(cam, hit.z) : (float)NAN;
        depth[k] = seen ? (float)hit.z : (float)NAN;
        id[k] = seen ? (uint16_t)hit.quad->id : 0;
    }
}
