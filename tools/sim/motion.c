/* SPDX-License-Identifier: MIT
 * Oscillators, cantilever shapes, camera shake. */
#include "sim/motion.h"

#include <math.h>
#include <string.h>

#include "sim/rng.h"

#define PI    3.14159265358979323846
#define BETA1 1.87510406871196117 /* cos(b)*cosh(b) = -1 */
#define BETA2 4.69409113297417458
#define FORCE 400u /* streams of noise: one a mode */
#define SHAKE 500u /* phases */
#define TONES 3    /* sines of a shake */

/* Cantilever mode, 1 at the tip. */
static double cantilever(double beta, double xi)
{
    double s = (sinh(beta) - sin(beta)) / (cosh(beta) + cos(beta));
    double z = beta * xi;

    return 0.5 * (cosh(z) - cos(z) - s * (sinh(z) - sin(z)));
}

#define TABLE 512

typedef struct shape_table {
    int ready;
    double bend[2][TABLE + 2], twist[TABLE + 2];
} shape_table;

static double from_table(const double *t, double xi)
{
    double x = xi * TABLE;
    int i = (int)x;

    return t[i] + (x - i) * (t[i + 1] - t[i]);
}

static const shape_table *shapes(void)
{
    static shape_table t;
    int i;

    if (!t.ready) {
        for (i = 0; i < TABLE + 2; i++) {
            double xi = (double)i / TABLE;
            t.bend[0][i] = cantilever(BETA1, xi);
            t.bend[1][i] = -cantilever(BETA2, xi);
            t.twist[i] = sin(0.5 * PI * xi);
        }
        t.ready = 1;
    }
    return &t;
}

double plft_bend_at(const plft_bend *bend, double a, double b)
{
    double xi = a / bend->span;
    double eta = 2.0 * b / bend->chord - 1.0;
    const shape_table *t = shapes();

    xi = xi < 0.0 ? 0.0 : xi > 1.0 ? 1.0 : xi;
    return bend->q[PLFT_SHAPE_BEND1] * from_table(t->bend[0], xi) +
           bend->q[PLFT_SHAPE_BEND2] * from_table(t->bend[1], xi) +
           bend->q[PLFT_SHAPE_TORSION] * eta * from_table(t->twist, xi);
}

/* x'' + 2 z w x' + w^2 x = f with f constant over h: exact. */
static void oscillate(plft_mode *m, double damping, double f, double h)
{
    double w = 2.0 * PI * m->hz;
    double decay = damping * w;
    double wd = w * sqrt(1.0 - damping * damping);
    double e = exp(-decay * h);
    double c = e * cos(wd * h);
    double s = e * sin(wd * h) / wd;
    double rest = f / (w * w);
    double x = m->x - rest;
    double v = m->v;

    m->x = rest + x * (c + decay * s) + v * s;
    m->v = v * (c - decay * s) - x * w * w * s;
}

/* Force that gives the wanted rms: noise of variance s^2, constant over h, has
 * x variance s^2*h/(4*damping*w^3) while h*w is small. */
static double force_of(const plft_mode *m, double h)
{
    double w = 2.0 * PI * m->hz;

    return m->rms * sqrt(4.0 * m->damping * w * w * w / h);
}

void plft_motion_step(plft_motion *m, uint64_t n, double part)
{
    double h = 1.0 / (m->rate * PLFT_SUBSTEPS);
    int k;

    for (k = 0; k < m->modes; k++) {
        plft_mode *mode = &m->mode[k];
        double f =
            force_of(mode, h) * plft_gauss(plft_key(m->seed, FORCE + (uint64_t)k, n));
        double damping = mode->damping + part * (mode->damping_end - mode->damping);
        oscillate(mode, damping, f, h);
    }
}

/* The noise of the run-in has its own numbers, from 2^40 on. */
void plft_motion_start(plft_motion *m, double settle)
{
    uint64_t steps = (uint64_t)(settle * m->rate * PLFT_SUBSTEPS);
    uint64_t n;
    int k;

    for (k = 0; k < m->modes; k++) {
        m->mode[k].x = m->mode[k].v = 0.0;
    }
    for (n = 0; n < steps; n++) {
        plft_motion_step(m, ((uint64_t)1 << 40) + n, 0.0);
    }
}

void plft_motion_bend(const plft_motion *m, plft_bend *bend)
{
    int k;

    memset(bend->q, 0, sizeof bend->q);
    for (k = 0; k < m->modes; k++) {
        bend->q[m->mode[k].shape] += m->mode[k].x;
    }
}

/* Three sines about shake_hz with phases of their own, rms 1. */
static double wander(const plft_motion *m, int which, double t)
{
    static const double ratio[TONES] = {0.61, 1.0, 1.37};
    double sum = 0.0;
    int k;

    for (k = 0; k < TONES; k++) {
        double phase =
            plft_uniform(plft_key(m->seed, SHAKE, (uint64_t)(TONES * which + k)));
        sum += sin(2.0 * PI * (m->shake_hz * ratio[k] * t + phase));
    }
    return sum * sqrt(2.0 / TONES);
}

plft_pose plft_motion_pose(const plft_motion *m, double t)
{
    plft_pose pose;
    int k;

    for (k = 0; k < 3; k++) {
        pose.shift[k] = m->shake_mm * wander(m, k, t);
        pose.turn[k] = m->shake_rad * wander(m, 3 + k, t);
    }
    return pose;
}

double plft_motion_lamp(const plft_motion *m, double t)
{
    return 1.0 + m->flicker * sin(2.0 * PI * m->flicker_hz * t);
}
