/* SPDX-License-Identifier: MIT
 * Evidence, sample by sample, that a mode's damping has left its healthy value. */
#include "plenofix/modal.h"
#include "fix.h"

#include <string.h>

#define SAMPLES_LEAST 64        /* thinned, behind the scale */
#define RATIO_MAX     4096      /* energy of a sample over the mean innovation */
#define NATS_MAX_Q20  (1 << 30) /* evidence is cut at 1024 nats */

/* zeta*omega over a thinned period, q20; 0 when out of reach. */
static int64_t decay_q20(const plfx_modal_cfg *c, int32_t damp_ppm)
{
    uint64_t t = (uint64_t)damp_ppm * c->freq_uhz / c->rate_mhz * (uint64_t)c->every;

    /* t < 2^63 in 10^-9 turns; 6588397 = 2*pi*2^20 */
    return t < 200000000u ? (int64_t)(t * 6588397u / 1000000000u) : 0;
}

/* Integer square root of the product: geometric mean. */
static int64_t mean_q20(int64_t a, int64_t b)
{
    return (int64_t)plfx_isqrt_u64((uint64_t)(a * b));
}

/* (R(0) - R(1))/(u*R(0)) of the thinned process at decay u: a cubic B-spline of an
 * exponential, in powers of u; q16. */
static int64_t gain_q16(int64_t u_q20)
{
    int64_t u = plfx_asr_i64(u_q20, 4); /* q16 */
    int64_t uu = plfx_asr_i64(u * u, 16);
    int64_t num = 36045 - plfx_asr_i64(u, 1) + plfx_asr_i64(uu * 18646, 16);
    int64_t den = 65536 - plfx_asr_i64(u * 30583, 16) + plfx_asr_i64(uu * 10923, 16) -
                  plfx_asr_i64(plfx_asr_i64(uu * u, 16) * 3225, 16);

    return num * 65536 / den;
}

plfx_status plfx_modal_watch_init(plfx_modal_watch *w, const plfx_modal *m,
                                  int32_t limit_ppm, int32_t healthy_ppm,
                                  int32_t nats_q8)
{
    int64_t u0;
    int64_t u1;

    if (!w || !m || limit_ppm < 1 || healthy_ppm <= limit_ppm ||
        healthy_ppm > 1000000 || nats_q8 < 256 || nats_q8 > 1 << 17) {
        return PLFX_E_ARG;
    }
    u0 = decay_q20(&m->cfg, healthy_ppm);
    u1 = decay_q20(&m->cfg, limit_ppm);
    if (u0 > 1 << 20 || u1 < 256 || u0 <= u1) {
        return PLFX_E_RANGE;
    }
    memset(w, 0, sizeof *w);
    w->line_q20 = (int32_t)(u0 - u1);
    w->square_q20 = (int32_t)plfx_asr_i64(u0 * u0 - u1 * u1, 20);
    w->gain_q16 = (int32_t)gain_q16(mean_q20(u0, u1));
    w->limit_q20 = nats_q8 * 4096;
    return PLFX_OK;
}

typedef struct scale { /* sums over the record, same shift */
    int64_t innovation;
    int32_t shift, n;
} scale;

/* Sum of |y(t) - c*y(t-1)|^2 with the phase of c that makes it least, over all blocks:
 * E(0) + E(1) - 2*|R(1)|; sums < 2^63 (modal.h). */
static scale innovation_of(const plfx_modal *m)
{
    scale s = {0, 0, m->now.n};
    int64_t e0 = m->now.energy[0];
    int64_t e1 = m->now.energy[1];
    int64_t re = m->now.re[1];
    int64_t im = m->now.im[1];
    int32_t b;

    for (b = 0; b < m->used; b++) {
        e0 += m->ring[b].energy[0];
        e1 += m->ring[b].energy[1];
        re += m->ring[b].re[1];
        im += m->ring[b].im[1];
        s.n += m->ring[b].n;
    }
    while (plfx_asr_i64(e0 > e1 ? e0 : e1, s.shift) >= 1 << 30) { /* at most 33 */
        s.shift++;
    }
    re = plfx_asr_i64(re, s.shift);
    im = plfx_asr_i64(im, s.shift);
    s.innovation = plfx_asr_i64(e0, s.shift) + plfx_asr_i64(e1, s.shift) -
                   2 * (int64_t)plfx_isqrt_u64((uint64_t)(re * re + im * im));
    return s;
}

/* Energy of the newest thinned sample over the innovation of a period, q16. */
static int64_t energy_q16(const plfx_modal_watch *w, const plfx_modal *m,
                          const scale *s)
{
    int64_t re = m->y_re;
    int64_t im = m->y_im;
    int64_t e = plfx_asr_i64((re * re + im * im) * s->n, s->shift); /* < 2^63 */
    int64_t d = s->innovation;                                      /* < 2^32 */

    e = e > d * RATIO_MAX ? d * RATIO_MAX : e;
    return plfx_asr_i64(e * 65536 / d * w->gain_q16, 16); /* 2^60, then 2^44 */
}

int32_t plfx_modal_watch_add(plfx_modal_watch *w, const plfx_modal *m)
{
    scale s = innovation_of(m);
    int64_t q;

    if (s.n < SAMPLES_LEAST || s.innovation <= 0) {
        w->primed = 0;
        return 0;
    }
    q = energy_q16(w, m, &s);
    if (w->primed && m->since > 1) { /* steps < 2^50 */
        int64_t e = w->evidence_q20 +
                    plfx_asr_i64(w->line_q20 * (q - w->last_q16), 16) +
                    plfx_asr_i64(w->square_q20 * (q + w->last_q16), 17) - w->line_q20;
        w->evidence_q20 = (int32_t)(e < 0 ? 0 : e > NATS_MAX_Q20 ? NATS_MAX_Q20 : e);
    }
    w->last_q16 = q;
    w->primed = 1;
    return w->evidence_q20 > w->limit_q20;
}
