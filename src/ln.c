/* SPDX-License-Identifier: MIT */
#include "ln.h"
#include "fix.h"

int32_t plfx_log2_q20(uint64_t v)
{
    int32_t log = 63 << 20;
    uint64_t m = v;
    int32_t i;

    for (i = 0; i < 63 && m < (uint64_t)1 << 63; i++) {
        m <<= 1;
        log -= 1 << 20;
    }
    m >>= 32;                   /* 1 .. 2, q31 */
    for (i = 19; i >= 0; i--) { /* a squaring a bit of the fraction */
        m = m * m >> 31;
        if (m >= (uint64_t)1 << 32) {
            m >>= 1;
            log += (int32_t)1 << i;
        }
    }
    return log;
}

/* atan(2^-i), 2^32 a turn. */
static const uint32_t turns[28] = {
    536870912u, 316933406u, 167458907u, 85004756u, 42667331u, 21354465u, 10679838u,
    5340245u,   2670163u,   1335087u,   667544u,   333772u,   166886u,   83443u,
    41722u,     20861u,     10430u,     5215u,     2608u,     1304u,     652u,
    326u,       163u,       81u,        41u,       20u,       10u,       5u};

uint32_t plfx_angle_u32(int32_t x, int32_t y)
{
    uint32_t angle = 0;
    int64_t a = (int64_t)x * (1 << 24); /* < 2^54, grows by 1.65 */
    int64_t b = (int64_t)y * (1 << 24);
    int32_t i;

    if (a < 0) { /* half a turn brings it to the right half plane */
        a = -a;
        b = -b;
        angle = 0x80000000u;
    }
    for (i = 0; i < 28; i++) {
        int64_t da = plfx_asr_i64(b, i);
        int64_t db = plfx_asr_i64(a, i);
        if (b > 0) {
            a += da;
            b -= db;
            angle += turns[i];
        } else if (b < 0) {
            a -= da;
            b += db;
            angle -= turns[i];
        } else {
            break;
        }
    }
    return angle;
}
