/* SPDX-License-Identifier: MIT
 * The calibration itself. */
#include "calib/calib.h"

#include "calib/linalg.h"
#include "calib/period.h"
#include "calib/phase.h"
#include "common/progress.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FIRST     4     /* half width of the first region, lenses */
#define GROW      1.5   /* a region against the one before */
#define ENOUGH    5000  /* lenses make a mean micro-image */
#define DISC      0.5   /* registration disc radius, pitches */
#define MATCH_MIN 0.25  /* worst correlation of a lens that counts */
#define CUT       4.5   /* robust deviations of an outlier */
#define STIFF     0.006 /* residual, pitches: over it a region grows on steps alone */
#define PART      3000  /* lenses, about, that are registered while the shape settles */
#define ROUNDS    12
#define FINE      24.0 /* pitch up to which the micro-image gets two nodes a pixel */

typedef struct work {
    const plft_grey *grey;
    plft_calib *out;
    plft_bank bank;
    float *pixels;
    int quiet;
} work;

static int fail(plft_calib *c, const char *format, ...)
{
    va_list args;

    va_start(args, format);
    vsnprintf(c->reason, sizeof c->reason, format, args);
    va_end(args);
    return -1;
}

const char *plft_input_name(plft_input input)
{
    static const char *const name[3] = {"dots", "white", "scene"};
    return name[input];
}

/* Black, saturated and uniform frames, by a sparse histogram. */
static int refuse_flat(plft_calib *c, const plft_grey *g)
{
    const size_t n = (size_t)g->w * (size_t)g->h, step = n / 65536u + 1u;
    double *v = malloc((n / step + 1u) * sizeof *v), low, high;
    size_t k, count = 0;

    if (v == NULL) {
        return fail(c, "out of memory");
    }
    for (k = 0; k < n; k += step) {
        v[count++] = g->px[k];
    }
    low = plft_select(v, (int)count, (int)(count / 200u));
    high = plft_select(v, (int)count, (int)(count - 1u - count / 200u));
    free(v);
    if (low >= 65535.0 || (double)g->saturated > 0.6 * (double)n) {
        return fail(
            c,
            "the frame is saturated (%.0f %% of the pixels are clipped): expose "
            "less",
            100.0 * (double)g->saturated / (double)n);
    }
    if (high - g->pedestal < 65536.0 / 200.0) {
        return fail(c,
                    "the frame is black: its brightest pixels are under 0.5 %% of full "
                    "scale");
    }
    if (high - low < 65536.0 / 400.0) {
        return fail(c, "the frame is uniform: no lens shows");
    }
    return 0;
}

/* The block of lenses that may lie on the picture, with room for a drift of 1 %. */
static int make_field(work *w, const plft_lattice *l)
{
    plft_field *f = &w->out->field;
    double s0 = HUGE_VAL, s1 = -HUGE_VAL, t0 = HUGE_VAL, t1 = -HUGE_VAL;
    int k, n;

    for (k = 0; k < 4; k++) {
        plft_vec p = {k % 2 == 0 ? 0.0 : w->grey->w, k / 2 == 0 ? 0.0 : w->grey->h};
        double s, t;
        plft_lattice_coords(l, p, &s, &t);
        s0 = fmin(s0, s);
        s1 = fmax(s1, s);
        t0 = fmin(t0, t);
        t1 = fmax(t1, t);
    }
    f->kind = l->kind;
    f->i0 = (int)floor(s0 * 1.01) - 3;
    f->j0 = (int)floor(t0 * 1.01) - 3;
    f->j0 -= f->j0 & 1;
    f->nx = (int)ceil(s1 * 1.01) + 4 - f->i0;
    f->ny = (int)ceil(t1 * 1.01) + 4 - f->j0;
    if (f->nx > PLFX_LENSES_MAX || f->ny > PLFX_LENSES_MAX) {
        return fail(w->out, "more than %d lenses on a side", PLFX_LENSES_MAX);
    }
    n = f->nx * f->ny;
    f->spot = calloc((size_t)n, sizeof *f->spot);
    for (k = 0; f->spot != NULL && k < n; k++) {
        f->spot[k].flags = PLFX_LENS_MISSING;
    }
    return f->spot != NULL ? 0 : fail(w->out, "out of memory");
}

static plft_spot *spot_of(const plft_field *f, int i, int j)
{
    return &f->spot[(j - f->j0) * f->nx + (i - f->i0)];
}

static int on_picture(const plft_grey *g, plft_vec p)
{
    return p.x >= -0.5 && p.y >= -0.5 && p.x < g->w - 0.5 && p.y < g->h - 0.5;
}

/* A block of lenses of the field, ends included. */
typedef struct block {
    int i0, i1, j0, j1;
} block;

static block block_around(const plft_field *f, int half)
{
    block b;

    b.i0 = -half > f->i0 ? -half : f->i0;
    b.j0 = -half > f->j0 ? -half : f->j0;
    b.i1 = half < f->i0 + f->nx - 1 ? half : f->i0 + f->nx - 1;
    b.j1 = half < f->j0 + f->ny - 1 ? half : f->j0 + f->ny - 1;
    return b;
}

/* Every lens of the block, or one in step^2, registered near where the model has it. */
static void measure(work *w, block b, int step, double reach)
{
    const plft_field *f = &w->out->field;
    int i, j;

    for (j = b.j0; j <= b.j1; j++) {
        for (i = b.i0; i <= b.i1; i++) {
            plft_spot *s = spot_of(f, i, j);
            plft_vec p = plft_model_at(&w->out->model, i, j);
            s->flags = PLFX_LENS_MISSING;
            if (i % step != 0 || j % step != 0 || !on_picture(w->grey, p)) {
                continue;
            }
            plft_locate(&w->bank, w->grey, p, reach, w->pixels, s);
            s->flags = s->match < MATCH_MIN || s->seen < 0.5f ||
                               hypot(s->x - p.x, s->y - p.y) > 0.98 * reach
                           ? PLFX_LENS_MISSING
                           : 0;
        }
        if (!w->quiet && step == 1 && f->ny > 64) {
            plft_progress("registering lenses", (j - b.j0) / (double)(b.j1 - b.j0 + 1));
        }
    }
}

/* Windows of the block's usable lenses (of all, the first time), evenly thinned to
 * about ENOUGH, at the places of the model. */
static void fold_block(const work *w, block b, int all, plft_fold *fold)
{
    const plft_calib *c = w->out;
    int i, j, seen = 0, usable = 0, pass;

    for (pass = 0; pass < 2; pass++) { /* 0: count; 1: fold */
        const int step = usable / ENOUGH + 1;
        for (j = b.j0; j <= b.j1; j++) {
            for (i = b.i0; i <= b.i1; i++) {
                const plft_spot *s = spot_of(&c->field, i, j);
                if (!all && s->flags != 0) {
                    continue;
                }
                if (pass == 0) {
                    usable++;
                } else if (seen++ % step == 0) {
                    plft_fold_add(fold, w->grey, plft_model_at(&c->model, i, j),
                                  all ? 0.0 : (double)s->base,
                                  all ? 1.0 : (double)s->gain);
                }
            }
        }
    }
}

/* Mean micro-image over the block; its centre of symmetry moves the model. */
static int reshape(work *w, block b, int per)
{
    plft_calib *c = w->out;
    const double radius = DISC * c->pitch + 0.5;
    plft_fold fold;
    int status;

    if (plft_fold_init(&fold, (int)ceil(radius) + 2, c->pitch > 32.0 ? 4 : 8) != 0) {
        return fail(c, "out of memory");
    }
    fold_block(w, b, c->shape.c == NULL, &fold);
    status = plft_shape_fit(&c->shape, &fold, per);
    if (status != 0) {
        plft_fold_free(&fold);
        return fail(c, "no whole micro-image lies on the picture");
    }
    c->shape.centre.x = c->shape.centre.y = 0.0;
    plft_shape_centre(&c->shape, DISC * c->pitch);
    if (hypot(c->shape.centre.x, c->shape.centre.y) > 0.5 * c->pitch) {
        c->shape.centre.x = c->shape.centre.y = 0.0;
    }
    status = plft_shape_round(&c->shape, &fold, radius);
    plft_fold_free(&fold);
    if (status != 0) {
        return fail(c, "out of memory");
    }
    c->model.cx[0] += c->shape.centre.x;
    c->model.cy[0] += c->shape.centre.y;
    plft_bank_free(&w->bank);
    free(w->pixels);
    w->pixels = NULL;
    if (plft_bank_init(&w->bank, &c->shape, radius) != 0 ||
        (w->pixels = calloc((size_t)w->bank.len,
                            PLFT_LOCATE_SCRATCH * sizeof *w->pixels)) == NULL) {
        return fail(c, "the mean micro-image has no structure to register against");
    }
    return 0;
}

static int whole(const plft_field *f, block b)
{
    return b.i0 == f->i0 && b.j0 == f->j0 && b.i1 == f->i0 + f->nx - 1 &&
           b.j1 == f->j0 + f->ny - 1;
}

/* From the first region to the whole field. */
static int grow(work *w)
{
    plft_calib *c = w->out;
    const double reach = 0.35 * c->pitch;
    block b = block_around(&c->field, FIRST);
    double half;
    int round;

    for (round = 0; round < 3; round++) {
        if (reshape(w, b, 1) != 0) {
            return -1;
        }
        measure(w, b, 1, reach);
        if (plft_model_fit(&c->model, &c->field, 1, CUT) != 0) {
            return fail(c,
                        "no lens lattice: what repeats in the frame does not hold over "
                        "nine neighbouring places");
        }
    }
    for (half = FIRST * GROW; !whole(&c->field, b); half *= GROW) {
        const int order = c->model.rms > STIFF * c->pitch ? 1 : 3;
        if (order == 1 && half < 100.0 && reshape(w, b, 1) != 0) {
            return -1;
        }
        b = block_around(&c->field, (int)half);
        measure(w, b, half > 40.0 ? 3 : 1, reach);
        if (plft_model_fit(&c->model, &c->field, order, CUT) != 0) {
            return fail(c, "no lens lattice: it is lost away from the middle");
        }
    }
    return 0;
}

/* Largest move of the block's corners between two models. */
static double change(const plft_model *p, const plft_model *q, block b)
{
    double worst = 0.0;
    int k;

    for (k = 0; k < 4; k++) {
        const int i = k % 2 == 0 ? b.i0 : b.i1, j = k / 2 == 0 ? b.j0 : b.j1;
        plft_vec u = plft_model_at(p, i, j), v = plft_model_at(q, i, j);
        worst = fmax(worst, hypot(u.x - v.x, u.y - v.y));
    }
    return worst;
}

/* Mean micro-image and model in turn, on a part of the lenses, until they agree; then
 * all lenses once. */
static int refine(work *w)
{
    plft_calib *c = w->out;
    const block all = block_around(&c->field, PLFX_LENSES_MAX);
    const int per = c->pitch < FINE ? 2 : 1;
    const int step = (int)sqrt(c->field.nx * c->field.ny / (double)PART) + 1;
    int round;

    for (round = 0; round < ROUNDS; round++) {
        const plft_model before = c->model;
        if (reshape(w, all, per) != 0) {
            return -1;
        }
        measure(w, all, step, 0.3 * c->pitch);
        if (plft_model_fit(&c->model, &c->field, 3, CUT) != 0) {
            return fail(c, "no lens lattice: too few lenses agree");
        }
        if (change(&before, &c->model, all) < 5e-4) {
            break;
        }
    }
    measure(w, all, 1, 0.3 * c->pitch);
    if (plft_model_fit(&c->model, &c->field, 3, CUT) != 0) {
        return fail(c, "no lens lattice: too few lenses agree");
    }
    if (!w->quiet && c->field.ny > 64) {
        plft_progress("registering lenses", 1.0);
    }
    return 0;
}

static int find_lattice(work *w, const plft_calib_options *o, plft_lattice *l)
{
    plft_calib *c = w->out;
    plft_period p;

    if (plft_period_find(w->grey, &p) != 0 || p.strength < 4.0 * p.rest * 0.5 ||
        p.strength < 0.02) {
        return fail(c,
                    "no lens pattern: nothing in the frame repeats in two directions");
    }
    c->strength = p.strength;
    if (plft_lattice_orient(p.v1, p.v2, o->kind, l) != 0) {
        return fail(c,
                    "no lens pattern: what repeats (%.1f and %.1f px apart) is neither "
                    "a square nor a hexagonal lattice%s",
                    hypot(p.v1.x, p.v1.y), hypot(p.v2.x, p.v2.y),
                    o->kind == PLFT_LATTICE_AUTO ? "" : " of the kind asked for");
    }
    c->pitch = plft_lattice_pitch(l);
    if (plft_phase_find(w->grey, l, &c->contrast) != 0) {
        return fail(c, "the frame is too small for its lens pitch of %.1f px",
                    c->pitch);
    }
    return 0;
}

void plft_calib_free(plft_calib *c)
{
    free(c->field.spot);
    free(c->final);
    plft_shape_free(&c->shape);
    c->field.spot = NULL;
    c->final = NULL;
}

int plft_calibrate(plft_calib *c, const plft_grey *g, const plft_calib_options *o)
{
    plft_lattice l;
    work w;
    int status = -1;

    memset(c, 0, sizeof *c);
    memset(&w, 0, sizeof w);
    w.grey = g;
    w.out = c;
    w.quiet = o->quiet;
    if (refuse_flat(c, g) == 0 && find_lattice(&w, o, &l) == 0 &&
        make_field(&w, &l) == 0) {
        plft_model_from_lattice(&c->model, &l, FIRST);
        if (grow(&w) == 0 && refine(&w) == 0) {
            status = plft_calib_finish(c, g, o, &w.bank);
        }
    }
    plft_bank_free(&w.bank);
    free(w.pixels);
    return status;
}
