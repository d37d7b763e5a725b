/* SPDX-License-Identifier: MIT
 * Similarity between a table and a frame. */
#include "calib/drift.h"

#include "calib/linalg.h"
#include "calib/locate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENSES 3000
#define ROUNDS 6
#define MATCH  0.3
#define CUT    4.0
#define MOVED  0.05 /* px at the worst corner */

typedef struct place {
    plft_vec at;   /* by the table, pixels of the grey picture */
    double dx, dy; /* measured displacement */
    double weight; /* 0: not used */
} place;

typedef struct work {
    const plft_grey *g;
    double pitch;
    place *p;
    int n;
    plft_shape shape;
    plft_drift *d;
} work;

static int fail(plft_drift *d, const char *reason)
{
    snprintf(d->reason, sizeof d->reason, "%s", reason);
    return -1;
}

/* Every so-manieth lens without a flag. */
static int collect(work *w, const plfx_lut *lut)
{
    const int nx = lut->lattice.nx, n = nx * lut->lattice.ny, step = n / LENSES + 1;
    int k;

    w->p = calloc((size_t)(n / step + 1), sizeof *w->p);
    for (k = 0; w->p != NULL && k < n; k += step) {
        if (plfx_lut_flags(lut, k % nx, k / nx) == 0u) {
            const plfx_point c = plfx_lut_centre(lut, k % nx, k / nx);
            w->p[w->n].at.x = c.x_q16 / 65536.0 - w->g->shift;
            w->p[w->n++].at.y = c.y_q16 / 65536.0 - w->g->shift;
        }
    }
    return w->p != NULL ? 0 : fail(w->d, "out of memory");
}

static plft_vec moved(const work *w, plft_vec at)
{
    const plft_drift *d = w->d;
    const double x = at.x - 0.5 * w->g->w, y = at.y - 0.5 * w->g->h;
    plft_vec p = {at.x + d->shift_x + d->scale * x - d->rotation * y,
                  at.y + d->shift_y + d->rotation * x + d->scale * y};
    return p;
}

/* Mean micro-image where the lenses are thought to be; its centre of symmetry moves the
 * shift. */
static int reshape(work *w, plft_bank *bank)
{
    const double radius = 0.5 * w->pitch + 0.5;
    plft_fold fold;
    int k, status;

    if (plft_fold_init(&fold, (int)ceil(radius) + 2, w->pitch > 32.0 ? 4 : 8) != 0) {
        return fail(w->d, "out of memory");
    }
    for (k = 0; k < w->n; k++) {
        plft_fold_add(&fold, w->g, moved(w, w->p[k].at));
    }
    status = plft_shape_fit(&w->shape, &fold, w->pitch < 24.0 ? 2 : 1);
    w->shape.centre.x = w->shape.centre.y = 0.0;
    if (status == 0) {
        plft_shape_centre(&w->shape, 0.5 * w->pitch);
        w->d->shift_x += w->shape.centre.x;
        w->d->shift_y += w->shape.centre.y;
        status = plft_shape_round(&w->shape, &fold, radius);
    }
    plft_fold_free(&fold);
    plft_bank_free(bank);
    if (status != 0 || plft_bank_init(bank, &w->shape, radius) != 0) {
        return fail(w->d, "the frame disagrees with the table: the micro-images at its "
                          "centres have no structure");
    }
    return 0;
}

static int measure(work *w, const plft_bank *bank)
{
    float *pixels = malloc(2u * (size_t)bank->len * sizeof *pixels);
    const double reach = 0.3 * w->pitch;
    int k;

    if (pixels == NULL) {
        return fail(w->d, "out of memory");
    }
    for (k = 0; k < w->n; k++) {
        const plft_vec guess = moved(w, w->p[k].at);
        plft_spot s;
        plft_locate(bank, w->g, guess, reach, pixels, &s);
        w->p[k].dx = s.x - w->p[k].at.x;
        w->p[k].dy = s.y - w->p[k].at.y;
        w->p[k].weight = s.match > MATCH && s.seen > 0.85f &&
                         hypot(s.x - guess.x, s.y - guess.y) < 0.98 * reach;
    }
    free(pixels);
    return 0;
}

/* Least squares of shift, rotation and scale; covariance for unit variance in g. */
static int solve(work *w, double g[16])
{
    double rhs[4] = {0}, x[4];
    int k, i, j, axis;

    memset(g, 0, 16 * sizeof *g);
    for (k = 0; k < w->n; k++) {
        const double px = w->p[k].at.x - 0.5 * w->g->w,
                     py = w->p[k].at.y - 0.5 * w->g->h;
        const double f[2][4] = {{1.0, 0.0, -py, px}, {0.0, 1.0, px, py}};
        const double r[2] = {w->p[k].dx, w->p[k].dy};
        for (axis = 0; axis < 2; axis++) {
            for (i = 0; i < 4; i++) {
                rhs[i] += w->p[k].weight * f[axis][i] * r[axis];
                for (j = 0; j < 4; j++) {
                    g[4 * i + j] += w->p[k].weight * f[axis][i] * f[axis][j];
                }
            }
        }
    }
    if (plft_spd_invert(g, 4) != 0) {
        return -1;
    }
    plft_mat_vec(g, rhs, 4, x);
    w->d->shift_x = x[0];
    w->d->shift_y = x[1];
    w->d->rotation = x[2];
    w->d->scale = x[3];
    return 0;
}

/* Drop lenses beyond CUT robust deviations; rms of the rest. */
static int reject(work *w)
{
    double *r = malloc((size_t)(w->n + 1) * sizeof *r), limit, sum = 0.0;
    int k, n = 0;

    if (r == NULL) {
        return -1;
    }
    for (k = 0; k < w->n; k++) {
        const plft_vec p = moved(w, w->p[k].at);
        if (w->p[k].weight > 0.0) {
            r[n++] =
                hypot(w->p[k].at.x + w->p[k].dx - p.x, w->p[k].at.y + w->p[k].dy - p.y);
        }
    }
    limit = CUT * plft_median(r, n) / 1.1774 + 1e-6;
    free(r);
    w->d->lenses = 0;
    for (k = 0; k < w->n; k++) {
        const plft_vec p = moved(w, w->p[k].at);
        const double d =
            hypot(w->p[k].at.x + w->p[k].dx - p.x, w->p[k].at.y + w->p[k].dy - p.y);
        w->p[k].weight = w->p[k].weight > 0.0 && d <= limit;
        if (w->p[k].weight > 0.0) {
            sum += d * d;
            w->d->lenses++;
        }
    }
    w->d->rms = sqrt(sum / fmax(2.0 * w->d->lenses - 4.0, 1.0));
    return 0;
}

/* Standard errors, and whether the worst corner moved. */
static void finish(work *w, const double g[16])
{
    plft_drift *d = w->d;
    double sigma;
    int k;

    d->shift_sigma = hypot(d->rms * sqrt(g[0]), w->shape.centre_sigma);
    d->rotation_sigma = d->rms * sqrt(g[10]);
    d->scale_sigma = d->rms * sqrt(g[15]);
    for (k = 0; k < 4; k++) {
        plft_vec c = {k % 2 == 0 ? 0.0 : w->g->w, k / 2 == 0 ? 0.0 : w->g->h};
        plft_vec p = moved(w, c);
        d->corner = fmax(d->corner, hypot(p.x - c.x, p.y - c.y));
    }
    sigma =
        hypot(d->shift_sigma * sqrt(2.0),
              0.5 * hypot(w->g->w, w->g->h) * hypot(d->rotation_sigma, d->scale_sigma));
    d->moved = d->corner > MOVED && d->corner > 4.0 * sigma;
}

static int find(work *w)
{
    plft_bank bank;
    double g[16];
    int round, status = 0;

    memset(&bank, 0, sizeof bank);
    for (round = 0; status == 0 && round < ROUNDS; round++) {
        const plft_drift before = *w->d;
        status = reshape(w, &bank);
        if (status == 0) {
            status = measure(w, &bank);
        }
        if (status == 0 && (solve(w, g) != 0 || reject(w) != 0 || solve(w, g) != 0 ||
                            reject(w) != 0 || 2 * w->d->lenses < w->n)) {
            snprintf(
                w->d->reason, sizeof w->d->reason,
                "the frame disagrees with the table: %d of %d lenses are where a lens "
                "should be",
                w->d->lenses, w->n);
            status = -1;
        }
        if (hypot(before.shift_x - w->d->shift_x, before.shift_y - w->d->shift_y) <
                1e-3 &&
            round > 0) {
            break;
        }
    }
    if (status == 0) {
        finish(w, g);
    }
    plft_bank_free(&bank);
    return status;
}

int plft_drift_find(plft_drift *d, const plfx_lut *lut, const plft_grey *g)
{
    work w;
    int status;

    memset(d, 0, sizeof *d);
    memset(&w, 0, sizeof w);
    w.g = g;
    w.d = d;
    w.pitch = plfx_lut_pitch_q16(lut) / 65536.0;
    if (lut->sensor_w != g->w || lut->sensor_h != g->h) {
        snprintf(d->reason, sizeof d->reason,
                 "the frame is %dx%d but the table is for %dx%d", g->w, g->h,
                 lut->sensor_w, lut->sensor_h);
        return -1;
    }
    status = collect(&w, lut);
    d->tried = w.n;
    if (status == 0) {
        status =
            w.n < 25 ? fail(d, "the table has fewer than 25 good lenses") : find(&w);
    }
    plft_shape_free(&w.shape);
    free(w.p);
    return status;
}
