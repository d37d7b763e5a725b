/* SPDX-License-Identifier: MIT */
#include "suite.h"
#include "ref.h"

#define NONE PLFX_SLOPE_NONE

static void means(void **state)
{
    int32_t s[4] = {10, NONE, -30, 5};
    uint16_t w[4] = {1, 65535, 1, 0};

    (void)state;
    assert_int_equal(plfx_fuse_mean(s, w, 4), -10);
    assert_int_equal(plfx_fuse_mean(s, w, 1), 10);
    assert_int_equal(plfx_fuse_mean(s + 1, w + 1, 1), NONE);
    assert_int_equal(plfx_fuse_mean(s + 3, w + 3, 1), NONE);
    assert_int_equal(plfx_fuse_mean(s, w, 0), NONE);
}

static void medians(void **state)
{
    int32_t s[5] = {10, NONE, -30, 5, 5};
    uint16_t w[5] = {1, 9, 1, 1, 1};
    uint16_t heavy[5] = {9, 9, 1, 1, 1};

    (void)state;
    assert_int_equal(plfx_fuse_median(s, w, 5), 5);
    assert_int_equal(plfx_fuse_median(s, w, 3), -10); /* halves meet: mean of both */
    assert_int_equal(plfx_fuse_median(s, heavy, 5), 10);
    assert_int_equal(plfx_fuse_median(s + 1, w, 1), NONE);
    assert_int_equal(plfx_fuse_median(s, w, 0), NONE);
}

/* Against a count over all split points. */
static void random_medians(void **state)
{
    ref_rng rng = {11};

    (void)state;
    for (int t = 0; t < 3000; t++) {
        int32_t s[9];
        uint16_t w[9];
        int32_t n = ref_range(&rng, 1, 9);
        int64_t total = 0;
        int64_t low = 0;
        int32_t m;
        for (int32_t i = 0; i < n; i++) {
            s[i] = ref_range(&rng, -5, 5) * 2;
            w[i] = (uint16_t)ref_range(&rng, 0, 3);
            total += w[i];
        }
        m = plfx_fuse_median(s, w, n);
        if (total == 0) {
            assert_int_equal(m, NONE);
            continue;
        }
        for (int32_t i = 0; i < n; i++) {
            low += s[i] <= m ? w[i] : 0;
        }
        assert_true(2 * low >= total);
        for (int32_t i = 0, below = 0; i < n; i++) {
            below += s[i] < m ? w[i] : 0;
            assert_true(2 * below <= total);
        }
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(means),
    cmocka_unit_test(medians),
    cmocka_unit_test(random_medians),
};

SUITE(tests)
