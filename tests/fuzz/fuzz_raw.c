/* SPDX-License-Identifier: MIT
 * Raw rows: any format, size, row and stretch; the same pixels one at a time. */
#include "fuzz.h"

#include "plenofix/raw.h"

static void stretch(const plfx_raw_row *row, int32_t x0, int32_t n)
{
    uint16_t *out = fuzz_room(n > 0 ? 2 * (size_t)n : 0);
    uint16_t one;
    int32_t x;

    if (plfx_raw_unpack(row, x0, n, out) == PLFX_OK) {
        for (x = 0; x < n; x++) {
            fuzz_must(plfx_raw_unpack(row, x0 + x, 1, &one) == PLFX_OK &&
                      one == out[x]);
        }
    }
    free(out);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    plfx_raw raw;
    plfx_raw_row row;
    uint8_t *copy;
    int32_t y;
    int32_t x0;
    int32_t count;

    raw.format = (uint8_t)fuzz_u8(&in);
    raw.bits = (uint8_t)fuzz_u8(&in);
    raw.w = fuzz_range(&in, -1, 300);
    raw.h = fuzz_range(&in, -1, 40);
    y = fuzz_range(&in, -1, 40);
    x0 = fuzz_range(&in, -1, 300);
    count = fuzz_range(&in, -1, 300);
    copy = fuzz_rest(&in);
    raw.bytes = copy;
    raw.size = in.left;
    if (plfx_raw_row_at(&raw, y, &row) == PLFX_OK) {
        stretch(&row, x0, count);
        stretch(&row, 0, row.width);
    }
    free(copy);
    return 0;
}
