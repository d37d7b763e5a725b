/* SPDX-License-Identifier: MIT
 * Broken on purpose: the lowest floor looks up. */
#include "plenofix/image.h"
