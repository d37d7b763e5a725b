/* SPDX-License-Identifier: MIT */
#include "pfnc.h"

#define U8   PLFX_RAW_U8
#define U16  PLFX_RAW_U16LE
#define P10  PLFX_RAW_MONO10P
#define P12  PLFX_RAW_MONO12P
#define K10  PLFX_RAW_MONO10PACKED
#define K12  PLFX_RAW_MONO12PACKED
#define GREY PLFX_BAYER_NONE
#define RGGB PLFX_BAYER_RGGB
#define GRBG PLFX_BAYER_GRBG
#define GBRG PLFX_BAYER_GBRG
#define BGGR PLFX_BAYER_BGGR

/* clang-format off */
static const plfx_pfnc known[] = {
    {0x01080001u, U8, 8, GREY},  {0x01080008u, U8, 8, GRBG},
    {0x01080009u, U8, 8, RGGB},  {0x0108000au, U8, 8, GBRG},
    {0x0108000bu, U8, 8, BGGR},
    {0x01100003u, U16, 10, GREY}, {0x01100005u, U16, 12, GREY},
    {0x01100025u, U16, 14, GREY}, {0x01100007u, U16, 16, GREY},
    {0x0110000cu, U16, 10, GRBG}, {0x0110000du, U16, 10, RGGB},
    {0x0110000eu, U16, 10, GBRG}, {0x0110000fu, U16, 10, BGGR},
    {0x01100010u, U16, 12, GRBG}, {0x01100011u, U16, 12, RGGB},
    {0x01100012u, U16, 12, GBRG}, {0x01100013u, U16, 12, BGGR},
    {0x0110002eu, U16, 16, GRBG}, {0x0110002fu, U16, 16, RGGB},
    {0x01100030u, U16, 16, GBRG}, {0x01100031u, U16, 16, BGGR},
    {0x010a0046u, P10, 10, GREY}, {0x010a0052u, P10, 10, BGGR},
    {0x010a0054u, P10, 10, GBRG}, {0x010a0056u, P10, 10, GRBG},
    {0x010a0058u, P10, 10, RGGB},
    {0x010c0047u, P12, 12, GREY}, {0x010c0053u, P12, 12, BGGR},
    {0x010c0055u, P12, 12, GBRG}, {0x010c0057u, P12, 12, GRBG},
    {0x010c0059u, P12, 12, RGGB},
    {0x010c0004u, K10, 10, GREY}, {0x010c0026u, K10, 10, GRBG},
    {0x010c0027u, K10, 10, RGGB}, {0x010c0028u, K10, 10, GBRG},
    {0x010c0029u, K10, 10, BGGR},
    {0x010c0006u, K12, 12, GREY}, {0x010c002au, K12, 12, GRBG},
    {0x010c002bu, K12, 12, RGGB}, {0x010c002cu, K12, 12, GBRG},
    {0x010c002du, K12, 12, BGGR},
};
/* clang-format on */

#define KNOWN (sizeof known / sizeof known[0])

const plfx_pfnc *plfx_pfnc_find(uint32_t code)
{
    size_t k;

    for (k = 0; k < KNOWN; k++) {
        if (known[k].code == code) {
            return &known[k];
        }
    }
    return NULL;
}

uint32_t plfx_pfnc_code(uint8_t format, uint8_t bits, uint8_t bayer)
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
