/* SPDX-License-Identifier: MIT
 * What can be seen of a board from outside.  Runs on the board, without libc but memory
 * functions, in about 2 KiB of stack. */
#include "template.h"

#include "plenofix/lut.h"
#include "store/store.h"

#include <string.h>

#define READINGS 1000
#define TABLE    256u
#define UPDATES  6
#define PATIENCE 1000u /* ms for a frame */

void plfx_template_selftest_clock(const plfx_clock *clock, plfx_template_report *r)
{
    uint64_t before = clock->now_ns(clock->context);
    int32_t k;

    for (k = 0; k < READINGS; k++) {
        uint64_t now = clock->now_ns(clock->context);
        r->clock_back += now < before;
        before = now;
    }
}

/* A small valid table that carries number k. */
static uint32_t table_of(uint8_t *table, uint32_t k)
{
    plfx_lut_desc d;
    uint32_t n;

    memset(&d, 0, sizeof d);
    d.camera_id = k + 1u;
    d.sensor_w = 40;
    d.sensor_h = 40;
    d.sensor_bits = 8;
    d.lattice.nx = 2;
    d.lattice.ny = 2;
    d.lattice.origin.x_q16 = 10 * 65536;
    d.lattice.origin.y_q16 = 10 * 65536;
    d.lattice.a.x_q22 = 10 * 4194304;
    d.lattice.b.y_q22 = 10 * 4194304;
    n = (uint32_t)plfx_lut_bytes(&d);
    return n <= TABLE && plfx_lut_write(&d, table, TABLE) == PLFX_OK ? n : 0u;
}

/* One update, then everything anew, as after a start. */
static void update(const plfx_block *flash, uint32_t k, plfx_template_report *r)
{
    uint8_t table[TABLE];
    uint8_t back[TABLE];
    uint32_t n = table_of(table, k);
    plfx_store s;
    uint32_t i;

    if (plfx_store_open(&s, flash, 0) != PLFX_OK ||
        plfx_store_write(&s, table, n) != PLFX_OK ||
        plfx_store_open(&s, flash, 0) != PLFX_OK || s.length != n ||
        plfx_store_read(&s, back, TABLE) != PLFX_OK) {
        r->store_errors++;
        return;
    }
    for (i = 0; i < n; i++) {
        r->wrong_bytes += back[i] != table[i];
        r->wrong_bytes += flash->map && plfx_store_table(&s)[i] != table[i];
    }
}

void plfx_template_selftest_storage(const plfx_block *flash, plfx_template_report *r)
{
    uint32_t k;

    for (k = 0; k < UPDATES; k++) {
        update(flash, k, r);
    }
}

static void check_frame(const plfx_camera_frame *f, const plfx_camera_frame *before,
                        const plfx_pool *pool, plfx_template_report *r)
{
    size_t room = pool->slot_size * (size_t)pool->slots;

    r->frame_outside +=
        f->raw.bytes < pool->bytes || f->raw.bytes >= pool->bytes + room;
    if (before->raw.bytes != NULL) {
        r->frame_numbers += f->sequence != before->sequence + 1u + f->dropped;
        r->frame_times += f->time_ns < before->time_ns;
    }
}

void plfx_template_selftest_camera(const plfx_camera *camera, const plfx_pool *pool,
                                   int32_t frames, plfx_template_report *r)
{
    plfx_camera_cfg cfg;
    plfx_camera_frame f;
    plfx_camera_frame before;
    int32_t k;

    memset(&cfg, 0, sizeof cfg);
    memset(&before, 0, sizeof before);
    cfg.gain_mdb = INT32_MIN;
    if (camera->open(camera->context, &cfg, pool) != PLFX_OK) {
        r->frame_errors++;
        return;
    }
    if (camera->start(camera->context) != PLFX_OK) {
        r->frame_errors++;
        camera->close(camera->context); /* the pool is the caller's again */
        return;
    }
    for (k = 0; k < frames; k++) {
        if (camera->acquire(camera->context, PATIENCE, &f) != PLFX_OK) {
            r->frame_errors++;
            continue;
        }
        check_frame(&f, &before, pool, r);
        before = f;
        r->frame_errors += camera->release(camera->context, &f) != PLFX_OK;
    }
    r->frame_errors += camera->stop(camera->context) != PLFX_OK;
    camera->close(camera->context);
}
