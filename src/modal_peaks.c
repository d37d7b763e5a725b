/* SPDX-License-Identifier: MIT
 * Peaks of a power spectrum. */
#include "plenofix/modal.h"
#include "fix.h"
#include "ln.h"

/* Of bin k with a neighbour on both sides. */
static int32_t is_peak(const uint32_t *p, int32_t k)
{
    return p[k] > 0 && p[k] >= p[k - 1] && p[k] > p[k + 1];
}

/* Free of the peaks found so far. */
static int32_t is_apart(const plfx_peak *peaks, int32_t count, int32_t k, int32_t apart)
{
    int32_t i;

    for (i = 0; i < count; i++) {
        int32_t d = 256 * k - peaks[i].bin_q8;
        if (plfx_max_i32(d, -d) < 256 * apart) {
            return 0;
        }
    }
    return 1;
}

/* Vertex of the parabola through the logarithms of bins k-1, k, k+1. */
static int32_t vertex_q8(const uint32_t *p, int32_t k)
{
    int64_t a = plfx_log2_q20(p[k - 1] ? p[k - 1] : 1u);
    int64_t b = plfx_log2_q20(p[k]);
    int64_t c = plfx_log2_q20(p[k + 1] ? p[k + 1] : 1u);
    int64_t bend = 2 * b - a - c; /* >= 0 */

    return 256 * k + (bend > 0 ? (int32_t)plfx_div_round_i64((c - a) * 128, bend) : 0);
}

static uint64_t mean(const uint32_t *p, int32_t n)
{
    uint64_t sum = 0;
    int32_t k;

    for (k = 1; k < n; k++) {
        sum += p[k];
    }
    return sum / (uint64_t)(n - 1);
}

plfx_status plfx_modal_peaks(const uint32_t *power, int32_t n, int32_t apart,
                             int32_t floor_q4, plfx_peak *peaks, int32_t max,
                             int32_t *count)
{
    uint64_t least;
    int32_t found = 0;
    int32_t round;

    if (!power || !peaks || !count || n < 3 || n > 1 << 20 || apart < 1 ||
        apart > 1 << 20 || floor_q4 < 0 || max < 1 || max > 1 << 10) {
        return PLFX_E_ARG;
    }
    least = mean(power, n) * (uint64_t)floor_q4 / 16u;
    for (round = 0; round < max; round++) {
        int32_t best = 0;
        int32_t k;
        for (k = 1; k < n - 1; k++) {
            if (is_peak(power, k) && power[k] >= least &&
                (best == 0 || power[k] > power[best]) &&
                is_apart(peaks, found, k, apart)) {
                best = k;
            }
        }
        if (best == 0) {
            break;
        }
        peaks[found].bin_q8 = vertex_q8(power, best);
        peaks[found].power = power[best];
        found++;
    }
    *count = found;
    return PLFX_OK;
}
