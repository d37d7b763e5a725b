/* SPDX-License-Identifier: MIT
 * Broken on purpose: a port looks into the core. */
#include "../src/inner.h"
