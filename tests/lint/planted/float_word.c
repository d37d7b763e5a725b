/* SPDX-License-Identifier: MIT
 * Broken on purpose: names a floating-point type. */
int plfx_planted(int v)
{
    float f = 1.0f;
    return f > 0.5f ? v : -v;
}
