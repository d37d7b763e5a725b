/* SPDX-License-Identifier: MIT
 * Two-slot store of a lens table on a block device.
 *
 * The device is halved; each half holds a head and a table.  A new table goes into
 * the half that is not in use: erase, table, sync, read back, then the head, sync.
 * The head is what makes a slot valid, and the other slot is not touched before the
 * next update, so that a power cut at any operation leaves the old table or the new
 * one.  Opening takes the newest slot whose head and table have the right CRC. */
#ifndef PLENOFIX_PORT_STORE_H
#define PLENOFIX_PORT_STORE_H

#include "plenofix/port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_STORE_NONE 0xffffffffu

typedef struct plfx_store {
    const plfx_block *device;
    int32_t slot;        /* in use: 0 or 1; -1: empty */
    uint32_t generation; /* of the table in use: updates so far */
    uint32_t length;     /* of the table in use, bytes */
    uint32_t camera_id;  /* tables of another camera are refused; 0: any */
    uint32_t capacity;   /* longest table that fits, bytes */
    uint32_t wear;       /* erasures that each block of the busier half has seen */
    int32_t fell_back;   /* 1: the newer slot was damaged and the older one is in use */
    uint32_t bad_at;     /* byte of the device where an update failed; _NONE */
} plfx_store;

/* Look at both slots.  A store without a table, empty or damaged, is no error: slot is
 * -1 then.  PLFX_OK, PLFX_E_ARG (geometry), PLFX_E_IO (a half cannot be read and the
 * other holds no table). */
plfx_status plfx_store_open(plfx_store *s, const plfx_block *device,
                            uint32_t camera_id) PLFX_MUST_USE;

/* The table in use, in place; NULL without `map` or table. */
const uint8_t *plfx_store_table(const plfx_store *s);

/* Copy of the table in use.  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE (n under s->length),
 * PLFX_E_STATE (empty), PLFX_E_IO, PLFX_E_FORMAT (it has changed since it was
 * opened). */
plfx_status plfx_store_read(const plfx_store *s, uint8_t *table,
                            uint32_t n) PLFX_MUST_USE;

/* Replace the table.  On an error the old one stays in use; s->bad_at names the
 * place of a failed operation or of bytes that did not read back, and the call may
 * be repeated.  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE (over the capacity), PLFX_E_FORMAT
 * (no valid table, or of another camera), PLFX_E_IO. */
plfx_status plfx_store_write(plfx_store *s, const uint8_t *table,
                             uint32_t n) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
