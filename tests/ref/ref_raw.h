/* SPDX-License-Identifier: MIT
 * A raw frame bit by bit: where each bit of each pixel stands in the file, from the
 * drawings of src/FORMAT.md.  No groups, no shifts of words. */
#ifndef PLENOFIX_TESTS_REF_RAW_H
#define PLENOFIX_TESTS_REF_RAW_H

#include "plenofix/raw.h"

/* Position in the frame (8*byte + bit, bit 0 least significant) of bit k of pixel q. */
static size_t ref_raw_place(int32_t format, size_t q, uint32_t k)
{
    size_t pair = q / 2u * 3u;
    size_t four = q / 4u * 5u;
    size_t odd = q % 2u;

    switch (format) {
    case PLFX_RAW_U8:
        return q * 8u + k;
    case PLFX_RAW_U16LE:
        return q * 16u + k;
    case PLFX_RAW_MONO10P:
        return q * 10u + k;
    case PLFX_RAW_MONO12P:
        return q * 12u + k;
    case PLFX_RAW_MONO10PACKED:
        return k < 2u ? (pair + 1u) * 8u + odd * 4u + k
                      : (pair + odd * 2u) * 8u + (k - 2u);
    case PLFX_RAW_MONO12PACKED:
        return k < 4u ? (pair + 1u) * 8u + odd * 4u + k
                      : (pair + odd * 2u) * 8u + (k - 4u);
    case PLFX_RAW_CSI10:
        return k < 2u ? (four + 4u) * 8u + q % 4u * 2u + k
                      : (four + q % 4u) * 8u + (k - 2u);
    default: /* CSI12 */
        return k < 4u ? (pair + 2u) * 8u + odd * 4u + k : (pair + odd) * 8u + (k - 4u);
    }
}

/* Significant bits that the format itself holds. */
static uint32_t ref_raw_depth(int32_t format)
{
    return format == PLFX_RAW_U8                                    ? 8u
           : format == PLFX_RAW_U16LE || format == PLFX_RAW_U16     ? 16u
           : format == PLFX_RAW_MONO10P || format == PLFX_RAW_CSI10 ? 10u
           : format == PLFX_RAW_MONO10PACKED                        ? 10u
                                                                    : 12u;
}

static uint16_t ref_raw_get(const uint8_t *b, int32_t format, size_t q)
{
    uint32_t v = 0;
    uint32_t k;

    for (k = 0; k < ref_raw_depth(format); k++) {
        size_t at = ref_raw_place(format, q, k);
        v |= (uint32_t)(b[at / 8u] >> at % 8u & 1u) << k;
    }
    return (uint16_t)v;
}

#endif
