/* SPDX-License-Identifier: MIT
 * What .ci/checks/instructions.py counts on an emulated Cortex-M7.
 *   counts stages         every golden stage once
 *   counts fast|small N   N frames of the goldens' scene through a stream, a row of
 *                         lenses at a time */
#include "golden/golden.h"
#include "golden/scene.h"

#include <stdlib.h>
#include <string.h>

#define BAND 10 /* sensor rows of a row of lenses */

static int stages(void)
{
    int wrong = 0;

    for (size_t i = 0; i < golden_count; i++) {
        wrong |= golden_stages[i].run() != golden_stages[i].crc;
    }
    return wrong;
}

static plfx_status pop(plfx_stream *s, int32_t ready)
{
    plfx_status status = PLFX_OK;

    while (status == PLFX_OK && ready > 0) {
        plfx_map line = scene_empty();
        int32_t j;
        line.h = 1;
        status = plfx_stream_pop(s, &j, &line, &ready);
    }
    return status;
}

/* Map rows are popped as soon as they are whole; the band then goes on. */
static plfx_status push(plfx_stream *s, int32_t y)
{
    plfx_raw band = scene_raw();
    plfx_status status = PLFX_OK;
    int32_t left = BAND;

    while (status == PLFX_OK && left > 0) {
        int32_t used = 0;
        int32_t ready = 0;
        size_t skip = (size_t)y * SCENE_W * 2u;
        band = scene_raw();
        band.bytes += skip;
        band.size = (size_t)left * SCENE_W * 2u;
        band.h = left;
        status = plfx_stream_push_band(s, y, &band, &used, &ready);
        if (status == PLFX_OK) {
            status = pop(s, ready);
        }
        y += used;
        left -= used;
    }
    return status;
}

static int frames(int32_t profile, int32_t count)
{
    plfx_stream s;

    if (scene_stream(&s, profile) != PLFX_OK) {
        return 1;
    }
    for (int32_t i = 0; i < count; i++) {
        for (int32_t y = 0; y < SCENE_H; y += BAND) {
            if (push(&s, y) != PLFX_OK) {
                return 1;
            }
        }
        if (plfx_stream_finish(&s) != PLFX_OK || plfx_stream_reset(&s) != PLFX_OK) {
            return 1;
        }
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 2) {
        return stages();
    }
    if (argc != 3) {
        return 2;
    }
    return frames(strcmp(argv[1], "fast") == 0 ? PLFX_PROFILE_FAST : PLFX_PROFILE_SMALL,
                  atoi(argv[2]));
}
