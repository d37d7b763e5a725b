/* SPDX-License-Identifier: MIT
 * Rows of the costs of arms: what the whole frame and the stream share.  Rows of n
 * lenses; `restrict` ones do not overlap. */
#ifndef PLENOFIX_SRC_ARMS_ROWS_H
#define PLENOFIX_SRC_ARMS_ROWS_H

#include "frame_state.h"

#define PLFX_ARMS_LEVELS 4 /* cheapest arms followed */

/* Row y of view k displaced by `shift`, less the reference: into diff[1 .. nx], ends
 * repeated.  warp: [2][nx]; fresh = 0: it holds what the row before left there. */
void plfx_arms_diff(const plfx_frame_state *s, int32_t k, const plfx_shift *shift,
                    int32_t y, int32_t fresh, uint16_t *warp, int16_t *diff);

/* sum += cost of a view from difference rows y-1 .. y+1. */
void plfx_arms_cost(const int16_t *restrict up, const int16_t *restrict mid,
                    const int16_t *restrict down, const plfx_frame_cfg *cfg, int32_t n,
                    int16_t *restrict sum);

/* sum += cost of view k at row y without gradients.  warp: [2][nx] to spare. */
void plfx_arms_flat(const plfx_frame_state *s, int32_t k, const plfx_shift *shift,
                    int32_t y, uint16_t *warp, int16_t *sum);

/* Mean of an arm scaled for the box, ends repeated r times. */
void plfx_arms_mean(const int16_t *restrict sum, uint16_t mul, int32_t shift, int32_t n,
                    int32_t r, int16_t *restrict out);

/* Means on top of a column (sign 1) or off it (-1). */
void plfx_arms_column(const int16_t *restrict sum, uint16_t mul, int32_t shift,
                      int32_t n, int32_t sign, int16_t *restrict col);

/* out[i] = sum of in[i .. i + window - 1]; window odd, 3 or more. */
void plfx_arms_box(const int16_t *restrict in, int32_t window, int32_t n,
                   int16_t *restrict out);

/* Insert v into the PLFX_ARMS_LEVELS ordered rows of least costs. */
void plfx_arms_keep(const int16_t *restrict v, int32_t n, int16_t *restrict least);

void plfx_arms_lesser(const int16_t *restrict v, int32_t n, int16_t *restrict least);

/* Running least over the labels and its label. */
void plfx_arms_follow(const int16_t *restrict v, int32_t label, int32_t n,
                      int16_t *restrict best, uint8_t *restrict at);

/* Axis of an arm: 0 u, 1 v, or -1. */
int32_t plfx_arms_axis(const plfx_frame_state *s, int32_t a);

/* 8-bit cost from the `keep` least. */
void plfx_arms_quantise(const int16_t *restrict least, int32_t n, int32_t keep,
                        uint16_t mul, uint8_t *restrict out);

/* Least of 3x3; rows begin a lens before. */
void plfx_arms_least(const uint8_t *restrict a, const uint8_t *restrict b,
                     const uint8_t *restrict c, int32_t n, uint8_t *restrict out);

#endif
