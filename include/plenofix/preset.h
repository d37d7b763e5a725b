/* SPDX-License-Identifier: MIT
 * Presets: constant settings for three places of work, and the choice of views.
 *
 *   STREAM   8 views on the axes, 4 arms of which the best 2, winner alone: what a
 *            microcontroller can keep up with.
 *   ONBOARD  a star of 8 rays of views, best 3 arms, aggregation, medians, one damped
 *            refinement: maps, on a single-board computer or a host.
 *   PRECISE  the same, then undamped refinement in a wide window by 6-tap kernels: the
 *            slope of regions and planes, down to the noise. */
#ifndef PLENOFIX_PRESET_H
#define PLENOFIX_PRESET_H

#include "plenofix/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum plfx_preset_id {
    PLFX_PRESET_STREAM = 0,
    PLFX_PRESET_ONBOARD,
    PLFX_PRESET_PRECISE,
    PLFX_PRESETS /* count, not a preset */
} plfx_preset_id;

/* Fill `frame`, and of `cfg` the fields method, cost, fit, fuse, window, texture and
 * unique_u16.  The others (views, bits, slopes, labels) are the caller's and kept.
 * PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_preset(int32_t id, plfx_cfg *cfg, plfx_frame_cfg *frame) PLFX_MUST_USE;

/* Which of n views the preset uses: use[k] = 1 or 0, use[ref] = 1.  ONBOARD and
 * PRECISE: views within about 6 degrees of the eight rays through the reference, or
 * all when fewer than four lie there; STREAM: on the four half axes, the farthest view
 * and the one nearest half its distance.  n <= 2048.  Returns the number of views
 * used; 0 on a bad argument, then `use` is untouched. */
int32_t plfx_preset_views(int32_t id, const plfx_offset *at, int32_t n, int32_t ref,
                          uint8_t *use);

/* Labels that step by 0.4 lens pitches (STREAM: 0.5) in the view farthest along an
 * axis, between the slopes and both included, PLFX_LABELS_MIN .. PLFX_LABELS_MAX.
 * base_q8: that view's offset, sensor pixels, > 0. */
int32_t plfx_preset_labels(int32_t id, int32_t min_q16, int32_t max_q16,
                           int32_t base_q8);

#ifdef __cplusplus
}
#endif
#endif
