/* SPDX-License-Identifier: MIT
 * Rounding and saturation: every value of small domains, and the ends of large ones. */
#include "suite.h"
#include "ref.h"

#include "fix.h"

#define SEED 0xf1cu

/* floor(v / 2^s) without a shift of a negative number. */
static int64_t ref_floor(int64_t v, int32_t s)
{
    uint64_t one = (uint64_t)1 << s;

    return v >= 0 ? (int64_t)((uint64_t)v / one)
                  : -(int64_t)(((uint64_t)-v + one - 1u) / one);
}

static void shifts_floor(void **state)
{
    ref_rng rng = {SEED};
    int32_t v;
    int32_t s;

    (void)state;
    for (v = -70000; v <= 70000; v += 1) {
        for (s = 0; s <= 18; s++) {
            assert_int_equal(plfx_asr_i32(v, s), (int32_t)ref_floor(v, s));
        }
    }
    for (s = 0; s <= 31; s++) {
        assert_int_equal(plfx_asr_i32(INT32_MIN, s), (int32_t)ref_floor(INT32_MIN, s));
        assert_int_equal(plfx_asr_i32(INT32_MAX, s), (int32_t)ref_floor(INT32_MAX, s));
    }
    for (v = 0; v < 4000; v++) {
        int64_t x = (int64_t)((uint64_t)ref_next(&rng) << 32 ^ ref_next(&rng));
        s = v % 63;
        x = x == INT64_MIN ? 0 : x;
        assert_true(plfx_asr_i64(x, s) == ref_floor(x, s));
        x /= 4;
        s = v % 61 + 1;
        assert_true(plfx_round_shift_i64(x, s) ==
                    ref_floor(x + ((int64_t)1 << (s - 1)), s));
    }
}

static void division_rounds_half_away(void **state)
{
    int64_t n;
    int64_t d;

    (void)state;
    for (d = 1; d <= 40; d++) {
        for (n = -400; n <= 400; n++) {
            int64_t a = n < 0 ? -n : n;
            int64_t q = a / d + (2 * (a % d) >= d);
            assert_true(plfx_div_round_i64(n, d) == (n < 0 ? -q : q));
        }
    }
    assert_true(plfx_div_round_i64(((int64_t)1 << 62) - 1, 1) ==
                ((int64_t)1 << 62) - 1);
}

static void roots_are_floors(void **state)
{
    uint64_t v;
    uint32_t root = 0;

    (void)state;
    for (v = 0; v < 300000; v++) {
        root += (uint64_t)(root + 1u) * (root + 1u) <= v;
        assert_int_equal(plfx_isqrt_u64(v), root);
    }
    for (root = 65536; root != 0; root += 65521u * 7u) {
        v = (uint64_t)root * root;
        assert_int_equal(plfx_isqrt_u64(v), root);
        assert_int_equal(plfx_isqrt_u64(v - 1u), root - 1u);
        assert_int_equal(plfx_isqrt_u64(v + 2u * (uint64_t)root), root);
        if (root > 0xffffffffu - 65521u * 7u) {
            break;
        }
    }
    assert_int_equal(plfx_isqrt_u64(UINT64_MAX), 0xffffffffu);
}

static void logarithms_name_the_top_bit(void **state)
{
    int32_t n;

    (void)state;
    for (n = 0; n < 64; n++) {
        uint64_t v = (uint64_t)1 << n;
        assert_int_equal(plfx_log2_u64(v), n);
        assert_int_equal(plfx_log2_u64(v | (v - 1u)), n);
    }
}

static void values_saturate(void **state)
{
    (void)state;
    assert_int_equal(plfx_sat_i32((int64_t)INT32_MAX + 1), INT32_MAX);
    assert_int_equal(plfx_sat_i32(INT32_MAX), INT32_MAX);
    assert_int_equal(plfx_sat_i32((int64_t)INT32_MIN - 1), INT32_MIN);
    assert_int_equal(plfx_sat_i32(INT32_MIN), INT32_MIN);
    assert_int_equal(plfx_sat_i32(-5), -5);
    assert_int_equal(plfx_clamp_i32(5, -1, 4), 4);
    assert_int_equal(plfx_clamp_i32(-5, -1, 4), -1);
    assert_int_equal(plfx_clamp_i32(3, -1, 4), 3);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(shifts_floor),     cmocka_unit_test(division_rounds_half_away),
    cmocka_unit_test(roots_are_floors), cmocka_unit_test(logarithms_name_the_top_bit),
    cmocka_unit_test(values_saturate),
};

SUITE(tests)
