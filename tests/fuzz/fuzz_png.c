/* SPDX-License-Identifier: MIT
 * PNG pictures. */
#include "picture.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_picture(plft_png_parse, bytes, n);
    return 0;
}
