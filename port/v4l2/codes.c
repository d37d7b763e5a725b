/* SPDX-License-Identifier: MIT
 * Pixel formats by their four letters. */
#include "v4l2.h"

#define CODE(a, b, c, d)                                                               \
    ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)

typedef struct entry {
    uint32_t code;
    uint8_t format, bits, bayer;
} entry;

#define U8   PLFX_RAW_U8
#define U16  PLFX_RAW_U16LE
#define C10  PLFX_RAW_CSI10
#define C12  PLFX_RAW_CSI12
#define GREY PLFX_BAYER_NONE
#define RGGB PLFX_BAYER_RGGB
#define GRBG PLFX_BAYER_GRBG
#define GBRG PLFX_BAYER_GBRG
#define BGGR PLFX_BAYER_BGGR

/* clang-format off */
static const entry known[] = {
    {CODE('G', 'R', 'E', 'Y'), U8, 8, GREY},
    {CODE('R', 'G', 'G', 'B'), U8, 8, RGGB},
    {CODE('G', 'R', 'B', 'G'), U8, 8, GRBG},
    {CODE('G', 'B', 'R', 'G'), U8, 8, GBRG},
    {CODE('B', 'A', '8', '1'), U8, 8, BGGR},
    {CODE('Y', '1', '0', ' '), U16, 10, GREY},
    {CODE('Y', '1', '2', ' '), U16, 12, GREY},
    {CODE('Y', '1', '4', ' '), U16, 14, GREY},
    {CODE('Y', '1', '6', ' '), U16, 16, GREY},
    {CODE('R', 'G', '1', '0'), U16, 10, RGGB},
    {CODE('B', 'A', '1', '0'), U16, 10, GRBG},
    {CODE('G', 'B', '1', '0'), U16, 10, GBRG},
    {CODE('B', 'G', '1', '0'), U16, 10, BGGR},
    {CODE('R', 'G', '1', '2'), U16, 12, RGGB},
    {CODE('B', 'A', '1', '2'), U16, 12, GRBG},
    {CODE('G', 'B', '1', '2'), U16, 12, GBRG},
    {CODE('B', 'G', '1', '2'), U16, 12, BGGR},
    {CODE('R', 'G', '1', '6'), U16, 16, RGGB},
    {CODE('G', 'R', '1', '6'), U16, 16, GRBG},
    {CODE('G', 'B', '1', '6'), U16, 16, GBRG},
    {CODE('B', 'Y', 'R', '2'), U16, 16, BGGR},
    {CODE('Y', '1', '0', 'P'), C10, 10, GREY},
    {CODE('p', 'R', 'A', 'A'), C10, 10, RGGB},
    {CODE('p', 'g', 'A', 'A'), C10, 10, GRBG},
    {CODE('p', 'G', 'A', 'A'), C10, 10, GBRG},
    {CODE('p', 'B', 'A', 'A'), C10, 10, BGGR},
    {CODE('Y', '1', '2', 'P'), C12, 12, GREY},
    {CODE('p', 'R', 'C', 'C'), C12, 12, RGGB},
    {CODE('p', 'g', 'C', 'C'), C12, 12, GRBG},
    {CODE('p', 'G', 'C', 'C'), C12, 12, GBRG},
    {CODE('p', 'B', 'C', 'C'), C12, 12, BGGR},
};
/* clang-format on */

#define KNOWN (sizeof known / sizeof known[0])

uint32_t plfx_v4l2_code(uint8_t format, uint8_t bits, uint8_t bayer)
{
    size_t k;

    for (k = 0; k < KNOWN; k++) {
        if (known[k].format == format && known[k].bits == bits &&
            known[k].bayer == bayer) {
            return known[k].code;
        }
    }
    return 0;
}

int plfx_v4l2_find(uint32_t code, uint8_t *format, uint8_t *bits, uint8_t *bayer)
{
    size_t k;

    for (k = 0; k < KNOWN; k++) {
        if (known[k].code == code) {
            *format = known[k].format;
            *bits = known[k].bits;
            *bayer = known[k].bayer;
            return 0;
        }
    }
    return -1;
}
