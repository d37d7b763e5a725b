/* SPDX-License-Identifier: MIT
 * Stages of a frame at their ends: odd rows of a hexagonal lattice, neighbours beyond
 * the gate, steps at the clamp, maps of more than 15 bits, flags that a plan leaves
 * out. */
#include "suite.h"

#include "plenofix/preset.h"
#include "ref_frame.h"

#define NX 14
#define NY 12
#define N  5 /* the reference in the middle of a cross */

static uint64_t memory[18000];
static uint16_t block[NY * N * NX];
static plfx_cfg cfg;
static plfx_frame_cfg fcfg;
static plfx_plan plan;
static plfx_views views = {block, NX, NY, N};
static uint8_t blob[256];
static plfx_lut lut;
static uint32_t seed = 4711;

static uint32_t random_next(void)
{
    seed = seed * 1664525u + 1013904223u;
    return seed >> 8;
}

static void setup(int32_t preset)
{
    static const plfx_offset cross[N] = {
        {0, -256}, {-256, 0}, {0, 0}, {256, 0}, {0, 256}};

    memset(&cfg, 0, sizeof cfg);
    assert_int_equal(plfx_preset(preset, &cfg, &fcfg), PLFX_OK);
    cfg.bits = 10;
    cfg.n = N;
    cfg.ref = 2;
    cfg.labels = 5;
    cfg.slope_min_q16 = -2 * 65536;
    cfg.slope_max_q16 = 2 * 65536;
    memcpy(cfg.at, cross, sizeof cross);
    printf("# seed %u\n", (unsigned)seed);
}

/* A lattice with a step of `ax` pixels along the rows, which are 9 apart. */
static const plfx_lut *lattice(int32_t hex, int32_t ax)
{
    plfx_lut_desc d;

    memset(&d, 0, sizeof d);
    d.sensor_w = (NX + 1) * ax;
    d.sensor_h = NY * 9;
    d.sensor_bits = 12;
    d.lattice.kind = hex ? PLFX_LATTICE_HEX : PLFX_LATTICE_SQUARE;
    d.lattice.nx = NX;
    d.lattice.ny = NY;
    d.lattice.origin.x_q16 = 4 << 16;
    d.lattice.origin.y_q16 = 4 << 16;
    d.lattice.a.x_q22 = ax << 22;
    d.lattice.b.y_q22 = 9 << 22;
    d.lattice.odd.x_q22 = hex ? ax << 21 : 0;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, sizeof blob), PLFX_OK);
    return &lut;
}

static void noise(uint32_t mask)
{
    size_t i;

    for (i = 0; i < sizeof block / sizeof block[0]; i++) {
        block[i] = (uint16_t)(random_next() & mask);
    }
}

/* Waves displaced by `left` lenses a view in the left half, by `right` elsewhere. */
static void planes(double left, double right)
{
    int i;

    for (i = 0; i < NX * NY * N; i++) {
        int k = i / NX % N;
        double d = i % NX < NX / 2 ? left : right;
        double x = i % NX - d * cfg.at[k].u_q8 / 256;
        double y = i / NX / N - d * cfg.at[k].v_q8 / 256;
        block[i] = (uint16_t)(500.5 + 150 * sin(0.9 * x + 0.4 * y) +
                              120 * sin(0.5 * y - 0.7 * x + 1) +
                              80 * sin(1.3 * y + 0.2 * x + 2));
    }
}

static plfx_frame_state opened(const plfx_lut *table)
{
    plfx_frame_state s;

    assert_int_equal(plfx_plan_init(&plan, &cfg, table, NX, NY), PLFX_OK);
    assert_int_equal(plfx_frame_derive(&s, &plan, &fcfg, NULL), PLFX_OK);
    assert_true(plfx_frame_carve(&s, NULL) <= sizeof memory - 64);
    (void)plfx_frame_carve(&s, aligned(memory));
    plfx_frame_tables(&s, NULL);
    plfx_frame_load(&s, &views);
    return s;
}

static void odd_rows_are_displaced_in_arms(void **state)
{
    plfx_frame_state s;
    int i;

    (void)state;
    setup(PLFX_PRESET_ONBOARD);
    planes(0.8, -0.3);
    s = opened(lattice(1, 10));
    assert_int_equal(plan.odd_q4, 8);
    plfx_arms_volume(&s);
    for (i = 0; i < NX * NY * s.labels; i++) {
        int x = i % NX;
        int l = i / NX % s.labels;
        int y = i / NX / s.labels;
        assert_int_equal(s.volume[i], ref_volume(&s, l, x, y));
    }
}

/* Sums of a window's neighbours within the gate. */
static double gated_step(const plfx_frame_state *s, const int32_t *in, int x, int y)
{
    double prior = fcfg.prior_q12 / 4096.;
    double gate = fcfg.gate_q8 / 256.;
    double r = 0;
    double n = 0;
    double a = 0;
    double b = 0;
    int i;

    for (i = 0; i < 9; i++) {
        int at = (y + i / 3 - 1) * NX + x + i % 3 - 1;
        double d = (in[at] - in[y * NX + x]) / 65536.;
        ref_sums t;
        if (fabs(d) >= gate) {
            continue;
        }
        t = ref_pixel(s, in[at] / 65536., at % NX, at / NX);
        a += t.a;
        b += t.a * d - t.b;
        r += t.r;
        n += t.n;
    }
    r = r / n < 819 / 256. ? 819 / 256. : r / n;
    return b / (a + r / (prior * prior));
}

/* Two surfaces 0.9 columns apart: each pixel is refined with its own. */
static void neighbours_beyond_the_gate_do_not_count(void **state)
{
    static int32_t in[NX * NY], out[NX * NY];
    static uint32_t near[NX * NY];
    plfx_frame_state s;
    int side;
    int i;

    (void)state;
    setup(PLFX_PRESET_ONBOARD);
    fcfg.taps = 6;
    fcfg.window = 3;
    fcfg.gate_q8 = 128;
    fcfg.prior_q12 = 400;
    planes(0.4, -0.5);
    s = opened(NULL);
    for (i = 0; i < NX * NY; i++) {
        in[i] = (i % NX < NX / 2 ? 25000 : -34000) + (int32_t)(random_next() % 2000u);
        s.flags[i] = 0;
    }
    plfx_refine(&s, in, out, 1);
    memcpy(near, s.base, sizeof near);
    for (i = 0; i < NX * NY; i++) {
        int x = i % NX;
        int y = i / NX;
        if (x >= 4 && x < NX - 4 && y >= 4 && y < NY - 4) {
            double want = gated_step(&s, in, x, y);
            assert_true(fabs((out[i] - in[i]) / 65536. - want) <
                        2e-4 + 0.05 * fabs(want));
        }
    }
    for (side = -1; side <= 0; side++) { /* the other side moved: errors stay */
        static int32_t moved[NX * NY];
        for (i = 0; i < NX * NY; i++) {
            int other = (i % NX < NX / 2) != (side < 0);
            moved[i] = in[i] + (other ? (side < 0 ? -9000 : 9000) : 0);
        }
        plfx_refine(&s, moved, out, 1);
        for (i = NX / 2 + side; i < NX * NY; i += NX) {
            assert_int_equal(s.base[i], near[i]);
        }
    }
}

static void no_step_is_longer_than_the_clamp(void **state)
{
    static int32_t in[NX * NY], out[NX * NY];
    plfx_frame_state s;
    int up = 0;
    int down = 0;
    int i;

    (void)state;
    setup(PLFX_PRESET_ONBOARD);
    fcfg.clamp_q8 = 8;
    planes(0.4, 0.4);
    s = opened(NULL);
    for (i = 0; i < NX * NY; i++) {
        in[i] = i % NX < NX / 2 ? 0 : 52000; /* 0.4 is 26214 */
        s.flags[i] = 0;
    }
    plfx_refine(&s, in, out, 0);
    for (i = 0; i < NX * NY; i++) {
        assert_in_range(out[i] - in[i] + 2048, 0, 4096);
        up += out[i] - in[i] == 2048;
        down += out[i] - in[i] == -2048;
    }
    assert_true(up > NX * NY / 8 && down > NX * NY / 8);
}

/* A range of 20 bits leaves 15: values are cut to steps of 32 from the least. */
static void medians_of_wide_maps_are_cut_to_15_bits(void **state)
{
    static int32_t in[NX * NY], cut[NX * NY], out[NX * NY];
    plfx_frame_state s;
    int i;

    (void)state;
    setup(PLFX_PRESET_ONBOARD);
    noise(255);
    s = opened(NULL);
    for (i = 0; i < NX * NY; i++) {
        in[i] = (int32_t)(random_next() % 1048576u) - 500000;
    }
    in[5] = -500000;
    in[6] = -500000 + 1048575;
    for (i = 0; i < NX * NY; i++) {
        cut[i] = (in[i] + 500000) / 32 * 32 - 500000;
    }
    plfx_median(&s, 5, in, out);
    for (i = 0; i < NX * NY; i++) {
        assert_int_equal(out[i], ref_median(&s, 5, cut, i % NX, i / NX));
    }
}

static uint8_t flags_with(uint16_t unique, uint16_t texture)
{
    static int32_t slope[NX * NY];
    static uint8_t flags[NX * NY];
    plfx_map map = {slope, NULL, NULL, flags, NX, NY, NX};

    cfg.unique_u16 = unique;
    cfg.texture = texture;
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, NX, NY), PLFX_OK);
    assert_int_equal(plfx_frame(&plan, &fcfg, &views, NULL, &map, aligned(memory),
                                sizeof memory - 64),
                     PLFX_OK);
    return flags[NX * (NY / 2) + NX / 2];
}

static void weak_samples_are_flagged_when_asked(void **state)
{
    int i;

    (void)state;
    setup(PLFX_PRESET_ONBOARD);
    for (i = 0; i < NX * NY * N; i++) {
        block[i] = 500;
    }
    assert_int_equal(flags_with(0, 0) & (PLFX_FLAG_UNIQUE | PLFX_FLAG_TEXTURE), 0);
    assert_int_equal(flags_with(1, 0) & (PLFX_FLAG_UNIQUE | PLFX_FLAG_TEXTURE),
                     PLFX_FLAG_UNIQUE);
    assert_int_equal(flags_with(0, 1) & (PLFX_FLAG_UNIQUE | PLFX_FLAG_TEXTURE),
                     PLFX_FLAG_TEXTURE);
}

/* Columns three times as far apart as rows: an offset of 1/256 is a 768th of one. */
static void views_in_one_place_are_refused(void **state)
{
    (void)state;
    setup(PLFX_PRESET_ONBOARD);
    cfg.n = 2;
    cfg.ref = 0;
    memset(cfg.at, 0, sizeof cfg.at);
    cfg.at[1].u_q8 = 1;
    assert_int_equal(plfx_plan_init(&plan, &cfg, lattice(0, 27), NX, NY), PLFX_OK);
    assert_int_equal(plfx_frame_ws(&plan, &fcfg), 0);
    cfg.at[1].u_q8 = 2;
    assert_int_equal(plfx_plan_init(&plan, &cfg, &lut, NX, NY), PLFX_OK);
    assert_true(plfx_frame_ws(&plan, &fcfg) > 0);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(odd_rows_are_displaced_in_arms),
    cmocka_unit_test(neighbours_beyond_the_gate_do_not_count),
    cmocka_unit_test(no_step_is_longer_than_the_clamp),
    cmocka_unit_test(medians_of_wide_maps_are_cut_to_15_bits),
    cmocka_unit_test(weak_samples_are_flagged_when_asked),
    cmocka_unit_test(views_in_one_place_are_refused),
};

SUITE(tests)
