/* SPDX-License-Identifier: MIT */
#include "plenofix/version.h"

int plfx_version(void)
{
    return PLFX_VERSION;
}
