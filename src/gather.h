/* SPDX-License-Identifier: MIT
 * From passing sensor rows to view rows: view.h in the order of the sensor.  A sample
 * needs two sensor rows; between them its first tap waits in 16 bits where the sample
 * will stand. */
#ifndef PLENOFIX_SRC_GATHER_H
#define PLENOFIX_SRC_GATHER_H

#include "plenofix/stream.h"
#include "arena.h"

/* Sensor rows under one lens row, at most, in the fast profile. */
#define PLFX_GATHER_ROWS 256

#define PLFX_GATHER_SPARE 8 /* lanes read and written back behind the last lens */

/* The lenses of an open row in the order of their first sensor row: those that begin in
 * row first + b are number start[b] .. start[b+1] - 1. */
typedef struct plfx_gather_order {
    int32_t *x_q16, *y_q16; /* [nx] centres */
    uint16_t *lens;         /* [nx] column */
    uint16_t *start;        /* [PLFX_GATHER_ROWS + 1] */
    int32_t inside;         /* 1: no tap leaves the sensor sideways */
    int32_t first, count;   /* sensor row of start[0]; sensor rows */
} plfx_gather_order;

typedef struct plfx_gather {
    const plfx_lut *lut;
    plfx_tone tone;
    const plfx_offset *at;
    int32_t n, open, white, bits;
    int32_t ordered;   /* 1: fast profile */
    plfx_point *shift; /* [n] displacements, q16, with 1/2; NULL: extremes alone */
    plfx_point least, most;
    plfx_point *centre; /* [nx], fast profile: before they are put in order */
    int16_t *begin;     /* [nx], likewise: first sensor rows, -1 missing */
    plfx_gather_order order[PLFX_STREAM_OPEN_MAX];
    uint16_t *rows;   /* [open][n][nx]; in the row's order until it is closed */
    uint16_t *line;   /* [nx] gains, or a row before it is put in place */
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

/* The fast profile's part of open, taps and close (gather_fast.c). */
void plfx_gather_sort(plfx_gather *g, int32_t j);
void plfx_gather_lanes(plfx_gather *g, int32_t j, int32_t y, const plfx_raw_row *row);
void plfx_gather_place(plfx_gather *g, int32_t j);

/* Sensor rows under the lens at c. */
plfx_rows_span plfx_gather_under(const plfx_gather *g, plfx_point c);

#endif
