/* SPDX-License-Identifier: MIT
 * PNG and base64 in memory. */
#include "calib/embed.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

static void base64(FILE *file, const uint8_t *p, size_t n)
{
    static const char digit[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    size_t k;

    for (k = 0; k < n; k += 3) {
        const uint32_t v = (uint32_t)p[k] << 16 |
                           (k + 1 < n ? (uint32_t)p[k + 1] << 8 : 0u) |
                           (k + 2 < n ? (uint32_t)p[k + 2] : 0u);
        fputc(digit[v >> 18], file);
        fputc(digit[v >> 12 & 63u], file);
        fputc(k + 1 < n ? digit[v >> 6 & 63u] : '=', file);
        fputc(k + 2 < n ? digit[v & 63u] : '=', file);
    }
}

int plft_embed_png(FILE *file, const uint8_t *px, int w, int h, int channels)
{
    png_alloc_size_t n = 0;
    png_image image;
    uint8_t *out;
    int ok;

    memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    image.width = (png_uint_32)w;
    image.height = (png_uint_32)h;
    image.format = channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
    if (!png_image_write_to_memory(&image, NULL, &n, 0, px, 0, NULL)) {
        return -1;
    }
    out = malloc(n);
    ok = out != NULL && png_image_write_to_memory(&image, out, &n, 0, px, 0, NULL);
    if (ok) {
        fputs("data:image/png;base64,", file);
        base64(file, out, n);
    }
    free(out);
    return ok ? 0 : -1;
}
