/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "camera/source.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera/pictures.h"
#include "common/err.h"
#include "common/memory.h"
#include "posix/clock.h"
#include "posix/replay.h"
#ifdef PLFT_ARAVIS
#include "aravis/aravis.h"
#endif
#ifdef PLFT_V4L2
#include "v4l2/v4l2.h"
#endif

#define PATIENCE_S 12           /* without a frame; Aravis takes 8 to miss a camera */
#define SLICE_MS   250          /* between looks at the interrupt flag */
#define ROOM       (64u << 20u) /* of a slot when the size is not known beforehand */
#define FORMATS    "u8|u16|mono10p|mono12p|mono10packed|mono12packed|csi10|csi12"

typedef union any_camera {
    plfx_replay replay;
    plft_pictures pictures;
#ifdef PLFT_ARAVIS
    plfx_aravis aravis;
#endif
#ifdef PLFT_V4L2
    plfx_v4l2 v4l2;
#endif
} any_camera;

static volatile sig_atomic_t interrupted;

static void on_interrupt(int signal_number)
{
    (void)signal_number;
    interrupted = 1;
}

void plft_wish_none(plft_wish *wish)
{
    memset(wish, 0, sizeof *wish);
    wish->format = -1;
    wish->gain_db = NAN;
    wish->slots = 4;
    wish->patience = PATIENCE_S;
}

int plft_wish_options(plft_option *table, plft_wish *w)
{
    const plft_option own[PLFT_SOURCE_OPTIONS] = {
        {"--size", PLFT_TEXT, &w->size, "WxH", 0, 0, "of a frame, pixels"},
        {"--offset", PLFT_TEXT, &w->offset, "X,Y", 0, 0, "first pixel on the sensor"},
        {"--format", PLFT_WORD, &w->format, FORMATS, 0, 0, "of a pixel; the camera's"},
        {"--bits", PLFT_INT, &w->bits, "N", 8, 16, "significant ones of u16 and files"},
        {"--bayer", PLFT_WORD, &w->bayer, "none|rggb|grbg|gbrg|bggr", 0, 0,
         "mosaic of the sensor"},
        {"--exposure", PLFT_REAL, &w->exposure_us, "US", 1, 1e9, "microseconds"},
        {"--gain", PLFT_REAL, &w->gain_db, "DB", -20, 60, "decibels"},
        {"--rate", PLFT_REAL, &w->rate, "HZ", 0.001, 100000, "frames a second"},
        {"--packet", PLFT_INT, &w->packet, "BYTES", 220, 16404, "on the wire"},
        {"--slots", PLFT_INT, &w->slots, "N", 2, 32, "frames of memory; 4"},
        {"--frames", PLFT_INT, &w->frames, "N", 1, 1e9, "stop after so many"},
        {"--timeout", PLFT_REAL, &w->patience, "S", 0.1, 1e6,
         "seconds without a frame before giving up; 12"}};

    memcpy(table, own, sizeof own);
    return PLFT_SOURCE_OPTIONS;
}

static int parse_pair(const char *text, const char *form, const char *option,
                      int32_t *a, int32_t *b)
{
    char rest;
    int x;
    int y;

    if (text == NULL) {
        return 0;
    }
    if (sscanf(text, form, &x, &y, &rest) != 2 || x < 0 || y < 0 || x > 32767 ||
        y > 32767) {
        return plft_fail(PLFT_USAGE, "%s %s: want two numbers, 0 to 32767", option,
                         text);
    }
    *a = x;
    *b = y;
    return 0;
}

static int fill_cfg(plfx_camera_cfg *c, const plft_wish *w)
{
    static const uint8_t formats[] = {PLFX_RAW_U8,           PLFX_RAW_U16LE,
                                      PLFX_RAW_MONO10P,      PLFX_RAW_MONO12P,
                                      PLFX_RAW_MONO10PACKED, PLFX_RAW_MONO12PACKED,
                                      PLFX_RAW_CSI10,        PLFX_RAW_CSI12};
    static const uint8_t bits[] = {8, 16, 10, 12, 10, 12, 10, 12};
    int rc;

    memset(c, 0, sizeof *c);
    rc = parse_pair(w->size, "%dx%d%c", "--size", &c->w, &c->h);
    rc = rc != 0 ? rc : parse_pair(w->offset, "%d,%d%c", "--offset", &c->x0, &c->y0);
    if (w->format >= 0) {
        c->format = formats[w->format];
        c->bits = w->bits ? (uint8_t)w->bits : bits[w->format];
    }
    c->bayer = (uint8_t)w->bayer;
    c->exposure_us = (uint32_t)lround(w->exposure_us);
    c->gain_mdb = isnan(w->gain_db) ? INT32_MIN : (int32_t)lround(1000.0 * w->gain_db);
    c->rate_mhz = (uint32_t)lround(1000.0 * w->rate);
    c->packet_size = (uint32_t)w->packet;
    return rc;
}

static int ends_in(const char *name, const char *end)
{
    size_t n = strlen(name);
    size_t k = strlen(end);

    return n > k && strcmp(name + n - k, end) == 0;
}

static int is_picture(const char *name)
{
    return ends_in(name, ".png") || ends_in(name, ".PNG") || ends_in(name, ".tif") ||
           ends_in(name, ".tiff");
}

/* Bytes that a frame can have at most. */
static size_t room_for(const plft_camera *c, const plfx_replay *replay)
{
    plfx_recording r;
    size_t n = plfx_raw_bytes(PLFX_RAW_U16LE, c->cfg.w, c->cfg.h);

    if (replay && !replay->bare &&
        plfx_recording_open(&r, replay->path, 0) == PLFX_OK) {
        n = r.payload;
        plfx_recording_close(&r);
    }
    return n ? n : ROOM;
}

static void choose_replay(plft_camera *c, any_camera *any, const plft_wish *w)
{
    plfx_replay_init(&any->replay, c->name, plfx_posix_monotonic());
    any->replay.bare = !ends_in(c->name, ".plxr");
    any->replay.speed_q8 = (uint32_t)lround(256.0 * w->speed);
    c->port = &any->replay.camera;
    c->ends = 1;
}

static int choose_device(plft_camera *c, any_camera *any)
{
    if (strncmp(c->name, "gige", 4) == 0) {
#ifdef PLFT_ARAVIS
        plfx_aravis_init(&any->aravis, c->name[4] == ':' ? c->name + 5 : NULL);
        c->port = &any->aravis.camera;
#endif
        return c->port ? 0 : plft_fail(PLFT_DATA, "%s: built without Aravis", c->name);
    }
#ifdef PLFT_V4L2
    plfx_v4l2_init(&any->v4l2, c->name + 5);
    c->port = &any->v4l2.camera;
#else
    (void)any;
#endif
    return c->port ? 0 : plft_fail(PLFT_DATA, "%s: built without V4L2", c->name);
}

static int is_device(const char *name)
{
    return strcmp(name, "gige") == 0 || strncmp(name, "gige:", 5) == 0 ||
           strncmp(name, "v4l2:", 5) == 0;
}

static int choose(plft_camera *c, any_camera *any, const plft_wish *w)
{
    if (is_device(c->name)) {
        return w->n == 1 ? choose_device(c, any)
                         : plft_fail(PLFT_USAGE, "%s: one camera at a time", c->name);
    }
    if (is_picture(c->name)) {
        plft_pictures_init(&any->pictures, w->names, w->n, w->bits,
                           plfx_posix_monotonic());
        c->port = &any->pictures.camera;
        c->ends = 1;
        return 0;
    }
    if (w->n != 1) {
        return plft_fail(PLFT_USAGE, "%s: one file at a time, or pictures", c->name);
    }
    choose_replay(c, any, w);
    if (any->replay.bare && (c->cfg.w == 0 || c->cfg.bits == 0)) {
        return plft_fail(PLFT_USAGE, "%s: bare frames want --size and --format",
                         c->name);
    }
    return 0;
}

static const char *words_of(const plft_camera *c)
{
#ifdef PLFT_ARAVIS
    if (strncmp(c->name, "gige", 4) == 0) {
        return ((const any_camera *)c->state)->aravis.message;
    }
#else
    (void)c;
#endif
    return "";
}

static uint32_t id_of(const plft_camera *c)
{
    const any_camera *any = c->state;

#ifdef PLFT_ARAVIS
    if (c->port == &any->aravis.camera && !c->ends &&
        strncmp(c->name, "gige", 4) == 0) {
        return any->aravis.camera_id;
    }
#endif
    return c->ends && !is_picture(c->name) ? any->replay.record.info.camera_id : 0u;
}

int plft_camera_suits(const plft_camera *c, const plfx_lut *t, const char *path)
{
    if (c->camera_id && t->camera_id && c->camera_id != t->camera_id) {
        return plft_fail(PLFT_DATA, "%s is of camera %u, %s is camera %u", path,
                         (unsigned)t->camera_id, c->name, (unsigned)c->camera_id);
    }
    if (t->sensor_w != c->cfg.w || t->sensor_h != c->cfg.h) {
        return plft_fail(PLFT_DATA, "%s is for %dx%d pixels, %s sends %dx%d", path,
                         (int)t->sensor_w, (int)t->sensor_h, c->name, (int)c->cfg.w,
                         (int)c->cfg.h);
    }
    if (t->sensor_bits != c->cfg.bits) {
        plft_warn("%s is of frames of %d bits, %s sends %d; see --format and --bits",
                  path, (int)t->sensor_bits, c->name, c->cfg.bits);
    }
    return 0;
}

static int explain(const plft_camera *c, plfx_status status)
{
    const char *why = status == PLFX_E_DEVICE   ? "cannot be opened"
                      : status == PLFX_E_ARG    ? "cannot be set as wished"
                      : status == PLFX_E_SIZE   ? "has frames too large or too small"
                      : status == PLFX_E_FORMAT ? "is no recording"
                                                : "failed";
    const char *words = words_of(c);

    return plft_fail(PLFT_DATA, "%s %s%s%s", c->name, why, words[0] ? ": " : "", words);
}

static int make_pool(plft_camera *c, const plft_wish *w)
{
    const any_camera *any = c->state;
    size_t slot =
        PLFX_ALIGNED(room_for(c, c->port == &any->replay.camera ? &any->replay : NULL));

    c->memory = plft_alloc_ws(slot * (size_t)w->slots);
    if (c->memory == NULL) {
        return PLFT_DATA;
    }
    c->pool.bytes = c->memory;
    c->pool.slot_size = slot;
    c->pool.slots = w->slots;
    return 0;
}

int plft_camera_start(plft_camera *c, const plft_wish *wish)
{
    plfx_status status;
    int rc;

    memset(c, 0, sizeof *c);
    if (wish->n < 1) {
        return plft_fail(PLFT_USAGE, "want a camera: gige, v4l2:/dev/video0, a "
                                     "recording, or pictures");
    }
    c->name = wish->names[0];
    c->patience_ms = (int64_t)(1000.0 * wish->patience);
    c->state = plft_alloc(1, sizeof(any_camera));
    rc = c->state == NULL ? PLFT_DATA : fill_cfg(&c->cfg, wish);
    rc = rc != 0 ? rc : choose(c, c->state, wish);
    rc = rc != 0 ? rc : make_pool(c, wish);
    if (rc != 0) {
        c->port = NULL;
        plft_camera_stop(c);
        return rc;
    }
    status = c->port->open(c->port->context, &c->cfg, &c->pool);
    if (status == PLFX_OK) {
        status = c->port->start(c->port->context);
    }
    if (status != PLFX_OK) {
        rc = explain(c, status);
        plft_camera_stop(c);
        return rc;
    }
    c->camera_id = id_of(c);
    interrupted = 0;
    (void)signal(SIGINT, on_interrupt);
    (void)signal(SIGTERM, on_interrupt);
    return 0;
}

int plft_camera_next(plft_camera *c, plfx_camera_frame *frame)
{
    int64_t left = c->patience_ms;

    while (left > 0) { /* at most patience over slice */
        uint32_t slice = left < SLICE_MS ? (uint32_t)left : SLICE_MS;
        plfx_status status;
        if (interrupted) {
            return -1;
        }
        status = c->port->acquire(c->port->context, slice, frame);
        if (status == PLFX_OK) {
            return 0;
        }
        if (status == PLFX_E_DEVICE && c->ends) {
            return -1;
        }
        if (status != PLFX_E_TIMEOUT) {
            return plft_fail(PLFT_DATA, "%s: %s", c->name,
                             status == PLFX_E_DEVICE ? "the camera is gone"
                                                     : "the camera failed");
        }
        left -= c->ends ? 0 : slice; /* a file is as slow as it says */
    }
    return plft_fail(PLFT_DATA, "%s: no frame within %g s", c->name,
                     (double)c->patience_ms / 1000.0);
}

void plft_camera_release(plft_camera *c, const plfx_camera_frame *frame)
{
    (void)c->port->release(c->port->context, frame);
}

void plft_camera_report(const plft_camera *c)
{
    plfx_camera_count n;

    if (!c->port) {
        return;
    }
    c->port->count(c->port->context, &n);
    if (n.incomplete + n.missed + n.starved + n.misfit + n.back > 0) {
        plft_warn("%s: %llu frames good, %llu incomplete, %llu missed, %llu without "
                  "memory, %llu of another size, %llu times set back",
                  c->name, (unsigned long long)n.good, (unsigned long long)n.incomplete,
                  (unsigned long long)n.missed, (unsigned long long)n.starved,
                  (unsigned long long)n.misfit, (unsigned long long)n.back);
    }
}

void plft_camera_stop(plft_camera *c)
{
    if (c->port) {
        (void)c->port->stop(c->port->context);
        c->port->close(c->port->context);
        (void)signal(SIGINT, SIG_DFL);
        (void)signal(SIGTERM, SIG_DFL);
    }
    free(c->memory);
    free(c->state);
    memset(c, 0, sizeof *c);
}
