/* SPDX-License-Identifier: MIT
 * Every stage of the core on made input, small enough for a bare Cortex-M. */
#include "golden.h"

#include "fix.h"
#include "plenofix/plenofix.h"

static int64_t random_i64(uint32_t *seed, int32_t bits)
{
    uint64_t high = golden_random(seed);
    uint64_t v = (high << 32) | golden_random(seed);
    int64_t magnitude = (int64_t)(v >> (64 - bits));

    return (golden_random(seed) & 0x80000000u) != 0u ? -magnitude : magnitude;
}

static void add_i64(golden_crc *c, int64_t v)
{
    golden_add(c, (uint32_t)((uint64_t)v & 0xffffffffu), 4);
    golden_add(c, (uint32_t)((uint64_t)v >> 32), 4);
}

/* Rounding, saturation, root. */
static uint32_t run_fix(void)
{
    uint32_t seed = 1;
    golden_crc c;
    int32_t i;

    golden_begin(&c);
    for (i = 0; i < 500; i++) {
        int64_t n = random_i64(&seed, 1 + i % 60);
        int64_t d = random_i64(&seed, 1 + i % 31);
        add_i64(&c, plfx_round_shift_i64(n, 1 + i % 40));
        add_i64(&c, plfx_div_round_i64(n, d < 0 ? 1 - d : 1 + d));
        golden_add(&c, (uint32_t)plfx_sat_i32(n), 4);
        golden_add(&c, plfx_isqrt_u64((uint64_t)n), 4);
    }
    return golden_end(&c);
}

const golden_stage golden_stages[] = {
    {"fix", run_fix, 0x29ac5e74u},
};

const size_t golden_count = sizeof golden_stages / sizeof golden_stages[0];
