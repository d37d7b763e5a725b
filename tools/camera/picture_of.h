/* SPDX-License-Identifier: MIT
 * A camera's frame as a picture. */
#ifndef PLFT_PICTURE_OF_H
#define PLFT_PICTURE_OF_H

#include "common/frame.h"
#include "plenofix/port.h"

/* Unpack all pixels, mosaics as they are.  0 or PLFT_DATA with a message. */
int plft_picture_of(plft_frame *picture, const plfx_camera_frame *frame,
                    const char *name);

#endif
