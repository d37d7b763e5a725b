/* SPDX-License-Identifier: MIT */
#include "common/frame.h"

#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"
#include "common/out.h"

int plft_frame_alloc(plft_frame *frame, unsigned long w, unsigned long h, int channels,
                     const char *name)
{
    memset(frame, 0, sizeof *frame);
    if (w < 1 || h < 1 || w > PLFT_SIDE_MAX || h > PLFT_SIDE_MAX) {
        return plft_fail(PLFT_DATA, "%s: %lu x %lu pixels; a side may have 1 to %d",
                         name, w, h, PLFT_SIDE_MAX);
    }
    if (w * h * (unsigned long)channels > PLFT_SAMPLES_MAX) {
        return plft_fail(PLFT_DATA, "%s: %lu x %lu pixels are more than %lu samples",
                         name, w, h, PLFT_SAMPLES_MAX);
    }
    frame->px = (uint16_t *)plft_alloc(w * h * (size_t)channels, sizeof *frame->px);
    if (frame->px == NULL) {
        return PLFT_DATA;
    }
    frame->w = (int)w;
    frame->h = (int)h;
    frame->channels = channels;
    return 0;
}

void plft_frame_free(plft_frame *frame)
{
    free(frame->px);
    memset(frame, 0, sizeof *frame);
}

static int set_bits(plft_frame *frame, int bits, const char *name)
{
    size_t n = (size_t)frame->w * (size_t)frame->h * (size_t)frame->channels;
    unsigned max = (1u << bits) - 1u;
    size_t i;

    for (i = 0; i < n; i++) {
        if (frame->px[i] > max) {
            return plft_fail(PLFT_DATA,
                             "%s: holds %u, over the %u of %d bits; give --bits as the "
                             "camera stores them",
                             name, frame->px[i], max, bits);
        }
    }
    frame->bits = bits;
    return 0;
}

static int parse(plft_frame *frame, const unsigned char *s, size_t n, const char *name)
{
    static const unsigned char png[8] = {137, 80, 78, 71, 13, 10, 26, 10};

    if (n >= 8 && memcmp(s, png, 8) == 0) {
        return plft_png_parse(frame, s, n, name);
    }
    if (n >= 4 && (memcmp(s, "II*\0", 4) == 0 || memcmp(s, "MM\0*", 4) == 0)) {
        return plft_tiff_parse(frame, s, n, name);
    }
    return plft_fail(PLFT_DATA, "%s: neither PNG nor TIFF; convert it to one of them",
                     name);
}

int plft_frame_read(plft_frame *frame, const char *path, int bits)
{
    unsigned char *bytes = NULL;
    size_t n = 0;
    int rc = plft_in_bytes(path, &bytes, &n);

    memset(frame, 0, sizeof *frame);
    if (rc == 0) {
        rc = parse(frame, bytes, n, path);
    }
    if (rc == 0 && bits != 0) {
        rc = set_bits(frame, bits, path);
    }
    if (rc != 0) {
        plft_frame_free(frame);
    }
    free(bytes);
    return rc;
}

void plft_frame_to_grey(plft_frame *frame)
{
    size_t n = (size_t)frame->w * (size_t)frame->h;
    size_t i;

    if (frame->channels != 3) {
        return;
    }
    for (i = 0; i < n;
         i++) { /* in place: sample i is read before 3i is reached again */
        const uint16_t *rgb = frame->px + 3 * i;
        frame->px[i] =
            (uint16_t)((299u * rgb[0] + 587u * rgb[1] + 114u * rgb[2] + 500u) / 1000u);
    }
    frame->channels = 1;
}
