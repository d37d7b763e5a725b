/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "camera/pictures.h"

#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "common/err.h"
#include "common/frame.h"

static plfx_status read_frame(const plft_pictures *p, int k, plft_frame *f)
{
    memset(f, 0, sizeof *f);
    if (plft_frame_read(f, p->paths[k], p->bits) != 0) {
        return PLFX_E_DEVICE;
    }
    plft_frame_to_grey(f);
    return PLFX_OK;
}

static plfx_status pictures_open(void *context, plfx_camera_cfg *cfg,
                                 const plfx_pool *pool)
{
    plft_pictures *p = context;
    plft_frame f;
    plfx_status status;

    if (pool->slots < 1 || pool->slots > PLFT_PICTURES_SLOTS || p->n < 1) {
        return PLFX_E_ARG;
    }
    status = read_frame(p, 0, &f);
    if (status != PLFX_OK) {
        return status;
    }
    p->pool = *pool;
    p->cfg = *cfg;
    p->cfg.w = f.w;
    p->cfg.h = f.h;
    p->cfg.bits = (uint8_t)f.bits;
    p->cfg.format = f.bits <= 8 ? PLFX_RAW_U8 : PLFX_RAW_U16LE;
    plft_frame_free(&f);
    *cfg = p->cfg;
    return plfx_raw_bytes(cfg->format, cfg->w, cfg->h) <= pool->slot_size ? PLFX_OK
                                                                          : PLFX_E_SIZE;
}

static plfx_status pictures_start(void *context)
{
    plft_pictures *p = context;

    if (p->running) {
        return PLFX_E_STATE;
    }
    memset(&p->count, 0, sizeof p->count);
    memset(p->taken, 0, sizeof p->taken);
    p->next = 0;
    p->running = 1;
    return PLFX_OK;
}

static void pack(const plft_frame *f, int format, uint8_t *to)
{
    size_t n = (size_t)f->w * (size_t)f->h;
    size_t i;

    for (i = 0; i < n; i++) {
        if (format == PLFX_RAW_U8) {
            to[i] = (uint8_t)f->px[i];
        } else {
            to[2 * i] = (uint8_t)f->px[i];
            to[2 * i + 1] = (uint8_t)(f->px[i] >> 8);
        }
    }
}

/* Ask the system for the next file while this one is decoded. */
static void look_ahead(const plft_pictures *p)
{
    int file = p->next + 1 < p->n ? open(p->paths[p->next + 1], O_RDONLY) : -1;

    if (file >= 0) {
        (void)posix_fadvise(file, 0, 0, POSIX_FADV_WILLNEED);
        (void)close(file);
    }
}

static int free_slot(const plft_pictures *p)
{
    int k;

    for (k = 0; k < p->pool.slots; k++) {
        if (!p->taken[k]) {
            return k;
        }
    }
    return -1;
}

/* Time of picture k by the rate; waits for it. */
static uint64_t pace(plft_pictures *p)
{
    uint64_t at =
        p->cfg.rate_mhz ? (uint64_t)p->next * 1000000000000u / p->cfg.rate_mhz : 0u;

    if (p->cfg.rate_mhz && p->clock.now_ns) {
        if (p->next == 0) {
            p->began_ns = p->clock.now_ns(p->clock.context);
        }
        (void)p->clock.sleep_until(p->clock.context, p->began_ns + at);
    }
    return at;
}

static void describe(const plft_pictures *p, plfx_camera_frame *frame, int slot)
{
    memset(frame, 0, sizeof *frame);
    frame->raw.bytes = p->pool.bytes + (size_t)slot * p->pool.slot_size;
    frame->raw.format = p->cfg.format;
    frame->raw.bits = p->cfg.bits;
    frame->raw.w = p->cfg.w;
    frame->raw.h = frame->rows = p->cfg.h;
    frame->raw.size = plfx_raw_bytes(p->cfg.format, p->cfg.w, p->cfg.h);
    frame->bayer = p->cfg.bayer;
    frame->slot = slot;
    frame->sequence = (uint32_t)p->next;
    frame->clock = p->cfg.rate_mhz ? PLFX_CLOCK_CAMERA : PLFX_CLOCK_NONE;
}

static plfx_status pictures_acquire(void *context, uint32_t timeout_ms,
                                    plfx_camera_frame *frame)
{
    plft_pictures *p = context;
    int slot = free_slot(p);
    plfx_camera_frame out;
    plft_frame f;

    (void)timeout_ms;
    if (!p->running || slot < 0) {
        p->count.starved += p->running != 0;
        return PLFX_E_STATE;
    }
    if (p->next == p->n) {
        return PLFX_E_DEVICE;
    }
    describe(p, &out, slot);
    look_ahead(p);
    out.time_ns = pace(p);
    if (read_frame(p, p->next, &f) != PLFX_OK) {
        p->count.incomplete++;
        p->next++;
        return PLFX_E_TIMEOUT;
    }
    if (f.w != p->cfg.w || f.h != p->cfg.h || f.bits != p->cfg.bits) {
        plft_warn("%s is %dx%d of %d bits, the first was %dx%d of %d: left out",
                  p->paths[p->next], f.w, f.h, f.bits, p->cfg.w, p->cfg.h, p->cfg.bits);
        p->count.misfit++;
        p->next++;
        plft_frame_free(&f);
        return PLFX_E_TIMEOUT;
    }
    pack(&f, p->cfg.format, p->pool.bytes + (size_t)slot * p->pool.slot_size);
    plft_frame_free(&f);
    p->taken[slot] = 1;
    p->count.good++;
    p->next++;
    *frame = out;
    return PLFX_OK;
}

static plfx_status pictures_release(void *context, const plfx_camera_frame *frame)
{
    plft_pictures *p = context;

    p->taken[frame->slot] = 0;
    return PLFX_OK;
}

static plfx_status pictures_stop(void *context)
{
    ((plft_pictures *)context)->running = 0;
    return PLFX_OK;
}

static void pictures_count(void *context, plfx_camera_count *count)
{
    *count = ((plft_pictures *)context)->count;
}

static void pictures_close(void *context)
{
    ((plft_pictures *)context)->running = 0;
}

void plft_pictures_init(plft_pictures *p, const char *const *paths, int n, int bits,
                        plfx_clock clock)
{
    memset(p, 0, sizeof *p);
    p->paths = paths;
    p->n = n;
    p->bits = bits;
    p->clock = clock;
    p->camera.context = p;
    p->camera.open = pictures_open;
    p->camera.start = pictures_start;
    p->camera.acquire = pictures_acquire;
    p->camera.release = pictures_release;
    p->camera.stop = pictures_stop;
    p->camera.count = pictures_count;
    p->camera.close = pictures_close;
}
