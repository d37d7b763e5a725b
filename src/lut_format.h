/* SPDX-License-Identifier: MIT
 * Byte offsets of the lens table; src/FORMAT.md explains them. */
#ifndef PLENOFIX_SRC_LUT_FORMAT_H
#define PLENOFIX_SRC_LUT_FORMAT_H

#include "plenofix/lut.h"

/* Lattice within its documented ranges: steps at least a pixel, not parallel. */
int32_t plfx_lattice_ok(const plfx_lattice *l);

#define LUT_MAJOR       1u
#define LUT_MINOR       0u
#define LUT_AT_VERSION  4
#define LUT_AT_SIZE     8
#define LUT_AT_HEADER   12
#define LUT_AT_CAMERA   16
#define LUT_AT_SENSOR   20
#define LUT_AT_BITS     24
#define LUT_AT_KIND     25
#define LUT_AT_SECTIONS 26
#define LUT_AT_LENSES   28
#define LUT_AT_ORIGIN   32
#define LUT_AT_STEPS    40
#define LUT_AT_RADIUS   64
#define LUT_AT_CRC      68
#define LUT_HEADER      72u
#define LUT_ENTRY       16u /* tag, offset, length, CRC-32 */
#define LUT_SECTIONS    64u /* at most, unknown ones included */
#define LUT_GAIN_HEAD   8u  /* zones x, y, profile radius, 0 */

#endif
