/* SPDX-License-Identifier: MIT
 * A decision of which a report (mcdc.json) shows one condition. */
int plfx_planted(int a, int b);
int plfx_planted(int a, int b)
{
    return a && b;
}
