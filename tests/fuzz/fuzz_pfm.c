/* SPDX-License-Identifier: MIT
 * PFM maps. */
#include "fuzz.h"

#include "common/pfm.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint8_t *copy = fuzz_rest(&in);
    plft_map map;

    if (plft_pfm_parse(&map, copy, n, "input") == 0) {
        fuzz_must(map.w > 0 && map.h > 0);
        plft_map_free(&map);
    }
    free(copy);
    return 0;
}
