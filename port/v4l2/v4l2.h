/* SPDX-License-Identifier: MIT
 * Video devices of Linux by memory-mapped streaming: greyscale and Bayer, 8 to 16
 * bits, unpacked or packed as MIPI packs them.
 *
 * The driver owns the memory: frames lie in its mapping, no copy is made, and the
 * pool is used only where the driver pads its rows: then the padding is taken out
 * into it. */
#ifndef PLENOFIX_PORT_V4L2_H
#define PLENOFIX_PORT_V4L2_H

#include "plenofix/port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_V4L2_BUFFERS 32

typedef struct plfx_v4l2 {
    plfx_camera camera; /* the interface; filled by plfx_v4l2_init() */
    const char *path;
    int error; /* errno of the last failure */

    /* private */
    int file;
    int32_t running, buffers;
    plfx_camera_cfg cfg;
    plfx_camera_count count;
    plfx_pool pool;
    uint8_t *map[PLFX_V4L2_BUFFERS];
    size_t length[PLFX_V4L2_BUFFERS];
    uint8_t taken[PLFX_V4L2_BUFFERS];
    uint32_t stride; /* bytes from row to row */
    uint32_t row;    /* bytes of a row's pixels */
    uint32_t exposure_us;
    int64_t last_number; /* of the driver; -1: none yet */
    uint64_t sequence, last_good, last_ns;
} plfx_v4l2;

/* Exposure is set by V4L2_CID_EXPOSURE_ABSOLUTE and gain, which V4L2 gives no unit, by
 * V4L2_CID_GAIN in the driver's steps of a thousandth of gain_mdb. */
void plfx_v4l2_init(plfx_v4l2 *v, const char *path);

/* The V4L2 code of a format, or 0; and its entry back: 0, or -1 when the core cannot
 * unpack it. */
uint32_t plfx_v4l2_code(uint8_t format, uint8_t bits, uint8_t bayer);
int plfx_v4l2_find(uint32_t code, uint8_t *format, uint8_t *bits, uint8_t *bayer);

#ifdef __cplusplus
}
#endif
#endif
