/* SPDX-License-Identifier: MIT
 * The least that a user of the library writes: include, call, compare versions. */
#include <stdio.h>

#include <plenofix/plenofix.h>

int main(void)
{
    printf("plenofix %s\n", PLFX_VERSION_STRING);
    return plfx_version() == PLFX_VERSION ? 0 : 1;
}
