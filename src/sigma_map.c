/* SPDX-License-Identifier: MIT
 * Standard errors of a whole map (frame.h): what the refinement states of a window, and
 * in quadrature what tells of another surface.
 *   Misfit over the usual one of the frame.
 *   Rival, of a margin c:  R max(0, 1 - c (1 + noise/14)/0.64)^3, noise in grey levels,
 *     which lowers all margins alike.
 *   Boundary, of the share o of 7x7 samples that lie outside the gate:
 *     R (1 - c/1.39) (0.55 o + 11.6 o^4), as a majority elsewhere likely is right. */
#include <string.h>

#include "refine_state.h"
#include "fix.h"

#define ROOT_MAX   ((uint64_t)1 << 30)
#define BIN_LEAST  160u   /* of a misfit of 32 */
#define RIVAL_CONF 41943u /* 0.64 */
#define BOUND_CONF 91095u /* 1.39 */
#define NOISE_Q4   224u   /* 14 grey levels */
#define REACH      3      /* of 7x7 */

/* Exponent and five bits; no misfit lies under 819 (refine.c). */
static uint32_t bin_of(uint32_t v)
{
    uint32_t e = 0;

    while (v >> e > 1u) { /* at most 31 times */
        e++;
    }
    return (e << 5) | ((v >> (e - 5u)) & 31u);
}

/* Middle of the misfits, q8: 2 % fine. */
static uint32_t usual_misfit(const plfx_frame_state *s, uint32_t *bin)
{
    size_t n = (size_t)s->nx * (size_t)s->ny;
    uint32_t k = BIN_LEAST;
    size_t seen;
    size_t i;

    memset(bin, 0, PLFX_MISFIT_BINS * sizeof *bin);
    for (i = 0; i < n; i++) {
        bin[bin_of(s->misfit[i])]++;
    }
    seen = bin[k];
    while (2 * seen < n) { /* at most PLFX_MISFIT_BINS: they hold n */
        k++;
        seen += bin[k];
    }
    return (32u | (k & 31u)) << ((k >> 5) - 5u);
}

/* What chance gives: two standard errors above: half of a residual's square is
 * the reference's noise, the same for all views, so that a window of w^2 pixels holds
 * w^2/c of it: 2 sqrt(2 c/w^2)/2, c the filter's reach, 64/9 of smoothed views. */
static uint32_t chance_misfit(const plfx_frame_state *s, uint32_t usual)
{
    uint32_t root_q8 = s->smooth ? 966u : 362u; /* sqrt(2 c) */

    return plfx_cut_u32(usual + (((uint64_t)usual * root_q8 / s->cfg.window) >> 8));
}

/* R max(0, 1 - c (1 + noise/14)/0.64)^3, q16 columns. */
static uint64_t rival_of(const plfx_frame_state *s, uint16_t conf)
{
    uint32_t c = conf * (NOISE_Q4 + s->cfg.noise_q4) / NOISE_Q4;
    uint64_t near_q8 = c < RIVAL_CONF ? (RIVAL_CONF - c) * 256u / RIVAL_CONF : 0u;

    return (near_q8 * near_q8 * near_q8 * s->cfg.rival_q8) >> 16;
}

/* R (1 - c/1.39) (0.55 o + 11.6 o^4), o = n/49, q16 columns. */
static uint64_t boundary_of(const plfx_frame_state *s, uint16_t conf, uint32_t n)
{
    uint32_t share_q16 = n * 735u + (n * n * n * n * 135u >> 10); /* n <= 48 */
    uint64_t near_q8 = 256u - conf * 256u / BOUND_CONF;

    return (near_q8 * share_q16 * s->cfg.rival_q8) >> 16;
}

/* Samples of row y of e whose neighbour at (dx,dy) lies outside the gate. */
static void count_outside(const plfx_frame_state *s, const int32_t *e, int32_t y,
                          int32_t dx, int32_t dy, uint8_t *count)
{
    int32_t gate = s->cfg.gate_q8 * 256;
    int32_t to = plfx_clamp_i32(y + dy, 0, s->ny - 1);
    const int32_t *here = e + (size_t)y * (size_t)s->nx;
    const int32_t *there = e + (size_t)to * (size_t)s->nx;
    int32_t x;

    for (x = plfx_max_i32(0, -dx); x < plfx_min_i32(s->nx, s->nx - dx); x++) {
        int32_t d = there[x + dx] - here[x];
        count[x] = (uint8_t)(count[x] + (plfx_max_i32(d, -d) >= gate));
    }
}

static void outside_row(const plfx_frame_state *s, const int32_t *e, int32_t y,
                        uint8_t *count)
{
    int32_t dx;
    int32_t dy;

    memset(count, 0, (size_t)s->nx);
    for (dy = -REACH; dy <= REACH; dy++) {
        for (dx = -REACH; dx <= REACH; dx++) {
            count_outside(s, e, y, dx, dy, count);
        }
    }
}

static uint64_t square_of(uint64_t v)
{
    v = v < ROOT_MAX ? v : ROOT_MAX;
    return v * v;
}

/* Standard error of the slope of sample i; `usual` as chance_misfit() tells. */
static uint16_t sigma_of(const plfx_frame_state *s, size_t i, uint32_t usual,
                         uint32_t outside)
{
    uint32_t over = s->misfit[i] > usual ? s->misfit[i] - usual : 0u;
    uint64_t more =
        ((uint64_t)s->lever[i] * plfx_isqrt_u64(over)) >> 8; /* q20 q4 -> q16 */
    uint64_t sum = square_of(s->base[i]) + square_of(more) +
                   square_of(rival_of(s, s->conf[i])) +
                   square_of(boundary_of(s, s->conf[i], outside)); /* under 2^63 */

    return plfx_frame_sigma(s, plfx_cut_u32(plfx_isqrt_u64(sum)));
}

size_t plfx_sigma_scratch(const plfx_frame_state *s)
{
    return PLFX_MISFIT_BINS * sizeof(uint32_t) + (size_t)s->nx;
}

void plfx_sigma_map(const plfx_frame_state *s, const int32_t *e)
{
    uint32_t *bin = s->scratch;
    uint8_t *count = (uint8_t *)(bin + PLFX_MISFIT_BINS);
    uint32_t usual = chance_misfit(s, usual_misfit(s, bin));
    size_t i = 0;
    int32_t y;
    int32_t x;

    memset(count, 0, (size_t)s->nx);
    for (y = 0; y < s->ny; y++) {
        if (s->cfg.rival_q8) {
            outside_row(s, e, y, count);
        }
        for (x = 0; x < s->nx; x++, i++) {
            s->sigma[i] = sigma_of(s, i, usual, count[x]);
        }
    }
}
