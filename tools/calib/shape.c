/* SPDX-License-Identifier: MIT
 * Spline of the mean micro-image. */
#include "calib/shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SMOOTH 1e-5 /* weight of squared second differences against one lens' pixels */
#define RINGS  4    /* nodes of the radial profile a pixel */
#define OVAL   0.08 /* misfit up to which a micro-image counts as round */
#define STEPS  60   /* of conjugate gradients, at most */

int plft_fold_init(plft_fold *f, int half, int phases)
{
    const size_t bins = (size_t)phases * (size_t)phases;

    f->half = half;
    f->n = 2 * half + 1;
    f->phases = phases;
    f->sum = calloc(bins * (size_t)f->n * (size_t)f->n, sizeof *f->sum);
    f->fx = calloc(bins, sizeof *f->fx);
    f->fy = calloc(bins, sizeof *f->fy);
    f->weight = calloc(bins, sizeof *f->weight);
    if (f->sum == NULL || f->fx == NULL || f->fy == NULL || f->weight == NULL) {
        plft_fold_free(f);
        return -1;
    }
    return 0;
}

void plft_fold_free(plft_fold *f)
{
    free(f->sum);
    free(f->fx);
    free(f->fy);
    free(f->weight);
    memset(f, 0, sizeof *f);
}

static int phase_bin(double f, int phases)
{
    int k = (int)((f + 0.5) * phases);
    return k < 0 ? 0 : k >= phases ? phases - 1 : k;
}

void plft_fold_add(plft_fold *f, const plft_grey *g, plft_vec at, double base,
                   double gain)
{
    const int cx = (int)floor(at.x + 0.5), cy = (int)floor(at.y + 0.5);
    const double fx = at.x - cx, fy = at.y - cy;
    const size_t bin =
        (size_t)(phase_bin(fy, f->phases) * f->phases + phase_bin(fx, f->phases));
    double *sum = f->sum + bin * (size_t)f->n * (size_t)f->n;
    int x, y;

    if (cx < f->half || cy < f->half || cx + f->half >= g->w || cy + f->half >= g->h) {
        return;
    }
    for (y = 0; y < f->n; y++) {
        const uint16_t *row =
            g->px + (size_t)(cy - f->half + y) * (size_t)g->w + cx - f->half;
        for (x = 0; x < f->n; x++) {
            sum[y * f->n + x] += row[x] - base;
        }
    }
    f->fx[bin] += gain * fx;
    f->fy[bin] += gain * fy;
    f->weight[bin] += gain;
}

/* Cubic B-spline weights of four neighbouring nodes, t in 0..1 past the second. */
static void spline(double t, double w[4])
{
    const double s = 1.0 - t;

    w[0] = s * s * s / 6.0;
    w[1] = (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0;
    w[2] = (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0;
    w[3] = t * t * t / 6.0;
}

static void spline_slope(double t, double w[4])
{
    const double s = 1.0 - t;

    w[0] = -0.5 * s * s;
    w[1] = -2.0 * t + 1.5 * t * t;
    w[2] = 2.0 * s - 1.5 * s * s;
    w[3] = 0.5 * t * t;
}

/* First of the four nodes that carry position p; *t as in spline(). */
static int node(const plft_shape *s, double p, double *t)
{
    double k = (p + s->half + 1.0) * s->per + 1.0; /* node 1 sits at -half - 1 */
    int i = (int)floor(k);

    i = i < 1 ? 1 : i > s->m - 3 ? s->m - 3 : i;
    *t = k - i;
    *t = *t < 0.0 ? 0.0 : *t > 1.0 ? 1.0 : *t;
    return i - 1;
}

static double blend(const double *c, int m, const double wx[4], const double wy[4])
{
    double sum = 0.0;
    int i, j;

    for (j = 0; j < 4; j++) {
        const double *r = c + j * m;
        double row = 0.0;
        for (i = 0; i < 4; i++) {
            row += wx[i] * r[i];
        }
        sum += wy[j] * row;
    }
    return sum;
}

double plft_shape_at(const plft_shape *s, double x, double y)
{
    double tx, ty, wx[4], wy[4];
    int i = node(s, x, &tx), j = node(s, y, &ty);

    spline(tx, wx);
    spline(ty, wy);
    return blend(s->c + (size_t)j * (size_t)s->m + i, s->m, wx, wy);
}

void plft_shape_slope(const plft_shape *s, double x, double y, double *value,
                      double *gx, double *gy)
{
    double tx, ty, wx[4], wy[4], dx[4], dy[4];
    int i = node(s, x, &tx), j = node(s, y, &ty);
    const double *c = s->c + (size_t)j * (size_t)s->m + i;

    spline(tx, wx);
    spline(ty, wy);
    spline_slope(tx, dx);
    spline_slope(ty, dy);
    *value = blend(c, s->m, wx, wy);
    *gx = s->per * blend(c, s->m, dx, wy);
    *gy = s->per * blend(c, s->m, wx, dy);
}

/* Value and slope of the radial profile; nodes are mirrored at r = 0. */
static double ring_at(const plft_shape *s, double r, double *slope)
{
    const double k = fmin(r * RINGS, s->rings - 3.0);
    const int i = (int)k;
    double w[4], d[4], v = 0.0;
    int n;

    spline(k - i, w);
    spline_slope(k - i, d);
    *slope = 0.0;
    for (n = 0; n < 4; n++) {
        const double c = s->ring[abs(i + n - 1)];
        v += w[n] * c;
        *slope += RINGS * d[n] * c;
    }
    return v;
}

void plft_shape_even(const plft_shape *s, double x, double y, double *value, double *gx,
                     double *gy)
{
    double v, vx, vy;

    if (s->round) {
        const double r = hypot(x, y);
        *value = ring_at(s, r, &v);
        *gx = r > 0.0 ? v * x / r : 0.0;
        *gy = r > 0.0 ? v * y / r : 0.0;
        return;
    }
    plft_shape_slope(s, s->centre.x + x, s->centre.y + y, value, gx, gy);
    plft_shape_slope(s, s->centre.x - x, s->centre.y - y, &v, &vx, &vy);
    *value = 0.5 * (*value + v);
    *gx = 0.5 * (*gx - vx);
    *gy = 0.5 * (*gy - vy);
}

/* Normal equations of the radial profile. */
typedef struct ring_sums {
    double *g, *rhs; /* [rings][4] band of the normal matrix; right-hand side */
    int n;
} ring_sums;

static void ring_add(ring_sums *sums, double r, double v, double weight)
{
    const double k = r * RINGS;
    const int i = (int)k;
    double w[4];
    int p, q;

    if (i + 2 >= sums->n) {
        return;
    }
    spline(k - i, w);
    for (p = 0; p < 4; p++) {
        const int row = abs(i + p - 1);
        sums->rhs[row] += weight * w[p] * v;
        for (q = 0; q < 4; q++) {
            const int column = abs(i + q - 1);
            if (column >= row) {
                sums->g[4 * row + column - row] += weight * w[p] * w[q];
            }
        }
    }
}

/* Second differences, weakly, so that radii without a sample are bridged. */
static void ring_smooth(ring_sums *s)
{
    static const double d[3] = {1.0, -2.0, 1.0};
    double trace = 0.0;
    int k, p, q;

    for (k = 0; k < s->n; k++) {
        trace += s->g[4 * k] / s->n;
    }
    for (k = 0; k + 2 < s->n; k++) {
        for (p = 0; p < 3; p++) {
            for (q = p; q < 3; q++) {
                s->g[4 * (k + p) + q - p] += 1e-4 * trace * d[p] * d[q];
            }
        }
    }
}

/* Banded Cholesky, half width 3, in place; then both substitutions. */
static void ring_solve(ring_sums *s, double *x)
{
    const int n = s->n;
    double *g = s->g;
    int k, p, q;

    for (k = 0; k < n; k++) {
        const double pivot = fmax(g[4 * k], 1e-300);
        for (p = 1; p < 4 && k + p < n; p++) {
            const double f = g[4 * k + p] / pivot;
            for (q = p; q < 4; q++) {
                g[4 * (k + p) + q - p] -= f * g[4 * k + q];
            }
            s->rhs[k + p] -= f * s->rhs[k];
        }
    }
    for (k = n - 1; k >= 0; k--) {
        double v = s->rhs[k];
        for (p = 1; p < 4 && k + p < n; p++) {
            v -= g[4 * k + p] * x[k + p];
        }
        x[k] = v / fmax(g[4 * k], 1e-300);
    }
}

static void ring_fold(const plft_shape *s, const plft_fold *f, ring_sums *sums)
{
    const size_t n = (size_t)f->n * (size_t)f->n;
    const int bins = f->phases * f->phases;
    int b, x, y;

    for (b = 0; b < bins; b++) {
        const double w = f->weight[b];
        const double *v = f->sum + (size_t)b * n;
        for (y = 0; w > 0.0 && y < f->n; y++) {
            for (x = 0; x < f->n; x++) {
                ring_add(sums,
                         hypot(x - f->half - f->fx[b] / w - s->centre.x,
                               y - f->half - f->fy[b] / w - s->centre.y),
                         v[y * f->n + x] / w, w);
            }
        }
    }
}

/* rms of the folded pixels about the ring profile, over their contrast. */
static double ring_misfit(const plft_shape *s, const plft_fold *f, double radius)
{
    const size_t n = (size_t)f->n * (size_t)f->n;
    double e2 = 0.0, v1 = 0.0, v2 = 0.0, total = 0.0;
    int b, x, y;

    for (b = 0; b < f->phases * f->phases; b++) {
        const double w = f->weight[b];
        for (y = 0; w > 0.0 && y < f->n; y++) {
            for (x = 0; x < f->n; x++) {
                double r = hypot(x - f->half - f->fx[b] / w - s->centre.x,
                                 y - f->half - f->fy[b] / w - s->centre.y);
                double v = f->sum[(size_t)b * n + (size_t)(y * f->n + x)] / w, slope, e;
                if (r > radius) {
                    continue;
                }
                e = v - ring_at(s, r, &slope);
                e2 += w * e * e;
                v1 += w * v;
                v2 += w * v * v;
                total += w;
            }
        }
    }
    return total > 0.0 ? sqrt(e2 / fmax(v2 - v1 * v1 / total, 1e-30)) : 1.0;
}

int plft_shape_round(plft_shape *s, const plft_fold *f, double radius)
{
    ring_sums sums;

    free(s->ring);
    sums.n = s->rings = (f->half + 1) * RINGS + 3;
    s->ring = calloc((size_t)s->rings, sizeof *s->ring);
    sums.g = calloc(5u * (size_t)s->rings, sizeof *sums.g);
    if (s->ring == NULL || sums.g == NULL) {
        free(sums.g);
        return -1;
    }
    sums.rhs = sums.g + 4 * s->rings;
    ring_fold(s, f, &sums);
    ring_smooth(&sums);
    ring_solve(&sums, s->ring);
    free(sums.g);
    s->oval = ring_misfit(s, f, radius);
    s->round = s->oval < OVAL;
    return 0;
}

/* The normal matrix of the fit: half of it, a plane for each neighbour of a node, right
 * of it in its row or in the three rows after. */
#define ACROSS 7
#define PLANES (4 + 3 * ACROSS)

typedef struct normal {
    const plft_shape *s;
    double *plane; /* [PLANES][m][m] */
    double *line;  /* [2][4][m] couplings along one axis, of one bin */
} normal;

/* Plane of the neighbour dx columns and dy rows on. */
static double *plane_of(const normal *a, int dx, int dy)
{
    const int k = dy == 0 ? dx : 4 + (dy - 1) * ACROSS + dx + 3;
    return a->plane + (size_t)k * (size_t)a->s->m * (size_t)a->s->m;
}

/* Couplings [4][m] of the nodes of one axis with themselves and the next three: sums
 * over n pixels, the first one's nodes from i0 on with weights w. */
static void couple(const plft_shape *s, int n, int i0, const double w[4], double *line)
{
    int q, i, d;

    memset(line, 0, 4u * (size_t)s->m * sizeof *line);
    for (q = 0; q < n; q++) {
        for (d = 0; d < 4; d++) {
            for (i = 0; i + d < 4; i++) {
                line[d * s->m + i0 + q * s->per + i] += w[i] * w[i + d];
            }
        }
    }
}

/* plane[j][i] += weight * y[j] * x[i - back] */
static void outer(int m, double weight, const double *y, const double *x, int back,
                  double *restrict plane)
{
    int i, j;

    for (j = 0; j < m; j++) {
        const double f = weight * y[j];
        for (i = back; f > 0.0 && i < m; i++) {
            plane[j * m + i] += f * x[i - back];
        }
    }
}

/* All pixels of a bin share the same spline weights, so its part of the matrix is a
 * product of two lines. */
static void add_bin(normal *a, const plft_fold *f, size_t bin, double total,
                    double *rhs)
{
    const plft_shape *s = a->s;
    const double inv = 1.0 / f->weight[bin], weight = f->weight[bin] / total;
    const double *data = f->sum + bin * (size_t)f->n * (size_t)f->n;
    double tx, ty, wx[4], wy[4], *x = a->line, *y = a->line + 4 * s->m;
    const int i0 = node(s, -f->half - f->fx[bin] * inv, &tx);
    const int j0 = node(s, -f->half - f->fy[bin] * inv, &ty);
    int qx, qy, dx, dy;

    spline(tx, wx);
    spline(ty, wy);
    couple(s, f->n, i0, wx, x);
    couple(s, f->n, j0, wy, y);
    for (dy = 0; dy < 4; dy++) {
        for (dx = dy == 0 ? 0 : -3; dx < 4; dx++) {
            outer(s->m, weight, y + dy * s->m, x + abs(dx) * s->m, dx < 0 ? -dx : 0,
                  plane_of(a, dx, dy));
        }
    }
    for (qy = 0; qy < f->n; qy++) {
        for (qx = 0; qx < f->n; qx++) {
            double *to = rhs + (j0 + qy * s->per) * s->m + i0 + qx * s->per;
            const double v = weight * inv * data[qy * f->n + qx];
            for (dy = 0; dy < 4; dy++) {
                for (dx = 0; dx < 4; dx++) {
                    to[dy * s->m + dx] += v * wy[dy] * wx[dx];
                }
            }
        }
    }
}

/* out[k] += a[k] x[k + shift], and the mirrored half; shift 0 has none. */
static void couple_planes(const double *restrict a, const double *restrict x, int n,
                          int shift, double *restrict out)
{
    int k;

    for (k = 0; k < n - shift; k++) {
        out[k] += a[k] * x[k + shift];
    }
    for (k = shift; shift > 0 && k < n; k++) {
        out[k] += a[k - shift] * x[k - shift];
    }
}

/* out += SMOOTH * D'D x with D the second differences along rows and columns. */
static void smooth(const plft_shape *s, const double *x, double *out)
{
    const int m = s->m;
    int i, j;

    for (j = 0; j < m; j++) {
        for (i = 0; i < m; i++) {
            const int k = j * m + i;
            if (i > 0 && i < m - 1) {
                double d = SMOOTH * (x[k - 1] - 2.0 * x[k] + x[k + 1]);
                out[k - 1] += d;
                out[k] -= 2.0 * d;
                out[k + 1] += d;
            }
            if (j > 0 && j < m - 1) {
                double d = SMOOTH * (x[k - m] - 2.0 * x[k] + x[k + m]);
                out[k - m] += d;
                out[k] -= 2.0 * d;
                out[k + m] += d;
            }
        }
    }
}

/* out = A x */
static void multiply(const normal *a, const double *x, double *out)
{
    const int m = a->s->m;
    int dx, dy;

    memset(out, 0, sizeof(double) * (size_t)m * (size_t)m);
    for (dy = 0; dy < 4; dy++) {
        for (dx = dy == 0 ? 0 : -3; dx < 4; dx++) {
            couple_planes(plane_of(a, dx, dy), x, m * m, dy * m + dx, out);
        }
    }
    smooth(a->s, x, out);
}

static double dot(const double *a, const double *b, int n)
{
    double s = 0.0;
    int k;

    for (k = 0; k < n; k++) {
        s += a[k] * b[k];
    }
    return s;
}

/* Conjugate gradients from the coefficients at hand; r, p, q are scratch, r holds the
 * right-hand side. */
static void descend(plft_shape *s, const normal *a, double *r, double *p, double *q)
{
    const int n = s->m * s->m;
    double rr, stop;
    int step, k;

    multiply(a, s->c, q);
    for (k = 0; k < n; k++) {
        p[k] = r[k] -= q[k];
    }
    rr = dot(r, r, n);
    stop = 1e-18 * rr;
    for (step = 0; step < STEPS && rr > stop; step++) {
        double alpha, next;
        multiply(a, p, q);
        alpha = rr / dot(p, q, n);
        for (k = 0; k < n; k++) {
            s->c[k] += alpha * p[k];
            r[k] -= alpha * q[k];
        }
        next = dot(r, r, n);
        for (k = 0; k < n; k++) {
            p[k] = r[k] + next / rr * p[k];
        }
        rr = next;
    }
}

static int solve(plft_shape *s, const plft_fold *f, double total)
{
    const size_t n = (size_t)s->m * (size_t)s->m;
    const size_t bins = (size_t)f->phases * (size_t)f->phases;
    normal a = {s, NULL, NULL};
    double *r = calloc((PLANES + 3u) * n + 8u * (size_t)s->m, sizeof *r);
    size_t b;

    if (r == NULL) {
        return -1;
    }
    a.plane = r + 3u * n;
    a.line = a.plane + PLANES * n;
    for (b = 0; b < bins; b++) {
        if (f->weight[b] > 0.0) {
            add_bin(&a, f, b, total, r);
        }
    }
    descend(s, &a, r, r + n, r + 2u * n);
    free(r);
    return 0;
}

/* The same function on twice as many nodes: cubic two-scale relation, 1 4 6 4 1 over
 * 8. */
static int refine(plft_shape *s)
{
    static const double even[3] = {0.125, 0.75, 0.125};
    const int m = s->m, m2 = 2 * m - 3;
    double *fine = calloc((size_t)m2 * (size_t)m2, sizeof *fine);
    int x, y, i, j;

    if (fine == NULL) {
        return -1;
    }
    for (y = 0; y < m2; y++) { /* fine node k sits at coarse (k+1)/2 */
        for (x = 0; x < m2; x++) {
            const int ox = (x + 1) % 2, oy = (y + 1) % 2;
            double sum = 0.0;
            for (j = 0; j < 3 - oy; j++) {
                for (i = 0; i < 3 - ox; i++) {
                    int cx = (x + 1) / 2 + i - (ox ? 0 : 1),
                        cy = (y + 1) / 2 + j - (oy ? 0 : 1);
                    double w = (ox ? 0.5 : even[i]) * (oy ? 0.5 : even[j]);
                    cx = cx < 0 ? 0 : cx >= m ? m - 1 : cx;
                    cy = cy < 0 ? 0 : cy >= m ? m - 1 : cy;
                    sum += w * s->c[cy * m + cx];
                }
            }
            fine[y * m2 + x] = sum;
        }
    }
    free(s->c);
    s->c = fine;
    s->m = m2;
    s->per *= 2;
    return 0;
}

int plft_shape_fit(plft_shape *s, const plft_fold *f, int per)
{
    double total = 0.0;
    int k;

    for (k = 0; k < f->phases * f->phases; k++) {
        total += f->weight[k];
    }
    free(s->c);
    s->half = f->half;
    s->per = 1;
    s->m = 2 * (f->half + 1) + 3; /* nodes -half-2 .. half+2 */
    s->c = calloc((size_t)s->m * (size_t)s->m, sizeof *s->c);
    if (s->c == NULL || !(total > 0.0) || solve(s, f, total) != 0) {
        return -1;
    }
    while (s->per < per) {
        if (refine(s) != 0 || solve(s, f, total) != 0) {
            return -1;
        }
    }
    return 0;
}

void plft_shape_free(plft_shape *s)
{
    free(s->c);
    free(s->ring);
    memset(s, 0, sizeof *s);
}

/* One Gauss-Newton step of the centre; returns its length.  Sums over half the disc:
 * the other half repeats it. */
static double centre_step(plft_shape *s, double radius, double step)
{
    double xx = 0, xy = 0, yy = 0, rx = 0, ry = 0, det, dx, dy, x, y, e2 = 0, n = 0;

    for (y = 0.5 * step; y <= radius; y += step) {
        for (x = -radius; x <= radius; x += step) {
            double a, ax, ay, b, bx, by, e;
            if (x * x + y * y > radius * radius) {
                continue;
            }
            plft_shape_slope(s, s->centre.x + x, s->centre.y + y, &a, &ax, &ay);
            plft_shape_slope(s, s->centre.x - x, s->centre.y - y, &b, &bx, &by);
            e = a - b;
            ax -= bx;
            ay -= by;
            xx += ax * ax;
            xy += ax * ay;
            yy += ay * ay;
            rx += ax * e;
            ry += ay * e;
            e2 += e * e;
            n += 1.0;
        }
    }
    s->asymmetry = e2;
    det = xx * yy - xy * xy;
    if (!(det > 1e-12 * xx * yy)) {
        return 0.0;
    }
    dx = -(yy * rx - xy * ry) / det;
    dy = -(xx * ry - xy * rx) / det;
    /* Samples nearer than a pixel repeat each other: n * step^2 independent ones. */
    s->centre_sigma = sqrt(0.5 * e2 / n * (xx + yy) / det / (step * step));
    dx = fmax(-0.5, fmin(0.5, dx));
    dy = fmax(-0.5, fmin(0.5, dy));
    s->centre.x += dx;
    s->centre.y += dy;
    return hypot(dx, dy);
}

static double contrast(const plft_shape *s, double radius, double step)
{
    double sum = 0, sum2 = 0, x, y, n = 0;

    for (y = 0.5 * step; y <= radius; y += step) {
        for (x = -radius; x <= radius; x += step) {
            if (x * x + y * y <= radius * radius) {
                double v = plft_shape_at(s, s->centre.x + x, s->centre.y + y);
                sum += v;
                sum2 += v * v;
                n += 1.0;
            }
        }
    }
    return sum2 - sum * sum / fmax(n, 1.0);
}

void plft_shape_centre(plft_shape *s, double radius)
{
    const double step = radius > 16.0 ? radius / 32.0 : 0.5;
    int k;

    for (k = 0; k < 12 && centre_step(s, radius, step) > 1e-7; k++) {
    }
    s->asymmetry = sqrt(s->asymmetry / fmax(contrast(s, radius, step), 1e-30));
}
