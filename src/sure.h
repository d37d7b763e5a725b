/* SPDX-License-Identifier: MIT
 * Takes the status of a call whose arguments were checked before: it cannot fail. */
#ifndef PLENOFIX_SRC_SURE_H
#define PLENOFIX_SRC_SURE_H

#include "plenofix/base.h"

static inline void plfx_sure(plfx_status status)
{
    (void)status;
}

#endif
