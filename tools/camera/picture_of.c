/* SPDX-License-Identifier: MIT */
#include "camera/picture_of.h"

#include "common/err.h"

int plft_picture_of(plft_frame *picture, const plfx_camera_frame *frame,
                    const char *name)
{
    plfx_raw_row row;
    int32_t y;
    int rc = plft_frame_alloc(picture, (unsigned long)frame->raw.w,
                              (unsigned long)frame->raw.h, 1, name);

    for (y = 0; rc == 0 && y < frame->raw.h; y++) {
        if (plfx_raw_row_at(&frame->raw, y, &row) != PLFX_OK ||
            plfx_raw_unpack(&row, 0, row.width,
                            picture->px + (size_t)y * (size_t)row.width) != PLFX_OK) {
            rc = plft_fail(PLFT_DATA, "%s: frame cannot be unpacked", name);
        }
    }
    picture->bits = frame->raw.bits;
    if (rc != 0) {
        plft_frame_free(picture);
    }
    return rc;
}
