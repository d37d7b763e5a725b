/* SPDX-License-Identifier: MIT
 * plenofix_cl against the core, to the bit, on whatever OpenCL device is here.
 * usage: test_cl [CASES | tiny]   (default 24; tiny: a few small plans, for slow
 * implementations) */
#include "../unit/suite.h"
#include "../golden/scene.h"
#include "../ref/ref.h"
#include "plenofix/cl.h"

#define SIDE         48
#define CELLS        (SIDE * SIDE)
#define PLANES_CELLS CELLS
#define N            6
#define RAW_W        300
#define RAW_H        220
#define LENS_X       24
#define LENS_Y       17

#include "../unit/planes.h"

static int cases = 24;
static int32_t side = SIDE;
static uint16_t samples[CELLS * 25];
static uint16_t frame[RAW_W * RAW_H];
static unsigned char blob[65536];
static unsigned char memory[(16 << 20) + 64];

static unsigned char *workspace(void)
{
    return memory + (64 - (uintptr_t)memory % 64) % 64;
}

static void cross(plfx_cfg *c, int16_t step)
{
    c->n = 5;
    c->ref = 0;
    memset(c->at, 0, sizeof c->at);
    c->at[1].u_q8 = (int16_t)-step;
    c->at[2].u_q8 = step;
    c->at[3].v_q8 = (int16_t)-step;
    c->at[4].v_q8 = step;
}

static plfx_cfg random_cfg(ref_rng *rng)
{
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.method = (uint8_t)ref_range(rng, 0, 2);
    c.cost = (uint8_t)(c.method == PLFX_METHOD_PAIRS ? ref_range(rng, 0, 1) : 0);
    c.fit = (uint8_t)ref_range(rng, 0, 1);
    c.fuse = (uint8_t)ref_range(rng, 0, 1);
    c.window = (uint8_t)(2 * ref_range(rng, 1, 4) + 1);
    c.bits = (uint8_t)ref_range(rng, 8, 12);
    c.n = (uint8_t)(ref_range(rng, 0, 5) == 0 ? ref_range(rng, 2, 25)
                                              : ref_range(rng, 2, N));
    c.ref = (uint8_t)ref_range(rng, 0, c.n - 1);
    c.labels = (uint16_t)ref_range(rng, 3, 20);
    c.texture = (uint16_t)(ref_range(rng, 0, 2) == 0 ? ref_range(rng, 0, 3000) : 0);
    c.unique_u16 = (uint16_t)(ref_range(rng, 0, 2) == 0 ? ref_range(rng, 0, 20000) : 0);
    c.slope_min_q16 = ref_range(rng, -40000, 0);
    c.slope_max_q16 = c.slope_min_q16 + ref_range(rng, 100, 60000);
    for (int32_t k = 0; k < c.n; k++) {
        c.at[k].u_q8 = (int16_t)ref_range(rng, -1000, 1000);
        c.at[k].v_q8 =
            (int16_t)(ref_range(rng, 0, 1) ? ref_range(rng, -1000, 1000) : 0);
    }
    if (c.method == PLFX_METHOD_GRADIENT) {
        cross(&c, (int16_t)ref_range(rng, 1, 1000));
    }
    return c;
}

static void fill(ref_rng *rng, uint16_t *px, size_t n, int32_t top)
{
    int32_t kind = ref_range(rng, 0, 3);
    int32_t level = ref_range(rng, 0, top);

    for (size_t i = 0; i < n; i++) {
        int32_t s = kind == 0   ? level
                    : kind == 1 ? (ref_range(rng, 0, 1) ? top : 0)
                                : ref_range(rng, 0, top);
        px[i] = (uint16_t)s;
    }
}

static plfx_status core_map(const plfx_plan *plan, const plfx_views *v,
                            const plfx_map *m)
{
    assert_true(plan->cfg.method == PLFX_METHOD_GRADIENT ||
                plfx_sweep_ws(plan) <= sizeof memory - 64);
    return plan->cfg.method == PLFX_METHOD_GRADIENT
               ? plfx_gradient(plan, v, m, workspace(), plfx_gradient_ws(plan))
               : plfx_sweep(plan, v, m, workspace(), plfx_sweep_ws(plan));
}

static void same(const plfx_plan *plan, uint32_t seed)
{
    size_t n = (size_t)plan->nx * (size_t)plan->ny;

    for (size_t i = 0; i < n; i++) {
        if (got.slope[i] != want.slope[i] || got.conf[i] != want.conf[i] ||
            got.flags[i] != want.flags[i]) {
            fail_msg(
                "seed %u method %d cost %d lens %u: slope %d/%d conf %u/%u flags %u/%u",
                (unsigned)seed, plan->cfg.method, plan->cfg.cost, (unsigned)i,
                (int)got.slope[i], (int)want.slope[i], got.conf[i], want.conf[i],
                got.flags[i], want.flags[i]);
        }
    }
}

static void device_map(const plfx_plan *plan, const plfx_cl_input *input,
                       const void *bytes, size_t n, const plfx_map *m)
{
    static plfx_cl cl;
    plfx_status s = plfx_cl_open(&cl, 0, plan, input);

    if (s != PLFX_OK) {
        fail_msg("open: %d %s", s, cl.message);
    }
    assert_int_equal(plfx_cl_submit(&cl, bytes, n), PLFX_OK);
    assert_int_equal(plfx_cl_fetch(&cl, m), PLFX_OK);
    plfx_cl_close(&cl);
}

static int views_case(uint32_t seed)
{
    ref_rng rng = {seed};
    plfx_cfg cfg = random_cfg(&rng);
    plfx_cl_input input;
    plfx_plan plan;
    plfx_views v;
    plfx_map g;
    plfx_map w;

    memset(&input, 0, sizeof input);
    if (plfx_plan_init(&plan, &cfg, NULL, ref_range(&rng, 9, side),
                       ref_range(&rng, 9, side / 2)) != PLFX_OK) {
        return 0;
    }
    plan.hex = ref_range(&rng, 0, 1);
    plan.odd_q4 = plan.hex ? ref_range(&rng, -9, 9) : 0;
    plan.row_q16 = plan.hex ? 75674 : 65536;
    v.px = samples;
    v.nx = plan.nx;
    v.ny = plan.ny;
    v.n = plan.cfg.n;
    fill(&rng, samples, (size_t)v.nx * (size_t)v.ny * (size_t)v.n, (1 << cfg.bits) - 1);
    g = map_of(&got, &plan);
    w = map_of(&want, &plan);
    device_map(&plan, &input, samples, 2 * (size_t)v.nx * (size_t)v.ny * (size_t)v.n,
               &g);
    assert_int_equal(core_map(&plan, &v, &w), PLFX_OK);
    same(&plan, seed);
    return 1;
}

static void views_equal_the_core(void **state)
{
    int done = 0;

    (void)state;
    for (uint32_t seed = 1; done < cases && seed < 100000; seed++) {
        done += views_case(seed);
    }
    printf("# %d random plans, 0 differing words\n", done);
    assert_int_equal(done, cases);
}

static plfx_lut table(ref_rng *rng, int32_t hex, int32_t bits)
{
    static uint16_t profile[4 * 81], gain[LENS_X * LENS_Y];
    static uint8_t flags[LENS_X * LENS_Y];
    plfx_lut_desc d;
    plfx_lut lut;

    memset(&d, 0, sizeof d);
    d.sensor_w = RAW_W;
    d.sensor_h = RAW_H;
    d.sensor_bits = bits;
    d.lattice.kind = hex ? PLFX_LATTICE_HEX : PLFX_LATTICE_SQUARE;
    d.lattice.nx = LENS_X;
    d.lattice.ny = LENS_Y;
    d.lattice.origin.x_q16 = 8 << 16 | 777;
    d.lattice.origin.y_q16 = 6 << 16 | 333;
    d.lattice.a.x_q22 = 12 << 22;
    d.lattice.a.y_q22 = 40000;
    d.lattice.b.x_q22 = -40000;
    d.lattice.b.y_q22 = hex ? 43588074 : 12 << 22;
    d.lattice.odd.x_q22 = hex ? 6 << 22 : 0;
    d.radius_q8 = 4 * 256;
    for (int i = 0; i < LENS_X * LENS_Y; i++) {
        flags[i] = ref_range(rng, 0, 20) == 0 ? PLFX_LENS_MISSING : 0;
        gain[i] = (uint16_t)ref_range(rng, 6000, 20000);
    }
    for (int i = 0; i < 4 * 81; i++) {
        profile[i] = (uint16_t)ref_range(rng, 6000, 12000);
    }
    d.flags = flags;
    d.zones_x = 2;
    d.zones_y = 2;
    d.profile_r = 4;
    d.profile_u13 = profile;
    d.lens_gain_u13 = gain;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, plfx_lut_bytes(&d)), PLFX_OK);
    return lut;
}

static void raw_case(uint32_t seed, uint8_t format, uint8_t bits)
{
    ref_rng rng = {seed};
    plfx_lut lut = table(&rng, ref_range(&rng, 0, 1), bits);
    plfx_raw raw = {(const uint8_t *)frame,
                    plfx_raw_bytes(format, RAW_W, RAW_H),
                    format,
                    bits,
                    RAW_W,
                    RAW_H};
    plfx_cl_input input;
    plfx_plan plan;
    plfx_cfg cfg;
    plfx_views v = {samples, LENS_X, LENS_Y, 5};
    plfx_map g;
    plfx_map w;

    memset(&cfg, 0, sizeof cfg);
    memset(&input, 0, sizeof input);
    cfg.window = 5;
    cfg.bits = 10;
    cfg.labels = 7;
    cfg.slope_min_q16 = -20000;
    cfg.slope_max_q16 = 20000;
    cross(&cfg, 700);
    input.lut = &lut;
    input.format = format;
    input.bits = bits;
    input.white = (uint8_t)(seed & 1);
    input.tone = plfx_tone_unity(10);
    input.tone.black_u16 = 1000;
    input.tone.gain_q12 = 5000;
    input.tone.dx_q8 = -128;
    fill(&rng, frame, RAW_W * RAW_H, format == PLFX_RAW_U16 ? (1 << bits) - 1 : 65535);
    assert_int_equal(plfx_plan_init(&plan, &cfg, &lut, LENS_X, LENS_Y), PLFX_OK);
    g = map_of(&got, &plan);
    w = map_of(&want, &plan);
    device_map(&plan, &input, frame, raw.size, &g);
    assert_int_equal(plfx_view_all(&lut, &raw, &input.tone, cfg.at, input.white, &v),
                     PLFX_OK);
    assert_int_equal(core_map(&plan, &v, &w), PLFX_OK);
    same(&plan, seed);
}

static void raw_frames_equal_the_core(void **state)
{
    static const uint8_t bits[PLFX_RAW_FORMATS] = {8, 14, 12, 10, 12, 10, 12, 10, 12};

    (void)state;
    for (uint8_t f = 0; f < PLFX_RAW_FORMATS; f++) {
        raw_case(100u + f, f, bits[f]);
    }
}

/* Slope, confidence, flags and depth of the golden scene, from its raw frame. */
static void golden_case(int32_t lattice, const plfx_cfg *cfg)
{
    static const plfx_optics optics = {16777216, -123456789};
    static uint32_t um[SCENE_NX * SCENE_NY];
    static uint32_t row[SCENE_NX];
    static plfx_cl cl;
    plfx_raw raw = scene_raw();
    plfx_cl_input input;
    plfx_plan plan;
    plfx_lut lut;
    plfx_views v;
    plfx_map g;
    plfx_map w;
    int32_t y;

    assert_true(scene_make(lattice, &lut) > 0);
    memset(&input, 0, sizeof input);
    input.lut = &lut;
    input.format = raw.format;
    input.bits = raw.bits;
    input.white = 1;
    input.tone = scene_tone();
    input.optics = &optics;
    assert_int_equal(plfx_plan_init(&plan, cfg, &lut, SCENE_NX, SCENE_NY), PLFX_OK);
    g = map_of(&got, &plan);
    w = map_of(&want, &plan);
    if (plfx_cl_open(&cl, 0, &plan, &input) != PLFX_OK) {
        fail_msg("open: %s", cl.message);
    }
    assert_int_equal(plfx_cl_submit(&cl, raw.bytes, raw.size), PLFX_OK);
    assert_int_equal(plfx_cl_fetch_depth(&cl, &g, um), PLFX_OK);
    plfx_cl_close(&cl);
    assert_int_equal(scene_views(&lut, &v), PLFX_OK);
    assert_int_equal(core_map(&plan, &v, &w), PLFX_OK);
    same(&plan, 0);
    for (y = 0; y < SCENE_NY; y++) {
        plfx_depth_row(&optics, want.slope + y * SCENE_NX, SCENE_NX, row);
        assert_memory_equal(um + y * SCENE_NX, row, sizeof row);
    }
}

/* Every dense stage that test_golden.c holds on every target. */
static void golden_scenes_equal_the_core(void **state)
{
    static const uint8_t list[][4] = {
        {PLFX_METHOD_SWEEP, PLFX_COST_SAD, PLFX_FIT_VEE, 0},
        {PLFX_METHOD_SWEEP, PLFX_COST_SAD, PLFX_FIT_PARABOLA, 0},
        {PLFX_METHOD_PAIRS, PLFX_COST_SAD, PLFX_FIT_VEE, 0},
        {PLFX_METHOD_PAIRS, PLFX_COST_ZNCC, PLFX_FIT_PARABOLA, 0},
        {PLFX_METHOD_PAIRS, PLFX_COST_ZNCC, PLFX_FIT_PARABOLA, 1},
        {PLFX_METHOD_GRADIENT, PLFX_COST_SAD, PLFX_FIT_PARABOLA, 0}};
    size_t k;

    (void)state;
    for (k = 0; k < sizeof list / sizeof list[0]; k++) {
        plfx_cfg cfg = scene_cfg(list[k][0], list[k][1], list[k][2]);
        cfg.fuse = list[k][3] ? PLFX_FUSE_CORRELATION : PLFX_FUSE_MEDIAN;
        golden_case(PLFX_LATTICE_SQUARE, &cfg);
        golden_case(PLFX_LATTICE_HEX, &cfg);
    }
    printf("# 12 golden maps and their depth, 0 differing words\n");
}

/* Two frames in flight come back in order, each its own. */
static void frames_in_flight(void **state)
{
    static plfx_cl cl;
    ref_rng rng = {77};
    plfx_cfg cfg = random_cfg(&rng);
    plfx_cl_input input;
    plfx_plan plan;
    plfx_views v = {samples, 30, 20, 3};
    size_t n = 2 * 30 * 20 * 3;
    plfx_map g;
    plfx_map w;

    (void)state;
    memset(&input, 0, sizeof input);
    cfg.method = PLFX_METHOD_PAIRS;
    cfg.cost = PLFX_COST_ZNCC;
    cfg.n = 3;
    cfg.ref = 1;
    cfg.window = 5;
    for (int k = 0; k < 3; k++) {
        cfg.at[k].u_q8 = (int16_t)(256 * (k - 1));
        cfg.at[k].v_q8 = 0;
    }
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, 30, 20), PLFX_OK);
    g = map_of(&got, &plan);
    w = map_of(&want, &plan);
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &input), PLFX_OK);
    assert_int_equal(cl.bytes, plfx_cl_bytes(&plan, &input));
    assert_int_equal(plfx_cl_fetch(&cl, &g), PLFX_E_STATE);
    for (uint32_t i = 0; i < 6; i++) {
        rng.state = 1000 + i;
        fill(&rng, samples, n / 2, (1 << cfg.bits) - 1);
        assert_int_equal(plfx_cl_submit(&cl, samples, n), PLFX_OK);
        if (i == 0) {
            continue;
        }
        if (i == 1) {
            assert_int_equal(plfx_cl_submit(&cl, samples, n), PLFX_E_STATE);
        }
        rng.state = 999 + i;
        fill(&rng, samples, n / 2, (1 << cfg.bits) - 1);
        assert_int_equal(plfx_cl_fetch(&cl, &g), PLFX_OK);
        assert_int_equal(core_map(&plan, &v, &w), PLFX_OK);
        same(&plan, i);
    }
    assert_int_equal(plfx_cl_submit(&cl, samples, n - 1), PLFX_E_SIZE);
    assert_int_equal(plfx_cl_submit(&cl, NULL, n), PLFX_E_ARG);
    g.w++;
    assert_int_equal(plfx_cl_fetch(&cl, &g), PLFX_E_ARG);
    plfx_cl_close(&cl);
    assert_int_equal(plfx_cl_submit(&cl, samples, n), PLFX_E_ARG);
}

static void refusals(void **state)
{
    static plfx_cl cl;
    ref_rng rng = {5};
    plfx_lut lut = table(&rng, 0, 12);
    plfx_cfg cfg = random_cfg(&rng);
    plfx_cl_input input;
    plfx_cl_info info;
    plfx_plan plan;

    (void)state;
    memset(&input, 0, sizeof input);
    cfg.method = PLFX_METHOD_GRADIENT;
    cfg.cost = 0;
    cfg.window = 5;
    cross(&cfg, 100);
    assert_int_equal(plfx_plan_init(&plan, &cfg, NULL, 30, 20), PLFX_OK);
    assert_int_equal(plfx_cl_open(&cl, 99, &plan, &input), PLFX_E_ARG);
    assert_true(cl.message[0] != 0);
    assert_int_equal(plfx_cl_open(&cl, -1, &plan, &input), PLFX_E_ARG);
    assert_int_equal(plfx_cl_open(&cl, 0, NULL, &input), PLFX_E_ARG);
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, NULL), PLFX_E_ARG);
    input.lut = &lut; /* a table of another size than the plan */
    input.bits = 12;
    input.tone = plfx_tone_unity(cfg.bits);
    assert_int_equal(plfx_cl_bytes(&plan, &input), 0);
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &input), PLFX_E_ARG);
    assert_int_equal(plfx_cl_describe(99, &info), PLFX_E_ARG);
    assert_int_equal(plfx_cl_describe(0, NULL), PLFX_E_ARG);
    assert_int_equal(plfx_cl_describe(0, &info), PLFX_OK);
    assert_true(info.memory > 0 && info.units > 0 && info.group > 0 &&
                info.name[0] != 0);
    memset(&cl, 0, sizeof cl);
    plfx_cl_close(&cl);
    plfx_cl_close(NULL);
}

int main(int argc, char **argv)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(views_equal_the_core),
        cmocka_unit_test(raw_frames_equal_the_core),
        cmocka_unit_test(golden_scenes_equal_the_core),
        cmocka_unit_test(frames_in_flight),
        cmocka_unit_test(refusals),
    };

    static const struct CMUnitTest few[] = {
        cmocka_unit_test(views_equal_the_core),
    };
    int tiny = argc > 1 && strcmp(argv[1], "tiny") == 0;

    if (argc > 1) {
        cases = tiny ? 6 : atoi(argv[1]);
        side = tiny ? 20 : SIDE;
    }
    if (plfx_cl_devices() == 0) {
        printf("1..0 # SKIP no OpenCL device\n");
        return 0;
    }
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return tiny ? cmocka_run_group_tests(few, NULL, NULL)
                : cmocka_run_group_tests(tests, NULL, NULL);
}
