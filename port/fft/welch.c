/* SPDX-License-Identifier: MIT
 * Welch's average of windowed spectra. */
#include <math.h>
#include <string.h>

#include "fft/fft.h"

/* A half-overlapping stretch less its mean, under Hann's window, in 31 bits. */
static void load(plfx_fft *fft, const int16_t *x)
{
    size_t n = (size_t)1 << fft->log2;
    int64_t sum = 0;
    size_t k;

    for (k = 0; k < n; k++) {
        sum += x[k];
    }
    for (k = 0; k < n; k++) {
        double hann =
            0.5 - 0.5 * cos(6.283185307179586 * ((double)k + 0.5) / (double)n);
        int32_t w = (int32_t)floor(16384.0 * hann + 0.5);
        int64_t v = ((int64_t)x[k] * (int64_t)n - sum) / (int64_t)n; /* 17 bits */
        fft->in[2u * k] = (int32_t)(v * w);                          /* under 2^31 */
        fft->in[2u * k + 1u] = 0;
    }
}

static uint64_t bin_power(const int32_t *v)
{
    int64_t re = v[0];
    int64_t im = v[1];

    return (uint64_t)(re * re) / 2u + (uint64_t)(im * im) / 2u;
}

/* Powers of one stretch, < 2^48, of which 2^16 stay in 64 bits. */
static void add(plfx_fft *fft)
{
    size_t bins = ((size_t)1 << fft->log2) / 2u + 1u;
    size_t k;

    for (k = 0; k < bins; k++) {
        fft->sum[k] += bin_power(fft->out + 2u * k) >> 14;
    }
}

plfx_status plfx_fft_welch(plfx_fft *fft, const int16_t *x, int32_t count,
                           uint32_t *power, int32_t *scale_log2)
{
    uint64_t *sum = fft ? fft->sum : NULL;
    int32_t n = fft ? 1 << fft->log2 : 0;
    int32_t bins = n / 2 + 1;
    uint64_t most = 0;
    int32_t shift = 0;
    int32_t at;
    int32_t k;

    if (!fft || !x || !power || !scale_log2 || count < n || count / n > 1 << 14) {
        return PLFX_E_ARG;
    }
    memset(sum, 0, (size_t)bins * sizeof *sum);
    for (at = 0; at + n <= count; at += n / 2) {
        load(fft, x + at);
        plfx_fft_run(fft);
        add(fft);
    }
    for (k = 0; k < bins; k++) {
        most = sum[k] > most ? sum[k] : most;
    }
    while (most >> shift >= (uint64_t)1 << 31) { /* at most 33 */
        shift++;
    }
    while (most > 0 && shift <= 0 && most << -shift < (uint64_t)1 << 30) { /* 30 */
        shift--;
    }
    for (k = 0; k < bins; k++) {
        power[k] = (uint32_t)(shift >= 0 ? sum[k] >> shift : sum[k] << -shift);
    }
    *scale_log2 = shift + 14;
    return PLFX_OK;
}
