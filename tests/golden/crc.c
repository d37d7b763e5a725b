/* SPDX-License-Identifier: MIT
 * Checksum and generator of the goldens. */
#include "golden.h"

void golden_begin(golden_crc *c)
{
    c->reg = 0xffffffffu;
}

void golden_add(golden_crc *c, uint32_t value, int32_t bytes)
{
    int32_t i;
    int32_t k;

    for (i = 0; i < bytes; i++) {
        c->reg ^= (value >> (8 * i)) & 0xffu;
        for (k = 0; k < 8; k++) {
            c->reg = (c->reg >> 1) ^ (0xedb88320u & (0u - (c->reg & 1u)));
        }
    }
}

uint32_t golden_end(const golden_crc *c)
{
    return ~c->reg;
}

uint32_t golden_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state;
}
