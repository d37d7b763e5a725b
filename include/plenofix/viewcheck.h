/* SPDX-License-Identifier: MIT
 * Views judged before they are matched: their noise, and which of them are dark,
 * clipped or out of line with the rest. */
#ifndef PLENOFIX_VIEWCHECK_H
#define PLENOFIX_VIEWCHECK_H

#include "plenofix/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Findings about one view. */
#define PLFX_VIEW_DARK 1u /* mean under a quarter of the median view's */
#define PLFX_VIEW_CLIPPED                                                              \
    2u                     /* over a quarter of its samples at full scale, and twice the
                              median view's share */
#define PLFX_VIEW_ALIEN 4u /* mean apart from the median view's by over half of it */

/* Judge every view by every fourth sample of every fourth row; found[k] = PLFX_VIEW_*,
 * 0 when a view is like the rest.  bits: of a sample.  Returns the number of views
 * with a finding, or PLFX_E_ARG (n under 3 or over 2048, NULL).  work: 2n numbers. */
int32_t plfx_views_check(const plfx_views *views, int32_t bits, uint8_t *found,
                         uint32_t *work);

#define PLFX_VIEWS_ALL (-1)

/* Standard deviation of the noise of view k, grey levels of an 8-bit scale in
 * sixteenths: blocks of 8x8, sum of |[1 -2 1; -2 4 -2; 1 -2 1]| (Immerkaer 1996: noise
 * = sqrt(pi/2)/6 of its mean), the smoothest twentieth of the blocks.  One view reads
 * up to a quarter low, as the smoothest blocks are those where noise happens to be
 * weak.  PLFX_VIEWS_ALL: the same place in up to eight views, spread over all, is one
 * block, which leaves 5 % of that.  Fine texture everywhere reads as noise, noise that
 * neighbouring samples share reads low.  0 when a view is smaller than 16x16. */
int32_t plfx_views_noise_q4(const plfx_views *views, int32_t bits, int32_t k);

#ifdef __cplusplus
}
#endif
#endif
