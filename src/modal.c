/* SPDX-License-Identifier: MIT
 * Channel in: mixing, thinning, sums of lags. */
#include "plenofix/modal.h"
#include "fix.h"

#include <string.h>

#define RATE_MIN  1000u
#define RATE_MAX  8000000u
#define EVERY_MAX 2048

/* First quarter of a sine, q15. */
static const int16_t quarter[129] = {
    0,     402,   804,   1206,  1608,  2009,  2410,  2811,  3212,  3612,  4011,  4410,
    4808,  5205,  5602,  5998,  6393,  6786,  7179,  7571,  7962,  8351,  8739,  9126,
    9512,  9896,  10278, 10659, 11039, 11417, 11793, 12167, 12539, 12910, 13279, 13645,
    14010, 14372, 14732, 15090, 15446, 15800, 16151, 16499, 16846, 17189, 17530, 17869,
    18204, 18537, 18868, 19195, 19519, 19841, 20159, 20475, 20787, 21096, 21403, 21705,
    22005, 22301, 22594, 22884, 23170, 23452, 23731, 24007, 24279, 24547, 24811, 25072,
    25329, 25582, 25832, 26077, 26319, 26556, 26790, 27019, 27245, 27466, 27683, 27896,
    28105, 28310, 28510, 28706, 28898, 29085, 29268, 29447, 29621, 29791, 29956, 30117,
    30273, 30424, 30571, 30714, 30852, 30985, 31113, 31237, 31356, 31470, 31580, 31685,
    31785, 31880, 31971, 32057, 32137, 32213, 32285, 32351, 32412, 32469, 32521, 32567,
    32609, 32646, 32678, 32705, 32728, 32745, 32757, 32765, 32767};

/* sin(2*pi*k/512), q15. */
static int32_t sine(uint32_t k)
{
    uint32_t q = k >> 7 & 3u;
    uint32_t r = k & 127u;
    int32_t v = quarter[q % 2u ? 128u - r : r];

    return q >= 2u ? -v : v;
}

int32_t plfx_modal_every(uint32_t rate_mhz, uint32_t freq_uhz, int32_t damp_ppm)
{
    uint64_t rate = (uint64_t)rate_mhz * 1000u; /* uHz */
    uint64_t want;
    uint64_t least = (uint64_t)freq_uhz * 2u / 5u + 1u;

    want = (uint64_t)freq_uhz * (uint64_t)plfx_max_i32(damp_ppm, 0) / 1000000u * 45u;
    want = want > least ? want : least;
    rate = (rate + want / 2u) / want;
    return rate < 1u ? 1 : rate > EVERY_MAX ? EVERY_MAX : (int32_t)rate;
}

static int32_t cfg_ok(const plfx_modal_cfg *c)
{
    return c->rate_mhz >= RATE_MIN && c->rate_mhz <= RATE_MAX && c->freq_uhz > 0 &&
           c->freq_uhz < c->rate_mhz * 500u && c->every >= 1 && c->every <= EVERY_MAX &&
           c->block >= 8 && c->block <= 1 << 17 && c->mean_log2 >= 4 &&
           c->mean_log2 <= 16;
}

plfx_status plfx_modal_init(plfx_modal *m, const plfx_modal_cfg *cfg)
{
    uint32_t gain;

    if (!m || !cfg || !cfg_ok(cfg)) {
        return PLFX_E_ARG;
    }
    memset(m, 0, sizeof *m);
    m->cfg = *cfg;
    m->step =
        (uint32_t)(((uint64_t)cfg->freq_uhz << 32) / ((uint64_t)cfg->rate_mhz * 1000u));
    gain = (uint32_t)cfg->every * (uint32_t)cfg->every;
    while (gain > 32u) { /* at most 17 */
        gain = (gain + 1u) / 2u;
        m->shift++;
    }
    return PLFX_OK;
}

/* The sums of the newest thinned sample with those before it. */
static void add_lags(plfx_modal *m)
{
    int64_t re = m->y_re; /* 2^20: products < 2^41, 2^17 of them < 2^58 */
    int64_t im = m->y_im;
    int32_t l;

    m->now.energy[0] += re * re + im * im;
    m->now.n++;
    for (l = 1; l <= m->since; l++) {
        int64_t pr = m->past_re[l - 1];
        int64_t pi = m->past_im[l - 1];
        m->now.re[l] += pr * re + pi * im;
        m->now.im[l] += pr * im - pi * re;
        m->now.energy[l] += pr * pr + pi * pi;
    }
    for (l = PLFX_MODAL_LAGS - 1; l > 0; l--) {
        m->past_re[l] = m->past_re[l - 1];
        m->past_im[l] = m->past_im[l - 1];
    }
    m->past_re[0] = m->y_re;
    m->past_im[0] = m->y_im;
    m->since = plfx_min_i32(m->since + 1, PLFX_MODAL_LAGS);
}

static void end_block(plfx_modal *m)
{
    m->ring[m->head] = m->now;
    m->head = (m->head + 1) % PLFX_MODAL_BLOCKS;
    m->used = plfx_min_i32(m->used + 1, PLFX_MODAL_BLOCKS);
    memset(&m->now, 0, sizeof m->now);
}

static int32_t scaled(int64_t v, int32_t shift)
{
    return (int32_t)(shift > 0 ? plfx_round_shift_i64(v, shift) : v);
}

/* End of a period of R samples x(0) .. x(R-1).  The triangle of weights 1 .. R .. 1
 * over two periods is the sum over the last one of (i+1)*x(i), kept in half, and over
 * this one of (R-1-i)*x(i) = run - sum. */
static void thin(plfx_modal *m)
{
    int64_t r = m->cfg.every;
    int64_t re = m->half_re + m->run_re - m->sum_re; /* < 2^17 * 2^22 */
    int64_t im = m->half_im + m->run_im - m->sum_im;

    m->half_re = (r + 1) * m->sum_re - m->run_re;
    m->half_im = (r + 1) * m->sum_im - m->run_im;
    m->sum_re = 0;
    m->sum_im = 0;
    m->run_re = 0;
    m->run_im = 0;
    m->fill = 0;
    m->y_re = scaled(re, m->shift);
    m->y_im = scaled(im, m->shift);
}

/* Sample less the slow mean, at most 16 bits and a sign. */
static int32_t without_mean(plfx_modal *m, int32_t x)
{
    int64_t x_q16 = (int64_t)x * 65536;

    if (!m->primed) {
        m->primed = 1;
        m->mean_q16 = x_q16;
    }
    m->mean_q16 += plfx_asr_i64(x_q16 - m->mean_q16, m->cfg.mean_log2);
    return (int32_t)plfx_round_shift_i64(x_q16 - m->mean_q16, 16);
}

int32_t plfx_modal_push(plfx_modal *m, int16_t x)
{
    int32_t v = without_mean(m, x);
    uint32_t k = m->phase >> 23;

    m->sum_re += plfx_round_shift_i64((int64_t)v * sine(k + 128u), 15);
    m->sum_im -= plfx_round_shift_i64((int64_t)v * sine(k), 15);
    m->run_re += m->sum_re;
    m->run_im += m->sum_im;
    m->phase += m->step;
    m->fill++;
    if (m->fill < m->cfg.every) {
        return 0;
    }
    thin(m);
    add_lags(m);
    if (m->now.n >= m->cfg.block) {
        end_block(m);
    }
    return 1;
}

void plfx_modal_gap(plfx_modal *m, uint32_t n)
{
    if (n > 0) {
        m->phase += m->step * n; /* modulo a turn */
        m->sum_re = 0;
        m->sum_im = 0;
        m->run_re = 0;
        m->run_im = 0;
        m->half_re = 0;
        m->half_im = 0;
        m->fill = 0;
        m->since = 0;
        m->now.gap = 1;
    }
}

void plfx_modal_shape_add(plfx_modal_shape *s, const plfx_modal *channel,
                          const plfx_modal *ref)
{
    int64_t a = channel->y_re;
    int64_t b = channel->y_im;
    int64_t c = ref->y_re;
    int64_t d = ref->y_im;

    s->re += a * c + b * d;
    s->im += b * c - a * d;
    s->ref += c * c + d * d;
}
