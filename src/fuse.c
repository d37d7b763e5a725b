/* SPDX-License-Identifier: MIT */
#include "plenofix/fuse.h"
#include "fix.h"

static int32_t counts(int32_t slope_q16, uint16_t w_u16)
{
    return slope_q16 != PLFX_SLOPE_NONE && w_u16 > 0;
}

int32_t plfx_fuse_mean(const int32_t *slope_q16, const uint16_t *w_u16, int32_t n)
{
    int64_t sum = 0; /* 128 * 2^31 * 2^16 < 2^54 */
    int64_t weight = 0;
    int32_t k;

    for (k = 0; k < n; k++) {
        if (counts(slope_q16[k], w_u16[k])) {
            sum += (int64_t)slope_q16[k] * w_u16[k];
            weight += w_u16[k];
        }
    }
    return weight > 0 ? (int32_t)plfx_div_round_i64(sum, weight) : PLFX_SLOPE_NONE;
}

/* Weight of entries up to and including `slope`. */
static int64_t weight_up_to(const int32_t *slope_q16, const uint16_t *w_u16, int32_t n,
                            int32_t slope)
{
    int64_t sum = 0;
    int32_t k;

    for (k = 0; k < n; k++) {
        if (counts(slope_q16[k], w_u16[k]) && slope_q16[k] <= slope) {
            sum += w_u16[k];
        }
    }
    return sum;
}

/* Smallest counting slope over `above`; INT32_MAX when there is none. */
static int32_t next_slope(const int32_t *slope_q16, const uint16_t *w_u16, int32_t n,
                          int32_t above)
{
    int32_t best = INT32_MAX;
    int32_t k;

    for (k = 0; k < n; k++) {
        if (counts(slope_q16[k], w_u16[k]) && slope_q16[k] > above) {
            best = plfx_min_i32(best, slope_q16[k]);
        }
    }
    return best;
}

int32_t plfx_fuse_median(const int32_t *slope_q16, const uint16_t *w_u16, int32_t n)
{
    int64_t total = weight_up_to(slope_q16, w_u16, n, INT32_MAX);
    int32_t median = PLFX_SLOPE_NONE;
    int64_t below = 0;
    int32_t k;

    if (total == 0) {
        return PLFX_SLOPE_NONE;
    }
    for (k = 0; k < n && 2 * below < total; k++) {
        median = next_slope(slope_q16, w_u16, n, median);
        below = weight_up_to(slope_q16, w_u16, n, median);
    }
    if (2 * below == total) {
        int64_t next = next_slope(slope_q16, w_u16, n, median);
        median = (int32_t)plfx_asr_i64(median + next + 1, 1);
    }
    return median;
}
