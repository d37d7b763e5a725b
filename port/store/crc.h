/* SPDX-License-Identifier: MIT
 * CRC-32 of the formats of this library, for the port layer (src/FORMAT.md). */
#ifndef PLENOFIX_PORT_STORE_CRC_H
#define PLENOFIX_PORT_STORE_CRC_H

#include <stddef.h>
#include <stdint.h>

/* CRC of n bytes continued from `crc` (0 to start). */
uint32_t plfx_port_crc32(uint32_t crc, const uint8_t *bytes, size_t n);

#endif
