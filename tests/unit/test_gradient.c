/* SPDX-License-Identifier: MIT */
#include "suite.h"
#include "ref.h"
#include "gradient_scalar.h"
#include "rows.h"

#include <math.h>

#define NX 40
#define NY 24
static uint16_t samples[NX * NY * 5];
static int32_t slope[NX * NY];
static uint16_t conf[NX * NY], sigma[NX * NY];
static uint8_t flags[NX * NY];
static unsigned char memory[NX * 48 + 16 * 128 + 64 + 16 * NX * 2];

static unsigned char *workspace(void)
{
    return aligned(memory);
}

static plfx_map map(void)
{
    plfx_map m = {slope, conf, sigma, flags, NX, NY, NX};

    return m;
}

static plfx_plan plan_of(int step_q8)
{
    plfx_cfg c;
    plfx_plan p;

    memset(&c, 0, sizeof c);
    c.method = PLFX_METHOD_GRADIENT;
    c.window = 7;
    c.bits = 12;
    c.n = 5;
    c.labels = 3;
    c.slope_max_q16 = 65536;
    c.at[1].u_q8 = (int16_t)-step_q8;
    c.at[2].u_q8 = (int16_t)step_q8;
    c.at[3].v_q8 = (int16_t)-step_q8;
    c.at[4].v_q8 = (int16_t)step_q8;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, NY), PLFX_OK);
    return p;
}

static double texture(double x, double y)
{
    return 2000 + 500 * sin(0.7 * x + 0.3 * y) + 400 * sin(0.5 * y - 0.4 * x + 1);
}

/* Views of a plane of slope d at offsets of `step` sensor pixels, column scale and
 * odd-row displacement of the lattice. */
static void render(const plfx_plan *p, double d, double step, double odd)
{
    static const int du[5] = {0, -1, 1, 0, 0};
    static const int dv[5] = {0, 0, 0, -1, 1};
    double row = 65536.0 / p->row_q16; /* row spacing in pitches */

    for (int j = 0; j < NY; j++) {
        for (int k = 0; k < 5; k++) {
            for (int i = 0; i < NX; i++) {
                double x = i + (j % 2 ? odd : 0) - d * step * du[k];
                double y = j * row - d * step * dv[k];
                samples[(j * 5 + k) * NX + i] = (uint16_t)(texture(x, y) + 0.5);
            }
        }
    }
}

static void expect(double d, double tolerance)
{
    for (int j = 4; j < NY - 4; j++) {
        for (int i = 4; i < NX - 4; i++) {
            double got = slope[j * NX + i] / 65536.0;
            if (fabs(got - d) > tolerance) {
                fail_msg("(%d,%d): %f, not %f", i, j, got, d);
            }
        }
    }
}

static void planes(void **state)
{
    static const double d[] = {-0.15, -0.05, 0, 0.08, 0.15};
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    for (size_t i = 0; i < 5; i++) {
        render(&p, d[i], 2, 0);
        assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                         PLFX_OK);
        expect(d[i], 0.004);
    }
    assert_int_equal(flags[0], PLFX_FLAG_EDGE);
    assert_int_equal(slope[3 * NX + 10], PLFX_SLOPE_NONE);
    assert_int_equal(flags[4 * NX + 4], 0);
    assert_int_equal(flags[4 * NX + NX - 4], PLFX_FLAG_EDGE);
    assert_int_equal(sigma[0], PLFX_SIGMA_NONE);
}

/* A ramp of one count a column and one of sixteen, displaced by a column for two
 * pixels: window sums within 31 bits and beyond. */
static void faint_and_steep_ramps_have_one_slope(void **state)
{
    static const int32_t du[5] = {0, -1, 1, 0, 0};
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    for (int32_t steep = 1; steep <= 16; steep += 15) {
        for (int32_t i = 0; i < NX * NY * 5; i++) {
            samples[i] = (uint16_t)(1000 + steep * (i % NX - du[i / NX % 5]));
        }
        assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                         PLFX_OK);
        expect(0.5, 0.01);
    }
}

static void hexagonal_plane(void **state)
{
    plfx_plan p = plan_of(256);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    p.hex = 1;
    p.odd_q4 = 8;
    p.row_q16 = 75674;
    render(&p, 0.1, 1, 0.5);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    expect(0.1, 0.01);
}

static void opposite_order_negates(void **state)
{
    plfx_plan p = plan_of(-512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    render(&p, 0.1, -2, 0);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    expect(0.1, 0.003);
}

static void flat_is_missing(void **state)
{
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    for (size_t i = 0; i < sizeof samples / sizeof samples[0]; i++) {
        samples[i] = 4095;
    }
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    assert_int_equal(slope[10 * NX + 10], PLFX_SLOPE_NONE);
    assert_int_equal(flags[10 * NX + 10], PLFX_FLAG_TEXTURE);
    assert_int_equal(conf[10 * NX + 10], 0);
}

/* Views without any relation: no overflow, slope within its limits. */
static void extremes(void **state)
{
    ref_rng rng = {9};
    plfx_plan p = plan_of(1);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    for (size_t i = 0; i < sizeof samples / sizeof samples[0]; i++) {
        samples[i] = (uint16_t)(ref_range(&rng, 0, 1) * 4095);
    }
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    for (int i = 0; i < NX * NY; i++) {
        assert_true(slope[i] == PLFX_SLOPE_NONE ||
                    (slope[i] >= -(8 << 16) && slope[i] <= 8 << 16));
    }
}

/* Sample of view k at column x of row y, as row j sees it. */
static int64_t seen(const plfx_plan *p, const plfx_views *v, int k, int x, int y, int j)
{
    plfx_ring ring = plfx_ring_of(v);
    plfx_shift shift = {0, 0, y - j, 0};
    uint16_t px;

    plfx_sample_row(p, &ring, k, shift, j, x, 1, &px);
    return px;
}

/* Weights of the matched pair at a step of -1, 0, 1. */
static const int64_t even[3] = {59, 138, 59};
static const int64_t odd[3] = {-109, 0, 109};

/* sum over the 3x3 lenses around (x,y) of along[dx] across[dy]. */
static int64_t stencil(const plfx_plan *p, const plfx_views *v, int k, int x, int y,
                       const int64_t *along, const int64_t *across)
{
    int64_t sum = 0;

    for (int dy = -1; dy <= 1; dy++) {
        for (int dx = -1; dx <= 1; dx++) {
            sum += along[dx + 1] * across[dy + 1] * seen(p, v, k, x + dx, y + dy, y);
        }
    }
    return sum;
}

static void add_products(const plfx_plan *p, const plfx_views *v, int x, int y,
                         plfx_products *to)
{
    static const int views_u[3] = {1, 0, 2};
    static const int views_v[3] = {3, 0, 4};
    int64_t ix = 0;
    int64_t iy = 0;
    int64_t iu = 0;
    int64_t iv = 0;

    for (int a = 0; a < 3; a++) {
        ix += even[a] * stencil(p, v, views_u[a], x, y, odd, even);
        iy += even[a] * stencil(p, v, views_v[a], x, y, even, odd);
        iu += odd[a] * stencil(p, v, views_u[a], x, y, even, even);
        iv += odd[a] * stencil(p, v, views_v[a], x, y, even, even);
    }
    ix = plfx_round_shift_i64(ix, 20);
    iy = plfx_round_shift_i64(iy, 20);
    iu = plfx_round_shift_i64(iu, 20);
    iv = plfx_round_shift_i64(iv, 20);
    to->xu += ix * iu;
    to->yv += iy * iv;
    to->xx += ix * ix;
    to->yy += iy * iy;
    to->xy += ix * iy;
}

/* The definition of gradient.h in double; products are q8. */
static double conf_ref(plfx_products s, int n, int bits)
{
    double xx = (double)s.xx / n / 256;
    double yy = (double)s.yy / n / 256;
    double xy = (double)s.xy / n / 256;
    double e = (xx + yy - sqrt((xx - yy) * (xx - yy) + 4 * xy * xy)) / 2;

    return 65535 * e / (e + pow(2, 2 * (bits - 6)));
}

/* Every lens whose window has its stencils inside, lens by lens. */
static void compare(const plfx_plan *p, const plfx_views *v, unsigned seed)
{
    int w = p->cfg.window;
    int r = w / 2;

    for (int y = r + 1; y < p->ny - 1 - r; y++) {
        for (int x = r + 1; x < p->nx - 1 - r; x++) {
            plfx_products sum = {0, 0, 0, 0, 0};
            int32_t want;
            for (int i = 0; i < w * w; i++) {
                add_products(p, v, x - r + i % w, y - r + i / w, &sum);
            }
            want = plfx_gradient_slope_q16(sum, p->col_q16, p->row_q16, p->du_q8[2]);
            if (slope[y * p->nx + x] != want) {
                fail_msg("seed %u (%d,%d): %d, not %d", seed, x, y,
                         (int)slope[y * p->nx + x], (int)want);
            }
            assert_int_equal(conf[y * p->nx + x],
                             want == PLFX_SLOPE_NONE
                                 ? 0u
                                 : plfx_gradient_conf_u16(sum, w * w, p->cfg.bits));
            if (want != PLFX_SLOPE_NONE) {
                double off = conf[y * p->nx + x] - conf_ref(sum, w * w, p->cfg.bits);
                assert_true(fabs(off) < 16); /* of 2^16: e is kept in 2^-3 */
            }
        }
    }
}

/* Related and unrelated views, full contrast, both lattices, any step. */
static void equals_definition(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 12; seed++) {
        ref_rng rng = {seed};
        plfx_plan p = plan_of(seed % 3 == 0 ? 256 : ref_range(&rng, -800, -100));
        plfx_views v = {samples, 14 + (int)seed % 3, 12, 5};
        plfx_map m = map();
        int32_t spread = seed % 4 == 0 ? 4095 : 30;

        p.nx = m.w = m.stride = v.nx;
        p.ny = m.h = v.ny;
        p.cfg.window = (uint8_t)(3 + 2 * (seed % 3));
        p.hex = (int32_t)seed % 2;
        p.odd_q4 = p.hex ? ref_range(&rng, -9, 9) : 0;
        p.row_q16 = p.hex ? 75674 : 65536;
        for (int i = 0; i < v.nx * v.ny * 5; i++) {
            samples[i] = (uint16_t)ref_range(&rng, 0, spread);
        }
        assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                         PLFX_OK);
        compare(&p, &v, seed);
    }
}

/* Roots of numbers of every size, about squares and elsewhere. */
static void roots(void **state)
{
    (void)state;
    ref_rng rng = {7};
    for (int i = 0; i < 400000; i++) {
        uint64_t r = (uint64_t)ref_range(&rng, 0, (1 << 26) - 1) >> (i % 26);
        uint64_t v = r * r + (uint64_t)(i % 3) - (r > 0 ? 1u : 0u);
        uint64_t any =
            (r << 26 | (uint64_t)ref_range(&rng, 0, (1 << 26) - 1)) >> (i % 27);
        assert_int_equal(plfx_gradient_root(v), plfx_isqrt_u64(v));
        assert_int_equal(plfx_gradient_root(any), plfx_isqrt_u64(any));
    }
}

/* Slopes are the same where no confidence is asked for. */
static void confidence_changes_no_slope(void **state)
{
    static int32_t alone[NX * NY];
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();
    plfx_map bare = {alone, NULL, NULL, NULL, NX, NY, NX};

    (void)state;
    render(&p, 0.1, 2, 0);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    assert_int_equal(plfx_gradient(&p, &v, &bare, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    assert_memory_equal(alone, slope, sizeof alone);
    p.cfg.unique_u16 = 65535;
    assert_int_equal(plfx_gradient(&p, &v, &bare, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    assert_int_equal(alone[10 * NX + 10], PLFX_SLOPE_NONE);
}

static void low_confidence_is_missing(void **state)
{
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();

    (void)state;
    p.cfg.unique_u16 = 65535;
    render(&p, 0.1, 2, 0);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), plfx_gradient_ws(&p)),
                     PLFX_OK);
    assert_int_equal(slope[10 * NX + 10], PLFX_SLOPE_NONE);
}

static void bad_arguments(void **state)
{
    plfx_plan p = plan_of(512);
    plfx_views v = {samples, NX, NY, 5};
    plfx_map m = map();
    size_t n = plfx_gradient_ws(&p);
    plfx_cfg c = p.cfg;

    (void)state;
    assert_true(n <= sizeof memory - 64);
    assert_int_equal(plfx_gradient(NULL, &v, &m, workspace(), n), PLFX_E_ARG);
    assert_int_equal(plfx_gradient(&p, NULL, &m, workspace(), n), PLFX_E_ARG);
    assert_int_equal(plfx_gradient(&p, &v, NULL, workspace(), n), PLFX_E_ARG);
    assert_int_equal(plfx_gradient(&p, &v, &m, NULL, n), PLFX_E_SIZE);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), n - 1), PLFX_E_SIZE);
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace() + 1, n), PLFX_E_SIZE);
    v.n = 4;
    assert_int_equal(plfx_gradient(&p, &v, &m, workspace(), n), PLFX_E_ARG);
    c.at[4].v_q8 = 100;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, NY), PLFX_E_ARG);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(planes),
    cmocka_unit_test(faint_and_steep_ramps_have_one_slope),
    cmocka_unit_test(hexagonal_plane),
    cmocka_unit_test(opposite_order_negates),
    cmocka_unit_test(flat_is_missing),
    cmocka_unit_test(extremes),
    cmocka_unit_test(equals_definition),
    cmocka_unit_test(roots),
    cmocka_unit_test(confidence_changes_no_slope),
    cmocka_unit_test(low_confidence_is_missing),
    cmocka_unit_test(bad_arguments),
};

SUITE(tests)
