/* SPDX-License-Identifier: MIT
 * View rows at rest: low bytes of a row, then for more than 8 bits the high nibbles of
 * lens i and of lens half + i in one byte.  Three bytes for two samples. */
#ifndef PLENOFIX_SRC_STORE_H
#define PLENOFIX_SRC_STORE_H

#include <stddef.h>
#include <stdint.h>

/* Bytes of a stored row of nx samples. */
static inline size_t plfx_store_bytes(int32_t nx, int32_t bits)
{
    return (size_t)nx + (bits > 8 ? ((size_t)nx + 1u) / 2u : 0u);
}

static inline void plfx_store_put(uint8_t *to, int32_t nx, int32_t bits,
                                  const uint16_t *row)
{
    int32_t half = (nx + 1) / 2;
    int32_t i;

    for (i = 0; i < nx; i++) {
        to[i] = (uint8_t)(row[i] & 255u);
    }
    for (i = 0; bits > 8 && i < half; i++) {
        uint32_t upper = half + i < nx ? row[half + i] >> 8 : 0u;
        to[nx + i] = (uint8_t)(row[i] >> 8 | upper << 4);
    }
}

static inline void plfx_store_get(const uint8_t *from, int32_t nx, int32_t bits,
                                  uint16_t *row)
{
    int32_t half = (nx + 1) / 2;
    int32_t i;

    if (bits <= 8) {
        for (i = 0; i < nx; i++) {
            row[i] = from[i];
        }
        return;
    }
    for (i = 0; i < half; i++) {
        row[i] = (uint16_t)(from[i] | (from[nx + i] & 15u) << 8);
    }
    for (i = half; i < nx; i++) {
        row[i] = (uint16_t)(from[i] | (uint32_t)(from[nx + i - half] >> 4) << 8);
    }
}

#endif
