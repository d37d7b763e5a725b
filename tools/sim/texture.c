/* SPDX-License-Identifier: MIT
 * Procedural textures as summed-area tables. */
#include "sim/texture.h"

#include <math.h>
#include <stdlib.h>

#include "sim/rng.h"

#define SOFT_MAX 8 /* texels */

static double clamp(double v, double lo, double hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

static double fade(double t)
{
    return t * t * (3.0 - 2.0 * t);
}

/* Lattice value of octave o, -1 .. 1, periodic in m. */
static double lattice_value(uint64_t seed, int o, int m, int x, int y)
{
    uint64_t at = (uint64_t)(y % m) * (uint64_t)m + (uint64_t)(x % m);

    return 2.0 * plft_uniform(plft_key(seed, 200u + (uint64_t)o, at)) - 1.0;
}

/* One octave with m cells on a side of a tile of n texels. */
static double octave(uint64_t seed, int o, int m, int n, int x, int y)
{
    double fx = (x + 0.5) * m / n;
    double fy = (y + 0.5) * m / n;
    int ix = (int)fx;
    int iy = (int)fy;
    double tx = fade(fx - ix);
    double ty = fade(fy - iy);
    double a = lattice_value(seed, o, m, ix, iy);
    double b = lattice_value(seed, o, m, ix + 1, iy);
    double c = lattice_value(seed, o, m, ix, iy + 1);
    double d = lattice_value(seed, o, m, ix + 1, iy + 1);

    return (a * (1.0 - tx) + b * tx) * (1.0 - ty) + (c * (1.0 - tx) + d * tx) * ty;
}

static int cells_of(const plft_texture *t, double cell_mm)
{
    int m = (int)(t->n * t->texel / cell_mm + 0.5);

    return m < 1 ? 1 : m > t->n ? t->n : m;
}

/* Bring `v` to the mean and rms of the description. */
static void normalise(double *v, size_t count, const plft_texture_desc *desc)
{
    double sum = 0.0;
    double square = 0.0;
    double mean, scale;
    size_t k;

    for (k = 0; k < count; k++) {
        sum += v[k];
        square += v[k] * v[k];
    }
    mean = sum / (double)count;
    scale = desc->contrast / sqrt(square / (double)count - mean * mean + 1e-12);
    for (k = 0; k < count; k++) {
        v[k] = clamp(desc->mean + (v[k] - mean) * scale, 0.02, 1.0);
    }
}

static void draw_noise(double *v, const plft_texture *t, const plft_texture_desc *desc)
{
    size_t count = (size_t)t->n * (size_t)t->n;
    double amplitude = 1.0;
    double cell = desc->cell_mm;
    int o, x, y;

    for (o = 0; o < desc->octaves; o++) {
        int m = cells_of(t, cell);
        for (y = 0; y < t->n; y++) {
            for (x = 0; x < t->n; x++) {
                v[(size_t)y * (size_t)t->n + (size_t)x] +=
                    amplitude * octave(desc->seed, o, m, t->n, x, y);
            }
        }
        amplitude *= desc->persistence;
        cell *= 0.5;
    }
    normalise(v, count, desc);
}

/* A round blob with a soft rim about (cx,cy), radius r, texels, wrapped. */
static void draw_blob(double *cover, int n, double cx, double cy, double r)
{
    int reach = (int)r + 2;
    int x0 = (int)cx;
    int y0 = (int)cy;
    int x, y;

    for (y = y0 - reach; y <= y0 + reach; y++) {
        for (x = x0 - reach; x <= x0 + reach; x++) {
            double dx = x + 0.5 - cx;
            double dy = y + 0.5 - cy;
            double ink = clamp(r + 0.5 - sqrt(dx * dx + dy * dy), 0.0, 1.0);
            double *at = cover + (size_t)((y + n) % n) * (size_t)n + (x + n) % n;
            *at = ink > *at ? ink : *at;
        }
    }
}

/* One blob a cell, jittered, radius 0.28 .. 0.46 cell: half of the surface inked. */
static void draw_speckle(double *v, const plft_texture *t,
                         const plft_texture_desc *desc)
{
    size_t count = (size_t)t->n * (size_t)t->n;
    int m = cells_of(t, desc->cell_mm);
    double cell = (double)t->n / m;
    size_t k;
    int i;

    for (i = 0; i < m * m; i++) {
        uint64_t at = (uint64_t)i;
        double cx = (i % m + plft_uniform(plft_key(desc->seed, 301, at))) * cell;
        double cy = (i / m + plft_uniform(plft_key(desc->seed, 302, at))) * cell;
        double r = (0.28 + 0.18 * plft_uniform(plft_key(desc->seed, 303, at))) * cell;
        draw_blob(v, t->n, cx, cy, r);
    }
    for (k = 0; k < count; k++) {
        v[k] = clamp(desc->mean + desc->contrast * (1.0 - 2.0 * v[k]), 0.02, 1.0);
    }
}

static void draw_checker(double *v, const plft_texture *t,
                         const plft_texture_desc *desc)
{
    int x, y;

    for (y = 0; y < t->n; y++) {
        for (x = 0; x < t->n; x++) {
            int cx = (int)((x + 0.5) * t->texel / desc->cell_mm);
            int cy = (int)((y + 0.5) * t->texel / desc->cell_mm);
            double swing = ((cx + cy) & 1) ? -desc->contrast : desc->contrast;
            v[(size_t)y * (size_t)t->n + (size_t)x] =
                clamp(desc->mean + swing, 0.02, 1.0);
        }
    }
}

/* Pips of one half: a 3x3 grid, bit 3*row + column. */
static unsigned pip_mask(int pips)
{
    static const unsigned mask[7] = {0u,     0x010u, 0x044u, 0x054u,
                                     0x145u, 0x155u, 0x16Du};

    return mask[pips < 0 ? 0 : pips > 6 ? 6 : pips];
}

/* Depth of a drilled dimple of radius r about (cx,cy): 1 in the middle, 0 at the rim,
 * without an edge. */
static void draw_dimple(double *ink, int n, double cx, double cy, double r)
{
    int x, y;

    for (y = (int)(cy - r); y <= (int)(cy + r); y++) {
        for (x = (int)(cx - r); x <= (int)(cx + r); x++) {
            double dx = (x + 0.5 - cx) / r;
            double dy = (y + 0.5 - cy) / r;
            double deep = 1.0 - dx * dx - dy * dy;
            if (deep > 0.0 && x >= 0 && y >= 0 && x < n && y < n) {
                ink[(size_t)y * (size_t)n + (size_t)x] += fade(deep);
            }
        }
    }
}

static void draw_half(double *ink, const plft_texture *t, const plft_texture_desc *desc,
                      int half)
{
    double w = desc->face_mm[0] / t->texel;
    double h = 0.5 * desc->face_mm[1] / t->texel;
    unsigned mask = pip_mask(desc->pips[half]);
    int k;

    for (k = 0; k < 9; k++) {
        if (mask >> k & 1u) {
            draw_dimple(ink, t->n, w * (0.22 + 0.28 * (k % 3)),
                        h * (half + 0.22 + 0.28 * (k / 3)), 0.135 * w);
        }
    }
}

/* Dimples and the groove between the halves take up to 85 % of the light. */
static int draw_domino(double *v, const plft_texture *t, const plft_texture_desc *desc)
{
    size_t count = (size_t)t->n * (size_t)t->n;
    double *ink = calloc(count, sizeof *ink);
    double middle = 0.5 * desc->face_mm[1] / t->texel;
    double half = 0.035 * desc->face_mm[1] / t->texel;
    size_t k;

    if (!ink) {
        return -1;
    }
    draw_noise(v, t, desc);
    draw_half(ink, t, desc, 0);
    draw_half(ink, t, desc, 1);
    for (k = 0; k < count; k++) {
        double y = ((double)(k / (size_t)t->n) + 0.5 - middle) / half;
        double groove = y * y < 1.0 ? fade(1.0 - y * y) : 0.0;
        v[k] *= 1.0 - 0.85 * clamp(ink[k] + groove, 0.0, 1.0);
    }
    free(ink);
    return 0;
}

static int draw(double *v, const plft_texture *t, const plft_texture_desc *desc)
{
    switch (desc->pattern) {
    case PLFT_PATTERN_NOISE:
        draw_noise(v, t, desc);
        return 0;
    case PLFT_PATTERN_SPECKLE:
        draw_speckle(v, t, desc);
        return 0;
    case PLFT_PATTERN_CHECKER:
        draw_checker(v, t, desc);
        return 0;
    case PLFT_PATTERN_DOMINO:
        return draw_domino(v, t, desc);
    default:
        return -1;
    }
}

/* A line of the periodic tile convolved with taps k[0 .. r], `step` apart. */
static void soften_line(double *v, int n, size_t step, const double *k, int r,
                        double *copy)
{
    int i, d;

    for (i = 0; i < n; i++) {
        copy[i] = v[(size_t)i * step];
    }
    for (i = 0; i < n; i++) {
        double sum = k[0] * copy[i];
        for (d = 1; d <= r; d++) {
            sum += k[d] * (copy[(i + d) % n] + copy[(i - d + n) % n]);
        }
        v[(size_t)i * step] = sum;
    }
}

static int soften(double *v, int n, double sigma)
{
    double *copy = malloc((size_t)n * sizeof *copy);
    double k[3 * SOFT_MAX + 1];
    double sum = 1.0;
    int r, i;

    if (!copy) {
        return -1;
    }
    sigma = clamp(sigma, 0.1, SOFT_MAX);
    r = (int)(3.0 * sigma);
    r = r < n / 2 ? r : n / 2 - 1;
    k[0] = 1.0;
    for (i = 1; i <= r; i++) {
        k[i] = exp(-0.5 * i * i / (sigma * sigma));
        sum += 2.0 * k[i];
    }
    for (i = 0; i <= r; i++) {
        k[i] /= sum;
    }
    for (i = 0; i < n; i++) {
        soften_line(v + (size_t)i * (size_t)n, n, 1, k, r, copy);
    }
    for (i = 0; i < n; i++) {
        soften_line(v + i, n, (size_t)n, k, r, copy);
    }
    free(copy);
    return 0;
}

/* sum[y][x]: texels above y and left of x, the tile repeated into the pad. */
static void integrate(plft_texture *t, const double *v)
{
    int x, y;

    for (y = 1; y < t->stride; y++) {
        const double *row = v + (size_t)((y - 1) % t->n) * (size_t)t->n;
        const double *up = t->sum + (size_t)(y - 1) * (size_t)t->stride;
        double *out = t->sum + (size_t)y * (size_t)t->stride;
        double run = 0.0;
        for (x = 1; x < t->stride; x++) {
            run += row[(x - 1) % t->n];
            out[x] = up[x] + run;
        }
    }
}

int plft_texture_make(plft_texture *t, const plft_texture_desc *desc, double texel_mm,
                      int n)
{
    double *v;
    int status;

    t->n = n;
    t->texel = texel_mm;
    t->mean = desc->mean;
    t->stride = n + PLFT_TEXTURE_PAD + 1;
    t->sum = NULL;
    if (desc->pattern == PLFT_PATTERN_NONE) {
        return 0;
    }
    v = calloc((size_t)n * (size_t)n, sizeof *v);
    t->sum = calloc((size_t)t->stride * (size_t)t->stride, sizeof *t->sum);
    status = v && t->sum ? draw(v, t, desc) : -1;
    if (status == 0 && desc->soft_mm > 0.0) {
        status = soften(v, n, desc->soft_mm / texel_mm);
    }
    if (status == 0) {
        integrate(t, v);
    } else {
        plft_texture_free(t);
    }
    free(v);
    return status;
}

void plft_texture_free(plft_texture *t)
{
    free(t->sum);
    t->sum = NULL;
}

/* Integral of the tile from its corner to (x,y) texels, 0 <= x, y < stride - 1:
 * linear between table entries, as texels are constant. */
static double integral(const plft_texture *t, double x, double y)
{
    int ix = (int)x;
    int iy = (int)y;
    double fx = x - ix;
    double fy = y - iy;
    const double *p = t->sum + (size_t)iy * (size_t)t->stride + ix;
    const double *q = p + t->stride;

    return (p[0] * (1.0 - fx) + p[1] * fx) * (1.0 - fy) +
           (q[0] * (1.0 - fx) + q[1] * fx) * fy;
}

double plft_texture_box(const plft_texture *t, double x, double y, double w, double h)
{
    double bw, bh, x0, y0, x1, y1;

    if (!t->sum) {
        return t->mean;
    }
    bw = clamp(w / t->texel, 0.0625, PLFT_TEXTURE_PAD - 2.0);
    bh = clamp(h / t->texel, 0.0625, PLFT_TEXTURE_PAD - 2.0);
    x0 = x / t->texel - 0.5 * bw;
    y0 = y / t->texel - 0.5 * bh;
    x0 -= floor(x0 / t->n) * t->n;
    y0 -= floor(y0 / t->n) * t->n;
    x1 = x0 + bw;
    y1 = y0 + bh;
    return (integral(t, x1, y1) - integral(t, x0, y1) - integral(t, x1, y0) +
            integral(t, x0, y0)) /
           (bw * bh);
}
