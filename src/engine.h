/* SPDX-License-Identifier: MIT
 * Rows of view samples in, rows of the map out: the matcher, and for plenoptic stereo
 * the fusion of its pairs.  The whole-frame call and the stream are this engine. */
#ifndef PLENOFIX_SRC_ENGINE_H
#define PLENOFIX_SRC_ENGINE_H

#include "match.h"
#include "sweep_state.h"

typedef struct plfx_engine {
    plfx_match match;
    plfx_sweep_state fuse; /* the rows of the pairs */
    plfx_line *lines;      /* [pairs] */
} plfx_engine;

void plfx_engine_carve(plfx_engine *e, const plfx_plan *plan, int32_t leave,
                       plfx_arena *a);

/* Row y of the map, y consecutive; `row` is a map of one row. */
void plfx_engine_row(plfx_engine *e, const plfx_rows *src, int32_t y,
                     const plfx_map *row);

/* Row `y` of a map as a map of one row. */
plfx_map plfx_map_row(const plfx_map *m, int32_t y);

/* One sample of a row. */
void plfx_map_put(const plfx_map *row, size_t at, int32_t slope, uint16_t conf,
                  uint8_t flags);

/* A row too near the border for a window. */
void plfx_map_edge(const plfx_map *row);

/* A row that holds no standard errors. */
void plfx_map_no_sigma(const plfx_map *row);

#endif
