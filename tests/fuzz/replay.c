/* SPDX-License-Identifier: MIT
 * Runs a harness over its corpus, a file of inputs one after another: length (4 bytes,
 * little-endian), bytes.  Without libFuzzer: any compiler.  Speaks TAP. */
#include "fuzz.h"

#include <stdio.h>

static int take(FILE *f, uint8_t **bytes, size_t *n)
{
    uint8_t head[4];

    if (fread(head, 1, 4, f) != 4) {
        return 0;
    }
    *n = head[0] | (size_t)head[1] << 8 | (size_t)head[2] << 16 | (size_t)head[3] << 24;
    *bytes = fuzz_room(*n);
    return fread(*bytes, 1, *n, f) == *n;
}

int main(int argc, char **argv)
{
    FILE *f = argc == 2 ? fopen(argv[1], "rb") : NULL;
    uint8_t *bytes = NULL;
    size_t count = 0;
    size_t n = 0;

    if (!f) {
        printf("Bail out! no corpus\n");
        return 1;
    }
    while (take(f, &bytes, &n)) {
        (void)LLVMFuzzerTestOneInput(bytes, n);
        free(bytes);
        count++;
    }
    (void)fclose(f);
    printf("1..1\n%s 1 - %u inputs\n", count ? "ok" : "not ok", (unsigned)count);
    return count == 0;
}
