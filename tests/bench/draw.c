/* SPDX-License-Identifier: MIT
 * Frames from formulas. */
#include "draw.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MARGIN 24 /* pixels around the outermost centres */
#define SUB    6  /* samples of a pixel on an axis */
#define PI     3.14159265358979323846

static uint64_t state;

static double uniform(void) /* xorshift64*, 0 .. 1 */
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (double)((state * 2685821657736338717u) >> 11) / 9007199254740992.0;
}

static double normal(void)
{
    double u = uniform(), v = uniform();
    return sqrt(-2.0 * log(u + 1e-300)) * cos(2.0 * PI * v);
}

static double shape(const draw_spec *s, double r)
{
    const double rim = 0.46 * s->pitch;

    if (s->spot == DRAW_DOTS) {
        return exp(-0.5 * r * r / (s->sigma * s->sigma));
    }
    if (s->spot == DRAW_SOFT) {
        double c = r < 0.5 * s->pitch ? cos(PI * r / s->pitch) : 0.0;
        return c * c;
    }
    return r < rim ? 1.0 - 0.25 * (r / rim) * (r / rim) : 0.0;
}

static double pixel(const draw_spec *s, double dx, double dy)
{
    double sum = 0.0;
    int i, j;

    if (s->spot == DRAW_DOTS) {
        return shape(s, hypot(dx, dy));
    }
    for (j = 0; j < SUB; j++) {
        for (i = 0; i < SUB; i++) {
            sum +=
                shape(s, hypot(dx + (i + 0.5) / SUB - 0.5, dy + (j + 0.5) / SUB - 0.5));
        }
    }
    return sum / (SUB * SUB);
}

/* True centres, and the frame's size from them. */
static void place(draw_frame *f, const draw_spec *s)
{
    const double a = s->rotation * PI / 180.0, c = cos(a) * s->pitch,
                 d = sin(a) * s->pitch;
    const double row = s->hex ? sqrt(0.75) : 1.0;
    double left = HUGE_VAL, top = HUGE_VAL, right = 0.0, bottom = 0.0;
    int k;

    for (k = 0; k < f->lenses; k++) {
        const int i = k % s->nx, j = k / s->nx;
        const double u = i + (s->hex && j % 2 != 0 ? 0.5 : 0.0), v = j * row;
        f->xy[2 * k] = s->x0 + u * c - v * d;
        f->xy[2 * k + 1] = s->y0 + u * d + v * c;
        left = fmin(left, f->xy[2 * k]);
        top = fmin(top, f->xy[2 * k + 1]);
    }
    left = floor(left) - MARGIN;
    top = floor(top) - MARGIN;
    for (k = 0; k < f->lenses; k++) { /* whole pixels: the sub-pixel phase is kept */
        f->xy[2 * k] -= left;
        f->xy[2 * k + 1] -= top;
        right = fmax(right, f->xy[2 * k]);
        bottom = fmax(bottom, f->xy[2 * k + 1]);
    }
    f->w = (int)ceil(right) + MARGIN;
    f->h = (int)ceil(bottom) + MARGIN;
}

/* Radial shift towards the middle, `barrel` of the radius at the corner. */
static void distort(draw_frame *f, const draw_spec *s)
{
    const double cx = 0.5 * f->w, cy = 0.5 * f->h, corner = cx * cx + cy * cy;
    int k;

    for (k = 0; k < f->lenses; k++) {
        double x = f->xy[2 * k] - cx, y = f->xy[2 * k + 1] - cy;
        double scale = 1.0 - s->barrel * (x * x + y * y) / corner;
        f->xy[2 * k] = cx + x * scale;
        f->xy[2 * k + 1] = cy + y * scale;
    }
}

static void move(draw_frame *f, const draw_spec *s)
{
    const double cx = 0.5 * (f->w - 1), cy = 0.5 * (f->h - 1);
    int k;

    for (k = 0; k < f->lenses; k++) {
        double x = f->xy[2 * k] - cx, y = f->xy[2 * k + 1] - cy;
        f->xy[2 * k] += s->shift_x + s->grow * x - s->turn * y;
        f->xy[2 * k + 1] += s->shift_y + s->turn * x + s->grow * y;
    }
}

/* A smooth random world, 1 - scene .. 1; (u,v) in lens pitches. */
static double world(const draw_spec *s, double u, double v)
{
    double sum = 0.0;
    int k;

    for (k = 0; k < 12; k++) {
        const double angle = 2.4 * k + 0.1 * s->seed, wave = 2.0 * PI / (2.5 + 1.7 * k);
        sum += cos(wave * (u * cos(angle) + v * sin(angle)) + 1.7 * k * k + s->seed);
    }
    sum = 0.5 + sum / 6.0;
    return 1.0 - s->scene * (sum < 0.0 ? 0.0 : sum > 1.0 ? 1.0 : sum);
}

static double light(const draw_frame *f, const draw_spec *s, double x, double y)
{
    double t = (x + y) / (f->w + f->h);

    if (x > (1.0 - s->black) * f->w) {
        return 0.0;
    }
    return 1.0 / (1.0 + t * (s->gradient - 1.0));
}

static void add_spot(const draw_frame *f, const draw_spec *s, float *im, double cx,
                     double cy, double level)
{
    const double far = s->slope * s->pitch;
    const int r =
        (int)ceil(s->spot == DRAW_DOTS ? 6.0 * s->sigma : 0.5 * s->pitch + 1.0);
    const int x0 = (int)floor(cx + 0.5), y0 = (int)floor(cy + 0.5);
    int x, y;

    for (y = y0 - r; y <= y0 + r; y++) {
        for (x = x0 - r; x <= x0 + r; x++) {
            if (x >= 0 && y >= 0 && x < f->w && y < f->h) {
                const double seen = s->scene > 0.0
                                        ? world(s, (cx + far * (x - cx)) / s->pitch,
                                                (cy + far * (y - cy)) / s->pitch)
                                        : 1.0;
                im[(size_t)y * (size_t)f->w + (size_t)x] +=
                    (float)(level * seen * pixel(s, x - cx, y - cy));
            }
        }
    }
}

/* Gaussian of `spread` px along one axis, `step` apart. */
static void blur_line(float *line, int n, int step, double spread, float *copy)
{
    int k, d;

    for (k = 0; k < n; k++) {
        copy[k] = line[(size_t)k * (size_t)step];
    }
    for (k = 0; k < n; k++) {
        double sum = 0.0, weight = 0.0;
        for (d = -12; d <= 12; d++) {
            if (k + d >= 0 && k + d < n) {
                const double w = exp(-0.5 * d * d / (spread * spread));
                sum += w * copy[k + d];
                weight += w;
            }
        }
        line[(size_t)k * (size_t)step] = (float)(sum / weight);
    }
}

static void blur(const draw_frame *f, double spread, float *im)
{
    float *copy = malloc((size_t)(f->w + f->h) * sizeof *copy);
    int k;

    if (copy == NULL) {
        abort();
    }
    for (k = 0; k < f->h; k++) {
        blur_line(im + (size_t)k * (size_t)f->w, f->w, 1, spread, copy);
    }
    for (k = 0; k < f->w; k++) {
        blur_line(im + k, f->h, f->w, spread, copy);
    }
    free(copy);
}

static void expose(const draw_frame *f, const draw_spec *s, const float *im)
{
    const size_t n = (size_t)f->w * (size_t)f->h;
    const double top = (double)((1 << s->bits) - 1);
    size_t k;

    for (k = 0; k < n; k++) {
        double v = 0.02 + im[k] + s->noise * normal();
        if (s->hot > 0.0 && uniform() < s->hot) {
            v = 0.3 + 0.7 * uniform();
        }
        v = floor(v * top + 0.5);
        f->px[k] = (uint16_t)(v < 0.0 ? 0.0 : v > top ? top : v);
    }
}

void draw(draw_frame *f, const draw_spec *s)
{
    float *im;
    int k;

    state = 88172645463325252u + 977u * s->seed;
    memset(f, 0, sizeof *f);
    f->lenses = s->nx * s->ny;
    f->xy = malloc(2u * (size_t)f->lenses * sizeof *f->xy);
    f->state = calloc((size_t)f->lenses, 1);
    if (f->xy == NULL || f->state == NULL) {
        abort();
    }
    place(f, s);
    distort(f, s);
    move(f, s);
    f->px = malloc((size_t)f->w * (size_t)f->h * sizeof *f->px);
    im = calloc((size_t)f->w * (size_t)f->h, sizeof *im);
    if (f->px == NULL || im == NULL) {
        abort();
    }
    for (k = 0; k < f->lenses; k++) {
        const double x = f->xy[2 * k], y = f->xy[2 * k + 1], l = light(f, s, x, y);
        f->state[k] = l <= 0.0 ? 2 : uniform() < s->dead ? 1 : 0;
        if (f->state[k] == 0) {
            add_spot(f, s, im, x, y, s->level * l);
        }
    }
    if (s->spread > 0.0) {
        blur(f, s->spread, im);
    }
    expose(f, s, im);
    free(im);
}

void draw_free(draw_frame *f)
{
    free(f->px);
    free(f->xy);
    free(f->state);
    memset(f, 0, sizeof *f);
}
