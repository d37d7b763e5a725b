/* SPDX-License-Identifier: MIT
 * The made scene of the goldens: a textured world of two slopes seen through a small
 * lens array, a lens table with residuals, gains and flags, and random bytes. */
#ifndef GOLDEN_SCENE_H
#define GOLDEN_SCENE_H

#include <stdint.h>

#include "plenofix/plenofix.h"

#define SCENE_W     420
#define SCENE_H     330
#define SCENE_NX    40
#define SCENE_NY    30
#define SCENE_VIEWS 5
#define SCENE_BITS  12
#define SCENE_LABEL 12
#define SCENE_WS    (512u * 1024u)

typedef struct scene_map {
    int32_t slope[SCENE_NX * SCENE_NY];
    uint16_t conf[SCENE_NX * SCENE_NY], sigma[SCENE_NX * SCENE_NY];
    uint8_t flags[SCENE_NX * SCENE_NY];
} scene_map;

extern uint16_t scene_frame[SCENE_W * SCENE_H];
extern uint8_t scene_blob[16384];
extern uint16_t scene_samples[SCENE_NX * SCENE_NY * SCENE_VIEWS];
extern scene_map scene_out;
extern const plfx_offset scene_at[SCENE_VIEWS];

/* Frame and table; `kind` is PLFX_LATTICE_*.  Returns the size of the blob, or 0. */
size_t scene_make(int32_t kind, plfx_lut *lut);

plfx_raw scene_raw(void);
plfx_tone scene_tone(void);

/* Views of the frame into scene_samples. */
plfx_status scene_views(const plfx_lut *lut, plfx_views *views);

/* A configuration of the five views, slopes -0.12 .. 0.12. */
plfx_cfg scene_cfg(int32_t method, int32_t cost, int32_t fit);

/* A stream of the frame, matched by sums of all views; its plan and table stay here. */
plfx_status scene_stream(plfx_stream *s, int32_t profile);

/* scene_out, emptied. */
plfx_map scene_empty(void);
void *scene_ws(void);

#endif
