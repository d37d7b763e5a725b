/* SPDX-License-Identifier: MIT
 * CRC-32 bit by bit: no table; a store is checked a few times in its life. */
#include "crc.h"

uint32_t plfx_port_crc32(uint32_t crc, const uint8_t *bytes, size_t n)
{
    size_t i;
    int k;

    crc = ~crc;
    for (i = 0; i < n; i++) {
        crc ^= bytes[i];
        for (k = 0; k < 8; k++) {
            crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}
