/* SPDX-License-Identifier: MIT
 * Displacement of regions against a rest state, with its standard error.
 *
 * A region is a patch of lenses.  Its rest state is the mean of up to 16 frames in
 * every view.  Each later frame is sampled at the patch's lenses only; the differences
 * d to the rest state R give the joint least-squares displacement p = (x, y, e), x and
 * y columns and rows of lenses, e the change of slope as shift at the aperture's rim:
 *   N p = sum over views and lenses of g*d,   g = -(Rx, Ry, u*Rx + v*Ry)
 * g is made orthogonal to a constant and to R itself (by two sums over the bright and
 * the dark half), so lamp flicker and dark drift do not move the result.
 *
 * Self-calibration.  The rest state is displaced by known amounts with a 6-tap
 * interpolator (25 in-plane positions within +-1/2 lens, 3 slopes) and the same sums
 * are taken; what they read is tabled and inverted in every frame.  That removes the
 * gain error of gradients and their non-linearity.  Larger motion is followed by whole
 * lenses.  No gradient of time: differences against one fixed state, free of drift.
 *
 * Standard error of a frame: the bound from the region's own gradients (inverse of the
 * information matrix), with the correlation of views that share sensor pixels, times
 * the rms of what the displacement leaves unexplained, at least the rest state's noise.
 * What is unexplained is split, lens by lens, into its mean over the views and what
 * lies apart from it.  What the interpolator misses of texture finer than two lenses is
 * alike in all views: it is no noise, and its standard error is that of one view; its
 * size is how far the mean's energy is from the noise, over it or under.  What lies
 * apart is noise, or something before the region at another depth.  The rest state's
 * own error, 1/sqrt(rest) of a frame's, is common to all frames and in no standard
 * error.
 *
 * Work in a frame and region of n lenses in h rows, k views: k*n samples of 3
 * multiply-adds (two more when the raw frame is packed, one with white gains) and 3
 * more for the sums, 5*k*h to begin their rows, 1450 for the solution, 2200 when it has
 * moved by a third of a lens; at most `steps` times that when it has moved by over half
 * a lens; as much again and 2*n*(2*r+1)^2 subtractions, r = max(seek, 1), when it was
 * lost.
 * 24 regions of 7 x 9 lenses, 25 views, as counted on a Cortex-M7 with every product of
 * an address and three for one of 64 bits: 289,000, moved 307,000
 * (tests/bench/multiplies.py).  The rest state costs 75*42*k*n once.
 *
 * Square lattices.  Scaling: samples 16 bits, gradients int16 in 4 units a lens; sums
 * < 2^51 in 64 bits; the inverse is q24 of the information matrix scaled to unit
 * diagonal; displacements q24. */
#ifndef PLENOFIX_ROI_H
#define PLENOFIX_ROI_H

#include "plenofix/view.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_ROI_MAX       64 /* regions */
#define PLFX_ROI_HALF_MAX  20 /* lenses from the centre of a region to its side */
#define PLFX_ROI_MARGIN    3  /* lenses around a region that the rest state needs */
#define PLFX_ROI_REST_MAX  16 /* frames of the rest state */
#define PLFX_ROI_SEEK_MAX  16
#define PLFX_ROI_NODES     25
#define PLFX_ROI_STEPS_MAX 4
#define PLFX_ROI_NONE      INT32_MIN

/* Why a displacement is not valid; the first seven as in image.h. */
#define PLFX_ROI_TEXTURE   1u   /* too little texture, or along one direction only */
#define PLFX_ROI_SATURATED 2u   /* clipped samples */
#define PLFX_ROI_OCCLUDED  4u   /* residual over the limit, or a crowded rest margin */
#define PLFX_ROI_EDGE      8u   /* the patch leaves the lattice */
#define PLFX_ROI_LENS      16u  /* over 1/8 of its lenses are dim or missing */
#define PLFX_ROI_RANGE     32u  /* it moved out of reach */
#define PLFX_ROI_LIGHT     128u /* brightness under 1/4 or over 4 times the rest's */

typedef struct plfx_roi_region {
    int16_t i, j;      /* centre, lens column and row */
    uint8_t hx, hy;    /* half sizes: 2*hx+1 by 2*hy+1 lenses; 1 .. PLFX_ROI_HALF_MAX */
    uint8_t reference; /* 1: stands on rigid structure */
} plfx_roi_region;

typedef struct plfx_roi_cfg {
    const plfx_lut *lut; /* kept; NULL: single images of nx x ny pixels, one view */
    int32_t nx, ny;      /* without a table */
    int32_t bits;        /* of an image's samples, without a table, 8 .. 16 */
    plfx_tone tone;      /* black_u16, sat_u16, dx_q8 and dy_q8 are used */
    int32_t white;       /* use the table's gains */
    int32_t views;       /* 1 .. PLFX_VIEWS_MAX; 1 without a table */
    plfx_offset at[PLFX_VIEWS_MAX];
    int32_t regions; /* 1 .. PLFX_ROI_MAX */
    plfx_roi_region region[PLFX_ROI_MAX];
    int32_t rest;        /* frames, 1 .. PLFX_ROI_REST_MAX */
    int32_t steps;       /* 1 .. PLFX_ROI_STEPS_MAX */
    int32_t seek;        /* lenses around which a lost region is sought, 0 .. 16; the
                            eight lenses around always */
    int32_t residual_q8; /* residual over the rest's noise at which OCCLUDED, variance
                            ratio, 256 .. 65535 */
} plfx_roi_cfg;

typedef struct plfx_roi_frame { /* a frame: raw with a table, image without */
    const plfx_raw *raw;
    const plfx_image *image;
} plfx_roi_frame;

typedef struct plfx_roi_result {
    int32_t u_q24, v_q24; /* in-plane, lens pitches along the lattice step and across */
    int32_t w_q24;        /* change of slope; NONE with one view */
    uint32_t u_sigma_q24, v_sigma_q24, w_sigma_q24;
    uint16_t light_q12;   /* brightness against the rest state */
    uint16_t residual_q8; /* variance over the rest's, the worse of all and apart,
                             saturated; 0 without a noise */
    uint8_t flags;        /* PLFX_ROI_*; 0: valid */
} plfx_roi_result;

struct plfx_roi_patch; /* in the workspace */

typedef struct plfx_roi {
    plfx_roi_cfg cfg;
    struct plfx_roi_patch *patch; /* workspace, the caller's until the last call */
    uint16_t *row;                /* workspace: gains of a lens row */
    int32_t *lens;            /* workspace: sums over the views of a patch's lenses */
    int32_t rested;           /* frames of the rest state so far */
    int32_t rim_q8;           /* greatest |u|, |v| of the views; 0: no slope */
    int32_t col_q12, row_q12; /* P over column and row distance */
    int32_t lean_q12[PLFX_VIEWS_MAX][2]; /* columns and rows a unit of rim shift */
    plfx_point shift[PLFX_VIEWS_MAX];    /* sampling displacement, q16 px */
} plfx_roi;

/* Workspace, bytes: exactly enough; 0 if cfg is out of range. */
size_t plfx_roi_ws(const plfx_roi_cfg *cfg);

/* Upper bound of it for `n` regions of w x h lenses in k views, for static memory, at
 * most 5 % over where regions have 40 lenses and views are 5 or more.
 * gains: cfg.white; nx: lenses in a row. */
#define PLFX_ROI_WS(n, w, h, k, gains, nx)                                             \
    (PLFX_ALIGNED((n)*2048u) + PLFX_ALIGNED(2u * (nx)) +                               \
     PLFX_ALIGNED(4u * (w) * (h)) +                                                    \
     (size_t)(n) * (PLFX_ALIGNED((size_t)2 * (k) * ((w) + 6u) * ((h) + 6u)) *          \
                        ((gains) ? 2u : 1u) +                                          \
                    3u * PLFX_ALIGNED((size_t)2 * (k) * (w) * (h))))

/* Check and start; the rest state is empty.  Regions that leave the lattice with their
 * margin are kept and flagged EDGE.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE, PLFX_E_RANGE (hexagonal lattice). */
plfx_status plfx_roi_init(plfx_roi *roi, const plfx_roi_cfg *cfg, void *ws,
                          size_t ws_size) PLFX_MUST_USE;

/* Add a frame to the rest state; the cfg.rest-th one completes it, which costs as much
 * as some hundred frames.  PLFX_OK, PLFX_E_ARG (frame of another size),
 * PLFX_E_SIZE (frame cut short), PLFX_E_STATE (rest state complete). */
plfx_status plfx_roi_rest(plfx_roi *roi, const plfx_roi_frame *frame) PLFX_MUST_USE;

/* Measure all regions.  out: cfg.regions results.  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE,
 * PLFX_E_STATE (rest state incomplete). */
plfx_status plfx_roi_measure(plfx_roi *roi, const plfx_roi_frame *frame,
                             plfx_roi_result *out) PLFX_MUST_USE;

/* Where region k is looked for next: whole lenses from its rest position.  A caller who
 * knows the motion may set it; |di|, |dj| <= PLFX_LENSES_MAX.  PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_roi_aim(plfx_roi *roi, int32_t k, int32_t di,
                         int32_t dj) PLFX_MUST_USE;

typedef struct plfx_roi_shake {  /* motion of the camera, seen by reference regions */
    int32_t n;                   /* valid references behind it */
    int32_t i_q8, j_q8;          /* their centre, lenses */
    int32_t u_q24, v_q24, w_q24; /* there */
    int32_t turn_q24, zoom_q24;  /* u += zoom*di - turn*dj, v += zoom*dj + turn*di */
    int32_t wi_q24, wj_q24;      /* w += wi*di + wj*dj; lenses */
    uint32_t uv_sigma_q24, w_sigma_q24; /* mean standard error of a reference */
    int32_t spread;                     /* sum of di^2 + dj^2; 0: no turn */
    int32_t ii_q24, ij_q24, jj_q24; /* inverse of the sums behind the tilt; 0: none */
} plfx_roi_shake;

/* Least-squares rigid motion of the valid reference regions: translation from one, turn
 * and zoom from two, tilt of w from three that are not in line.  n = 0: no valid
 * reference, all 0.  The references must be about as far from the camera as the rest.
 * PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_roi_shake_fit(const plfx_roi *roi, const plfx_roi_result *result,
                               plfx_roi_shake *shake) PLFX_MUST_USE;

/* Subtract it from every region's displacement, and add its standard error there,
 * independent of the region's:
 *   in the plane s^2*(1/n + (di^2 + dj^2)/spread), w s^2*(1/n + d'*S^-1*d)
 * with the references' mean standard error s.  Without a tilt (fewer than three
 * references, or all in line) the camera's turn about an axis in the plane stays in w
 * and is in no standard error: 0.9 mm a degree and 50 mm of distance.  References,
 * which are part of what is subtracted, keep their standard errors. */
void plfx_roi_steady(const plfx_roi *roi, const plfx_roi_shake *shake,
                     plfx_roi_result *result);

#ifdef __cplusplus
}
#endif
#endif
