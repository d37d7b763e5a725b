/* SPDX-License-Identifier: MIT */
#include "motion/thin.h"

#include <math.h>

#include "plenofix/modal.h"

#define PI    3.14159265358979323846
#define LEAST 0.6 /* of the thinning that the damping alone wants */
#define MOST  1.2

/* Gain of the triangle at `hz`. */
static double gain(double rate, int every, double hz)
{
    double x = PI * hz / rate;
    double s = every * sin(x);
    double g = fabs(s) > 1e-12 ? sin(every * x) / s : 1.0;

    return g * g;
}

double plft_thin_leak(double rate, int every, double from, double to)
{
    return gain(rate, every, from - to) + gain(rate, every, from + to);
}

int plft_thin_apart(double rate, int every, double a, double b)
{
    return fabs(a - b) > 0.5 * rate / every;
}

/* Of the modes that a thinning by `usual` parts from mode m. */
static double leaks(double rate, const double *freq, int n, int m, int usual, int every)
{
    double sum = 0.0;
    int k;

    for (k = 0; k < n; k++) {
        if (plft_thin_apart(rate, usual, freq[k], freq[m])) {
            double r = freq[m] / freq[k];
            sum += r * r * plft_thin_leak(rate, every, freq[k], freq[m]);
        }
    }
    return sum;
}

int plft_thin_every(double rate, const double *freq, int n, int m, double damping)
{
    int every =
        plfx_modal_every((uint32_t)lround(rate * 1000), (uint32_t)lround(freq[m] * 1e6),
                         (int32_t)lround(damping * 1e6));
    int most = (int)(MOST * every);
    int best = every;
    int k;

    for (k = (int)ceil(LEAST * every); k <= most; k++) {
        if (leaks(rate, freq, n, m, every, k) < leaks(rate, freq, n, m, every, best)) {
            best = k;
        }
    }
    return best;
}
