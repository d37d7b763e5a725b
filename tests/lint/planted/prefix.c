/* SPDX-License-Identifier: MIT
 * Broken on purpose: a global without a prefix and writable data. */
static int count;

int planted_counter(void)
{
    return ++count;
}
