/* SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "v4l2.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#define CAPTURE V4L2_BUF_TYPE_VIDEO_CAPTURE

/* ioctl that goes on after signals; keeps errno. */
static int call(plfx_v4l2 *v, unsigned long request, void *argument)
{
    int failed;

    do { /* at most once a signal */
        failed = ioctl(v->file, request, argument);
    } while (failed < 0 && errno == EINTR);
    if (failed < 0) {
        v->error = errno;
    }
    return failed;
}

static plfx_status gone_or(const plfx_v4l2 *v, plfx_status other)
{
    return v->error == ENODEV || v->error == ENXIO || v->error == EIO ? PLFX_E_DEVICE
                                                                      : other;
}

static int can_stream(plfx_v4l2 *v)
{
    struct v4l2_capability c;
    uint32_t caps;

    memset(&c, 0, sizeof c);
    if (call(v, VIDIOC_QUERYCAP, &c) < 0) {
        return 0;
    }
    caps = c.capabilities & V4L2_CAP_DEVICE_CAPS ? c.device_caps : c.capabilities;
    return (caps & V4L2_CAP_VIDEO_CAPTURE) && (caps & V4L2_CAP_STREAMING);
}

/* Agree on size and format; v->cfg becomes what holds. */
static plfx_status set_format(plfx_v4l2 *v)
{
    plfx_camera_cfg *c = &v->cfg;
    uint32_t code = c->bits ? plfx_v4l2_code(c->format, c->bits, c->bayer) : 0;
    struct v4l2_format f;
    struct v4l2_pix_format *p = &f.fmt.pix;

    memset(&f, 0, sizeof f);
    f.type = CAPTURE;
    if ((c->bits && code == 0) || call(v, VIDIOC_G_FMT, &f) < 0) {
        return code ? gone_or(v, PLFX_E_ARG) : PLFX_E_ARG;
    }
    p->width = c->w > 0 ? (uint32_t)c->w : p->width;
    p->height = c->h > 0 ? (uint32_t)c->h : p->height;
    p->pixelformat = code ? code : p->pixelformat;
    p->field = V4L2_FIELD_NONE;
    p->bytesperline = 0;
    if (call(v, VIDIOC_S_FMT, &f) < 0) {
        return gone_or(v, PLFX_E_ARG);
    }
    if ((code && p->pixelformat != code) || (c->w > 0 && p->width != (uint32_t)c->w) ||
        (c->h > 0 && p->height != (uint32_t)c->h) || p->width > 32767 ||
        p->height > 32767 ||
        plfx_v4l2_find(p->pixelformat, &c->format, &c->bits, &c->bayer) != 0) {
        return PLFX_E_ARG;
    }
    c->w = (int32_t)p->width;
    c->h = (int32_t)p->height;
    v->row = (uint32_t)plfx_raw_bytes(c->format, c->w, 1);
    v->stride = p->bytesperline;
    /* packed rows that do not end on a byte never come from a driver unpadded */
    return v->stride >= v->row &&
                   (uint32_t)c->w * (uint32_t)plfx_raw_bpp(c->format) % 8 == 0
               ? PLFX_OK
               : PLFX_E_ARG;
}

static int set_control(plfx_v4l2 *v, uint32_t id, int32_t value)
{
    struct v4l2_control c;

    c.id = id;
    c.value = value;
    return call(v, VIDIOC_S_CTRL, &c);
}

static plfx_status set_light(plfx_v4l2 *v)
{
    struct v4l2_control automatic = {V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL};
    struct v4l2_streamparm p;
    int failed = 0;

    if (v->cfg.exposure_us) { /* in units of 100 us */
        (void)call(v, VIDIOC_S_CTRL, &automatic);
        failed |= set_control(v, V4L2_CID_EXPOSURE_ABSOLUTE,
                              (int32_t)((v->cfg.exposure_us + 50) / 100));
        v->exposure_us = v->cfg.exposure_us;
    }
    if (v->cfg.gain_mdb != INT32_MIN) {
        failed |= set_control(v, V4L2_CID_GAIN, v->cfg.gain_mdb / 1000);
    }
    if (v->cfg.rate_mhz) {
        memset(&p, 0, sizeof p);
        p.type = CAPTURE;
        p.parm.capture.timeperframe.numerator = 1000;
        p.parm.capture.timeperframe.denominator = v->cfg.rate_mhz;
        failed |= call(v, VIDIOC_S_PARM, &p);
    }
    return failed < 0 ? gone_or(v, PLFX_E_ARG) : PLFX_OK;
}

static void describe(struct v4l2_buffer *b, uint32_t index)
{
    memset(b, 0, sizeof *b);
    b->index = index;
    b->type = CAPTURE;
    b->memory = V4L2_MEMORY_MMAP;
}

static plfx_status map_buffers(plfx_v4l2 *v)
{
    struct v4l2_requestbuffers request;
    struct v4l2_buffer b;
    uint32_t k;

    memset(&request, 0, sizeof request);
    request.count = (uint32_t)v->pool.slots;
    request.type = CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (call(v, VIDIOC_REQBUFS, &request) < 0) {
        return gone_or(v, PLFX_E_DEVICE);
    }
    for (k = 0; k < request.count && k < PLFX_V4L2_BUFFERS; k++) {
        void *at;
        describe(&b, k);
        if (call(v, VIDIOC_QUERYBUF, &b) < 0) {
            return PLFX_E_DEVICE;
        }
        at = mmap(NULL, b.length, PROT_READ | PROT_WRITE, MAP_SHARED, v->file,
                  (off_t)b.m.offset);
        if (at == MAP_FAILED) {
            v->error = errno;
            return PLFX_E_DEVICE;
        }
        v->map[k] = at;
        v->length[k] = b.length;
        v->buffers++;
        if (b.length < (size_t)v->stride * (uint32_t)v->cfg.h) {
            return PLFX_E_SIZE;
        }
    }
    return v->buffers > 1 ? PLFX_OK : PLFX_E_DEVICE;
}

static void v4l2_close(void *context)
{
    plfx_v4l2 *v = context;
    int32_t k;

    for (k = 0; k < v->buffers; k++) {
        (void)munmap(v->map[k], v->length[k]);
    }
    v->buffers = 0;
    if (v->file >= 0) {
        (void)close(v->file);
        v->file = -1;
    }
    v->running = 0;
}

static int pool_ok(const plfx_v4l2 *v)
{
    return v->stride == v->row ||
           (v->pool.bytes && v->pool.slot_size >= (size_t)v->row * (uint32_t)v->cfg.h);
}

static plfx_status prepare(plfx_v4l2 *v)
{
    plfx_status status = can_stream(v) ? set_format(v) : PLFX_E_DEVICE;

    if (status == PLFX_OK) {
        status = set_light(v);
    }
    if (status == PLFX_OK) {
        status = pool_ok(v) ? map_buffers(v) : PLFX_E_SIZE;
    }
    return status;
}

static plfx_status v4l2_open(void *context, plfx_camera_cfg *cfg, const plfx_pool *pool)
{
    plfx_v4l2 *v = context;
    plfx_status status;

    if (!cfg || !pool || pool->slots < 2 || pool->slots > PLFX_V4L2_BUFFERS ||
        v->file >= 0) {
        return PLFX_E_ARG;
    }
    v->file = open(v->path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (v->file < 0) {
        v->error = errno;
        return PLFX_E_DEVICE;
    }
    v->cfg = *cfg;
    v->pool = *pool;
    status = prepare(v);
    if (status != PLFX_OK) {
        v4l2_close(v);
        return status;
    }
    *cfg = v->cfg;
    return PLFX_OK;
}

static int queue(plfx_v4l2 *v, uint32_t index)
{
    struct v4l2_buffer b;

    describe(&b, index);
    return call(v, VIDIOC_QBUF, &b);
}

static plfx_status v4l2_start(void *context)
{
    plfx_v4l2 *v = context;
    int type = CAPTURE;
    int failed = 0;
    int32_t k;

    if (v->file < 0 || v->running) {
        return PLFX_E_STATE;
    }
    memset(&v->count, 0, sizeof v->count);
    memset(v->taken, 0, sizeof v->taken);
    v->last_number = -1;
    v->sequence = v->last_good = v->last_ns = 0;
    for (k = 0; k < v->buffers; k++) {
        failed |= queue(v, (uint32_t)k) < 0;
    }
    if (failed || call(v, VIDIOC_STREAMON, &type) < 0) {
        (void)call(v, VIDIOC_STREAMOFF, &type); /* gives the buffers back */
        return PLFX_E_DEVICE;
    }
    v->running = 1;
    return PLFX_OK;
}

/* Widen the driver's number; what it skipped is missed. */
static void follow(plfx_v4l2 *v, uint32_t number)
{
    uint64_t step =
        v->last_number < 0 ? 1u : (uint32_t)(number - (uint32_t)v->last_number);

    if (step == 0 || step > 0x7fffffffu) {
        step = 1; /* the driver began to count anew */
    }
    if (v->last_number >= 0) {
        v->count.missed += step - 1;
    }
    v->sequence += step;
    v->last_number = number;
}

/* Rows without their padding, in the pool. */
static const uint8_t *compact(const plfx_v4l2 *v, uint32_t index)
{
    uint8_t *to = v->pool.bytes + (size_t)index * v->pool.slot_size;
    int32_t y;

    for (y = 0; y < v->cfg.h; y++) {
        memcpy(to + (size_t)y * v->row, v->map[index] + (size_t)y * v->stride, v->row);
    }
    return to;
}

static uint64_t time_of(const plfx_v4l2 *v, const struct v4l2_buffer *b, uint8_t *clock)
{
    uint64_t ns = (uint64_t)b->timestamp.tv_sec * 1000000000u +
                  (uint64_t)b->timestamp.tv_usec * 1000u;

    *clock =
        (b->flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC
            ? PLFX_CLOCK_MONOTONIC
            : PLFX_CLOCK_UTC;
    if ((b->flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE) {
        ns += (uint64_t)v->exposure_us * 500u; /* from start to middle of exposure */
    }
    return ns;
}

static void hand_out(plfx_v4l2 *v, const struct v4l2_buffer *b, plfx_camera_frame *f)
{
    memset(f, 0, sizeof *f);
    f->raw.bytes = v->stride == v->row ? v->map[b->index] : compact(v, b->index);
    f->raw.size = (size_t)v->row * (uint32_t)v->cfg.h;
    f->raw.format = v->cfg.format;
    f->raw.bits = v->cfg.bits;
    f->raw.w = v->cfg.w;
    f->raw.h = f->rows = v->cfg.h;
    f->bayer = v->cfg.bayer;
    f->slot = (int32_t)b->index;
    f->time_ns = time_of(v, b, &f->clock);
    f->sequence = (uint32_t)v->sequence;
    f->dropped = (uint32_t)(v->sequence - v->last_good - 1u);
    v->count.back += f->time_ns < v->last_ns;
    v->last_ns = f->time_ns;
    v->last_good = v->sequence;
    v->count.good++;
    v->taken[b->index] = 1;
}

/* One filled buffer: handed out, or counted and queued again. */
static int judge(plfx_v4l2 *v, const struct v4l2_buffer *b, plfx_camera_frame *frame)
{
    follow(v, b->sequence);
    if (b->flags & V4L2_BUF_FLAG_ERROR) {
        v->count.incomplete++;
    } else if (b->bytesused != 0 &&
               b->bytesused < v->stride * (uint32_t)(v->cfg.h - 1) + v->row) {
        v->count.misfit++;
    } else {
        hand_out(v, b, frame);
        return 1;
    }
    (void)queue(v, b->index);
    return 0;
}

static int64_t now_ms(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000 + t.tv_nsec / 1000000;
}

static int none_queued(const plfx_v4l2 *v)
{
    int32_t k;

    for (k = 0; k < v->buffers; k++) {
        if (!v->taken[k]) {
            return 0;
        }
    }
    return 1;
}

/* Waits for a buffer; 1: the device is gone. */
static int lost_while_waiting(const plfx_v4l2 *v, int64_t ms)
{
    struct pollfd wait = {v->file, POLLIN, 0};

    return poll(&wait, 1, (int)ms) > 0 && (wait.revents & (POLLERR | POLLHUP));
}

static plfx_status v4l2_acquire(void *context, uint32_t timeout_ms,
                                plfx_camera_frame *frame)
{
    plfx_v4l2 *v = context;
    int64_t until = now_ms() + timeout_ms;
    int64_t left = timeout_ms;

    if (!v->running || !frame) {
        return v->running ? PLFX_E_ARG : PLFX_E_STATE;
    }
    if (none_queued(v)) {
        v->count.starved++;
        return PLFX_E_STATE;
    }
    do { /* at most until the timeout */
        struct v4l2_buffer b;
        describe(&b, 0);
        if (call(v, VIDIOC_DQBUF, &b) == 0) {
            if (judge(v, &b, frame)) {
                return PLFX_OK;
            }
        } else if (v->error != EAGAIN || lost_while_waiting(v, left)) {
            return PLFX_E_DEVICE;
        }
        left = until - now_ms();
    } while (left > 0);
    return PLFX_E_TIMEOUT;
}

static plfx_status v4l2_release(void *context, const plfx_camera_frame *frame)
{
    plfx_v4l2 *v = context;

    if (!frame || frame->slot < 0 || frame->slot >= v->buffers ||
        !v->taken[frame->slot]) {
        return PLFX_E_ARG;
    }
    if (queue(v, (uint32_t)frame->slot) < 0) {
        return gone_or(v, PLFX_E_IO); /* still the caller's */
    }
    v->taken[frame->slot] = 0;
    return PLFX_OK;
}

static plfx_status v4l2_stop(void *context)
{
    plfx_v4l2 *v = context;
    int type = CAPTURE;

    if (!v->running) {
        return PLFX_E_STATE;
    }
    v->running = 0;
    return call(v, VIDIOC_STREAMOFF, &type) == 0 ? PLFX_OK : PLFX_E_DEVICE;
}

static void v4l2_count(void *context, plfx_camera_count *count)
{
    *count = ((plfx_v4l2 *)context)->count;
}

void plfx_v4l2_init(plfx_v4l2 *v, const char *path)
{
    memset(v, 0, sizeof *v);
    v->path = path;
    v->file = -1;
    v->camera.context = v;
    v->camera.open = v4l2_open;
    v->camera.start = v4l2_start;
    v->camera.acquire = v4l2_acquire;
    v->camera.release = v4l2_release;
    v->camera.stop = v4l2_stop;
    v->camera.count = v4l2_count;
    v->camera.close = v4l2_close;
}
