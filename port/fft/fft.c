/* SPDX-License-Identifier: MIT
 * The transform: kissfft, or radix-2 with decimation in time. */
#include "fft/fft.h"

#include <math.h>

#ifdef PLFX_KISSFFT
#include "kiss_fft.h"
#endif

/* Factors of a turn. */
static int32_t prepare(plfx_fft *fft)
{
    size_t n = (size_t)1 << fft->log2;
#ifdef PLFX_KISSFFT
    size_t bytes = (n + 64u) * sizeof(uint64_t); /* n factors and under 300 bytes */

    return kiss_fft_alloc((int)n, 0, fft->factor, &bytes) != NULL;
#else
    size_t k;

    for (k = 0; k < n / 2u; k++) {
        double a = -6.283185307179586 * (double)k / (double)n;
        fft->factor[2u * k] = (int32_t)floor(2147483647.0 * cos(a) + 0.5);
        fft->factor[2u * k + 1u] = (int32_t)floor(2147483647.0 * sin(a) + 0.5);
    }
    return 1;
#endif
}

plfx_status plfx_fft_init(plfx_fft *fft, int32_t log2, uint64_t *ws, size_t words)
{
    size_t n = (size_t)1 << (log2 & 31);

    if (!fft || !ws || log2 < PLFX_FFT_LOG2_MIN || log2 > PLFX_FFT_LOG2_MAX) {
        return PLFX_E_ARG;
    }
    if (words < PLFX_FFT_WORDS(log2)) {
        return PLFX_E_SIZE;
    }
    fft->log2 = log2;
    fft->sum = ws; /* n/2 + 1 */
    fft->in = (int32_t *)(void *)(ws + n / 2u + 1u);
    fft->out = fft->in + 2u * n;
    fft->factor = fft->out + 2u * n;
    return prepare(fft) ? PLFX_OK : PLFX_E_SIZE;
}

#ifdef PLFX_KISSFFT

const char *plfx_fft_name(void)
{
    return "kissfft";
}

void plfx_fft_run(plfx_fft *fft)
{
    kiss_fft((kiss_fft_cfg)(void *)fft->factor,
             (const kiss_fft_cpx *)(const void *)fft->in,
             (kiss_fft_cpx *)(void *)fft->out);
}

#else

const char *plfx_fft_name(void)
{
    return "radix-2";
}

/* Values in bit-reversed order. */
static void reorder(const int32_t *in, int32_t *out, int32_t log2)
{
    uint32_t n = (uint32_t)1 << log2;
    uint32_t k;

    for (k = 0; k < n; k++) {
        uint32_t r = 0;
        int32_t b;
        for (b = 0; b < log2; b++) {
            r |= (k >> b & 1u) << (log2 - 1 - b);
        }
        out[2u * r] = in[2u * k];
        out[2u * r + 1u] = in[2u * k + 1u];
    }
}

static int32_t half(int64_t v)
{
    return (int32_t)((v + 1) / 2);
}

/* a, b to (a + w*b)/2, (a - w*b)/2. */
static void butterfly(int32_t *a, int32_t *b, const int32_t *w)
{
    int64_t re = ((int64_t)b[0] * w[0] - (int64_t)b[1] * w[1]) / 2147483648LL;
    int64_t im = ((int64_t)b[0] * w[1] + (int64_t)b[1] * w[0]) / 2147483648LL;

    b[0] = half(a[0] - re);
    b[1] = half(a[1] - im);
    a[0] = half(a[0] + re);
    a[1] = half(a[1] + im);
}

void plfx_fft_run(plfx_fft *fft)
{
    size_t n = (size_t)1 << fft->log2;
    int32_t *v = fft->out;
    size_t span;

    reorder(fft->in, v, fft->log2);
    for (span = 1; span < n; span *= 2u) {
        size_t at;
        for (at = 0; at < n; at += 2u * span) {
            size_t k;
            for (k = 0; k < span; k++) {
                butterfly(v + 2u * (at + k), v + 2u * (at + k + span),
                          fft->factor + 2u * (k * (n / 2u / span)));
            }
        }
    }
}

#endif
