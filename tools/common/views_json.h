/* SPDX-License-Identifier: MIT
 * views.json: what `views` leaves beside its pictures and `depth --views-dir` obeys. */
#ifndef PLFT_VIEWS_JSON_H
#define PLFT_VIEWS_JSON_H

#include "common/field.h"

/* Fill the ready-made part of a light field from DIR/views.json.  0 or PLFT_DATA. */
int plft_views_json_read(plft_field *field, const char *dir);

/* Write DIR/views.json and, when lenses carry flags, DIR/lenses.png. */
int plft_views_json_write(const plft_field *field, const char *dir,
                          const plfx_offset *at, int n);

/* File name of view k: "view_000.png". */
void plft_view_name(char *to, size_t room, int k);

#endif
