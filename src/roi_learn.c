/* SPDX-License-Identifier: MIT
 * The rest state becomes gradients, a table of what known displacements read, and the
 * noise. */
#include "roi_state.h"
#include "fix.h"

#include <string.h>

#define QUARTER 16384  /* a quarter of a lens, q16 */
#define CROWDED 16     /* times the patch's greatest scatter over the views */
#define FULL    65440u /* a mean rest sample from here on was clipped at times */

static int32_t wide_w(const plfx_roi_patch *p)
{
    return p->w + 2 * PLFX_ROI_MARGIN;
}

static int32_t wide_h(const plfx_roi_patch *p)
{
    return p->h + 2 * PLFX_ROI_MARGIN;
}

/* Sums of 12-bit samples to mean 16-bit samples, and the noise of one frame: scatter of
 * the frames about their mean. */
static void average(const plfx_roi *roi, plfx_roi_patch *p)
{
    size_t n = (size_t)roi->cfg.views * (size_t)p->w * (size_t)p->h;
    size_t all = (size_t)roi->cfg.views * (size_t)wide_w(p) * (size_t)wide_h(p);
    uint32_t frames = (uint32_t)roi->cfg.rest;
    uint64_t square = 0;
    size_t s;

    for (s = 0; s < all; s++) {
        uint32_t sum = p->wide[s]; /* <= 16 * 4095 */
        int32_t x = (int32_t)(s % (size_t)wide_w(p));
        int32_t y = (int32_t)(s / (size_t)wide_w(p) % (size_t)wide_h(p));
        if (plfx_roi_within(p, x, y)) {
            square += (uint64_t)sum * sum;
        }
        p->wide[s] = (uint16_t)((sum * 16u + frames / 2u) / frames);
    }
    p->noise_q8 = 0;
    if (frames > 1u) { /* squares < 2^32 * 2^19 */
        int64_t scatter = p->rest_square - (int64_t)(square / frames);
        scatter = scatter > 0 ? scatter : 0;
        p->noise_q8 =
            /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): two frames at least */
            scatter * 256 / (int64_t)(n * (frames - 1u)) * 256 + 256 * 256 / 12;
    }
}

static uint32_t lens_flags(const plfx_roi *roi, const plfx_roi_patch *p, int32_t x,
                           int32_t y)
{
    return roi->cfg.lut ? plfx_lut_flags(roi->cfg.lut, p->i0 + x, p->j0 + y) : 0u;
}

/* A missing lens takes the mean of its neighbours in the row: the interpolator reads
 * it. */
static void mend(const plfx_roi *roi, plfx_roi_patch *p)
{
    int32_t w = wide_w(p);
    int32_t h = wide_h(p);
    int32_t k;
    int32_t y;
    int32_t x;

    for (y = 0; y < h; y++) {
        for (x = 0; x < w; x++) {
            if (lens_flags(roi, p, x - PLFX_ROI_MARGIN, y - PLFX_ROI_MARGIN) &
                PLFX_LENS_MISSING) {
                for (k = 0; k < roi->cfg.views; k++) {
                    uint16_t *row = p->wide + (size_t)(k * h + y) * (size_t)w;
                    uint32_t a = row[plfx_max_i32(x - 1, 0)];
                    uint32_t b = row[plfx_min_i32(x + 1, w - 1)];
                    row[x] = (uint16_t)((a + b) / 2u);
                }
            }
        }
    }
}

/* Reference samples; unused where clipped or without a lens. */
static void reference(const plfx_roi *roi, plfx_roi_patch *p)
{
    int32_t w = wide_w(p);
    int32_t h = wide_h(p);
    int32_t weak = 0;
    int32_t k;
    int32_t y;
    int32_t x;

    for (y = 0; y < p->h; y++) {
        for (x = 0; x < p->w; x++) {
            uint32_t flags = lens_flags(roi, p, x, y);
            weak += (flags & (PLFX_LENS_MISSING | PLFX_LENS_DIM)) != 0;
            for (k = 0; k < roi->cfg.views; k++) {
                uint32_t v = p->wide[(size_t)(k * h + y + PLFX_ROI_MARGIN) * (size_t)w +
                                     (size_t)(x + PLFX_ROI_MARGIN)];
                int32_t out = v >= FULL || (flags & PLFX_LENS_MISSING);
                p->ref[(size_t)(k * p->h + y) * (size_t)p->w + (size_t)x] =
                    (uint16_t)(out ? PLFX_ROI_UNUSED : v);
            }
        }
    }
    if (weak * 8 > p->w * p->h) {
        p->flags |= PLFX_ROI_LENS;
    }
}

/* g = R(. - 1/4) - R(. + 1/4), halved: a quarter of the response to a lens. */
static void gradients(const plfx_roi *roi, plfx_roi_patch *p)
{
    uint16_t plus[PLFX_ROI_SIDE];
    uint16_t minus[PLFX_ROI_SIDE];
    int32_t k;
    int32_t y;
    int32_t x;
    int32_t axis;

    for (k = 0; k < roi->cfg.views; k++) {
        for (y = 0; y < p->h; y++) {
            for (axis = 0; axis < 2; axis++) {
                int16_t *g =
                    (axis ? p->gy : p->gx) + (size_t)(k * p->h + y) * (size_t)p->w;
                int32_t dx = axis ? 0 : QUARTER;
                int32_t dy = axis ? QUARTER : 0;
                plfx_roi_warp(p, k, y, dx, dy, plus);
                plfx_roi_warp(p, k, y, -dx, -dy, minus);
                for (x = 0; x < p->w; x++) { /* +-32767 */
                    g[x] = (int16_t)(((int32_t)plus[x] - minus[x]) / 2);
                }
            }
        }
    }
}

/* Counts and sums of the bright and the dark half; split at the mean. */
static void halves(const plfx_roi *roi, plfx_roi_patch *p)
{
    size_t n = (size_t)roi->cfg.views * (size_t)p->w * (size_t)p->h;
    uint64_t sum = 0;
    size_t s;

    p->used = 0;
    p->n_bright = 0;
    p->n_dark = 0;
    p->ref_bright = 0;
    p->ref_dark = 0;
    p->all.ref = 0;
    for (s = 0; s < n; s++) {
        if (p->ref[s] != PLFX_ROI_UNUSED) {
            sum += p->ref[s];
            p->used++;
        }
    }
    p->split = p->used ? (uint32_t)(sum / (uint64_t)p->used) : 0u;
    for (s = 0; s < n; s++) {
        int64_t v = p->ref[s];
        if (p->ref[s] == PLFX_ROI_UNUSED) {
            continue;
        }
        p->all.ref += v * v;
        if (v >= (int64_t)p->split) {
            p->n_bright++;
            p->ref_bright += v;
        } else {
            p->n_dark++;
            p->ref_dark += v;
        }
    }
}

/* Sum of (row - R)*R. */
static int64_t products(const plfx_roi_patch *p, int32_t k, int32_t y,
                        const uint16_t *row)
{
    const uint16_t *ref = p->ref + (size_t)(k * p->h + y) * (size_t)p->w;
    int64_t sum = 0;
    int32_t x;

    for (x = 0; x < p->w; x++) {
        if (ref[x] != PLFX_ROI_UNUSED) {
            sum += ((int64_t)row[x] - ref[x]) * ref[x];
        }
    }
    return sum;
}

/* Sums of the rest state displaced by (x, y) and slope z; product: of differences times
 * R, and the part of it that lies apart. */
static void sums_of(const plfx_roi *roi, const plfx_roi_patch *p,
                    const int32_t at_q16[3], plfx_roi_sums *all, int64_t product[2])
{
    uint16_t row[PLFX_ROI_SIDE];
    plfx_roi_sums view;
    plfx_roi_shared shared;
    size_t at = 0;
    int32_t k;

    product[0] = 0;
    memset(&view, 0, sizeof view);
    memset(all, 0, sizeof *all);
    memset(roi->lens, 0, (size_t)p->w * (size_t)p->h * sizeof *roi->lens);
    for (k = 0; k < roi->cfg.views; k++) {
        int32_t dx = at_q16[0] + at_q16[2] * roi->lean_q12[k][0] / 4096;
        int32_t dy = at_q16[1] + at_q16[2] * roi->lean_q12[k][1] / 4096;
        int32_t y;
        for (y = 0; y < p->h; y++) {
            plfx_roi_warp(p, k, y, dx, dy, row);
            plfx_roi_add(p, at, row, &view, roi->lens + y * p->w);
            product[0] += products(p, k, y, row);
            at += (size_t)p->w;
        }
        plfx_roi_close(roi->lean_q12[k], &view, all);
    }
    shared = plfx_roi_share(roi, p, roi->lens, 1);
    all->apart = all->energy - shared.square;
    product[1] = product[0] - shared.product;
}

/* Node m, or of a unit slope by a quarter of it to both sides. */
static void keep(plfx_roi_energies *e, int32_t used, int32_t m, int32_t z_q16,
                 int64_t square, int64_t product)
{
    if (z_q16 == 0) {
        e->square[m] = (int32_t)(square / used / 4);    /* < 2^30 */
        e->product[m] = (int32_t)(product / used / 16); /* |.| < 2^28 */
    } else if (m == PLFX_ROI_NODES / 2) {
        e->cross[0] += 8 * square;
        e->lean += 8 * product;
    }
}

/* What the rest state reads when displaced to node m and slope z. */
static void read_node(const plfx_roi *roi, plfx_roi_patch *p, int32_t m, int32_t z_q16,
                      int32_t out_q24[3])
{
    plfx_roi_sums s;
    const int32_t at_q16[3] = {(m % 5 - 2) * QUARTER, (m / 5 - 2) * QUARTER, z_q16};
    int64_t product[2];
    plfx_roi_light l;

    sums_of(roi, p, at_q16, &s, product);
    l = plfx_roi_light_of(p, &s);
    plfx_roi_linear(p, &s, l.gain_q20, out_q24);
    keep(&p->all, p->used, m, z_q16, s.energy, product[0]);
    keep(&p->apart, p->used, m, z_q16, s.apart, product[1]);
    if (z_q16 == 0) {
        p->gain_q20[m] = l.gain_q20;
        p->offset_q4[m] = l.offset_q4;
    }
}

void plfx_roi_tabulate(const plfx_roi *roi, plfx_roi_patch *p)
{
    int32_t at[3];
    int32_t plus[3];
    int32_t minus[3];
    int32_t m;
    int32_t k;

    for (m = 0; m < PLFX_ROI_NODES; m++) {
        read_node(roi, p, m, 0, at);
        memset(plus, 0, sizeof plus);
        memset(minus, 0, sizeof minus);
        if (roi->rim_q8 > 0) {
            read_node(roi, p, m, QUARTER, plus);
            read_node(roi, p, m, -QUARTER, minus);
        }
        for (k = 0; k < 3; k++) { /* a unit of slope is four quarters */
            p->reads_q24[k][m] = at[k];
            p->leans_q24[k][m] = plfx_sat_i32(2 * ((int64_t)plus[k] - minus[k]));
        }
    }
}

/* Variance of a lens over the views. */
static int64_t scatter(const plfx_roi *roi, const plfx_roi_patch *p, size_t lens,
                       size_t lenses)
{
    int32_t n = roi->cfg.views;
    uint32_t sum = 0;    /* < 2^23 */
    uint64_t square = 0; /* < 2^39 */
    int32_t k;

    for (k = 0; k < n; k++) {
        uint32_t v = p->wide[lens];
        sum += v;
        square += v * v; /* < 2^32 */
        lens += lenses;
    }
    return ((int64_t)square - (int64_t)sum * sum / n) / n;
}

/* The interpolator reads the margin.  What stands before it at another depth differs
 * from view to view, and reads as a change of slope. */
static void margin(const plfx_roi *roi, plfx_roi_patch *p)
{
    int32_t w = wide_w(p);
    int32_t n = w * wide_h(p);
    int64_t most[2] = {0, 0}; /* in the margin, within */
    int32_t s;

    for (s = 0; s < n; s++) {
        int64_t v = scatter(roi, p, (size_t)s, (size_t)n);
        int64_t *at = &most[plfx_roi_within(p, s % w, s / w)];
        *at = v > *at ? v : *at;
    }
    if (most[0] > CROWDED * (most[1] + p->noise_q8 / 256)) {
        p->flags |= PLFX_ROI_OCCLUDED;
    }
}

void plfx_roi_learn(const plfx_roi *roi, plfx_roi_patch *p)
{
    average(roi, p);
    mend(roi, p);
    margin(roi, p);
    reference(roi, p);
    gradients(roi, p);
    halves(roi, p);
    memset(roi->lens, 0, (size_t)p->w * (size_t)p->h * sizeof *roi->lens);
    p->apart.ref = p->all.ref - plfx_roi_share(roi, p, roi->lens, 1).ref;
    if (p->used * 2 < roi->cfg.views * p->w * p->h) {
        p->flags |= PLFX_ROI_SATURATED;
    }
}
