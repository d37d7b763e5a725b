/* SPDX-License-Identifier: MIT
 * A block device in memory that fails on purpose, for tests of what is stored.
 * Stricter than flash: misaligned calls and a second program of a unit are refused
 * and counted. */
#ifndef PLENOFIX_PORT_RAM_H
#define PLENOFIX_PORT_RAM_H

#include "plenofix/port.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum plfx_ram_fault {
    PLFX_RAM_SOUND = 0,
    PLFX_RAM_FAIL_ONCE, /* operation `when` does nothing and returns E_IO */
    PLFX_RAM_FAIL_EVER, /* so does every one from `when` on */
    PLFX_RAM_CUT,  /* power goes during operation `when` after `tear` of its bytes */
    PLFX_RAM_FLIP, /* operation `when` leaves bit `tear` of its range wrong */
    PLFX_RAM_DEAF  /* operation `when` does nothing and says PLFX_OK */
} plfx_ram_fault;

typedef struct plfx_ram {
    uint8_t *bytes;     /* of the caller */
    uint8_t *worn;      /* one a byte: programmed since it was erased */
    plfx_block block;   /* give &ram->block to plfx_store_open() */
    uint8_t fault;      /* plfx_ram_fault */
    uint32_t when;      /* counted from 0 over program, erase and sync */
    uint32_t tear;      /* bytes, or a bit */
    uint32_t count;     /* operations so far; reads do not count */
    uint32_t misused;   /* calls against the rules of port.h */
    int32_t off;        /* 1: power is cut; nothing works until plfx_ram_power() */
    uint32_t last_size; /* bytes of operation `when`, 0 for a sync */
} plfx_ram;

/* `size` bytes each at bytes and worn, erased.  PLFX_OK, PLFX_E_ARG. */
plfx_status plfx_ram_init(plfx_ram *ram, uint8_t *bytes, uint8_t *worn, uint32_t size,
                          uint32_t erase_size, uint32_t program_size) PLFX_MUST_USE;

/* Power on, no fault planned, counter at 0. */
void plfx_ram_power(plfx_ram *ram);

#ifdef __cplusplus
}
#endif
#endif
