/* SPDX-License-Identifier: MIT
 * Drift of a lattice in double, from the formulas of drift.h: no fixed point, no
 * shared sums; every window is kept, the similarity is from full normal equations. */
#ifndef PLENOFIX_TESTS_REF_DRIFT_H
#define PLENOFIX_TESTS_REF_DRIFT_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plenofix/drift.h"

#define REF_DRIFT_LENSES 512
#define REF_DRIFT_SIDE   25 /* samples of a window, at most */

typedef struct ref_drift {
    double p[4]; /* shift x, y, rotation, scale */
    double rms;
    int lenses, tried;
} ref_drift;

typedef struct ref_drift_lens {
    double x, y, dx, dy;
    double w[REF_DRIFT_SIDE][REF_DRIFT_SIDE];
    int ok;
} ref_drift_lens;

static ref_drift_lens ref_lens[REF_DRIFT_LENSES];

static double ref_spline(double d)
{
    const double r = fabs(d);

    return r < 1.0   ? (4.0 - 6.0 * r * r + 3.0 * r * r * r) / 6.0
           : r < 2.0 ? pow(2.0 - r, 3.0) / 6.0
                     : 0.0;
}

static double ref_tap(double d)
{
    return 0.5 * (ref_spline(d - 0.5) + ref_spline(d + 0.5));
}

/* Taps of the pixels first .. first+5 around c. */
static int ref_taps(double c, double tap[6])
{
    const int first = (int)floor(c - 0.5) - 1;
    int k;

    for (k = 0; k < 6; k++) {
        tap[k] = ref_tap(first + k - c);
    }
    return first;
}

static void ref_window(const uint16_t *px, int w, double cx, double cy, int half,
                       ref_drift_lens *l)
{
    double tx[6], ty[6];
    const int x0 = ref_taps(cx, tx), y0 = ref_taps(cy, ty);
    int x, y, i, j;

    for (y = -half; y <= half; y++) {
        for (x = -half; x <= half; x++) {
            double sum = 0.0;
            for (j = 0; j < 6; j++) {
                for (i = 0; i < 6; i++) {
                    sum += tx[i] * ty[j] * px[(y0 + y + j) * w + x0 + x + i];
                }
            }
            l->w[y + half][x + half] = sum;
        }
    }
}

/* Windows where p puts the lenses; all must lie on the frame. */
static void ref_read(const plfx_lut *lut, const uint16_t *px, int stride, int half,
                     ref_drift *r)
{
    const double mx = 0.5 * (lut->sensor_w - 1), my = 0.5 * (lut->sensor_h - 1);
    int i, j;

    r->tried = 0;
    for (j = 1 + stride / 2; j < lut->lattice.ny - 1; j += stride) {
        for (i = 1 + stride / 2; i < lut->lattice.nx - 1; i += stride) {
            const plfx_point c = plfx_lut_centre(lut, i, j);
            ref_drift_lens *l = &ref_lens[r->tried];
            double cx, cy;
            if (plfx_lut_flags(lut, i, j) != 0) {
                continue;
            }
            l->x = c.x_q16 / 65536.0 - mx;
            l->y = c.y_q16 / 65536.0 - my;
            cx = l->x + mx + r->p[0] + r->p[3] * l->x - r->p[2] * l->y;
            cy = l->y + my + r->p[1] + r->p[2] * l->x + r->p[3] * l->y;
            ref_window(px, lut->sensor_w, cx, cy, half, l);
            r->tried++;
        }
    }
}

static int ref_in(double radius, int x, int y)
{
    return (double)x * x + (double)y * y <= radius * radius;
}

static void ref_centroids(int n, int half, double radius)
{
    int k, x, y;

    for (k = 0; k < n; k++) {
        ref_drift_lens *l = &ref_lens[k];
        double low = HUGE_VAL, high = -HUGE_VAL, m = 0.0, mx = 0.0, my = 0.0;
        for (y = -half; y <= half; y++) {
            for (x = -half; x <= half; x++) {
                if (ref_in(radius, x, y)) {
                    low = fmin(low, l->w[y + half][x + half]);
                    high = fmax(high, l->w[y + half][x + half]);
                }
            }
        }
        for (y = -half; y <= half; y++) {
            for (x = -half; x <= half; x++) {
                const double v = l->w[y + half][x + half] - low;
                if (ref_in(radius, x, y)) {
                    m += v;
                    mx += v * x;
                    my += v * y;
                }
            }
        }
        l->ok = high - low >= 512.0;
        l->dx = m > 0.0 ? mx / m : 0.0;
        l->dy = m > 0.0 ? my / m : 0.0;
    }
}

/* Mean of the windows that counted the last time. */
static void ref_mean(int n, int side, double t[REF_DRIFT_SIDE][REF_DRIFT_SIDE])
{
    int k, x, y, used = 0;

    memset(t, 0, sizeof(double) * REF_DRIFT_SIDE * REF_DRIFT_SIDE);
    for (k = 0; k < n; k++) {
        used += ref_lens[k].ok;
        for (y = 0; y < side && ref_lens[k].ok; y++) {
            for (x = 0; x < side; x++) {
                t[y][x] += ref_lens[k].w[y][x];
            }
        }
    }
    for (y = 0; y < side; y++) {
        for (x = 0; x < side; x++) {
            t[y][x] /= used;
        }
    }
}

/* Every window against the mean lens t. */
static void ref_against(int n, int half, double radius,
                        double t[REF_DRIFT_SIDE][REF_DRIFT_SIDE])
{
    static double gx[REF_DRIFT_SIDE][REF_DRIFT_SIDE],
        gy[REF_DRIFT_SIDE][REF_DRIFT_SIDE], e[REF_DRIFT_SIDE][REF_DRIFT_SIDE];
    double mean = 0.0, xx = 0.0, xy = 0.0, yy = 0.0, et = 0.0, ee = 0.0;
    int k, x, y, cells = 0;

    for (y = 1; y < 2 * half; y++) {
        for (x = 1; x < 2 * half; x++) {
            const int ox = 2 * half - x, oy = 2 * half - y;
            gx[y][x] =
                0.25 * (t[y][x + 1] - t[y][x - 1] - t[oy][ox + 1] + t[oy][ox - 1]);
            gy[y][x] =
                0.25 * (t[y + 1][x] - t[y - 1][x] - t[oy + 1][ox] + t[oy - 1][ox]);
            e[y][x] = 0.5 * (t[y][x] + t[oy][ox]);
            if (ref_in(radius, x - half, y - half)) {
                mean += e[y][x];
                cells++;
            }
        }
    }
    mean /= cells;
    for (y = 1; y < 2 * half; y++) {
        for (x = 1; x < 2 * half; x++) {
            e[y][x] -= mean;
            if (ref_in(radius, x - half, y - half)) {
                xx += gx[y][x] * gx[y][x];
                xy += gx[y][x] * gy[y][x];
                yy += gy[y][x] * gy[y][x];
                et += e[y][x] * t[y][x];
                ee += e[y][x] * e[y][x];
            }
        }
    }
    for (k = 0; k < n; k++) {
        ref_drift_lens *l = &ref_lens[k];
        double bx = 0.0, by = 0.0, ew = 0.0, w1 = 0.0, w2 = 0.0;
        for (y = 1; y < 2 * half; y++) {
            for (x = 1; x < 2 * half; x++) {
                const double w = l->w[y][x];
                if (ref_in(radius, x - half, y - half)) {
                    bx += gx[y][x] * w;
                    by += gy[y][x] * w;
                    ew += e[y][x] * w;
                    w1 += w;
                    w2 += w * w;
                }
            }
        }
        l->ok = 8.0 * ew > et && ew >= 0.3 * sqrt(ee * (w2 - w1 * w1 / cells));
        l->dx = -(yy * bx - xy * by) / (xx * yy - xy * xy) * et / ew;
        l->dy = -(xx * by - xy * bx) / (xx * yy - xy * xy) * et / ew;
    }
}

/* Add the least-squares similarity of the lenses within `reach`; the longest
 * coordinate that it moves at a corner. */
static double ref_step(const plfx_lut *lut, double reach, ref_drift *r)
{
    double a[4][5] = {{0.0}}, s = 0.0, square = 0.0;
    int k, i, j, m, axis;

    r->lenses = 0;
    for (k = 0; k < r->tried; k++) {
        ref_drift_lens *l = &ref_lens[k];
        const double f[2][5] = {{1.0, 0.0, -l->y, l->x, l->dx},
                                {0.0, 1.0, l->x, l->y, l->dy}};
        l->ok = l->ok && hypot(l->dx, l->dy) <= reach;
        r->lenses += l->ok;
        square += l->ok ? l->dx * l->dx + l->dy * l->dy : 0.0;
        for (axis = 0; axis < 2 && l->ok; axis++) {
            for (i = 0; i < 4; i++) {
                for (j = 0; j < 5; j++) {
                    a[i][j] += f[axis][i] * f[axis][j];
                }
            }
        }
    }
    r->rms = sqrt(square / (2.0 * r->lenses));
    for (i = 0; i < 4; i++) {
        for (m = 0; m < 4; m++) {
            const double q = a[m][i] / a[i][i];
            for (j = 0; j < 5 && m != i; j++) {
                a[m][j] -= q * a[i][j];
            }
        }
    }
    for (i = 0; i < 4; i++) {
        r->p[i] += a[i][4] / a[i][i];
        s += fabs(a[i][4] / a[i][i]) *
             (i < 2 ? 1.0 : 0.5 * hypot(lut->sensor_w, lut->sensor_h));
    }
    return s;
}

/* px: 16-bit samples.  Windows of all lenses must lie on the frame. */
static ref_drift ref_drift_find(const plfx_lut *lut, const uint16_t *px, int lenses)
{
    static double mean[REF_DRIFT_SIDE][REF_DRIFT_SIDE];
    const double pitch = plfx_lut_pitch_q16(lut) / 65536.0, radius = 0.5 * pitch + 0.5;
    const int half = (int)floor(radius) + 2;
    ref_drift r;
    double step = 1e9;
    int stride = 1, round;

    memset(&r, 0, sizeof r);
    while (((lut->lattice.nx + stride - 1) / stride) *
               ((lut->lattice.ny + stride - 1) / stride) >
           lenses) {
        stride++;
    }
    for (round = 0; round < 5 && step > 0.5; round++) {
        ref_read(lut, px, stride, half, &r);
        ref_centroids(r.tried, half, radius);
        step = ref_step(lut, 0.4 * pitch, &r);
    }
    for (round = 0; round < 10; round++) {
        ref_mean(r.tried, 2 * half + 1, mean);
        ref_read(lut, px, stride, half, &r);
        ref_against(r.tried, half, radius, mean);
        ref_step(lut,
                 round == 0 ? 0.4 * pitch
                            : fmin(0.3 * pitch, fmax(4.0 * r.rms, 1.0 / 64.0)),
                 &r);
    }
    return r;
}

#endif
