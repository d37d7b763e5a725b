/* SPDX-License-Identifier: MIT
 * The video port against the kernel's vivid driver, run as the only program of an
 * emulated machine.  /dev/video1 shows frames that this program makes, /dev/video0
 * takes them back through the port.  Speaks TAP. */
#define _DEFAULT_SOURCE
#include "v4l2/v4l2.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#define OUTPUT  V4L2_BUF_TYPE_VIDEO_OUTPUT
#define BUFFERS 4u
#define W       1280
#define H       720

static int screen = -1;
static uint8_t *shown[BUFFERS];
static uint32_t shown_size;
static int number, failures;

static void verdict(int ok, const char *what)
{
    printf("%s %d - %s\n", ok ? "ok" : "not ok", ++number, what);
    failures += !ok;
}

/* Set a control by its name. */
static int control(int file, const char *name, int32_t value)
{
    struct v4l2_queryctrl q;
    struct v4l2_control c;

    memset(&q, 0, sizeof q);
    q.id = V4L2_CTRL_FLAG_NEXT_CTRL;
    while (ioctl(file, VIDIOC_QUERYCTRL, &q) == 0) { /* at most once a control */
        if (strcmp((const char *)q.name, name) == 0) {
            c.id = q.id;
            c.value = value;
            return ioctl(file, VIDIOC_S_CTRL, &c);
        }
        q.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
    }
    return -1;
}

static int set_screen(uint32_t code)
{
    struct v4l2_format f;
    struct v4l2_requestbuffers r;

    memset(&f, 0, sizeof f);
    f.type = OUTPUT;
    if (ioctl(screen, VIDIOC_G_FMT, &f) != 0) {
        return -1;
    }
    f.fmt.pix.pixelformat = code;
    f.fmt.pix.field = V4L2_FIELD_NONE;
    f.fmt.pix.bytesperline = 0;
    if (ioctl(screen, VIDIOC_S_FMT, &f) != 0 || f.fmt.pix.pixelformat != code ||
        f.fmt.pix.width != W || f.fmt.pix.height != H) {
        return -1;
    }
    shown_size = f.fmt.pix.sizeimage;
    memset(&r, 0, sizeof r);
    r.count = BUFFERS;
    r.type = OUTPUT;
    r.memory = V4L2_MEMORY_MMAP;
    return ioctl(screen, VIDIOC_REQBUFS, &r) == 0 && r.count == BUFFERS ? 0 : -1;
}

static int queue_screen(uint32_t k)
{
    struct v4l2_buffer b;

    memset(&b, 0, sizeof b);
    b.index = k;
    b.type = OUTPUT;
    b.memory = V4L2_MEMORY_MMAP;
    b.bytesused = shown_size;
    b.field = V4L2_FIELD_NONE;
    return ioctl(screen, VIDIOC_QBUF, &b);
}

/* The same random bytes in every buffer, then on. */
static int show(uint32_t code)
{
    struct v4l2_buffer b;
    uint32_t random = code;
    int type = OUTPUT;
    uint32_t k;
    uint32_t i;

    if (set_screen(code) != 0) {
        return -1;
    }
    for (k = 0; k < BUFFERS; k++) {
        memset(&b, 0, sizeof b);
        b.index = k;
        b.type = OUTPUT;
        b.memory = V4L2_MEMORY_MMAP;
        if (ioctl(screen, VIDIOC_QUERYBUF, &b) != 0) {
            return -1;
        }
        shown[k] = mmap(NULL, b.length, PROT_READ | PROT_WRITE, MAP_SHARED, screen,
                        (off_t)b.m.offset);
        if (shown[k] == MAP_FAILED) {
            return -1;
        }
        for (i = 0; k == 0 && i < shown_size; i++) {
            random = random * 1664525u + 1013904223u;
            shown[0][i] = (uint8_t)(random >> 24);
        }
        memcpy(shown[k], shown[0], shown_size);
        if (queue_screen(k) != 0) {
            return -1;
        }
    }
    return ioctl(screen, VIDIOC_STREAMON, &type);
}

static void hide(void)
{
    struct v4l2_requestbuffers r;
    int type = OUTPUT;
    uint32_t k;

    (void)ioctl(screen, VIDIOC_STREAMOFF, &type);
    for (k = 0; k < BUFFERS; k++) {
        (void)munmap(shown[k], shown_size);
    }
    memset(&r, 0, sizeof r);
    r.type = OUTPUT;
    r.memory = V4L2_MEMORY_MMAP;
    (void)ioctl(screen, VIDIOC_REQBUFS, &r);
}

/* Give back what was shown, so that the loop does not run dry. */
static void go_on_showing(void)
{
    struct v4l2_buffer b;

    memset(&b, 0, sizeof b);
    b.type = OUTPUT;
    b.memory = V4L2_MEMORY_MMAP;
    if (ioctl(screen, VIDIOC_DQBUF, &b) == 0) {
        (void)queue_screen(b.index);
    }
}

/* The sensor takes the timing of what it is shown. */
static int tune(void)
{
    struct v4l2_dv_timings t;
    int file = open("/dev/video0", O_RDWR);
    int input = 0;
    int failed;

    (void)ioctl(file, VIDIOC_S_INPUT, &input);
    failed =
        control(file, "OSD Text Mode", 2) != 0 || control(file, "Loop Video", 1) != 0;
    memset(&t, 0, sizeof t);
    if (ioctl(file, VIDIOC_QUERY_DV_TIMINGS, &t) == 0) {
        failed |= ioctl(file, VIDIOC_S_DV_TIMINGS, &t) != 0;
    }
    (void)close(file);
    return failed ? -1 : 0;
}

static plfx_status start(plfx_v4l2 *v, uint8_t format, uint8_t bits, uint8_t bayer)
{
    static uint8_t memory[64];
    plfx_pool pool = {memory, sizeof memory, 4};
    plfx_camera_cfg cfg;
    plfx_status status;

    memset(&cfg, 0, sizeof cfg);
    cfg.w = W;
    cfg.h = H;
    cfg.format = format;
    cfg.bits = bits;
    cfg.bayer = bayer;
    cfg.gain_mdb = INT32_MIN;
    plfx_v4l2_init(v, "/dev/video0");
    status = v->camera.open(v, &cfg, &pool);
    return status == PLFX_OK ? v->camera.start(v) : status;
}

static void bytes_loop_exactly(const char *name, uint8_t format, uint8_t bits,
                               uint8_t bayer)
{
    plfx_v4l2 v;
    plfx_camera_frame f;
    int good = 0;
    int exact = 0;
    int k;

    if (show(plfx_v4l2_code(format, bits, bayer)) != 0 || tune() != 0 ||
        start(&v, format, bits, bayer) != PLFX_OK) {
        printf("# errno %d, port %d\n", errno, v.error);
        verdict(0, name);
        return;
    }
    for (k = 0; k < 8; k++) {
        go_on_showing();
        if (v.camera.acquire(&v, 2000, &f) == PLFX_OK) {
            good++;
            /* the first frames may be from before the screen was on */
            exact += f.raw.size == plfx_raw_bytes(format, W, H) &&
                     memcmp(f.raw.bytes, shown[0], f.raw.size) == 0;
            (void)v.camera.release(&v, &f);
        }
    }
    printf("# %s: %d frames, %d exact\n", name, good, exact);
    verdict(good == 8 && exact >= 6, name);
    (void)v.camera.stop(&v);
    v.camera.close(&v);
    hide();
}

/* Frames until `n` good ones came or two seconds passed without. */
static plfx_status take(plfx_v4l2 *v, int n)
{
    plfx_camera_frame f;
    plfx_status status = PLFX_OK;

    while (n-- > 0 && status == PLFX_OK) { /* at most n rounds */
        status = v->camera.acquire(v, 2000, &f);
        if (status == PLFX_OK) {
            status = v->camera.release(v, &f);
        }
    }
    return status;
}

/* Frames until one more is counted as broken, at most 30: a fault meets buffers that
 * the driver has not filled yet. */
static int broken_after(plfx_v4l2 *v, uint64_t before)
{
    plfx_camera_count now;
    int k;

    for (k = 0; k < 30 && take(v, 1) == PLFX_OK; k++) {
        v->camera.count(v, &now);
        if (now.incomplete > before) {
            return take(v, 2) == PLFX_OK;
        }
    }
    return 0;
}

static void faults_are_counted(void)
{
    plfx_camera_count before;
    plfx_camera_count after;
    plfx_v4l2 v;

    if (start(&v, PLFX_RAW_U8, 8, 0) != PLFX_OK || take(&v, 2) != PLFX_OK) {
        verdict(0, "faults: camera");
        return;
    }
    v.camera.count(&v, &before);
    verdict(control(v.file, "Inject V4L2_BUF_FLAG_ERROR", 1) == 0 &&
                broken_after(&v, before.incomplete),
            "a frame that is marked broken is counted, and frames go on");
    v.camera.count(&v, &after);
    verdict(control(v.file, "Percentage of Dropped Buffers", 50) == 0 &&
                take(&v, 20) == PLFX_OK,
            "frames go on while every second one is dropped");
    v.camera.count(&v, &before);
    verdict(before.missed > after.missed, "the dropped ones are counted");
    (void)control(v.file, "Percentage of Dropped Buffers", 0);
    (void)v.camera.stop(&v);
    (void)control(v.file, "Inject VIDIOC_STREAMON Error", 1);
    verdict(v.camera.start(&v) == PLFX_E_DEVICE && v.camera.start(&v) == PLFX_OK,
            "a start that fails can be repeated");
    verdict(take(&v, 2) == PLFX_OK && control(v.file, "Disconnect", 1) == 0 &&
                take(&v, 10) == PLFX_E_DEVICE,
            "a camera that is unplugged is named");
    v.camera.close(&v);
    plfx_v4l2_init(&v, "/dev/video0");
}

int main(void)
{
    int output = 0;

    screen = open("/dev/video1", O_RDWR);
    if (screen < 0) {
        printf("Bail out! no vivid driver: %s\n", strerror(errno));
        return 1;
    }
    (void)ioctl(screen, VIDIOC_S_OUTPUT, &output);
    bytes_loop_exactly("GREY, byte for byte", PLFX_RAW_U8, 8, 0);
    bytes_loop_exactly("Y10, byte for byte", PLFX_RAW_U16LE, 10, 0);
    bytes_loop_exactly("Y12, byte for byte", PLFX_RAW_U16LE, 12, 0);
    bytes_loop_exactly("Y16, byte for byte", PLFX_RAW_U16LE, 16, 0);
    bytes_loop_exactly("RG12, byte for byte", PLFX_RAW_U16LE, 12, PLFX_BAYER_RGGB);
    faults_are_counted();
    printf("1..%d\n", number);
    return failures != 0;
}
