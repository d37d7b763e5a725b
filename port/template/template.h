/* SPDX-License-Identifier: MIT
 * Where a port begins: a board with a camera, a flash and a timer.  As it stands the
 * board is memory, so that it builds and passes its self-test on any machine;
 * replace the functions marked BOARD in board.c one after the other and run the
 * self-test after each (port/PORTING.md). */
#ifndef PLENOFIX_PORT_TEMPLATE_H
#define PLENOFIX_PORT_TEMPLATE_H

#include "plenofix/port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TEMPLATE_W 64 /* of the sensor, pixels */
#define TEMPLATE_H 48

plfx_clock plfx_template_clock(void);
plfx_block plfx_template_flash(void);
plfx_camera plfx_template_camera(void);

/* What the self-tests found; 0 everywhere is good. */
typedef struct plfx_template_report {
    uint32_t clock_back;    /* readings earlier than the one before */
    uint32_t store_errors;  /* failed operations */
    uint32_t wrong_bytes;   /* that did not come back as written */
    uint32_t frame_errors;  /* acquire or release failed */
    uint32_t frame_outside; /* frames outside the pool and of no other known place */
    uint32_t frame_numbers; /* sequence and dropped disagree */
    uint32_t frame_times;   /* times that go back */
} plfx_template_report;

/* Erases the flash.  Each adds to the report. */
void plfx_template_selftest_clock(const plfx_clock *clock, plfx_template_report *r);
void plfx_template_selftest_storage(const plfx_block *flash, plfx_template_report *r);
void plfx_template_selftest_camera(const plfx_camera *camera, const plfx_pool *pool,
                                   int32_t frames, plfx_template_report *r);

#ifdef __cplusplus
}
#endif
#endif
