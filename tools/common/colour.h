/* SPDX-License-Identifier: MIT
 * False-colour pictures of maps, with a colour bar and its numbers. */
#ifndef PLFT_COLOUR_H
#define PLFT_COLOUR_H

#include <stdint.h>

/* A perceptually ordered ramp (dark blue .. yellow), t in 0..1; NaN is mid grey. */
void plft_colour(float t, uint8_t rgb[3]);

/* Picture of a map between lo and hi (lo == hi: 1st to 99th percentile), each sample
 * drawn `scale` pixels wide (0: so that the picture is 400..900 pixels wide), beside a
 * colour bar with `label` and at least three numbers.  0 or PLFT_DATA. */
int plft_colour_png(const char *path, const float *v, int w, int h, float lo, float hi,
                    int scale, const char *label);

/* Draw text in a built-in 6x10 font into an RGB picture. */
void plft_text(uint8_t *rgb, int w, int h, int x, int y, const char *text,
               const uint8_t colour[3]);

#endif
