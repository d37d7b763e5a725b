/* SPDX-License-Identifier: MIT
 * Extent, flags, radius and figures of a fitted field of lenses. */
#include "calib/calib.h"

#include "calib/linalg.h"
#include "calib/outline.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LIT     0.02 /* of the best level: less is no light */
#define DIM     0.125
#define MATCH   0.25
#define CUT     4.5
#define MARGIN  2.5   /* default usable radius: that much inside the micro-image, px */
#define STRAY_Z 2.054 /* deviations that leave 2 % of a blurred edge */
#define DEGREES 57.295779513082320877

static int fail(plft_calib *c, const char *reason)
{
    snprintf(c->reason, sizeof c->reason, "%s", reason);
    return -1;
}

/* The q quantile of a spot figure over the spots without flags. */
static double quantile(const plft_field *f, double (*get)(const plft_spot *), double q)
{
    const int n = f->nx * f->ny;
    double *v = malloc((size_t)n * sizeof *v), r;
    int k, count = 0;

    for (k = 0; v != NULL && k < n; k++) {
        if (f->spot[k].flags == 0) {
            v[count++] = get(&f->spot[k]);
        }
    }
    r = count > 0 ? plft_select(v, count, (int)(q * (count - 1))) : 0.0;
    free(v);
    return r;
}

static double get_gain(const plft_spot *s)
{
    return s->gain;
}

static double get_sigma(const plft_spot *s)
{
    return s->sigma;
}

static double get_match(const plft_spot *s)
{
    return s->match;
}

static double get_rms(const plft_spot *s)
{
    return s->rms;
}

static int lit(const plft_spot *s, double best)
{
    return s->seen > 0.0f && s->match >= (float)MATCH && s->gain >= LIT * best;
}

/* Quality of every lens of the field from its own measurement. */
static void flag_lenses(plft_field *f, double best)
{
    int k;

    for (k = 0; k < f->nx * f->ny; k++) {
        plft_spot *s = &f->spot[k];
        uint8_t flags = s->flags & PLFX_LENS_INTERP;
        if (!lit(s, best)) {
            flags = PLFX_LENS_MISSING;
        } else if ((s->flags & PLFX_LENS_MISSING) != 0u) {
            flags = PLFX_LENS_INTERP; /* light, but its place could not be measured */
        }
        if (flags != PLFX_LENS_MISSING && s->gain < DIM * best) {
            flags |= PLFX_LENS_DIM;
        }
        if (s->clipped >= 3) {
            flags |= PLFX_LENS_CLIPPED;
        }
        s->flags = flags;
    }
}

/* A dark place of a scene says nothing about its lens: all lenses on the picture count,
 * those that could not be measured as interpolated. */
static void flag_scene(plft_calib *c, const plft_grey *g)
{
    plft_field *f = &c->field;
    int k;

    for (k = 0; k < f->nx * f->ny; k++) {
        plft_spot *s = &f->spot[k];
        const plft_vec p =
            plft_model_at(&c->model, f->i0 + k % f->nx, f->j0 + k / f->nx);
        if (p.x < -0.5 || p.y < -0.5 || p.x >= g->w - 0.5 || p.y >= g->h - 0.5) {
            s->flags = PLFX_LENS_MISSING;
        } else {
            s->flags = s->flags != 0 ? PLFX_LENS_INTERP : 0;
        }
    }
}

static int is_lit(const plft_field *f, int i, int j)
{
    return i >= 0 && j >= 0 && i < f->nx && j < f->ny &&
           (f->spot[j * f->nx + i].flags & PLFX_LENS_MISSING) == 0u;
}

/* Rows and columns between the outermost lit lenses that have two lit neighbours. */
static int extent(const plft_field *f, int *i0, int *i1, int *j0, int *j1)
{
    int i, j, x, y;

    *i0 = f->nx;
    *j0 = f->ny;
    *i1 = *j1 = -1;
    for (j = 0; j < f->ny; j++) {
        for (i = 0; i < f->nx; i++) {
            int n = 0;
            for (y = -1; y <= 1; y++) {
                for (x = -1; x <= 1; x++) {
                    n += is_lit(f, i + x, j + y);
                }
            }
            if (is_lit(f, i, j) && n >= 3) {
                *i0 = i < *i0 ? i : *i0;
                *i1 = i > *i1 ? i : *i1;
                *j0 = j < *j0 ? j : *j0;
                *j1 = j > *j1 ? j : *j1;
            }
        }
    }
    return *i1 - *i0 >= 4 && *j1 - *j0 >= 4 ? 0 : -1;
}

/* Cut the field to its extent, row and column 0 first, centres in sensor pixels.
 * When a hexagonal field begins with an odd row, even rows become odd ones and step
 * back by one column, so that odd rows are the ones shifted right. */
static int cut_field(plft_calib *c, const plft_grey *g)
{
    plft_field *f = &c->field;
    int i0, i1, j0, j1, i, j, odd;
    plft_field n;

    if (extent(f, &i0, &i1, &j0, &j1) != 0) {
        return fail(c, "fewer than 5 x 5 lenses");
    }
    odd = f->kind == PLFX_LATTICE_HEX && ((f->j0 + j0) & 1) != 0;
    i0 -= odd && i0 > 0; /* the even rows' first lens would fall off on the left */
    n.kind = f->kind;
    n.i0 = n.j0 = 0;
    n.nx = i1 - i0 + 1;
    n.ny = j1 - j0 + 1;
    n.spot = calloc((size_t)(n.nx * n.ny), sizeof *n.spot);
    if (n.spot == NULL) {
        return fail(c, "out of memory");
    }
    for (j = 0; j < n.ny; j++) {
        for (i = 0; i < n.nx; i++) {
            const int old = i0 + i + (odd && j % 2 != 0);
            plft_spot *s = &n.spot[j * n.nx + i];
            s->flags = PLFX_LENS_MISSING;
            if (old < f->nx) {
                *s = f->spot[(j0 + j) * f->nx + old];
            }
            s->x += g->shift;
            s->y += g->shift;
        }
    }
    free(f->spot);
    *f = n;
    return 0;
}

/* Fit again in the final indices, then drop empty columns that the shift left. */
static int refit(plft_calib *c)
{
    if (plft_model_fit(&c->model, &c->field, c->input == PLFT_INPUT_SCENE ? 2 : 3,
                       CUT) != 0) {
        return fail(c, "no lens lattice: too few lenses agree");
    }
    plft_model_lattice(&c->model, &c->field, &c->lattice);
    c->lattice.nx = c->field.nx;
    c->lattice.ny = c->field.ny;
    c->lattice.turned = fabs(c->lattice.a.y) > fabs(c->lattice.a.x);
    c->pitch = plft_lattice_mean_pitch(&c->lattice);
    return 0;
}

/* Mean of the shape on a circle. */
static double ring(const plft_shape *s, double r)
{
    double sum = 0.0;
    int k;

    for (k = 0; k < 48; k++) {
        double angle = 6.28318530717958647693 * k / 48.0;
        sum += plft_shape_at(s, s->centre.x + r * cos(angle),
                             s->centre.y + r * sin(angle));
    }
    return sum / 48.0;
}

/* First radius at which the mean profile falls below `part` of its height. */
static double radius_at(const plft_calib *c, double top, double floor_, double part)
{
    double r;

    for (r = 0.0; r < 0.6 * c->pitch; r += 0.02) {
        if (ring(&c->shape, r) < floor_ + part * (top - floor_)) {
            break;
        }
    }
    return r;
}

/* Largest radius at which a neighbour adds at most 2 % of a lens' light.  A lens'
 * edge, blurred by sigma, falls from 3/4 to 1/2 over 0.674 sigma; at the border its
 * share is half of the cross-talk, z sigma outside its edge, and z grows by one with
 * each sigma inside the border. */
static double clean_radius(const plft_calib *c, double top, double black)
{
    const double sigma =
        (radius_at(c, top, black, 0.5) - radius_at(c, top, black, 0.75)) / 0.674;
    double z = 0.0;

    while (z < 4.0 && 0.5 * erfc(z / sqrt(2.0)) > 0.5 * c->crosstalk) {
        z += 0.01;
    }
    return 0.5 * c->pitch - sigma * fmax(0.0, STRAY_Z - z);
}

/* Input kind of a mean profile; radii; cross-talk. */
static void profile(plft_calib *c, const plft_grey *g, double wanted)
{
    const double top = ring(&c->shape, 0.1 * c->pitch);
    const plft_vec a = c->lattice.a;
    double low = HUGE_VAL, r, half, soft, edge;

    for (r = 0.0; r <= 0.55 * c->pitch; r += 0.1) {
        low = fmin(low, ring(&c->shape, r));
    }
    half = radius_at(c, ring(&c->shape, 0.0), low, 0.5);
    if (half < 0.22 * c->pitch && c->input != PLFT_INPUT_SCENE) {
        c->input = PLFT_INPUT_DOTS;
    }
    half = radius_at(c, top, low, 0.5);
    soft = radius_at(c, top, low, 0.25) - radius_at(c, top, low, 0.75);
    c->edge_radius =
        c->input == PLFT_INPUT_WHITE && soft < 0.35 * half ? half : 0.5 * c->pitch;
    edge = plft_shape_at(&c->shape, c->shape.centre.x + 0.5 * a.x,
                         c->shape.centre.y + 0.5 * a.y);
    c->crosstalk = fmax(0.0, edge - g->pedestal) /
                   fmax(plft_shape_at(&c->shape, c->shape.centre.x, c->shape.centre.y) -
                            g->pedestal,
                        1.0);
    c->usable_radius = c->edge_radius - MARGIN;
    if (c->input == PLFT_INPUT_WHITE) {
        c->usable_radius = fmin(c->usable_radius, clean_radius(c, top, g->pedestal));
    }
    c->usable_radius = wanted > 0.0 ? wanted : fmax(c->usable_radius, 0.25 * c->pitch);
    c->peak = top - low;
}

/* Covariance of the residuals of neighbouring pixels of one lens, and of the
 * contrast. */
static void structure(const plft_calib *c, const plft_grey *g, const plft_spot *s,
                      double *cov, double *n)
{
    const int r = (int)(0.4 * c->pitch);
    const int cx = (int)floor(s->x + 0.5), cy = (int)floor(s->y + 0.5);
    double last = 0.0;
    int x, y;

    if (cx < r || cy < r || cx + r >= g->w || cy + r >= g->h) {
        return;
    }
    for (y = -r; y <= r; y++) {
        for (x = -r; x <= r; x++) {
            double v =
                g->px[(size_t)(cy + y) * (size_t)g->w + (size_t)(cx + x)] - s->base;
            v = v / s->gain - plft_shape_at(&c->shape,
                                            c->shape.centre.x + cx + x - s->x,
                                            c->shape.centre.y + cy + y - s->y);
            if (x > -r) {
                *cov += v * last;
                *n += 1.0;
            }
            last = v;
        }
    }
}

/* 95 % point of the relative change of contrast from a lens to the next in its row. */
static double unevenness(const plft_field *f)
{
    const int n = f->nx * f->ny;
    double *v = malloc((size_t)n * sizeof *v), r;
    int k, count = 0;

    for (k = 0; v != NULL && k + 1 < n; k++) {
        const plft_spot *s = &f->spot[k];
        if (k % f->nx + 1 < f->nx && s[0].flags == 0 && s[1].flags == 0) {
            v[count++] =
                fabs((double)s[1].gain - s[0].gain) / ((double)s[1].gain + s[0].gain);
        }
    }
    r = count > 0 ? plft_select(v, count, (int)(0.95 * (count - 1))) : 0.0;
    free(v);
    return r;
}

/* A scene shows as structure inside the lenses that the mean micro-image has not, or as
 * changes from lens to lens. */
static int is_scene(const plft_calib *c, const plft_grey *g)
{
    const int total = c->field.nx * c->field.ny, step = total / 400 + 1;
    double cov = 0.0, n = 0.0;
    int k;

    for (k = 0; k < total; k += step) {
        if (c->field.spot[k].flags == 0) {
            structure(c, g, &c->field.spot[k], &cov, &n);
        }
    }
    return (n > 0.0 && cov > 0.0 && sqrt(cov / n) > 0.1 * c->peak) ||
           unevenness(&c->field) > 0.08;
}

static double q12(double v)
{
    return fmax(-8.0, fmin(8.0 - 1.0 / 4096.0, v));
}

/* Centres for the table: the lattice; its distortion where that reaches 0.004 px; a
 * lens' own deviation, shrunk by its noise, where such deviations are real. */
static int finish_centres(plft_calib *c)
{
    const plft_field *f = &c->field;
    const double sigma = quantile(f, get_sigma, 0.5);
    double largest = 0.0;
    int i, j;

    c->final = calloc((size_t)(f->nx * f->ny), sizeof *c->final);
    if (c->final == NULL) {
        return fail(c, "out of memory");
    }
    c->individual = c->input != PLFT_INPUT_SCENE && c->model.tau > 0.01 &&
                    c->model.tau > 2.0 * sigma;
    for (j = 0; j < f->ny; j++) {
        for (i = 0; i < f->nx; i++) {
            plft_vec l = plft_lattice_at(&c->lattice, i, j),
                     m = plft_model_at(&c->model, i, j);
            largest = fmax(largest, hypot(m.x - l.x, m.y - l.y));
        }
    }
    c->smooth = largest > 0.004;
    for (j = 0; j < f->ny; j++) {
        for (i = 0; i < f->nx; i++) {
            const int k = j * f->nx + i;
            const plft_spot *s = &f->spot[k];
            plft_vec l = plft_lattice_at(&c->lattice, i, j);
            plft_vec p = c->smooth ? plft_model_at(&c->model, i, j) : l;
            if (c->individual &&
                (s->flags & (PLFX_LENS_MISSING | PLFX_LENS_INTERP)) == 0u) {
                double t2 = c->model.tau * c->model.tau;
                double w = t2 / (t2 + (double)s->sigma * s->sigma);
                p.x += w * (s->x - p.x);
                p.y += w * (s->y - p.y);
            }
            p.x = l.x + q12(p.x - l.x);
            p.y = l.y + q12(p.y - l.y);
            c->final[k] = p;
        }
    }
    return 0;
}

static void count_flags(plft_calib *c, const plft_grey *g)
{
    int k;

    for (k = 0; k < c->field.nx * c->field.ny; k++) {
        plft_spot *s = &c->field.spot[k];
        const plft_vec p = c->final[k];
        if (p.x < -0.5 || p.y < -0.5 || p.x >= g->w - 0.5 || p.y >= g->h - 0.5) {
            s->flags = PLFX_LENS_MISSING | PLFX_LENS_INTERP;
            c->off_sensor++;
            continue;
        }
        if ((s->flags & PLFX_LENS_MISSING) != 0u) {
            s->flags |= PLFX_LENS_INTERP;
            c->missing++;
            continue;
        }
        c->found++;
        c->dim += (s->flags & PLFX_LENS_DIM) != 0u;
        c->clipped += (s->flags & PLFX_LENS_CLIPPED) != 0u;
        c->interpolated += (s->flags & PLFX_LENS_INTERP) != 0u;
    }
}

/* 1-sigma of the lattice figures from the covariance of the fit. */
static void sigmas(plft_calib *c)
{
    const plft_model *m = &c->model;
    const double step = sqrt(m->cov[PLFT_TERMS + 1]) / m->scale;

    c->origin_sigma =
        hypot(plft_model_sigma(m, (int)m->ic, (int)m->jc), c->shape.centre_sigma);
    c->pitch_sigma = step;
    c->rotation_sigma = DEGREES * step / hypot(c->lattice.a.x, c->lattice.a.y);
}

int plft_calib_finish(plft_calib *c, const plft_grey *g, const plft_calib_options *o,
                      const plft_bank *bank)
{
    const double best = quantile(&c->field, get_gain, 0.95);

    c->peak = bank->peak;
    c->input = is_scene(c, g) ? PLFT_INPUT_SCENE : PLFT_INPUT_WHITE;
    if (c->input == PLFT_INPUT_SCENE) {
        flag_scene(c, g);
    } else {
        flag_lenses(&c->field, best);
    }
    if (cut_field(c, g) != 0 || refit(c) != 0) {
        return -1;
    }
    profile(c, g, o->radius);
    c->spot_sigma = quantile(&c->field, get_sigma, 0.5);
    c->match = quantile(&c->field, get_match, 0.5);
    c->noise = quantile(&c->field, get_rms, 0.5) / 65535.0;
    c->level = best * c->peak / 65535.0;
    if (finish_centres(c) != 0) {
        return -1;
    }
    count_flags(c, g);
    if (4 * c->found < c->field.nx * c->field.ny - c->off_sensor) {
        return fail(c,
                    "no lens lattice: fewer than a quarter of the places hold a lens");
    }
    if (c->model.rms > 0.12 * c->pitch) {
        return fail(c,
                    "no lens lattice: the places found scatter by more than an eighth "
                    "of the pitch");
    }
    plft_outline(c);
    if (plft_outline_odd(c) == 1) {
        snprintf(c->reason, sizeof c->reason,
                 "no lens pattern: what repeats is not the round image of an aperture "
                 "(its half-light radius varies by %.0f %%) but some texture, or "
                 "images that overlap",
                 100.0 * c->outline);
        return -1;
    }
    sigmas(c);
    return 0;
}
