/* SPDX-License-Identifier: MIT
 * Registration of one micro-image against the mean one. */
#include "calib/locate.h"

#include "calib/linalg.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LANES  8 /* independent sums: the compiler may use vectors */
#define ROUNDS 6
#define CUT    4.0  /* times the residual: a pixel that is not of this lens */
#define GRAIN  0.15 /* of the local height: what a pixel of this lens may be off */

static size_t phase_index(const plft_bank *b, int kx, int ky)
{
    return (size_t)(ky * (b->phases + 1) + kx);
}

/* Sums over the disc of products of the four basis functions. */
static void gram(const plft_bank *b, const float *basis, const float *mask,
                 double g[16])
{
    int i, j, k;

    for (i = 0; i < 4; i++) {
        for (j = 0; j <= i; j++) {
            const float *p = basis + i * b->len, *q = basis + j * b->len;
            float lane[LANES] = {0};
            double s = 0.0;
            int l;
            for (k = 0; k < b->len; k += LANES) {
                for (l = 0; l < LANES; l++) {
                    lane[l] += p[k + l] * q[k + l] * mask[k + l];
                }
            }
            for (l = 0; l < LANES; l++) {
                s += lane[l];
            }
            g[4 * i + j] = g[4 * j + i] = s;
        }
    }
}

/* Basis and pseudo-inverse of one phase. */
static int tabulate(plft_bank *b, const plft_shape *s, int kx, int ky)
{
    const size_t at = phase_index(b, kx, ky);
    float *basis = b->basis + 4u * at * (size_t)b->len;
    float *solve = b->solve + 4u * at * (size_t)b->len;
    const double fx = (double)kx / b->phases - 0.5, fy = (double)ky / b->phases - 0.5;
    double g[16];
    int x, y, i, j, k;

    for (y = 0; y < b->n; y++) {
        for (x = 0; x < b->n; x++) {
            double v, gx, gy;
            k = y * b->n + x;
            plft_shape_even(s, x - b->half - fx, y - b->half - fy, &v, &gx, &gy);
            basis[k] = 1.0f;
            basis[b->len + k] = (float)v;
            basis[2 * b->len + k] = (float)-gx;
            basis[3 * b->len + k] = (float)-gy;
        }
    }
    gram(b, basis, b->mask, g);
    b->cov[4u * at + 3u] = g[5] - g[4] * g[4] / g[0];
    if (plft_spd_invert(g, 4) != 0) {
        return -1;
    }
    b->cov[4u * at] = g[0];
    b->cov[4u * at + 1u] = g[10];
    b->cov[4u * at + 2u] = g[15];
    for (i = 0; i < 4; i++) {
        for (k = 0; k < b->len; k++) {
            double v = 0.0;
            for (j = 0; j < 4; j++) {
                v += g[4 * i + j] * (double)basis[j * b->len + k];
            }
            solve[i * b->len + k] = (float)v * b->mask[k];
        }
    }
    return 0;
}

static double count(const plft_bank *b, const float *mask)
{
    double s = 0.0;
    int k;

    for (k = 0; k < b->len; k++) {
        s += mask[k];
    }
    return s;
}

static void fill_mask(plft_bank *b)
{
    int x, y;

    for (y = 0; y < b->n; y++) {
        for (x = 0; x < b->n; x++) {
            double dx = x - b->half, dy = y - b->half;
            b->mask[y * b->n + x] =
                dx * dx + dy * dy <= b->radius * b->radius ? 1.0f : 0.0f;
        }
    }
}

static double contrast(const plft_shape *s, double radius)
{
    double low = HUGE_VAL, x, y;

    for (y = -radius; y <= radius; y += 0.5) {
        for (x = -radius; x <= radius; x += 0.5) {
            if (x * x + y * y <= radius * radius) {
                low = fmin(low, plft_shape_at(s, s->centre.x + x, s->centre.y + y));
            }
        }
    }
    return plft_shape_at(s, s->centre.x, s->centre.y) - low;
}

int plft_bank_init(plft_bank *b, const plft_shape *s, double radius)
{
    size_t bins, bytes;
    int kx, ky;

    memset(b, 0, sizeof *b);
    b->half = (int)ceil(radius);
    b->n = 2 * b->half + 1;
    b->len = (b->n * b->n + LANES - 1) / LANES * LANES;
    b->phases = b->n > 64 ? 4 : 8;
    b->radius = radius;
    bins = (size_t)(b->phases + 1) * (size_t)(b->phases + 1);
    bytes = 4u * bins * (size_t)b->len;
    b->solve = calloc(bytes, sizeof *b->solve);
    b->basis = calloc(bytes, sizeof *b->basis);
    b->cov = calloc(4u * bins, sizeof *b->cov);
    b->mask = calloc((size_t)b->len, sizeof *b->mask);
    if (b->solve == NULL || b->basis == NULL || b->cov == NULL || b->mask == NULL) {
        plft_bank_free(b);
        return -1;
    }
    fill_mask(b);
    b->count = count(b, b->mask);
    b->peak = contrast(s, radius);
    for (ky = 0; ky <= b->phases; ky++) {
        for (kx = 0; kx <= b->phases; kx++) {
            if (tabulate(b, s, kx, ky) != 0) {
                plft_bank_free(b);
                return -1;
            }
        }
    }
    return 0;
}

void plft_bank_free(plft_bank *b)
{
    free(b->solve);
    free(b->basis);
    free(b->cov);
    free(b->mask);
    memset(b, 0, sizeof *b);
}

/* Pixels of the window around (cx,cy) minus `ref`; their mask (the bank's without what
 * is off the picture or clipped).  Returns 1 when the mask differs from the bank's. */
static int read_window(const plft_bank *b, const plft_grey *g, int cx, int cy,
                       float *px, float *mask, float *ref, int *clipped)
{
    const int whole =
        cx >= b->half && cy >= b->half && cx + b->half < g->w && cy + b->half < g->h;
    const int inner = b->half / 2;
    uint16_t top = 0;
    int x, y, differs = !whole;

    *ref = g->px[(size_t)cy * (size_t)g->w + (size_t)cx];
    *clipped = 0;
    for (y = 0; whole && y < b->n; y++) {
        const uint16_t *row =
            g->px + (size_t)(cy - b->half + y) * (size_t)g->w + cx - b->half;
        float *p = px + y * b->n;
        for (x = 0; x < b->n; x++) {
            top = row[x] > top ? row[x] : top;
            p[x] = (float)row[x] - *ref;
        }
    }
    if (whole && top < PLFT_SATURATED) {
        return 0;
    }
    for (y = 0; y < b->n; y++) {
        for (x = 0; x < b->n; x++) {
            const int k = y * b->n + x, gx = cx - b->half + x, gy = cy - b->half + y;
            const int in = gx >= 0 && gy >= 0 && gx < g->w && gy < g->h;
            const uint16_t v = in ? g->px[(size_t)gy * (size_t)g->w + (size_t)gx] : 0;
            const int bad = !in || v == PLFT_SATURATED;
            mask[k] = bad ? 0.0f : b->mask[k];
            px[k] = bad ? 0.0f : (float)v - *ref;
            differs |= bad;
            *clipped += in && v == PLFT_SATURATED && abs(x - b->half) <= inner &&
                        abs(y - b->half) <= inner;
        }
    }
    return differs;
}

/* out[i] = sum over the window of rows[i] * px, i = 0..3. */
static void four_sums(const plft_bank *b, const float *rows, const float *px,
                      double out[4])
{
    float lane[4][LANES] = {{0}};
    int i, k, l;

    for (k = 0; k < b->len; k += LANES) {
        for (i = 0; i < 4; i++) {
            for (l = 0; l < LANES; l++) {
                lane[i][l] += rows[i * b->len + k + l] * px[k + l];
            }
        }
    }
    for (i = 0; i < 4; i++) {
        out[i] = 0.0;
        for (l = 0; l < LANES; l++) {
            out[i] += lane[i][l];
        }
    }
}

/* Squared residual over the mask; *worst is the largest single square. */
static double residual(const plft_bank *b, const float *basis, const float *px,
                       const float *mask, const double p[4], double *worst)
{
    const float p0 = (float)p[0], p1 = (float)p[1], p2 = (float)p[2], p3 = (float)p[3];
    float sum[LANES] = {0}, top[LANES] = {0};
    double s = 0.0;
    int k, l;

    for (k = 0; k < b->len; k += LANES) {
        for (l = 0; l < LANES; l++) {
            const int q = k + l;
            float r = px[q] - p0 - p1 * basis[b->len + q] - p2 * basis[2 * b->len + q] -
                      p3 * basis[3 * b->len + q];
            r = r * r * mask[q];
            sum[l] += r;
            top[l] = r > top[l] ? r : top[l];
        }
    }
    *worst = 0.0;
    for (l = 0; l < LANES; l++) {
        s += sum[l];
        *worst = top[l] > *worst ? top[l] : *worst;
    }
    return s;
}

/* Solve with a mask of its own; cov as in the bank.  0, or -1. */
static int solve_masked(const plft_bank *b, const float *basis, const float *px,
                        const float *mask, double p[4], double cov[4])
{
    double g[16], rhs[4];
    int i, k;

    gram(b, basis, mask, g);
    if (!(g[0] > 0.0)) {
        return -1;
    }
    cov[3] = g[5] - g[4] * g[4] / g[0];
    for (i = 0; i < 4; i++) {
        rhs[i] = 0.0;
        for (k = 0; k < b->len; k++) {
            rhs[i] += (double)(basis[i * b->len + k] * px[k] * mask[k]);
        }
    }
    if (plft_spd_invert(g, 4) != 0) {
        return -1;
    }
    plft_mat_vec(g, rhs, 4, p);
    cov[0] = g[0];
    cov[1] = g[10];
    cov[2] = g[15];
    return 0;
}

/* Drop from the mask the pixels whose squared residual is over `limit` and over what
 * shot noise and the shape's error explain, GRAIN of the local height; how many. */
static int drop_outliers(const plft_bank *b, const float *basis, const float *px,
                         float *mask, const double p[4], double limit)
{
    int k, n = 0;

    for (k = 0; k < b->len; k++) {
        double height = p[1] * basis[b->len + k];
        double r = px[k] - p[0] - height - p[2] * basis[2 * b->len + k] -
                   p[3] * basis[3 * b->len + k];
        double grain = GRAIN * height;
        if (mask[k] > 0.0f && r * r > limit + grain * grain) {
            mask[k] = 0.0f;
            n++;
        }
    }
    return n;
}

/* Refine p without outliers; returns the residual variance, *n the pixels kept. */
static double robust(const plft_bank *b, const float *basis, const float *px,
                     float *mask, double p[4], double cov[4], double *n)
{
    double worst, s2 = residual(b, basis, px, mask, p, &worst) / fmax(*n - 4.0, 1.0);
    int round;

    for (round = 0; round < 4 && worst > CUT * CUT * s2; round++) {
        if (drop_outliers(b, basis, px, mask, p, CUT * CUT * s2) == 0 ||
            solve_masked(b, basis, px, mask, p, cov) != 0) {
            break;
        }
        *n = count(b, mask);
        s2 = residual(b, basis, px, mask, p, &worst) / fmax(*n - 4.0, 1.0);
    }
    return s2;
}

static void describe(const plft_bank *b, const double p[4], const double cov[4],
                     double s2, double n, float ref, plft_spot *spot)
{
    const double signal = p[1] * p[1] * cov[3];

    spot->gain = (float)p[1];
    spot->base = (float)p[0] + ref;
    spot->rms = (float)sqrt(s2);
    spot->match = p[1] > 0.0 ? (float)sqrt(signal / (signal + s2 * n + 1e-9)) : 0.0f;
    spot->sigma = (float)(sqrt(s2 * fmax(cov[1], cov[2])) / fmax(fabs(p[1]), 1e-9));
    spot->seen = (float)(n / b->count);
}

/* State of one search. */
typedef struct search {
    float *px, *mask, ref;
    const float *basis;
    double p[4], cov[4], n;
    int clipped;
} search;

/* Nearest tabulated phase of a coordinate; *whole its pixel. */
static int split(const plft_bank *b, double c, int *whole)
{
    *whole = (int)floor(c + 0.5);
    return (int)floor((c - *whole + 0.5) * b->phases + 0.5);
}

/* Linear solution about the phase nearest to *c, which becomes that phase.  0, or
 * -1. */
static int linear_step(const plft_bank *b, const plft_grey *g, plft_vec *c, search *s)
{
    int cx, cy, kx = split(b, c->x, &cx), ky = split(b, c->y, &cy);
    const size_t at = phase_index(b, kx, ky);

    if (cx < 0 || cy < 0 || cx >= g->w || cy >= g->h) {
        return -1;
    }
    c->x = cx + (double)kx / b->phases - 0.5;
    c->y = cy + (double)ky / b->phases - 0.5;
    s->basis = b->basis + 4u * at * (size_t)b->len;
    if (read_window(b, g, cx, cy, s->px, s->mask, &s->ref, &s->clipped)) {
        s->n = count(b, s->mask);
        return s->n < 12.0 ? -1
                           : solve_masked(b, s->basis, s->px, s->mask, s->p, s->cov);
    }
    four_sums(b, b->solve + 4u * at * (size_t)b->len, s->px, s->p);
    memcpy(s->cov, b->cov + 4u * at, sizeof s->cov);
    memcpy(s->mask, b->mask, (size_t)b->len * sizeof *s->mask);
    s->n = b->count;
    return 0;
}

/* *c moved by the solved step, at most a pixel, and held within `reach` of the guess;
 * returns the step's larger component. */
static double move(const search *s, plft_vec guess, double reach, plft_vec *c)
{
    const double dx = s->p[2] / s->p[1], dy = s->p[3] / s->p[1];
    double d;

    c->x += fmax(-1.0, fmin(1.0, dx));
    c->y += fmax(-1.0, fmin(1.0, dy));
    d = hypot(c->x - guess.x, c->y - guess.y);
    if (d > reach) {
        c->x = guess.x + (c->x - guess.x) * reach / d;
        c->y = guess.y + (c->y - guess.y) * reach / d;
    }
    return fmax(fabs(dx), fabs(dy));
}

void plft_locate(const plft_bank *b, const plft_grey *g, plft_vec guess, double reach,
                 float *pixels, plft_spot *spot)
{
    plft_vec c = guess, phase;
    search s;
    double s2;
    int round;

    memset(spot, 0, sizeof *spot);
    memset(&s, 0, sizeof s);
    memset(pixels, 0, 2u * (size_t)b->len * sizeof *pixels);
    s.px = pixels;
    s.mask = pixels + b->len;
    spot->rms = HUGE_VALF;
    spot->x = guess.x;
    spot->y = guess.y;
    for (round = 0; round < ROUNDS; round++) { /* to the nearest phase */
        phase = c;
        if (linear_step(b, g, &phase, &s) != 0) {
            return;
        }
        c = phase;
        if (!(s.p[1] > 1e-6) || move(&s, guess, reach, &c) * b->phases <= 0.75) {
            break;
        }
    }
    s2 = robust(b, s.basis, s.px, s.mask, s.p, s.cov, &s.n);
    describe(b, s.p, s.cov, s2, s.n, s.ref, spot);
    spot->clipped = (uint8_t)(s.clipped < 255 ? s.clipped : 255);
    if (s.p[1] > 1e-6) {
        c = phase;
        move(&s, guess, reach, &c);
        spot->x = c.x;
        spot->y = c.y;
    }
}
