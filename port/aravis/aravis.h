/* SPDX-License-Identifier: MIT
 * GigE Vision (and USB3 Vision) cameras by the Aravis library.  Frames arrive in the
 * caller's pool and are handed out there: no copy is made in this layer.
 *
 * A frame of which a packet is missing is pushed back and counted; it is never
 * handed out.  The 16-bit frame number of GigE Vision (1 .. 65535, then 1 again) is
 * widened. */
#ifndef PLENOFIX_PORT_ARAVIS_H
#define PLENOFIX_PORT_ARAVIS_H

#include "plenofix/port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_ARAVIS_SLOTS 32

typedef struct plfx_aravis {
    plfx_camera camera; /* the interface; filled by plfx_aravis_init() */
    const char *name;   /* as Aravis lists it, or an address; NULL: the first found */
    char message[160];  /* of the last failure, in Aravis' words */
    uint32_t camera_id; /* of the open camera, for tables; 0: no serial number */

    /* private */
    void *device, *stream;
    void *taken[PLFX_ARAVIS_SLOTS]; /* buffers in the caller's hands */
    plfx_pool pool;
    plfx_camera_cfg cfg;
    plfx_camera_count count;
    size_t payload;
    uint32_t code; /* PFNC */
    uint32_t exposure_us;
    uint64_t last_id; /* on the wire; 0: none yet */
    uint64_t broken;  /* frames that arrived broken since */
    uint64_t sequence, last_good;
    uint64_t last_ns;
    int64_t asked_us;          /* when the camera was last asked for its clock */
    uint8_t clock, last_clock; /* plfx_clock_id: of the camera, of the last frame */
    uint8_t ptp;               /* offered */
    int32_t running;
    int lost; /* set by Aravis' thread when the camera is gone */
} plfx_aravis;

/* The id of a camera by its serial number: a decimal number below 10^9 as it is, else
 * the FNV-1a hash of the text without its top bit. */
uint32_t plfx_aravis_id(const char *serial);

/* Names and settings: width, height, offset, format, exposure, gain, rate and packet
 * size from the configuration; zero leaves the camera's.  A camera that offers IEEE
 * 1588 is asked to use it; frames say PLFX_CLOCK_PTP while it is locked, which is asked
 * at the start and then once a second. */
void plfx_aravis_init(plfx_aravis *a, const char *name);

#ifdef __cplusplus
}
#endif
#endif
