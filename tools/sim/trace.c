/* SPDX-License-Identifier: MIT
 * Light on the sensor by rays. */
#include "sim/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HEX_SIDE   0.93060485910209960 /* square as large as a hexagon of pitch 1 */
#define LENS_PARTS 3                   /* of a lens side, at the rim of the pupil */
#define RAYS_MAX   8                   /* a side */
#define PIXEL_ROWS 12                  /* of a pixel, at the rim of the pupil */

static double lens_side(const plft_camera *cam)
{
    return cam->pitch * cam->fill * (cam->hex ? HEX_SIDE : 1.0);
}

int plft_bayer_colour(int bayer, int x, int y)
{
    static const int colour[5][4] = {
        {1, 1, 1, 1}, {0, 1, 1, 2}, {1, 0, 2, 1}, {1, 2, 0, 1}, {2, 1, 1, 0}};

    return colour[bayer][2 * (y & 1) + (x & 1)];
}

/* Chord of a disc about (c,0) at height y: 0 when it misses. */
static int chord(double c, double y, double r, double *lo, double *hi)
{
    double q = r * r - y * y;
    double half;

    if (q <= 0.0) {
        return 0;
    }
    half = sqrt(q);
    *lo = c - half > *lo ? c - half : *lo;
    *hi = c + half < *hi ? c + half : *hi;
    return *hi > *lo;
}

/* Centre of the second stop as the pupil sees it from lens (cx,cy), and its radius
 * there: a ray through U meets the stop at U - (c*focus/L + U)*z/focus. */
static void stop_on_pupil(const plft_camera *cam, double cx, double cy, double *x,
                          double *y, double *r)
{
    double k = 1.0 - cam->stop_z / cam->focus;

    *x = cx * cam->stop_z / cam->L / k;
    *y = cy * cam->stop_z / cam->L / k;
    *r = cam->stop_r / k;
}

/* Part of the segment [x - w/2, x + w/2] at height y inside the pupil and the stop. */
static double segment(const plft_trace *t, double x, double y, double w,
                      const double stop[3])
{
    double lo = x - 0.5 * w;
    double hi = x + 0.5 * w;

    if (!chord(0.0, y, t->pupil_r, &lo, &hi)) {
        return 0.0;
    }
    if (stop[2] > 0.0 && !chord(stop[0], y - stop[1], stop[2], &lo, &hi)) {
        return 0.0;
    }
    return (hi - lo) / w;
}

/* Mean over parts of the lens (both axes) and rows of the pixel; along the rows of the
 * pixel the chord is exact. */
static double rim_cover(const plft_trace *t, double ux, double uy, const double stop[3])
{
    double pixel = t->cam->L * t->cam->pixel / t->cam->f_mu;
    double lens = lens_side(t->cam) / LENS_PARTS;
    double row = pixel / PIXEL_ROWS;
    double sum = 0.0;
    int i, j, k;

    for (j = 0; j < LENS_PARTS; j++) {
        for (k = 0; k < PIXEL_ROWS; k++) {
            double y = uy + (j - 0.5 * (LENS_PARTS - 1)) * lens +
                       (k - 0.5 * (PIXEL_ROWS - 1)) * row;
            for (i = 0; i < LENS_PARTS; i++) {
                double x = ux + (i - 0.5 * (LENS_PARTS - 1)) * lens;
                sum += segment(t, x, y, pixel, stop);
            }
        }
    }
    return sum / (LENS_PARTS * LENS_PARTS * PIXEL_ROWS);
}

/* Half the diagonal of the square of crossings of one pixel through one lens. */
static double reach(const plft_camera *cam)
{
    return 0.7072 * (cam->L * cam->pixel / cam->f_mu + lens_side(cam));
}

/* 1 all inside a disc, 0 all outside, -1 across its rim. */
static int side_of(double dx, double dy, double r, double margin)
{
    double d = sqrt(dx * dx + dy * dy);

    return d + margin < r ? 1 : d - margin > r ? 0 : -1;
}

double plft_trace_cover(const plft_trace *t, double ux, double uy, double cx, double cy)
{
    double stop[3] = {0.0, 0.0, 0.0};
    double margin = reach(t->cam);
    int pupil = side_of(ux, uy, t->pupil_r, margin);
    int second = 1;

    if (pupil != 0 && t->cam->stop_r > 0.0) {
        stop_on_pupil(t->cam, cx, cy, &stop[0], &stop[1], &stop[2]);
        second = side_of(ux - stop[0], uy - stop[1], stop[2], margin);
    }
    if (pupil == 0 || second == 0) {
        return 0.0;
    }
    return pupil == 1 && second == 1 ? 1.0 : rim_cover(t, ux, uy, stop);
}

plft_ray plft_trace_ray(const plft_camera *cam, double ax, double ay, double cx,
                        double cy, double sx, double sy)
{
    double k = cam->L / cam->f_mu;
    double ux = ax - k * (sx - cx);
    double uy = ay - k * (sy - cy);
    plft_ray ray = {-ux, -uy, ax / cam->L + ux / cam->focus,
                    ay / cam->L + uy / cam->focus};

    return ray;
}

/* out = in turned by small angles about X, Y, Z (sign -1: turned back). */
static void turned(const plft_pose *pose, double sign, const double in[3],
                   double out[3])
{
    double a = sign * pose->turn[0];
    double b = sign * pose->turn[1];
    double c = sign * pose->turn[2];

    out[0] = in[0] + b * in[2] - c * in[1];
    out[1] = in[1] + c * in[0] - a * in[2];
    out[2] = in[2] + a * in[1] - b * in[0];
}

plft_ray plft_pose_ray(const plft_pose *pose, const plft_ray *ray)
{
    const double from[3] = {ray->px, ray->py, 0.0};
    const double along[3] = {ray->dx, ray->dy, 1.0};
    double p[3], d[3];
    plft_ray out;

    turned(pose, 1.0, from, p);
    turned(pose, 1.0, along, d);
    out.dx = d[0] / d[2];
    out.dy = d[1] / d[2];
    out.px = p[0] + pose->shift[0] - (p[2] + pose->shift[2]) * out.dx;
    out.py = p[1] + pose->shift[1] - (p[2] + pose->shift[2]) * out.dy;
    return out;
}

/* Turning back by small angles is exact to their square: three corrections. */
void plft_pose_inverse(const plft_pose *pose, const double world[3], double out[3])
{
    double x[3], again[3], left[3], more[3];
    int k, i;

    for (i = 0; i < 3; i++) {
        x[i] = world[i] - pose->shift[i];
    }
    turned(pose, -1.0, x, out);
    for (k = 0; k < 3; k++) {
        turned(pose, 1.0, out, again);
        for (i = 0; i < 3; i++) {
            left[i] = x[i] - again[i];
        }
        turned(pose, -1.0, left, more);
        for (i = 0; i < 3; i++) {
            out[i] += more[i];
        }
    }
}

double plft_trace_side(const plft_camera *cam, double z, double lens, double pixel)
{
    double a = lens * (z / cam->F - 1.0);
    double s = pixel * cam->L / cam->f_mu * (1.0 - z / cam->focus);

    return sqrt(a * a + s * s);
}

/* Reflectance seen by one ray; `part` is the side of its share of lens and pixel. */
static double ray_value(const plft_trace *t, const plft_ray *ray, double part,
                        int colour)
{
    plft_ray seen = t->pose != NULL ? plft_pose_ray(t->pose, ray) : *ray;
    plft_hit hit = plft_world_trace(t->world, &seen);
    double side;

    if (!hit.quad) {
        return t->world->sky;
    }
    side =
        plft_trace_side(t->cam, hit.z, lens_side(t->cam) * part, t->cam->pixel * part);
    return plft_world_shade(t->world, &hit, &seen, side) *
           (t->bayer ? hit.quad->rgb[colour] : 1.0);
}

/* The rays of lens c to a pixel that pass the pupil; one at least.  Share (i,j) of the
 * lens goes with share (j,i) of the pixel, so that both are covered.  *part is the side
 * of a share. */
static int rays_of(const plft_trace *t, const double c[2], double sx, double sy,
                   plft_ray *ray, double *part)
{
    const plft_camera *cam = t->cam;
    int n = 0;
    int i, j;

    *part = 1.0 / t->rays;
    for (j = 0; j < t->rays; j++) {
        for (i = 0; i < t->rays; i++) {
            double di = (i + 0.5) * *part - 0.5;
            double dj = (j + 0.5) * *part - 0.5;
            ray[n] = plft_trace_ray(cam, c[0] + di * lens_side(cam),
                                    c[1] + dj * lens_side(cam), c[0], c[1],
                                    sx + dj * cam->pixel, sy + di * cam->pixel);
            n +=
                ray[n].px * ray[n].px + ray[n].py * ray[n].py < t->pupil_r * t->pupil_r;
        }
    }
    if (n == 0) { /* a sliver of the pupil between the rays */
        ray[n++] = plft_trace_ray(cam, c[0], c[1], c[0], c[1], sx, sy);
        *part = 1.0;
    }
    return n;
}

/* Mean reflectance over rays. */
static double mean_of(const plft_trace *t, const plft_ray *ray, int n, double part,
                      int colour)
{
    double sum = 0.0;
    int k;

    for (k = 0; k < n; k++) {
        sum += ray_value(t, &ray[k], part, colour);
    }
    return sum / n;
}

/* Mean reflectance over the lens aperture and the pixel that pass the pupil. */
static double mean_value(const plft_trace *t, const double c[2], double sx, double sy,
                         int colour)
{
    plft_ray ray[RAYS_MAX * RAYS_MAX];
    double part;
    int n = rays_of(t, c, sx, sy, ray, &part);

    return mean_of(t, ray, n, part, colour);
}

/* Part of a pixel's light that passes lens (i,j) and the pupil. */
static double lens_cover(const plft_trace *t, int i, int j, double sx, double sy)
{
    const plft_camera *cam = t->cam;
    size_t at = (size_t)j * (size_t)cam->nx + (size_t)i;
    const double *c = cam->centre + 2 * at;
    double ux = c[0] - cam->L * (sx - c[0]) / cam->f_mu;
    double uy = c[1] - cam->L * (sy - c[1]) / cam->f_mu;
    double tan_x = (ux - c[0]) / cam->L;
    double tan_y = (uy - c[1]) / cam->L;
    double sec2 = 1.0 + tan_x * tan_x + tan_y * tan_y; /* cos^4 law */
    double light = plft_trace_cover(t, ux, uy, c[0], c[1]) * cam->gain[at];

    return light > 0.0 ? light / (sec2 * sec2) : 0.0;
}

/* Light that lens (i,j) sends to the sensor point in mm. */
static double lens_light(const plft_trace *t, int i, int j, double sx, double sy,
                         int colour)
{
    const double *c = t->cam->centre + 2 * ((size_t)j * (size_t)t->cam->nx + (size_t)i);
    double light = lens_cover(t, i, j, sx, sy);

    return light > 0.0 && t->world ? light * mean_value(t, c, sx, sy, colour) : light;
}

double plft_trace_pixel(const plft_trace *t, int x, int y)
{
    const plft_camera *cam = t->cam;
    double sx = (x - 0.5 * (cam->w - 1)) * cam->pixel;
    double sy = (y - 0.5 * (cam->h - 1)) * cam->pixel;
    int colour = plft_bayer_colour(t->bayer, x, y);
    double sum = 0.0;
    int i0, j0, i, j;

    plft_camera_nearest(cam, sx, sy, &i0, &j0);
    for (j = j0 - 1; j <= j0 + 1; j++) {
        for (i = i0 - 1; i <= i0 + 1; i++) {
            if (i >= 0 && j >= 0 && i < cam->nx && j < cam->ny) {
                sum += lens_light(t, i, j, sx, sy, colour);
            }
        }
    }
    return t->bayer ? sum * t->colour[colour] : sum;
}

/* Taps k[0..3] of a Gaussian, k[0] in the middle, their sum over both sides 1. */
static void gauss_taps(double sigma, double k[4])
{
    double sum = 1.0;
    int i;

    k[0] = 1.0;
    for (i = 1; i < 4; i++) {
        k[i] = exp(-0.5 * i * i / (sigma * sigma));
        sum += 2.0 * k[i];
    }
    for (i = 0; i < 4; i++) {
        k[i] /= sum;
    }
}

static int at_edge(int i, int n)
{
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

static void blur_row(const double *in, double *out, int n, const double k[4])
{
    int i, d;

    for (i = 0; i < n; i++) {
        double sum = k[0] * in[i];
        for (d = 1; d < 4; d++) {
            sum += k[d] * (in[at_edge(i - d, n)] + in[at_edge(i + d, n)]);
        }
        out[i] = sum;
    }
}

/* Row y of the frame blurred across rows. */
static void blur_across(const double *in, double *out, int w, int h, int y,
                        const double k[4])
{
    const double *row[7];
    int x, d;

    for (d = -3; d <= 3; d++) {
        row[d + 3] = in + (size_t)at_edge(y + d, h) * (size_t)w;
    }
    for (x = 0; x < w; x++) {
        double sum = k[0] * row[3][x];
        for (d = 1; d < 4; d++) {
            sum += k[d] * (row[3 - d][x] + row[3 + d][x]);
        }
        out[x] = sum;
    }
}

static int blur_frame(double *signal, int w, int h, double sigma)
{
    double *other = malloc((size_t)w * (size_t)h * sizeof *other);
    double k[4];
    int y;

    if (!other) {
        return -1;
    }
    gauss_taps(sigma, k);
    for (y = 0; y < h; y++) {
        blur_row(signal + (size_t)y * (size_t)w, other + (size_t)y * (size_t)w, w, k);
    }
    for (y = 0; y < h; y++) {
        blur_across(other, signal + (size_t)y * (size_t)w, w, h, y, k);
    }
    free(other);
    return 0;
}

int plft_trace_frame(const plft_trace *t, double *signal)
{
    int w = t->cam->w;
    int h = t->cam->h;
    int x, y;

    for (y = 0; y < h; y++) {
        for (x = 0; x < w; x++) {
            signal[(size_t)y * (size_t)w + (size_t)x] = plft_trace_pixel(t, x, y);
        }
    }
    return t->cam->blur > 0.0 ? blur_frame(signal, w, h, t->cam->blur) : 0;
}

/* ---- beams ---- */

static int beam_room(plft_beams *b)
{
    if (b->n == b->room) {
        size_t room = b->room ? 2 * b->room : 1 << 16;
        plft_beam *more = realloc(b->beam, room * sizeof *more);
        if (!more) {
            return -1;
        }
        b->beam = more;
        b->room = room;
    }
    if (b->ray_room - b->rays < RAYS_MAX * RAYS_MAX) {
        size_t room = b->ray_room ? 2 * b->ray_room : 1 << 16;
        plft_ray *more = realloc(b->ray, room * sizeof *more);
        if (!more) {
            return -1;
        }
        b->ray = more;
        b->ray_room = room;
    }
    return 0;
}

static int beams_of_pixel(plft_beams *b, const plft_trace *t, int x, int y)
{
    const plft_camera *cam = t->cam;
    double sx = (x - 0.5 * (cam->w - 1)) * cam->pixel;
    double sy = (y - 0.5 * (cam->h - 1)) * cam->pixel;
    double part;
    int i0, j0, i, j;

    plft_camera_nearest(cam, sx, sy, &i0, &j0);
    for (j = j0 - 1; j <= j0 + 1; j++) {
        for (i = i0 - 1; i <= i0 + 1; i++) {
            int on = i >= 0 && j >= 0 && i < cam->nx && j < cam->ny;
            double light = on ? lens_cover(t, i, j, sx, sy) : 0.0;
            if (light > 0.0) {
                size_t at = (size_t)j * (size_t)cam->nx + (size_t)i;
                plft_beam *beam;
                if (beam_room(b)) {
                    return -1;
                }
                beam = &b->beam[b->n++];
                beam->pixel = (uint32_t)(y * cam->w + x);
                beam->light = light;
                beam->rays = (uint32_t)rays_of(t, cam->centre + 2 * at, sx, sy,
                                               b->ray + b->rays, &part);
                beam->part = part;
                b->rays += beam->rays;
            }
        }
    }
    return 0;
}

int plft_beams_make(plft_beams *b, const plft_trace *t, const uint8_t *mask)
{
    int x, y;

    b->beam = NULL;
    b->ray = NULL;
    b->n = b->rays = b->room = b->ray_room = 0;
    for (y = 0; y < t->cam->h; y++) {
        for (x = 0; x < t->cam->w; x++) {
            int wanted = !mask || mask[(size_t)y * (size_t)t->cam->w + (size_t)x];
            if (wanted && beams_of_pixel(b, t, x, y)) {
                plft_beams_free(b);
                return -1;
            }
        }
    }
    return 0;
}

int plft_beams_frame(const plft_beams *b, const plft_trace *t, double *signal)
{
    int w = t->cam->w;
    int h = t->cam->h;
    const plft_ray *ray = b->ray;
    size_t k = 0;

    memset(signal, 0, (size_t)w * (size_t)h * sizeof *signal);
    while (k < b->n) {
        uint32_t pixel = b->beam[k].pixel;
        int colour = plft_bayer_colour(t->bayer, (int)(pixel % (uint32_t)w),
                                       (int)(pixel / (uint32_t)w));
        double sum = 0.0;
        for (; k < b->n && b->beam[k].pixel == pixel; k++) {
            const plft_beam *m = &b->beam[k];
            sum += t->world ? m->light * mean_of(t, ray, (int)m->rays, m->part, colour)
                            : m->light;
            ray += m->rays;
        }
        signal[pixel] = t->bayer ? sum * t->colour[colour] : sum;
    }
    return t->cam->blur > 0.0 ? blur_frame(signal, w, h, t->cam->blur) : 0;
}

void plft_beams_free(plft_beams *b)
{
    free(b->beam);
    free(b->ray);
    b->beam = NULL;
    b->ray = NULL;
    b->n = b->rays = b->room = b->ray_room = 0;
}
