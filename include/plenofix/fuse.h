/* SPDX-License-Identifier: MIT
 * Plenoptic stereo: one slope from the slopes of several pairs (the paper's III.C). */
#ifndef PLENOFIX_FUSE_H
#define PLENOFIX_FUSE_H

#include "plenofix/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Mean weighted by w (correlations, 0 .. 1 - 2^-16): round(sum(w*s)/sum(w)) over
 * entries with w > 0 and s != NONE; NONE when there are none.  n <= PLFX_VIEWS_MAX. */
int32_t plfx_fuse_mean(const int32_t *slope_q16, const uint16_t *w_u16, int32_t n);

/* Weighted median: the smallest slope at which the weights of slopes up to and
 * including it reach half of the total; the mean of it and its successor when they
 * reach exactly half.  NONE entries and weights of 0 do not count.
 * n <= PLFX_VIEWS_MAX. */
int32_t plfx_fuse_median(const int32_t *slope_q16, const uint16_t *w_u16, int32_t n);

#ifdef __cplusplus
}
#endif
#endif
