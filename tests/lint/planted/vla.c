/* SPDX-License-Identifier: MIT
 * Broken on purpose: an array of variable length. */
int plfx_planted(int n);

int plfx_planted(int n)
{
    volatile int a[n];
    a[n - 1] = n;
    return a[n - 1];
}
