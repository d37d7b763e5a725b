/* SPDX-License-Identifier: MIT
 * Broken on purpose: has no floor. */
#include <stdint.h>
