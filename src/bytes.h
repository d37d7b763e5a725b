/* SPDX-License-Identifier: MIT
 * Little-endian numbers in byte buffers of any alignment. */
#ifndef PLENOFIX_SRC_BYTES_H
#define PLENOFIX_SRC_BYTES_H

#include <stdint.h>

static inline uint32_t plfx_get_u16(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8;
}

static inline uint32_t plfx_get_u32(const uint8_t *p)
{
    return plfx_get_u16(p) | plfx_get_u16(p + 2) << 16;
}

/* Two's complement without an implementation-defined conversion. */
static inline int32_t plfx_get_i16(const uint8_t *p)
{
    return (int32_t)(plfx_get_u16(p) ^ 0x8000u) - 0x8000;
}

static inline int32_t plfx_get_i32(const uint8_t *p)
{
    uint32_t v = plfx_get_u32(p);

    return v < 0x80000000u ? (int32_t)v : -(int32_t)(0xffffffffu - v) - 1;
}

static inline void plfx_put_u16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)(v & 255u);
    p[1] = (uint8_t)(v >> 8 & 255u);
}

static inline void plfx_put_u32(uint8_t *p, uint32_t v)
{
    plfx_put_u16(p, v & 0xffffu);
    plfx_put_u16(p + 2, v >> 16);
}

#endif
