/* SPDX-License-Identifier: MIT
 * Clocks of a POSIX system. */
#ifndef PLENOFIX_PORT_CLOCK_H
#define PLENOFIX_PORT_CLOCK_H

#include "plenofix/port.h"

/* CLOCK_MONOTONIC, which nobody sets back. */
plfx_clock plfx_posix_monotonic(void);

#endif
