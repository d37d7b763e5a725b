/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "replay.h"

#include "checksum.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define AHEAD   4u /* frames fetched ahead */
#define MILLION 1000000u
#define HEADER  4096u
#define HEAD    64u

/* Size, format and number of frames of a bare file. */
static plfx_status open_bare(plfx_replay *r)
{
    plfx_recording *rec = &r->record;
    struct stat about;

    memset(rec, 0, sizeof *rec);
    rec->file = -1;
    rec->payload = (uint32_t)plfx_raw_bytes(r->cfg.format, r->cfg.w, r->cfg.h);
    if (rec->payload == 0 || r->cfg.bits < 8 || r->cfg.bits > 16) {
        return PLFX_E_ARG;
    }
    rec->file = open(r->path, O_RDONLY | O_CLOEXEC);
    if (rec->file < 0 || fstat(rec->file, &about) != 0) {
        return PLFX_E_DEVICE;
    }
    r->total = (uint64_t)about.st_size / rec->payload;
    return r->total > 0 ? PLFX_OK : PLFX_E_SIZE;
}

static int same(int32_t wanted, int32_t is)
{
    return wanted == 0 || wanted == is;
}

static plfx_status open_recording(plfx_replay *r)
{
    plfx_status status = plfx_recording_open(&r->record, r->path, 0);
    const plfx_recording_info *i = &r->record.info;

    if (status != PLFX_OK) {
        return status == PLFX_E_IO ? PLFX_E_DEVICE : status;
    }
    if (!same(r->cfg.w, i->w) || !same(r->cfg.h, i->h)) {
        return PLFX_E_ARG;
    }
    r->cfg.w = i->w;
    r->cfg.h = i->h;
    r->cfg.format = i->format;
    r->cfg.bits = i->bits;
    r->cfg.bayer = i->bayer;
    r->total = r->record.count;
    return PLFX_OK;
}

static int pool_ok(const plfx_pool *p)
{
    return p && p->bytes && p->slots >= 1 && p->slots <= PLFX_REPLAY_SLOTS;
}

static plfx_status replay_open(void *context, plfx_camera_cfg *cfg,
                               const plfx_pool *pool)
{
    plfx_replay *r = context;
    plfx_status status;

    if (!cfg || !pool_ok(pool) || r->open) {
        return PLFX_E_ARG;
    }
    r->cfg = *cfg;
    status = r->bare ? open_bare(r) : open_recording(r);
    if (status == PLFX_OK && pool->slot_size < r->record.payload) {
        status = PLFX_E_SIZE;
    }
    if (status != PLFX_OK) {
        plfx_recording_close(&r->record);
        return status;
    }
    r->pool = *pool;
    r->open = 1;
    *cfg = r->cfg;
    return PLFX_OK;
}

static plfx_status replay_start(void *context)
{
    plfx_replay *r = context;

    if (!r->open || r->running) {
        return PLFX_E_STATE;
    }
    memset(&r->count, 0, sizeof r->count);
    memset(r->taken, 0, sizeof r->taken);
    r->next = 0;
    r->rounds = r->last_number = 0;
    r->last_ns = 0;
    r->running = 1;
    return PLFX_OK;
}

/* Head of the frame to play. */
static plfx_status head(plfx_replay *r, plfx_camera_frame *f)
{
    if (!r->bare) {
        return plfx_recording_read(&r->record, r->next, NULL, 0, f);
    }
    memset(f, 0, sizeof *f);
    f->raw.size = r->record.payload;
    f->raw.format = r->cfg.format;
    f->raw.bits = r->cfg.bits;
    f->raw.w = r->cfg.w;
    f->raw.h = r->cfg.h;
    f->rows = r->cfg.h;
    f->bayer = r->cfg.bayer;
    f->sequence = (uint32_t)r->next;
    f->clock = r->cfg.rate_mhz ? PLFX_CLOCK_CAMERA : PLFX_CLOCK_NONE;
    f->time_ns = r->cfg.rate_mhz ? r->next * 1000000u * MILLION / r->cfg.rate_mhz : 0u;
    return PLFX_OK;
}

/* Wait until the frame is due; a time that steps back restarts the measure. */
static plfx_status pace(plfx_replay *r, const plfx_camera_frame *f, uint32_t timeout_ms)
{
    uint64_t now;
    uint64_t due;

    if (r->speed_q8 == 0 || !r->clock.now_ns || f->clock == PLFX_CLOCK_NONE) {
        return PLFX_OK;
    }
    now = r->clock.now_ns(r->clock.context);
    if (r->next == 0 || f->time_ns < r->last_ns) {
        r->began_ns = now;
        r->first_ns = f->time_ns;
    }
    due = r->began_ns + (f->time_ns - r->first_ns) * 256u / r->speed_q8;
    if (due <= now) {
        return PLFX_OK;
    }
    if (due - now > (uint64_t)timeout_ms * MILLION) {
        if (r->clock.sleep_until) {
            (void)r->clock.sleep_until(r->clock.context,
                                       now + (uint64_t)timeout_ms * MILLION);
        }
        return PLFX_E_TIMEOUT;
    }
    return r->clock.sleep_until ? r->clock.sleep_until(r->clock.context, due) : PLFX_OK;
}

static int32_t free_slot(const plfx_replay *r)
{
    int32_t k;

    for (k = 0; k < r->pool.slots; k++) {
        if (!r->taken[k]) {
            return k;
        }
    }
    return -1;
}

/* Bytes from `from` to `to` of the payload of frame i. */
static plfx_status fetch(plfx_replay *r, uint64_t i, uint8_t *bytes, size_t from,
                         size_t to)
{
    uint64_t at =
        r->bare ? i * r->record.payload : HEADER + i * r->record.stride + HEAD;

    while (from < to) { /* at most a round a byte */
        ssize_t k = pread(r->record.file, bytes + from, to - from, (off_t)(at + from));
        if (k < 0 && errno == EINTR) {
            continue;
        }
        if (k <= 0) {
            return PLFX_E_DEVICE;
        }
        from += (size_t)k;
    }
    return PLFX_OK;
}

/* The payload of the frame to play: all of it, or none yet. */
static plfx_status body(plfx_replay *r, plfx_camera_frame *f)
{
    uint8_t *bytes = r->pool.bytes + (size_t)f->slot * r->pool.slot_size;
    plfx_camera_frame whole;
    plfx_status status;

    f->raw.bytes = bytes;
    if (r->bands) {
        f->rows = 0;
        return PLFX_OK;
    }
    if (r->bare) {
        return fetch(r, r->next, bytes, 0, r->record.payload);
    }
    status = plfx_recording_read(&r->record, r->next, bytes, r->pool.slot_size, &whole);
    return status;
}

/* Ask the system for the frames that follow. */
static void look_ahead(const plfx_replay *r)
{
    if (r->bare) {
        (void)posix_fadvise(r->record.file, (off_t)((r->next + 1) * r->record.payload),
                            (off_t)AHEAD * r->record.payload, POSIX_FADV_WILLNEED);
    } else {
        plfx_recording_ahead(&r->record, r->next + 1, AHEAD);
    }
}

static void account(plfx_replay *r, plfx_camera_frame *f)
{
    if (r->count.good > 0 || f->dropped > 0) {
        r->count.missed += f->dropped;
    }
    if (f->time_ns < r->last_ns) {
        r->count.back++;
    }
    r->last_ns = f->time_ns;
    r->last_number = f->sequence;
    f->sequence += r->rounds;
    r->count.good++;
    r->taken[f->slot] = (uint8_t)(1 + r->next % 255u);
}

static plfx_status replay_acquire(void *context, uint32_t timeout_ms,
                                  plfx_camera_frame *frame)
{
    plfx_replay *r = context;
    plfx_camera_frame f;
    plfx_status status;

    if (!r->running || !frame) {
        return r->running ? PLFX_E_ARG : PLFX_E_STATE;
    }
    if (r->next == r->total && r->loop) {
        r->next = 0;
        r->rounds += r->last_number + 1u; /* numbers never repeat */
        r->last_ns = 0;
    }
    if (r->next == r->total) {
        return PLFX_E_DEVICE;
    }
    status = head(r, &f);
    if (status == PLFX_OK) {
        status = pace(r, &f, timeout_ms);
    }
    f.slot = free_slot(r);
    if (status == PLFX_OK && f.slot < 0) {
        r->count.starved++;
        return PLFX_E_STATE;
    }
    if (status == PLFX_OK) {
        status = body(r, &f);
    }
    if (status == PLFX_E_FORMAT) { /* damaged on the medium: never handed out */
        r->count.incomplete++;
        r->next++;
        return PLFX_E_TIMEOUT;
    }
    if (status != PLFX_OK) {
        return status;
    }
    account(r, &f);
    look_ahead(r);
    r->next++;
    *frame = f;
    return PLFX_OK;
}

/* Bytes that hold the first `rows` rows. */
static size_t bytes_of(const plfx_raw *raw, int32_t rows)
{
    size_t n = plfx_raw_bytes(raw->format, raw->w, rows);

    return rows >= raw->h || n > raw->size ? raw->size : n;
}

static plfx_status replay_rows(void *context, plfx_camera_frame *f, int32_t want,
                               uint32_t timeout_ms)
{
    plfx_replay *r = context;
    uint8_t *bytes;
    uint64_t i = r->next - 1u;
    plfx_camera_frame whole;
    plfx_status status;

    (void)timeout_ms;
    if (!r->running || !f || want < 0 || want > f->raw.h || f->slot < 0 ||
        f->slot >= r->pool.slots || r->taken[f->slot] != 1 + i % 255u) {
        return PLFX_E_STATE;
    }
    if (want <= f->rows) {
        return PLFX_OK;
    }
    bytes = r->pool.bytes + (size_t)f->slot * r->pool.slot_size;
    if (want == f->raw.h && !r->bare) { /* the end: now the CRC can be checked */
        status = plfx_recording_read(&r->record, i, bytes, r->pool.slot_size, &whole);
        r->count.incomplete += status == PLFX_E_FORMAT;
    } else {
        status = fetch(r, i, bytes, f->rows ? bytes_of(&f->raw, f->rows) : 0,
                       bytes_of(&f->raw, want));
    }
    if (status == PLFX_OK) {
        f->rows = want;
    }
    return status;
}

static plfx_status replay_release(void *context, const plfx_camera_frame *frame)
{
    plfx_replay *r = context;

    if (!frame || frame->slot < 0 || frame->slot >= r->pool.slots ||
        !r->taken[frame->slot]) {
        return PLFX_E_ARG;
    }
    r->taken[frame->slot] = 0;
    return PLFX_OK;
}

static plfx_status replay_stop(void *context)
{
    plfx_replay *r = context;

    if (!r->running) {
        return PLFX_E_STATE;
    }
    r->running = 0;
    return PLFX_OK;
}

static void replay_count(void *context, plfx_camera_count *count)
{
    *count = ((plfx_replay *)context)->count;
}

static void replay_close(void *context)
{
    plfx_replay *r = context;

    plfx_recording_close(&r->record);
    r->open = 0;
    r->running = 0;
}

void plfx_replay_init(plfx_replay *r, const char *path, plfx_clock clock)
{
    memset(r, 0, sizeof *r);
    r->path = path;
    r->clock = clock;
    r->speed_q8 = 256;
    r->record.file = -1;
    r->camera.context = r;
    r->camera.open = replay_open;
    r->camera.start = replay_start;
    r->camera.acquire = replay_acquire;
    r->camera.rows = replay_rows;
    r->camera.release = replay_release;
    r->camera.stop = replay_stop;
    r->camera.count = replay_count;
    r->camera.close = replay_close;
}
