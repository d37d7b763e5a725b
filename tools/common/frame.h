/* SPDX-License-Identifier: MIT
 * Frames and pictures: PNG and TIFF in, PNG out. */
#ifndef PLFT_FRAME_H
#define PLFT_FRAME_H

#include <stddef.h>
#include <stdint.h>

#define PLFT_SIDE_MAX 32767 /* pixels on a side, as in plfx_raw */
/* Of one picture, 512 MB: a forged head asks for no more memory. */
#define PLFT_SAMPLES_MAX (1ul << 28)

/* A frame of right-justified samples.  File values are kept: 8-bit files give bits 8,
 * 16-bit files bits 16, or `bits` when the caller names it. */
typedef struct plft_frame {
    uint16_t *px; /* [h][w][channels], malloc'd */
    int w, h;
    int channels; /* 1 grey or mosaic, 3 RGB */
    int bits;     /* significant bits of a sample */
} plft_frame;

/* Read a PNG or TIFF, 8 or 16 bits, grey or RGB, by its content.  Palette images and
 * alpha are refused.  bits 0: as the file; 8..16: samples over 2^bits - 1 are refused.
 * 0 or PLFT_DATA with a message. */
int plft_frame_read(plft_frame *frame, const char *path, int bits);

/* The readers behind it, from n bytes in memory; `name` is for messages.  bits is the
 * file's.  0 or PLFT_DATA with a message. */
int plft_png_parse(plft_frame *frame, const unsigned char *bytes, size_t n,
                   const char *name);
int plft_tiff_parse(plft_frame *frame, const unsigned char *bytes, size_t n,
                    const char *name);

/* Room for w x h x channels samples; checks 1 .. PLFT_SIDE_MAX.  0 or PLFT_DATA. */
int plft_frame_alloc(plft_frame *frame, unsigned long w, unsigned long h, int channels,
                     const char *name);

/* Replace an RGB frame by its luma (Rec. 601, rounded); no effect on grey. */
void plft_frame_to_grey(plft_frame *frame);

void plft_frame_free(plft_frame *frame);

/* Write PNG: bit depth 8 when bits <= 8, else 16; samples are written as they are, with
 * an sBIT chunk when bits is neither 8 nor 16.  0 or PLFT_DATA. */
int plft_png_write(const char *path, const plft_frame *frame);

/* 8-bit RGB picture. */
int plft_png_write_rgb8(const char *path, const uint8_t *rgb, int w, int h);

#endif
