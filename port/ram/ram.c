/* SPDX-License-Identifier: MIT */
#include "ram.h"

#include <string.h>

#define ERASED 0xffu

/* What an operation shall do: how many of its n bytes come about, what it returns. */
typedef struct fate {
    uint32_t bytes;
    plfx_status status;
    int32_t flip; /* 1: bit ram->tear of the range is left wrong */
} fate;

static fate fate_of(plfx_ram *ram, uint32_t n)
{
    fate f = {n, PLFX_OK, 0};
    uint32_t now = ram->count++;
    int32_t due = now == ram->when;

    if (ram->off) {
        f.bytes = 0;
        f.status = PLFX_E_IO;
        return f;
    }
    if (ram->fault == PLFX_RAM_FAIL_EVER) {
        due = now >= ram->when;
    }
    if (!due || ram->fault == PLFX_RAM_SOUND) {
        return f;
    }
    ram->last_size = n;
    f.flip = ram->fault == PLFX_RAM_FLIP;
    if (ram->fault == PLFX_RAM_CUT) {
        f.bytes = ram->tear < n ? ram->tear : n;
        ram->off = 1;
    } else if (!f.flip) {
        f.bytes = 0;
    }
    f.status = f.flip || ram->fault == PLFX_RAM_DEAF ? PLFX_OK : PLFX_E_IO;
    return f;
}

static void flip(plfx_ram *ram, const fate *f, uint32_t at, uint32_t n)
{
    if (f->flip && ram->tear / 8u < n) {
        ram->bytes[at + ram->tear / 8u] ^= (uint8_t)(1u << ram->tear % 8u);
    }
}

static plfx_status misuse(plfx_ram *ram)
{
    ram->misused++;
    return PLFX_E_ARG;
}

static int outside(const plfx_ram *ram, uint32_t at, uint32_t n)
{
    return at > ram->block.size || n > ram->block.size - at;
}

static plfx_status ram_read(void *context, uint32_t at, void *data, uint32_t n)
{
    plfx_ram *ram = context;

    if (outside(ram, at, n)) {
        return misuse(ram);
    }
    if (ram->off) {
        return PLFX_E_IO;
    }
    memcpy(data, ram->bytes + at, n);
    return PLFX_OK;
}

static plfx_status ram_program(void *context, uint32_t at, const void *data, uint32_t n)
{
    plfx_ram *ram = context;
    const uint8_t *from = data;
    uint32_t i;
    fate f;

    if (outside(ram, at, n) || at % ram->block.program_size != 0u ||
        n % ram->block.program_size != 0u) {
        return misuse(ram);
    }
    for (i = 0; i < n; i++) {
        if (ram->worn[at + i]) {
            return misuse(ram);
        }
    }
    f = fate_of(ram, n);
    for (i = 0; i < f.bytes; i++) {
        ram->bytes[at + i] &= from[i];
        ram->worn[at + i] = 1;
    }
    flip(ram, &f, at, n);
    return f.status;
}

static plfx_status ram_erase(void *context, uint32_t at)
{
    plfx_ram *ram = context;
    fate f;

    if (outside(ram, at, ram->block.erase_size) || at % ram->block.erase_size != 0u) {
        return misuse(ram);
    }
    f = fate_of(ram, ram->block.erase_size);
    memset(ram->bytes + at, ERASED, f.bytes);
    memset(ram->worn + at, 0, f.bytes);
    flip(ram, &f, at, ram->block.erase_size);
    return f.status;
}

static plfx_status ram_sync(void *context)
{
    return fate_of(context, 0).status;
}

plfx_status plfx_ram_init(plfx_ram *ram, uint8_t *bytes, uint8_t *worn, uint32_t size,
                          uint32_t erase_size, uint32_t program_size)
{
    if (!ram || !bytes || !worn || erase_size == 0u || program_size == 0u ||
        size % erase_size != 0u || erase_size % program_size != 0u) {
        return PLFX_E_ARG;
    }
    memset(ram, 0, sizeof *ram);
    memset(bytes, ERASED, size);
    memset(worn, 0, size);
    ram->bytes = bytes;
    ram->worn = worn;
    ram->block.context = ram;
    ram->block.read = ram_read;
    ram->block.program = ram_program;
    ram->block.erase = ram_erase;
    ram->block.sync = ram_sync;
    ram->block.size = size;
    ram->block.erase_size = erase_size;
    ram->block.program_size = program_size;
    ram->block.erased = ERASED;
    ram->block.map = bytes;
    plfx_ram_power(ram);
    return PLFX_OK;
}

void plfx_ram_power(plfx_ram *ram)
{
    ram->fault = PLFX_RAM_SOUND;
    ram->when = 0;
    ram->tear = 0;
    ram->count = 0;
    ram->off = 0;
}
