/* SPDX-License-Identifier: MIT
 * From passing sensor rows to view rows: view.h in the order of the sensor.  A sample
 * needs two sensor rows; between them its first tap waits in 16 bits where the sample
 * will stand. */
#ifndef PLENOFIX_SRC_GATHER_H
#define PLENOFIX_SRC_GATHER_H

#include "plenofix/stream.h"
#include "arena.h"

typedef struct plfx_gather {
    const plfx_lut *lut;
    plfx_tone tone;
    const plfx_offset *at;
    int32_t n, open, white, bits;
    plfx_point
        *shift; /* [n] displacement of each view, q16, rounding included; NULL: only
                              their extremes are wanted */
    plfx_point least, most;
    plfx_point *centre; /* [open][nx], or NULL: computed when needed */
    uint16_t *rows;     /* [open][n][nx] */
    uint16_t *gain;     /* [nx] */
    uint16_t *pixels;   /* [sensor_w] an unpacked row, or NULL */
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

#endif
