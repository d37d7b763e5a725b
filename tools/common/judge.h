/* SPDX-License-Identifier: MIT
 * Views out of order, named before they are matched. */
#ifndef PLFT_JUDGE_H
#define PLFT_JUDGE_H

#include "common/field.h"
#include "plenofix/plan.h"

/* skip[k] = 1 for every view of cfg->at, in `views`, that is dark, saturated or unlike
 * the rest in brightness, with a line that says so; their number in *left_out.  Fewer
 * than three views tell nothing.  PLFT_DATA when the reference is dark or saturated. */
int plft_judge_views(const plft_field *field, const plfx_cfg *cfg,
                     const plfx_views *views, uint8_t *skip, int *left_out);

/* Ready-made views only, as cameras of an array fail one by one: judges cfg's views and
 * takes those out of order from cfg->at.  cfg: bits, ref, n, at.  PLFT_DATA. */
int plft_judge_ready(const plft_field *field, plfx_cfg *cfg, int *left_out);

#endif
