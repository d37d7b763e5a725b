/* SPDX-License-Identifier: MIT
 * What both directions of the packets share. */
#ifndef PLENOFIX_SRC_PACKET_FORMAT_H
#define PLENOFIX_SRC_PACKET_FORMAT_H

#include <stddef.h>
#include <stdint.h>

/* CRC-16 of CCSDS: polynomial 0x1021, start 0xffff, not reflected. */
uint32_t plfx_crc16(const uint8_t *bytes, size_t n);

#endif
