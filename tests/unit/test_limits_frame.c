/* SPDX-License-Identifier: MIT
 * Limits of the arguments of whole frames and of streams. */
#include "limits.h"
#include "square_table.h"

#include "plenofix/preset.h"
#include "plenofix/stream.h"

#define NX   12
#define NY   10
#define N    9
#define LENS 9
#define OK   PLFX_OK
#define ARG  PLFX_E_ARG
#define SIZE PLFX_E_SIZE
#define ROOM 200000

static uint64_t memory[ROOM / 8];
static uint16_t samples[NX * NY * N];
static int32_t slope[NX * NY];

static uint8_t *room(void)
{
    return aligned(memory);
}

typedef struct frame_args {
    plfx_plan plan;
    plfx_frame_cfg cfg;
    plfx_views views;
    plfx_map out;
    uint8_t *ws;
    size_t size;
} frame_args;

static frame_args args;

static void set_up(int32_t preset)
{
    plfx_cfg c;
    int32_t k;

    memset(&c, 0, sizeof c);
    memset(&args, 0, sizeof args);
    assert_int_equal(plfx_preset(preset, &c, &args.cfg), OK);
    c.bits = 10;
    c.n = N;
    c.ref = 4;
    c.labels = 5;
    c.slope_min_q16 = -65536;
    c.slope_max_q16 = 65536;
    for (k = 0; k < N; k++) {
        c.at[k].u_q8 = (int16_t)(256 * (k % 3 - 1));
        c.at[k].v_q8 = (int16_t)(256 * (k / 3 - 1));
    }
    assert_int_equal(plfx_plan_init(&args.plan, &c, NULL, NX, NY), OK);
    args.views.px = samples;
    args.views.nx = NX;
    args.views.ny = NY;
    args.views.n = N;
    args.out.slope_q16 = slope;
    args.out.w = NX;
    args.out.h = NY;
    args.out.stride = NX;
    args.ws = room();
    args.size = ROOM - 64;
}

static int32_t call_frame(void *p)
{
    const frame_args *a = p;

    mark(slope, sizeof slope);
    return kept(plfx_frame(&a->plan, &a->cfg, &a->views, NULL, &a->out, a->ws, a->size),
                slope, sizeof slope);
}

static void frame_configuration(void **state)
{
#define F(field, value, status) LIMIT(frame_args, cfg.field, value, status)
    static const limit table[] = {
        F(arms, 3, ARG),         F(arms, 4, OK),         F(arms, 8, OK),
        F(keep, 0, ARG),         F(keep, 4, OK),         F(keep, 5, ARG),
        F(shrink, 0, OK),        F(shrink, 2, ARG),      F(paths, 0, OK),
        F(paths, 5, OK),         F(paths, 8, OK),        F(paths, 4, ARG),
        F(median1, 0, OK),       F(median1, 2, ARG),     F(median1, 7, OK),
        F(median1, 9, ARG),      F(median2, 0, OK),      F(median2, 4, ARG),
        F(median2, 7, OK),       F(median2, 9, ARG),     F(taps, 0, OK),
        F(taps, 4, OK),          F(taps, 6, OK),         F(taps, 5, ARG),
        F(window, 4, ARG),       F(window, 1, OK),       F(window, 15, OK),
        F(window, 17, ARG),      F(passes, 0, ARG),      F(passes, 4, OK),
        F(passes, 5, ARG),       F(axes, 1, OK),         F(axes, 2, ARG),
        F(trunc_q4, 0, ARG),     F(trunc_q4, 1, OK),     F(trunc_q4, 1024, OK),
        F(trunc_q4, 1025, ARG),  F(gtrunc_q4, 0, ARG),   F(gtrunc_q4, 1024, OK),
        F(gtrunc_q4, 1025, ARG), F(gweight_q4, 31, OK),  F(gweight_q4, 32, ARG),
        F(p1_q4, 40, ARG),       F(p1_q4, 39, OK),       F(p2_q4, 1024, OK),
        F(p2_q4, 1025, ARG),     F(soften_q4, 0, ARG),   F(soften_q4, 1, OK),
        F(similar_q4, 0, ARG),   F(similar_q4, 1, OK),   F(robust_q4, 15, ARG),
        F(robust_q4, 16, OK),    F(robust_q4, 2048, OK), F(robust_q4, 2049, ARG),
        F(gate_q8, 0, ARG),      F(gate_q8, 1, OK),      F(gate_q8, 256, OK),
        F(gate_q8, 257, ARG),    F(clamp_q8, 256, OK),   F(clamp_q8, 257, ARG),
        F(prior_q12, 0, ARG),    F(prior_q12, 1, OK),    F(noise_q4, 0, OK),
        F(noise_q4, 256, OK),    F(noise_q4, 257, ARG),
    };
#undef F

    (void)state;
    set_up(PLFX_PRESET_ONBOARD);
    limits(&args, sizeof args, table, COUNT(table), call_frame);
    assert_true(plfx_frame_ws(&args.plan, &args.cfg) > 0);
    assert_int_equal(plfx_frame_ws(NULL, &args.cfg), 0);
    assert_int_equal(plfx_frame_ws(&args.plan, NULL), 0);
}

static void frame_arguments(void **state)
{
#define F(field, value, status) LIMIT(frame_args, field, value, status)
    static const limit table[] = {
        F(plan.cfg.method, PLFX_METHOD_SWEEP, ARG),
        F(views.px, 0, ARG),
        F(views.nx, NX - 1, ARG),
        F(views.ny, NY + 1, ARG),
        F(views.n, N - 1, ARG),
        F(out.slope_q16, 0, ARG),
        F(out.w, NX + 1, ARG),
        F(out.h, NY - 1, ARG),
        F(out.stride, NX - 1, ARG),
        F(ws, 0, SIZE),
        F(size, 1, SIZE),
    };
#undef F

    (void)state;
    set_up(PLFX_PRESET_ONBOARD);
    limits(&args, sizeof args, table, COUNT(table), call_frame);
    args.ws++;
    args.size = ROOM - 128;
    assert_int_equal(call_frame(&args), SIZE);
    set_up(PLFX_PRESET_ONBOARD);
    assert_int_equal(
        plfx_frame(NULL, &args.cfg, &args.views, NULL, &args.out, args.ws, args.size),
        ARG);
    assert_int_equal(
        plfx_frame(&args.plan, NULL, &args.views, NULL, &args.out, args.ws, args.size),
        ARG);
    assert_int_equal(
        plfx_frame(&args.plan, &args.cfg, NULL, NULL, &args.out, args.ws, args.size),
        ARG);
    assert_int_equal(
        plfx_frame(&args.plan, &args.cfg, &args.views, NULL, NULL, args.ws, args.size),
        ARG);
}

/* All views but the reference left out: nothing to match. */
static void no_view_left(void **state)
{
    static const uint8_t all[N] = {1, 1, 1, 1, 0, 1, 1, 1, 1};
    static const uint8_t most[N] = {1, 1, 1, 1, 0, 0, 1, 1, 1};

    (void)state;
    set_up(PLFX_PRESET_PRECISE);
    mark(slope, sizeof slope);
    assert_int_equal(plfx_frame(&args.plan, &args.cfg, &args.views, all, &args.out,
                                args.ws, args.size),
                     ARG);
    assert_true(marked(slope, sizeof slope));
    assert_int_equal(plfx_frame(&args.plan, &args.cfg, &args.views, most, &args.out,
                                args.ws, args.size),
                     OK);
}

/* So many views in an arm that their sum leaves 15 bits. */
static void an_arm_too_full(void **state)
{
    plfx_cfg c;
    int32_t k;

    (void)state;
    set_up(PLFX_PRESET_ONBOARD);
    c = args.plan.cfg;
    c.n = 58;
    c.ref = 0;
    for (k = 0; k < c.n; k++) {
        c.at[k].u_q8 = (int16_t)(k * 4);
        c.at[k].v_q8 = 0;
    }
    args.cfg.trunc_q4 = 1024;
    assert_int_equal(plfx_plan_init(&args.plan, &c, NULL, NX, NY), OK);
    assert_int_equal(plfx_frame(&args.plan, &args.cfg, &args.views, NULL, &args.out,
                                args.ws, args.size),
                     PLFX_E_RANGE);
}

/* Views on one line alone, in both directions and a single one; every kind of map. */
static void lines_of_views(void **state)
{
    static uint16_t conf[NX * NY], sigma[NX * NY];
    static uint8_t flags[NX * NY];
    static const plfx_offset at[4][2] = {{{256, 0}, {-256, 0}},
                                         {{0, 256}, {0, -256}},
                                         {{256, 250}, {-250, -256}},
                                         {{-256, 250}, {250, -256}}};
    int32_t way;
    int32_t arms;

    (void)state;
    for (way = 0; way < 4; way++) {
        for (arms = 4; arms <= 8; arms += 4) {
            plfx_cfg c;
            size_t i;
            set_up(PLFX_PRESET_STREAM);
            c = args.plan.cfg;
            c.n = 3;
            c.ref = 0;
            c.at[0].u_q8 = c.at[0].v_q8 = 0;
            c.at[1] = at[way][0];
            c.at[2] = at[way][1];
            args.cfg.arms = (uint8_t)arms;
            args.views.n = 3;
            args.out.conf_u16 = conf;
            args.out.sigma_u20 = sigma;
            args.out.flags = flags;
            for (i = 0; i < COUNT(samples); i++) {
                samples[i] = (uint16_t)(i * 2654435761u >> 7 & 1023u);
            }
            assert_int_equal(plfx_plan_init(&args.plan, &c, NULL, NX, NY), OK);
            assert_int_equal(call_frame(&args), OK);
            assert_int_equal(sigma[0], PLFX_SIGMA_NONE); /* nothing was refined */
        }
    }
}

/* A stream of NX x NY lenses. */
static uint8_t blob[512];
static plfx_lut lut;
static uint8_t pixels[(NX * LENS) * (NY * LENS) * 2];

typedef struct stream_args {
    plfx_stream_cfg cfg;
    uint8_t *ws;
    size_t size;
} stream_args;

static stream_args sa;
static plfx_plan plan;

static void set_up_stream(void)
{
    plfx_lut_desc d = square_table(NX, NY, LENS);
    plfx_cfg c;

    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), OK);
    assert_int_equal(plfx_lut_open(&lut, blob, sizeof blob), OK);
    memset(&c, 0, sizeof c);
    c.window = 5;
    c.bits = 10;
    c.n = 3;
    c.labels = 5;
    c.slope_min_q16 = -65536;
    c.slope_max_q16 = 65536;
    c.at[1].u_q8 = 256;
    c.at[2].v_q8 = 256;
    assert_int_equal(plfx_plan_init(&plan, &c, &lut, NX, NY), OK);
    memset(&sa, 0, sizeof sa);
    sa.cfg.plan = &plan;
    sa.cfg.lut = &lut;
    sa.cfg.tone = plfx_tone_unity(10);
    sa.cfg.format = PLFX_RAW_U16LE;
    sa.cfg.bits = 12;
    sa.cfg.open_rows = plfx_stream_open_rows(&lut, &plan, &sa.cfg.tone);
    sa.cfg.j1 = NY;
    sa.ws = room();
    sa.size = ROOM - 64;
    assert_in_range(sa.cfg.open_rows, 1, PLFX_STREAM_OPEN_MAX);
}

static int32_t call_stream(void *p)
{
    const stream_args *a = p;
    plfx_stream s;
    plfx_status status;

    mark(&s, sizeof s);
    status = plfx_stream_init(&s, &a->cfg, a->ws, a->size);
    assert_true(status == OK || marked(&s, sizeof s));
    assert_true((plfx_stream_ws(&a->cfg) == 0) == (status == ARG));
    return status;
}

static void stream_configuration(void **state)
{
#define S(field, value, status) LIMIT(stream_args, field, value, status)
    static const limit table[] = {
        S(cfg.plan, 0, ARG),
        S(cfg.lut, 0, ARG),
        S(cfg.profile, 1, OK),
        S(cfg.profile, 2, ARG),
        S(cfg.format, PLFX_RAW_FORMATS, ARG),
        S(cfg.bits, 7, ARG),
        S(cfg.bits, 8, OK),
        S(cfg.bits, 16, OK),
        S(cfg.bits, 17, ARG),
        S(cfg.tone.gain_q12, 4095, ARG),
        S(cfg.tone.gain_q12, 8191, OK),
        S(cfg.tone.gain_q12, 8192, ARG),
        S(cfg.tone.shift, -9, ARG),
        S(cfg.tone.shift, -8, OK),
        S(cfg.tone.shift, 8, OK),
        S(cfg.tone.shift, 9, ARG),
        S(cfg.tone.dx_q8, -257, ARG),
        S(cfg.tone.dx_q8, -256, OK),
        S(cfg.tone.dx_q8, 256, OK),
        S(cfg.tone.dx_q8, 257, ARG),
        S(cfg.tone.dy_q8, -257, ARG),
        S(cfg.tone.dy_q8, 256, OK),
        S(cfg.tone.dy_q8, 257, ARG),
        S(cfg.tone.bits, 9, ARG),
        S(cfg.white, 1, OK),
        S(cfg.open_rows, 0, ARG),
        S(cfg.open_rows, PLFX_STREAM_OPEN_MAX, OK),
        S(cfg.open_rows, PLFX_STREAM_OPEN_MAX + 1, ARG),
        S(cfg.j0, -1, ARG),
        S(cfg.j0, NY - 1, OK),
        S(cfg.j0, NY, ARG),
        S(cfg.j1, 1, OK),
        S(cfg.j1, NY + 1, ARG),
        S(ws, 0, SIZE),
        S(size, 1, SIZE),
    };
#undef S
    plfx_plan other;
    plfx_stream s;

    (void)state;
    set_up_stream();
    limits(&sa, sizeof sa, table, COUNT(table), call_stream);
    assert_int_equal(plfx_stream_init(NULL, &sa.cfg, sa.ws, sa.size), ARG);
    assert_int_equal(plfx_stream_init(&s, NULL, sa.ws, sa.size), ARG);
    assert_int_equal(plfx_stream_init(&s, &sa.cfg, sa.ws + 1, sa.size - 1), SIZE);
    other = plan;
    sa.cfg.plan = &other;
    other.nx++;
    assert_int_equal(call_stream(&sa), ARG);
    other.nx--;
    other.ny--;
    assert_int_equal(call_stream(&sa), ARG);
    other.ny++;
    other.cfg.method = PLFX_METHOD_GRADIENT;
    assert_int_equal(call_stream(&sa), ARG);
}

static void rows_at_the_same_time(void **state)
{
    plfx_tone tone;
    plfx_plan other;

    (void)state;
    set_up_stream();
    tone = sa.cfg.tone;
    assert_int_equal(plfx_stream_open_rows(NULL, &plan, &tone), 0);
    assert_int_equal(plfx_stream_open_rows(&lut, NULL, &tone), 0);
    assert_int_equal(plfx_stream_open_rows(&lut, &plan, NULL), 0);
    other = plan;
    other.ny++;
    assert_int_equal(plfx_stream_open_rows(&lut, &other, &tone), 0);
}

typedef struct push_args {
    plfx_raw_row row;
    int32_t y;
    int32_t odd; /* bytes beside their place */
} push_args;

static plfx_stream stream;

static int32_t call_push(void *p)
{
    const push_args *a = p;
    plfx_raw_row row = a->row;
    int32_t ready = -7;
    plfx_status status;

    if (row.bytes) {
        row.bytes += a->odd;
    }
    status = plfx_stream_push(&stream, a->y, &row, &ready);
    assert_true(status == OK || ready == -7);
    assert_int_equal(plfx_stream_reset(&stream), OK);
    return status;
}

static void pushed_rows(void **state)
{
#define P(field, value, status) LIMIT(push_args, field, value, status)
    static const limit table[] = {
        P(row.bytes, 0, ARG), P(row.format, PLFX_RAW_U8, ARG),
        P(row.bits, 11, ARG), P(row.width, NX * LENS - 1, ARG),
        P(row.bit, 4, ARG),   P(y, -1, ARG),
        P(y, NY * LENS, ARG), P(y, NY * LENS - 1, PLFX_E_STATE),
        P(odd, 1, OK),
    };
    static const limit own[] = {
        P(odd, 1, ARG),
        P(odd, 2, OK),
    };
#undef P
    push_args a = {{pixels, PLFX_RAW_U16LE, 12, 0, NX * LENS}, 0, 0};
    int32_t ready;
    plfx_stream empty;

    (void)state;
    memset(&empty, 0, sizeof empty);
    set_up_stream();
    assert_int_equal(plfx_stream_init(&stream, &sa.cfg, sa.ws, sa.size), OK);
    limits(&a, sizeof a, table, COUNT(table), call_push);
    assert_int_equal(plfx_stream_push(NULL, 0, &a.row, &ready), ARG);
    assert_int_equal(plfx_stream_push(&empty, 0, &a.row, &ready), ARG);
    assert_int_equal(plfx_stream_push(&stream, 0, NULL, &ready), ARG);
    assert_int_equal(plfx_stream_push(&stream, 0, &a.row, NULL), ARG);
    sa.cfg.format = a.row.format = PLFX_RAW_U16;
    a.row.bytes = (const uint8_t *)memory;
    assert_int_equal(plfx_stream_init(&stream, &sa.cfg, sa.ws, sa.size), OK);
    a.row.bytes = (const uint8_t *)samples;
    limits(&a, sizeof a, own, COUNT(own), call_push);
}

static void pushed_bands(void **state)
{
    plfx_raw band = {pixels, sizeof pixels, PLFX_RAW_U16LE, 12, NX * LENS, 3};
    plfx_stream empty;
    int32_t used = 0;
    int32_t ready = 0;

    (void)state;
    memset(&empty, 0, sizeof empty);
    set_up_stream();
    assert_int_equal(plfx_stream_init(&stream, &sa.cfg, sa.ws, sa.size), OK);
    assert_int_equal(plfx_stream_push_band(NULL, 0, &band, &used, &ready), ARG);
    assert_int_equal(plfx_stream_push_band(&empty, 0, &band, &used, &ready), ARG);
    assert_int_equal(plfx_stream_push_band(&stream, 0, NULL, &used, &ready), ARG);
    assert_int_equal(plfx_stream_push_band(&stream, 0, &band, NULL, &ready), ARG);
    assert_int_equal(plfx_stream_push_band(&stream, 0, &band, &used, NULL), ARG);
    band.h = 0;
    assert_int_equal(plfx_stream_push_band(&stream, 0, &band, &used, &ready), ARG);
    band.h = 3;
    band.size = 3 * 2 * NX * LENS - 1;
    assert_int_equal(plfx_stream_push_band(&stream, 0, &band, &used, &ready), SIZE);
    assert_int_equal(used, 0);
    band.size++;
    assert_int_equal(plfx_stream_push_band(&stream, 1, &band, &used, &ready), OK);
}

static void popped_rows(void **state)
{
    plfx_map row = {slope, NULL, NULL, NULL, NX, 1, NX};
    plfx_map bad;
    plfx_raw_row in = {pixels, PLFX_RAW_U16LE, 12, 0, NX * LENS};
    plfx_stream empty;
    int32_t first = 0;
    int32_t last = 0;
    int32_t ready = 0;
    int32_t j = 0;

    (void)state;
    memset(&empty, 0, sizeof empty);
    set_up_stream();
    assert_int_equal(plfx_stream_init(&stream, &sa.cfg, sa.ws, sa.size), OK);
    assert_int_equal(plfx_stream_push(&stream, 0, &in, &ready), OK);
    assert_true(ready > 0);
    mark(slope, sizeof slope);
    assert_int_equal(plfx_stream_pop(NULL, &j, &row, &ready), ARG);
    assert_int_equal(plfx_stream_pop(&empty, &j, &row, &ready), ARG);
    assert_int_equal(plfx_stream_pop(&stream, NULL, &row, &ready), ARG);
    assert_int_equal(plfx_stream_pop(&stream, &j, &row, NULL), ARG);
    assert_int_equal(plfx_stream_pop(&stream, &j, NULL, &ready), ARG);
    bad = row;
    bad.slope_q16 = NULL;
    assert_int_equal(plfx_stream_pop(&stream, &j, &bad, &ready), ARG);
    bad = row;
    bad.w--;
    assert_int_equal(plfx_stream_pop(&stream, &j, &bad, &ready), ARG);
    assert_true(marked(slope, sizeof slope));
    assert_int_equal(plfx_stream_pop(&stream, &j, &row, &ready), OK);
    assert_int_equal(plfx_stream_finish(NULL), ARG);
    assert_int_equal(plfx_stream_finish(&empty), ARG);
    assert_int_equal(plfx_stream_finish(&stream), PLFX_E_STATE);
    assert_int_equal(plfx_stream_reset(NULL), ARG);
    assert_int_equal(plfx_stream_reset(&empty), ARG);
    plfx_stream_rows(&stream, &first, &last);
    assert_true(first >= 0 && last < NY * LENS);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(frame_configuration),   cmocka_unit_test(frame_arguments),
    cmocka_unit_test(no_view_left),          cmocka_unit_test(an_arm_too_full),
    cmocka_unit_test(lines_of_views),        cmocka_unit_test(stream_configuration),
    cmocka_unit_test(rows_at_the_same_time), cmocka_unit_test(pushed_rows),
    cmocka_unit_test(pushed_bands),          cmocka_unit_test(popped_rows),
};

SUITE(tests)
