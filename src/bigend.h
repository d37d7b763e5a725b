/* SPDX-License-Identifier: MIT
 * Big-endian numbers in byte buffers of any alignment (packets). */
#ifndef PLENOFIX_SRC_BIGEND_H
#define PLENOFIX_SRC_BIGEND_H

#include <stdint.h>

static inline uint32_t plfx_be_u16(const uint8_t *p)
{
    return (uint32_t)p[0] << 8 | (uint32_t)p[1];
}

static inline uint32_t plfx_be_u32(const uint8_t *p)
{
    return plfx_be_u16(p) << 16 | plfx_be_u16(p + 2);
}

/* Two's complement without an implementation-defined conversion. */
static inline int32_t plfx_be_i16(const uint8_t *p)
{
    return (int32_t)(plfx_be_u16(p) ^ 0x8000u) - 0x8000;
}

static inline int32_t plfx_be_i32(const uint8_t *p)
{
    uint32_t v = plfx_be_u32(p);

    return v < 0x80000000u ? (int32_t)v : -(int32_t)(0xffffffffu - v) - 1;
}

static inline void plfx_be_put16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)(v >> 8 & 255u);
    p[1] = (uint8_t)(v & 255u);
}

static inline void plfx_be_put32(uint8_t *p, uint32_t v)
{
    plfx_be_put16(p, v >> 16);
    plfx_be_put16(p + 2, v & 0xffffu);
}

#endif
