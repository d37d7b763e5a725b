/* SPDX-License-Identifier: MIT
 * What the stages of plfx_frame() share.  Samples are of 12 bits; e is the
 * displacement in the widest view, columns (or rows, if wider), q16. */
#ifndef PLENOFIX_SRC_FRAME_STATE_H
#define PLENOFIX_SRC_FRAME_STATE_H

#include "plenofix/frame.h"

typedef struct plfx_frame_state {
    const plfx_plan *plan;
    plfx_frame_cfg cfg;
    int32_t smooth; /* views are smoothed first */
    int32_t nx, ny, n, labels;
    int32_t pad, stride; /* of a padded row */
    int8_t *arm_of;      /* [n], -1: not used */
    int32_t arm_n[PLFX_ARMS_MAX];
    int32_t arms, keep;              /* arms that have views; arms kept */
    int32_t base_q8;                 /* widest offset, columns a unit of slope */
    int32_t *bx_q16, *by_q16;        /* [n], share of it, -1 .. 1 */
    uint16_t arm_mul[PLFX_ARMS_MAX]; /* arm mean = sum * mul >> arm_shift */
    int32_t arm_shift[PLFX_ARMS_MAX];
    uint16_t vol_mul;       /* volume = kept sum / 4 * mul >> 16, cut to 255 */
    int32_t p1, p2;         /* volume units */
    uint16_t *p2_of;        /* by grey difference, 8-bit levels */
    uint16_t *sample;       /* [ny][n][stride] */
    uint8_t *volume;        /* [ny][labels][nx] */
    int16_t *sum;           /* [ny or 1][labels][nx], and a chunk to spare */
    int32_t *e_a, *e_b;     /* [ny][nx] */
    int16_t *axis_best[2];  /* [ny][nx] least cost of the u and of the v arms */
    uint8_t *axis_label[2]; /* and its label */
    uint16_t *conf;         /* [ny][nx] */
    uint8_t *flags;
    uint16_t *sigma;
    uint32_t *base;   /* [ny][nx] with refinement: error of e, q16 columns */
    uint32_t *misfit; /* mean w r^2, q8 */
    uint32_t *lever;  /* error a count of misfit, q20 columns */
    void *scratch;    /* of one stage at a time */
} plfx_frame_state;

static inline const uint16_t *plfx_frame_row(const plfx_frame_state *s, int32_t k,
                                             int32_t y)
{
    return s->sample + ((size_t)y * (size_t)s->n + (size_t)k) * (size_t)s->stride +
           s->pad;
}

/* Everything but the tables, which plfx_frame_tables() fills; errors as plfx_frame().
 */
plfx_status plfx_frame_derive(plfx_frame_state *s, const plfx_plan *plan,
                              const plfx_frame_cfg *cfg, const uint8_t *skip);
/* Place the planes in a workspace (NULL: measure); bytes. */
size_t plfx_frame_carve(plfx_frame_state *s, void *base);
/* Tables of the workspace; after carving. */
void plfx_frame_tables(const plfx_frame_state *s, const uint8_t *skip);
/* 12-bit copies of the views. */
void plfx_frame_load(const plfx_frame_state *s, const plfx_views *views);

/* Slope to e and back. */
int32_t plfx_frame_e_of(const plfx_frame_state *s, int32_t slope_q16);
int32_t plfx_frame_slope_of(const plfx_frame_state *s, int32_t e_q16);
/* Standard error of the slope, 2^-20, from that of e, q16 columns. */
uint16_t plfx_frame_sigma(const plfx_frame_state *s, uint32_t sigma_q16);

/* Flags of a row that need no matching: EDGE, TEXTURE, SATURATED, UNIQUE, axes apart.
 */
void plfx_frame_flags(const plfx_frame_state *s, const plfx_views *views, int32_t y);

/* Bytes that each stage needs, and the stages. */
size_t plfx_arms_scratch(const plfx_frame_state *s);
void plfx_arms_volume(const plfx_frame_state *s);
size_t plfx_sgm_scratch(const plfx_frame_state *s);
void plfx_sgm(const plfx_frame_state *s);
size_t plfx_winner_scratch(void);
void plfx_winner_row(const plfx_frame_state *s, int32_t y, const int16_t *sum,
                     void *work);
size_t plfx_median_scratch(const plfx_frame_state *s);
void plfx_median(const plfx_frame_state *s, int32_t window, const int32_t *in,
                 int32_t *out);
size_t plfx_refine_scratch(const plfx_frame_state *s);
/* One pass; standard errors only with the last. */
void plfx_refine(const plfx_frame_state *s, const int32_t *in, int32_t *out,
                 int32_t last);

#endif
