/* SPDX-License-Identifier: MIT
 * Outline of the mean micro-image. */
#include "calib/outline.h"

#include <math.h>

#define RAYS   96
#define STEPS  200  /* from centre to border */
#define ODD    0.09 /* under a square's */
#define UNEVEN 0.055

/* Distance from a lens' centre to the border of its cell: half way to the neighbour
 * that is met first. */
static double border(const plft_lattice *l, double ux, double uy)
{
    const plft_vec o = plft_lattice_at(l, 2, 2);
    double best = HUGE_VAL;
    int i, j;

    for (j = 0; j < 5; j++) {
        for (i = 0; i < 5; i++) {
            const plft_vec p = plft_lattice_at(l, i, j);
            const double x = p.x - o.x, y = p.y - o.y, along = x * ux + y * uy;
            if (along > 1e-6) {
                best = fmin(best, 0.5 * (x * x + y * y) / along);
            }
        }
    }
    return best;
}

static double at(const plft_shape *s, double r, double ux, double uy)
{
    return plft_shape_at(s, s->centre.x + r * ux, s->centre.y + r * uy);
}

/* Lowest light within the cell. */
static double floor_of(const plft_calib *c)
{
    double low = HUGE_VAL;
    int k, n;

    for (k = 0; k < RAYS; k++) {
        const double t = 6.28318530717958647693 * k / RAYS, ux = cos(t), uy = sin(t);
        const double end = border(&c->lattice, ux, uy);
        for (n = 0; n <= STEPS; n += 4) {
            low = fmin(low, at(&c->shape, n * end / STEPS, ux, uy));
        }
    }
    return low;
}

void plft_outline(plft_calib *c)
{
    const double top = at(&c->shape, 0.0, 1.0, 0.0), low = floor_of(c);
    const double half = 0.5 * (top + low);
    double sum = 0.0, squares = 0.0, rim = 0.0;
    int k, n;

    for (k = 0; k < RAYS; k++) {
        const double t = 6.28318530717958647693 * k / RAYS, ux = cos(t), uy = sin(t);
        const double step = border(&c->lattice, ux, uy) / STEPS;
        for (n = 0; n < STEPS && at(&c->shape, n * step, ux, uy) >= half; n++) {
        }
        sum += n * step;
        squares += n * step * n * step;
        rim += at(&c->shape, STEPS * step, ux, uy) / RAYS;
    }
    c->outline = top - low > 0.5 * (rim - low)
                     ? sqrt(fmax(0.0, squares * RAYS / (sum * sum) - 1.0))
                     : 1.0;
}

int plft_outline_odd(const plft_calib *c)
{
    return c->outline > ODD ? 1 : c->outline > UNEVEN ? 2 : 0;
}
