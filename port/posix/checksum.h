/* SPDX-License-Identifier: MIT
 * CRC-32 of the formats of this library, fast: eight bytes a step, 8 KiB of table. */
#ifndef PLENOFIX_PORT_CHECKSUM_H
#define PLENOFIX_PORT_CHECKSUM_H

#include <stddef.h>
#include <stdint.h>

/* CRC of n bytes continued from `crc` (0 to start).  The first call fills the table:
 * make it before threads begin. */
uint32_t plfx_checksum(uint32_t crc, const uint8_t *bytes, size_t n);

#endif
