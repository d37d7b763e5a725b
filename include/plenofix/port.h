/* SPDX-License-Identifier: MIT
 * What the library can use of a board: cameras, storage, clocks, as small structures
 * of callbacks.  The core never includes this header; port/PORTING.md tells how to
 * fill it in.
 *
 * Every callback gets the structure's `context` first and returns PLFX_OK, or a
 * negative status: E_ARG (misuse), E_IO and E_DEVICE (the hardware failed),
 * E_TIMEOUT (nothing yet), E_STATE (a call out of order).  A callback never keeps a
 * pointer that it was given, but for the pool of an open camera. */
#ifndef PLENOFIX_PORT_H
#define PLENOFIX_PORT_H

#include "plenofix/raw.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Clocks ---- */

typedef enum plfx_clock_id {
    PLFX_CLOCK_NONE = 0,  /* no time known */
    PLFX_CLOCK_MONOTONIC, /* this machine's, from an arbitrary start, never back */
    PLFX_CLOCK_CAMERA,    /* the camera's own counter */
    PLFX_CLOCK_PTP,       /* camera locked to IEEE 1588 */
    PLFX_CLOCK_UTC        /* this machine's civil time; may be set back */
} plfx_clock_id;

typedef struct plfx_clock {
    void *context;
    uint64_t (*now_ns)(void *context);
    plfx_status (*sleep_until)(void *context, uint64_t ns); /* may be NULL: poll */
    uint8_t id;                                             /* plfx_clock_id */
} plfx_clock;

/* ---- Cameras ---- */

/* Memory for frames, the caller's: `slots` pieces of `slot_size` bytes, a multiple
 * of PLFX_ALIGN, from `bytes` on, aligned to PLFX_ALIGN.  A camera fills frames in
 * place. */
typedef struct plfx_pool {
    uint8_t *bytes;
    size_t slot_size;
    int32_t slots; /* 2 or more to grab while another frame is being read */
} plfx_pool;

typedef struct plfx_camera_cfg {
    int32_t w, h;         /* pixels; 0: as the camera stands */
    int32_t x0, y0;       /* first column and row on the sensor */
    uint8_t format, bits; /* plfx_raw_format, significant bits */
    uint8_t bayer;        /* plfx_bayer */
    uint32_t exposure_us; /* 0: as the camera stands */
    int32_t gain_mdb;  /* thousandths of a decibel; INT32_MIN: as the camera stands */
    uint32_t rate_mhz; /* thousandths of a frame a second; 0: as the camera stands */
    uint32_t packet_size; /* bytes on the wire; 0: the port's choice */
} plfx_camera_cfg;

typedef struct plfx_camera_frame {
    plfx_raw raw;      /* valid until released; in the pool, or in a driver's memory */
    uint64_t time_ns;  /* middle of the exposure where known, else of arrival */
    uint8_t clock;     /* plfx_clock_id of time_ns */
    uint8_t bayer;     /* plfx_bayer */
    int32_t slot;      /* of the pool */
    int32_t rows;      /* rows present: raw.h, or fewer from a camera with `rows` */
    uint32_t sequence; /* the camera's frame counter, widened: it never repeats */
    uint32_t dropped;  /* frames lost or thrown away since the frame before this one */
} plfx_camera_frame;

/* What went wrong so far, all since `start`. */
typedef struct plfx_camera_count {
    uint64_t good;       /* handed out */
    uint64_t incomplete; /* arrived with bytes missing: never handed out */
    uint64_t missed;     /* numbers skipped by the frame counter */
    uint64_t starved;    /* no slot of the pool was free */
    uint64_t misfit;     /* another size or format than was agreed on */
    uint64_t back;       /* time stamps earlier than the one before */
} plfx_camera_count;

typedef struct plfx_camera {
    void *context;
    /* Agree on a configuration and take the pool; *cfg becomes what holds.  E_ARG: the
     * camera cannot do it; E_SIZE: a slot is too small; E_DEVICE: absent. */
    plfx_status (*open)(void *context, plfx_camera_cfg *cfg, const plfx_pool *pool);
    plfx_status (*start)(void *context);
    /* The next whole frame.  E_TIMEOUT: none in time; E_DEVICE: the camera is gone. */
    plfx_status (*acquire)(void *context, uint32_t timeout_ms,
                           plfx_camera_frame *frame);
    /* May be NULL.  Else acquire may return when a frame begins, and this waits
     * until its first `want` rows are present and sets frame->rows.  E_FORMAT: the
     * frame turned out broken; what was made of it must be dropped. */
    plfx_status (*rows)(void *context, plfx_camera_frame *frame, int32_t want,
                        uint32_t timeout_ms);
    plfx_status (*release)(void *context, const plfx_camera_frame *frame);
    plfx_status (*stop)(void *context);
    void (*count)(void *context, plfx_camera_count *count);
    void (*close)(void *context); /* after this the pool is the caller's again */
} plfx_camera;

/* ---- Storage ---- */

/* A device that is erased by blocks and programmed by units.  An erased byte reads as
 * `erased`.  A unit is programmed once between two erasures. */
typedef struct plfx_block {
    void *context;
    plfx_status (*read)(void *context, uint32_t at, void *data, uint32_t n);
    /* at and n are multiples of program_size. */
    plfx_status (*program)(void *context, uint32_t at, const void *data, uint32_t n);
    /* Erase the block that begins at `at`, a multiple of erase_size. */
    plfx_status (*erase)(void *context, uint32_t at);
    /* Returns when all that was programmed or erased would survive a power cut. */
    plfx_status (*sync)(void *context);
    uint32_t size;         /* bytes, a multiple of erase_size */
    uint32_t erase_size;   /* a multiple of program_size */
    uint32_t program_size; /* 1 .. 256, a power of two */
    uint8_t erased;        /* 0xff for flash */
    const uint8_t *map;    /* the device in the address space, or NULL */
} plfx_block;

#ifdef __cplusplus
}
#endif
#endif
