/* SPDX-License-Identifier: MIT
 * One picture by one of the readers: samples lie below 2^bits, grey can be made. */
#ifndef PLENOFIX_TESTS_FUZZ_PICTURE_H
#define PLENOFIX_TESTS_FUZZ_PICTURE_H

#include "fuzz.h"

#include "common/frame.h"

typedef int fuzz_parse(plft_frame *frame, const unsigned char *bytes, size_t n,
                       const char *name);

static inline void fuzz_picture(fuzz_parse *parse, const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint8_t *copy = fuzz_rest(&in);
    plft_frame f;

    if (parse(&f, copy, n, "input") == 0) {
        size_t last = (size_t)f.w * (size_t)f.h * (size_t)f.channels - 1u;
        fuzz_must(f.px[last] < 1l << f.bits);
        plft_frame_to_grey(&f);
        plft_frame_free(&f);
    }
    free(copy);
}

#endif
