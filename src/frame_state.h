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
    int32_t ring;        /* rows kept of the reference alone; 0: all of all views */
    int32_t span;        /* rows of a view at hand then, */
    const uint8_t *slot; /* [n] where, */
    uint16_t *lines;     /* [slot][span][stride] in here */
    int32_t kept;        /* rows of the planes of winners: ny, or a ring */
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
    int32_t *e_a, *e_b;     /* [kept][nx] */
    int16_t *axis_best[2];  /* [ny][nx] least cost of the u and of the v arms */
    uint8_t *axis_label[2]; /* and its label */
    uint16_t *conf;         /* [kept][nx] */
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

/* The same where only some rows are kept. */
static inline const uint16_t *plfx_frame_line(const plfx_frame_state *s, int32_t k,
                                              int32_t y)
{
    size_t stride = (size_t)s->stride;

    if (s->ring == 0) {
        return plfx_frame_row(s, k, y);
    }
    if (k == s->plan->cfg.ref) {
        return s->sample + (size_t)(y % s->ring) * stride + s->pad;
    }
    return s->lines + (size_t)(s->slot[k] * s->span + y % s->span) * stride + s->pad;
}

/* Where row y of a plane of winners begins. */
static inline size_t plfx_frame_at(const plfx_frame_state *s, int32_t y)
{
    return (size_t)(y % s->kept) * (size_t)s->nx;
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

/* A row on its way into the map. */
typedef struct plfx_frame_out {
    const uint16_t *raw; /* samples of the reference, */
    uint32_t top;        /* saturated from here */
    const int32_t *e;
    const uint16_t *conf;
    uint8_t *flags; /* those of the winner; more are added */
} plfx_frame_out;

/* Flags of row y that need no matching: EDGE, TEXTURE, SATURATED, UNIQUE. */
void plfx_frame_flags(const plfx_frame_state *s, const plfx_frame_out *row, int32_t y);
/* Flags of lenses whose axes chose labels apart. */
void plfx_frame_axes(const plfx_frame_state *s, const uint8_t *u, const uint8_t *v,
                     uint8_t *flags);

/* Bytes that each stage needs, and the stages. */
size_t plfx_arms_scratch(const plfx_frame_state *s);
void plfx_arms_volume(const plfx_frame_state *s);
size_t plfx_sgm_scratch(const plfx_frame_state *s);
void plfx_sgm(const plfx_frame_state *s);
size_t plfx_winner_scratch(void);
void plfx_winner_row(const plfx_frame_state *s, int32_t y, const int16_t *sum,
                     void *work);
/* The same for n lenses from x on: label l of lens x + i in sum[l*step + i], of
 * PLFX_WINNER_CHUNK lenses that may be read. */
#define PLFX_WINNER_CHUNK 64
void plfx_winner_chunk(const plfx_frame_state *s, size_t at, const int16_t *sum,
                       int32_t step, int32_t n, void *work);

/* Rows of a weighted median: `window` of them around the one that comes out.  Reads
 * PLFX_WINNER_CHUNK samples of the reference beyond its rows. */
typedef struct plfx_median_rows {
    int16_t *value; /* [window][wide] */
    size_t wide;
    int32_t window, low, shift; /* value = (e - low) >> shift */
} plfx_median_rows;
size_t plfx_median_carve(const plfx_frame_state *s, plfx_median_rows *t, int32_t window,
                         void *base);
size_t plfx_median_work(int32_t window); /* bytes of `work` */
/* The 15 bits of a value from those of all labels. */
void plfx_median_of_labels(const plfx_frame_state *s, plfx_median_rows *t);
/* Row y of e enters; rows in order. */
void plfx_median_load(const plfx_frame_state *s, const plfx_median_rows *t,
                      const int32_t *e, int32_t y);
void plfx_median_row(const plfx_frame_state *s, const plfx_median_rows *t, int32_t y,
                     int32_t *out, void *work);
size_t plfx_median_scratch(const plfx_frame_state *s);
void plfx_median(const plfx_frame_state *s, int32_t window, const int32_t *in,
                 int32_t *out);
size_t plfx_refine_scratch(const plfx_frame_state *s);
/* One pass; what standard errors need only with the last. */
void plfx_refine(const plfx_frame_state *s, const int32_t *in, int32_t *out,
                 int32_t last);
/* Standard errors of the final e. */
size_t plfx_sigma_scratch(const plfx_frame_state *s);
void plfx_sigma_map(const plfx_frame_state *s, const int32_t *e);

#endif
