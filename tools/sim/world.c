/* SPDX-License-Identifier: MIT
 * Textured rectangles in space. */
#include "sim/world.h"

#include <math.h>
#include <stdlib.h>

static double dot_ray(const double v[3], const plft_ray *ray)
{
    return v[0] * ray->dx + v[1] * ray->dy + v[2];
}

void plft_quad_ready(plft_quad *q)
{
    q->n[0] = q->e1[1] * q->e2[2] - q->e1[2] * q->e2[1];
    q->n[1] = q->e1[2] * q->e2[0] - q->e1[0] * q->e2[2];
    q->n[2] = q->e1[0] * q->e2[1] - q->e1[1] * q->e2[0];
}

#define BEND_STEPS 5    /* a bent surface is met by successive planes */
#define CLOSE      1e-8 /* mm between two that are one */

/* Depth at which a ray meets the plane of a quad lifted against n, and the material
 * point under it.  0: never, or behind the lens. */
static int on_plane(const plft_quad *q, const plft_ray *ray, double lift, plft_hit *hit)
{
    double along = dot_ray(q->n, ray);
    double px = q->o[0] - ray->px;
    double py = q->o[1] - ray->py;
    double x, y, dz;

    if (fabs(along) < 1e-9) {
        return 0;
    }
    hit->z = (q->n[0] * px + q->n[1] * py + q->n[2] * q->o[2] - lift) / along;
    x = hit->z * ray->dx - px;
    y = hit->z * ray->dy - py;
    dz = hit->z - q->o[2];
    hit->a = q->e1[0] * x + q->e1[1] * y + q->e1[2] * dz;
    hit->b = q->e2[0] * x + q->e2[1] * y + q->e2[2] * dz;
    hit->quad = q;
    return hit->z > 0.0;
}

/* Meet a quad; *best becomes it when it is nearer and met inside. */
static void meet(const plft_quad *q, const plft_ray *ray, plft_hit *best)
{
    plft_hit hit;
    int met = on_plane(q, ray, 0.0, &hit);
    double lift = 0.0, last = 1.0;
    int k;

    for (k = 0; q->bend != NULL && met && k < BEND_STEPS && fabs(lift - last) > CLOSE;
         k++) {
        last = lift;
        lift = plft_bend_at(q->bend, hit.a, hit.b);
        met = on_plane(q, ray, lift, &hit);
    }
    if (met && hit.z < best->z && (q->w <= 0.0 || (hit.a >= 0.0 && hit.a <= q->w)) &&
        (q->h <= 0.0 || (hit.b >= 0.0 && hit.b <= q->h))) {
        *best = hit;
    }
}

plft_hit plft_world_trace(const plft_world *world, const plft_ray *ray)
{
    plft_hit hit = {NULL, HUGE_VAL, 0.0, 0.0};
    int k;

    for (k = 0; k < world->quads; k++) {
        meet(&world->quad[k], ray, &hit);
    }
    return hit;
}

/* Change of material coordinate along e when the ray moves by one unit in X or Y
 * (axis 0 or 1): the hit slides along the ray back onto the surface. */
static double slide(const plft_quad *q, const double e[3], const plft_ray *ray,
                    int axis)
{
    return fabs(e[axis] - dot_ray(e, ray) * q->n[axis] / dot_ray(q->n, ray));
}

double plft_world_shade(const plft_world *world, const plft_hit *hit,
                        const plft_ray *ray, double side)
{
    const plft_quad *q = hit->quad;
    double w = side * (slide(q, q->e1, ray, 0) + slide(q, q->e1, ray, 1));
    double h = side * (slide(q, q->e2, ray, 0) + slide(q, q->e2, ray, 1));

    return plft_texture_box(&world->texture[q->texture], hit->a + q->shift[0],
                            hit->b + q->shift[1], w, h);
}

void plft_world_swing(plft_world *world, double t)
{
    int k, i;

    for (k = 0; k < world->quads; k++) {
        plft_quad *q = &world->quad[k];
        double part = sin(6.28318530717958647693 * q->swing_hz * t);
        for (i = 0; i < 3; i++) {
            q->o[i] = q->home[i] + part * q->swing[i];
        }
    }
}

void plft_world_free(plft_world *world)
{
    int k;

    for (k = 0; k < world->textures; k++) {
        plft_texture_free(&world->texture[k]);
    }
    free(world->texture);
    free(world->quad);
    world->texture = NULL;
    world->quad = NULL;
    world->textures = world->quads = 0;
}
