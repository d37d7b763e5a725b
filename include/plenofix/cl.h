/* SPDX-License-Identifier: MIT
 * The dense path on an OpenCL 1.2 device, bit-equal to the core: raw frame or views ->
 * slope, confidence, flags and depth.  Library plenofix_cl, above the core and never
 * included by it.
 *
 * A context belongs to one plan.  All device memory is taken by plfx_cl_open(); a frame
 * allocates nothing.  Two frames may be in flight: submit the next one before the last
 * is fetched, and its transfer hides behind the work.  One context is used by one
 * thread at a time. */
#ifndef PLENOFIX_CL_H
#define PLENOFIX_CL_H

#include "plenofix/depth.h"
#include "plenofix/plan.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_CL_SLOTS   2
#define PLFX_CL_KERNELS 13
#define PLFX_CL_PLANES  4
#define PLFX_CL_BUFFERS 24

typedef struct plfx_cl_info { /* what a device says of itself */
    char name[128], platform[128];
    uint64_t memory, local_memory; /* bytes */
    uint32_t units, group;         /* compute units, largest work-group */
} plfx_cl_info;

typedef struct plfx_cl_input { /* what a frame is; all 0 for ready-made views */
    const plfx_lut *lut;       /* NULL: frames are blocks of views */
    uint8_t format, bits;      /* of raw frames: plfx_raw_format, significant bits */
    uint8_t white;             /* use the table's GAIN section */
    plfx_tone tone;            /* bits as in the plan */
    const plfx_optics *optics; /* NULL: no depth */
} plfx_cl_input;

/* Complete for declaration only; the fields belong to the library. */
typedef struct plfx_cl {
    void *context, *program;
    void *queue_up, *queue_work, *queue_down;
    void *kernel[PLFX_CL_KERNELS];
    void *buffer[PLFX_CL_BUFFERS];
    void *uploaded[PLFX_CL_SLOTS], *worked[PLFX_CL_SLOTS];
    void *input[PLFX_CL_SLOTS], *output[PLFX_CL_SLOTS][PLFX_CL_PLANES];
    plfx_plan plan;
    size_t input_bytes;
    uint64_t bytes; /* of device memory taken */
    int32_t params[44];
    int32_t raw_w, raw_h, from_raw, format, depth;
    size_t group_x, group_y;
    uint32_t table_crc;  /* of the table uploaded */
    int32_t head, count; /* slot of the oldest frame in flight, frames in flight */
    int32_t timing;      /* 1: wait for every kernel and add up its time */
    uint64_t kernel_ns[PLFX_CL_KERNELS];
    char message[256]; /* what the last failure was, in words */
} plfx_cl;

/* Devices of all platforms; 0 when there is none. */
int32_t plfx_cl_devices(void);

/* Why there is none, into message[n].  PLFX_OK when there is one (an empty message),
 * PLFX_E_DEVICE: no driver, or a driver that lists no device, as PoCL does where it
 * cannot write its kernel cache.  PLFX_E_ARG. */
plfx_status plfx_cl_look(char *message, size_t n) PLFX_MUST_USE;

/* PLFX_OK, PLFX_E_ARG (no such device), PLFX_E_DEVICE. */
plfx_status plfx_cl_describe(int32_t device, plfx_cl_info *info) PLFX_MUST_USE;

/* Device memory that plfx_cl_open() will take, bytes; 0 if the arguments do not fit. */
uint64_t plfx_cl_bytes(const plfx_plan *plan, const plfx_cl_input *input);

/* Build the kernels, take the memory, upload table and plan.  On failure nothing is
 * held and cl->message says why, with the first line of what the kernels' compiler
 * said.  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE (not enough device memory), PLFX_E_DEVICE. */
plfx_status plfx_cl_open(plfx_cl *cl, int32_t device, const plfx_plan *plan,
                         const plfx_cl_input *input) PLFX_MUST_USE;

/* The same context for another plan and input that need the same memory: other slopes,
 * limits or tone, the same sizes and table.  Nothing is built and nothing is taken.
 * PLFX_OK, PLFX_E_ARG (a frame of another kind: open another context), PLFX_E_STATE
 * (frames in flight), PLFX_E_DEVICE. */
plfx_status plfx_cl_retune(plfx_cl *cl, const plfx_plan *plan,
                           const plfx_cl_input *input) PLFX_MUST_USE;

/* Start a frame: `bytes` is a raw frame in the input's format, or a views block
 * (uint16, banded).  The memory may be reused when the call returns.  PLFX_OK,
 * PLFX_E_ARG, PLFX_E_SIZE (n too small), PLFX_E_STATE (PLFX_CL_SLOTS frames in flight),
 * PLFX_E_DEVICE. */
plfx_status plfx_cl_submit(plfx_cl *cl, const void *bytes, size_t n) PLFX_MUST_USE;

/* Finish the oldest frame into `out`; sigma is PLFX_SIGMA_NONE.  PLFX_OK, PLFX_E_ARG,
 * PLFX_E_STATE (nothing in flight), PLFX_E_DEVICE. */
plfx_status plfx_cl_fetch(plfx_cl *cl, const plfx_map *out) PLFX_MUST_USE;

/* The same with the depth of every lens in micrometres, as plfx_depth_row() gives it:
 * um[y * out->stride + x].  PLFX_E_ARG also when the context has no optics. */
plfx_status plfx_cl_fetch_depth(plfx_cl *cl, const plfx_map *out,
                                uint32_t *um) PLFX_MUST_USE;

/* Give everything back.  Harmless on a zeroed or failed context. */
void plfx_cl_close(plfx_cl *cl);

#ifdef __cplusplus
}
#endif
#endif
