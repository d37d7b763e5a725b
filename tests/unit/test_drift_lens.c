/* SPDX-License-Identifier: MIT
 * One lens against the mean lens: kernels from sums made by hand, the ratio behind all
 * of drift.h. */
#include "suite.h"

#include "drift_state.h"

#define HALF 8
#define N    (2 * HALF + 1)
#define R    6 /* radius of the disc */

static uint16_t px[N * N];
static uint32_t sum[N * N];
static int16_t kx[N * N], ky[N * N], even[N * N], span[N];
static plfx_drift_window w;

/* A disc of radius R in a window of HALF. */
static void window(int32_t folded)
{
    int32_t y;

    memset(&w, 0, sizeof w);
    w.half = HALF;
    w.n = N;
    w.span = span;
    w.px = px;
    w.sum = sum;
    w.kx = kx;
    w.ky = ky;
    w.even = even;
    w.folded = folded;
    for (y = -HALF; y <= HALF; y++) {
        int32_t x = -1;
        while ((x + 1) * (x + 1) + y * y <= R * R) {
            x++;
        }
        span[y + HALF] = (int16_t)x;
        w.cells += x < 0 ? 0 : 2 * x + 1;
    }
}

/* A bowl, displaced by (dx, dy) sixteenths: top - height*r^2/50. */
static int32_t bowl(int32_t x, int32_t y, int32_t dx, int32_t dy, int32_t top,
                    int32_t height)
{
    int32_t r = (16 * x - dx) * (16 * x - dx) + (16 * y - dy) * (16 * y - dy);

    return top - height * (r / 16) / 800;
}

static void mean_of(int32_t top, int32_t height, int32_t folded)
{
    int32_t k;

    window(folded);
    for (k = 0; k < N * N; k++) {
        sum[k] = (uint32_t)folded *
                 (uint32_t)bowl(k % N - HALF, k / N - HALF, 0, 0, top, height);
    }
}

/* Displacement that the kernels read from a bowl at (dx, dy) sixteenths. */
static plfx_drift_lens reading(int32_t dx, int32_t dy, int32_t top, int32_t height)
{
    int32_t k;

    for (k = 0; k < N * N; k++) {
        px[k] = (uint16_t)bowl(k % N - HALF, k / N - HALF, dx, dy, top, height);
    }
    return plfx_drift_match(&w);
}

/* Contrast of any size, sums of few or many lenses: the same displacement. */
static void scale_does_not_matter(void **s)
{
    static const int32_t of[5][2] = {
        {300, 16}, {3000, 1}, {3000, 16}, {20000, 17}, {20000, 4096}};
    int32_t k;

    (void)s;
    for (k = 0; k < 5; k++) {
        int32_t height = of[k][0];
        plfx_drift_lens d;
        mean_of(40000, height, of[k][1]);
        assert_int_equal(plfx_drift_kernels(&w), 1);
        d = reading(8, -4, 40000, height);
        assert_int_equal(d.ok, 1);
        assert_in_range(d.dx_q20, 500000, 548576); /* half a pixel, 5 % */
        assert_in_range(-d.dy_q20, 245000, 279288);
    }
}

static void flat_means_have_no_kernels(void **s)
{
    int32_t k;

    (void)s;
    window(16);
    for (k = 0; k < N * N; k++) {
        sum[k] = 16 * 30000;
    }
    assert_int_equal(plfx_drift_kernels(&w), 0);
    for (k = 0; k < N * N; k++) { /* along y alone */
        sum[k] = 16u * (uint32_t)(30000 - 200 * (k / N - HALF) * (k / N - HALF));
    }
    assert_int_equal(plfx_drift_kernels(&w), 0);
}

/* Flat inside the disc, bright around it: differences across its rim are the
 * neighbours', not the lens's own. */
static void neighbours_are_no_structure(void **s)
{
    int32_t k;

    (void)s;
    window(16);
    for (k = 0; k < N * N; k++) {
        int32_t x = k % N - HALF;
        int32_t y = k / N - HALF;
        sum[k] = x * x + y * y <= R * R ? 16 * 20000 : 16 * 50000;
    }
    assert_int_equal(plfx_drift_kernels(&w), 0);
}

static void ratios_cut_the_divisor_and_saturate(void **s)
{
    (void)s;
    assert_int_equal(plfx_drift_ratio(0, 5, 20), 0);
    assert_int_equal(plfx_drift_ratio(3, 2, 4), 24);
    assert_int_equal(plfx_drift_ratio(-7, 2, 0), -3); /* rounded down in magnitude */
    assert_true(plfx_drift_ratio((int64_t)1 << 61, (int64_t)1 << 40, 20) == (int64_t)1
                                                                                << 41);
    assert_true(plfx_drift_ratio((int64_t)1 << 61, 1, 20) == (int64_t)1 << 62);
    assert_true(plfx_drift_ratio(-((int64_t)1 << 61), 1, 20) == -((int64_t)1 << 62));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(scale_does_not_matter),
    cmocka_unit_test(flat_means_have_no_kernels),
    cmocka_unit_test(neighbours_are_no_structure),
    cmocka_unit_test(ratios_cut_the_divisor_and_saturate),
};

SUITE(tests)
