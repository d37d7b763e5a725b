/* SPDX-License-Identifier: MIT
 * Sums over a patch and the displacement that explains them. */
#include "roi_state.h"
#include "fix.h"

#include <string.h>

void plfx_roi_add(const plfx_roi_patch *p, size_t at, const uint16_t *row,
                  plfx_roi_sums *view, int32_t *lens)
{
    const uint16_t *ref = p->ref + at;
    const int16_t *gx = p->gx + at;
    const int16_t *gy = p->gy + at;
    int32_t x;

    for (x = 0; x < p->w; x++) {
        int32_t d = (int32_t)row[x] - ref[x]; /* 16 bits and a sign */
        if (ref[x] == PLFX_ROI_UNUSED) {
            continue;
        }
        view->clipped += row[x] == PLFX_ROI_UNUSED;
        view->b[0] += gx[x] * d; /* within 32 bits */
        view->b[1] += gy[x] * d;
        view->energy += (uint32_t)d * (uint32_t)d;
        lens[x] += d;
        if (ref[x] >= p->split) {
            view->bright += d;
        } else {
            view->dark += d;
        }
    }
}

void plfx_roi_close(const int32_t lean_q12[2], plfx_roi_sums *view, plfx_roi_sums *all)
{
    all->b[0] += view->b[0]; /* < 2^43 a view */
    all->b[1] += view->b[1];
    all->b[2] +=
        plfx_round_shift_i64(view->b[0] * lean_q12[0] + view->b[1] * lean_q12[1], 12);
    all->bright += view->bright;
    all->dark += view->dark;
    all->energy += view->energy;
    all->clipped += view->clipped;
    memset(view, 0, sizeof *view);
}

plfx_roi_shared plfx_roi_share(const plfx_roi *roi, const plfx_roi_patch *p,
                               const int32_t *lens, int32_t with_ref)
{
    size_t n = (size_t)p->w * (size_t)p->h;
    plfx_roi_shared all = {0, 0, 0};
    int32_t view;
    size_t s;

    for (s = 0; s < n; s++) {
        int32_t used = 0;
        int32_t ref = 0; /* < 2^23 */
        for (view = 0; view < roi->cfg.views; view++) {
            uint32_t r = p->ref[n * (size_t)view + s];
            used += r != PLFX_ROI_UNUSED;
            ref += r != PLFX_ROI_UNUSED ? (int32_t)r : 0;
        }
        if (used > 0) {
            all.square += (int64_t)lens[s] * lens[s] / used;
        }
        if (used > 0 && with_ref) {
            all.product += (int64_t)lens[s] * ref / used;
            all.ref += (int64_t)ref * ref / used;
        }
    }
    return all;
}

plfx_roi_light plfx_roi_light_of(const plfx_roi_patch *p, const plfx_roi_sums *s)
{
    /* both halves: d = a*R + o; sums < 2^36, counts < 2^20 */
    int64_t det = p->ref_bright * p->n_dark - p->ref_dark * p->n_bright;
    int64_t num = s->bright * p->n_dark - s->dark * p->n_bright;
    int64_t all = s->bright + s->dark;
    int64_t ref = p->ref_bright + p->ref_dark;
    plfx_roi_light l = {1 << 20, 0};
    int64_t a_q20 = 0;

    if (det > 0) { /* 0 where all of R is one number */
        int32_t down = plfx_max_i32(plfx_log2_u64((uint64_t)det) - 30, 0);
        num = plfx_asr_i64(plfx_clamp_i64(num, -det, 15 * det), down); /* < 2^35 */
        a_q20 = num * (1 << 20) / plfx_asr_i64(det, down);
    }
    l.gain_q20 += (int32_t)a_q20;
    all -= plfx_round_shift_i64(ref * a_q20, 20); /* < 2^36 * 2^24 */
    l.offset_q4 = plfx_sat_i32(all * 16 / p->used);
    return l;
}

void plfx_roi_linear(const plfx_roi_patch *p, const plfx_roi_sums *s, int32_t gain_q20,
                     int32_t out_q24[3])
{
    int64_t t[3];
    int32_t k;

    for (k = 0; k < 3; k++) { /* bright, dark < 2^36, alpha < 2^27 */
        int64_t b =
            s->b[k] - plfx_round_shift_i64(
                          s->bright * p->alpha_q12[k] + s->dark * p->beta_q12[k], 12);
        int64_t limit = (int64_t)1 << 33;
        t[k] = b * 64 / p->scale[k]; /* b < 2^52 */
        t[k] = plfx_clamp_i64(t[k], -limit, limit);
    }
    for (k = 0; k < 3; k++) { /* inverse < 2^28: products < 2^61 */
        int64_t sum = (plfx_asr_i64(p->inv_q24[k][0] * t[0], 2) +
                       plfx_asr_i64(p->inv_q24[k][1] * t[1], 2) +
                       plfx_asr_i64(p->inv_q24[k][2] * t[2], 2)) /
                      (p->scale[k] * 16);
        sum = sum > (int64_t)1 << 31 ? (int64_t)1 << 31 : sum;
        sum = sum < -((int64_t)1 << 31) ? -((int64_t)1 << 31) : sum;
        out_q24[k] = plfx_sat_i32(sum * (1 << 20) / gain_q20);
    }
}

/* Lagrange's basis over the nodes -1/2 .. 1/2 in steps of 1/4, q20. */
static void basis(int32_t x_q24, int32_t l[5])
{
    static const int8_t below[5] = {24, -6, 4, -6, 24};
    int32_t way[5]; /* to the nodes, q20; |way| < 4.5 */
    int32_t i;
    int32_t j;

    for (i = 0; i < 5; i++) {
        way[i] = plfx_asr_i32(x_q24, 2) - (i - 2) * (1 << 20);
    }
    for (i = 0; i < 5; i++) {
        int32_t v = 1 << 20;
        for (j = 0; j < 5; j++) { /* |v| < 2^27 */
            if (j != i) {
                v = (int32_t)plfx_round_shift_i64((int64_t)v * way[j], 20);
            }
        }
        l[i] = v / below[i];
    }
}

static int64_t at_nodes(const int32_t lx[5], const int32_t ly[5], const int32_t *table)
{
    int64_t sum = 0;
    int32_t i;
    int32_t j;

    for (j = 0; j < 5; j++) {
        int64_t line = 0; /* 2^30 * 2^21 * 5 */
        for (i = 0; i < 5; i++) {
            line += (int64_t)lx[i] * table[5 * j + i];
        }
        sum += plfx_asr_i64(line, 20) * ly[j];
    }
    return plfx_round_shift_i64(sum, 20);
}

/* The displacement that reads as `linear`: p += linear - reads(p), which shrinks the
 * error 3 times and more a round within half a lens. */
static void invert(const plfx_roi_patch *patch, const int32_t linear[3], int32_t p[3])
{
    const int32_t reach = 5 * (PLFX_ROI_ONE / 8);
    int32_t lx[5];
    int32_t ly[5];
    int32_t round;
    int32_t k;

    memcpy(p, linear, 3 * sizeof *p);
    for (round = 0; round < 12; round++) {
        int32_t worst = 0;
        p[0] = plfx_clamp_i32(p[0], -reach, reach);
        p[1] = plfx_clamp_i32(p[1], -reach, reach);
        p[2] = plfx_clamp_i32(p[2], -PLFX_ROI_ONE, PLFX_ROI_ONE);
        basis(p[0], lx);
        basis(p[1], ly);
        for (k = 2; k >= 0; k--) {
            int64_t r =
                at_nodes(lx, ly, patch->reads_q24[k]) +
                plfx_round_shift_i64(at_nodes(lx, ly, patch->leans_q24[k]) * p[2], 24);
            int32_t step = plfx_sat_i32(linear[k] - r);
            worst = plfx_max_i32(worst, plfx_max_i32(step, -step));
            p[k] = plfx_sat_i32((int64_t)p[k] + step);
        }
        if (worst < 64) {
            break;
        }
    }
}

static plfx_roi_sums look(const plfx_roi *roi, const plfx_roi_frame *frame,
                          const plfx_roi_patch *p)
{
    uint16_t row[PLFX_ROI_SIDE];
    plfx_roi_sums view;
    plfx_roi_sums all;
    size_t at = 0;
    int32_t k;

    memset(&view, 0, sizeof view);
    memset(&all, 0, sizeof all);
    memset(roi->lens, 0, (size_t)p->w * (size_t)p->h * sizeof *roi->lens);
    for (k = 0; k < roi->cfg.views; k++) {
        int32_t *lens = roi->lens;
        int32_t y;
        for (y = 0; y < p->h; y++) {
            plfx_roi_sample(roi, frame, p, k, y, 0, p->w, row);
            plfx_roi_add(p, at, row, &view, lens);
            at += (size_t)p->w;
            lens += p->w;
        }
        plfx_roi_close(roi->lean_q12[k], &view, &all);
    }
    all.apart = all.energy - plfx_roi_share(roi, p, roi->lens, 0).square;
    return all;
}

/* Lagrange's bases at a displacement. */
typedef struct place {
    int32_t lx[5], ly[5];
} place;

static void place_of(const int32_t d[3], place *at)
{
    basis(d[0], at->lx);
    basis(d[1], at->ly);
}

/* Energy that displacement d and the gain a put into the differences: with R' the rest
 * state displaced, d = a*(R'-R) + (a-1)*R
 *   a^2*sum (R'-R)^2 + 2*a*(a-1)*sum (R'-R)*R
 * from the tables.  Not in it: (a-1)^2*sum R^2. */
static int64_t moved_energy(const plfx_roi_energies *e, int64_t used, const place *at,
                            const int32_t d[3], int32_t gain_q20)
{
    int64_t a_q16 = plfx_asr_i32(gain_q20 + 8, 4);                   /* <= 2^20 */
    int64_t z = plfx_asr_i32(d[2], 12);                              /* q12 */
    int64_t square = 4 * at_nodes(at->lx, at->ly, e->square) * used; /* < 2^51 */
    int64_t product = 16 * at_nodes(at->lx, at->ly, e->product) * used;
    int64_t sum;

    square += plfx_asr_i64(plfx_asr_i64(e->cross[0], 12) * z, 12) * z;
    square +=
        2 *
        (plfx_asr_i64(plfx_asr_i64(e->cross[1], 12) * z, 12) * plfx_asr_i32(d[0], 12) +
         plfx_asr_i64(plfx_asr_i64(e->cross[2], 12) * z, 12) * plfx_asr_i32(d[1], 12));
    product += plfx_asr_i64(plfx_asr_i64(e->lean, 12) * z, 12) * z;
    sum = plfx_asr_i64(square, 16) * a_q16 +
          2 * plfx_asr_i64(product, 16) * (a_q16 - 65536); /* < 2^60 */
    sum = plfx_asr_i64(sum, 16) * a_q16;
    return sum > 0 ? sum : 0;
}

static uint16_t sat_u16(int64_t v)
{
    return (uint16_t)(v < 0 ? 0 : v > 65535 ? 65535 : v);
}

/* Brightness without what the displacement feigns. */
static plfx_roi_light true_light(const plfx_roi_patch *p, plfx_roi_light seen,
                                 const place *at)
{
    plfx_roi_light l;
    int64_t gain = at_nodes(at->lx, at->ly, p->gain_q20);

    gain = gain > 1 << 16 ? gain : 1 << 16;
    l.gain_q20 = plfx_sat_i32(((int64_t)seen.gain_q20 << 20) / gain);
    l.offset_q4 = plfx_sat_i32(
        seen.offset_q4 -
        plfx_round_shift_i64(at_nodes(at->lx, at->ly, p->offset_q4) * l.gain_q20, 20));
    return l;
}

/* (gain-1)^2*sum R^2. */
static int64_t gain_energy(int64_t ref, plfx_roi_light l)
{
    int64_t a_q16 = plfx_asr_i32(l.gain_q20 - (1 << 20) + 8, 4); /* < 2^20 */

    return plfx_asr_i64(plfx_asr_i64(ref, 16) * a_q16, 16) * a_q16;
}

/* Sum of ((gain-1)*R + offset)^2. */
static int64_t light_energy(const plfx_roi_patch *p, plfx_roi_light l)
{
    int64_t a_q16 = plfx_asr_i32(l.gain_q20 - (1 << 20) + 8, 4);
    int64_t o = plfx_asr_i32(l.offset_q4 + 8, 4); /* < 2^18 */
    int64_t ref = p->ref_bright + p->ref_dark;    /* < 2^36 */

    return gain_energy(p->all.ref, l) + 2 * o * plfx_round_shift_i64(ref * a_q16, 16) +
           p->used * o * o;
}

/* Variances of a sample that the displacement does not explain, q8. */
typedef struct leftover {
    int64_t noise;  /* its own; at least that of the rest state */
    int64_t missed; /* alike in all views */
} leftover;

/* What is left of an energy, a sample, q8. */
static int64_t left_q8(int64_t energy, int64_t explained, int64_t used)
{
    return (energy - explained) / used * 256;
}

/* How far what all views share is from their noise, over it or under, beyond what the
 * rest state's own noise and chance put there. */
static int64_t missed_q8(const plfx_roi *roi, int64_t left, int64_t noise_q8,
                         int64_t part_q12)
{
    int64_t off = left - noise_q8 - noise_q8 / roi->cfg.rest;

    off = (off < 0 ? -off : off) - plfx_asr_i64(noise_q8 * part_q12, 12);
    return off > 0 ? off : 0;
}

/* Over the noise and what the interpolator misses, 1/24 of the energy of sharp texture;
 * < 2^48. */
static int64_t over_q8(int64_t left, int64_t noise_q8, int64_t moved)
{
    return left * 256 / (noise_q8 + moved * 11 + 1);
}

/* The same for what lies apart, where twice the way from 1 counts.  Energy under 0
 * tells that the rest state promised what is not there: something stood before its
 * margin. */
static int64_t apart(const plfx_roi_patch *p, int64_t left, int64_t noise_q8,
                     int64_t moved)
{
    int64_t off = left > noise_q8 ? left - noise_q8 : left < 0 ? -2 * left : 0;

    off -= plfx_asr_i64(noise_q8 * p->chance_q12, 12);
    return 256 + (off > 0 ? off * 512 / (noise_q8 + moved * 11 + 1) : 0);
}

/* Splits what is left; flags what it says.  Texture finer than two lenses is alike in
 * all views; what lies before the region, at another depth, is not. */
static leftover residual(const plfx_roi *roi, const plfx_roi_patch *p,
                         const plfx_roi_sums *s, plfx_roi_light l, const int32_t d[3],
                         const place *at, plfx_roi_result *out)
{
    int64_t moved = moved_energy(&p->all, p->used, at, d, l.gain_q20); /* < 2^56 */
    int64_t left = left_q8(s->energy, light_energy(p, l) + moved, p->used);
    int64_t noise = plfx_asr_i64(p->noise_q8 * plfx_asr_i32(l.gain_q20, 8), 12);
    int64_t own = left;
    int64_t common = left;
    int64_t its_noise;
    int64_t ratio_q8;
    int32_t part_q12 = p->chance_q12;
    leftover v = {p->noise_q8, 0};

    noise = noise > p->noise_q8 ? noise : p->noise_q8;
    ratio_q8 = over_q8(left, noise, moved / p->used);
    its_noise = noise;
    if (p->own_q12 >= 256) { /* else one view, or all at one place */
        int64_t share = plfx_asr_i64(noise * p->own_q12, 12);
        int64_t apart_q8;
        moved = moved_energy(&p->apart, p->used, at, d, l.gain_q20);
        own = left_q8(s->apart, gain_energy(p->apart.ref, l) + moved, p->used);
        apart_q8 = apart(p, own, share, moved / p->used);
        ratio_q8 = apart_q8 > ratio_q8 ? apart_q8 : ratio_q8;
        common = left - own;
        its_noise = noise - share;
        part_q12 = 2048;
        own = own * 4096 / p->own_q12;
    }
    if (p->noise_q8 > 0) {
        v.missed = missed_q8(roi, common, its_noise, part_q12);
        out->residual_q8 = sat_u16(ratio_q8);
        if (out->residual_q8 > roi->cfg.residual_q8) {
            out->flags |= PLFX_ROI_OCCLUDED;
        }
    }
    v.noise = own > v.noise ? own : v.noise;
    return v;
}

uint32_t plfx_roi_root(uint64_t v)
{
    return plfx_isqrt_u64(v);
}

uint64_t plfx_roi_hypot(uint64_t a, uint64_t b)
{
    int32_t shift = 0;

    while ((a | b) >> shift >= (uint64_t)1 << 31) { /* at most 33 */
        shift++;
    }
    a >>= shift;
    b >>= shift;
    return (uint64_t)plfx_roi_root(a * a + b * b) << shift;
}

/* Noise scatters with the views' pixels; what is missed is alike in all views. */
static uint32_t sigma(const plfx_roi_patch *p, int32_t k, const leftover *left,
                      int32_t gain_q20)
{
    uint64_t rms_q8 = plfx_roi_root((uint64_t)left->noise << 8); /* < 2^24 */
    uint64_t over_q8 = plfx_roi_root((uint64_t)left->missed << 8);
    uint64_t s = plfx_roi_hypot(rms_q8 * p->spread_q12[k], over_q8 * p->common_q12[k]) *
                 16u / (uint64_t)p->scale[k];

    s = s < (uint64_t)1 << 43 ? s : (uint64_t)1 << 43;
    s = (s << 20) / (uint64_t)(gain_q20 > 1 << 14 ? gain_q20 : 1 << 14) + 1u;
    s = s < 0x7fffffffu ? s : 0x7fffffffu;
    return (uint32_t)s;
}

/* Whole columns or rows nearest to d. */
static int32_t whole(int32_t d_q24)
{
    return plfx_asr_i32(d_q24 + PLFX_ROI_ONE / 2, 24);
}

static int32_t inside(const plfx_roi *roi, const plfx_roi_patch *p)
{
    return p->i0 + p->ki >= 0 && p->j0 + p->kj >= 0 &&
           p->i0 + p->ki + p->w <= roi->cfg.nx && p->j0 + p->kj + p->h <= roi->cfg.ny;
}

/* Sum of absolute differences of the first view less its mean difference, per patch. */
static int64_t unlike(const plfx_roi *roi, const plfx_roi_frame *frame,
                      const plfx_roi_patch *p, int32_t view)
{
    uint16_t row[PLFX_ROI_SIDE];
    int64_t mean = 0;
    int64_t sum = 0;
    int32_t pass;
    int32_t y;
    int32_t x;

    for (pass = 0; pass < 2; pass++) {
        for (y = 0; y < p->h; y++) {
            const uint16_t *ref =
                p->ref + ((size_t)view * (size_t)p->h + (size_t)y) * (size_t)p->w;
            plfx_roi_sample(roi, frame, p, view, y, 0, p->w, row);
            for (x = 0; x < p->w; x++) {
                int64_t d = (int64_t)row[x] - ref[x] - mean;
                sum += pass == 0 || d >= 0 ? d : -d;
            }
        }
        mean = pass == 0 ? sum / ((int64_t)p->w * p->h) : mean;
        sum = pass == 0 ? 0 : sum;
    }
    return sum;
}

/* The likest place within cfg.seek lenses, at least one, in the first view. */
static void seek(const plfx_roi *roi, const plfx_roi_frame *frame, plfx_roi_patch *p)
{
    int32_t i0 = p->ki;
    int32_t j0 = p->kj;
    int32_t best_i = i0;
    int32_t best_j = j0;
    int64_t best = INT64_MAX;
    int32_t r = plfx_max_i32(roi->cfg.seek, 1);
    int32_t a;
    int32_t b;

    for (b = -r; b <= r; b++) {
        for (a = -r; a <= r; a++) {
            p->ki = i0 + a;
            p->kj = j0 + b;
            if (inside(roi, p)) {
                int64_t cost = unlike(roi, frame, p, 0);
                if (cost < best) {
                    best = cost;
                    best_i = p->ki;
                    best_j = p->kj;
                }
            }
        }
    }
    p->ki = best_i;
    p->kj = best_j;
}

static void clear(plfx_roi_result *out, uint32_t flags)
{
    memset(out, 0, sizeof *out);
    out->u_q24 = PLFX_ROI_NONE;
    out->v_q24 = PLFX_ROI_NONE;
    out->w_q24 = PLFX_ROI_NONE;
    out->flags = (uint8_t)flags;
}

/* Lens pitches and slope of columns, rows and rim shift. */
static void fill(const plfx_roi *roi, const plfx_roi_patch *p, const int32_t d[3],
                 const leftover *left, int32_t gain_q20, plfx_roi_result *out)
{
    int64_t col = d[0] + (int64_t)p->ki * PLFX_ROI_ONE;
    int64_t row = d[1] + (int64_t)p->kj * PLFX_ROI_ONE;

    out->u_q24 = plfx_sat_i32(col * 4096 / roi->col_q12);
    out->v_q24 = plfx_sat_i32(row * 4096 / roi->row_q12);
    out->u_sigma_q24 = (uint32_t)((uint64_t)sigma(p, 0, left, gain_q20) * 4096u /
                                  (uint32_t)roi->col_q12);
    out->v_sigma_q24 = (uint32_t)((uint64_t)sigma(p, 1, left, gain_q20) * 4096u /
                                  (uint32_t)roi->row_q12);
    if (roi->rim_q8 > 0) {
        out->w_q24 = plfx_sat_i32(plfx_div_round_i64((int64_t)d[2] * 256, roi->rim_q8));
        out->w_sigma_q24 = (uint32_t)((uint64_t)sigma(p, 2, left, gain_q20) * 256u /
                                      (uint32_t)roi->rim_q8);
    }
}

static int32_t beyond(int32_t v, int32_t limit)
{
    return v > limit || v < -limit;
}

/* One look and what it says; 1 when the patch should be looked at again elsewhere. */
static int32_t attempt(const plfx_roi *roi, const plfx_roi_frame *frame,
                       plfx_roi_patch *p, plfx_roi_result *out)
{
    const int32_t half = 9 * (PLFX_ROI_ONE / 16);
    plfx_roi_sums s;
    plfx_roi_light l;
    int32_t linear[3];
    int32_t d[3];
    int32_t away;
    leftover left;
    place at;

    clear(out, 0);
    if (!inside(roi, p)) {
        out->flags = PLFX_ROI_EDGE;
        return 0;
    }
    s = look(roi, frame, p);
    l = plfx_roi_light_of(p, &s);
    if (s.clipped > p->used / 64) {
        out->flags |= PLFX_ROI_SATURATED;
    }
    if (l.gain_q20 < 1 << 16) {
        out->flags |= PLFX_ROI_LIGHT;
        return 0;
    }
    plfx_roi_linear(p, &s, l.gain_q20, linear);
    invert(p, linear, d);
    place_of(d, &at);
    l = true_light(p, l, &at);
    out->light_q12 = sat_u16(plfx_asr_i32(l.gain_q20, 8));
    if (l.gain_q20 < 1 << 18 || l.gain_q20 > 4 << 20) {
        out->flags |= PLFX_ROI_LIGHT;
    }
    away = beyond(d[0], half) | beyond(d[1], half);
    if (away | beyond(d[2], PLFX_ROI_ONE / 2)) {
        out->flags |= PLFX_ROI_RANGE;
    }
    left = residual(roi, p, &s, l, d, &at, out);
    fill(roi, p, d, &left, l.gain_q20, out);
    if (away) { /* by a whole lens at least */
        p->ki += whole(d[0]);
        p->kj += whole(d[1]);
    }
    return away;
}

/* Looks from the patch's place on; 1 when the last one is valid. */
static int32_t settle(const plfx_roi *roi, const plfx_roi_frame *frame,
                      plfx_roi_patch *p, plfx_roi_result *out)
{
    int32_t step;

    for (step = 0; step < roi->cfg.steps; step++) {
        if (!attempt(roi, frame, p, out)) {
            break;
        }
    }
    return out->flags == 0;
}

/* From where the region was last seen; once more from the likest place around it; if
 * both fail it waits there. */
static void follow(const plfx_roi *roi, const plfx_roi_frame *frame, plfx_roi_patch *p,
                   plfx_roi_result *out)
{
    int32_t ki = p->ki;
    int32_t kj = p->kj;
    int32_t within = inside(roi, p);
    int32_t found = settle(roi, frame, p, out);

    if (!found && (within || roi->cfg.seek > 0)) {
        p->ki = ki;
        p->kj = kj;
        seek(roi, frame, p);
        found = settle(roi, frame, p, out);
    }
    if (!found) {
        p->ki = ki;
        p->kj = kj;
    }
}

plfx_status plfx_roi_measure(plfx_roi *roi, const plfx_roi_frame *frame,
                             plfx_roi_result *out)
{
    plfx_status status;
    int32_t k;

    if (!roi || !roi->patch || !out) {
        return PLFX_E_ARG;
    }
    if (roi->rested < roi->cfg.rest) {
        return PLFX_E_STATE;
    }
    status = plfx_roi_frame_ok(roi, frame);
    for (k = 0; status == PLFX_OK && k < roi->cfg.regions; k++) {
        if (roi->patch[k].flags) {
            clear(&out[k], roi->patch[k].flags);
        } else {
            follow(roi, frame, &roi->patch[k], &out[k]);
        }
    }
    return status;
}
