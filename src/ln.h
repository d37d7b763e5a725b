/* SPDX-License-Identifier: MIT
 * Logarithm and angle in integers. */
#ifndef PLENOFIX_SRC_LN_H
#define PLENOFIX_SRC_LN_H

#include <stdint.h>

/* log2(v) q20, cut; v > 0.  Error under 2^-19. */
int32_t plfx_log2_q20(uint64_t v);

/* Angle of (x, y), 2^32 a turn, error under 2^-27 turn; 0 for (0,0).
 * |x|, |y| < 2^30. */
uint32_t plfx_angle_u32(int32_t x, int32_t y);

#endif
