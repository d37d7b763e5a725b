/* SPDX-License-Identifier: MIT
 * What the files of plenofix_cl share: buffers, kernels, errors. */
#ifndef PLENOFIX_CL_STATE_H
#define PLENOFIX_CL_STATE_H

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include "plenofix/cl.h"
#include "params.h"

extern const char plfx_cl_source[]; /* kernels and what is pasted before them */

enum {
    B_PARAMS,
    B_FRAME,   /* unpacked raw frame */
    B_CENTRE,  /* lens centres, int2 q16 */
    B_OFFSET,  /* view offsets, int2 q16 */
    B_MISSING, /* one byte a lens */
    B_GAIN,    /* white gain of every view sample */
    B_VIEWS,
    B_PADDED,    /* views with replicated borders */
    B_SHIFT,     /* int2 q4 of every view and label */
    B_SPAN,      /* short4 of every pair and label */
    B_ITEM,      /* SAD of one lens, every label */
    B_COLUMN,    /* its vertical sums */
    B_PAIR_SUMS, /* vertical moments of a pair, three planes a label */
    B_SUMS,      /* vertical moments and texture of the reference */
    B_SLOPE,     /* results of every pair */
    B_CONF,
    B_WEIGHT,
    B_FLAGS,
    B_BASELINE,
    B_CELLS, /* gradient products */
    B_COUNT
};
PLFX_STATIC_ASSERT(B_COUNT <= PLFX_CL_BUFFERS, buffers_fit);
PLFX_STATIC_ASSERT(CL_PARAMS <= 44, params_fit);

enum {
    K_UNPACK,
    K_EXTRACT,
    K_PAD,
    K_SAD_ITEMS,
    K_SAD_COLUMNS,
    K_SAD_WINNERS,
    K_REF_COLUMNS,
    K_ZNCC_COLUMNS,
    K_ZNCC_WINNERS,
    K_FUSE,
    K_GRADIENT_PRODUCTS,
    K_GRADIENT_MAP,
    K_DEPTH,
    K_COUNT
};
extern const char *const plfx_cl_kernel_name[K_COUNT];
PLFX_STATIC_ASSERT(K_COUNT <= PLFX_CL_KERNELS, kernels_fit);

/* Bytes of every buffer, 0 where the plan does not use it; bytes of one frame of
 * input. */
typedef struct plfx_cl_sizes {
    uint64_t buffer[B_COUNT];
    uint64_t input, lenses;
} plfx_cl_sizes;
plfx_cl_sizes plfx_cl_sizes_of(const plfx_plan *plan, const plfx_cl_input *input);

/* Columns of replicated border: the farthest sample and its neighbour. */
int32_t plfx_cl_pad(const plfx_plan *plan);

/* 1 when the pair fits together. */
int32_t plfx_cl_input_ok(const plfx_plan *plan, const plfx_cl_input *input);

/* Note what failed in cl->message; PLFX_E_DEVICE. */
plfx_status plfx_cl_fail(plfx_cl *cl, const char *what, cl_int error);

/* Append to a text in room bytes; what does not fit is cut. */
void plfx_cl_append(char *to, size_t room, const char *text);

/* The n-th device over all platforms; 0 when there is none. */
int32_t plfx_cl_device_at(int32_t n, cl_device_id *device, cl_platform_id *platform);

/* Fill the tables of a plan on the device.  0 or an OpenCL error. */
cl_int plfx_cl_upload_plan(plfx_cl *cl);
cl_int plfx_cl_upload_table(plfx_cl *cl, const plfx_cl_input *input);

#endif
