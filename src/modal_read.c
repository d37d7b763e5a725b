/* SPDX-License-Identifier: MIT
 * Sums of lags to frequency, damping and amplitude. */
#include "plenofix/modal.h"
#include "fix.h"
#include "ln.h"
#include "sure.h"

#include <string.h>

#define LAGS       PLFX_MODAL_LAGS
#define LN2_Q20    726817
#define LIMIT      ((1 << 29) - 1) /* of R/energy, q28: over 1 in growth alone */
#define BAND       1073741824      /* a quarter turn a lag: an alias is 28 dB down */
#define CRITICAL   1000000         /* ppm */
#define DAMP_LEAST 1000 /* ppm: the bound is taken at this damping at least */

typedef struct fit {    /* straight lines through ln|R| and phase over lags 1 .. 5 */
    int64_t slope_q20;  /* of ln|R|, a lag */
    int64_t zero_q20;   /* ln|R| at lag 0 less ln R(0) */
    int64_t turn_u32;   /* phase, 2^32 a turn, a lag */
    uint32_t second_q8; /* |R(2)|/R(0) */
} fit;

/* Sum of the newest blocks and the one under way. */
static plfx_modal_sums gather(const plfx_modal *m, int32_t blocks)
{
    plfx_modal_sums s = m->now;
    int32_t b;
    int32_t l;

    for (b = 1; b <= plfx_min_i32(blocks, m->used); b++) {
        const plfx_modal_sums *r =
            &m->ring[(m->head + PLFX_MODAL_BLOCKS - b) % PLFX_MODAL_BLOCKS];
        s.gap |= r->gap;
        s.n += r->n;
        for (l = 0; l <= LAGS; l++) {
            s.re[l] += r->re[l];
            s.im[l] += r->im[l];
            s.energy[l] += r->energy[l];
        }
    }
    return s;
}

/* R(l) over the energy of the samples l back, q28; R(0) = 1. */
static void normalise(plfx_modal_sums *s)
{
    int32_t l;

    for (l = 1; l <= LAGS; l++) {
        int64_t energy = s->energy[l] | 1; /* < 2^63; |R| is of the same size at most */
        int32_t shift = 0;
        /* at most 29 */
        while (plfx_asr_i64(energy, shift) >= (int64_t)1 << 34) {
            shift++;
        }
        energy = plfx_asr_i64(energy, shift);
        s->re[l] = plfx_asr_i64(s->re[l], shift) * ((int64_t)1 << 28) / energy;
        s->im[l] = plfx_asr_i64(s->im[l], shift) * ((int64_t)1 << 28) / energy;
        s->re[l] = plfx_clamp_i32(plfx_sat_i32(s->re[l]), -LIMIT, LIMIT);
        s->im[l] = plfx_clamp_i32(plfx_sat_i32(s->im[l]), -LIMIT, LIMIT);
    }
    s->re[0] = (int64_t)1 << 28;
    s->im[0] = 0;
}

static uint64_t square(const plfx_modal_sums *s, int32_t l)
{
    return (uint64_t)(s->re[l] * s->re[l] + s->im[l] * s->im[l]); /* < 2^60 */
}

/* Weighted lines; weights |R|^2 q12, at most 2^15, so that the sums stay under 2^60. */
static void lines(const plfx_modal_sums *s, fit *f)
{
    int64_t w0 = 0;
    int64_t w1 = 0;
    int64_t w2 = 0;
    int64_t a0 = 0;
    int64_t a1 = 0;
    int64_t p1 = 0;
    int64_t phase = 0;
    uint32_t last = 0;
    int32_t zero = plfx_log2_q20(square(s, 0));
    int32_t l;

    for (l = 1; l <= LAGS; l++) {
        uint64_t r2 = square(s, l);
        uint32_t angle = plfx_angle_u32((int32_t)s->re[l], (int32_t)s->im[l]);
        int64_t w = (int64_t)(r2 / (square(s, 0) / 4096u + 1u));
        int64_t a = ((int64_t)plfx_log2_q20(r2 ? r2 : 1u) - zero) / 2;
        uint32_t turn = angle - last;
        phase += turn < 0x80000000u ? (int64_t)turn : (int64_t)turn - 4294967296;
        last = angle;
        w0 += w;
        w1 += w * l;
        w2 += w * l * l;
        a0 += w * a;
        a1 += w * l * a;
        p1 += plfx_asr_i64(phase, 4) * w * l;
    }
    f->slope_q20 = w0 * w2 - w1 * w1;
    if (f->slope_q20 > 0) {
        f->zero_q20 = (w2 * a0 - w1 * a1) / f->slope_q20;
        f->slope_q20 = (w0 * a1 - w1 * a0) / f->slope_q20;
        f->turn_u32 = plfx_div_round_i64(p1, w2) * 16;
    }
    f->slope_q20 = f->slope_q20 * LN2_Q20 / (1 << 20);
}

/* 2^x q8 of x q20, -1 .. 4, in steps of 2^-5: 1/2 .. 16. */
static uint32_t exp2_q8(int64_t x_q20)
{
    uint64_t v = 256u << 8;
    int64_t one = 1 << 20;
    uint32_t x = (uint32_t)((x_q20 < -one      ? -one
                             : x_q20 > 4 * one ? 4 * one
                                               : x_q20) +
                            one);
    /* 2^(1/2), 2^(1/4) ... 2^(1/32), q16 */
    static const uint32_t roots[5] = {92682u, 77936u, 71468u, 68438u, 66971u};
    int32_t i;

    for (i = 0; i < 5; i++) {
        if (x >> (19 - i) & 1u) {
            v = v * roots[i] >> 16;
        }
    }
    return (uint32_t)(v << (x >> 20) >> 9);
}

static uint32_t sat_u32(uint64_t v)
{
    return v > 0xffffffffu ? 0xffffffffu : (uint32_t)v;
}

/* Frequency of a turn of the thinned oscillation: step + turn/every, 2^32 a turn a
 * sample, times the rate. */
static uint32_t frequency(const plfx_modal *m, int64_t turn)
{
    int64_t inc = (int64_t)m->step + plfx_div_round_i64(turn, m->cfg.every);
    uint64_t rate = m->cfg.rate_mhz; /* < 2^23 */

    return inc <= 0 ? 0 : (uint32_t)(((uint64_t)inc * rate >> 12) * 1000u >> 20);
}

/* zeta = -slope*(rate/every)/(2*pi*f); 155425 = 10^9/(2*pi)/1024. */
static int32_t damping(const plfx_modal *m, int64_t slope_q20, uint32_t freq_uhz)
{
    int64_t t = -slope_q20 * (int64_t)m->cfg.rate_mhz / m->cfg.every; /* < 2^47 */

    t = t > (int64_t)1 << 45 ? (int64_t)1 << 45 : t;
    t = t < -((int64_t)1 << 45) ? -((int64_t)1 << 45) : t;
    return plfx_sat_i32(plfx_div_round_i64(t * 155425, (int64_t)freq_uhz << 10));
}

/* rms = sqrt(2*R(0)/n)/gain, gain = every^2/2^shift; the fit's R(0), without noise. */
static uint32_t amplitude(const plfx_modal *m, int64_t power, uint32_t noise_q8)
{
    uint64_t p = (uint64_t)power * 2u; /* < 2^42 */
    uint64_t e = (uint64_t)m->cfg.every;
    uint64_t rms_q8;

    p = p * 256u / noise_q8;
    rms_q8 = plfx_isqrt_u64(p << 20); /* q10 */
    return sat_u32((rms_q8 << m->shift >> 2) / (e * e));
}

/* Standard errors from the bound, over the record's cycles (thousandths). */
static void errors(plfx_mode *mode, uint64_t cycles_m, uint32_t noise_q8)
{
    uint64_t z = (uint64_t)plfx_max_i32(mode->damp_ppm, DAMP_LEAST);
    uint64_t sd = plfx_isqrt_u64(z * 159154943u / cycles_m); /* 10^9/(2*pi) */

    sd = sd * (noise_q8 > 256u ? noise_q8 : 256u) / 256u + 1u;
    mode->damp_sigma_ppm = sat_u32(sd * PLFX_MODAL_DAMP_LOSS_Q8 / 256u);
    sd = sd * PLFX_MODAL_FREQ_LOSS_Q8 / 256u;
    mode->freq_sigma_uhz = sat_u32(mode->freq_uhz * sd / 1000000u + 1u);
    mode->amp_sigma_q8 = sat_u32(mode->amp_q8 * sd / (2u * z) + 1u);
}

/* Correlated, inside the thinned band, under critical damping. */
static int32_t is_mode(const plfx_modal *m, const plfx_modal_sums *s, const fit *f,
                       const plfx_mode *mode)
{
    return square(s, 2) >= square(s, 0) / 16u && f->turn_u32 < BAND &&
           f->turn_u32 > -BAND && mode->freq_uhz > 0 &&
           mode->freq_uhz < m->cfg.rate_mhz * 500u && mode->damp_ppm < CRITICAL &&
           mode->damp_ppm > -CRITICAL;
}

static void measure(const plfx_modal *m, const plfx_modal_sums *sums, plfx_mode *mode)
{
    plfx_modal_sums s = *sums;
    int64_t power = s.energy[0] / s.n;
    fit f = {0, 0, 0, 0};
    uint64_t cycles_m;
    uint32_t noise_q8;

    normalise(&s);
    lines(&s, &f);
    mode->freq_uhz = frequency(m, f.turn_u32);
    mode->damp_ppm = mode->freq_uhz ? damping(m, f.slope_q20, mode->freq_uhz) : 0;
    if (!is_mode(m, &s, &f, mode)) {
        mode->freq_uhz = 0;
        mode->damp_ppm = 0;
        mode->flags |= PLFX_MODE_LOST;
        return;
    }
    noise_q8 = exp2_q8(-f.zero_q20);
    mode->amp_q8 = amplitude(m, power, noise_q8);
    cycles_m = (uint64_t)mode->freq_uhz * mode->record_ms / 1000000u;
    errors(mode, cycles_m ? cycles_m : 1u, noise_q8);
    mode->flags |= PLFX_MODE_VALID | (cycles_m < 20000u ? PLFX_MODE_SHORT : 0u);
}

plfx_status plfx_modal_read(const plfx_modal *m, int32_t blocks, plfx_mode *mode)
{
    plfx_modal_sums s;
    uint64_t samples;

    if (!m || !mode || blocks < 1 || blocks > PLFX_MODAL_BLOCKS) {
        return PLFX_E_ARG;
    }
    memset(mode, 0, sizeof *mode);
    s = gather(m, blocks);
    samples = (uint64_t)s.n * (uint64_t)m->cfg.every; /* < 2^36 */
    mode->record_ms = sat_u32(samples * 1000000u / m->cfg.rate_mhz);
    mode->flags = s.gap ? PLFX_MODE_GAP : 0u;
    if (s.n < 2 * LAGS) {
        mode->flags |= PLFX_MODE_SHORT;
    } else if (s.energy[0] < 2 * (int64_t)s.n) { /* under a step of the samples */
        mode->flags |= PLFX_MODE_LOST;
    } else {
        measure(m, &s, mode);
    }
    return PLFX_OK;
}

/* Standard error that a damping of limit_ppm would have over the mode's record. */
static int64_t sigma_at(const plfx_mode *mode, int32_t limit_ppm)
{
    uint64_t cycles_m = (uint64_t)mode->freq_uhz * mode->record_ms / 1000000u + 1u;
    uint64_t sd = plfx_isqrt_u64((uint64_t)limit_ppm * 159154943u / cycles_m);

    return (int64_t)(sd * PLFX_MODAL_DAMP_LOSS_Q8 / 256u);
}

plfx_status plfx_modal_alarm(const plfx_modal *m, int32_t limit_ppm, int32_t nsigma_q8,
                             plfx_mode *mode)
{
    int32_t blocks;

    if (!m || !mode || limit_ppm < 0 || limit_ppm > 1000000 || nsigma_q8 < 0 ||
        nsigma_q8 > 65535) {
        return PLFX_E_ARG;
    }
    /* at most 5 */
    for (blocks = 1; blocks <= PLFX_MODAL_BLOCKS; blocks *= 2) {
        int64_t sigma;
        plfx_sure(plfx_modal_read(m, blocks, mode));
        sigma = sigma_at(mode, limit_ppm);
        sigma = sigma > (int64_t)mode->damp_sigma_ppm ? sigma
                                                      : (int64_t)mode->damp_sigma_ppm;
        if ((mode->flags & (PLFX_MODE_VALID | PLFX_MODE_SHORT)) == PLFX_MODE_VALID &&
            m->used >= blocks && mode->damp_ppm + sigma * nsigma_q8 / 256 < limit_ppm) {
            mode->flags |= PLFX_MODE_ALARM;
            return PLFX_OK;
        }
    }
    return PLFX_OK;
}
