/* SPDX-License-Identifier: MIT
 * Least squares of lens centres. */
#include "calib/model.h"

#include "calib/linalg.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define K      PLFT_TERMS
#define WHOLE  0.85f /* part of the disc that a whole micro-image shows */
#define ENOUGH 60    /* whole ones that do without the others */
#define ODD_MIN                                                                        \
    0.015 /* px: a smaller shift of odd rows may be the pixel grid's doing */

/* Sums of one pass over the field. */
typedef struct sums {
    double g[K * K], rx[K], ry[K]; /* weighted */
    int n;
} sums;

static void terms(const plft_model *m, int i, int j, double f[K])
{
    const int odd = m->kind == PLFX_LATTICE_HEX && j % 2 != 0;
    const double s = (i + (odd ? 0.5 : 0.0) - m->ic) / m->scale;
    const double t = (j - m->jc) / m->scale;

    f[0] = 1.0;
    f[1] = s;
    f[2] = t;
    f[3] = odd ? 0.5 : -0.5;
    f[4] = s * s;
    f[5] = s * t;
    f[6] = t * t;
    f[7] = s * s * s;
    f[8] = s * s * t;
    f[9] = s * t * t;
    f[10] = t * t * t;
}

static void row_of(const double c[K], double t, double odd, double out[4])
{
    out[0] = c[0] + odd * c[3] + t * (c[2] + t * (c[6] + t * c[10]));
    out[1] = c[1] + t * (c[5] + t * c[9]);
    out[2] = c[4] + t * c[8];
    out[3] = c[7];
}

void plft_model_row(const plft_model *m, int j, plft_row *r)
{
    const int odd = m->kind == PLFX_LATTICE_HEX && j % 2 != 0;
    const double t = (j - m->jc) / m->scale;

    r->step = 1.0 / m->scale;
    r->start = ((odd ? 0.5 : 0.0) - m->ic) * r->step;
    row_of(m->cx, t, odd ? 0.5 : -0.5, r->x);
    row_of(m->cy, t, odd ? 0.5 : -0.5, r->y);
}

static plft_vec along(const plft_row *r, int i)
{
    const double s = r->start + i * r->step;
    plft_vec p;

    p.x = r->x[0] + s * (r->x[1] + s * (r->x[2] + s * r->x[3]));
    p.y = r->y[0] + s * (r->y[1] + s * (r->y[2] + s * r->y[3]));
    return p;
}

plft_vec plft_row_at(const plft_row *r, int i)
{
    return along(r, i);
}

plft_vec plft_model_at(const plft_model *m, int i, int j)
{
    plft_row r;

    plft_model_row(m, j, &r);
    return along(&r, i);
}

double plft_model_sigma(const plft_model *m, int i, int j)
{
    double f[K], cf[K], s = 0.0;
    int k;

    terms(m, i, j, f);
    plft_mat_vec(m->cov, f, K, cf);
    for (k = 0; k < K; k++) {
        s += f[k] * cf[k];
    }
    return sqrt(fmax(0.0, s));
}

void plft_model_from_lattice(plft_model *m, const plft_lattice *l, double scale)
{
    memset(m, 0, sizeof *m);
    m->kind = l->kind;
    m->terms = 3;
    m->order = 1;
    m->scale = scale;
    m->use[0] = m->use[1] = m->use[2] = 1;
    m->cx[0] = l->origin.x;
    m->cy[0] = l->origin.y;
    m->cx[1] = l->a.x * scale;
    m->cy[1] = l->a.y * scale;
    m->cx[2] = l->b.x * scale;
    m->cy[2] = l->b.y * scale;
}

static int takes_part(const plft_model *m, const plft_spot *s)
{
    return (s->flags & (PLFX_LENS_MISSING | PLFX_LENS_INTERP)) == 0u &&
           s->seen >= m->whole;
}

/* Micro-images cut by the border of the sensor do not shape the model when there are
 * enough whole ones. */
static void ask_for_whole(plft_model *m, const plft_field *f)
{
    int k, n = 0;

    m->whole = WHOLE;
    for (k = 0; k < f->nx * f->ny; k++) {
        n += takes_part(m, &f->spot[k]);
    }
    m->whole = n >= ENOUGH ? WHOLE : 0.0f;
}

/* Normalise columns and rows to -1 .. 1 over the spots that take part. */
static int normalise(plft_model *m, const plft_field *f)
{
    int i, j, i1 = -1, j1 = -1, i0 = f->nx, j0 = f->ny;

    for (j = 0; j < f->ny; j++) {
        for (i = 0; i < f->nx; i++) {
            if (takes_part(m, &f->spot[j * f->nx + i])) {
                i0 = i < i0 ? i : i0;
                i1 = i > i1 ? i : i1;
                j0 = j < j0 ? j : j0;
                j1 = j > j1 ? j : j1;
            }
        }
    }
    m->ic = f->i0 + 0.5 * (i0 + i1);
    m->jc = f->j0 + 0.5 * (j0 + j1);
    m->scale = 0.5 * fmax(i1 - i0, j1 - j0);
    return i1 > i0 && j1 > j0 ? 0 : -1;
}

static double weight_of(const plft_spot *s, double tau)
{
    return 1.0 / ((double)s->sigma * s->sigma + tau * tau + 1e-8);
}

static void accumulate(const plft_model *m, const plft_field *f, double tau, sums *s)
{
    int i, j, p, q;

    memset(s, 0, sizeof *s);
    for (j = 0; j < f->ny; j++) {
        for (i = 0; i < f->nx; i++) {
            const plft_spot *spot = &f->spot[j * f->nx + i];
            double t[K], w;
            if (!takes_part(m, spot)) {
                continue;
            }
            terms(m, f->i0 + i, f->j0 + j, t);
            w = weight_of(spot, tau);
            for (p = 0; p < K; p++) {
                for (q = 0; q <= p; q++) {
                    s->g[p * K + q] += w * t[p] * t[q];
                }
                s->rx[p] += w * t[p] * spot->x;
                s->ry[p] += w * t[p] * spot->y;
            }
            s->n++;
        }
    }
    for (p = 0; p < K; p++) {
        for (q = 0; q < p; q++) {
            s->g[q * K + p] = s->g[p * K + q];
        }
    }
}

/* Solve for the terms in m->use; coefficients of the others become 0.  0, or -1. */
static int solve(plft_model *m, const sums *s)
{
    double g[K * K], rx[K], ry[K], x[K], y[K];
    int at[K], n = 0, p, q;

    for (p = 0; p < K; p++) {
        if (m->use[p]) {
            at[n++] = p;
        }
        m->cx[p] = m->cy[p] = 0.0;
    }
    for (p = 0; p < n; p++) {
        for (q = 0; q < n; q++) {
            g[p * n + q] = s->g[at[p] * K + at[q]];
        }
        rx[p] = s->rx[at[p]];
        ry[p] = s->ry[at[p]];
    }
    if (plft_spd_invert(g, n) != 0) {
        return -1;
    }
    plft_mat_vec(g, rx, n, x);
    plft_mat_vec(g, ry, n, y);
    memset(m->cov, 0, sizeof m->cov);
    for (p = 0; p < n; p++) {
        m->cx[at[p]] = x[p];
        m->cy[at[p]] = y[p];
        for (q = 0; q < n; q++) {
            m->cov[at[p] * K + at[q]] = g[p * n + q];
        }
    }
    m->terms = n;
    m->lenses = s->n;
    return 0;
}

/* Weighted and plain squares of the residuals, and the spots' expected variance. */
static double chi_square(const plft_model *m, const plft_field *f, double tau,
                         double *squares, double *expected)
{
    double chi = 0.0;
    int i, j;

    *squares = *expected = 0.0;
    for (j = 0; j < f->ny; j++) {
        plft_row row;
        plft_model_row(m, f->j0 + j, &row);
        for (i = 0; i < f->nx; i++) {
            const plft_spot *s = &f->spot[j * f->nx + i];
            plft_vec p;
            double r2;
            if (!takes_part(m, s)) {
                continue;
            }
            p = along(&row, f->i0 + i);
            r2 = (s->x - p.x) * (s->x - p.x) + (s->y - p.y) * (s->y - p.y);
            chi += r2 * weight_of(s, tau);
            *squares += r2;
            *expected += 2.0 * (double)s->sigma * s->sigma;
        }
    }
    return chi;
}

static void use_terms(plft_model *m, int order, int odd)
{
    int k;

    for (k = 0; k < K; k++) {
        m->use[k] = k < 3 || (k == 3 && odd) || (k > 3 && k <= 6 && order >= 2) ||
                    (k > 6 && order >= 3);
    }
    m->order = order;
}

/* The terms that the Bayes information criterion picks. */
static int pick_terms(plft_model *m, const plft_field *f, const sums *s, double tau,
                      int order)
{
    double best = HUGE_VAL, squares, expected;
    int o, odd, best_order = 0, best_odd = 0, n = 2 * s->n;

    for (o = 1; o <= order; o++) {
        for (odd = 0; odd <= (m->kind == PLFX_LATTICE_HEX); odd++) {
            double bic;
            use_terms(m, o, odd);
            if (solve(m, s) != 0 || n <= 2 * m->terms + 8) {
                continue;
            }
            bic = n * log(chi_square(m, f, tau, &squares, &expected) / n) +
                  2.0 * m->terms * log((double)n);
            if (bic < best) {
                best = bic;
                best_order = o;
                best_odd = odd;
            }
        }
    }
    if (best_order == 0) {
        return -1;
    }
    use_terms(m, best_order, best_odd);
    if (solve(m, s) != 0) {
        return -1;
    }
    if (best_odd && hypot(m->cx[3], m->cy[3]) < ODD_MIN) {
        use_terms(m, best_order, 0);
        return solve(m, s);
    }
    return 0;
}

/* Squared distance of every spot from the model. */
static void distances(const plft_model *m, const plft_field *f, double *d)
{
    int i, j;

    for (j = 0; j < f->ny; j++) {
        plft_row row;
        plft_model_row(m, f->j0 + j, &row);
        for (i = 0; i < f->nx; i++) {
            const plft_spot *s = &f->spot[j * f->nx + i];
            const plft_vec p = along(&row, f->i0 + i);
            *d++ = (s->x - p.x) * (s->x - p.x) + (s->y - p.y) * (s->y - p.y);
        }
    }
}

/* Flag what is beyond cut robust deviations (1.48 medians of the distance ratio of a
 * plane normal law, 1.1774); returns how many flags changed. */
static int flag_outliers(const plft_model *m, const plft_field *f, double cut)
{
    const int n = f->nx * f->ny;
    double *d = calloc(2u * (size_t)n, sizeof *d), limit;
    int k, count = 0, changed = 0;

    if (d == NULL) {
        return 0;
    }
    distances(m, f, d);
    for (k = 0; k < n; k++) {
        if (takes_part(m, &f->spot[k])) {
            d[n + count++] = d[k];
        }
    }
    limit = cut * sqrt(plft_median(d + n, count)) / 1.1774;
    for (k = 0; k < n; k++) {
        plft_spot *s = &f->spot[k];
        uint8_t flags = (uint8_t)(s->flags & ~PLFX_LENS_INTERP);
        /* A border lens may be worse than most. */
        const double own = cut * (double)s->sigma;
        const double most = (own > limit ? own : limit) + 1e-3;
        if (d[k] > most * most) {
            flags |= PLFX_LENS_INTERP;
        }
        if ((s->flags & PLFX_LENS_MISSING) == 0u && flags != s->flags) {
            s->flags = flags;
            changed++;
        }
    }
    free(d);
    return changed;
}

/* Residual figures; what the spots' sigmas leave unexplained becomes tau. */
static void measure(plft_model *m, const plft_field *f)
{
    double squares, expected, chi, free_axes;
    int k;

    chi_square(m, f, 0.0, &squares, &expected);
    free_axes = fmax(2.0 * m->lenses - 2.0 * m->terms, 1.0);
    m->rms = sqrt(squares / free_axes);
    m->tau = sqrt(fmax(0.0, squares / free_axes - expected / (2.0 * m->lenses)));
    chi = chi_square(m, f, m->tau, &squares, &expected);
    m->chi = sqrt(chi / free_axes);
    for (k = 0; k < K * K; k++) {
        m->cov[k] *= m->chi * m->chi;
    }
}

int plft_model_fit(plft_model *m, const plft_field *f, int order, double cut)
{
    double tau = 0.0;
    sums s;
    int round;

    m->kind = f->kind;
    ask_for_whole(m, f);
    for (round = 0; round < 5; round++) {
        int changed;
        if (normalise(m, f) != 0) {
            return -1;
        }
        accumulate(m, f, tau, &s);
        if (s.n < 9 || pick_terms(m, f, &s, tau, s.n < 60 ? 1 : order) != 0) {
            return -1;
        }
        measure(m, f);
        tau = m->tau;
        changed = flag_outliers(m, f, cut);
        if (round > 0 && changed * 1000 <= s.n) {
            break;
        }
    }
    return 0;
}

void plft_model_lattice(const plft_model *m, const plft_field *f, plft_lattice *l)
{
    double g[9] = {0}, rx[3] = {0}, ry[3] = {0}, x[3], y[3];
    int i, j, p, q;

    for (j = f->j0; j < f->j0 + f->ny; j++) {
        for (i = f->i0; i < f->i0 + f->nx; i++) {
            const int odd = m->kind == PLFX_LATTICE_HEX && j % 2 != 0;
            const double t[3] = {1.0, i + (odd ? 0.5 : 0.0), j};
            plft_vec at = plft_model_at(m, i, j);
            at.x -= odd ? m->cx[3] : 0.0;
            at.y -= odd ? m->cy[3] : 0.0;
            for (p = 0; p < 3; p++) {
                rx[p] += t[p] * at.x;
                ry[p] += t[p] * at.y;
                for (q = 0; q < 3; q++) {
                    g[3 * p + q] += t[p] * t[q];
                }
            }
        }
    }
    if (plft_spd_invert(g, 3) != 0) {
        return;
    }
    plft_mat_vec(g, rx, 3, x);
    plft_mat_vec(g, ry, 3, y);
    l->kind = m->kind;
    l->origin.x = x[0];
    l->origin.y = y[0];
    l->a.x = x[1];
    l->a.y = y[1];
    l->b.x = x[2];
    l->b.y = y[2];
    l->odd.x = m->kind == PLFX_LATTICE_HEX ? 0.5 * x[1] + m->cx[3] : 0.0;
    l->odd.y = m->kind == PLFX_LATTICE_HEX ? 0.5 * y[1] + m->cy[3] : 0.0;
}
