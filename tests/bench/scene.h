/* SPDX-License-Identifier: MIT
 * Small light fields with truth, from formulas alone: a tilted background, boxes, a
 * bump and bars, textures of twelve waves from broad to fine, contrasts from faint to
 * strong.  The generator is our own, so that every host draws the same scene. */
#ifndef PLENOFIX_BENCH_SCENE_H
#define PLENOFIX_BENCH_SCENE_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#define SCENE_SIDE     104
#define SCENE_SURFACES 9
#define SCENE_WAVES    12
#define SCENE_RAYS     2 /* a side of a pixel */

typedef struct scene_surface {
    double d0, dx, dy, bump; /* disparity: d0 + dx X + dy Y + bump exp(-r^2/400) */
    double cx, cy, hx, hy;   /* rectangle; hx 0: everywhere */
    double mean, contrast;
    double fx[SCENE_WAVES], fy[SCENE_WAVES], phase[SCENE_WAVES], size[SCENE_WAVES];
} scene_surface;

typedef struct scene {
    scene_surface s[SCENE_SURFACES];
    uint64_t seed;
} scene;

static inline double scene_random(scene *c, double lo, double hi)
{
    c->seed = c->seed * 6364136223846793005u + 1442695040888963407u;
    return lo + (hi - lo) * (double)(c->seed >> 11) / 9007199254740992.0;
}

/* Box-Muller. */
static inline double scene_gauss(scene *c)
{
    double a = scene_random(c, 1e-12, 1);

    return sqrt(-2 * log(a)) * cos(6.283185307179586 * scene_random(c, 0, 1));
}

static inline void scene_texture(scene *c, scene_surface *s)
{
    double least = 0.02;
    double most = exp(scene_random(c, log(0.06), log(0.4)));
    double sum = 0;
    int i;

    for (i = 0; i < SCENE_WAVES; i++) {
        double f = exp(scene_random(c, log(least), log(most)));
        double a = scene_random(c, 0, 6.283185307179586);
        s->fx[i] = 6.283185307179586 * f * cos(a);
        s->fy[i] = 6.283185307179586 * f * sin(a);
        s->phase[i] = scene_random(c, 0, 6.283185307179586);
        s->size[i] = pow(f, -0.5);
        sum += s->size[i] * s->size[i] / 2;
    }
    for (i = 0; i < SCENE_WAVES; i++) {
        s->size[i] /= sqrt(sum);
    }
    s->mean = scene_random(c, 70, 180);
    s->contrast = exp(scene_random(c, log(3), log(30)));
}

static inline void scene_make(scene *c, uint64_t seed)
{
    int k;

    c->seed = seed * 977 + 1;
    for (k = 0; k < SCENE_SURFACES; k++) {
        scene_surface *s = c->s + k;
        double level = scene_random(c, -0.9, 1.2);
        s->cx = scene_random(c, 0.1, 0.9) * SCENE_SIDE;
        s->cy = scene_random(c, 0.1, 0.9) * SCENE_SIDE;
        s->hx = k == 0 ? 0 : scene_random(c, 0.06, 0.2) * SCENE_SIDE;
        s->hy = scene_random(c, 0.06, 0.2) * SCENE_SIDE;
        if (k >= 6) { /* bars */
            s->hx = scene_random(c, 1, 3.5);
        }
        s->dx = scene_random(c, -0.5, 0.5) / SCENE_SIDE;
        s->dy = scene_random(c, -0.5, 0.5) / SCENE_SIDE;
        s->d0 = (k == 0 ? -1.3 : level) - s->dx * s->cx - s->dy * s->cy;
        s->bump = k < 2 ? 0.4 : 0;
        scene_texture(c, s);
    }
}

static inline double scene_disparity(const scene_surface *s, double x, double y)
{
    double r2 = (x - s->cx) * (x - s->cx) + (y - s->cy) * (y - s->cy);

    return s->d0 + s->dx * x + s->dy * y +
           (s->bump != 0 ? s->bump * exp(-r2 / 400) : 0);
}

/* What a ray at (x,y) of the view at (u,v) = -(c - cc), -(r - rc) sees; the point (X,Y)
 * of disparity d is seen at X + d u. */
static inline double scene_ray(const scene *c, double x, double y, double u, double v,
                               double *disparity)
{
    double best = -99;
    double bx = 0;
    double by = 0;
    double grey;
    const scene_surface *hit = c->s;
    int k;
    int i;

    for (k = 0; k < SCENE_SURFACES; k++) {
        const scene_surface *s = c->s + k;
        double px = x;
        double py = y;
        double d = 0;
        for (i = 0; i < 6; i++) {
            d = scene_disparity(s, px, py);
            px = x - d * u;
            py = y - d * v;
        }
        if (d > best &&
            (s->hx == 0 || (fabs(px - s->cx) < s->hx && fabs(py - s->cy) < s->hy))) {
            best = d;
            hit = s;
            bx = px;
            by = py;
        }
    }
    *disparity = best;
    grey = hit->mean;
    for (i = 0; i < SCENE_WAVES; i++) {
        grey += hit->contrast * hit->size[i] *
                sin(hit->fx[i] * bx + hit->fy[i] * by + hit->phase[i]);
    }
    return grey;
}

/* Grey of a pixel, rays averaged, 0 .. 255. */
static inline double scene_pixel(const scene *c, int x, int y, double u, double v)
{
    double sum = 0;
    double d;
    int i;

    for (i = 0; i < SCENE_RAYS * SCENE_RAYS; i++) {
        sum += scene_ray(c, x + (i % SCENE_RAYS + 0.5) / SCENE_RAYS - 0.5,
                         y + (i / SCENE_RAYS + 0.5) / SCENE_RAYS - 0.5, u, v, &d);
    }
    sum /= SCENE_RAYS * SCENE_RAYS;
    return sum < 0 ? 0 : sum > 255 ? 255 : sum;
}

#endif
