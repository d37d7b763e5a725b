/* SPDX-License-Identifier: MIT
 * A recording, or a file of bare raw frames, played as a camera: in real time, faster,
 * or as fast as frames are taken. */
#ifndef PLENOFIX_PORT_REPLAY_H
#define PLENOFIX_PORT_REPLAY_H

#include "recording.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_REPLAY_SLOTS 32

typedef struct plfx_replay {
    plfx_camera camera; /* the interface; fill by plfx_replay_init() */
    const char *path;
    plfx_clock clock;
    int32_t bare;      /* 1: raw frames one behind the other, cfg says which */
    int32_t bands;     /* 1: acquire returns at the first row; rows() gives the rest */
    int32_t loop;      /* 1: begin again at the end */
    uint32_t speed_q8; /* 256: in real time; 0: no waiting */

    /* private */
    plfx_recording record;
    plfx_pool pool;
    plfx_camera_cfg cfg;
    plfx_camera_count count;
    uint8_t taken[PLFX_REPLAY_SLOTS];
    int32_t running, open;
    uint64_t next, total; /* frame to play, frames in the file */
    uint64_t began_ns;    /* clock when frame `first` was due */
    uint64_t first_ns;    /* its recorded time */
    uint64_t last_ns;     /* time of the frame before */
    uint32_t last_number; /* of the frame before, in the file */
    uint32_t rounds;      /* added to it since the file began anew */
} plfx_replay;

/* A camera that plays `path`.  Set bare, bands, loop and speed_q8 before
 * camera.open.  A bare file takes size, format and rate from the configuration.  At
 * the end of the file acquire returns PLFX_E_DEVICE: the camera is gone. */
void plfx_replay_init(plfx_replay *r, const char *path, plfx_clock clock);

#ifdef __cplusplus
}
#endif
#endif
