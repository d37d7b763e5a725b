/* SPDX-License-Identifier: MIT
 * What the files of roi.c share: patches in the workspace and their sums. */
#ifndef PLENOFIX_SRC_ROI_STATE_H
#define PLENOFIX_SRC_ROI_STATE_H

#include "plenofix/roi.h"

#define PLFX_ROI_SIDE   (2 * PLFX_ROI_HALF_MAX + 1)
#define PLFX_ROI_WIDE   (PLFX_ROI_SIDE + 2 * PLFX_ROI_MARGIN)
#define PLFX_ROI_UNUSED 65535u   /* a rest sample that takes no part */
#define PLFX_ROI_ONE    16777216 /* a lens, q24 */

/* Sums over the samples of a patch; differences d to the rest state. */
typedef struct plfx_roi_sums {
    int64_t b[3];   /* of g*d: along columns, rows, slope */
    int64_t bright; /* of d where the rest is bright */
    int64_t dark;   /* of d elsewhere */
    int64_t energy; /* of d*d, < 2^32 * 2^18 */
    int64_t apart;  /* of d less its mean over the views, lens by lens */
    int32_t clipped;
} plfx_roi_sums;

/* Energy that the rest state R gives to differences when it is displaced to R'. */
typedef struct plfx_roi_energies {
    int32_t square[PLFX_ROI_NODES];  /* (R'-R)^2, mean of a sample, in 4 */
    int32_t product[PLFX_ROI_NODES]; /* (R'-R)*R, mean of a sample, in 16 */
    int64_t cross[3];                /* of a unit slope, and with x, with y; sums */
    int64_t lean;                    /* (R'-R)*R of a unit slope, its even part; sum */
    int64_t ref;                     /* sum of R*R */
} plfx_roi_energies;

typedef struct plfx_roi_patch {
    int32_t i0, j0, w, h; /* first lens at rest, lenses */
    int32_t ki, kj;       /* whole lenses followed */
    uint32_t flags;       /* of the rest state */
    int32_t used;         /* samples that take part */
    uint32_t split;       /* rest samples from here on are bright */
    uint16_t *wide;       /* [view][h+6][w+6]: sums, then mean of the rest frames */
    uint16_t *gain;       /* [view][h+6][w+6] u13, or NULL */
    uint16_t *ref;        /* [view][h][w] */
    int16_t *gx, *gy;     /* [view][h][w] */
    int64_t rest_square;  /* sum of squares of the patch's rest samples, 12 bits */
    int64_t n_bright, n_dark, ref_bright, ref_dark;
    int64_t scale[3]; /* square roots of the information's diagonal */
    int32_t inv_q24[3][3];
    int32_t alpha_q12[3], beta_q12[3];    /* taken off g in the bright and dark half */
    int64_t noise_q8;                     /* variance of a sample at rest; 0: unknown */
    uint32_t spread_q12[3];               /* standard error over rms/scale */
    uint32_t common_q12[3];               /* the same for errors that all views share */
    int32_t reads_q24[3][PLFX_ROI_NODES]; /* what known displacements read */
    int32_t leans_q24[3][PLFX_ROI_NODES]; /* and its change a unit of slope */
    int32_t gain_q20[PLFX_ROI_NODES];     /* brightness that the displacement feigns */
    int32_t offset_q4[PLFX_ROI_NODES];
    plfx_roi_energies all;   /* of every sample */
    plfx_roi_energies apart; /* less the mean over the views, lens by lens */
    int32_t own_q12;         /* share of the noise's variance that lies apart */
    int32_t chance_q12;      /* three standard errors of a variance of all samples */
} plfx_roi_patch;

/* Is sample (x, y) of the rest state with its margin one of the patch? */
static inline int32_t plfx_roi_within(const plfx_roi_patch *p, int32_t x, int32_t y)
{
    return x >= PLFX_ROI_MARGIN && x < PLFX_ROI_MARGIN + p->w && y >= PLFX_ROI_MARGIN &&
           y < PLFX_ROI_MARGIN + p->h;
}

/* Row y of view k of the patch, displaced by whole lenses: samples x0 .. x0+n-1 counted
 * from the patch's first lens; 16 bits, PLFX_ROI_UNUSED where clipped. */
void plfx_roi_sample(const plfx_roi *roi, const plfx_roi_frame *frame,
                     const plfx_roi_patch *p, int32_t k, int32_t y, int32_t x0,
                     int32_t n, uint16_t *out);

/* Does the frame fit?  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE. */
plfx_status plfx_roi_frame_ok(const plfx_roi *roi, const plfx_roi_frame *frame);

/* Row y of view k of the rest state displaced by (x, y): R(. - (dx, dy)), q16 lenses,
 * |dx|, |dy| <= 1. */
void plfx_roi_warp(const plfx_roi_patch *p, int32_t k, int32_t y, int32_t dx_q16,
                   int32_t dy_q16, uint16_t *out);

/* Take a row of a view, its first sample number `at` of the patch, into the sums of the
 * view and of the lenses of that row. */
void plfx_roi_add(const plfx_roi_patch *p, size_t at, const uint16_t *row,
                  plfx_roi_sums *view, int32_t *lens);

/* Energies of the means over the views, lens by lens. */
typedef struct plfx_roi_shared {
    int64_t square;  /* of d, < 2^50 */
    int64_t product; /* of d with R */
    int64_t ref;     /* of R */
} plfx_roi_shared;

/* floor(sqrt(v)), one copy of it. */
uint32_t plfx_roi_root(uint64_t v);

/* sqrt(a*a + b*b). */
uint64_t plfx_roi_hypot(uint64_t a, uint64_t b);

/* From sums of d over the views of each lens, |lens[]| < 2^23; without `with_ref`
 * square alone. */
plfx_roi_shared plfx_roi_share(const plfx_roi *roi, const plfx_roi_patch *p,
                               const int32_t *lens, int32_t with_ref);

/* Add the sums of a view, its slope term by its lean, and clear them. */
void plfx_roi_close(const int32_t lean_q12[2], plfx_roi_sums *view, plfx_roi_sums *all);

/* Brightness that the sums look like, motion included: d = (gain-1)*R + offset. */
typedef struct plfx_roi_light {
    int32_t gain_q20;
    int32_t offset_q4; /* 16-bit steps */
} plfx_roi_light;

plfx_roi_light plfx_roi_light_of(const plfx_roi_patch *p, const plfx_roi_sums *s);

/* Linear estimate before the table: columns, rows, slope, q24. */
void plfx_roi_linear(const plfx_roi_patch *p, const plfx_roi_sums *s, int32_t gain_q20,
                     int32_t out_q24[3]);

/* Complete the rest state of a patch, in this order while it has no flag: samples and
 * gradients; information, inverse and standard errors; table of known displacements. */
void plfx_roi_learn(const plfx_roi *roi, plfx_roi_patch *p);
void plfx_roi_inform(const plfx_roi *roi, plfx_roi_patch *p);
void plfx_roi_tabulate(const plfx_roi *roi, plfx_roi_patch *p);

#endif
