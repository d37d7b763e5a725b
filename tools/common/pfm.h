/* SPDX-License-Identifier: MIT
 * PFM: 32-bit float maps, NaN where nothing was measured.  In memory row 0 is the top
 * of the field; the file stores rows bottom-up, as the format says. */
#ifndef PLFT_PFM_H
#define PLFT_PFM_H

#include <stddef.h>

typedef struct plft_map {
    float *v; /* [h][w], malloc'd */
    int w, h;
} plft_map;

int plft_pfm_read(plft_map *map, const char *path); /* 0 or PLFT_DATA */
/* The same from n bytes in memory; `name` is for messages. */
int plft_pfm_parse(plft_map *map, const unsigned char *bytes, size_t n,
                   const char *name);
int plft_pfm_write(const char *path, const float *v, int w, int h);
void plft_map_free(plft_map *map);

#endif
