/* SPDX-License-Identifier: MIT
 * The stages of frame.h the slow, obvious way: costs and paths in integers from the
 * formulas, medians by counting, refinement in double. */
#ifndef PLENOFIX_REF_FRAME_H
#define PLENOFIX_REF_FRAME_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "frame_state.h"

static inline int ref_clamp(int v, int lo, int hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

static inline int ref_sample(const plfx_frame_state *s, int k, int x, int y)
{
    return plfx_frame_row(s, k, ref_clamp(y, 0, s->ny - 1))[ref_clamp(x, 0, s->nx - 1)];
}

/* Bilinear in sixteenths, columns first, each step rounded half up. */
static inline int ref_warped(const plfx_frame_state *s, int k, plfx_shift t, int x,
                             int y)
{
    int h[2];
    int j;

    for (j = 0; j < 2; j++) {
        int yy = ref_clamp(y + t.ky + j, 0, s->ny - 1);
        int q4 = 16 * t.kx + t.fx_q4 +
                 (s->plan->hex ? s->plan->odd_q4 * ((y & 1) - (yy & 1)) : 0);
        int f = q4 & 15;
        int a = ref_sample(s, k, x + (q4 - f) / 16, yy);
        int b = ref_sample(s, k, x + (q4 - f) / 16 + 1, yy);
        h[j] = (a * (16 - f) + b * f + 8) / 16;
    }
    return (h[0] * (16 - t.fy_q4) + h[1] * t.fy_q4 + 8) / 16;
}

static inline int ref_diff(const plfx_frame_state *s, int k, plfx_shift t, int x, int y)
{
    x = ref_clamp(x, 0, s->nx - 1);
    y = ref_clamp(y, 0, s->ny - 1);
    return ref_warped(s, k, t, x, y) - ref_sample(s, s->plan->cfg.ref, x, y);
}

static inline int ref_min(int a, int b)
{
    return a < b ? a : b;
}

static inline int ref_view_cost(const plfx_frame_state *s, int k, plfx_shift t, int x,
                                int y)
{
    int d = abs(ref_diff(s, k, t, x, y));
    int dx = abs(ref_diff(s, k, t, x + 1, y) - ref_diff(s, k, t, x - 1, y));
    int dy = abs(ref_diff(s, k, t, x, y + 1) - ref_diff(s, k, t, x, y - 1));

    return ref_min(d, s->cfg.trunc_q4) +
           (ref_min(dx, s->cfg.gtrunc_q4) + ref_min(dy, s->cfg.gtrunc_q4)) *
               s->cfg.gweight_q4 / 16;
}

/* Scaled mean of arm a at a pixel. */
static inline int ref_arm(const plfx_frame_state *s, int a, int label, int x, int y)
{
    int64_t sum = 0;
    int k;

    x = ref_clamp(x, 0, s->nx - 1);
    y = ref_clamp(y, 0, s->ny - 1);
    for (k = 0; k < s->n; k++) {
        if (s->arm_of[k] == a) {
            sum += ref_view_cost(s, k, plfx_plan_shift(s->plan, k, label), x, y);
        }
    }
    return (int)((sum * s->arm_mul[a] + ((int64_t)1 << (s->arm_shift[a] - 1))) >>
                 s->arm_shift[a]);
}

static inline int ref_by_value(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

/* 8-bit cost of a label before the 3x3 minimum. */
static inline int ref_cost(const plfx_frame_state *s, int label, int x, int y)
{
    int box[PLFX_ARMS_MAX];
    int r = s->plan->cfg.window / 2;
    int arms = 0;
    int sum = 0;
    int a;
    int i;
    int j;

    x = ref_clamp(x, 0, s->nx - 1);
    y = ref_clamp(y, 0, s->ny - 1);
    for (a = 0; a < s->cfg.arms; a++) {
        if (s->arm_n[a] == 0) {
            continue;
        }
        box[arms] = 0;
        for (j = -r; j <= r; j++) {
            for (i = -r; i <= r; i++) {
                box[arms] += ref_arm(s, a, label, x + i, y + j);
            }
        }
        arms++;
    }
    qsort(box, (size_t)arms, sizeof *box, ref_by_value);
    for (i = 0; i < s->keep; i++) {
        sum += box[i] / 4;
    }
    return ref_min(255, (int)(((int64_t)sum * s->vol_mul) >> 16));
}

static inline int ref_volume(const plfx_frame_state *s, int label, int x, int y)
{
    int best = ref_cost(s, label, x, y);
    int i;

    for (i = 0; s->cfg.shrink && i < 9; i++) {
        best = ref_min(best, ref_cost(s, label, x + i % 3 - 1, y + i / 3 - 1));
    }
    return best;
}

/* Path costs along (dx,dy) into out[ny][nx][labels]. */
static inline void ref_path(const plfx_frame_state *s, int dx, int dy, int *out)
{
    int n = s->labels;
    int i;
    int l;

    for (i = 0; i < s->nx * s->ny; i++) {
        int x =
            dx > 0 || (dx == 0 && dy > 0) || dy > 0 ? i % s->nx : s->nx - 1 - i % s->nx;
        int y = dy >= 0 ? i / s->nx : s->ny - 1 - i / s->nx;
        int px;
        int py = y - dy;
        int *here;
        if (dy == 0) {
            x = dx > 0 ? i % s->nx : s->nx - 1 - i % s->nx;
        }
        px = x - dx;
        here = out + (size_t)(y * s->nx + x) * (size_t)n;
        for (l = 0; l < n; l++) {
            int c = s->volume[((size_t)y * (size_t)n + (size_t)l) * (size_t)s->nx +
                              (size_t)x];
            here[l] = c;
        }
        if (px >= 0 && px < s->nx && py >= 0 && py < s->ny) {
            const int *q = out + (size_t)(py * s->nx + px) * (size_t)n;
            int grey = abs(ref_sample(s, s->plan->cfg.ref, x, y) -
                           ref_sample(s, s->plan->cfg.ref, px, py));
            int m = q[0];
            for (l = 1; l < n; l++) {
                m = ref_min(m, q[l]);
            }
            for (l = 0; l < n; l++) {
                int v = ref_min(q[l], m + s->p2_of[grey / 16]);
                v = l > 0 ? ref_min(v, q[l - 1] + s->p1) : v;
                v = l < n - 1 ? ref_min(v, q[l + 1] + s->p1) : v;
                here[l] += v - m;
            }
        }
    }
}

/* Weighted median of a window by trying every value of the window. */
static inline int ref_median(const plfx_frame_state *s, int window,
                             const int32_t *value, int x, int y)
{
    int r = window / 2;
    int h = s->cfg.similar_q4;
    int v[49];
    int w[49];
    int total = 0;
    int best = 0;
    int n = 0;
    int i;
    int j;

    for (j = -r; j <= r; j++) {
        for (i = -r; i <= r; i++) {
            int xx = ref_clamp(x + i, 0, s->nx - 1);
            int yy = ref_clamp(y + j, 0, s->ny - 1);
            int d = abs(ref_sample(s, s->plan->cfg.ref, xx, yy) -
                        ref_sample(s, s->plan->cfg.ref, x, y));
            int q = ref_min(d, h) * (65535 / h) / 256;
            int u = 255 - q * q / 256;
            v[n] = value[yy * s->nx + xx];
            w[n] = u * u / 256;
            total += w[n++];
        }
    }
    best = INT32_MAX;
    for (i = 0; i < n; i++) {
        int sum = 0;
        for (j = 0; j < n; j++) {
            sum += v[j] <= v[i] ? w[j] : 0;
        }
        if (2 * sum >= total && v[i] < best) {
            best = v[i];
        }
    }
    return best;
}

/* Least-squares taps as tests/bench/ls_kernel.py defines them, by normal equations with
 * two constraints: sum t = 1, sum k t = f. */
static inline void ref_taps(int n, double f, double *taps)
{
    double m[8][9];
    double band = n == 4 ? 0.35 : 0.3;
    int i;
    int j;
    int k;

    memset(m, 0, sizeof m);
    for (k = 0; k < 96; k++) {
        double w = 2 * 3.14159265358979323846 * (k + 0.5) / 96 * band;
        double c = w / 2;
        double g = w * (sin(c) / c) * exp(-w);
        for (i = 0; i < n; i++) {
            for (j = 0; j < n; j++) {
                m[i][j] += g * g * cos(w * (i - j));
            }
            m[i][n + 2] += g * g * cos(w * (i - (n / 2 - 1) - f));
        }
    }
    for (i = 0; i < n; i++) {
        m[i][n] = 1;
        m[n][i] = 1;
        m[i][n + 1] = i - (n / 2 - 1);
        m[n + 1][i] = i - (n / 2 - 1);
    }
    m[n][n + 2] = 1;
    m[n + 1][n + 2] = f;
    for (i = 0; i < n + 2; i++) { /* Gauss-Jordan with row pivots */
        int p = i;
        for (j = i + 1; j < n + 2; j++) {
            p = fabs(m[j][i]) > fabs(m[p][i]) ? j : p;
        }
        for (k = 0; k <= n + 2; k++) {
            double t = m[i][k];
            m[i][k] = m[p][k];
            m[p][k] = t;
        }
        for (j = 0; j < n + 2; j++) {
            double q = j == i ? 0 : m[j][i] / m[i][i];
            for (k = i; k <= n + 2; k++) {
                m[j][k] -= q * m[i][k];
            }
        }
    }
    for (i = 0; i < n; i++) {
        taps[i] = m[i][n + 2] / m[i][i];
    }
}

/* View k at a real position by n taps an axis; NAN where the kernel leaves the view. */
static inline double ref_value(const plfx_frame_state *s, int k, double x, double y)
{
    double tx[8];
    double ty[8];
    int n = s->cfg.taps;
    int x0 = (int)floor(x);
    int y0 = (int)floor(y);
    double sum = 0;
    int i;
    int j;

    if (x0 < n / 2 - 1 || y0 < n / 2 - 1 || x0 > s->nx - 1 - n / 2 ||
        y0 > s->ny - 1 - n / 2) {
        return NAN;
    }
    ref_taps(n, x - x0, tx);
    ref_taps(n, y - y0, ty);
    for (j = 0; j < n; j++) {
        for (i = 0; i < n; i++) {
            sum += ty[j] * tx[i] *
                   ref_sample(s, k, x0 + i - (n / 2 - 1), y0 + j - (n / 2 - 1));
        }
    }
    return sum;
}

typedef struct ref_sums {
    double a, b, r, w, n;
} ref_sums;

/* Information of one pixel at displacement e (columns of the widest view). */
static inline ref_sums ref_pixel(const plfx_frame_state *s, double e, int x, int y)
{
    const double d5[5] = {1. / 12, -8. / 12, 0, 8. / 12, -1. / 12};
    double limit = s->cfg.robust_q4;
    double gx = 0;
    double gy = 0;
    ref_sums t = {0, 0, 0, 0, 0};
    int k;

    for (k = 0; k < 5; k++) {
        gx += d5[k] * ref_sample(s, s->plan->cfg.ref, x + k - 2, y);
        gy += d5[k] * ref_sample(s, s->plan->cfg.ref, x, y + k - 2);
    }
    for (k = 0; k < s->n; k++) {
        double bx = s->bx_q16[k] / 65536.;
        double by = s->by_q16[k] / 65536.;
        double v = s->arm_of[k] < 0 ? NAN : ref_value(s, k, x + e * bx, y + e * by);
        double r = v - ref_sample(s, s->plan->cfg.ref, x, y);
        double g = bx * gx + by * gy;
        double q = 1 - r * r / (limit * limit);
        if (isnan(v)) {
            continue;
        }
        t.n++;
        if (q > 0) {
            t.a += q * q * g * g;
            t.b += q * q * g * r;
            t.r += q * q * r * r;
            t.w += q * q;
        }
    }
    return t;
}

#endif
