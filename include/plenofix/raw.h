/* SPDX-License-Identifier: MIT
 * Raw sensor rows: unpacked and packed layouts, Bayer mosaics.
 * Layouts are those of PFNC 2.1, GigE Vision 1.x and MIPI CSI-2; src/FORMAT.md draws
 * them byte by byte. */
#ifndef PLENOFIX_RAW_H
#define PLENOFIX_RAW_H

#include "plenofix/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum plfx_raw_format {
    PLFX_RAW_U8 = 0,       /* one byte a pixel */
    PLFX_RAW_U16LE,        /* little-endian 16-bit container, right-justified */
    PLFX_RAW_U16,          /* the same in the machine's own order, aligned; sampled in
                              place: what stands above the significant bits must be 0 */
    PLFX_RAW_MONO10P,      /* PFNC lsb-packed: 4 pixels in 5 bytes, one bit stream */
    PLFX_RAW_MONO12P,      /* PFNC lsb-packed: 2 pixels in 3 bytes, one bit stream */
    PLFX_RAW_MONO10PACKED, /* GigE Vision: 2 pixels in 3 bytes */
    PLFX_RAW_MONO12PACKED, /* GigE Vision: 2 pixels in 3 bytes, high bytes outside */
    PLFX_RAW_CSI10,        /* MIPI: 4 high bytes, then the 4 pairs of low bits */
    PLFX_RAW_CSI12,        /* MIPI: 2 high bytes, then the 2 low nibbles */
    PLFX_RAW_FORMATS       /* count, not a format */
} plfx_raw_format;

/* A row of pixels inside a frame.  A packed frame is one bit stream: a row of odd width
 * does not start on a byte. */
typedef struct plfx_raw_row {
    const uint8_t *bytes; /* the byte that holds the row's first bit */
    uint8_t format;       /* plfx_raw_format */
    uint8_t bits;         /* significant bits, 8 .. 16 */
    uint8_t bit;          /* first bit inside bytes[0]: 0, or 4 with 12-bit streams, or
                             0/2/4/6 with 10-bit streams; 0 for unpacked */
    int32_t width;        /* pixels, 1 .. 32767 */
} plfx_raw_row;

typedef struct plfx_raw { /* a whole frame in one bit stream, no padding between rows */
    const uint8_t *bytes;
    size_t size; /* bytes available */
    uint8_t format, bits;
    int32_t w, h; /* pixels, 1 .. 32767 */
} plfx_raw;

/* Bits of storage for one pixel of a format; 0 if the format is unknown.
 * MONO10PACKED and MONO12PACKED both take 12. */
int32_t plfx_raw_bpp(int32_t format);

/* Bytes of a frame: ceil(w*h*bpp/8) of a bit stream (MONO10P, MONO12P); layouts that
 * keep low bits apart end with a whole group (3 or 5 bytes), once a frame.  0 if an
 * argument is out of range. */
size_t plfx_raw_bytes(int32_t format, int32_t w, int32_t h);

/* Row y of a frame.  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE (frame shorter than w*h). */
plfx_status plfx_raw_row_at(const plfx_raw *raw, int32_t y,
                            plfx_raw_row *row) PLFX_MUST_USE;

/* out[0..n) = pixels x0 .. x0+n-1, right-justified, masked to `bits`.  Any x0: packed
 * groups are entered in their middle.  Reads no byte beyond the last pixel's own.
 * PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_raw_unpack(const plfx_raw_row *row, int32_t x0, int32_t n,
                            uint16_t *out) PLFX_MUST_USE;

/* Which colour of a Bayer mosaic stands at pixel (0,0), read along the row. */
typedef enum plfx_bayer {
    PLFX_BAYER_NONE = 0,
    PLFX_BAYER_RGGB,
    PLFX_BAYER_GRBG,
    PLFX_BAYER_GBRG,
    PLFX_BAYER_BGGR
} plfx_bayer;

/* Grey of a mosaic by 2x2 mean: out[x] = (r0[x]+r0[x+1]+r1[x]+r1[x+1]+2)>>2 for
 * x = 0 .. w-2; out[w-1] = out[w-2].  Each sample holds R+2G+B whatever the phase and
 * is centred at (x+1/2, y+1/2): give plfx_tone.dx_q8 = dy_q8 = -128.  r0, r1: two
 * neighbouring rows, w >= 2 samples each.  `out` may be r0.  PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_raw_bayer_grey(const uint16_t *r0, const uint16_t *r1, int32_t w,
                                uint16_t *out) PLFX_MUST_USE;

/* One channel of a mosaic at every pixel: the pixel itself where it has that colour,
 * else the rounded mean of its nearest neighbours of that colour (2 or 4).
 *   above, below: the neighbouring rows, or NULL at the border of the frame (mirrored)
 *   channel: 0 red, 1 green, 2 blue;  y: row number in the frame (its parity matters)
 * PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_raw_bayer_channel(int32_t bayer, int32_t channel, int32_t y,
                                   const uint16_t *above, const uint16_t *row,
                                   const uint16_t *below, int32_t w,
                                   uint16_t *out) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
