/* SPDX-License-Identifier: MIT
 * What the refinement and its standard errors share. */
#ifndef PLENOFIX_SRC_REFINE_STATE_H
#define PLENOFIX_SRC_REFINE_STATE_H

#include "frame_state.h"
#include "fix.h"

#define PLFX_TUKEY_STEPS 256
#define PLFX_MISFIT_BINS 1024 /* 32 an octave */

/* Of a pixel or a window, as refine.c tells. */
typedef struct plfx_sums {
    int64_t a, b, r;
    int32_t w, n;
} plfx_sums;

typedef struct plfx_refine_work {
    plfx_sums *ring;  /* [window][nx] */
    int32_t *gx, *gy; /* [nx] */
    int32_t *value;   /* [nx] */
    uint16_t *tukey;  /* [PLFX_TUKEY_STEPS] */
    int32_t *score;   /* [window + 4][window + 4] */
    int64_t noise_q8; /* of A, a view of weight 1 */
    int32_t last;     /* the pass whose standard errors count */
} plfx_refine_work;

typedef struct plfx_refine_window {
    int32_t x0, x1, y0, y1; /* inclusive, inside the map */
} plfx_refine_window;

typedef struct plfx_solution {
    int64_t a, lambda; /* information without noise's share; of the prior */
    int64_t misfit_q8; /* mean w r^2, counts^2 */
    int32_t step;      /* q16 columns */
    int32_t samples;
} plfx_solution;

static inline plfx_sums *plfx_refine_row(const plfx_frame_state *s,
                                         const plfx_refine_work *t, int32_t y)
{
    return t->ring + (size_t)(y % s->cfg.window) * (size_t)s->nx;
}

static inline uint32_t plfx_cut_u32(uint64_t v)
{
    return (uint32_t)plfx_clamp_i64((int64_t)v, 0, UINT32_MAX); /* v < 2^63 */
}

/* What a standard error needs of pixel `at`. */
void plfx_sigma_pixel(const plfx_frame_state *s, const plfx_refine_work *t,
                      const int32_t *e, plfx_refine_window w, size_t at,
                      const plfx_solution *v);

#endif
