/* SPDX-License-Identifier: MIT
 * Planted: a kernel that narrows without saying so. */
__kernel void planted(__global short *out, int v)
{
    out[0] = v;
}
