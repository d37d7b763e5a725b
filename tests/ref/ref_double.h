/* SPDX-License-Identifier: MIT
 * plfx_frame() in double: the same method with exact shifts, unrounded costs, paths,
 * medians and steps.  What fixed point costs is the difference in figures.  No
 * smoothing and no flags: noise_q4 must be under the smoothing threshold. */
#ifndef PLENOFIX_REF_DOUBLE_H
#define PLENOFIX_REF_DOUBLE_H

#include "ref_frame.h"

#define REF_PHASES 1024

typedef struct ref_field { /* one double a pixel */
    double *v;
    int w, h;
} ref_field;

static inline double ref_at(const plfx_frame_state *s, int k, int x, int y)
{
    return ref_sample(s, k, x, y) / 16.; /* 8-bit grey levels */
}

static inline double ref_dmin(double a, double b)
{
    return a < b ? a : b;
}

/* View k at slope d, bilinear, minus the reference. */
static inline void ref_warp(const plfx_frame_state *s, int k, double d, double *out)
{
    double sx = d * s->bx_q16[k] / 65536. * s->base_q8 / 256.;
    double sy = d * s->by_q16[k] / 65536. * s->base_q8 / 256.;
    int kx = (int)floor(sx);
    int ky = (int)floor(sy);
    double fx = sx - kx;
    double fy = sy - ky;
    int x;
    int y;

    for (y = 0; y < s->ny; y++) {
        for (x = 0; x < s->nx; x++) {
            double a = ref_at(s, k, x + kx, y + ky) * (1 - fx) +
                       ref_at(s, k, x + kx + 1, y + ky) * fx;
            double b = ref_at(s, k, x + kx, y + ky + 1) * (1 - fx) +
                       ref_at(s, k, x + kx + 1, y + ky + 1) * fx;
            out[y * s->nx + x] =
                a * (1 - fy) + b * fy - ref_at(s, s->plan->cfg.ref, x, y);
        }
    }
}

static inline double ref_get(const plfx_frame_state *s, const double *p, int x, int y)
{
    return p[ref_clamp(y, 0, s->ny - 1) * s->nx + ref_clamp(x, 0, s->nx - 1)];
}

static inline void ref_add_cost(const plfx_frame_state *s, const double *d, double *sum)
{
    double t = s->cfg.trunc_q4 / 16.;
    double g = s->cfg.gtrunc_q4 / 16.;
    double w = s->cfg.gweight_q4 / 16.;
    int x;
    int y;

    for (y = 0; y < s->ny; y++) {
        for (x = 0; x < s->nx; x++) {
            double dx = ref_get(s, d, x + 1, y) - ref_get(s, d, x - 1, y);
            double dy = ref_get(s, d, x, y + 1) - ref_get(s, d, x, y - 1);
            sum[y * s->nx + x] += ref_dmin(fabs(d[y * s->nx + x]), t) +
                                  w * (ref_dmin(fabs(dx), g) + ref_dmin(fabs(dy), g));
        }
    }
}

static inline void ref_box(const plfx_frame_state *s, const double *in, double *out)
{
    int r = s->plan->cfg.window / 2;
    int x;
    int y;
    int i;
    int j;

    for (y = 0; y < s->ny; y++) {
        for (x = 0; x < s->nx; x++) {
            double sum = 0;
            for (j = -r; j <= r; j++) {
                for (i = -r; i <= r; i++) {
                    sum += ref_get(s, in, x + i, y + j);
                }
            }
            out[y * s->nx + x] = sum / ((2 * r + 1) * (2 * r + 1));
        }
    }
}

static inline int ref_by_double(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Mean cost of the kept arms at a label, least of 3x3, cut at half range. */
static inline void ref_slice(const plfx_frame_state *s, double d, double *out)
{
    size_t n = (size_t)s->nx * (size_t)s->ny;
    double *warp = calloc(n, sizeof *warp);
    double *sum = calloc(n, sizeof *sum);
    double *box = calloc(n * PLFX_ARMS_MAX, sizeof *box);
    double *cost = calloc(n, sizeof *cost);
    double half =
        (s->cfg.trunc_q4 + s->cfg.gtrunc_q4 * 2. * s->cfg.gweight_q4 / 16) / 32;
    int arms = 0;
    size_t i;
    int a;
    int k;

    for (a = 0; a < s->cfg.arms; a++) {
        if (s->arm_n[a] == 0) {
            continue;
        }
        memset(sum, 0, n * sizeof *sum);
        for (k = 0; k < s->n; k++) {
            if (s->arm_of[k] == a) {
                ref_warp(s, k, d, warp);
                ref_add_cost(s, warp, sum);
            }
        }
        ref_box(s, sum, box + (size_t)arms * n);
        for (i = 0; i < n; i++) {
            box[(size_t)arms * n + i] /= s->arm_n[a];
        }
        arms++;
    }
    for (i = 0; i < n; i++) {
        double v[PLFX_ARMS_MAX];
        for (a = 0; a < arms; a++) {
            v[a] = box[(size_t)a * n + i];
        }
        qsort(v, (size_t)arms, sizeof *v, ref_by_double);
        for (a = 0; a < s->keep; a++) {
            cost[i] += v[a] / s->keep;
        }
        cost[i] = ref_dmin(cost[i], half);
    }
    for (i = 0; i < n; i++) {
        out[i] = cost[i];
        for (k = 0; k < 9; k++) {
            out[i] = ref_dmin(out[i], ref_get(s, cost, (int)i % s->nx + k % 3 - 1,
                                              (int)i / s->nx + k / 3 - 1));
        }
    }
    free(warp);
    free(sum);
    free(box);
    free(cost);
}

/* Adds the path along (dx,dy) of volume[labels][ny][nx] to sum. */
static inline void ref_dpath(const plfx_frame_state *s, int dx, int dy,
                             const double *volume, double *sum)
{
    int n = s->labels;
    size_t pixels = (size_t)s->nx * (size_t)s->ny;
    double *path = calloc(pixels * (size_t)n, sizeof *path);
    double p1 = s->cfg.p1_q4 / 16.;
    int i;
    int l;

    for (i = 0; i < s->nx * s->ny; i++) {
        int x = dx >= 0 ? i % s->nx : s->nx - 1 - i % s->nx;
        int y = dy >= 0 ? i / s->nx : s->ny - 1 - i / s->nx;
        int px = x - dx;
        int py = y - dy;
        double *here = path + (size_t)(y * s->nx + x) * (size_t)n;
        const double *q = path + (size_t)(py * s->nx + px) * (size_t)n;
        int in = px >= 0 && px < s->nx && py >= 0 && py < s->ny;
        double p2 = 0;
        double m = 0;
        if (in) {
            double grey = fabs(ref_at(s, s->plan->cfg.ref, x, y) -
                               ref_at(s, s->plan->cfg.ref, px, py));
            p2 = s->cfg.p2_q4 / 16. / (1 + 16 * grey / s->cfg.soften_q4);
            p2 = p2 < 1.1 * p1 ? 1.1 * p1 : p2;
            m = q[0];
            for (l = 1; l < n; l++) {
                m = ref_dmin(m, q[l]);
            }
        }
        for (l = 0; l < n; l++) {
            double v = 0;
            if (in) {
                v = ref_dmin(q[l], m + p2);
                v = l > 0 ? ref_dmin(v, q[l - 1] + p1) : v;
                v = l < n - 1 ? ref_dmin(v, q[l + 1] + p1) : v;
            }
            here[l] = volume[(size_t)l * pixels + (size_t)(y * s->nx + x)] + v - m;
            sum[(size_t)l * pixels + (size_t)(y * s->nx + x)] += here[l];
        }
    }
    free(path);
}

/* e of the winner with its equiangular fit. */
static inline void ref_winner(const plfx_frame_state *s, const double *sum, double *e)
{
    const plfx_cfg *c = &s->plan->cfg;
    size_t n = (size_t)s->nx * (size_t)s->ny;
    size_t i;
    int l;

    for (i = 0; i < n; i++) {
        int best = 0;
        double f = 0;
        for (l = 1; l < s->labels; l++) {
            best = sum[(size_t)l * n + i] < sum[(size_t)best * n + i] ? l : best;
        }
        if (best > 0 && best < s->labels - 1) {
            double a = sum[(size_t)(best - 1) * n + i];
            double b = sum[(size_t)best * n + i];
            double d = sum[(size_t)(best + 1) * n + i];
            double rise = (a > d ? a : d) - b;
            f = rise > 0 ? (a - d) / (2 * rise) : 0;
        }
        e[i] = (c->slope_min_q16 + (best + f) *
                                       ((double)c->slope_max_q16 - c->slope_min_q16) /
                                       (s->labels - 1)) /
               65536 * s->base_q8 / 256;
    }
}

typedef struct ref_pair {
    double v, w;
} ref_pair;

static inline void ref_dmedian(const plfx_frame_state *s, int window, const double *in,
                               double *out)
{
    double h = s->cfg.similar_q4 / 16.;
    int x;
    int y;
    int k;

    for (y = 0; y < s->ny; y++) {
        for (x = 0; x < s->nx; x++) {
            ref_pair p[49];
            double total = 0;
            double sum = 0;
            for (k = 0; k < window * window; k++) {
                int xx = x + k % window - window / 2;
                int yy = y + k / window - window / 2;
                double d = ref_at(s, s->plan->cfg.ref, xx, yy) -
                           ref_at(s, s->plan->cfg.ref, x, y);
                double q = 1 - ref_dmin(d * d / (h * h), 1);
                p[k].v = ref_get(s, in, xx, yy);
                p[k].w = q * q;
                total += p[k].w;
            }
            qsort(p, (size_t)(window * window), sizeof *p, ref_by_double);
            for (k = 0; 2 * (sum + p[k].w) < total; k++) {
                sum += p[k].w;
            }
            out[y * s->nx + x] = p[k].v;
        }
    }
}

static inline const double *ref_table(int taps, double f)
{
    static double table[2][REF_PHASES + 1][6];
    static int ready[2];
    int which = taps == 6;
    int i;

    for (i = 0; !ready[which] && i <= REF_PHASES; i++) {
        ref_taps(taps, (double)i / REF_PHASES, table[which][i]);
    }
    ready[which] = 1;
    return table[which][(int)(f * REF_PHASES + 0.5)];
}

/* As ref_pixel(), with taps from a fine table. */
static inline ref_sums ref_dpixel(const plfx_frame_state *s, double e, int x, int y)
{
    const double d5[5] = {1. / 12, -8. / 12, 0, 8. / 12, -1. / 12};
    int n = s->cfg.taps;
    double limit = s->cfg.robust_q4;
    double gx = 0;
    double gy = 0;
    ref_sums t = {0, 0, 0, 0, 0};
    int k;
    int i;
    int j;

    for (k = 0; k < 5; k++) {
        gx += d5[k] * ref_sample(s, s->plan->cfg.ref, x + k - 2, y);
        gy += d5[k] * ref_sample(s, s->plan->cfg.ref, x, y + k - 2);
    }
    for (k = 0; k < s->n; k++) {
        double bx = s->bx_q16[k] / 65536.;
        double by = s->by_q16[k] / 65536.;
        int x0 = (int)floor(x + e * bx);
        int y0 = (int)floor(y + e * by);
        const double *tx;
        const double *ty;
        double v = 0;
        double g = bx * gx + by * gy;
        double q;
        if (s->arm_of[k] < 0 || x0 < n / 2 - 1 || y0 < n / 2 - 1 ||
            x0 > s->nx - 1 - n / 2 || y0 > s->ny - 1 - n / 2) {
            continue;
        }
        tx = ref_table(n, x + e * bx - x0);
        ty = ref_table(n, y + e * by - y0);
        for (j = 0; j < n; j++) {
            for (i = 0; i < n; i++) {
                v += ty[j] * tx[i] *
                     ref_sample(s, k, x0 + i - (n / 2 - 1), y0 + j - (n / 2 - 1));
            }
        }
        v -= ref_sample(s, s->plan->cfg.ref, x, y);
        q = 1 - v * v / (limit * limit);
        t.n++;
        if (q > 0) {
            t.a += q * q * g * g;
            t.b += q * q * g * v;
            t.r += q * q * v * v;
        }
    }
    return t;
}

static inline void ref_refine(const plfx_frame_state *s, const double *in, double *out)
{
    size_t n = (size_t)s->nx * (size_t)s->ny;
    ref_sums *t = calloc(n, sizeof *t);
    double gate = s->cfg.gate_q8 / 256.;
    double most = s->cfg.clamp_q8 / 256.;
    double prior = s->cfg.prior_q12 / 4096.;
    int r = s->cfg.window / 2;
    size_t i;
    int x;
    int y;

    for (i = 0; i < n; i++) {
        t[i] = ref_dpixel(s, in[i], (int)i % s->nx, (int)i / s->nx);
    }
    for (i = 0; i < n; i++) {
        ref_sums w = {0, 0, 0, 0, 0};
        double mean;
        double step;
        for (y = (int)i / s->nx - r; y <= (int)i / s->nx + r; y++) {
            for (x = (int)i % s->nx - r; x <= (int)i % s->nx + r; x++) {
                size_t q = (size_t)(y * s->nx + x);
                if (x >= 0 && y >= 0 && x < s->nx && y < s->ny &&
                    fabs(in[q] - in[i]) < gate) {
                    w.a += t[q].a;
                    w.b += t[q].a * (in[q] - in[i]) - t[q].b;
                    w.r += t[q].r;
                    w.n += t[q].n;
                }
            }
        }
        mean = w.n > 0 ? w.r / w.n : 0;
        mean = mean < 3.2 ? 3.2 : mean; /* (0.11 grey levels)^2 */
        step = w.b / (w.a + mean / (prior * prior));
        out[i] = in[i] + (step > most ? most : step < -most ? -most : step);
    }
    free(t);
}

/* Slope of every sample; the state is opened and loaded, its planes are not used. */
static inline void ref_frame(const plfx_frame_state *s, double *slope)
{
    static const int dir[8][2] = {{1, 0}, {-1, 0},  {0, 1},  {0, -1},
                                  {1, 1}, {-1, -1}, {1, -1}, {-1, 1}};
    size_t n = (size_t)s->nx * (size_t)s->ny;
    double *volume = calloc(n * (size_t)s->labels, sizeof *volume);
    double *sum = calloc(n * (size_t)s->labels, sizeof *sum);
    double *e = calloc(n, sizeof *e);
    double *f = calloc(n, sizeof *f);
    size_t i;
    int k;

    for (k = 0; k < s->labels; k++) {
        ref_slice(s, plfx_plan_slope_q16(s->plan, 16 * k) / 65536.,
                  volume + (size_t)k * n);
    }
    memcpy(sum, volume, n * (size_t)s->labels * sizeof *sum);
    if (s->cfg.paths == 8) {
        memset(sum, 0, n * (size_t)s->labels * sizeof *sum);
    }
    for (k = 0; k < s->cfg.paths; k++) {
        ref_dpath(s, dir[k][0], dir[k][1], volume, sum);
    }
    ref_winner(s, sum, e);
    if (s->cfg.median1) {
        ref_dmedian(s, s->cfg.median1, e, f);
        memcpy(e, f, n * sizeof *e);
    }
    for (k = 0; s->cfg.taps && k < s->cfg.passes; k++) {
        ref_refine(s, e, f);
        memcpy(e, f, n * sizeof *e);
    }
    if (s->cfg.median2) {
        ref_dmedian(s, s->cfg.median2, e, f);
        memcpy(e, f, n * sizeof *e);
    }
    for (i = 0; i < n; i++) {
        slope[i] = e[i] * 256 / s->base_q8;
    }
    free(volume);
    free(sum);
    free(e);
    free(f);
}

#endif
