/* SPDX-License-Identifier: MIT
 * What can go wrong with a device, on a driver of the test's own (fake_cl.h): every
 * call fails once; each time there is a status, a message, nothing held, and the core
 * goes on. */
#define CL_TARGET_OPENCL_VERSION 120
#include "../unit/suite.h"
#include "fake_cl.h"
#include "plenofix/plenofix.h"
#include "plenofix/cl.h"

#include "params.h"

#include <CL/cl.h>

#define NX 20
#define NY 15
#define W  200
#define H  150

static uint8_t frame[2 * W * H], blob[4096];
static uint16_t samples[5 * NX * NY];
static unsigned char work[1 << 19] __attribute__((aligned(PLFX_ALIGN)));
static int32_t slope[NX * NY];
static uint16_t conf[NX * NY];
static uint8_t flags[NX * NY];
static uint32_t um[NX * NY];
static const plfx_map map = {slope, conf, NULL, flags, NX, NY, NX};
static const plfx_optics optics = {16777216, -123456789};
static plfx_lut lut;
static plfx_plan plan;
static plfx_cl cl;

static void prepare(uint8_t method, uint8_t cost)
{
    plfx_lut_desc d;
    plfx_cfg c;
    int k;

    memset(&d, 0, sizeof d);
    d.sensor_w = W;
    d.sensor_h = H;
    d.sensor_bits = 12;
    d.lattice.nx = NX;
    d.lattice.ny = NY;
    d.lattice.origin.x_q16 = d.lattice.origin.y_q16 = 5 << 16;
    d.lattice.a.x_q22 = d.lattice.b.y_q22 = 10 << 22;
    d.radius_q8 = 4 * 256;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, plfx_lut_bytes(&d)), PLFX_OK);
    memset(&c, 0, sizeof c);
    c.method = method;
    c.cost = cost;
    c.window = 3;
    c.bits = 10;
    c.n = 5;
    c.labels = 5;
    c.slope_min_q16 = -5000;
    c.slope_max_q16 = 5000;
    for (k = 1; k < 5; k++) {
        c.at[k].u_q8 = (int16_t)(k == 1 ? -300 : k == 2 ? 300 : 0);
        c.at[k].v_q8 = (int16_t)(k == 3 ? -300 : k == 4 ? 300 : 0);
    }
    assert_int_equal(plfx_plan_init(&plan, &c, &lut, NX, NY), PLFX_OK);
    fake_reset();
}

static plfx_cl_input input_of(void)
{
    plfx_cl_input in;

    memset(&in, 0, sizeof in);
    in.lut = &lut;
    in.format = PLFX_RAW_U16LE;
    in.bits = 12;
    in.tone = plfx_tone_unity(10);
    in.optics = &optics;
    return in;
}

static void core_goes_on(void)
{
    plfx_views v = {samples, NX, NY, 5};

    assert_in_range(plfx_sweep_ws(&plan), 1, sizeof work);
    assert_int_equal(plfx_sweep(&plan, &v, &map, work, sizeof work), PLFX_OK);
}

/* Open, two frames in flight, both fetched: the first status that is not OK. */
static plfx_status whole_life(void)
{
    plfx_cl_input in = input_of();
    plfx_status status = plfx_cl_open(&cl, 0, &plan, &in);

    status = status ? status : plfx_cl_submit(&cl, frame, sizeof frame);
    status = status ? status : plfx_cl_submit(&cl, frame, sizeof frame);
    status = status ? status : plfx_cl_fetch_depth(&cl, &map, um);
    return status ? status : plfx_cl_fetch(&cl, &map);
}

static void every_call_may_fail(void **state)
{
    static const uint8_t list[][2] = {{PLFX_METHOD_SWEEP, PLFX_COST_SAD},
                                      {PLFX_METHOD_PAIRS, PLFX_COST_SAD},
                                      {PLFX_METHOD_PAIRS, PLFX_COST_ZNCC}};
    size_t m;
    int32_t k;

    (void)state;
    for (m = 0; m < sizeof list / sizeof list[0]; m++) {
        int32_t calls;
        prepare(list[m][0], list[m][1]);
        assert_int_equal(whole_life(), PLFX_OK);
        calls = fake.calls;
        plfx_cl_close(&cl);
        assert_int_equal(fake.held, 0);
        for (k = 1; k <= calls; k++) {
            fake_reset();
            fake.fail_at = k;
            assert_true(whole_life() < 0);
            assert_true(cl.message[0] != 0);
            plfx_cl_close(&cl);
            assert_int_equal(fake.held, 0);
            assert_int_equal(fake.used, 0);
        }
        print_message("# method %d cost %d: each of %d calls failed once\n", list[m][0],
                      list[m][1], (int)calls);
        if (list[m][0] != PLFX_METHOD_GRADIENT) {
            core_goes_on();
        }
    }
}

static void memory_has_a_limit(void **state)
{
    plfx_cl_input in = input_of();
    uint64_t bytes;

    (void)state;
    prepare(PLFX_METHOD_SWEEP, PLFX_COST_SAD);
    in = input_of();
    bytes = plfx_cl_bytes(&plan, &in);
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_OK);
    assert_int_equal(fake.used, bytes); /* told beforehand, to the byte */
    assert_int_equal(cl.bytes, bytes);
    plfx_cl_close(&cl);
    fake.told = bytes - 1; /* the device says so */
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_E_SIZE);
    assert_non_null(strstr(cl.message, "too little memory"));
    fake.told = bytes; /* it only finds out */
    fake.memory = bytes - 1;
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_E_SIZE);
    assert_non_null(strstr(cl.message, "cannot take device memory"));
    assert_int_equal(fake.held, 0);
    fake.memory = bytes;
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_OK);
    plfx_cl_close(&cl);
    core_goes_on();
}

static void kernels_may_not_build(void **state)
{
    plfx_cl_input in = input_of();

    (void)state;
    prepare(PLFX_METHOD_SWEEP, PLFX_COST_SAD);
    fake.build_error = CL_BUILD_PROGRAM_FAILURE;
    in = input_of();
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_E_DEVICE);
    assert_string_equal(
        cl.message, "cannot build the kernels: OpenCL error -11 "
                    "(can the driver write its kernel cache?): line 7: no such word");
    assert_int_equal(fake.held, 0);
    core_goes_on();
}

/* Lost with a frame in flight: submit and fetch say so, closing gives all back. */
static void device_may_be_lost(void **state)
{
    plfx_cl_input in = input_of();

    (void)state;
    prepare(PLFX_METHOD_PAIRS, PLFX_COST_ZNCC);
    in = input_of();
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_OK);
    assert_int_equal(plfx_cl_submit(&cl, frame, sizeof frame), PLFX_OK);
    fake.lost = 1;
    assert_int_equal(plfx_cl_submit(&cl, frame, sizeof frame), PLFX_E_DEVICE);
    assert_non_null(strstr(cl.message, "cannot start a frame: OpenCL error -2"));
    assert_int_equal(plfx_cl_fetch(&cl, &map), PLFX_E_DEVICE);
    assert_non_null(strstr(cl.message, "cannot fetch a frame: OpenCL error -2"));
    assert_int_equal(plfx_cl_fetch(&cl, &map), PLFX_E_STATE);
    plfx_cl_close(&cl);
    assert_int_equal(fake.held, 0);
    core_goes_on();
}

static void absence_is_explained(void **state)
{
    plfx_cl_input in = input_of();
    char message[256];

    (void)state;
    prepare(PLFX_METHOD_SWEEP, PLFX_COST_SAD);
    in = input_of();
    assert_int_equal(plfx_cl_look(message, sizeof message), PLFX_OK);
    assert_string_equal(message, "");
    assert_int_equal(plfx_cl_look(NULL, 1), PLFX_E_ARG);
    fake.platforms = 0;
    assert_int_equal(plfx_cl_devices(), 0);
    assert_int_equal(plfx_cl_look(message, sizeof message), PLFX_E_DEVICE);
    assert_string_equal(message, "no OpenCL driver here");
    assert_true(plfx_cl_open(&cl, 0, &plan, &in) < 0);
    assert_string_equal(cl.message, "no OpenCL driver here");
    fake.platforms = 1; /* a driver that cannot write its cache lists no device */
    fake.devices = 0;
    fake.list_error = CL_DEVICE_NOT_FOUND;
    assert_int_equal(plfx_cl_look(message, sizeof message), PLFX_E_DEVICE);
    assert_non_null(strstr(message, "Fake is here but lists no device"));
    assert_non_null(strstr(message, "kernel cache"));
    fake_reset();
    assert_int_equal(plfx_cl_open(&cl, 1, &plan, &in), PLFX_E_ARG);
    assert_string_equal(cl.message, "no such OpenCL device");
}

/* 64 work-items a group, and fewer; one upload and one download a frame. */
static void small_devices_do(void **state)
{
    static const uint32_t groups[] = {1, 63, 64, 256, 4096};
    size_t k;

    (void)state;
    for (k = 0; k < sizeof groups / sizeof groups[0]; k++) {
        plfx_cl_input in = input_of();
        prepare(PLFX_METHOD_PAIRS, PLFX_COST_ZNCC);
        fake.group = groups[k];
        in = input_of();
        assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_OK);
        fake.up = fake.down = 0;
        assert_int_equal(plfx_cl_submit(&cl, frame, sizeof frame), PLFX_OK);
        assert_int_equal(plfx_cl_fetch_depth(&cl, &map, um), PLFX_OK);
        assert_int_equal(fake.up, sizeof frame);
        assert_int_equal(fake.down, 11 * NX * NY);
        assert_true(fake.launches > 0 && fake.largest <= groups[k]);
        plfx_cl_close(&cl);
    }
}

/* Another tone and range in the same context; another kind of frame is refused. */
static void contexts_are_retuned(void **state)
{
    plfx_cl_input in;
    plfx_plan other;
    int32_t held;

    (void)state;
    prepare(PLFX_METHOD_SWEEP, PLFX_COST_SAD);
    in = input_of();
    assert_int_equal(plfx_cl_retune(&cl, &plan, &in), PLFX_E_ARG); /* not open */
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_OK);
    held = fake.held;
    in.tone.gain_q12 = 5000;
    other = plan;
    other.cfg.texture = 77;
    assert_int_equal(plfx_cl_retune(&cl, &other, &in), PLFX_OK);
    assert_int_equal(fake.held, held);
    assert_int_equal(cl.params[CL_TEXTURE], 77);
    assert_int_equal(cl.params[CL_GAIN], 5000);
    assert_int_equal(plfx_cl_submit(&cl, frame, sizeof frame), PLFX_OK);
    assert_int_equal(plfx_cl_retune(&cl, &plan, &in), PLFX_E_STATE);
    assert_int_equal(plfx_cl_fetch(&cl, &map), PLFX_OK);
    in.optics = NULL;
    assert_int_equal(plfx_cl_retune(&cl, &plan, &in), PLFX_E_ARG);
    in = input_of();
    in.format = PLFX_RAW_MONO12P;
    assert_int_equal(plfx_cl_retune(&cl, &plan, &in), PLFX_E_ARG);
    other.cfg.labels++;
    in = input_of();
    assert_int_equal(plfx_cl_retune(&cl, &other, &in), PLFX_E_ARG);
    plfx_cl_close(&cl);
    assert_int_equal(fake.held, 0);
}

static void plans_and_frames_must_fit(void **state)
{
    plfx_cl_input in = input_of();
    plfx_plan none;

    (void)state;
    prepare(PLFX_METHOD_SWEEP, PLFX_COST_SAD);
    in = input_of();
    none = plan;
    none.cfg.n = 0; /* zero views */
    assert_int_equal(plfx_cl_open(&cl, 0, &none, &in), PLFX_E_ARG);
    assert_int_equal(plfx_cl_bytes(&none, &in), 0);
    none = plan;
    none.nx--; /* not the table's lenses */
    assert_int_equal(plfx_cl_open(&cl, 0, &none, &in), PLFX_E_ARG);
    in.bits = 7;
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_E_ARG);
    in = input_of();
    in.tone.bits = 9; /* not the plan's */
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_E_ARG);
    in = input_of();
    in.optics = NULL;
    assert_int_equal(plfx_cl_open(&cl, 0, &plan, &in), PLFX_OK);
    assert_int_equal(plfx_cl_submit(&cl, frame, sizeof frame - 1), PLFX_E_SIZE);
    assert_int_equal(plfx_cl_submit(&cl, frame, sizeof frame), PLFX_OK);
    assert_int_equal(plfx_cl_fetch_depth(&cl, &map, um), PLFX_E_ARG); /* no optics */
    assert_int_equal(plfx_cl_fetch(&cl, &map), PLFX_OK);
    plfx_cl_close(&cl);
    assert_int_equal(fake.held, 0);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(every_call_may_fail),
    cmocka_unit_test(memory_has_a_limit),
    cmocka_unit_test(kernels_may_not_build),
    cmocka_unit_test(device_may_be_lost),
    cmocka_unit_test(absence_is_explained),
    cmocka_unit_test(small_devices_do),
    cmocka_unit_test(contexts_are_retuned),
    cmocka_unit_test(plans_and_frames_must_fit),
};

SUITE(tests)
