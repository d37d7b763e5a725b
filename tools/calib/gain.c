/* SPDX-License-Identifier: MIT
 * White gains: what makes a uniform scene uniform. */
#include "calib/save.h"

#include "calib/linalg.h"
#include "common/err.h"
#include "common/memory.h"

#include <math.h>
#include <stdlib.h>

#define ZONES    8   /* on an axis, at most */
#define ZONE_MIN 12  /* lenses a zone spans, at least */
#define PER_ZONE 100 /* lenses, about, that make a zone's profile */
#define FULL     65535.0
#define ONE      8192.0 /* u13 */

typedef struct work {
    const plft_calib *c;
    const plft_grey *g;
    int zx, zy, r, side;
    double ca, sa;   /* direction of the rows */
    double *level;   /* [ny][nx] mean light of a lens, sample values; 0: none */
    double *sum, *n; /* [zones][side^2] light over the lens' mean */
} work;

/* Light at (x,y) of the white frame, bilinear; -1 off the picture. */
static double sample(const plft_grey *g, double x, double y)
{
    const int ix = (int)x, iy = (int)y; /* floors, once below 0 is out */
    const double fx = x - ix, fy = y - iy;
    const uint16_t *p;
    double v;

    if (x < 0.0 || y < 0.0 || ix + 1 >= g->w || iy + 1 >= g->h) {
        return -1.0;
    }
    p = g->px + (size_t)iy * (size_t)g->w + (size_t)ix;
    v = (1.0 - fy) * ((1.0 - fx) * p[0] + fx * p[1]) +
        fy * ((1.0 - fx) * p[g->w] + fx * p[g->w + 1]) - g->pedestal;
    return v > 0.0 ? v : 0.0;
}

static double light(const work *w, int lens, double u, double v)
{
    const plft_vec p = w->c->final[lens];

    return sample(w->g, p.x - w->g->shift + u * w->ca - v * w->sa,
                  p.y - w->g->shift + u * w->sa + v * w->ca);
}

/* Mean over the usable disc on a grid of at most 7 x 7; 0 when it leaves the
 * picture. */
static double lens_level(const work *w, int lens)
{
    const double radius = w->c->usable_radius, step = fmax(1.0, radius / 3.0);
    double sum = 0.0, n = 0.0, all = 0.0, u, v;

    if ((w->c->field.spot[lens].flags & PLFX_LENS_MISSING) != 0u) {
        return 0.0;
    }
    for (v = -floor(radius / step) * step; v <= radius; v += step) {
        for (u = -floor(radius / step) * step; u <= radius; u += step) {
            double l;
            if (u * u + v * v > radius * radius) {
                continue;
            }
            all += 1.0;
            l = light(w, lens, u, v);
            if (l >= 0.0) {
                sum += l;
                n += 1.0;
            }
        }
    }
    return 3.0 * n >= all && n > 0.0 ? sum / n : 0.0;
}

static void add_profile(work *w, int lens, size_t zone)
{
    const size_t cells = (size_t)w->side * (size_t)w->side;
    int u, v;

    for (v = -w->r; v <= w->r; v++) {
        for (u = -w->r; u <= w->r; u++) {
            const size_t k = zone * cells + (size_t)((v + w->r) * w->side + u + w->r);
            const double l = light(w, lens, u, v);
            if (l >= 0.0) {
                w->sum[k] += l;
                w->n[k] += w->level[lens];
            }
        }
    }
}

static void measure(work *w)
{
    const int nx = w->c->lattice.nx, ny = w->c->lattice.ny;
    const int step = nx * ny / (w->zx * w->zy * PER_ZONE) + 1;
    int k;

    for (k = 0; k < nx * ny; k++) {
        const size_t zone =
            (size_t)((k / nx * w->zy / ny) * w->zx + k % nx * w->zx / nx);
        w->level[k] = lens_level(w, k);
        if (w->level[k] > 0.0 && k % step == 0) {
            add_profile(w, k, zone);
        }
    }
}

/* The level that gets gain 1: that of the brightest twentieth of the lenses. */
static double best_level(const work *w)
{
    const int n = w->c->lattice.nx * w->c->lattice.ny;
    double *v = malloc((size_t)n * sizeof *v), best = 0.0;
    int k, count = 0;

    for (k = 0; v != NULL && k < n; k++) {
        if (w->level[k] > 0.0) {
            v[count++] = w->level[k];
        }
    }
    if (count > 0) {
        best = plft_select(v, count, (int)(0.95 * (count - 1)));
    }
    free(v);
    return best;
}

static uint16_t u13(double gain)
{
    return (uint16_t)fmin(FULL, floor(gain * ONE + 0.5));
}

static void fill(const work *w, double best, plft_saved *s)
{
    const int n = w->c->lattice.nx * w->c->lattice.ny;
    const size_t cells = (size_t)(w->zx * w->zy) * (size_t)w->side * (size_t)w->side;
    size_t k;
    int i;

    for (k = 0; k < cells; k++) { /* relative light 1/8 or less: the largest gain */
        const double rel = w->n[k] > 0.0 ? w->sum[k] / w->n[k] : 1.0;
        s->profile[k] = u13(1.0 / fmax(rel, 0.125));
    }
    for (i = 0; i < n; i++) {
        s->gain[i] = w->level[i] > 0.0 ? u13(best / w->level[i]) : (uint16_t)ONE;
    }
}

static int zones(int lenses)
{
    const int n = lenses / ZONE_MIN;
    return n < 1 ? 1 : n > ZONES ? ZONES : n;
}

int plft_saved_gain(plft_saved *s, const plft_calib *c, const plft_grey *white)
{
    const double a = hypot(c->lattice.a.x, c->lattice.a.y);
    size_t cells, n = (size_t)c->lattice.nx * (size_t)c->lattice.ny;
    work w = {
        c,    white, zones(c->lattice.nx), zones(c->lattice.ny), 0, 0, 0.0, 0.0, NULL,
        NULL, NULL};
    double best;

    w.r = (int)fmin(127.0, ceil(c->usable_radius) + 1.0);
    w.side = 2 * w.r + 1;
    w.ca = c->lattice.a.x / a;
    w.sa = c->lattice.a.y / a;
    cells = (size_t)(w.zx * w.zy) * (size_t)w.side * (size_t)w.side;
    w.level = plft_alloc(n + 2u * cells, sizeof *w.level);
    s->profile = plft_alloc(cells, sizeof *s->profile);
    s->gain = plft_alloc(n, sizeof *s->gain);
    if (w.level == NULL || s->profile == NULL || s->gain == NULL) {
        free(w.level);
        return PLFT_DATA;
    }
    w.sum = w.level + n;
    w.n = w.sum + cells;
    measure(&w);
    best = best_level(&w);
    fill(&w, best, s);
    free(w.level);
    if (!(best > FULL / 200.0)) {
        return plft_fail(PLFT_DATA, "the white frame is black where the lenses are");
    }
    s->desc.zones_x = w.zx;
    s->desc.zones_y = w.zy;
    s->desc.profile_r = w.r;
    s->desc.profile_u13 = s->profile;
    s->desc.lens_gain_u13 = s->gain;
    return 0;
}
