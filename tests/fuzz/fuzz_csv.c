/* SPDX-License-Identifier: MIT
 * Tables of numbers. */
#include "fuzz.h"

#include "common/csv.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    char *text = fuzz_room(n + 1);
    plft_csv csv;

    if (n) {
        memcpy(text, bytes, n);
    }
    if (plft_csv_parse(&csv, text, n, "input") == 0) {
        fuzz_must(csv.cols >= 1 && csv.cols <= PLFT_CSV_COLS_MAX);
        (void)plft_csv_column(&csv, "x");
        plft_csv_free(&csv);
    }
    free(text);
    return 0;
}
