/* SPDX-License-Identifier: MIT
 * Broken on purpose: a system header that the core may not use. */
#include "plenofix/image.h"
#include <stdlib.h>
