/* SPDX-License-Identifier: MIT
 * Motion of the camera from reference regions. */
#include "roi_state.h"
#include "fix.h"

#include <string.h>

#define NUMBERS 7

/* Number a of region k: i, j, u, v, w, standard errors in the plane and of w. */
static int32_t number(const plfx_roi *roi, const plfx_roi_result *r, int32_t k,
                      int32_t a)
{
    const plfx_roi_region *g = &roi->cfg.region[k];

    switch (a) {
    case 0:
        return 256 * g->i;
    case 1:
        return 256 * g->j;
    case 2:
        return r[k].u_q24;
    case 3:
        return r[k].v_q24;
    case 4:
        return r[k].w_q24 == PLFX_ROI_NONE ? 0 : r[k].w_q24;
    case 5:
        return (int32_t)(r[k].u_sigma_q24 / 2u + r[k].v_sigma_q24 / 2u);
    default:
        return (int32_t)r[k].w_sigma_q24;
    }
}

static int32_t is_reference(const plfx_roi *roi, const plfx_roi_result *r, int32_t k)
{
    return roi->cfg.region[k].reference && r[k].flags == 0;
}

/* Valid references, and the means of their numbers. */
static int32_t means_of(const plfx_roi *roi, const plfx_roi_result *r,
                        int32_t mean[NUMBERS])
{
    int32_t n = 0;
    int32_t k;
    int32_t a;

    for (a = 0; a < NUMBERS; a++) {
        int64_t sum = 0;
        n = 0;
        for (k = 0; k < roi->cfg.regions; k++) {
            if (is_reference(roi, r, k)) {
                sum += number(roi, r, k, a);
                n++;
            }
        }
        mean[a] = (int32_t)plfx_div_round_i64(sum, n > 0 ? n : 1);
    }
    return n;
}

/* Sums about the means; places in q4 < 2^19, displacements < 2^32. */
typedef struct sums {
    int64_t ii, ij, jj;
    int64_t i[3], j[3]; /* with u, v, w */
} sums;

static sums sums_of(const plfx_roi *roi, const plfx_roi_result *r,
                    const int32_t mean[NUMBERS])
{
    sums s;
    int32_t k;
    int32_t a;

    memset(&s, 0, sizeof s);
    for (k = 0; k < roi->cfg.regions; k++) {
        if (is_reference(roi, r, k)) {
            int32_t i = plfx_asr_i32(number(roi, r, k, 0) - mean[0], 4);
            int32_t j = plfx_asr_i32(number(roi, r, k, 1) - mean[1], 4);
            s.ii += (int64_t)i * i;
            s.ij += (int64_t)i * j;
            s.jj += (int64_t)j * j;
            for (a = 0; a < 3; a++) {
                int64_t move = (int64_t)number(roi, r, k, 2 + a) - mean[2 + a];
                s.i[a] += i * move;
                s.j[a] += j * move;
            }
        }
    }
    return s;
}

/* Entry of the inverse of a matrix that was shifted down; |v| < 2^12. */
static int32_t inverse_q24(int64_t v, int64_t det, int32_t down)
{
    return plfx_sat_i32(plfx_asr_i64(v * (1 << 24) / det, down));
}

/* (a*p - b*q)/det of a system that was shifted down. */
static int32_t solved(int64_t a, int64_t p, int64_t b, int64_t q, int64_t det,
                      int32_t down)
{
    return plfx_sat_i32(plfx_asr_i64(
        (plfx_asr_i64(a, 6) * p - plfx_asr_i64(b, 6) * q) / det * 64, down));
}

/* Plane of w from three references out of line: a 2 x 2 system. */
static void tilt(const sums *s, plfx_roi_shake *out)
{
    int64_t ii = plfx_asr_i64(s->ii, 8); /* whole lenses, < 2^32 */
    int64_t ij = plfx_asr_i64(s->ij, 8);
    int64_t jj = plfx_asr_i64(s->jj, 8);
    int64_t iw = plfx_asr_i64(s->i[2], 4); /* < 2^52 */
    int64_t jw = plfx_asr_i64(s->j[2], 4);
    int32_t down = 0;
    int64_t det;

    while (ii >> down >= 4096 || jj >> down >= 4096) { /* at most 32 */
        down++;
    }
    ii = plfx_asr_i64(ii, down);
    ij = plfx_asr_i64(ij, down);
    jj = plfx_asr_i64(jj, down);
    det = ii * jj - ij * ij; /* < 2^24 */
    if (det * 16 > ii * jj) {
        out->wi_q24 = solved(iw, jj, jw, ij, det, down);
        out->ii_q24 = inverse_q24(jj, det, down);
        out->ij_q24 = inverse_q24(-ij, det, down);
        out->jj_q24 = inverse_q24(ii, det, down);
        out->wj_q24 = solved(jw, ii, iw, ij, det, down);
    }
}

plfx_status plfx_roi_shake_fit(const plfx_roi *roi, const plfx_roi_result *result,
                               plfx_roi_shake *shake)
{
    int32_t mean[NUMBERS];
    sums s;

    if (!roi || !result || !shake) {
        return PLFX_E_ARG;
    }
    memset(shake, 0, sizeof *shake);
    shake->n = means_of(roi, result, mean);
    if (shake->n == 0) {
        return PLFX_OK;
    }
    shake->i_q8 = mean[0];
    shake->j_q8 = mean[1];
    shake->u_q24 = mean[2];
    shake->v_q24 = mean[3];
    shake->w_q24 = mean[4];
    shake->uv_sigma_q24 = (uint32_t)mean[5];
    shake->w_sigma_q24 = (uint32_t)mean[6];
    s = sums_of(roi, result, mean);
    if (s.ii + s.jj >= 256) {                        /* of one alone they are 0 */
        int64_t size = plfx_asr_i64(s.ii + s.jj, 4); /* q4 of lenses squared */
        shake->spread = plfx_sat_i32(plfx_asr_i64(size, 4));
        shake->zoom_q24 = plfx_sat_i32(plfx_div_round_i64(s.i[0] + s.j[1], size));
        shake->turn_q24 = plfx_sat_i32(plfx_div_round_i64(s.i[1] - s.j[0], size));
    }
    if (shake->n >= 3) {
        tilt(&s, shake);
    }
    return PLFX_OK;
}

/* A standard error and that of the shake, `times_q8` of a reference's. */
static uint32_t joined(uint32_t own_q24, uint32_t reference_q24, uint32_t times_q8)
{
    uint64_t s =
        plfx_roi_hypot(own_q24, (uint64_t)reference_q24 * times_q8 / 256u); /* < 2^55 */

    return (uint32_t)(s < 0x7fffffffu ? s : 0x7fffffffu);
}

/* Root of 1/n and a form of the distance to the references' centre, q8. */
static uint32_t times(const plfx_roi_shake *shake, int64_t form_q16)
{
    int64_t f = plfx_clamp_i64(form_q16, 0, (int64_t)1 << 48) + 65536 / shake->n;

    return plfx_roi_root((uint64_t)f);
}

/* Standard errors of a region i, j beside the references' centre, q8. */
static void doubt(const plfx_roi_shake *shake, int32_t i_q8, int32_t j_q8,
                  plfx_roi_result *r)
{
    int32_t i = plfx_asr_i32(i_q8, 8); /* < 2^15 */
    int32_t j = plfx_asr_i32(j_q8, 8);
    int64_t turn =
        shake->spread > 0 ? (int64_t)(i * i + j * j) * 65536 / shake->spread : 0;
    int64_t form = (int64_t)(i * i) * shake->ii_q24 +
                   2 * ((int64_t)(i * j) * shake->ij_q24) +
                   (int64_t)(j * j) * shake->jj_q24; /* < 2^62 */
    uint32_t plane_q8 = times(shake, turn);

    r->u_sigma_q24 = joined(r->u_sigma_q24, shake->uv_sigma_q24, plane_q8);
    r->v_sigma_q24 = joined(r->v_sigma_q24, shake->uv_sigma_q24, plane_q8);
    r->w_sigma_q24 =
        joined(r->w_sigma_q24, shake->w_sigma_q24, times(shake, plfx_asr_i64(form, 8)));
}

/* v less a plane: at + (di*i + dj*j)/256. */
static int32_t less(int32_t v_q24, int32_t at_q24, int32_t di, int32_t i, int32_t dj,
                    int32_t j)
{
    return plfx_sat_i32((int64_t)v_q24 - at_q24 -
                        plfx_round_shift_i64((int64_t)di * i + (int64_t)dj * j, 8));
}

void plfx_roi_steady(const plfx_roi *roi, const plfx_roi_shake *shake,
                     plfx_roi_result *result)
{
    int32_t k;

    for (k = 0; shake->n > 0 && k < roi->cfg.regions; k++) {
        plfx_roi_result *r = &result[k];
        int32_t i = 256 * roi->cfg.region[k].i - shake->i_q8;
        int32_t j = 256 * roi->cfg.region[k].j - shake->j_q8;
        if (r->u_q24 == PLFX_ROI_NONE) {
            continue;
        }
        r->u_q24 =
            less(r->u_q24, shake->u_q24, shake->zoom_q24, i, shake->turn_q24, -j);
        r->v_q24 = less(r->v_q24, shake->v_q24, shake->zoom_q24, j, shake->turn_q24, i);
        if (r->w_q24 != PLFX_ROI_NONE) {
            r->w_q24 = less(r->w_q24, shake->w_q24, shake->wi_q24, i, shake->wj_q24, j);
        }
        if (!roi->cfg.region[k].reference) {
            doubt(shake, i, j, r);
        }
    }
}
