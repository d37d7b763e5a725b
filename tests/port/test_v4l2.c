/* SPDX-License-Identifier: MIT
 * The video port without a video device: a driver of the test's own answers its ioctls
 * (the linker's --wrap), over a plain file that both map. */
#define _DEFAULT_SOURCE
#include "../unit/suite.h"
#include "scratch.h"
#include "v4l2/v4l2.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#define BUFFERS 4u
#define ROOM    8192u /* bytes of a buffer; a multiple of the page */
#define W       24
#define H       10
#define FILLER  0xee

int __real_ioctl(int file, unsigned long request, ...);
int __wrap_ioctl(int file, unsigned long request, ...);

/* The driver: buffers are filled in the order in which they were queued. */
static struct driver {
    int on; /* 0: ioctls go to the kernel */
    int file;
    uint32_t w, h, code, stride, align, force_w;
    uint32_t queue[64], head, tail;
    uint32_t number;                 /* sequence of the next frame */
    uint32_t broken, cut, unplugged; /* the next frame; at once */
    uint32_t flags;                  /* of time stamps */
    int64_t time_us;
    int32_t exposure, gain, automatic;
    struct v4l2_fract period;
    uint8_t queued[BUFFERS]; /* 1: the driver's */
    uint32_t count, when;    /* ioctls so far; the one that fails */
    int how;                 /* FAIL_... */
} d;

enum { FAIL_NEVER, FAIL_ONCE, FAIL_EVER, FAIL_SIGNAL };

static uint32_t bits_of(uint32_t code)
{
    uint8_t format = 0;
    uint8_t bits = 0;
    uint8_t bayer = 0;

    return plfx_v4l2_find(code, &format, &bits, &bayer) == 0
               ? (uint32_t)plfx_raw_bpp(format)
               : 16u;
}

static uint8_t byte_at(uint32_t number, uint32_t y, uint32_t x)
{
    return (uint8_t)((number * 31u + y * 7u + x) * 2654435761u >> 24);
}

static void fill_buffer(uint32_t index)
{
    static uint8_t b[ROOM];
    uint32_t row = d.w * bits_of(d.code) / 8u;
    uint32_t y;
    uint32_t x;

    memset(b, FILLER, sizeof b);
    for (y = 0; y < d.h; y++) {
        for (x = 0; x < row; x++) {
            b[y * d.stride + x] = byte_at(d.number, y, x);
        }
    }
    assert_int_equal(pwrite(d.file, b, sizeof b, (off_t)index * ROOM),
                     (ssize_t)sizeof b);
}

static int fail_with(int error)
{
    errno = error;
    return -1;
}

static int on_format(struct v4l2_format *f, int set)
{
    struct v4l2_pix_format *p = &f->fmt.pix;

    if (set) {
        d.w = d.force_w ? d.force_w : p->width;
        d.h = p->height;
        d.code = p->pixelformat;
        d.stride = (d.w * bits_of(d.code) / 8u + d.align - 1u) / d.align * d.align;
    }
    p->width = d.w;
    p->height = d.h;
    p->pixelformat = d.code;
    p->bytesperline = d.stride;
    p->sizeimage = d.stride * d.h;
    return 0;
}

static int on_dequeue(struct v4l2_buffer *b)
{
    if (d.unplugged) {
        return fail_with(ENODEV);
    }
    if (d.head == d.tail) {
        return fail_with(EAGAIN);
    }
    b->index = d.queue[d.head++ % 64u];
    d.queued[b->index] = 0;
    fill_buffer(b->index);
    b->sequence = d.number++;
    b->flags = d.flags | (d.broken ? V4L2_BUF_FLAG_ERROR : 0u);
    b->bytesused = d.stride * d.h - (d.cut ? d.stride : 0u);
    b->timestamp.tv_sec = d.time_us / 1000000;
    b->timestamp.tv_usec = d.time_us % 1000000;
    d.time_us += 10000;
    d.broken = d.cut = 0;
    return 0;
}

/* A buffer that is queued already is refused, as by the kernel. */
static int on_queue(const struct v4l2_buffer *b)
{
    if (d.unplugged || d.queued[b->index]) {
        return fail_with(d.unplugged ? ENODEV : EINVAL);
    }
    d.queued[b->index] = 1;
    d.queue[d.tail++ % 64u] = b->index;
    return 0;
}

static int on_control(const struct v4l2_control *c)
{
    switch (c->id) {
    case V4L2_CID_EXPOSURE_AUTO:
        d.automatic = c->value;
        return 0;
    case V4L2_CID_EXPOSURE_ABSOLUTE:
        d.exposure = c->value;
        return 0;
    case V4L2_CID_GAIN:
        d.gain = c->value;
        return 0;
    default:
        return fail_with(EINVAL);
    }
}

static int answer(unsigned long request, void *p)
{
    switch (request) {
    case VIDIOC_QUERYCAP:
        ((struct v4l2_capability *)p)->capabilities =
            V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        return 0;
    case VIDIOC_G_FMT:
        return on_format(p, 0);
    case VIDIOC_S_FMT:
        return on_format(p, 1);
    case VIDIOC_S_CTRL:
        return on_control(p);
    case VIDIOC_S_PARM:
        d.period = ((struct v4l2_streamparm *)p)->parm.capture.timeperframe;
        return 0;
    case VIDIOC_REQBUFS:
        ((struct v4l2_requestbuffers *)p)->count = BUFFERS;
        return 0;
    case VIDIOC_QUERYBUF:
        ((struct v4l2_buffer *)p)->length = ROOM;
        ((struct v4l2_buffer *)p)->m.offset = ((struct v4l2_buffer *)p)->index * ROOM;
        return 0;
    case VIDIOC_QBUF:
        return on_queue(p);
    case VIDIOC_DQBUF:
        return on_dequeue(p);
    case VIDIOC_STREAMON:
        return 0;
    case VIDIOC_STREAMOFF:
        d.head = d.tail = 0;
        memset(d.queued, 0, sizeof d.queued);
        return 0;
    default:
        return fail_with(ENOTTY);
    }
}

/* Shall this ioctl come to grief? */
static int grief(void)
{
    uint32_t now = d.count++;

    return d.how == FAIL_EVER ? now >= d.when : d.how != FAIL_NEVER && now == d.when;
}

int __wrap_ioctl(int file, unsigned long request, ...)
{
    va_list list;
    void *argument;

    va_start(list, request);
    argument = va_arg(list, void *);
    va_end(list);
    if (d.on && grief()) {
        return fail_with(d.how == FAIL_SIGNAL ? EINTR : EIO);
    }
    return d.on ? answer(request, argument) : __real_ioctl(file, request, argument);
}

static uint8_t pool_bytes[BUFFERS * ROOM];

static plfx_camera_cfg wish(uint8_t format, uint8_t bits, uint8_t bayer)
{
    plfx_camera_cfg c;

    memset(&c, 0, sizeof c);
    c.w = W;
    c.h = H;
    c.format = format;
    c.bits = bits;
    c.bayer = bayer;
    c.gain_mdb = INT32_MIN;
    return c;
}

/* A driver that pads rows to `align` bytes. */
static void drive(plfx_v4l2 *v, uint32_t align)
{
    static char path[384];

    (void)snprintf(path, sizeof path, "%s", scratch("video"));
    memset(&d, 0, sizeof d);
    d.on = 1;
    d.align = align;
    d.w = 64;
    d.h = 48;
    d.code = V4L2_PIX_FMT_GREY;
    d.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    d.time_us = 5000000;
    d.file = open(path, O_RDWR | O_CREAT, 0600);
    assert_true(d.file >= 0);
    assert_int_equal(ftruncate(d.file, (off_t)BUFFERS * ROOM), 0);
    plfx_v4l2_init(v, path);
}

static void start(plfx_v4l2 *v, uint32_t align, plfx_camera_cfg *cfg)
{
    plfx_pool pool = {pool_bytes, ROOM, (int32_t)BUFFERS};

    drive(v, align);
    assert_int_equal(v->camera.open(v, cfg, &pool), PLFX_OK);
    assert_int_equal(v->camera.start(v), PLFX_OK);
}

static void end(plfx_v4l2 *v)
{
    (void)v->camera.stop(v);
    v->camera.close(v);
    (void)close(d.file);
    d.on = 0;
}

static int in_pool(const plfx_camera_frame *f)
{
    return f->raw.bytes >= pool_bytes && f->raw.bytes < pool_bytes + sizeof pool_bytes;
}

static void check_rows(const plfx_camera_frame *f, uint32_t number)
{
    uint32_t row = (uint32_t)W * (uint32_t)plfx_raw_bpp(f->raw.format) / 8u;
    uint32_t i;

    assert_int_equal(f->raw.size, row * H);
    for (i = 0; i < row * H; i++) {
        assert_int_equal(f->raw.bytes[i], byte_at(number, i / row, i % row));
    }
}

/* Unpadded rows stay in the driver's memory; padding is taken out into the pool. */
static void every_format_comes_without_padding(void **state)
{
    static const uint8_t list[][3] = {
        {PLFX_RAW_U8, 8, PLFX_BAYER_NONE},     {PLFX_RAW_U8, 8, PLFX_BAYER_GBRG},
        {PLFX_RAW_U16LE, 10, PLFX_BAYER_NONE}, {PLFX_RAW_U16LE, 12, PLFX_BAYER_NONE},
        {PLFX_RAW_U16LE, 12, PLFX_BAYER_RGGB}, {PLFX_RAW_U16LE, 16, PLFX_BAYER_NONE},
        {PLFX_RAW_CSI10, 10, PLFX_BAYER_NONE}, {PLFX_RAW_CSI10, 10, PLFX_BAYER_RGGB},
        {PLFX_RAW_CSI12, 12, PLFX_BAYER_NONE}, {PLFX_RAW_CSI12, 12, PLFX_BAYER_BGGR}};
    size_t k;
    uint32_t padded;
    uint32_t n;

    (void)state;
    for (k = 0; k < 2u * sizeof list / sizeof list[0]; k++) {
        plfx_camera_cfg cfg = wish(list[k / 2][0], list[k / 2][1], list[k / 2][2]);
        plfx_v4l2 v;
        padded = k % 2u;
        start(&v, padded ? 64 : 1, &cfg);
        for (n = 0; n < 9; n++) { /* twice round the buffers */
            plfx_camera_frame f;
            assert_int_equal(v.camera.acquire(&v, 100, &f), PLFX_OK);
            assert_int_equal(f.sequence, n + 1);
            assert_int_equal(in_pool(&f), padded);
            assert_int_equal(f.bayer, list[k / 2][2]);
            assert_int_equal(f.clock, PLFX_CLOCK_MONOTONIC);
            check_rows(&f, n);
            assert_int_equal(v.camera.release(&v, &f), PLFX_OK);
            assert_int_equal(v.camera.release(&v, &f), PLFX_E_ARG);
        }
        end(&v);
    }
}

static plfx_camera_count counted(plfx_v4l2 *v)
{
    plfx_camera_count n;

    v->camera.count(v, &n);
    return n;
}

static plfx_camera_frame next(plfx_v4l2 *v)
{
    plfx_camera_frame f;

    assert_int_equal(v->camera.acquire(v, 100, &f), PLFX_OK);
    assert_int_equal(v->camera.release(v, &f), PLFX_OK);
    return f;
}

static void faults_are_counted_and_survived(void **state)
{
    plfx_camera_cfg cfg = wish(PLFX_RAW_CSI12, 12, PLFX_BAYER_NONE);
    plfx_camera_frame f[BUFFERS];
    plfx_v4l2 v;
    uint32_t k;

    (void)state;
    start(&v, 64, &cfg);
    (void)next(&v);
    d.broken = 1;
    f[0] = next(&v);
    assert_int_equal(f[0].dropped, 1);
    assert_int_equal(counted(&v).incomplete, 1);
    d.cut = 1;
    assert_int_equal(next(&v).dropped, 1);
    assert_int_equal(counted(&v).misfit, 1);
    d.number += 3;
    assert_int_equal(next(&v).dropped, 3);
    assert_int_equal(counted(&v).missed, 3);
    d.time_us -= 1000000;
    (void)next(&v);
    assert_int_equal(counted(&v).back, 1);
    d.number = UINT32_MAX; /* the driver's number wraps: frames go on */
    (void)next(&v);
    assert_int_equal(next(&v).dropped, 0);
    for (k = 0; k < BUFFERS; k++) {
        assert_int_equal(v.camera.acquire(&v, 100, &f[k]), PLFX_OK);
    }
    assert_int_equal(v.camera.acquire(&v, 0, &f[0]), PLFX_E_STATE);
    assert_int_equal(counted(&v).starved, 1);
    for (k = 0; k < BUFFERS; k++) {
        assert_int_equal(v.camera.release(&v, &f[k]), PLFX_OK);
    }
    d.unplugged = 1;
    assert_int_equal(v.camera.acquire(&v, 100, &f[0]), PLFX_E_DEVICE);
    assert_int_equal(v.error, ENODEV);
    end(&v);
}

/* The call, and when it fails the same again: the last answer. */
#define TWICE(call) ((call) == PLFX_OK ? PLFX_OK : (call))

/* Open to close with four frames; how many came. */
static uint32_t watch(plfx_v4l2 *v)
{
    plfx_pool pool = {pool_bytes, ROOM, (int32_t)BUFFERS};
    plfx_camera_cfg cfg = wish(PLFX_RAW_U8, 8, PLFX_BAYER_NONE);
    plfx_camera_frame f;
    uint32_t good = 0;
    uint32_t k;

    cfg.exposure_us = 4000;
    cfg.gain_mdb = 12000;
    cfg.rate_mhz = 50000;
    if (TWICE(v->camera.open(v, &cfg, &pool)) != PLFX_OK) {
        assert_int_equal(v->file, -1);
        assert_int_equal(v->buffers, 0);
        return 0;
    }
    if (TWICE(v->camera.start(v)) == PLFX_OK) {
        assert_int_equal(d.exposure, 40);
        assert_int_equal(d.tail - d.head, BUFFERS);
        for (k = 0; k < 4; k++) {
            if (TWICE(v->camera.acquire(v, 50, &f)) != PLFX_OK) {
                break;
            }
            check_rows(&f, d.number - 1u);
            good++;
            if (TWICE(v->camera.release(v, &f)) != PLFX_OK) {
                break;
            }
        }
        (void)v->camera.stop(v);
    }
    v->camera.close(v);
    return good;
}

/* Every ioctl fails once, for ever, and is interrupted: a status, nothing held, and
 * the call that failed can be repeated. */
static void every_ioctl_may_fail(void **state)
{
    plfx_v4l2 v;
    uint32_t total;
    uint32_t when;
    int how;

    (void)state;
    drive(&v, 64);
    assert_int_equal(watch(&v), 4);
    total = d.count;
    (void)close(d.file);
    d.on = 0;
    assert_in_range(total, 20, 60);
    for (how = FAIL_ONCE; how <= FAIL_SIGNAL; how++) {
        for (when = 0; when < total; when++) {
            drive(&v, 64);
            d.how = how;
            d.when = when;
            assert_true(watch(&v) == 4 || how == FAIL_EVER);
            assert_int_equal(v.file, -1);
            (void)close(d.file);
            d.on = 0;
        }
    }
    print_message("# count: operations that failed, %u tried, 0 missed\n",
                  3u * (unsigned)total);
}

/* From the start of the exposure to its middle; civil time is said to be that. */
static void times_are_of_the_middle_of_the_exposure(void **state)
{
    plfx_camera_cfg cfg = wish(PLFX_RAW_U8, 8, PLFX_BAYER_NONE);
    plfx_camera_frame f;
    plfx_v4l2 v;

    (void)state;
    cfg.exposure_us = 4000;
    cfg.gain_mdb = 12000;
    cfg.rate_mhz = 50000;
    start(&v, 1, &cfg);
    assert_int_equal(d.automatic, V4L2_EXPOSURE_MANUAL);
    assert_int_equal(d.exposure, 40);
    assert_int_equal(d.gain, 12);
    assert_int_equal(d.period.denominator / d.period.numerator, 50);
    assert_int_equal(next(&v).time_ns / 1000u, 5000000u);
    d.flags |= V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    assert_int_equal(next(&v).time_ns / 1000u, 5012000u);
    d.flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
    f = next(&v);
    assert_int_equal(f.clock, PLFX_CLOCK_UTC);
    end(&v);
}

static void what_the_driver_changes_is_refused(void **state)
{
    plfx_camera_cfg cfg = wish(PLFX_RAW_U8, 8, PLFX_BAYER_NONE);
    plfx_pool pool = {pool_bytes, ROOM, (int32_t)BUFFERS};
    plfx_v4l2 v;

    (void)state;
    drive(&v, 1);
    d.force_w = 32; /* another size than was wished */
    assert_int_equal(v.camera.open(&v, &cfg, &pool), PLFX_E_ARG);
    d.force_w = 0;
    cfg.format = PLFX_RAW_MONO12P; /* no format of this interface */
    cfg.bits = 12;
    assert_int_equal(v.camera.open(&v, &cfg, &pool), PLFX_E_ARG);
    cfg = wish(PLFX_RAW_CSI12, 12, PLFX_BAYER_NONE);
    cfg.w = 23; /* a row that ends within a byte */
    assert_int_equal(v.camera.open(&v, &cfg, &pool), PLFX_E_ARG);
    cfg.w = W;
    d.align = 64; /* padding wants a pool */
    pool.slot_size = W * H;
    assert_int_equal(v.camera.open(&v, &cfg, &pool), PLFX_E_SIZE);
    pool.slot_size = ROOM;
    assert_int_equal(v.camera.open(&v, &cfg, &pool), PLFX_OK);
    end(&v);
}

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
    cmocka_unit_test(every_format_comes_without_padding),
    cmocka_unit_test(faults_are_counted_and_survived),
    cmocka_unit_test(every_ioctl_may_fail),
    cmocka_unit_test(times_are_of_the_middle_of_the_exposure),
    cmocka_unit_test(what_the_driver_changes_is_refused),
};

int main(void)
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, scratch_make, scratch_drop);
}
