/* SPDX-License-Identifier: MIT
 * TIFF pictures. */
#include "picture.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_picture(plft_tiff_parse, bytes, n);
    return 0;
}
