/* SPDX-License-Identifier: MIT
 * Broken on purpose: nothing; base.h includes it. */
#include <stdint.h>
