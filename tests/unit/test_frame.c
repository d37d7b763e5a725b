/* SPDX-License-Identifier: MIT */
#include "suite.h"
#include "plenofix/preset.h"
#include "ref_frame.h"

#define NX 40
#define NY 26
#define N  9 /* a cross of 9 views and no diagonal, or a 3x3 grid */

static uint32_t seed = 12345;

static uint32_t random_next(void)
{
    seed = seed * 1664525u + 1013904223u;
    return seed >> 8;
}

static uint16_t block[NY * N * NX];
static plfx_cfg cfg;
static plfx_frame_cfg fcfg;
static plfx_plan plan;
static plfx_views views = {block, NX, NY, N};
static int32_t slope[NX * NY];
static uint16_t conf[NX * NY], sigma[NX * NY];
static uint8_t flags[NX * NY];
static plfx_map map = {slope, conf, sigma, flags, NX, NY, NX};

/* A smooth texture: three waves, amplitudes in 10-bit counts. */
static double texture(double x, double y)
{
    return 500 + 150 * sin(0.9 * x + 0.4 * y) + 120 * sin(0.5 * y - 0.7 * x + 1) +
           80 * sin(1.3 * y + 0.2 * x + 2);
}

/* 3x3 grid of views of a plane of slope d: the image moves by d*(u,v). */
static void plane(double d)
{
    int x;
    int y;
    int k;

    for (y = 0; y < NY; y++) {
        for (k = 0; k < N; k++) {
            for (x = 0; x < NX; x++) {
                double v = texture(x - d * (k % 3 - 1), y - d * (k / 3 - 1));
                block[(y * N + k) * NX + x] = (uint16_t)floor(v + 0.5);
            }
        }
    }
}

static void noise(uint32_t mask)
{
    size_t i;

    for (i = 0; i < sizeof block / sizeof block[0]; i++) {
        block[i] = (uint16_t)(random_next() & mask);
    }
}

static void setup(int32_t preset, int32_t labels)
{
    int k;

    memset(&cfg, 0, sizeof cfg);
    assert_int_equal(plfx_preset(preset, &cfg, &fcfg), PLFX_OK);
    cfg.bits = 10;
    cfg.n = N;
    cfg.ref = 4;
    cfg.labels = (uint16_t)labels;
    cfg.slope_min_q16 = -2 * 65536;
    cfg.slope_max_q16 = 2 * 65536;
    for (k = 0; k < N; k++) {
        cfg.at[k].u_q8 = (int16_t)(256 * (k % 3 - 1));
        cfg.at[k].v_q8 = (int16_t)(256 * (k / 3 - 1));
    }
}

/* A state with its planes, for the stages; *raw is to be freed. */
static plfx_frame_state opened(void **raw)
{
    plfx_frame_state s;
    size_t bytes;

    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
    assert_int_equal(plfx_frame_derive(&s, &plan, &fcfg, NULL), PLFX_OK);
    bytes = plfx_frame_carve(&s, NULL);
    *raw = malloc(bytes + PLFX_ALIGN);
    assert_non_null(*raw);
    memset(*raw, 0xA5, bytes + PLFX_ALIGN);
    (void)plfx_frame_carve(&s, (unsigned char *)*raw +
                                   (PLFX_ALIGN - (uintptr_t)*raw % PLFX_ALIGN));
    plfx_frame_tables(&s, NULL);
    plfx_frame_load(&s, &views);
    return s;
}

static plfx_status run(const uint8_t *skip, int32_t shorter)
{
    size_t need = plfx_frame_ws(&plan, &fcfg);
    unsigned char *raw = malloc(need + 2 * PLFX_ALIGN);
    unsigned char *ws = raw + (PLFX_ALIGN - (uintptr_t)raw % PLFX_ALIGN);
    plfx_status status;

    assert_non_null(raw);
    memset(ws, 0x5A, need + PLFX_ALIGN / 2);
    status = plfx_frame(&plan, &fcfg, &views, skip, &map, ws, need - (size_t)shorter);
    assert_int_equal(ws[need], 0x5A); /* nothing beyond what was asked for */
    free(raw);
    return status;
}

static void compare_volume(void)
{
    void *raw;
    plfx_frame_state s = opened(&raw);
    int l;
    int x;
    int y;

    plfx_arms_volume(&s);
    for (l = 0; l < s.labels; l += 2) {
        for (y = 0; y < NY; y += 5) {
            for (x = 0; x < NX; x += 3) {
                int got = s.volume[(y * s.labels + l) * NX + x];
                assert_int_equal(got, ref_volume(&s, l, x, y));
            }
        }
    }
    free(raw);
}

static void volume_is_the_formula(void **state)
{
    (void)state;
    printf("# seed %u\n", seed);
    setup(PLFX_PRESET_ONBOARD, 7);
    noise(1023);
    compare_volume();
    plane(0.8);
    compare_volume();
    setup(PLFX_PRESET_STREAM, 6);
    cfg.window = 3;
    noise(63);
    compare_volume();
    setup(PLFX_PRESET_ONBOARD, 5);
    fcfg.shrink = 0;
    fcfg.keep = 4;
    fcfg.trunc_q4 = 1024;
    fcfg.gtrunc_q4 = 1024;
    cfg.window = 7;
    cfg.bits = 12;
    noise(4095);
    compare_volume();
}

static void paths_are_the_formula(void **state)
{
    static const int dir[8][2] = {{1, 0},  {-1, 0}, {0, 1},  {1, 1},
                                  {-1, 1}, {0, -1}, {1, -1}, {-1, -1}};
    static int path[NX * NY * 7];
    static int sum[NX * NY * 7];
    void *raw;
    plfx_frame_state s;
    int d;
    int i;

    (void)state;
    setup(PLFX_PRESET_ONBOARD, 7);
    noise(1023);
    s = opened(&raw);
    for (i = 0; i < NX * NY * 7; i++) {
        s.volume[i] = (uint8_t)random_next();
    }
    plfx_sgm(&s);
    memset(sum, 0, sizeof sum);
    for (d = 0; d < 8; d++) {
        ref_path(&s, dir[d][0], dir[d][1], path);
        for (i = 0; i < NX * NY * 7; i++) {
            sum[i] += path[i];
        }
    }
    for (i = 0; i < NX * NY * 7; i++) {
        int x = i / 7 % NX;
        int y = i / 7 / NX;
        assert_int_equal(s.sum[(y * 7 + i % 7) * NX + x], sum[i]);
    }
    free(raw);
}

static void median_is_the_least_half(void **state)
{
    static int32_t in[NX * NY];
    static int32_t out[NX * NY];
    void *raw;
    plfx_frame_state s;
    int round;
    int x;
    int y;

    (void)state;
    setup(PLFX_PRESET_ONBOARD, 7);
    noise(255);
    s = opened(&raw);
    for (round = 0; round < 3; round++) {
        for (x = 0; x < NX * NY; x++) { /* within 15 bits: no value is rounded */
            in[x] = (int32_t)(random_next() % (round == 0 ? 5u : 30000u)) - 9000;
        }
        plfx_median(&s, 3 + 2 * round, in, out);
        for (y = 0; y < NY; y++) {
            for (x = 0; x < NX; x++) {
                assert_int_equal(out[y * NX + x],
                                 ref_median(&s, 3 + 2 * round, in, x, y));
            }
        }
    }
    free(raw);
}

/* Standard error of the step by frame.h's first two terms, columns: no noise, whole
 * window, all neighbours within the gate. */
static double ref_error(const plfx_frame_state *s, const int32_t *in, int x, int y,
                        double step, double a, double lambda)
{
    double t[9][9] = {{0}};
    double bias = 1 - pow((3 * 5 - 8. / 3) / 25, 2);
    double mean = lambda * pow(s->cfg.prior_q12 / 4096., 2);
    double sum = 0;
    double pull = 29. / 16 * lambda * s->cfg.prior_q12 / 4096.;
    double kept = 156 / 256.;
    int i;
    int k;

    for (i = 0; i < 25; i++) {
        int at = (y + i / 5 - 2) * NX + x + i % 5 - 2;
        ref_sums q = ref_pixel(s, in[at] / 65536., at % NX, at / NX);
        t[i / 5 + 2][i % 5 + 2] =
            q.a * ((in[at] - in[y * NX + x]) / 65536. - step) - q.b;
    }
    for (i = 0; i < 49; i++) {
        double b = 0;
        for (k = 0; k < 9; k++) {
            b += t[i / 7 + k / 3][i % 7 + k % 3];
        }
        sum += b * b / 9 / bias;
    }
    sum = sum < a * mean ? a * mean : sum;
    return hypot(sqrt(kept * kept * sum + pull * pull) / (a + lambda), step / 4);
}

/* One step in fixed point against double: the step is small against its error. */
static void compare_step(int taps, double tolerance)
{
    static int32_t in[NX * NY];
    static int32_t out[NX * NY];
    void *raw;
    plfx_frame_state s;
    int x;
    int y;

    setup(PLFX_PRESET_ONBOARD, 7);
    fcfg.taps = (uint8_t)taps;
    fcfg.prior_q12 = 400;
    plane(0.63);
    s = opened(&raw);
    for (x = 0; x < NX * NY; x++) {
        in[x] = (int32_t)(0.63 * 65536) + (int32_t)(random_next() % 4000u) - 2000;
        s.flags[x] = 0;
    }
    plfx_refine(&s, in, out, 1);
    for (y = 6; y < NY - 6; y += 3) {
        for (x = 6; x < NX - 6; x += 2) {
            double a = 0;
            double b = 0;
            double r = 0;
            double n = 0;
            double prior = fcfg.prior_q12 / 4096.;
            double mean;
            int i;
            for (i = 0; i < 25; i++) {
                int at = (y + i / 5 - 2) * NX + x + i % 5 - 2;
                ref_sums t = ref_pixel(&s, in[at] / 65536., at % NX, at / NX);
                a += t.a;
                b += t.a * (in[at] - in[y * NX + x]) / 65536. - t.b;
                r += t.r;
                n += t.n;
            }
            mean = r / n < 819 / 256. ? 819 / 256. : r / n;
            b /= a + mean / (prior * prior);
            assert_true(fabs((out[y * NX + x] - in[y * NX + x]) / 65536. - b) <
                        tolerance);
            if (taps == 6) {
                double error =
                    ref_error(&s, in, x, y, b, a, mean / (prior * prior)) * 65536;
                assert_true(fabs(s.base[y * NX + x] - error) < 2 + 0.03 * error);
                assert_true(fabs(s.misfit[y * NX + x] / 256. - mean) <
                            0.1 + 0.02 * mean);
                error = 156 / 256. * sqrt(n * a / s.arms / 2) /
                        (a + mean / (prior * prior));
                assert_true(fabs(s.lever[y * NX + x] / 1048576. - error) <
                            0.02 * error);
            }
        }
    }
    free(raw);
}

static void refinement_is_near_double(void **state)
{
    (void)state;
    compare_step(4, 4e-3); /* positions of 1/64: up to 1/128 a view */
    compare_step(6, 2e-4);
}

static void planes_are_found(void **state)
{
    int x;
    int y;
    int p;

    (void)state;
    for (p = 0; p < PLFX_PRESETS; p++) {
        setup(p, 11);
        plane(0.63);
        assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
        assert_int_equal(run(NULL, 0), PLFX_OK);
        for (y = 8; y < NY - 8; y++) {
            for (x = 8; x < NX - 8; x++) {
                double limit = p == 0 ? 0.12 : p == 1 ? 0.06 : 0.004;
                assert_true(fabs(slope[y * NX + x] / 65536. - 0.63) < limit);
                assert_int_equal(flags[y * NX + x] & PLFX_FLAG_EDGE, 0);
            }
        }
        assert_int_equal(flags[0] & PLFX_FLAG_EDGE, PLFX_FLAG_EDGE);
    }
}

static void a_skipped_view_changes_nothing(void **state)
{
    static int32_t before[NX * NY];
    uint8_t skip[N] = {0};
    int x;
    int y;

    (void)state;
    setup(PLFX_PRESET_ONBOARD, 11);
    plane(0.63);
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
    skip[2] = 1;
    assert_int_equal(run(skip, 0), PLFX_OK);
    memcpy(before, slope, sizeof slope);
    for (y = 0; y < NY; y++) {
        for (x = 0; x < NX; x++) {
            block[(y * N + 2) * NX + x] = 0;
        }
    }
    assert_int_equal(run(skip, 0), PLFX_OK);
    assert_memory_equal(before, slope, sizeof slope);
    assert_int_equal(run(NULL, 0), PLFX_OK);
    assert_memory_not_equal(before, slope, sizeof slope);
}

static void flags_tell_apart(void **state)
{
    int x;
    int y;
    int k;

    (void)state;
    setup(PLFX_PRESET_ONBOARD, 11);
    cfg.slope_max_q16 = 32768; /* the scene, 0.63, lies beyond the range */
    cfg.labels = 8;
    plane(0.63);
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
    assert_int_equal(run(NULL, 0), PLFX_OK);
    k = 0;
    for (x = 0; x < NX * NY; x++) {
        k += (flags[x] & PLFX_FLAG_RANGE_END) != 0;
    }
    assert_true(k > NX * NY / 2);
    setup(PLFX_PRESET_ONBOARD, 11);
    plane(0);
    for (y = 0; y < NY; y++) {
        for (k = 0; k < N; k++) {
            for (x = 0; x < NX; x++) {
                uint16_t *v = block + (y * N + k) * NX + x;
                *v = x < 12 ? 300 : x > 27 ? 1023 : *v;
            }
        }
    }
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
    assert_int_equal(run(NULL, 0), PLFX_OK);
    assert_int_equal(flags[13 * NX + 5] & PLFX_FLAG_TEXTURE, PLFX_FLAG_TEXTURE);
    assert_int_equal(flags[13 * NX + 20] & PLFX_FLAG_TEXTURE, 0);
    assert_int_equal(flags[13 * NX + 32] & PLFX_FLAG_SATURATED, PLFX_FLAG_SATURATED);
    assert_int_equal(flags[13 * NX + 20] & PLFX_FLAG_SATURATED, 0);
}

/* A near strip of slope 1 before a plane of slope 0: flagged beside it, where some
 * views see the strip instead, and nowhere far from it. */
static void occlusion_is_flagged(void **state)
{
    int near = 0;
    int far = 0;
    int x;
    int y;
    int k;

    (void)state;
    setup(PLFX_PRESET_ONBOARD, 11);
    plane(0);
    for (y = 0; y < NY; y++) {
        for (k = 0; k < N; k++) {
            for (x = 0; x < NX; x++) {
                int at = x - cfg.at[k].u_q8 / 256; /* on the strip */
                if (at >= 17 && at < 23) {
                    block[(y * N + k) * NX + x] =
                        (uint16_t)(500 + 60 * (at * 7 % 5) + 90 * ((y + at) % 3));
                }
            }
        }
    }
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
    assert_int_equal(run(NULL, 0), PLFX_OK);
    for (y = 8; y < NY - 8; y++) {
        for (x = 4; x < NX - 4; x++) {
            int flagged = (flags[y * NX + x] & PLFX_FLAG_OCCLUDED) != 0;
            near += flagged && x >= 13 && x < 27;
            far += flagged && (x < 11 || x >= 29);
        }
    }
    assert_true(near > 3 * (NY - 16));
    assert_int_equal(far, 0);
}

static void arguments_are_refused(void **state)
{
    uint8_t skip[N];

    (void)state;
    setup(PLFX_PRESET_ONBOARD, 11);
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
    slope[0] = 77;
    assert_int_equal(run(NULL, 1), PLFX_E_SIZE);
    memset(skip, 1, sizeof skip);
    assert_int_equal(run(skip, 0), PLFX_E_ARG);
    map.w = NX - 1;
    assert_int_equal(run(NULL, 0), PLFX_E_ARG);
    map.w = NX;
    fcfg.trunc_q4 = 0;
    assert_int_equal(plfx_frame_ws(&plan, &fcfg), 0);
    assert_int_equal(plfx_frame(&plan, &fcfg, &views, NULL, &map, block, 1),
                     PLFX_E_ARG);
    setup(PLFX_PRESET_ONBOARD, 11);
    cfg.method = PLFX_METHOD_PAIRS;
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
    assert_int_equal(plfx_frame_ws(&plan, &fcfg), 0);
    assert_int_equal(slope[0], 77);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(volume_is_the_formula),
        cmocka_unit_test(paths_are_the_formula),
        cmocka_unit_test(median_is_the_least_half),
        cmocka_unit_test(refinement_is_near_double),
        cmocka_unit_test(planes_are_found),
        cmocka_unit_test(a_skipped_view_changes_nothing),
        cmocka_unit_test(flags_tell_apart),
        cmocka_unit_test(occlusion_is_flagged),
        cmocka_unit_test(arguments_are_refused),
    };

    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
