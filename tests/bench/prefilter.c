/* SPDX-License-Identifier: MIT
 * For opencv.py: the filter that StereoBM cannot do without, so that our time can hold
 * its cost as well.  A 3x3 x-Sobel, clipped to -31 .. 31 and lifted by 31; the first
 * and last column are 31, rows beyond the image repeat its border. */
#include <stdint.h>

void bench_xsobel(const uint8_t *image, int w, int h, uint16_t *out, int stride);

static void filter_row(const uint8_t *restrict up, const uint8_t *restrict mid,
                       const uint8_t *restrict down, int w, uint16_t *restrict out)
{
    out[0] = 31;
    out[w - 1] = 31;
    for (int x = 1; x < w - 1; x++) {
        int16_t d = (int16_t)(up[x + 1] - up[x - 1] + 2 * (mid[x + 1] - mid[x - 1]) +
                              down[x + 1] - down[x - 1]);
        d = d < -31 ? (int16_t)-31 : d;
        d = d > 31 ? (int16_t)31 : d;
        out[x] = (uint16_t)(d + 31);
    }
}

/* stride: samples from one row of `out` to the next. */
void bench_xsobel(const uint8_t *image, int w, int h, uint16_t *out, int stride)
{
    for (int y = 0; y < h; y++) {
        const uint8_t *row = image + (int64_t)y * w;
        filter_row(y > 0 ? row - w : row, row, y < h - 1 ? row + w : row, w,
                   out + (int64_t)y * stride);
    }
}
