/* SPDX-License-Identifier: MIT
 * Registration of one micro-image against the mean one. */
#include "calib/locate.h"

#include "calib/linalg.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LANES  8 /* independent sums: the compiler may use vectors */
#define PIXELS 4 /* rows of a window are read by so many */
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

/* 0, or -1 when the mask leaves too little. */
static int invert_gram(const plft_bank *b, const float *basis, const float *mask,
                       plft_normal *out)
{
    double *g = out->inverse;

    gram(b, basis, mask, g);
    if (!(g[0] > 0.0)) {
        return -1;
    }
    out->count = g[0];
    out->sum = g[4];
    out->squares = g[5];
    return plft_spd_invert(g, 4);
}

/* Basis and pseudo-inverse of one phase. */
static int tabulate(plft_bank *b, const plft_shape *s, int kx, int ky)
{
    const size_t at = phase_index(b, kx, ky);
    float *basis = b->basis + 4u * at * (size_t)b->len;
    float *solve = b->solve + 4u * at * (size_t)b->len;
    const double fx = (double)kx / b->phases - 0.5, fy = (double)ky / b->phases - 0.5;
    double *g = b->fit[at].inverse;
    int x, y, i, j, k;

    for (y = 0; y < b->n; y++) {
        for (x = 0; x < b->n; x++) {
            double v, gx, gy;
            k = y * b->stride + x;
            plft_shape_even(s, x - b->half - fx, y - b->half - fy, &v, &gx, &gy);
            basis[k] = 1.0f;
            basis[b->len + k] = (float)v;
            basis[2 * b->len + k] = (float)-gx;
            basis[3 * b->len + k] = (float)-gy;
        }
    }
    if (invert_gram(b, basis, b->mask, &b->fit[at]) != 0) {
        return -1;
    }
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

static void fill_mask(plft_bank *b)
{
    int x, y;

    for (y = 0; y < b->n; y++) {
        for (x = 0; x < b->n; x++) {
            double dx = x - b->half, dy = y - b->half;
            const int in = dx * dx + dy * dy <= b->radius * b->radius;
            b->mask[y * b->stride + x] = in ? 1.0f : 0.0f;
            b->count += in;
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
    b->stride = (b->n + PIXELS - 1) / PIXELS * PIXELS;
    b->len = (b->n * b->stride + LANES - 1) / LANES * LANES;
    b->phases = b->n > 64 ? 4 : 8;
    b->radius = radius;
    bins = (size_t)(b->phases + 1) * (size_t)(b->phases + 1);
    bytes = 4u * bins * (size_t)b->len;
    b->solve = calloc(bytes, sizeof *b->solve);
    b->basis = calloc(bytes, sizeof *b->basis);
    b->fit = calloc(bins, sizeof *b->fit);
    b->mask = calloc((size_t)b->len, sizeof *b->mask);
    if (b->solve == NULL || b->basis == NULL || b->fit == NULL || b->mask == NULL) {
        plft_bank_free(b);
        return -1;
    }
    fill_mask(b);
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
    free(b->fit);
    free(b->mask);
    memset(b, 0, sizeof *b);
}

/* State of one search. */
typedef struct search {
    float *px, *own, *error; /* [len] pixels minus ref; mask of its own; squares */
    const float *mask, *basis;
    double p[4];
    plft_normal fit;
    float ref;
    int cx, cy, clipped, differs;
} search;

/* Pixels of a window that lies whole on the picture, minus s->ref; the highest. */
static float read_whole(const plft_bank *b, const plft_grey *g, search *s)
{
    const uint16_t *row =
        g->px + (size_t)(s->cy - b->half) * (size_t)g->w + (size_t)(s->cx - b->half);
    float top[PIXELS] = {0}, *p = s->px;
    int x, y, l;

    for (y = 0; y < b->n; y++, row += g->w) {
        for (x = 0; x < b->stride; x += PIXELS, p += PIXELS) {
            for (l = 0; l < PIXELS; l++) {
                const float v = (float)row[x + l];
                top[l] = v > top[l] ? v : top[l];
                p[l] = v - s->ref;
            }
        }
    }
    for (l = 1; l < PIXELS; l++) {
        top[0] = top[l] > top[0] ? top[l] : top[0];
    }
    return top[0];
}

/* The same pixel by pixel: those off the picture or clipped leave the mask. */
static void read_masked(const plft_bank *b, const plft_grey *g, search *s)
{
    const int inner = b->half / 2;
    int x, y;

    for (y = 0; y < b->n; y++) {
        for (x = 0; x < b->n; x++) {
            const int k = y * b->stride + x, gx = s->cx - b->half + x,
                      gy = s->cy - b->half + y;
            const int in = gx >= 0 && gy >= 0 && gx < g->w && gy < g->h;
            const uint16_t v = in ? g->px[(size_t)gy * (size_t)g->w + (size_t)gx] : 0;
            const int bad = !in || v == PLFT_SATURATED;
            s->own[k] = bad ? 0.0f : b->mask[k];
            s->px[k] = bad ? 0.0f : (float)v - s->ref;
            s->differs |= bad;
            s->clipped += in && v == PLFT_SATURATED && abs(x - b->half) <= inner &&
                          abs(y - b->half) <= inner;
        }
    }
}

/* Window around (cx,cy), unless it is there already. */
static void read_window(const plft_bank *b, const plft_grey *g, int cx, int cy,
                        search *s)
{
    const int x0 = cx - b->half, y0 = cy - b->half;

    if (s->mask != NULL && cx == s->cx && cy == s->cy) {
        return;
    }
    s->cx = cx;
    s->cy = cy;
    s->ref = g->px[(size_t)cy * (size_t)g->w + (size_t)cx];
    s->clipped = s->differs = 0;
    if (x0 < 0 || y0 < 0 || x0 + b->stride > g->w || y0 + b->n > g->h ||
        read_whole(b, g, s) >= (float)PLFT_SATURATED) {
        memset(s->px, 0, (size_t)b->len * sizeof *s->px);
        memset(s->own, 0, (size_t)b->len * sizeof *s->own);
        read_masked(b, g, s);
    }
    s->mask = s->differs ? s->own : b->mask;
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

/* Squared residuals under the mask into s->error. */
static void residuals(const plft_bank *b, const search *s)
{
    const float *restrict v = s->basis + b->len, *restrict vx = v + b->len,
                          *restrict vy = vx + b->len, *restrict px = s->px,
                          *restrict mask = s->mask;
    const float p0 = (float)s->p[0], p1 = (float)s->p[1], p2 = (float)s->p[2],
                p3 = (float)s->p[3];
    float *restrict error = s->error;
    int k;

    for (k = 0; k < b->len; k++) {
        const float r = px[k] - p0 - p1 * v[k] - p2 * vx[k] - p3 * vy[k];
        error[k] = r * r * mask[k];
    }
}

/* Their variance. */
static double variance(const plft_bank *b, const search *s)
{
    float lane[LANES] = {0};
    double sum = 0.0;
    int k, l;

    residuals(b, s);
    for (k = 0; k < b->len; k += LANES) {
        for (l = 0; l < LANES; l++) {
            lane[l] += s->error[k + l];
        }
    }
    for (l = 0; l < LANES; l++) {
        sum += lane[l];
    }
    return sum / fmax(s->fit.count - 4.0, 1.0);
}

/* Solution over a mask of the window's own.  0, or -1. */
static int solve_masked(const plft_bank *b, search *s)
{
    double rhs[4];
    int i, k;

    if (invert_gram(b, s->basis, s->mask, &s->fit) != 0 || s->fit.count < 12.0) {
        return -1;
    }
    for (i = 0; i < 4; i++) {
        rhs[i] = 0.0;
        for (k = 0; k < b->len; k++) {
            rhs[i] += (double)(s->basis[i * b->len + k] * s->px[k] * s->mask[k]);
        }
    }
    plft_mat_vec(s->fit.inverse, rhs, 4, s->p);
    return 0;
}

/* Take pixel k out of the solution: Sherman and Morrison's update of the inverse P and
 * of p = P rhs, with basis f: P += Pf f'P/(1 - f'Pf), p -= Pf (px - f'p)/(1 - f'Pf).
 * 0, or -1 when the rest would not hold the four unknowns. */
static int take_out(const plft_bank *b, search *s, int k)
{
    double *inverse = s->fit.inverse, f[4], pf[4], left = 1.0, e = s->px[k];
    int i, j;

    for (i = 0; i < 4; i++) {
        f[i] = s->basis[i * b->len + k];
    }
    plft_mat_vec(inverse, f, 4, pf);
    for (i = 0; i < 4; i++) {
        left -= f[i] * pf[i];
        e -= f[i] * s->p[i];
    }
    if (!(left > 1e-3)) {
        return -1;
    }
    for (i = 0; i < 4; i++) {
        s->p[i] -= pf[i] * e / left;
        for (j = 0; j < 4; j++) {
            inverse[4 * i + j] += pf[i] * pf[j] / left;
        }
    }
    s->fit.count -= 1.0;
    s->fit.sum -= f[1];
    s->fit.squares -= f[1] * f[1];
    s->own[k] = 0.0f;
    return 0;
}

static int count_over(const float *error, int n, float limit)
{
    int k, over = 0;

    for (k = 0; k < n; k++) {
        over += error[k] > limit;
    }
    return over;
}

/* Take out the pixels whose squared residual is over `limit` and over what shot noise
 * and the shape's error explain, GRAIN of the local height; how many. */
static int drop_outliers(const plft_bank *b, search *s, float limit)
{
    const float grain = (float)GRAIN * (float)s->p[1];
    int k, n = 0, left = count_over(s->error, b->len, limit);

    for (k = 0; left > 0; k++) {
        float height;
        if (s->error[k] <= limit) {
            continue;
        }
        left--;
        height = grain * s->basis[b->len + k];
        if (s->error[k] <= limit + height * height) {
            continue;
        }
        if (s->mask != s->own) {
            memcpy(s->own, s->mask, (size_t)b->len * sizeof *s->own);
            s->mask = s->own;
        }
        if (take_out(b, s, k) != 0) {
            break;
        }
        n++;
    }
    return n;
}

/* Refine s->p without outliers; returns the residual variance. */
static double robust(const plft_bank *b, search *s)
{
    double s2 = variance(b, s);
    int round;

    for (round = 0; round < 4; round++) {
        if (drop_outliers(b, s, (float)(CUT * CUT * s2)) == 0) {
            break;
        }
        s2 = variance(b, s);
    }
    return s2;
}

static void describe(const plft_bank *b, const search *s, double s2, plft_spot *spot)
{
    const double gain = s->p[1], n = s->fit.count;
    const double spread = s->fit.squares - s->fit.sum * s->fit.sum / n;
    const double signal = gain * gain * spread;
    const double var = fmax(s->fit.inverse[10], s->fit.inverse[15]);

    spot->gain = (float)gain;
    spot->base = (float)s->p[0] + s->ref;
    spot->rms = (float)sqrt(s2);
    spot->match = gain > 0.0 ? (float)sqrt(signal / (signal + s2 * n + 1e-9)) : 0.0f;
    spot->sigma = (float)(sqrt(s2 * var) / fmax(fabs(gain), 1e-9));
    spot->seen = (float)(n / b->count);
    spot->clipped = (uint8_t)(s->clipped < 255 ? s->clipped : 255);
}

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
    read_window(b, g, cx, cy, s);
    if (s->differs) {
        return solve_masked(b, s);
    }
    four_sums(b, b->solve + 4u * at * (size_t)b->len, s->px, s->p);
    s->fit = b->fit[at];
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
                 float *scratch, plft_spot *spot)
{
    plft_vec c = guess, phase;
    search s;
    int round;

    memset(spot, 0, sizeof *spot);
    memset(&s, 0, sizeof s);
    s.px = scratch;
    s.own = scratch + b->len;
    s.error = scratch + 2 * b->len;
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
    describe(b, &s, robust(b, &s), spot);
    if (s.p[1] > 1e-6) {
        c = phase;
        move(&s, guess, reach, &c);
        spot->x = c.x;
        spot->y = c.y;
    }
}
