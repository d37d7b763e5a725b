/* SPDX-License-Identifier: MIT
 * Broken on purpose: no braces. */
int plfx_planted(int v);

int plfx_planted(int v)
{
    if (v > 2)
        return 1;
    return 0;
}
