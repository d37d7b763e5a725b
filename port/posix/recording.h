/* SPDX-License-Identifier: MIT
 * Recordings: raw frames of one size in one file, each under its own CRC
 * (src/FORMAT.md).  Records have a fixed stride and there is no index: record i lies
 * at 4096 + i*stride.  A recording that was cut off at any byte is good up to its
 * last whole record. */
#ifndef PLENOFIX_PORT_RECORDING_H
#define PLENOFIX_PORT_RECORDING_H

#include "plenofix/port.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct plfx_recording_info {
    int32_t w, h;
    uint8_t format, bits; /* plfx_raw_format but U16, significant bits */
    uint8_t bayer;        /* plfx_bayer */
    uint32_t camera_id;   /* 0: none given */
    uint32_t table_crc;   /* plfx_lut.crc of the table that belongs to it; 0: none */
} plfx_recording_info;

typedef struct plfx_recording {
    plfx_recording_info info;
    int file; /* descriptor, -1 when closed */
    int writable;
    int error;        /* errno of the last E_IO */
    uint32_t payload; /* bytes of a frame */
    uint64_t stride;  /* bytes from record to record */
    uint64_t count;   /* whole records */
    uint64_t synced;  /* records that are on the medium for certain */
    uint64_t cut;     /* bytes behind the last whole record, found when it was opened */
} plfx_recording;

/* A new recording; a file of that name is not overwritten (errno EEXIST).  After an
 * error there is no new file.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_IO. */
plfx_status plfx_recording_create(plfx_recording *r, const char *path,
                                  const plfx_recording_info *info) PLFX_MUST_USE;

/* Open for reading, or to go on: then what follows the last whole record is cut off.
 * Walks back from the end to the first record whose CRCs hold.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_IO, PLFX_E_FORMAT (no recording). */
plfx_status plfx_recording_open(plfx_recording *r, const char *path,
                                int append) PLFX_MUST_USE;

/* Append a frame of the recording's size and format, in one write.  On E_IO (disk full)
 * what was written of it is cut off again and earlier frames stay.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_STATE (not writable), PLFX_E_IO. */
plfx_status plfx_recording_add(plfx_recording *r,
                               const plfx_camera_frame *frame) PLFX_MUST_USE;

/* Wait until all records are on the medium.  PLFX_OK, PLFX_E_IO, PLFX_E_STATE. */
plfx_status plfx_recording_sync(plfx_recording *r) PLFX_MUST_USE;

/* Head of record i and, where `bytes` is not NULL, its payload checked against its CRC.
 * frame->raw.bytes is `bytes`.  PLFX_OK, PLFX_E_ARG (i), PLFX_E_SIZE (n under payload),
 * PLFX_E_IO, PLFX_E_FORMAT (damaged). */
plfx_status plfx_recording_read(plfx_recording *r, uint64_t i, uint8_t *bytes, size_t n,
                                plfx_camera_frame *frame) PLFX_MUST_USE;

/* Ask the system to fetch records i .. i+n-1 ahead of time. */
void plfx_recording_ahead(const plfx_recording *r, uint64_t i, uint64_t n);

void plfx_recording_close(plfx_recording *r);

#ifdef __cplusplus
}
#endif
#endif
