/* SPDX-License-Identifier: MIT
 * Cameras by name, for the commands that take frames:
 *   gige, gige:NAME            a GigE Vision camera
 *   v4l2:/dev/video0           a video device
 *   FLIGHT.plxr                a recording
 *   FRAMES.raw                 bare frames one behind the other; wants size and format
 *   A.png B.png ...            pictures, one a frame */
#ifndef PLFT_SOURCE_H
#define PLFT_SOURCE_H

#include "common/args.h"
#include "plenofix/lut.h"
#include "plenofix/port.h"

#define PLFT_SOURCE_OPTIONS 12 /* options that plft_wish_options() fills in */

typedef struct plft_wish { /* as the command line names it */
    const char *const *names;
    int n; /* operands: one camera, or the pictures */
    const char *size, *offset;
    int format; /* index in PLFT_FORMATS; -1: the camera's */
    int bayer, bits;
    double exposure_us, gain_db, rate, speed, patience;
    int packet, slots, frames;
} plft_wish;

typedef struct plft_camera {
    plfx_camera *port; /* the interface */
    plfx_camera_cfg cfg;
    plfx_pool pool;
    const char *name;
    int ends;           /* 1: a file, whose end is no failure */
    uint32_t camera_id; /* noted in a recording, or of the serial number; 0: none */

    void *memory, *state; /* private */
    int64_t patience_ms;
} plft_camera;

/* Wishes that leave everything to the camera, without waiting between frames. */
void plft_wish_none(plft_wish *wish);

/* Options of `wish` into table[0..]; returns how many. */
int plft_wish_options(plft_option *table, plft_wish *wish);

/* Open and start.  0, PLFT_DATA or PLFT_USAGE with a message. */
int plft_camera_start(plft_camera *c, const plft_wish *wish);

/* The next whole frame.  0; PLFT_DATA with a message; -1 at the end of a file or after
 * an interrupt (ctrl-C and SIGTERM end a command in order). */
int plft_camera_next(plft_camera *c, plfx_camera_frame *frame);

void plft_camera_release(plft_camera *c, const plfx_camera_frame *frame);

/* Does a table, read from `path`, belong to the camera's frames?  0, or PLFT_DATA with
 * a message: another size, another camera.  Warns of another bit depth. */
int plft_camera_suits(const plft_camera *c, const plfx_lut *lut, const char *path);

/* Line of what was lost, when anything was. */
void plft_camera_report(const plft_camera *c);

void plft_camera_stop(plft_camera *c);

#endif
