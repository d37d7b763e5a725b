/* SPDX-License-Identifier: MIT */
#include "store.h"

#include "bytes.h"
#include "crc.h"
#include "plenofix/lut.h"

#include <string.h>

/* Head: magic, generation, length, CRC of the table, CRC of the 16 bytes before. */
#define HEAD     20u
#define UNIT_MAX 256u
#define CHUNK    256u /* bytes moved at a time; a multiple of every program_size */
#define NO_SLOT  (-1)

static const uint8_t magic[4] = {'P', 'S', 'L', 'T'};

typedef struct head {
    uint32_t generation, length, crc;
} head;

static uint32_t round_up(uint32_t n, uint32_t unit)
{
    return (n + unit - 1u) / unit * unit;
}

/* Bytes before the table in a slot: whole units. */
static uint32_t head_size(const plfx_block *d)
{
    return round_up(HEAD, d->program_size);
}

static uint32_t slot_size(const plfx_block *d)
{
    return d->size / d->erase_size / 2u * d->erase_size;
}

static uint32_t slot_at(const plfx_block *d, int32_t slot)
{
    return slot == 0 ? 0u : slot_size(d);
}

static int geometry_ok(const plfx_block *d)
{
    return d && d->read && d->program && d->erase && d->sync && d->program_size >= 1u &&
           d->program_size <= UNIT_MAX &&
           (d->program_size & (d->program_size - 1u)) == 0u &&
           d->erase_size >= d->program_size && d->erase_size % d->program_size == 0u &&
           d->size % d->erase_size == 0u && slot_size(d) > head_size(d);
}

/* CRC of n bytes of the device. */
static plfx_status crc_of(const plfx_block *d, uint32_t at, uint32_t n, uint32_t *crc)
{
    uint8_t part[CHUNK];
    uint32_t done;

    *crc = 0;
    for (done = 0; done < n; done += CHUNK) {
        uint32_t k = n - done < CHUNK ? n - done : CHUNK;
        plfx_status status = d->read(d->context, at + done, part, k);
        if (status != PLFX_OK) {
            return status;
        }
        *crc = plfx_port_crc32(*crc, part, k);
    }
    return PLFX_OK;
}

/* Head of a slot, its table checked.  E_FORMAT: there is none. */
static plfx_status read_slot(const plfx_block *d, int32_t slot, head *h)
{
    uint8_t b[HEAD];
    uint32_t crc;
    plfx_status status = d->read(d->context, slot_at(d, slot), b, HEAD);

    if (status != PLFX_OK) {
        return PLFX_E_IO;
    }
    if (memcmp(b, magic, sizeof magic) != 0 ||
        plfx_port_crc32(0, b, 16) != plfx_load_u32(b + 16)) {
        return PLFX_E_FORMAT;
    }
    h->generation = plfx_load_u32(b + 4);
    h->length = plfx_load_u32(b + 8);
    h->crc = plfx_load_u32(b + 12);
    if (h->length == 0u || h->length > slot_size(d) - head_size(d)) {
        return PLFX_E_FORMAT;
    }
    if (crc_of(d, slot_at(d, slot) + head_size(d), h->length, &crc) != PLFX_OK) {
        return PLFX_E_IO;
    }
    return crc == h->crc ? PLFX_OK : PLFX_E_FORMAT;
}

/* A head that is no head because its bytes are all erased is an empty slot; anything
 * else there is damage. */
static int is_blank(const plfx_block *d, int32_t slot)
{
    uint8_t b[HEAD];
    uint32_t i;

    if (d->read(d->context, slot_at(d, slot), b, HEAD) != PLFX_OK) {
        return 0;
    }
    for (i = 0; i < HEAD; i++) {
        if (b[i] != d->erased) {
            return 0;
        }
    }
    return 1;
}

static void take(plfx_store *s, int32_t slot, const head *h)
{
    s->slot = slot;
    s->generation = h->generation;
    s->length = h->length;
    s->wear = h->generation / 2u + (h->generation & 1u);
}

plfx_status plfx_store_open(plfx_store *s, const plfx_block *device, uint32_t camera_id)
{
    head h[2] = {{0, 0, 0}, {0, 0, 0}};
    plfx_status found[2];
    int32_t newer;

    if (!s || !geometry_ok(device)) {
        return PLFX_E_ARG;
    }
    found[0] = read_slot(device, 0, &h[0]);
    found[1] = read_slot(device, 1, &h[1]);
    if (found[0] != PLFX_OK && found[1] != PLFX_OK &&
        (found[0] == PLFX_E_IO || found[1] == PLFX_E_IO)) {
        return PLFX_E_IO; /* the half that cannot be read may hold the table */
    }
    memset(s, 0, sizeof *s);
    s->device = device;
    s->slot = NO_SLOT;
    s->camera_id = camera_id;
    s->capacity = slot_size(device) - head_size(device);
    s->bad_at = PLFX_STORE_NONE;
    if (found[0] == PLFX_OK && found[1] == PLFX_OK) {
        newer = h[1].generation - h[0].generation < 0x80000000u;
        take(s, newer, &h[newer]);
    } else if (found[0] == PLFX_OK || found[1] == PLFX_OK) {
        newer = found[1] == PLFX_OK;
        take(s, newer, &h[newer]);
        s->fell_back = !is_blank(device, 1 - newer);
    }
    return PLFX_OK;
}

const uint8_t *plfx_store_table(const plfx_store *s)
{
    if (!s || !s->device || !s->device->map || s->slot == NO_SLOT) {
        return NULL;
    }
    return s->device->map + slot_at(s->device, s->slot) + head_size(s->device);
}

plfx_status plfx_store_read(const plfx_store *s, uint8_t *table, uint32_t n)
{
    const plfx_block *d;
    plfx_status status;
    uint32_t at;
    head h;

    if (!s || !s->device || !table) {
        return PLFX_E_ARG;
    }
    if (s->slot == NO_SLOT) {
        return PLFX_E_STATE;
    }
    if (n < s->length) {
        return PLFX_E_SIZE;
    }
    d = s->device;
    at = slot_at(d, s->slot) + head_size(d);
    if (d->read(d->context, at, table, s->length) != PLFX_OK) {
        return PLFX_E_IO;
    }
    status = read_slot(d, s->slot, &h);
    if (status == PLFX_OK && plfx_port_crc32(0, table, s->length) != h.crc) {
        status = PLFX_E_FORMAT;
    }
    return status;
}

/* Note the place of a failure. */
static plfx_status bad(plfx_store *s, uint32_t at)
{
    s->bad_at = at;
    return PLFX_E_IO;
}

/* Program n bytes, the last unit filled up with erased bytes, and read them back. */
static plfx_status put(plfx_store *s, uint32_t at, const uint8_t *data, uint32_t n)
{
    const plfx_block *d = s->device;
    uint8_t part[CHUNK];
    uint32_t done;

    for (done = 0; done < n; done += CHUNK) {
        uint32_t k = n - done < CHUNK ? n - done : CHUNK;
        memset(part, d->erased, sizeof part);
        memcpy(part, data + done, k);
        if (d->program(d->context, at + done, part, round_up(k, d->program_size)) !=
            PLFX_OK) {
            return bad(s, at + done);
        }
    }
    if (d->sync(d->context) != PLFX_OK) {
        return bad(s, at);
    }
    for (done = 0; done < n; done += CHUNK) {
        uint32_t k = n - done < CHUNK ? n - done : CHUNK;
        if (d->read(d->context, at + done, part, k) != PLFX_OK ||
            memcmp(part, data + done, k) != 0) {
            return bad(s, at + done);
        }
    }
    return PLFX_OK;
}

static plfx_status erase_slot(plfx_store *s, uint32_t at, uint32_t n)
{
    const plfx_block *d = s->device;
    uint32_t done;

    for (done = 0; done < n; done += d->erase_size) {
        if (d->erase(d->context, at + done) != PLFX_OK) {
            return bad(s, at + done);
        }
    }
    return d->sync(d->context) == PLFX_OK ? PLFX_OK : bad(s, at);
}

static plfx_status put_head(plfx_store *s, uint32_t at, const head *h)
{
    uint8_t b[HEAD];

    memcpy(b, magic, sizeof magic);
    plfx_store_u32(b + 4, h->generation);
    plfx_store_u32(b + 8, h->length);
    plfx_store_u32(b + 12, h->crc);
    plfx_store_u32(b + 16, plfx_port_crc32(0, b, 16));
    return put(s, at, b, HEAD);
}

static plfx_status check_table(const plfx_store *s, const uint8_t *table, uint32_t n)
{
    plfx_lut lut;
    plfx_status status = plfx_lut_open(&lut, table, n);

    if (status != PLFX_OK || lut.size != n) {
        return PLFX_E_FORMAT;
    }
    return s->camera_id == 0u || lut.camera_id == s->camera_id ? PLFX_OK
                                                               : PLFX_E_FORMAT;
}

plfx_status plfx_store_write(plfx_store *s, const uint8_t *table, uint32_t n)
{
    int32_t slot;
    uint32_t at;
    plfx_status status;
    head h;

    if (!s || !s->device || !table) {
        return PLFX_E_ARG;
    }
    if (n > s->capacity) {
        return PLFX_E_SIZE;
    }
    status = check_table(s, table, n);
    if (status != PLFX_OK) {
        return status;
    }
    slot = s->slot == 0 ? 1 : 0;
    at = slot_at(s->device, slot);
    h.generation = s->generation + 1u;
    h.length = n;
    h.crc = plfx_port_crc32(0, table, n);
    s->bad_at = PLFX_STORE_NONE;
    status = erase_slot(s, at, head_size(s->device) + n);
    if (status == PLFX_OK) {
        status = put(s, at + head_size(s->device), table, n);
    }
    if (status == PLFX_OK) {
        status = put_head(s, at, &h);
    }
    if (status == PLFX_OK) {
        take(s, slot, &h);
        s->fell_back = 0;
    }
    return status;
}
