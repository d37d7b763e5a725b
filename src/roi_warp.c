/* SPDX-License-Identifier: MIT
 * The rest state displaced by a fraction of a lens. */
#include "roi_state.h"
#include "fix.h"

/* Six taps at -2 .. 3 that interpolate at k/32: least squares up to 1/3 of a cycle a
 * lens (speckle of three lenses), sum 2^14. */
static const int16_t taps_q14[33][6] = {
    {0, 0, 16384, 0, 0, 0},
    {77, -355, 16272, 527, -192, 55},
    {150, -683, 16117, 1078, -387, 109},
    {220, -983, 15914, 1651, -581, 163},
    {284, -1257, 15672, 2244, -775, 216},
    {344, -1502, 15385, 2855, -966, 268},
    {399, -1719, 15057, 3482, -1153, 318},
    {448, -1909, 14691, 4121, -1333, 366},
    {492, -2071, 14288, 4771, -1507, 411},
    {530, -2206, 13851, 5428, -1671, 452},
    {562, -2314, 13380, 6090, -1825, 491},
    {588, -2395, 12879, 6753, -1966, 525},
    {607, -2451, 12350, 7416, -2093, 555},
    {621, -2483, 11796, 8076, -2206, 580},
    {629, -2490, 11217, 8728, -2301, 601},
    {630, -2474, 10619, 9372, -2379, 616},
    {626, -2437, 10003, 10003, -2437, 626},
    {616, -2379, 9372, 10619, -2474, 630},
    {601, -2301, 8728, 11217, -2490, 629},
    {580, -2206, 8076, 11796, -2483, 621},
    {555, -2093, 7416, 12350, -2451, 607},
    {525, -1966, 6753, 12879, -2395, 588},
    {491, -1825, 6090, 13380, -2314, 562},
    {452, -1671, 5428, 13851, -2206, 530},
    {411, -1507, 4771, 14288, -2071, 492},
    {366, -1333, 4121, 14691, -1909, 448},
    {318, -1153, 3482, 15057, -1719, 399},
    {268, -966, 2855, 15385, -1502, 344},
    {216, -775, 2244, 15672, -1257, 284},
    {163, -581, 1651, 15914, -983, 220},
    {109, -387, 1078, 16117, -683, 150},
    {55, -192, 527, 16272, -355, 77},
    {0, 0, 0, 16384, 0, 0},
};

/* Taps at a fraction, 0 .. 65535 q16, between the two nearest of the table. */
static void taps(int32_t f_q16, int32_t t[6])
{
    int32_t at = f_q16 >> 11;
    int32_t f = f_q16 & 2047;
    int32_t k;

    for (k = 0; k < 6; k++) {
        t[k] = ((int32_t)taps_q14[at][k] * (2048 - f) +
                (int32_t)taps_q14[at + 1][k] * f + 1024) /
               2048;
    }
}

void plfx_roi_warp(const plfx_roi_patch *p, int32_t k, int32_t y, int32_t dx_q16,
                   int32_t dy_q16, uint16_t *out)
{
    int32_t w = p->w + 2 * PLFX_ROI_MARGIN;
    int32_t h = p->h + 2 * PLFX_ROI_MARGIN;
    int32_t cx = plfx_asr_i32(-dx_q16, 16); /* -1 or 0 */
    int32_t cy = plfx_asr_i32(-dy_q16, 16);
    int32_t tx[6];
    int32_t ty[6];
    int32_t x;
    int32_t a;
    int32_t b;

    taps(-dx_q16 - 65536 * cx, tx);
    taps(-dy_q16 - 65536 * cy, ty);
    for (x = 0; x < p->w; x++) {
        int64_t sum = 0; /* < 2^16 * 2^15 * 2^15 */
        for (b = 0; b < 6; b++) {
            int32_t r = y + PLFX_ROI_MARGIN + cy + b - 2;
            const uint16_t *row = p->wide + (size_t)(k * h + r) * (size_t)w +
                                  (x + PLFX_ROI_MARGIN + cx - 2);
            int64_t line = 0;
            for (a = 0; a < 6; a++) {
                line += (int64_t)row[a] * tx[a];
            }
            sum += line * ty[b];
        }
        sum = plfx_round_shift_i64(sum, 28);
        out[x] = (uint16_t)plfx_clamp_i32((int32_t)sum, 0, 65534);
    }
}
