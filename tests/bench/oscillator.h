/* SPDX-License-Identifier: MIT
 * A mode driven by white kicks, stepped exactly, and its noise. */
#ifndef PLFX_BENCH_OSCILLATOR_H
#define PLFX_BENCH_OSCILLATOR_H

#include <math.h>
#include <stdint.h>

#define PI 3.14159265358979323846

static uint64_t rng = 88172645463325252u;

static double uniform(void)
{
    rng ^= rng << 13;
    rng ^= rng >> 7;
    rng ^= rng << 17;
    return (double)(rng >> 11) / 9007199254740992.0;
}

static double gauss(void)
{
    return sqrt(-2.0 * log(uniform() + 1e-300)) * cos(2.0 * PI * uniform());
}

typedef struct oscillator {
    double x, v;
} oscillator;

/* One sample at `rate` of a mode of f Hz and damping z, excited as if its damping were
 * `rest`, at which x has unit variance. */
static double swing(oscillator *o, double f, double z, double rest, double rate)
{
    double w = 2.0 * PI * f;
    double d = w * sqrt(1.0 - z * z);
    double e = exp(-z * w / rate);
    double c = cos(d / rate);
    double s = sin(d / rate);
    double x = e * (c + z * w / d * s) * o->x + e * s / d * o->v;
    double v = -e * w * w / d * s * o->x + e * (c - z * w / d * s) * o->v;

    o->x = x;
    o->v = v + sqrt(4.0 * rest * w * w * w / rate) * gauss();
    return x;
}

static int16_t sample(double v)
{
    return (int16_t)(v < -32767 ? -32767 : v > 32767 ? 32767 : floor(v + 0.5));
}

#endif
