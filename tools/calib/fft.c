/* SPDX-License-Identifier: MIT
 * Radix-2 transform; columns are done in groups of 8 to stay in the cache. */
#include "calib/fft.h"

#include <math.h>
#include <stdlib.h>

#define GROUP 8

/* One butterfly between `count` samples at p and at q with the factor (c,s). */
static void butterfly(float *p, float *q, int count, float c, float s)
{
    int k;

    for (k = 0; k < count; k++) {
        float re = q[2 * k] * c - q[2 * k + 1] * s;
        float im = q[2 * k] * s + q[2 * k + 1] * c;
        q[2 * k] = p[2 * k] - re;
        q[2 * k + 1] = p[2 * k + 1] - im;
        p[2 * k] += re;
        p[2 * k + 1] += im;
    }
}

/* Bit reversal of n rows of `count` samples. */
static void reverse(float *z, int n, int count)
{
    int i, j = 0, k;

    for (i = 1; i < n; i++) {
        int bit = n >> 1;
        while (j & bit) {
            j ^= bit;
            bit >>= 1;
        }
        j |= bit;
        for (k = 0; i < j && k < 2 * count; k++) {
            float swap = z[2 * i * count + k];
            z[2 * i * count + k] = z[2 * j * count + k];
            z[2 * j * count + k] = swap;
        }
    }
}

/* Transform along the first index of z[n][count]. */
static void transform(float *z, int n, int count, const float *w, int sign)
{
    int half, i, k;

    reverse(z, n, count);
    for (half = 1; half < n; half *= 2) {
        for (k = 0; k < half; k++) {
            const float c = w[2 * (k * (n / (2 * half)))];
            const float s = (float)sign * w[2 * (k * (n / (2 * half))) + 1];
            for (i = k; i < n; i += 2 * half) {
                butterfly(z + 2 * i * count, z + 2 * (i + half) * count, count, c, s);
            }
        }
    }
}

static void columns(float *z, int n, float *work, const float *w, int sign)
{
    int x, y, k;

    for (x = 0; x < n; x += GROUP) {
        const int count = n < GROUP ? n : GROUP;
        for (y = 0; y < n; y++) {
            for (k = 0; k < 2 * count; k++) {
                work[2 * y * count + k] = z[2 * ((long)y * n + x) + k];
            }
        }
        transform(work, n, count, w, sign);
        for (y = 0; y < n; y++) {
            for (k = 0; k < 2 * count; k++) {
                z[2 * ((long)y * n + x) + k] = work[2 * y * count + k];
            }
        }
    }
}

static void transpose(float *z, int n)
{
    int x, y, k;

    for (y = 0; y < n; y++) {
        for (x = 0; x < y; x++) {
            for (k = 0; k < 2; k++) {
                float swap = z[2 * ((long)y * n + x) + k];
                z[2 * ((long)y * n + x) + k] = z[2 * ((long)x * n + y) + k];
                z[2 * ((long)x * n + y) + k] = swap;
            }
        }
    }
}

int plft_fft_square(float *z, int n, int sign)
{
    float *w = calloc((size_t)n, sizeof *w);
    float *work = malloc((size_t)n * GROUP * 2u * sizeof *work);
    int k;

    if (w == NULL || work == NULL) {
        free(w);
        free(work);
        return -1;
    }
    for (k = 0; k < n / 2; k++) {
        double angle = 6.28318530717958647693 * k / n;
        w[2 * k] = (float)cos(angle);
        w[2 * k + 1] = (float)sin(angle);
    }
    columns(z, n, work, w, sign);
    transpose(z, n);
    columns(z, n, work, w, sign);
    transpose(z, n);
    free(w);
    free(work);
    return 0;
}
