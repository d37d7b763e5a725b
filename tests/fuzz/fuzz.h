/* SPDX-License-Identifier: MIT
 * What the harnesses share: numbers taken from the input one after another, and
 * memory of the very size that is wanted: a sanitizer sees the first byte beyond it. */
#ifndef PLENOFIX_TESTS_FUZZ_H
#define PLENOFIX_TESTS_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The entry of libFuzzer; replay.c calls it with each input of the corpus. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n);

typedef struct fuzz_input {
    const uint8_t *at;
    size_t left;
} fuzz_input;

/* The next byte; 0 when none is left. */
static inline uint32_t fuzz_u8(fuzz_input *in)
{
    if (in->left == 0) {
        return 0;
    }
    in->left--;
    return *in->at++;
}

static inline uint32_t fuzz_u16(fuzz_input *in)
{
    uint32_t low = fuzz_u8(in);

    return low | fuzz_u8(in) << 8;
}

/* lo .. hi, at most 65536 values. */
static inline int32_t fuzz_range(fuzz_input *in, int32_t lo, int32_t hi)
{
    return lo + (int32_t)(fuzz_u16(in) % (uint32_t)(hi - lo + 1));
}

/* Zeroed; a test that finds no memory ends. */
static inline void *fuzz_room(size_t n)
{
    void *p = calloc(n ? n : 1, 1);

    if (!p) {
        abort();
    }
    return p;
}

/* A copy of what is left. */
static inline uint8_t *fuzz_rest(const fuzz_input *in)
{
    uint8_t *p = fuzz_room(in->left);

    if (in->left) {
        memcpy(p, in->at, in->left);
    }
    return p;
}

/* What must hold whatever the input. */
static inline void fuzz_must(int holds)
{
    if (!holds) {
        abort();
    }
}

#endif
