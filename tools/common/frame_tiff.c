/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

#include "common/err.h"
#include "common/frame.h"
#include "common/memory.h"

typedef struct source {
    const unsigned char *bytes;
    toff_t n, at;
} source;

static tmsize_t on_read(thandle_t h, void *to, tmsize_t n)
{
    source *s = (source *)h;
    toff_t left = s->at < s->n ? s->n - s->at : 0;
    toff_t take = (toff_t)n < left ? (toff_t)n : left;

    memcpy(to, s->bytes + (take > 0 ? s->at : 0), (size_t)take);
    s->at += take;
    return (tmsize_t)take;
}

static tmsize_t on_write(thandle_t h, void *from, tmsize_t n)
{
    (void)h;
    (void)from;
    (void)n;
    return -1;
}

static toff_t on_seek(thandle_t h, toff_t to, int whence)
{
    source *s = (source *)h;

    s->at = whence == SEEK_SET ? to : whence == SEEK_CUR ? s->at + to : s->n + to;
    return s->at;
}

static int on_close(thandle_t h)
{
    (void)h;
    return 0;
}

static toff_t on_size(thandle_t h)
{
    return ((source *)h)->n;
}

typedef struct kind {
    uint16_t depth, channels, planar, format, photometric;
} kind;

static int accept_kind(TIFF *tiff, kind *k, const char *name)
{
    k->photometric = PHOTOMETRIC_MINISBLACK;
    (void)TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &k->depth);
    (void)TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &k->channels);
    (void)TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &k->planar);
    (void)TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &k->format);
    (void)TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &k->photometric);
    if (k->photometric == PHOTOMETRIC_PALETTE) {
        return plft_fail(PLFT_DATA, "%s: a palette TIFF; save it as grey or RGB", name);
    }
    if ((k->depth != 8 && k->depth != 16) || k->format != SAMPLEFORMAT_UINT) {
        return plft_fail(PLFT_DATA,
                         "%s: a TIFF of %u bits a sample, kind %u; save it "
                         "with 8 or 16 bits, unsigned",
                         name, k->depth, k->format);
    }
    if ((k->channels != 1 && k->channels != 3) ||
        (k->channels == 3 && k->planar != PLANARCONFIG_CONTIG)) {
        return plft_fail(PLFT_DATA,
                         "%s: a TIFF of %u samples a pixel; save it as grey or "
                         "interleaved RGB, without alpha",
                         name, k->channels);
    }
    if (k->photometric == PHOTOMETRIC_MINISWHITE || TIFFIsTiled(tiff)) {
        return plft_fail(PLFT_DATA,
                         "%s: a tiled or inverted TIFF; save it in strips, "
                         "black as 0",
                         name);
    }
    return 0;
}

static int read_rows(TIFF *tiff, const kind *k, plft_frame *frame, const char *name)
{
    size_t n = (size_t)frame->w * (size_t)frame->channels;
    unsigned char *row = NULL;
    int y, rc = 0;

    if ((size_t)TIFFScanlineSize(tiff) != n * (k->depth / 8u)) {
        return plft_fail(PLFT_DATA,
                         "%s: a TIFF of a layout we do not read; save it as "
                         "plain grey or RGB",
                         name);
    }
    row = (unsigned char *)plft_alloc(n, 2);
    if (row == NULL) {
        return PLFT_DATA;
    }
    for (y = 0; y < frame->h && rc == 0; y++) {
        uint16_t *px = frame->px + (size_t)y * n;
        size_t i;
        if (TIFFReadScanline(tiff, row, (uint32_t)y, 0) < 0) {
            rc = plft_fail(PLFT_DATA, "%s: damaged TIFF in row %d; copy it again", name,
                           y);
        }
        for (i = 0; i < n && rc == 0;
             i++) { /* libtiff gives the machine's byte order */
            if (k->depth == 8) {
                px[i] = row[i];
            } else {
                memcpy(&px[i], row + 2 * i, 2);
            }
        }
    }
    free(row);
    return rc;
}

static int read_tiff(TIFF *tiff, plft_frame *frame, const char *name)
{
    uint32_t w = 0, h = 0;
    kind k;

    (void)TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &w);
    (void)TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &h);
    if (accept_kind(tiff, &k, name) != 0 ||
        plft_frame_alloc(frame, w, h, k.channels, name) != 0) {
        return PLFT_DATA;
    }
    frame->bits = k.depth;
    return read_rows(tiff, &k, frame, name);
}

int plft_tiff_parse(plft_frame *frame, const unsigned char *bytes, size_t n,
                    const char *name)
{
    source s;
    TIFF *tiff;
    int rc;

    memset(frame, 0, sizeof *frame);
    s.bytes = bytes;
    s.n = n;
    s.at = 0;
    (void)TIFFSetErrorHandler(NULL); /* we say one line ourselves */
    (void)TIFFSetWarningHandler(NULL);
    tiff = TIFFClientOpen(name, "rm", (thandle_t)&s, on_read, on_write, on_seek,
                          on_close, on_size, NULL, NULL);
    if (tiff == NULL) {
        return plft_fail(PLFT_DATA, "%s: damaged TIFF; copy it again", name);
    }
    rc = read_tiff(tiff, frame, name);
    TIFFClose(tiff);
    if (rc != 0) {
        plft_frame_free(frame);
    }
    return rc;
}
