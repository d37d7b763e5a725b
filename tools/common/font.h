/* SPDX-License-Identifier: MIT
 * The built-in font: ASCII 32..126, 5 columns in a cell of 6 x 10. */
#ifndef PLFT_FONT_H
#define PLFT_FONT_H

#include <stdint.h>

#define PLFT_FONT_W    6
#define PLFT_FONT_H_PX 10

/* Seven rows, bit 4 the leftmost column; *drop: rows below the usual top. */
const uint8_t *plft_glyph(char c, int *drop);

#endif
