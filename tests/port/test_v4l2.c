/* SPDX-License-Identifier: MIT
 * What of the video port can be tested without a video device. */
#define _DEFAULT_SOURCE
#include "../unit/suite.h"
#include "v4l2/v4l2.h"

#include <errno.h>
#include <linux/videodev2.h>

static void codes_are_those_of_the_kernel(void **state)
{
    static const uint32_t kernel[][4] = {
        {V4L2_PIX_FMT_GREY, PLFX_RAW_U8, 8, 0},
        {V4L2_PIX_FMT_Y10, PLFX_RAW_U16LE, 10, 0},
        {V4L2_PIX_FMT_Y12, PLFX_RAW_U16LE, 12, 0},
        {V4L2_PIX_FMT_Y16, PLFX_RAW_U16LE, 16, 0},
        {V4L2_PIX_FMT_Y10P, PLFX_RAW_CSI10, 10, 0},
        {V4L2_PIX_FMT_SRGGB12, PLFX_RAW_U16LE, 12, PLFX_BAYER_RGGB},
        {V4L2_PIX_FMT_SGRBG12, PLFX_RAW_U16LE, 12, PLFX_BAYER_GRBG},
        {V4L2_PIX_FMT_SBGGR8, PLFX_RAW_U8, 8, PLFX_BAYER_BGGR},
        {V4L2_PIX_FMT_SBGGR16, PLFX_RAW_U16LE, 16, PLFX_BAYER_BGGR},
        {V4L2_PIX_FMT_SGRBG10P, PLFX_RAW_CSI10, 10, PLFX_BAYER_GRBG},
        {V4L2_PIX_FMT_SGBRG12P, PLFX_RAW_CSI12, 12, PLFX_BAYER_GBRG}};
    uint8_t format;
    uint8_t bits;
    uint8_t bayer;
    size_t k;

    (void)state;
    for (k = 0; k < sizeof kernel / sizeof kernel[0]; k++) {
        assert_int_equal(plfx_v4l2_code((uint8_t)kernel[k][1], (uint8_t)kernel[k][2],
                                        (uint8_t)kernel[k][3]),
                         kernel[k][0]);
        assert_int_equal(plfx_v4l2_find(kernel[k][0], &format, &bits, &bayer), 0);
        assert_int_equal(format, kernel[k][1]);
        assert_int_equal(bits, kernel[k][2]);
        assert_int_equal(bayer, kernel[k][3]);
    }
    assert_int_equal(plfx_v4l2_find(V4L2_PIX_FMT_YUYV, &format, &bits, &bayer), -1);
    assert_int_equal(plfx_v4l2_code(PLFX_RAW_MONO12P, 12, 0), 0);
}

static void absent_and_foreign_devices_are_named(void **state)
{
    static uint8_t memory[2 * 64];
    plfx_pool pool = {memory, 64, 2};
    plfx_camera_cfg cfg;
    plfx_v4l2 v;
    plfx_camera_frame f;

    (void)state;
    memset(&cfg, 0, sizeof cfg);
    plfx_v4l2_init(&v, "/dev/video_absent");
    assert_int_equal(v.camera.open(&v, &cfg, &pool), PLFX_E_DEVICE);
    assert_int_equal(v.error, ENOENT);
    plfx_v4l2_init(&v, "/dev/null"); /* a device, but no camera */
    assert_int_equal(v.camera.open(&v, &cfg, &pool), PLFX_E_DEVICE);
    assert_int_equal(v.error, ENOTTY);
    pool.slots = 1;
    assert_int_equal(v.camera.open(&v, &cfg, &pool), PLFX_E_ARG);
    assert_int_equal(v.camera.start(&v), PLFX_E_STATE);
    assert_int_equal(v.camera.acquire(&v, 0, &f), PLFX_E_STATE);
    assert_int_equal(v.camera.stop(&v), PLFX_E_STATE);
    v.camera.close(&v);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(codes_are_those_of_the_kernel),
    cmocka_unit_test(absent_and_foreign_devices_are_named),
};

SUITE(tests)
