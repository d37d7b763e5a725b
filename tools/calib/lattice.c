/* SPDX-License-Identifier: MIT
 * Lattice conventions in double precision. */
#include "calib/lattice.h"

#include <math.h>
#include <string.h>

#define DEGREES   57.295779513082320877
#define TOLERANCE 0.12 /* of lengths and of the cosine, when a kind is recognised */

static double dot(plft_vec p, plft_vec q)
{
    return p.x * q.x + p.y * q.y;
}

static double cross(plft_vec p, plft_vec q)
{
    return p.x * q.y - p.y * q.x;
}

static plft_vec axpy(double k, plft_vec p, plft_vec q)
{
    plft_vec r = {q.x + k * p.x, q.y + k * p.y};
    return r;
}

plft_vec plft_lattice_at(const plft_lattice *l, int i, int j)
{
    plft_vec p = axpy(j, l->b, axpy(i, l->a, l->origin));
    return j % 2 != 0 ? axpy(1.0, l->odd, p) : p;
}

double plft_lattice_pitch(const plft_lattice *l)
{
    plft_vec u = l->kind == PLFX_LATTICE_HEX ? axpy(1.0, l->odd, l->b) : l->b;
    return fmin(sqrt(dot(l->a, l->a)), sqrt(dot(u, u)));
}

double plft_lattice_mean_pitch(const plft_lattice *l)
{
    const double row = l->kind == PLFX_LATTICE_HEX ? 0.86602540378443864676 : 1.0;
    return sqrt(fabs(cross(l->a, l->b)) / row);
}

double plft_lattice_rotation(const plft_lattice *l)
{
    return DEGREES * (l->turned ? atan2(-l->a.x, l->a.y) : atan2(l->a.y, l->a.x));
}

void plft_basis_reduce(plft_vec *v1, plft_vec *v2)
{
    int step;

    for (step = 0; step < 64; step++) { /* Gauss: lengths at least halve in a few */
        double k;
        if (dot(*v1, *v1) > dot(*v2, *v2)) {
            plft_vec swap = *v1;
            *v1 = *v2;
            *v2 = swap;
        }
        k = floor(dot(*v1, *v2) / dot(*v1, *v1) + 0.5);
        if (k == 0.0 || !(dot(*v1, *v1) > 0.0)) {
            break;
        }
        *v2 = axpy(-k, *v1, *v2);
    }
    if (dot(*v1, *v2) < 0.0) {
        v2->x = -v2->x;
        v2->y = -v2->y;
    }
}

/* Of the n vectors and their opposites, the one whose dot product with d is largest. */
static plft_vec nearest_direction(const plft_vec *v, int n, plft_vec d)
{
    plft_vec best = v[0];
    int k;

    for (k = 0; k < 2 * n; k++) {
        plft_vec c = v[k / 2];
        if (k % 2 != 0) {
            c.x = -c.x;
            c.y = -c.y;
        }
        if (dot(c, d) > dot(best, d)) {
            best = c;
        }
    }
    return best;
}

static void orient_hex(plft_vec v1, plft_vec v2, plft_lattice *l)
{
    const plft_vec right = {1.0, 0.0}, down = {0.0, 1.0};
    plft_vec v[3], across, u;

    v[0] = v1;
    v[1] = v2;
    v[2] = axpy(-1.0, v1, v2);
    l->a = nearest_direction(v, 3, right);
    l->turned = fabs(l->a.y) > l->a.x * 0.26794919243112270647; /* tan 15 degrees */
    if (l->turned) {
        l->a = nearest_direction(v, 3, down);
    }
    across.x =
        0.5 * l->a.x - 0.86602540378443864676 * l->a.y; /* a turned by 60 degrees */
    across.y = 0.5 * l->a.y + 0.86602540378443864676 * l->a.x;
    u = nearest_direction(v, 3, across);
    l->odd.x = 0.5 * l->a.x;
    l->odd.y = 0.5 * l->a.y;
    l->b = axpy(-1.0, l->odd, u);
}

static void orient_square(plft_vec v1, plft_vec v2, plft_lattice *l)
{
    const plft_vec right = {1.0, 0.0};
    plft_vec v[2], across;

    v[0] = v1;
    v[1] = v2;
    l->a = nearest_direction(v, 2, right);
    across.x = -l->a.y;
    across.y = l->a.x;
    l->b = nearest_direction(v, 2, across);
}

int plft_lattice_orient(plft_vec v1, plft_vec v2, int want, plft_lattice *l)
{
    double c, ratio;

    plft_basis_reduce(&v1, &v2);
    memset(l, 0, sizeof *l);
    ratio = sqrt(dot(v2, v2) / dot(v1, v1));
    c = dot(v1, v2) / sqrt(dot(v1, v1) * dot(v2, v2));
    l->kind = want == PLFT_LATTICE_AUTO
                  ? (c > 0.25 ? PLFX_LATTICE_HEX : PLFX_LATTICE_SQUARE)
                  : want;
    if (!(cross(v1, v2) != 0.0) || ratio > 1.0 + TOLERANCE ||
        fabs(c - (l->kind == PLFX_LATTICE_HEX ? 0.5 : 0.0)) > TOLERANCE) {
        return -1;
    }
    if (l->kind == PLFX_LATTICE_HEX) {
        orient_hex(v1, v2, l);
    } else {
        orient_square(v1, v2, l);
    }
    return 0;
}

void plft_lattice_coords(const plft_lattice *l, plft_vec p, double *s, double *t)
{
    plft_vec d = axpy(-1.0, l->origin, p);
    double det = cross(l->a, l->b);

    *s = cross(d, l->b) / det;
    *t = cross(l->a, d) / det;
}

void plft_lattice_nearest(const plft_lattice *l, plft_vec p, int *i, int *j)
{
    double s, t, best = HUGE_VAL;
    int row, k;

    plft_lattice_coords(l, p, &s, &t);
    row = (int)floor(t);
    for (k = row; k <= row + 1; k++) { /* the nearest centre lies in one of two rows */
        double o = k % 2 != 0 && l->kind == PLFX_LATTICE_HEX ? 0.5 : 0.0;
        int col = (int)floor(s - o + 0.5);
        plft_vec d = axpy(-1.0, plft_lattice_at(l, col, k), p);
        if (dot(d, d) < best) {
            best = dot(d, d);
            *i = col;
            *j = k;
        }
    }
}

static int quantise_vec(plft_vec v, plfx_vec_q22 *q)
{
    const double one = 4194304.0; /* 2^22 */

    if (!(fabs(v.x) < 511.0) || !(fabs(v.y) < 511.0)) {
        return -1;
    }
    q->x_q22 = (int32_t)floor(v.x * one + 0.5);
    q->y_q22 = (int32_t)floor(v.y * one + 0.5);
    return 0;
}

int plft_lattice_quantise(const plft_lattice *l, plfx_lattice *out)
{
    plfx_lattice q;

    memset(&q, 0, sizeof q);
    q.kind = l->kind;
    q.nx = l->nx;
    q.ny = l->ny;
    if (quantise_vec(l->a, &q.a) != 0 || quantise_vec(l->b, &q.b) != 0 ||
        quantise_vec(l->odd, &q.odd) != 0 || !(fabs(l->origin.x) < 32767.0) ||
        !(fabs(l->origin.y) < 32767.0)) {
        return -1;
    }
    q.origin.x_q16 = (int32_t)floor(l->origin.x * 65536.0 + 0.5);
    q.origin.y_q16 = (int32_t)floor(l->origin.y * 65536.0 + 0.5);
    *out = q;
    return 0;
}
