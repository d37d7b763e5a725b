/* SPDX-License-Identifier: MIT
 * Planted: a kernel that computes in floating point. */
__kernel void planted(__global int *out)
{
    float scaled = 0.5f * (float)out[0];

    out[0] = (int)scaled;
}
