/* SPDX-License-Identifier: MIT
 * Running a plan on a field, with the memory that takes. */
#ifndef PLFT_MATCH_H
#define PLFT_MATCH_H

#include "common/field.h"
#include "plenofix/plan.h"

typedef struct plft_times { /* CPU seconds */
    double read, extract, match, write;
} plft_times;

double plft_cpu_s(void);

/* Planes for a map of nx x ny, malloc'd.  0 or PLFT_DATA. */
int plft_slopes_alloc(plfx_map *map, int nx, int ny);
void plft_slopes_free(plfx_map *map);

/* Plan of `cfg` on a field, with messages that name the options.  0, PLFT_USAGE when
 * the options do not suit the views, or PLFT_DATA. */
int plft_plan(plfx_plan *plan, const plfx_cfg *cfg, const plft_field *field);

/* Extract the plan's views and match them into `map` (allocated by the caller); adds to
 * times->extract and times->match.  0 or PLFT_DATA. */
int plft_match(const plfx_plan *plan, const plft_field *field, const plfx_map *map,
               plft_times *times);

/* Least texture worth matching, 1/1000 of full scale: 1.3 times what the noise of the
 * centre view's smoothest parts (plfx_views_noise_q4) makes of the core's measure;
 * never under 2 nor over 12.  Behind a band pass, what that leaves of the noise.  2
 * for views of a camera array, whose noise is no longer the sensor's.  u_only: all
 * views lie along u.  0 or PLFT_DATA. */
int plft_find_texture(const plft_field *field, int u_only, double *texture);

/* A window that suits the size of the views: 9, less for fewer than 72 lenses. */
int plft_own_window(const plft_field *field);

/* Lenses that the table flags: LENS set, and no slope where the lens is missing. */
void plft_flag_lenses(const plft_field *field, const plfx_map *map);

/* Slopes that a light field holds: two coarse matches, percentiles of the samples that
 * are confident among their neighbours, widened.  Views of a camera array of 384
 * samples and more on their shorter side are searched at a half of their size, a
 * quarter from 768, and so on.  cfg: bits, cost, window, texture and views as they will
 * be used; lo, hi and labels come back, in the light field's unit.  0 or PLFT_DATA. */
int plft_find_slopes(const plft_field *field, const plfx_cfg *cfg, double *lo,
                     double *hi, int *labels, plft_times *times);

#endif
