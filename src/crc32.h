/* SPDX-License-Identifier: MIT
 * CRC-32 (IEEE 802.3, reflected, polynomial 0xEDB88320), by nibbles: 64 bytes of
 * table. */
#ifndef PLENOFIX_SRC_CRC32_H
#define PLENOFIX_SRC_CRC32_H

#include <stddef.h>
#include <stdint.h>

/* CRC of n bytes continued from `crc` (0 to start). */
uint32_t plfx_crc32(uint32_t crc, const uint8_t *bytes, size_t n);

#endif
