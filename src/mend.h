/* SPDX-License-Identifier: MIT
 * What stands where a lens has no light. */
#ifndef PLENOFIX_SRC_MEND_H
#define PLENOFIX_SRC_MEND_H

#include "plenofix/lut.h"

/* Row j of a view: samples of lenses flagged MISSING become the rounded mean of the
 * nearest measured ones to their left and right (of the one there is; 0 in a row
 * without any). A hole of zeros would be the strongest texture around, at slope 0. */
void plfx_mend_row(const plfx_lut *lut, int32_t j, uint16_t *row);

#endif
