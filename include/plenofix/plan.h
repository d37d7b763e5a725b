/* SPDX-License-Identifier: MIT
 * The plan: what to match and every number derived from it, validated once.
 *
 * A label l = 0 .. labels-1 is a slope, D(l) = min + l*(max-min)/(labels-1).  The image
 * of a point seen in the reference view at lens (i,j) is seen in a view at offset (u,v)
 * displaced by D*P*(du,dv), du and dv measured from the reference view:
 *   D*du*(P/|a|) columns and D*dv*(P/b) rows  (b: distance between lens rows). */
#ifndef PLENOFIX_PLAN_H
#define PLENOFIX_PLAN_H

#include "plenofix/lut.h"
#include "plenofix/view.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum plfx_method {
    PLFX_METHOD_SWEEP = 0, /* one cost summed over all views (SAD only), one winner */
    PLFX_METHOD_PAIRS,     /* one winner a view against the reference, then fused */
    PLFX_METHOD_GRADIENT,  /* least-squares gradient of five views (gradient.h) */
    PLFX_METHOD_ARMS       /* arms of views, aggregated and refined (frame.h) */
} plfx_method;

typedef enum plfx_cost { PLFX_COST_SAD = 0, PLFX_COST_ZNCC } plfx_cost;

typedef enum plfx_fit {
    PLFX_FIT_PARABOLA = 0, /* for ZNCC and squared costs */
    PLFX_FIT_VEE           /* equiangular, for SAD */
} plfx_fit;

typedef enum plfx_fuse_rule {
    PLFX_FUSE_MEDIAN = 0, /* weighted median of the pairs; weight = baseline^2 */
    PLFX_FUSE_CORRELATION /* the paper's mean weighted by correlation */
} plfx_fuse_rule;

typedef struct plfx_cfg {
    uint8_t method;   /* plfx_method */
    uint8_t cost;     /* plfx_cost; SWEEP takes SAD only */
    uint8_t fit;      /* plfx_fit */
    uint8_t fuse;     /* plfx_fuse_rule, PAIRS only */
    uint8_t window;   /* lenses on a side, odd, PLFX_WINDOW_MIN .. _MAX */
    uint8_t bits;     /* of a view sample */
    uint8_t ref;      /* index of the reference view */
    uint8_t n;        /* views, 2 .. PLFX_VIEWS_MAX; 5 for GRADIENT */
    uint16_t labels;  /* PLFX_LABELS_MIN .. PLFX_LABELS_MAX */
    uint16_t texture; /* mean |gradient| in view counts, q4, under it: TEXTURE; 0 off */
    uint16_t unique_u16;                  /* confidence under it: UNIQUE; 0 off */
    int32_t slope_min_q16, slope_max_q16; /* lens pitches per sensor px, -32 .. 32 */
    plfx_offset at[PLFX_VIEWS_MAX];
} plfx_cfg;

typedef struct plfx_plan {
    plfx_cfg cfg;
    int32_t nx, ny;  /* lenses */
    int32_t hex;     /* 1: odd rows are displaced by odd_q4 columns */
    int32_t odd_q4;  /* columns/16 */
    int32_t col_q16; /* P/|a| */
    int32_t row_q16; /* P/b */
    int32_t du_q8[PLFX_VIEWS_MAX], dv_q8[PLFX_VIEWS_MAX]; /* from the reference view */
    int32_t reach_x, reach_y; /* farthest sample from its target, columns and rows */
    int32_t sad_shift1;       /* cost of a row >> this before the columns */
    int32_t sad_shift2;       /* column >> this before the window sum */
} plfx_plan;

/* A shift in columns and rows, floor and sixteenths. */
typedef struct plfx_shift {
    int32_t kx, fx_q4, ky, fy_q4; /* 0 <= f < 16 */
} plfx_shift;

/* Validate and derive.  lut may be NULL for ready-made views: then nx, ny are given and
 * the lattice is square with P = |a| = b = 1.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_RANGE (a view's shift exceeds the map, or the cost does
 * not fit: n-1 views of `bits` must sum to at most 65535 in SWEEP). */
plfx_status plfx_plan_init(plfx_plan *plan, const plfx_cfg *cfg, const plfx_lut *lut,
                           int32_t nx, int32_t ny) PLFX_MUST_USE;

/* Slope of label l + f/16, rounded half away from zero. */
int32_t plfx_plan_slope_q16(const plfx_plan *plan, int32_t label_q4);

/* Shift of view k at label l, rounded to 1/16 column and row. */
plfx_shift plfx_plan_shift(const plfx_plan *plan, int32_t k, int32_t label);

#ifdef __cplusplus
}
#endif
#endif
