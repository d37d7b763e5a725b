/* SPDX-License-Identifier: MIT
 * Goldens: the CRC-32 of each stage's output on made input.  Every target, compiler and
 * optimisation gives the same.  No C library but memset and friends is needed, so the
 * same file runs freestanding. */
#ifndef GOLDEN_H
#define GOLDEN_H

#include <stddef.h>
#include <stdint.h>

typedef struct golden_stage {
    const char *name;
    uint32_t (*run)(void); /* CRC of the output; 0 when the stage returned an error */
    uint32_t crc;          /* what it must be */
} golden_stage;

extern const golden_stage golden_stages[];
extern const size_t golden_count;

/* CRC-32 (reflected 0xedb88320) of values fed as little-endian bytes. */
typedef struct golden_crc {
    uint32_t reg;
} golden_crc;

void golden_begin(golden_crc *c);
void golden_add(golden_crc *c, uint32_t value, int32_t bytes);
uint32_t golden_end(const golden_crc *c);

/* Stages of structural motion (motion.c). */
uint32_t golden_regions(void);
uint32_t golden_modes(void);
uint32_t golden_packets(void);

/* The generator of all made input: 32 bits a call, the high ones best. */
uint32_t golden_random(uint32_t *state);

#endif
