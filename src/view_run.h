/* SPDX-License-Identifier: MIT
 * Views side by side: of each of some lenses a run of neighbouring pixels becomes a run
 * of samples, one a view.  Plain pixels of 12 bits and less. */
#ifndef PLENOFIX_SRC_VIEW_RUN_H
#define PLENOFIX_SRC_VIEW_RUN_H

#include "taps.h"

#define PLFX_RUN_LENSES 8
#define PLFX_RUN_VIEWS  16

/* Rows of many views are written side by side, a piece of each: their next lines, so
 * many samples on, are called into the cache, or a third of the time is spent waiting
 * for them.  An address beyond the rows does no harm. */
#define PLFX_RUN_AHEAD 32
#if defined(__GNUC__)
#define PLFX_WILL_WRITE(p) __builtin_prefetch(p, 1)
#else
#define PLFX_WILL_WRITE(p) ((void)0)
#endif

typedef struct plfx_view_run {
    const uint16_t *px; /* the frame */
    int32_t w;
    const int32_t *x_q16, *y_q16;  /* [PLFX_RUN_LENSES] centres */
    plfx_point first;              /* displacement of the first view, with 1/2 */
    const uint16_t *x_u16, *y_u16; /* [PLFX_RUN_VIEWS] fractions of displacements */
    int32_t down;                  /* bits - 8 */
    int32_t toned; /* 0: samples are 16-bit means, gains are still to come */
    plfx_curve curve;
} plfx_view_run;

/* Samples of all lenses, views one pixel apart. */
void plfx_view_tile(const plfx_view_run *r, uint16_t (*restrict tile)[PLFX_RUN_VIEWS]);

/* to[i*step + lens] = tile[lens][i] for n views. */
void plfx_view_turn(uint16_t (*restrict tile)[PLFX_RUN_VIEWS], int32_t n,
                    uint16_t *restrict to, size_t step);

#endif
