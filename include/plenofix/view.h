/* SPDX-License-Identifier: MIT
 * Sub-aperture views: for fixed (u,v), sample the raw frame beside every lens centre.
 * u runs along the lattice step a, v perpendicular to it (a turned by +90 degrees),
 * both in sensor pixels from the lens centre.
 *
 * Scaling and overflow.  Raw pixels are taken left-justified to 16 bits.  Along x:
 *   h = (p0*(256-fx) + p1*fx + r) >> k,   k = raw bits - 8, r = 2^(k-1) (0 when k = 0)
 * h again in 16 bits (p right-justified, at most 24 bits before the shift).  Along y:
 *   s = (h0*(256-fy) + h1*fy + 128) >> 8      16 bits
 * then black level, white gain (u13) and tone (q12 mantissa, shift), all in 32 bits:
 *   t = max(s - black, 0);   t = (t*gain + 4096) >> 13            19 bits
 *   out = min((t*tone.gain_q12 + r) >> (28 - bits - shift), 2^bits - 1)
 * Weights sum to 256 on each axis: a constant frame gives a constant view.  s >=
 * sat_u16 gives 2^bits - 1 whatever the gain: clipped stays clipped.  The first two
 * roundings are of 2^-17 of full scale: they buy 16-bit storage between two raw
 * rows. */
#ifndef PLENOFIX_VIEW_H
#define PLENOFIX_VIEW_H

#include "plenofix/image.h"
#include "plenofix/lut.h"
#include "plenofix/raw.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_DECODE_MAX 1024 /* views of one call; a plan takes PLFX_VIEWS_MAX */

typedef struct plfx_offset { /* where in the micro-image a view looks */
    int16_t u_q8, v_q8; /* sensor pixels from the lens centre, -128 .. 128 - 2^-8 */
} plfx_offset;

typedef struct plfx_tone { /* raw sample -> view sample, the same for all views */
    uint16_t black_u16;    /* subtracted, full scale 65535 */
    uint16_t sat_u16;      /* at or above: clipped; 65535 to leave only true clipping */
    uint16_t gain_q12;     /* 4096 .. 8191: 1 .. 2 - 2^-12 */
    int8_t shift;          /* -8 .. 8, a further factor 2^shift */
    uint8_t bits;          /* of a view sample, PLFX_BITS_MIN .. PLFX_BITS_MAX */
    int16_t dx_q8, dy_q8;  /* added to every sampling point, sensor pixels, -1 .. 1 */
} plfx_tone;

/* The identity tone: black 0, gain 1, nothing clipped but full scale. */
plfx_tone plfx_tone_unity(int32_t bits);

/* Sampling displacement of an offset in sensor x and y, q16 pixels: (u,v) turned by the
 * angle of the step a. */
plfx_point plfx_view_offset(const plfx_lut *lut, plfx_offset at);

/* Fill lens rows j0 .. j1-1 of view k of `out` (out->nx, ny as in the table).  Samples
 * off the sensor take the nearest edge pixel; lenses flagged MISSING take the
 * mean of the nearest measured lenses to their left and right (one, or 0, where there
 * is no other). white: use the table's GAIN section (no effect when it has none) The
 * raw frame must have the table's size.  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE. */
plfx_status plfx_view_rows(const plfx_lut *lut, const plfx_raw *raw,
                           const plfx_tone *tone, plfx_offset at, int32_t white,
                           int32_t j0, int32_t j1, const plfx_views *out,
                           int32_t k) PLFX_MUST_USE;

/* All views `at[0..n)` of a whole frame; n = out->n, 1 .. PLFX_DECODE_MAX.  Same
 * errors.  Cost, x86-64-v3: 18 instructions a sample where views lie one pixel apart
 * along u in a plain frame of up to 12 bits; about 50 elsewhere, more where pixels are
 * packed: they are unpacked two at a time. */
plfx_status plfx_view_all(const plfx_lut *lut, const plfx_raw *raw,
                          const plfx_tone *tone, const plfx_offset *at, int32_t white,
                          const plfx_views *out) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
