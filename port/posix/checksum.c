/* SPDX-License-Identifier: MIT
 * With table[0][b] the register after byte b alone and table[k][b] that after k further
 * zero bytes, eight bytes are one sum of eight look-ups, the CRC being linear. */
#include "checksum.h"

#include "store/bytes.h"
#include "store/crc.h"

static uint32_t table[8][256];

static void fill(void)
{
    uint32_t b;
    int k;

    for (b = 0; b < 256; b++) {
        uint8_t byte = (uint8_t)b;
        table[0][b] = ~plfx_port_crc32(0xffffffffu, &byte, 1);
    }
    for (k = 1; k < 8; k++) {
        for (b = 0; b < 256; b++) {
            uint32_t v = table[k - 1][b];
            table[k][b] = v >> 8 ^ table[0][v & 255u];
        }
    }
}

uint32_t plfx_checksum(uint32_t crc, const uint8_t *bytes, size_t n)
{
    if (table[0][1] == 0) {
        fill();
    }
    crc = ~crc;
    for (; n >= 8; n -= 8, bytes += 8) {
        uint32_t a = crc ^ plfx_load_u32(bytes);
        uint32_t b = plfx_load_u32(bytes + 4);
        crc = table[7][a & 255u] ^ table[6][a >> 8 & 255u] ^ table[5][a >> 16 & 255u] ^
              table[4][a >> 24] ^ table[3][b & 255u] ^ table[2][b >> 8 & 255u] ^
              table[1][b >> 16 & 255u] ^ table[0][b >> 24];
    }
    for (; n > 0; n--, bytes++) {
        crc = crc >> 8 ^ table[0][(crc ^ *bytes) & 255u];
    }
    return ~crc;
}
