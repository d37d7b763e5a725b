/* SPDX-License-Identifier: MIT
 * Modes in flight: frequency, damping and amplitude of one vibration mode in one
 * channel of samples, each with its standard error, in integers and bounded work.
 *
 * Method.  The sample, less a slow mean, is mixed with a complex oscillator at the
 * mode's expected frequency, thinned by a second-order CIC (two running sums of `every`
 * samples), and its complex autocorrelation R(l) is summed for lags 0 .. 5, block by
 * block.  A lightly damped mode under random excitation has
 *   R(l) ~ exp((-zeta*w + i*(w - w0))*l*dt),
 * so the slope of ln|R| over lags 1 .. 5, weighted by |R|^2, gives the damping and the
 * slope of the phase the frequency.  Each R(l) is divided by the energy of the samples
 * l back, which makes the same lines exact for a free decay and for growth.  Unlike the
 * half-power width of a spectrum this is unbiased at records of a minute.
 *
 * Standard errors follow the bound of a randomly excited mode (Gersch 1974): with
 * n = f*T cycles in the record, var f/f = zeta/(2*pi*n) and var zeta/zeta =
 * 1/(2*pi*zeta*n), multiplied by PLFX_MODAL_*_LOSS_Q8 and by R(0)/(R(0) of the fit),
 * the share of noise.
 *
 * Work per sample: 2 multiplications and 12 additions; per thinned sample 24
 * multiply-adds.  Scaling: oscillator q15 from a table of 512; products cut to 16 bits;
 * CIC sums < 16 + 2*12 bits in int64, cut to 20; products of lags < 2^41, at most 2^17
 * of them in a block, so that 17 blocks stay under 2^63. */
#ifndef PLENOFIX_MODAL_H
#define PLENOFIX_MODAL_H

#include "plenofix/base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_MODAL_LAGS   5
#define PLFX_MODAL_BLOCKS 16 /* blocks of a record, the oldest dropped first */
/* Scatter of this estimator over the bound, q8; test_modal.c holds a part of it. */
#define PLFX_MODAL_FREQ_LOSS_Q8 300u
#define PLFX_MODAL_DAMP_LOSS_Q8 340u

#define PLFX_MODE_VALID 1u /* values hold; without it they are 0 */
#define PLFX_MODE_SHORT 2u /* under 20 cycles, or no full block yet */
/* R does not fall off like a mode's: noise, no motion, a damping over critical, or a
 * frequency a quarter of the thinned rate or more off the expected one. */
#define PLFX_MODE_LOST  4u
#define PLFX_MODE_GAP   8u  /* samples were missing inside the record */
#define PLFX_MODE_ALARM 16u /* damping is under the limit, standard error included */

typedef struct plfx_modal_cfg {
    uint32_t rate_mhz; /* samples in 1000 s, 1000 .. 8000000 */
    uint32_t freq_uhz; /* expected frequency, under half the rate */
    int32_t every;     /* thinning, 1 .. 2048: plfx_modal_every() */
    int32_t block;     /* thinned samples of a block, 8 .. 2^17 */
    int32_t mean_log2; /* slow mean over 2^this samples, 4 .. 16 */
} plfx_modal_cfg;

typedef struct plfx_modal_sums {     /* one block */
    int64_t re[PLFX_MODAL_LAGS + 1]; /* products with the sample l back; 0: unused */
    int64_t im[PLFX_MODAL_LAGS + 1];
    int64_t energy[PLFX_MODAL_LAGS + 1]; /* of the samples l back */
    int32_t n;                           /* thinned samples */
    int32_t gap;                         /* 1: samples were missing */
} plfx_modal_sums;

/* One channel and mode.  Plain data: copy it, save it, clear it. */
typedef struct plfx_modal {
    plfx_modal_cfg cfg;
    uint32_t step, phase; /* oscillator, 2^32 a turn */
    int64_t mean_q16;
    int64_t sum_re, sum_im;   /* of this period of `every` samples */
    int64_t run_re, run_im;   /* sums of its running sums */
    int64_t half_re, half_im; /* rising half of the triangle, from the last period */
    int32_t fill, primed;     /* samples in the period; 1: mean started */
    int32_t shift;            /* CIC gain to 20 bits */
    int32_t head, used;       /* ring of finished blocks */
    int32_t since;            /* thinned samples since a gap, at most LAGS */
    int32_t y_re, y_im;       /* newest thinned sample */
    int32_t past_re[PLFX_MODAL_LAGS], past_im[PLFX_MODAL_LAGS];
    plfx_modal_sums now;
    plfx_modal_sums ring[PLFX_MODAL_BLOCKS];
} plfx_modal;

typedef struct plfx_mode { /* what was measured, each with its standard error */
    uint32_t freq_uhz, freq_sigma_uhz;
    int32_t damp_ppm; /* millionths of critical damping */
    uint32_t damp_sigma_ppm;
    uint32_t amp_q8, amp_sigma_q8; /* rms of the motion, steps of the samples */
    uint32_t record_ms;
    uint32_t flags; /* PLFX_MODE_* */
} plfx_mode;

/* Thinning at which a mode of damping damp_ppm loses about half of its correlation
 * over the lags: the thinned rate is 45*zeta*f, at least 0.4*f; 1 .. 2048. */
int32_t plfx_modal_every(uint32_t rate_mhz, uint32_t freq_uhz, int32_t damp_ppm);

/* Check and start.  PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_modal_init(plfx_modal *m, const plfx_modal_cfg *cfg) PLFX_MUST_USE;

/* One sample.  Returns 1 when a new thinned sample stands in y_re, y_im, else 0. */
int32_t plfx_modal_push(plfx_modal *m, int16_t x);

/* n samples are missing: the oscillator is turned on, the broken correlation dropped
 * and the block marked; nothing is interpolated. */
void plfx_modal_gap(plfx_modal *m, uint32_t n);

/* The mode over the newest `blocks` finished blocks and the one under way,
 * 1 .. PLFX_MODAL_BLOCKS.  PLFX_OK (read flags), PLFX_E_ARG. */
plfx_status plfx_modal_read(const plfx_modal *m, int32_t blocks,
                            plfx_mode *mode) PLFX_MUST_USE;

/* Alarm: damping + nsigma_q8/256 standard errors < limit_ppm (0 .. 10^6) over one of
 * the windows of the newest 1, 2, 4, 8 or 16 finished blocks.  The standard error is
 * the greater of the mode's own and the one that a damping of limit_ppm would have over
 * that window: a short window that reads low by chance does not count.  *mode is that
 * window's, with PLFX_MODE_ALARM, or the longest.  PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_modal_alarm(const plfx_modal *m, int32_t limit_ppm, int32_t nsigma_q8,
                             plfx_mode *mode) PLFX_MUST_USE;

/* Watch for a loss of damping, faster than the alarm: a cumulative sum (Page 1954) of
 * the logarithm of the likelihood of damping limit_ppm over that of healthy_ppm.  The
 * envelope of a randomly excited mode decays with a = zeta*omega and is kicked by
 * sigma^2 a second; with q = |y|^2/sigma^2 a step adds
 *   (a0 - a1)*(q(t) - q(t-1)) + (a0^2 - a1^2)*dt*(q(t) + q(t-1))/2 - (a0 - a1)*dt
 * and the sum starts anew at 0.  sigma^2 is the mean innovation of the record's blocks:
 * excitation that rises within a record reads as evidence, so let blocks be as short as
 * gusts are long.  Noise of measurement only lowers the evidence.
 * nats_q8/256: 9 gives about one false alarm in eight hours at healthy_ppm, 11 one in
 * forty, 12 one in a hundred.
 * The mean delay after a step to limit_ppm is about nats/r seconds with
 * r = 2*pi*f*(healthy - limit)^2/(2*limit), and no test with as few false alarms is
 * faster (Lorden 1971): tests/bench/modal_alarm.c. */
typedef struct plfx_modal_watch {
    int32_t line_q20, square_q20, gain_q16, limit_q20;
    int64_t last_q16;
    int32_t primed;
    int32_t evidence_q20; /* nats; set to 0 to start anew */
} plfx_modal_watch;

/* 0 < limit_ppm < healthy_ppm <= 10^6, nats_q8 256 .. 2^17.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_RANGE (thinning too strong or too weak for them). */
plfx_status plfx_modal_watch_init(plfx_modal_watch *w, const plfx_modal *m,
                                  int32_t limit_ppm, int32_t healthy_ppm,
                                  int32_t nats_q8) PLFX_MUST_USE;

/* Call when plfx_modal_push() has returned 1.  Returns 1 while the evidence is over the
 * limit.  Cost: 64 additions, a root, a division. */
int32_t plfx_modal_watch_add(plfx_modal_watch *w, const plfx_modal *m);

/* Operating shape: sums of y*conj(ref) of a channel against the reference channel, both
 * at the same mode and thinning.  Channel k's complex shape is re/ref, im/ref. */
typedef struct plfx_modal_shape {
    int64_t re, im, ref;
} plfx_modal_shape;

/* Add the newest thinned samples of both; call when both pushes returned 1.
 * At most 2^22 times. */
void plfx_modal_shape_add(plfx_modal_shape *s, const plfx_modal *channel,
                          const plfx_modal *ref);

typedef struct plfx_peak {
    int32_t bin_q8; /* parabola through the logarithms of three bins */
    uint32_t power;
} plfx_peak;

/* The strongest local maxima of a power spectrum, strongest first, at least `apart`
 * bins from each other and over floor_q4/16 times the mean of the spectrum without
 * bin 0.  n: 3 .. 2^20.  *count: 0 .. max.  PLFX_OK, PLFX_E_ARG.  Cost n*max. */
plfx_status plfx_modal_peaks(const uint32_t *power, int32_t n, int32_t apart,
                             int32_t floor_q4, plfx_peak *peaks, int32_t max,
                             int32_t *count) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
