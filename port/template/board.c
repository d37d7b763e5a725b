/* SPDX-License-Identifier: MIT
 * The board.  Each function marked BOARD touches hardware on a real one. */
#include "template.h"

#include <string.h>

#define FLASH_SIZE 16384u
#define ERASE_SIZE 4096u
#define UNIT       16u
#define SLOTS      8

/* ---- Clock ---- */

/* BOARD: read a timer that does not stop; widen it to 64 bits and to nanoseconds. */
static uint64_t now_ns(void *context)
{
    static uint64_t ticks;

    (void)context;
    return ++ticks * 1000u;
}

plfx_clock plfx_template_clock(void)
{
    plfx_clock c = {NULL, now_ns, NULL, PLFX_CLOCK_MONOTONIC};

    return c;
}

/* ---- Flash ---- */

static uint8_t flash[FLASH_SIZE];

static int outside(uint32_t at, uint32_t n)
{
    return at > FLASH_SIZE || n > FLASH_SIZE - at;
}

/* BOARD: a memory copy where the flash is in the address space. */
static plfx_status flash_read(void *context, uint32_t at, void *data, uint32_t n)
{
    (void)context;
    if (outside(at, n)) {
        return PLFX_E_ARG;
    }
    memcpy(data, flash + at, n);
    return PLFX_OK;
}

/* BOARD: program whole units; wait until the part is done; E_IO when it complains. */
static plfx_status flash_program(void *context, uint32_t at, const void *data,
                                 uint32_t n)
{
    const uint8_t *from = data;
    uint32_t i;

    (void)context;
    if (outside(at, n) || at % UNIT != 0u || n % UNIT != 0u) {
        return PLFX_E_ARG;
    }
    for (i = 0; i < n; i++) {
        flash[at + i] &= from[i];
    }
    return PLFX_OK;
}

/* BOARD: erase one block. */
static plfx_status flash_erase(void *context, uint32_t at)
{
    (void)context;
    if (outside(at, ERASE_SIZE) || at % ERASE_SIZE != 0u) {
        return PLFX_E_ARG;
    }
    memset(flash + at, 0xff, ERASE_SIZE);
    return PLFX_OK;
}

/* BOARD: flush caches and buffers; nothing to do where program and erase wait. */
static plfx_status flash_sync(void *context)
{
    (void)context;
    return PLFX_OK;
}

plfx_block plfx_template_flash(void)
{
    plfx_block b;

    b.context = NULL;
    b.read = flash_read;
    b.program = flash_program;
    b.erase = flash_erase;
    b.sync = flash_sync;
    b.size = FLASH_SIZE;
    b.erase_size = ERASE_SIZE;
    b.program_size = UNIT;
    b.erased = 0xff;
    b.map = flash;
    return b;
}

/* ---- Camera ---- */

typedef struct sensor {
    plfx_pool pool;
    plfx_camera_cfg cfg;
    plfx_camera_count count;
    uint8_t taken[SLOTS];
    uint32_t sequence, last_good;
    int32_t running;
} sensor;

static sensor the_sensor;

/* BOARD: set the sensor up; refuse what it cannot do. */
static plfx_status camera_open(void *context, plfx_camera_cfg *cfg,
                               const plfx_pool *pool)
{
    sensor *s = context;

    if ((cfg->w != 0 && cfg->w != TEMPLATE_W) ||
        (cfg->h != 0 && cfg->h != TEMPLATE_H) || pool->slots < 1 ||
        pool->slots > SLOTS) {
        return PLFX_E_ARG;
    }
    if (pool->slot_size < (size_t)TEMPLATE_W * TEMPLATE_H) {
        return PLFX_E_SIZE;
    }
    cfg->w = TEMPLATE_W;
    cfg->h = TEMPLATE_H;
    cfg->format = PLFX_RAW_U8;
    cfg->bits = 8;
    memset(s, 0, sizeof *s);
    s->pool = *pool;
    s->cfg = *cfg;
    return PLFX_OK;
}

/* BOARD: give the first free slot to the DMA and start it. */
static plfx_status camera_start(void *context)
{
    sensor *s = context;

    memset(&s->count, 0, sizeof s->count);
    memset(s->taken, 0, sizeof s->taken);
    s->sequence = 0;
    s->last_good = 0;
    s->running = 1;
    return PLFX_OK;
}

/* BOARD: wait for the end-of-frame interrupt, at most timeout_ms.  Returns 1 when a
 * frame lies in `slot`, whole; 0 when none came; -1 when one came short. */
static int32_t wait_for_frame(sensor *s, int32_t slot, uint32_t timeout_ms)
{
    uint8_t *px = s->pool.bytes + (size_t)slot * s->pool.slot_size;

    (void)timeout_ms;
    s->sequence++; /* BOARD: the sensor's own counter */
    memset(px, (int)(s->sequence & 255u), (size_t)TEMPLATE_W * TEMPLATE_H);
    return 1;
}

static int32_t free_slot(const sensor *s)
{
    int32_t k;

    for (k = 0; k < s->pool.slots; k++) {
        if (s->taken[k] == 0u) {
            return k;
        }
    }
    return -1;
}

static plfx_status camera_acquire(void *context, uint32_t timeout_ms,
                                  plfx_camera_frame *frame)
{
    sensor *s = context;
    int32_t slot = free_slot(s);
    int32_t came;

    if (!s->running || slot < 0) {
        s->count.starved += s->running != 0;
        return PLFX_E_STATE;
    }
    came = wait_for_frame(s, slot, timeout_ms);
    if (came <= 0) {
        s->count.incomplete += came < 0;
        return PLFX_E_TIMEOUT;
    }
    memset(frame, 0, sizeof *frame);
    frame->raw.bytes = s->pool.bytes + (size_t)slot * s->pool.slot_size;
    frame->raw.size = (size_t)TEMPLATE_W * TEMPLATE_H;
    frame->raw.format = s->cfg.format;
    frame->raw.bits = s->cfg.bits;
    frame->raw.w = TEMPLATE_W;
    frame->raw.h = TEMPLATE_H;
    frame->rows = TEMPLATE_H;
    frame->slot = slot;
    frame->time_ns = now_ns(NULL); /* BOARD: minus half of the exposure */
    frame->clock = PLFX_CLOCK_MONOTONIC;
    frame->sequence = s->sequence;
    frame->dropped = s->sequence - s->last_good - 1u;
    s->count.missed += frame->dropped;
    s->count.good++;
    s->last_good = s->sequence;
    s->taken[slot] = 1;
    return PLFX_OK;
}

static plfx_status camera_release(void *context, const plfx_camera_frame *frame)
{
    sensor *s = context;

    if (frame->slot < 0 || frame->slot >= s->pool.slots ||
        s->taken[frame->slot] == 0u) {
        return PLFX_E_ARG;
    }
    s->taken[frame->slot] = 0;
    return PLFX_OK;
}

/* BOARD: stop the DMA. */
static plfx_status camera_stop(void *context)
{
    ((sensor *)context)->running = 0;
    return PLFX_OK;
}

static void camera_count(void *context, plfx_camera_count *count)
{
    *count = ((const sensor *)context)->count;
}

/* BOARD: power the sensor down. */
static void camera_close(void *context)
{
    ((sensor *)context)->running = 0;
}

plfx_camera plfx_template_camera(void)
{
    plfx_camera c;

    c.context = &the_sensor;
    c.open = camera_open;
    c.start = camera_start;
    c.acquire = camera_acquire;
    c.rows = NULL;
    c.release = camera_release;
    c.stop = camera_stop;
    c.count = camera_count;
    c.close = camera_close;
    return c;
}
