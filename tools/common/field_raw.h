/* SPDX-License-Identifier: MIT
 * The raw half of a light field. */
#ifndef PLFT_FIELD_RAW_H
#define PLFT_FIELD_RAW_H

#include "common/field.h"

/* Load table, frame, white and dark frame, and settle the tone.  0, PLFT_DATA or
 * PLFT_USAGE. */
int plft_field_open_raw(plft_field *field, const plft_source *source);

/* Extract view k of `to` at an offset. */
int plft_field_extract(const plft_field *field, plfx_offset at, const plfx_views *to,
                       int k);

#endif
