/* SPDX-License-Identifier: MIT
 * Pixel formats by their number in the GenICam Pixel Format Naming Convention. */
#ifndef PLENOFIX_PORT_PFNC_H
#define PLENOFIX_PORT_PFNC_H

#include "plenofix/raw.h"

typedef struct plfx_pfnc {
    uint32_t code;
    uint8_t format, bits, bayer; /* plfx_raw_format, significant bits, plfx_bayer */
} plfx_pfnc;

/* Entry of a number, or NULL: a format that the core cannot unpack. */
const plfx_pfnc *plfx_pfnc_find(uint32_t code);

/* Number of a format; 0 if it has none. */
uint32_t plfx_pfnc_code(uint8_t format, uint8_t bits, uint8_t bayer);

#endif
