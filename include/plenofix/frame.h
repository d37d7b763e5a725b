/* SPDX-License-Identifier: MIT
 * Depth from a whole frame of views: truncated costs along arms of views, semi-global
 * aggregation, weighted medians and one robust Gauss-Newton step over all views.
 *
 * Cost.  View samples are brought to 12 bits (16 counts a grey level of an 8-bit
 * scale). With d = view warped by the label (bilinear, sixteenths) - reference:
 *   c = min(|d|, T) + w * (min(|dx|, G) + min(|dy|, G))
 * dx, dy central differences of d.  Views are grouped by direction into arms; an arm's
 * cost is the mean of its views, box filtered; the label's cost is the sum of the
 * `keep` cheapest arms (an occluder hides the point from a contiguous part of the
 * views), then the least of 3x3 neighbours (a shiftable window), cut to 8 bits at half
 * of its range.
 *
 * Aggregation (Hirschmueller 2008): along each path r
 *   L(p,l) = c(p,l) + min(L(q,l), L(q,l-1)+P1, L(q,l+1)+P1, m(q)+P2') - m(q)
 * q the pixel before p, m(q) = min over l of L(q,l), P2' = max(P2/(1+|I(p)-I(q)|/S),
 * 1.1 P1).  Winner of the sum over the paths, equiangular fit in sixteenths of a
 * label.
 *
 * Refinement.  One Gauss-Newton step on the displacement e in the widest view, all
 * views, least-squares interpolation kernels of 4 or 6 taps, Tukey weights
 * (1-(r/R)^2)^2, over the window's pixels whose own e lies within the gate, pulled to
 * its start by a prior of standard deviation `prior`; clamped.
 *
 * Standard error of e, in quadrature (A the window's information, lambda the prior's,
 * k what median2 leaves: 1, 0.81, 0.61, 0.5 of windows 0, 3, 5, 7):
 *   k times the scatter of the window's scores over A + lambda: noise and the errors of
 *     interpolation as its own pixels show them (src/sigma.c);
 *   1.8 lambda prior / (A + lambda): what the prior holds back;
 *   a quarter of the step;
 *   k sqrt((m - m0)/2 samples A / arms) / (A + lambda), without the 2 if rival is 0: m
 *     the mean squared residual, m0 its median over the frame; what exceeds it is no
 *     noise but another surface, the same for a whole window and arm;
 *   rival max(0, 1 - c (1 + noise/14)/0.64)^3: another label may be right; c the
 *     confidence, noise in grey levels;
 *   rival (1 - c/1.39) (0.55 o + 11.6 o^4): o the share of 7x7 samples whose e lies
 *     outside the gate: this one may be on the wrong side of an edge.
 * Flags: TEXTURE under the plan's threshold or 1.3 times the mean |dx| + |dy| of noise
 * alone.
 */
#ifndef PLENOFIX_FRAME_H
#define PLENOFIX_FRAME_H

#include "plenofix/plan.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_ARMS_MAX 8

/* Grey levels are of an 8-bit scale in sixteenths, whatever the bits of the views.
 * Columns are of the view farthest from the reference. */
typedef struct plfx_frame_cfg {
    uint8_t arms;        /* sectors of directions, 4 or 8 */
    uint8_t keep;        /* cheapest arms kept, 1 .. 4 */
    uint8_t shrink;      /* 1: least cost of 3x3 */
    uint8_t paths;       /* 0 none, 5 (from above and along the row), 8 */
    uint8_t median1;     /* window of the weighted median of the winners: 0, 3, 5, 7 */
    uint8_t median2;     /* and of the refined map */
    uint8_t taps;        /* refinement: 0 none, 4, 6 */
    uint8_t window;      /* refinement, lenses on a side: 1 .. 15, odd */
    uint8_t passes;      /* Gauss-Newton steps, 1 .. 4 */
    uint8_t axes;        /* 1: flag where u arms and v arms choose labels apart */
    uint16_t trunc_q4;   /* T, 1 .. 1024 */
    uint16_t gtrunc_q4;  /* G, of differences over two lenses, 1 .. 1024 */
    uint16_t gweight_q4; /* w, sixteenths, 0 .. 31 */
    uint16_t p1_q4, p2_q4; /* P1 < P2, grey levels of mean cost */
    uint16_t soften_q4;    /* S */
    uint16_t similar_q4;   /* medians: grey difference at which a weight is 0 */
    uint16_t robust_q4;    /* R */
    uint16_t gate_q8;      /* columns */
    uint16_t clamp_q8;     /* columns */
    uint16_t rival_q8;     /* of the standard error, columns */
    uint16_t prior_q12;    /* columns, of views without noise */
    uint16_t noise_q4;     /* standard deviation of the noise of a view */
} plfx_frame_cfg;

/* Workspace of plfx_frame(), bytes: exactly enough; 0 if cfg does not suit the plan.
 */
size_t plfx_frame_ws(const plfx_plan *plan, const plfx_frame_cfg *cfg);

/* Match a frame.  plan: method ARMS.  skip: NULL, or n bytes, 1 for a view to leave
 * out (not the reference).  At the border a view's edge samples repeat: such a view
 * looks occluded and its arm is not kept; samples whose window leaves a view in use
 * carry PLFX_FLAG_EDGE.  PLFX_OK, PLFX_E_ARG (a field out of range, no view left),
 * PLFX_E_RANGE (over 56 views in an arm), PLFX_E_SIZE. */
plfx_status plfx_frame(const plfx_plan *plan, const plfx_frame_cfg *cfg,
                       const plfx_views *views, const uint8_t *skip,
                       const plfx_map *out, void *ws, size_t ws_size) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
