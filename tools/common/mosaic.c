/* SPDX-License-Identifier: MIT */
#include "common/mosaic.h"

#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"
#include "plenofix/raw.h"

int plft_subtract_dark(plft_frame *frame, const plft_frame *dark, const char *name)
{
    size_t n = (size_t)frame->w * (size_t)frame->h * (size_t)frame->channels;
    unsigned full = (1u << frame->bits) - 1u;
    size_t i;

    if (dark->w != frame->w || dark->h != frame->h ||
        dark->channels != frame->channels || dark->bits != frame->bits) {
        return plft_fail(
            PLFT_DATA,
            "%s: %d x %d, %d bits where the frame has %d x %d, %d bits; take "
            "it with the same camera settings",
            name, dark->w, dark->h, dark->bits, frame->w, frame->h, frame->bits);
    }
    for (i = 0; i < n; i++) {
        uint16_t p = frame->px[i], d = dark->px[i];
        frame->px[i] = p >= full ? p : p > d ? (uint16_t)(p - d) : 0;
    }
    return 0;
}

static uint16_t *row(const plft_frame *f, int y)
{
    return f->px + (size_t)y * (size_t)f->w;
}

/* In place: a row is read for the last time when it is written. */
static int mosaic_grey(plft_frame *f)
{
    int y;

    for (y = 0; y + 1 < f->h; y++) {
        if (plfx_raw_bayer_grey(row(f, y), row(f, y + 1), f->w, row(f, y)) != PLFX_OK) {
            return PLFT_DATA;
        }
    }
    if (f->h > 1) {
        memcpy(row(f, f->h - 1), row(f, f->h - 2), (size_t)f->w * sizeof *f->px);
    }
    return f->h > 1 ? 0 : PLFT_DATA;
}

static int mosaic_channel(plft_frame *f, int bayer, int channel)
{
    plft_frame to;
    int y, rc;

    rc = plft_frame_alloc(&to, (unsigned long)f->w, (unsigned long)f->h, 1, "frame");
    for (y = 0; y < f->h && rc == 0; y++) {
        const uint16_t *above = y > 0 ? row(f, y - 1) : NULL;
        const uint16_t *below = y + 1 < f->h ? row(f, y + 1) : NULL;
        if (plfx_raw_bayer_channel(bayer, channel, y, above, row(f, y), below, f->w,
                                   row(&to, y)) != PLFX_OK) {
            rc = PLFT_DATA;
        }
    }
    if (rc != 0) {
        plft_frame_free(&to);
        return rc;
    }
    to.bits = f->bits;
    plft_frame_free(f);
    *f = to;
    return 0;
}

int plft_to_plane(plft_frame *frame, int bayer, int channel, int *half,
                  const char *name)
{
    int rc;

    *half = 0;
    if (bayer == PLFX_BAYER_NONE) {
        plft_frame_to_grey(frame);
        return 0;
    }
    if (frame->channels != 1) {
        return plft_fail(PLFT_DATA, "%s: an RGB picture; leave out --bayer", name);
    }
    if (channel == PLFT_CHANNEL_GREY) {
        *half = 1;
        rc = mosaic_grey(frame);
    } else {
        rc = mosaic_channel(frame, bayer, channel);
    }
    return rc == 0 ? 0
                   : plft_fail(PLFT_DATA, "%s: %d x %d is too small for a mosaic", name,
                               frame->w, frame->h);
}
