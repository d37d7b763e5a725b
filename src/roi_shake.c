/* SPDX-License-Identifier: MIT
 * Motion of the camera from reference regions. */
#include "roi_state.h"
#include "fix.h"

#include <string.h>

typedef struct means { /* over the valid references; places q8, displacements q24 */
    int64_t i, j, u, v, w;
    int32_t n;
} means;

static int32_t is_reference(const plfx_roi *roi, const plfx_roi_result *r, int32_t k)
{
    return roi->cfg.region[k].reference && r[k].flags == 0;
}

static int32_t w_of(const plfx_roi_result *r)
{
    return r->w_q24 == PLFX_ROI_NONE ? 0 : r->w_q24;
}

static means mean_of(const plfx_roi *roi, const plfx_roi_result *r)
{
    means m = {0, 0, 0, 0, 0, 0};
    int32_t k;

    for (k = 0; k < roi->cfg.regions; k++) {
        if (is_reference(roi, r, k)) {
            m.i += 256 * (int64_t)roi->cfg.region[k].i;
            m.j += 256 * (int64_t)roi->cfg.region[k].j;
            m.u += r[k].u_q24;
            m.v += r[k].v_q24;
            m.w += w_of(&r[k]);
            m.n++;
        }
    }
    if (m.n > 0) {
        m.i = plfx_div_round_i64(m.i, m.n);
        m.j = plfx_div_round_i64(m.j, m.n);
        m.u = plfx_div_round_i64(m.u, m.n);
        m.v = plfx_div_round_i64(m.v, m.n);
        m.w = plfx_div_round_i64(m.w, m.n);
    }
    return m;
}

/* Sums about the means; places in q4 < 2^17, displacements < 2^33. */
typedef struct sums {
    int64_t ii, ij, jj;
    int64_t iu, ju, iv, jv, iw, jw;
} sums;

static sums sums_of(const plfx_roi *roi, const plfx_roi_result *r, const means *m)
{
    sums s = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    int32_t k;

    for (k = 0; k < roi->cfg.regions; k++) {
        if (is_reference(roi, r, k)) {
            int64_t i = plfx_asr_i64(256 * (int64_t)roi->cfg.region[k].i - m->i, 4);
            int64_t j = plfx_asr_i64(256 * (int64_t)roi->cfg.region[k].j - m->j, 4);
            s.ii += i * i;
            s.ij += i * j;
            s.jj += j * j;
            s.iu += i * (r[k].u_q24 - m->u);
            s.ju += j * (r[k].u_q24 - m->u);
            s.iv += i * (r[k].v_q24 - m->v);
            s.jv += j * (r[k].v_q24 - m->v);
            s.iw += i * (w_of(&r[k]) - m->w);
            s.jw += j * (w_of(&r[k]) - m->w);
        }
    }
    return s;
}

/* Plane of w from three references out of line: a 2 x 2 system. */
static void tilt(const sums *s, plfx_roi_shake *out)
{
    int64_t ii = plfx_asr_i64(s->ii, 8); /* whole lenses, < 2^32 */
    int64_t ij = plfx_asr_i64(s->ij, 8);
    int64_t jj = plfx_asr_i64(s->jj, 8);
    int64_t iw = plfx_asr_i64(s->iw, 4); /* < 2^52 */
    int64_t jw = plfx_asr_i64(s->jw, 4);
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
        out->wi_q24 = plfx_sat_i32(plfx_asr_i64(
            (plfx_asr_i64(iw, 6) * jj - plfx_asr_i64(jw, 6) * ij) / det * 64, down));
        out->wj_q24 = plfx_sat_i32(plfx_asr_i64(
            (plfx_asr_i64(jw, 6) * ii - plfx_asr_i64(iw, 6) * ij) / det * 64, down));
    }
}

plfx_status plfx_roi_shake_fit(const plfx_roi *roi, const plfx_roi_result *result,
                               plfx_roi_shake *shake)
{
    means m;
    sums s;

    if (!roi || !result || !shake) {
        return PLFX_E_ARG;
    }
    memset(shake, 0, sizeof *shake);
    m = mean_of(roi, result);
    shake->n = m.n;
    if (m.n == 0) {
        return PLFX_OK;
    }
    shake->i_q8 = (int32_t)m.i;
    shake->j_q8 = (int32_t)m.j;
    shake->u_q24 = plfx_sat_i32(m.u);
    shake->v_q24 = plfx_sat_i32(m.v);
    shake->w_q24 = plfx_sat_i32(m.w);
    s = sums_of(roi, result, &m);
    if (s.ii + s.jj >= 256) {                        /* of one alone they are 0 */
        int64_t size = plfx_asr_i64(s.ii + s.jj, 4); /* q4 of lenses squared */
        shake->zoom_q24 = plfx_sat_i32(plfx_div_round_i64(s.iu + s.jv, size));
        shake->turn_q24 = plfx_sat_i32(plfx_div_round_i64(s.iv - s.ju, size));
    }
    if (m.n >= 3) {
        tilt(&s, shake);
    }
    return PLFX_OK;
}

void plfx_roi_steady(const plfx_roi *roi, const plfx_roi_shake *shake,
                     plfx_roi_result *result)
{
    int32_t k;

    for (k = 0; shake->n > 0 && k < roi->cfg.regions; k++) {
        plfx_roi_result *r = &result[k];
        int64_t i = 256 * (int64_t)roi->cfg.region[k].i - shake->i_q8;
        int64_t j = 256 * (int64_t)roi->cfg.region[k].j - shake->j_q8;
        if (r->u_q24 == PLFX_ROI_NONE) {
            continue;
        }
        r->u_q24 = plfx_sat_i32(
            r->u_q24 - (int64_t)shake->u_q24 -
            plfx_round_shift_i64(shake->zoom_q24 * i - shake->turn_q24 * j, 8));
        r->v_q24 = plfx_sat_i32(
            r->v_q24 - (int64_t)shake->v_q24 -
            plfx_round_shift_i64(shake->zoom_q24 * j + shake->turn_q24 * i, 8));
        if (r->w_q24 != PLFX_ROI_NONE) {
            r->w_q24 = plfx_sat_i32(
                r->w_q24 - (int64_t)shake->w_q24 -
                plfx_round_shift_i64(shake->wi_q24 * i + shake->wj_q24 * j, 8));
        }
    }
}
