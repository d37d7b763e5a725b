/* SPDX-License-Identifier: MIT
 * From passing sensor rows to view rows: view.h in the order of the sensor.  A sample
 * needs two sensor rows; between them its first tap waits in 16 bits where the sample
 * will stand. */
#ifndef PLENOFIX_SRC_GATHER_H
#define PLENOFIX_SRC_GATHER_H

#include "plenofix/stream.h"
#include "arena.h"
#include "taps.h"

/* Bounds of the lenses that are sampled side by side. */
typedef struct plfx_gather_block {
    int32_t least_q16, most_q16; /* y of their centres; most < least: none measured */
    int32_t inside;              /* 1: no tap leaves the sensor sideways */
} plfx_gather_block;

/* Centres of an open row's lenses.  A missing lens stands far above the sensor, where
 * no row meets it, and beside a measured one. */
typedef struct plfx_gather_lenses {
    int32_t *x_q16, *y_q16; /* [blocks * PLFX_TAP_LANES] */
    plfx_gather_block *block;
} plfx_gather_lenses;

typedef struct plfx_gather {
    const plfx_lut *lut;
    plfx_tone tone;
    const plfx_offset *at;
    int32_t n, open, white, bits;
    int32_t lanes;     /* 1: fast profile */
    int32_t blocks;    /* of PLFX_TAP_LANES lenses in a row */
    plfx_point *shift; /* [n] displacements, q16, with 1/2; NULL: extremes alone */
    plfx_point least, most;
    plfx_gather_lenses lens[PLFX_STREAM_OPEN_MAX]; /* fast profile */
    uint16_t *rows;                                /* [open][n][nx] */
    uint16_t *line;                                /* [nx] gains, or NULL */
    uint16_t *pixels; /* [sensor_w] an unpacked row, or NULL */
    int32_t lo[PLFX_STREAM_OPEN_MAX], hi[PLFX_STREAM_OPEN_MAX];
} plfx_gather;

/* Sensor rows that a lens row needs; hi < lo: none (all lenses missing). */
typedef struct plfx_rows_span {
    int32_t lo, hi;
} plfx_rows_span;

void plfx_gather_carve(plfx_gather *g, const plfx_stream_cfg *cfg, plfx_arena *a);

/* Displacements; then any of the calls below. */
void plfx_gather_start(plfx_gather *g);

plfx_rows_span plfx_gather_span(const plfx_gather *g, int32_t j);

/* Lens row j begins to gather, in slot j % open. */
void plfx_gather_open(plfx_gather *g, int32_t j);

/* The taps that open lens row j has in sensor row y. */
void plfx_gather_taps(plfx_gather *g, int32_t j, int32_t y, const plfx_raw_row *row);

/* Lens row j is whole: black level, gain and tone. */
void plfx_gather_close(plfx_gather *g, int32_t j);

/* A row as plain pixels where that pays (fast profile). */
void plfx_gather_unpack(plfx_gather *g, const plfx_raw_row *row);

/* The fast profile's part of open and taps (gather_fast.c). */
void plfx_gather_aim(plfx_gather *g, int32_t j);
void plfx_gather_lanes(plfx_gather *g, int32_t j, int32_t y, const plfx_raw_row *row);

/* Sensor rows under the lens at c. */
plfx_rows_span plfx_gather_under(const plfx_gather *g, plfx_point c);

#endif
