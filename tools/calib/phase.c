/* SPDX-License-Identifier: MIT
 * Lattice phase by folding. */
#include "calib/phase.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CELL_MAX 24 /* bins of the unit cell on a side */
#define WINDOWS  5  /* tried on an axis */

typedef struct cell {
    int k;                         /* bins on a side */
    double v[CELL_MAX * CELL_MAX]; /* mean by place (s,t) in the primitive cell */
    double mean, contrast;
} cell;

/* Primitive steps: u reaches the neighbour in the next row. */
static void primitive(const plft_lattice *l, plft_vec *a, plft_vec *u)
{
    *a = l->a;
    u->x = l->b.x + l->odd.x;
    u->y = l->b.y + l->odd.y;
}

static double wrap(double s)
{
    return s - floor(s);
}

/* Fold the pixels of a window; empty bins take the mean. */
static void fold(const plft_grey *g, const plft_lattice *l, int x0, int y0, int w,
                 int h, cell *c)
{
    double count[CELL_MAX * CELL_MAX] = {0}, all = 0.0, all2 = 0.0, det, var = 0.0;
    plft_vec a, u;
    int x, y, k, n = c->k * c->k;

    primitive(l, &a, &u);
    det = a.x * u.y - a.y * u.x;
    memset(c->v, 0, sizeof c->v);
    for (y = y0; y < y0 + h; y++) {
        const uint16_t *row = g->px + (size_t)y * (size_t)g->w;
        for (x = x0; x < x0 + w; x++) {
            double s = wrap((x * u.y - y * u.x) / det),
                   t = wrap((a.x * y - a.y * x) / det);
            int bs = (int)(s * c->k), bt = (int)(t * c->k);
            k = (bt < c->k ? bt : c->k - 1) * c->k + (bs < c->k ? bs : c->k - 1);
            c->v[k] += row[x];
            count[k] += 1.0;
            all += row[x];
            all2 += (double)row[x] * row[x];
        }
    }
    c->mean = all / ((double)w * h);
    for (k = 0; k < n; k++) {
        c->v[k] = count[k] > 0.0 ? c->v[k] / count[k] : c->mean;
        var += (c->v[k] - c->mean) * (c->v[k] - c->mean) / n;
    }
    all2 = all2 / ((double)w * h) - c->mean * c->mean;
    c->contrast = sqrt(var);
    c->mean = c->contrast / sqrt(fmax(all2, 1e-9)); /* from here on: of the pixels' */
}

/* Bilinear value at (s,t), periodic. */
static double cell_at(const cell *c, double s, double t)
{
    double fs = wrap(s) * c->k - 0.5, ft = wrap(t) * c->k - 0.5;
    int is = (int)floor(fs), it = (int)floor(ft), s1, t1;

    fs -= is;
    ft -= it;
    s1 = (is + 1) % c->k;
    t1 = (it + 1) % c->k;
    is = (is + c->k) % c->k;
    it = (it + c->k) % c->k;
    return (1 - ft) * ((1 - fs) * c->v[it * c->k + is] + fs * c->v[it * c->k + s1]) +
           ft * ((1 - fs) * c->v[t1 * c->k + is] + fs * c->v[t1 * c->k + s1]);
}

/* Mean squared change of the cell when turned about (cs,ct), over twice its variance:
 * 0 when it repeats, 1 when nothing is left. */
static double turned(const cell *c, int hex, double cs, double ct)
{
    double sum = 0.0;
    int i, j;

    for (j = 0; j < c->k; j++) {
        for (i = 0; i < c->k; i++) {
            double s = (i + 0.5) / c->k, t = (j + 0.5) / c->k;
            double q = cell_at(c, cs - t, hex ? ct + s + t : ct + s);
            double d = cell_at(c, cs + s, ct + t) - q;
            sum += d * d;
        }
    }
    return sum / (2.0 * c->k * c->k * c->contrast * c->contrast + 1e-30);
}

/* Mean of the cell around (cs,ct), weighted by a bell of a quarter pitch. */
static double brightness(const cell *c, plft_vec a, plft_vec u, double pitch, double cs,
                         double ct)
{
    const double inv = 1.0 / (2.0 * 0.0625 * pitch * pitch);
    double sum = 0.0, weight = 0.0;
    int i, j;

    for (j = -c->k / 2; j <= c->k / 2; j++) {
        for (i = -c->k / 2; i <= c->k / 2; i++) {
            double s = (double)i / c->k, t = (double)j / c->k;
            double x = s * a.x + t * u.x, y = s * a.y + t * u.y;
            double w = exp(-(x * x + y * y) * inv);
            sum += w * cell_at(c, cs + s, ct + t);
            weight += w;
        }
    }
    return sum / weight;
}

/* The brightest place whose turning error is within 0.15 of the least; then, nearby,
 * the least turning error. */
static void find_centre(const cell *c, const plft_lattice *l, double *cs, double *ct)
{
    const int n = 2 * c->k, hex = l->kind == PLFX_LATTICE_HEX;
    const double pitch = plft_lattice_pitch(l);
    double least = HUGE_VAL, best = -HUGE_VAL, s0 = 0.0, t0 = 0.0;
    double error[4 * CELL_MAX * CELL_MAX];
    plft_vec a, u;
    int i, j;

    primitive(l, &a, &u);
    for (j = 0; j < n * n; j++) {
        error[j] = turned(c, hex, (j % n) / (double)n, (j / n) / (double)n);
        least = fmin(least, error[j]);
    }
    for (j = 0; j < n * n; j++) {
        double s = (j % n) / (double)n, t = (j / n) / (double)n, b;
        if (error[j] <= least + 0.15 && (b = brightness(c, a, u, pitch, s, t)) > best) {
            best = b;
            s0 = s;
            t0 = t;
        }
    }
    least = HUGE_VAL;
    for (j = -n / 8; j <= n / 8; j++) {
        for (i = -n / 8; i <= n / 8; i++) {
            int is = ((int)(s0 * n + 0.5) + i + n) % n,
                it = ((int)(t0 * n + 0.5) + j + n) % n;
            if (error[it * n + is] < least) {
                least = error[it * n + is];
                *cs = (double)is / n;
                *ct = (double)it / n;
            }
        }
    }
}

int plft_phase_find(const plft_grey *g, plft_lattice *l, double *contrast)
{
    const double pitch = plft_lattice_pitch(l);
    int w = (int)(10.0 * pitch), i, j, x, y, best_x = 0, best_y = 0;
    cell c, best;
    double s = 0.0, t = 0.0, score = -1.0;
    plft_vec a, u, middle, origin;

    w = w < g->w ? w : g->w;
    w = w < g->h ? w : g->h;
    c.k = (int)(0.5 * pitch);
    c.k = c.k < 6 ? 6 : c.k > CELL_MAX ? CELL_MAX : c.k;
    if (w < 8) {
        return -1;
    }
    for (j = 0; j < WINDOWS; j++) {
        for (i = 0; i < WINDOWS; i++) {
            double off = hypot(i - 2, j - 2) / 2.83;
            x = (g->w - w) * (2 * i + 1) / (2 * WINDOWS);
            y = (g->h - w) * (2 * j + 1) / (2 * WINDOWS);
            fold(g, l, x, y, w, w, &c);
            if (c.contrast * (1.0 - 0.3 * off) > score) { /* rather near the middle */
                score = c.contrast * (1.0 - 0.3 * off);
                best = c;
                best_x = x;
                best_y = y;
            }
        }
    }
    find_centre(&best, l, &s, &t);
    primitive(l, &a, &u);
    origin.x = s * a.x + t * u.x;
    origin.y = s * a.y + t * u.y;
    l->origin = origin;
    middle.x = best_x + 0.5 * w;
    middle.y = best_y + 0.5 * w;
    plft_lattice_nearest(l, middle, &i, &j);
    l->origin = plft_lattice_at(l, i, j - (j & 1));
    *contrast = best.mean;
    return 0;
}
