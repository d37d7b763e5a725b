/* SPDX-License-Identifier: MIT
 * PNG pictures. */
#include "fuzz.h"

#include "common/frame.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint8_t *copy = fuzz_rest(&in);
    plft_frame frame;

    if (plft_png_parse(&frame, copy, n, "input") == 0) {
        fuzz_must(
            frame.px[(size_t)frame.w * (size_t)frame.h * (size_t)frame.channels - 1u] <
            1l << frame.bits);
        plft_frame_to_grey(&frame);
        plft_frame_free(&frame);
    }
    free(copy);
    return 0;
}
