/* SPDX-License-Identifier: MIT
 * Information of a patch: its 3 x 3 matrix, inverse, and standard errors. */
#include "roi_state.h"
#include "fix.h"

#include <string.h>

#define ONE_Q24  ((int64_t)1 << 24)
#define DET_Q24  ((int64_t)1 << 17) /* under 1/128 of independent axes: no texture */
#define SLOPE_DN 256                /* least rms gradient, 16-bit steps a lens */

typedef struct moments {
    int64_t gg[3][3];           /* sums of products, < 2^49 */
    int64_t bright[3], dark[3]; /* sums of g in the halves */
    int64_t ref[3];             /* sums of g*R */
} moments;

/* g of sample s of view k along columns, rows, slope. */
static void response(const plfx_roi *roi, const plfx_roi_patch *p, int32_t k, size_t s,
                     int64_t g[3])
{
    g[0] = p->gx[s];
    g[1] = p->gy[s];
    g[2] = plfx_round_shift_i64(g[0] * roi->lean_q12[k][0] + g[1] * roi->lean_q12[k][1],
                                12);
}

static void collect(const plfx_roi *roi, const plfx_roi_patch *p, moments *m)
{
    size_t n = (size_t)p->w * (size_t)p->h;
    int32_t view;
    size_t s;
    int32_t a;
    int32_t b;

    memset(m, 0, sizeof *m);
    for (view = 0; view < roi->cfg.views; view++) {
        for (s = n * (size_t)view; s < n * (size_t)(view + 1); s++) {
            int64_t g[3];
            if (p->ref[s] == PLFX_ROI_UNUSED) {
                continue;
            }
            response(roi, p, view, s, g);
            for (a = 0; a < 3; a++) {
                for (b = 0; b < 3; b++) {
                    m->gg[a][b] += g[a] * g[b];
                }
                m->ref[a] += g[a] * p->ref[s];
                if (p->ref[s] >= p->split) {
                    m->bright[a] += g[a];
                } else {
                    m->dark[a] += g[a];
                }
            }
        }
    }
}

static int32_t clamp27(int64_t v)
{
    return plfx_clamp_i32(plfx_sat_i32(v), -(1 << 27), 1 << 27);
}

/* What to take off g in the halves so that it sums to 0 alone and times R:
 *   A + B = sum g, A*mb + B*md = sum g*R, A = alpha*n_bright, B = beta*n_dark. */
static void project(plfx_roi_patch *p, const moments *m)
{
    int64_t mb = p->ref_bright * 16 / p->n_bright; /* the greatest sample is bright */
    int64_t md = p->ref_dark * 16 / (p->n_dark > 0 ? p->n_dark : 1);
    int32_t k;

    for (k = 0; k < 3; k++) {
        int64_t sum = m->bright[k] + m->dark[k];
        int64_t a = mb > md ? (m->ref[k] * 16 - sum * md) / (mb - md) : sum;
        p->alpha_q12[k] = 0;
        p->beta_q12[k] = 0;
        if (p->n_dark > 0) {
            p->alpha_q12[k] = clamp27(a * 4096 / p->n_bright);
            p->beta_q12[k] = clamp27((sum - a) * 4096 / p->n_dark);
        }
    }
}

/* v/(s_k*s_l) q24 of |v| < 2^54. */
static int64_t scaled(const plfx_roi_patch *p, int64_t v, int32_t k, int32_t l)
{
    return v * 256 / p->scale[k] * 65536 / p->scale[l];
}

/* Information scaled to unit diagonal, q24.  0 when an axis has none. */
static int32_t information(const plfx_roi *roi, plfx_roi_patch *p, const moments *m,
                           int64_t n_q24[3][3])
{
    int64_t n[3][3];
    int32_t axes = roi->rim_q8 > 0 ? 3 : 2;
    int32_t k;
    int32_t l;

    for (k = 0; k < 3; k++) {
        for (l = 0; l < 3; l++) {
            n[k][l] = 4 * (m->gg[k][l] - plfx_asr_i64(p->alpha_q12[k] * m->bright[l] +
                                                          p->beta_q12[k] * m->dark[l],
                                                      12));
        }
        p->scale[k] = 1;
        if (k < axes) {
            if (n[k][k] / p->used * 4 < SLOPE_DN * SLOPE_DN / (k == 2 ? 16 : 1)) {
                return 0;
            }
            p->scale[k] = (int64_t)plfx_roi_root((uint64_t)n[k][k]);
        }
    }
    for (k = 0; k < 3; k++) {
        for (l = 0; l < 3; l++) {
            n_q24[k][l] = k < axes && l < axes ? scaled(p, n[k][l], k, l)
                          : k == l             ? ONE_Q24
                                               : 0;
        }
    }
    return 1;
}

/* Inverse by cofactors; entries of n are under 2 in q24.  0 when nearly singular. */
static int32_t invert(const int64_t n[3][3], int32_t inv_q24[3][3])
{
    int64_t c[3][3];
    int64_t det = 0;
    int32_t k;
    int32_t l;

    for (k = 0; k < 3; k++) {
        for (l = 0; l < 3; l++) {
            int32_t k1 = (k + 1) % 3;
            int32_t k2 = (k + 2) % 3;
            int32_t l1 = (l + 1) % 3;
            int32_t l2 = (l + 2) % 3;
            c[k][l] = plfx_asr_i64(n[k1][l1] * n[k2][l2] - n[k1][l2] * n[k2][l1], 24);
        }
    }
    for (l = 0; l < 3; l++) {
        det += plfx_asr_i64(n[0][l] * c[0][l], 24);
    }
    if (det < DET_Q24) {
        return 0;
    }
    for (k = 0; k < 3; k++) {
        for (l = 0; l < 3; l++) { /* at most 2 * 128 */
            inv_q24[k][l] = clamp27(c[l][k] * ONE_Q24 / det);
        }
    }
    return 1;
}

/* Correlation of two views' noise by the pixels they share: two triangles convolved, a
 * cubic B-spline of the offset, 1 at 0; q12. */
static int64_t shared_q12(int32_t d_q8)
{
    int64_t t = 16 * (int64_t)plfx_max_i32(d_q8, -d_q8); /* q12 */
    int64_t r;

    if (t >= 8192) {
        return 0;
    }
    if (t >= 4096) {
        r = 8192 - t;
        return plfx_asr_i64(plfx_asr_i64(r * r, 12) * r, 14);
    }
    r = plfx_asr_i64(t * t, 12);
    return 4096 - 3 * r / 2 + 3 * plfx_asr_i64(r * t, 12) / 4;
}

static int64_t shared(const plfx_roi *roi, int32_t a, int32_t b)
{
    const plfx_offset *p = &roi->cfg.at[a];
    const plfx_offset *q = &roi->cfg.at[b];

    return a == b
               ? 4096
               : plfx_asr_i64(
                     shared_q12(p->u_q8 - q->u_q8) * shared_q12(p->v_q8 - q->v_q8), 12);
}

/* g less what the projection takes off. */
static void orthogonal(const plfx_roi *roi, const plfx_roi_patch *p, int32_t view,
                       size_t s, int64_t g[3])
{
    int32_t k;

    response(roi, p, view, s, g);
    for (k = 0; k < 3; k++) {
        g[k] -= plfx_round_shift_i64(
            p->ref[s] >= p->split ? p->alpha_q12[k] : p->beta_q12[k], 12);
    }
}

/* Covariance of the sums for unit noise of a sample: products of views a and b. */
static void spread_pair(const plfx_roi *roi, const plfx_roi_patch *p, int32_t a,
                        int32_t b, int64_t weight_q12, int64_t v[3][3])
{
    size_t n = (size_t)p->w * (size_t)p->h;
    int64_t part[3][3];
    size_t s;
    int32_t k;
    int32_t l;

    memset(part, 0, sizeof part);
    for (s = 0; s < n; s++) {
        size_t sa = n * (size_t)a + s;
        size_t sb = n * (size_t)b + s;
        int64_t ga[3];
        int64_t gb[3];
        if (p->ref[sa] == PLFX_ROI_UNUSED || p->ref[sb] == PLFX_ROI_UNUSED) {
            continue;
        }
        orthogonal(roi, p, a, sa, ga);
        orthogonal(roi, p, b, sb, gb);
        for (k = 0; k < 3; k++) {
            for (l = 0; l < 3; l++) {
                part[k][l] += ga[k] * gb[l]; /* < 2^32 * 2^11 */
            }
        }
    }
    for (k = 0; k < 3; k++) {
        for (l = 0; l < 3; l++) {
            v[k][l] += plfx_round_shift_i64(part[k][l] * weight_q12, 12);
        }
    }
}

/* Diagonal of inv * v * inv', q24. */
static int64_t sandwich(const int32_t inv_q24[3][3], const int64_t v_q24[3][3],
                        int32_t k)
{
    int64_t sum = 0;
    int32_t a;
    int32_t b;

    for (a = 0; a < 3; a++) {
        int64_t line = 0; /* 2^27 * 2^27 * 3 */
        for (b = 0; b < 3; b++) {
            line += v_q24[a][b] * inv_q24[k][b];
        }
        sum += plfx_asr_i64(plfx_asr_i64(line, 24) * inv_q24[k][a], 24);
    }
    return sum;
}

/* Standard errors of the three components for a covariance of the sums, q12. */
static void errors_of(const plfx_roi_patch *p, int64_t v[3][3], uint32_t out_q12[3])
{
    int32_t a;
    int32_t b;
    int32_t k;

    for (a = 0; a < 3; a++) {
        for (b = 0; b < 3; b++) {
            v[a][b] = scaled(p, v[a][b], a, b);
        }
    }
    for (k = 0; k < 3; k++) {
        int64_t q =
            sandwich((const int32_t(*)[3])p->inv_q24, (const int64_t(*)[3])v, k);
        out_q12[k] = plfx_roi_root(q > 0 ? (uint64_t)q : 0u);
    }
}

static void spread(const plfx_roi *roi, plfx_roi_patch *p)
{
    int64_t v[3][3];
    int32_t a;
    int32_t b;

    memset(v, 0, sizeof v);
    for (a = 0; a < roi->cfg.views; a++) {
        for (b = 0; b < roi->cfg.views; b++) {
            int64_t weight = shared(roi, a, b);
            if (weight > 0) {
                spread_pair(roi, p, a, b, weight, v);
            }
        }
    }
    errors_of(p, v, p->spread_q12);
}

/* Sums of lens s over the views: of g, of g orthogonal, and how many. */
typedef struct lens_sums {
    int32_t g[3], own[3], used; /* < 2^23 */
} lens_sums;

static void over_views(const plfx_roi *roi, const plfx_roi_patch *p, size_t s,
                       lens_sums *sum)
{
    size_t n = (size_t)p->w * (size_t)p->h;
    int32_t view;
    int32_t k;

    memset(sum, 0, sizeof *sum);
    for (view = 0; view < roi->cfg.views; view++) {
        size_t at = n * (size_t)view + s;
        int64_t g[3];
        int64_t own[3];
        if (p->ref[at] == PLFX_ROI_UNUSED) {
            continue;
        }
        response(roi, p, view, at, g);
        orthogonal(roi, p, view, at, own);
        for (k = 0; k < 3; k++) {
            sum->g[k] += (int32_t)g[k];
            sum->own[k] += (int32_t)own[k];
        }
        sum->used++;
    }
}

/* The same for an error of unit variance that is one number a lens: what the
 * interpolator misses of texture finer than two lenses is alike in all views.  Products
 * over the lenses < 2^57.  And the energy of a unit slope with x and y. */
static void spread_common(const plfx_roi *roi, plfx_roi_patch *p, const moments *m)
{
    size_t n = (size_t)p->w * (size_t)p->h;
    int64_t v[3][3];
    int64_t mean[2] = {0, 0};
    size_t s;
    int32_t k;
    int32_t l;

    memset(v, 0, sizeof v);
    for (s = 0; s < n; s++) {
        lens_sums sum;
        over_views(roi, p, s, &sum);
        for (k = 0; k < 3; k++) {
            for (l = 0; l < 3; l++) { /* a 256th: the sums divide by the scale */
                v[k][l] += plfx_asr_i64((int64_t)sum.own[k] * sum.own[l], 8);
            }
        }
        for (k = 0; k < 2 && sum.used > 0; k++) {
            mean[k] += (int64_t)sum.g[2] * sum.g[k] / sum.used;
        }
    }
    errors_of(p, v, p->common_q12);
    for (k = 0; k < 3; k++) {
        p->common_q12[k] =
            16u * (p->common_q12[k] < 1u << 27 ? p->common_q12[k] : 1u << 27);
    }
    for (k = 0; k < 2; k++) {
        p->all.cross[k + 1] = 16 * m->gg[2][k];
        p->apart.cross[k + 1] = 16 * (m->gg[2][k] - mean[k]);
    }
}

/* Share of a sample's noise that is not in the mean over the views. */
static int32_t own_noise(const plfx_roi *roi)
{
    int64_t sum = 0; /* < 2^12 * 97^2 */
    int32_t a;
    int32_t b;

    for (a = 0; a < roi->cfg.views; a++) {
        for (b = 0; b < roi->cfg.views; b++) {
            sum += shared(roi, a, b);
        }
    }
    return 4096 - (int32_t)(sum / ((int64_t)roi->cfg.views * roi->cfg.views));
}

void plfx_roi_inform(const plfx_roi *roi, plfx_roi_patch *p)
{
    int64_t n_q24[3][3];
    moments m;

    collect(roi, p, &m);
    project(p, &m);
    if (!information(roi, p, &m, n_q24) ||
        !invert((const int64_t(*)[3])n_q24, p->inv_q24)) {
        p->flags |= PLFX_ROI_TEXTURE;
        return;
    }
    spread(roi, p);
    spread_common(roi, p, &m);
    /* about a third of the samples are independent */
    p->chance_q12 = (int32_t)(30000u / plfx_roi_root((uint64_t)p->used));
    p->own_q12 = own_noise(roi);
}
