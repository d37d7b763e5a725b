/* SPDX-License-Identifier: MIT
 * An OpenCL driver that runs nothing: it counts what is held, has limits, and fails
 * where it is told to.  The test links it instead of a real one. */
#ifndef PLENOFIX_TESTS_FAKE_CL_H
#define PLENOFIX_TESTS_FAKE_CL_H

#include <stdint.h>

typedef struct fake_cl {
    int32_t platforms, devices;
    uint64_t memory;     /* of the device, bytes: what clCreateBuffer gives at most */
    uint64_t told;       /* of the device, as it says itself */
    uint32_t group;      /* largest work-group */
    int32_t list_error;  /* of clGetDeviceIDs */
    int32_t build_error; /* of clBuildProgram */
    int32_t fail_at;     /* this call that can fail does, counted from 1; 0: none */
    int32_t error;       /* what it returns */
    int32_t lost;        /* 1: the device does not answer any more */

    int32_t calls;     /* that can fail, so far */
    int32_t held;      /* contexts, queues, programs, kernels, buffers, events */
    int32_t launches;  /* of kernels */
    uint64_t used;     /* bytes of buffers */
    uint64_t largest;  /* work-items of a group */
    uint64_t up, down; /* bytes moved by frames */
} fake_cl;

extern fake_cl fake;

/* One sound device, nothing held. */
void fake_reset(void);

#endif
