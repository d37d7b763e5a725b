/* SPDX-License-Identifier: MIT
 * Broken on purpose: calls through a pointer. */
int plfx_planted(int (*call)(int), int v)
{
    return call(v) + 1;
}
