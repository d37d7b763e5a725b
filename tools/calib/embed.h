/* SPDX-License-Identifier: MIT
 * Pictures inside a page. */
#ifndef PLFT_CALIB_EMBED_H
#define PLFT_CALIB_EMBED_H

#include <stdint.h>
#include <stdio.h>

/* Print an 8-bit picture (channels 1 or 3) as a data: address of a PNG.  0, or -1 when
 * memory is short. */
int plft_embed_png(FILE *file, const uint8_t *px, int w, int h, int channels);

#endif
