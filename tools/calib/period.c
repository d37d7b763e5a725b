/* SPDX-License-Identifier: MIT
 * Lattice steps by autocorrelation. */
#include "calib/period.h"

#include "calib/fft.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define N       512 /* samples of a block on a side */
#define HALF    (N / 2)
#define LAG_MIN 5.0   /* shortest step, samples */
#define LAG_MAX 176.0 /* longest */
#define PEAKS   400
#define SHORT   28   /* peaks that may span the lattice */
#define KEEP    0.75 /* of the best mean: a finer lattice is preferred */

/* Correlation at lags -HALF .. HALF-1, zero lag = 1; NAN where the window has run
 * out. */
typedef struct correlation {
    float *r;  /* [N][N], lag (dx,dy) at (dy & (N-1)) * N + (dx & (N-1)) */
    int reach; /* largest lag on an axis that counts */
} correlation;

typedef struct peak {
    plft_vec at;
    double height;
} peak;

static float at_lag(const correlation *c, int dx, int dy)
{
    return c->r[(dy & (N - 1)) * N + (dx & (N - 1))];
}

/* Mean of a bin x bin group of samples; clipped ones count as they are. */
static float binned(const plft_grey *g, int x, int y, int bin)
{
    uint32_t s = 0;
    int i, j;

    for (j = 0; j < bin; j++) {
        const uint16_t *row = g->px + (size_t)(y + j) * (size_t)g->w + x;
        for (i = 0; i < bin; i++) {
            s += row[i];
        }
    }
    return (float)s / (float)(bin * bin);
}

/* Put a block, its mean removed, tapered, into part `im` (0 or 1) of z. */
static void load(const plft_grey *g, int x0, int y0, int bin, int w, int h,
                 const float *taper_x, const float *taper_y, float *z, int im)
{
    double mean = 0.0;
    int x, y;

    for (y = 0; y < h; y++) {
        for (x = 0; x < w; x++) {
            float v = binned(g, x0 + x * bin, y0 + y * bin, bin);
            z[2 * (y * N + x) + im] = v;
            mean += v;
        }
    }
    mean /= (double)w * h;
    for (y = 0; y < h; y++) {
        for (x = 0; x < w; x++) {
            float *v = &z[2 * (y * N + x) + im];
            *v = (*v - (float)mean) * taper_x[x] * taper_y[y];
        }
    }
}

static void hann(float *taper, int n)
{
    int k;

    for (k = 0; k < n; k++) {
        taper[k] = 0.5f - 0.5f * (float)cos(6.28318530717958647693 * (k + 0.5) / n);
    }
}

/* Add the power of both parts of z, without the lowest frequencies. */
static void add_power(const float *z, float *power, double low)
{
    int x, y;

    for (y = 0; y < N; y++) {
        for (x = 0; x < N; x++) {
            int fx = x < HALF ? x : x - N, fy = y < HALF ? y : y - N;
            const float *p = z + 2 * (y * N + x);
            if ((double)fx * fx + (double)fy * fy > low * low) {
                power[y * N + x] += p[0] * p[0] + p[1] * p[1];
            }
        }
    }
}

/* Correlation of the taper with itself on one axis, zero lag 1. */
static void taper_lags(const float *taper, int n, float *lags)
{
    int d, k;

    for (d = 0; d < HALF; d++) {
        double s = 0.0;
        for (k = 0; k + d < n; k++) {
            s += (double)taper[k] * taper[k + d];
        }
        lags[d] = (float)s;
    }
    for (d = HALF - 1; d >= 0; d--) {
        lags[d] /= lags[0];
    }
}

static void to_correlation(const float *z, const float *lx, const float *ly,
                           correlation *c)
{
    const float r0 = z[0];
    int x, y;

    for (y = 0; y < N; y++) {
        for (x = 0; x < N; x++) {
            int dx = x < HALF ? x : N - x, dy = y < HALF ? y : N - y;
            float w = dx < HALF && dy < HALF ? lx[dx] * ly[dy] : 0.0f;
            c->r[y * N + x] = w > 0.04f ? z[2 * (y * N + x)] / (r0 * w) : NAN;
        }
    }
}

/* Amplitudes into z, less those of pixel noise: a blur of one sample. */
static void smooth_amplitude(const float *power, float *z)
{
    float blur[N];
    int k;

    for (k = 0; k < N; k++) {
        double f = (double)(k < HALF ? k : k - N) / N;
        blur[k] = (float)exp(-19.739208802178717 * f * f); /* 2 pi^2 */
    }
    for (k = 0; k < N * N; k++) {
        z[2 * k] = sqrtf(power[k]) * blur[k % N] * blur[k / N];
        z[2 * k + 1] = 0.0f;
    }
}

/* Blocks of w x h binned samples at the four quarters, two to a transform. */
static int correlate(const plft_grey *g, int bin, int w, int h, float *z, float *power,
                     correlation *c)
{
    float tx[N], ty[N], lx[HALF], ly[HALF];
    const int fx = g->w - w * bin, fy = g->h - h * bin;
    int k;

    hann(tx, w);
    hann(ty, h);
    memset(power, 0, sizeof(float) * N * N);
    for (k = 0; k < 2; k++) {
        int y0 = fy * (1 + 2 * k) / 4;
        memset(z, 0, sizeof(float) * 2 * N * N);
        load(g, fx / 4, y0, bin, w, h, tx, ty, z, 0);
        load(g, fx * 3 / 4, y0, bin, w, h, tx, ty, z, 1);
        if (plft_fft_square(z, N, -1) != 0) {
            return -1;
        }
        add_power(z, power, fmax(1.5, (double)N * bin / 200.0));
    }
    smooth_amplitude(power, z);
    if (plft_fft_square(z, N, 1) != 0 || !(z[0] > 0.0f)) {
        return -1;
    }
    taper_lags(tx, w, lx);
    taper_lags(ty, h, ly);
    to_correlation(z, lx, ly, c);
    return 0;
}

static int is_peak(const correlation *c, int dx, int dy)
{
    const float v = at_lag(c, dx, dy);
    int i, j;

    for (j = -1; j <= 1; j++) {
        for (i = -1; i <= 1; i++) {
            if ((i != 0 || j != 0) && !(at_lag(c, dx + i, dy + j) <= v)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Vertex of the parabolas through a peak and its neighbours. */
static peak refine(const correlation *c, int dx, int dy)
{
    float v = at_lag(c, dx, dy);
    double l = at_lag(c, dx - 1, dy), r = at_lag(c, dx + 1, dy);
    double u = at_lag(c, dx, dy - 1), d = at_lag(c, dx, dy + 1);
    peak p;

    p.at.x = dx + (2.0 * v - l - r > 0.0 ? 0.5 * (r - l) / (2.0 * v - l - r) : 0.0);
    p.at.y = dy + (2.0 * v - u - d > 0.0 ? 0.5 * (d - u) / (2.0 * v - u - d) : 0.0);
    p.height = v;
    return p;
}

static int by_height(const void *p, const void *q)
{
    double a = ((const peak *)p)->height, b = ((const peak *)q)->height;
    return a < b ? 1 : a > b ? -1 : 0;
}

static int by_length(const void *p, const void *q)
{
    const peak *a = p, *b = q;
    double d = hypot(a->at.x, a->at.y) - hypot(b->at.x, b->at.y);
    return d > 0.0 ? 1 : d < 0.0 ? -1 : 0;
}

/* The shorter ones of the high peaks of half the plane, shortest first. */
static int find_peaks(const correlation *c, peak *list)
{
    const int reach = c->reach < (int)LAG_MAX ? c->reach : (int)LAG_MAX;
    int x, y, n = 0, high = 0;

    for (y = 0; y <= reach; y++) {
        for (x = -reach; x <= reach; x++) {
            double r = hypot(x, y);
            if ((y == 0 && x <= 0) || r < LAG_MIN || r > LAG_MAX ||
                !(at_lag(c, x, y) > 0.02f) || !is_peak(c, x, y)) {
                continue;
            }
            if (n == PEAKS) { /* keep the higher half */
                qsort(list, (size_t)n, sizeof *list, by_height);
                n = PEAKS / 2;
            }
            list[n++] = refine(c, x, y);
        }
    }
    qsort(list, (size_t)n, sizeof *list, by_height);
    while (high < n && list[high].height > 0.3 * list[0].height) {
        high++;
    }
    qsort(list, (size_t)high, sizeof *list, by_length);
    return high < SHORT ? high : SHORT;
}

/* Highest correlation within one sample of a lag; NAN when it is out of reach. */
static double near_lag(const correlation *c, plft_vec at, int *px, int *py)
{
    int x0 = (int)floor(at.x + 0.5), y0 = (int)floor(at.y + 0.5), i, j;
    double best = NAN;

    if (abs(x0) >= c->reach || abs(y0) >= c->reach) {
        return NAN;
    }
    for (j = -1; j <= 1; j++) {
        for (i = -1; i <= 1; i++) {
            double v = at_lag(c, x0 + i, y0 + j);
            if (v > best || (isnan(best) && !isnan(v))) {
                best = v;
                *px = x0 + i;
                *py = y0 + j;
            }
        }
    }
    return best;
}

/* Least-squares v1, v2 from the peaks at m*v1 + n*v2, |m|, |n| <= order; returns their
 * mean correlation. */
static double fit_steps(const correlation *c, int order, plft_vec *v1, plft_vec *v2)
{
    double mm = 0, mn = 0, nn = 0, det, sum = 0;
    plft_vec m1 = {0, 0}, m2 = {0, 0};
    int m, n, count = 0;

    for (n = 0; n <= order; n++) {
        for (m = n == 0 ? 1 : -order; m <= order; m++) {
            plft_vec at = {m * v1->x + n * v2->x, m * v1->y + n * v2->y};
            int px = 0, py = 0;
            double v = near_lag(c, at, &px, &py);
            peak p;
            if (isnan(v) || hypot(at.x, at.y) > 1.2 * LAG_MAX) {
                continue;
            }
            sum += v;
            count++;
            if (!is_peak(c, px, py)) {
                continue;
            }
            p = refine(c, px, py);
            mm += m * m;
            mn += m * n;
            nn += n * n;
            m1.x += m * p.at.x;
            m1.y += m * p.at.y;
            m2.x += n * p.at.x;
            m2.y += n * p.at.y;
        }
    }
    det = mm * nn - mn * mn;
    if (det > 0.5) {
        v1->x = (nn * m1.x - mn * m2.x) / det;
        v1->y = (nn * m1.y - mn * m2.y) / det;
        v2->x = (mm * m2.x - mn * m1.x) / det;
        v2->y = (mm * m2.y - mn * m1.y) / det;
    }
    return count >= 3 ? sum / count : 0.0;
}

static double spread(const correlation *c)
{
    double s = 0, s2 = 0;
    int x, y, n = 0;

    for (y = 0; y < c->reach; y++) {
        for (x = -c->reach + 1; x < c->reach; x++) {
            double v = at_lag(c, x, y);
            if (!isnan(v) && hypot(x, y) > LAG_MIN) {
                s += v;
                s2 += v * v;
                n++;
            }
        }
    }
    return n > 0 ? sqrt(fmax(0.0, s2 / n - s / n * (s / n))) : 0.0;
}

/* Among the pairs of short peaks, the finest lattice nearly as good as the best. */
static int choose(const correlation *c, plft_period *p)
{
    peak list[PEAKS];
    int n = find_peaks(c, list), i, j, found = 0, pass;
    double best = 0.0, area = HUGE_VAL;

    for (pass = 0; pass < 2; pass++) { /* 0: the best mean; 1: the finest near it */
        for (i = 0; i < n; i++) {
            for (j = i + 1; j < n; j++) {
                plft_vec a = list[i].at, b = list[j].at;
                double s, cross = fabs(a.x * b.y - a.y * b.x);
                if (cross < 0.5 * hypot(a.x, a.y) * hypot(b.x, b.y)) {
                    continue;
                }
                plft_basis_reduce(&a, &b);
                if (hypot(a.x, a.y) < LAG_MIN) {
                    continue;
                }
                s = fit_steps(c, 2, &a, &b);
                if (pass == 0) {
                    best = fmax(best, s);
                } else if (s >= KEEP * best && s > 0.0 && cross < 0.97 * area) {
                    area = cross;
                    p->v1 = a;
                    p->v2 = b;
                    p->strength = s;
                    found = 1;
                }
            }
        }
    }
    if (found) {
        p->strength = fit_steps(c, 3, &p->v1, &p->v2);
        fit_steps(c, 5, &p->v1, &p->v2);
        plft_basis_reduce(&p->v1, &p->v2);
        p->rest = spread(c);
    }
    return found ? 0 : -1;
}

static int find_at(const plft_grey *g, int bin, float *z, float *power, plft_period *p)
{
    correlation c;
    int w = g->w / bin < N ? g->w / bin : N, h = g->h / bin < N ? g->h / bin : N;
    int status = -1;

    if (w < 24 || h < 24) {
        return -1;
    }
    c.r = malloc(sizeof(float) * N * N);
    c.reach = (w < h ? w : h) * 2 / 3;
    c.reach = c.reach < HALF - 2 ? c.reach : HALF - 2;
    if (c.r != NULL && correlate(g, bin, w, h, z, power, &c) == 0 &&
        choose(&c, p) == 0) {
        p->v1.x *= bin;
        p->v1.y *= bin;
        p->v2.x *= bin;
        p->v2.y *= bin;
        status = 0;
    }
    free(c.r);
    return status;
}

int plft_period_find(const plft_grey *g, plft_period *period)
{
    float *z = malloc(sizeof(float) * 2 * N * N);
    float *power = malloc(sizeof(float) * N * N);
    plft_period fine, coarse;
    int has_fine, has_coarse = 0;

    if (z == NULL || power == NULL) {
        free(z);
        free(power);
        return -1;
    }
    has_fine = find_at(g, 1, z, power, &fine) == 0;
    if (!has_fine || fine.strength < 0.4 || hypot(fine.v1.x, fine.v1.y) > 50.0) {
        has_coarse = find_at(g, 4, z, power, &coarse) == 0;
    }
    free(z);
    free(power);
    if (has_coarse && (!has_fine || coarse.strength * fine.rest >
                                        1.3 * fine.strength * coarse.rest)) {
        *period = coarse;
    } else if (has_fine) {
        *period = fine;
    }
    return has_fine || has_coarse ? 0 : -1;
}
