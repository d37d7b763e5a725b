/* SPDX-License-Identifier: MIT
 * Broken on purpose: a low header of the core; a port includes it. */
#include <stdint.h>
