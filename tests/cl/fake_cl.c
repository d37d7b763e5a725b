/* SPDX-License-Identifier: MIT */
#define CL_TARGET_OPENCL_VERSION 120
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include "fake_cl.h"

#include <CL/cl.h>
#include <stdlib.h>
#include <string.h>

fake_cl fake;

typedef struct object { /* whatever a handle points to */
    size_t bytes;
    unsigned char *data;
} object;

void fake_reset(void)
{
    memset(&fake, 0, sizeof fake);
    fake.platforms = fake.devices = 1;
    fake.memory = fake.told = (uint64_t)1 << 30;
    fake.group = 1024;
    fake.error = CL_OUT_OF_HOST_MEMORY;
}

/* Of a call that can fail: its error, or success. */
static cl_int step(void)
{
    fake.calls++;
    if (fake.lost) {
        return CL_DEVICE_NOT_AVAILABLE;
    }
    return fake.calls == fake.fail_at ? fake.error : CL_SUCCESS;
}

static void *make(cl_int e, size_t bytes, cl_int *error)
{
    object *o = NULL;

    if (e == CL_SUCCESS) {
        o = calloc(1, sizeof *o);
        o->bytes = bytes;
        o->data = bytes ? calloc(1, bytes) : NULL;
        fake.held++;
        fake.used += bytes;
    }
    if (error) {
        *error = e;
    }
    return o;
}

static cl_int drop(void *p)
{
    object *o = p;

    if (!o) {
        return CL_INVALID_VALUE;
    }
    fake.held--;
    fake.used -= o->bytes;
    free(o->data);
    free(o);
    return CL_SUCCESS;
}

static cl_int event(cl_int e, cl_event *done)
{
    if (e == CL_SUCCESS && done) {
        *done = make(CL_SUCCESS, 0, NULL);
    }
    return e;
}

static cl_int tell(const void *value, size_t n, size_t room, void *to)
{
    if (n > room) {
        return CL_INVALID_VALUE;
    }
    memcpy(to, value, n);
    return CL_SUCCESS;
}

cl_int clGetPlatformIDs(cl_uint n, cl_platform_id *ids, cl_uint *count)
{
    static int one;

    if (fake.platforms == 0) {
        return -1001; /* what a loader says that finds no driver */
    }
    if (ids && n > 0) {
        ids[0] = (cl_platform_id)(void *)&one;
    }
    *count = (cl_uint)fake.platforms;
    return CL_SUCCESS;
}

cl_int clGetDeviceIDs(cl_platform_id p, cl_device_type type, cl_uint n,
                      cl_device_id *ids, cl_uint *count)
{
    static int one;
    cl_uint k;

    (void)p;
    (void)type;
    for (k = 0; ids && k < n; k++) {
        ids[k] = (cl_device_id)(void *)&one;
    }
    *count = (cl_uint)fake.devices;
    return fake.list_error;
}

cl_int clGetPlatformInfo(cl_platform_id p, cl_platform_info what, size_t room, void *to,
                         size_t *size)
{
    (void)p;
    (void)what;
    (void)size;
    return tell("Fake", 5, room, to);
}

cl_int clGetDeviceInfo(cl_device_id d, cl_device_info what, size_t room, void *to,
                       size_t *size)
{
    cl_ulong memory = fake.told;
    cl_ulong local = 16384;
    cl_uint units = 1;
    size_t group = fake.group;

    (void)d;
    (void)size;
    switch (what) {
    case CL_DEVICE_NAME:
        return tell("fake device", 12, room, to);
    case CL_DEVICE_GLOBAL_MEM_SIZE:
        return tell(&memory, sizeof memory, room, to);
    case CL_DEVICE_LOCAL_MEM_SIZE:
        return tell(&local, sizeof local, room, to);
    case CL_DEVICE_MAX_COMPUTE_UNITS:
        return tell(&units, sizeof units, room, to);
    case CL_DEVICE_MAX_WORK_GROUP_SIZE:
        return tell(&group, sizeof group, room, to);
    default:
        return CL_INVALID_VALUE;
    }
}

cl_context
clCreateContext(const cl_context_properties *p, cl_uint n, const cl_device_id *d,
                void(CL_CALLBACK *f)(const char *, const void *, size_t, void *),
                void *user, cl_int *error)
{
    (void)p;
    (void)n;
    (void)d;
    (void)f;
    (void)user;
    return make(step(), 0, error);
}

cl_command_queue clCreateCommandQueue(cl_context c, cl_device_id d,
                                      cl_command_queue_properties p, cl_int *error)
{
    (void)c;
    (void)d;
    (void)p;
    return make(step(), 0, error);
}

cl_program clCreateProgramWithSource(cl_context c, cl_uint n, const char **text,
                                     const size_t *length, cl_int *error)
{
    (void)c;
    (void)n;
    (void)text;
    (void)length;
    return make(step(), 0, error);
}

cl_int clBuildProgram(cl_program p, cl_uint n, const cl_device_id *d,
                      const char *options, void(CL_CALLBACK *f)(cl_program, void *),
                      void *user)
{
    cl_int e = step();

    (void)p;
    (void)n;
    (void)d;
    (void)options;
    (void)f;
    (void)user;
    return fake.build_error ? fake.build_error : e;
}

cl_int clGetProgramBuildInfo(cl_program p, cl_device_id d, cl_program_build_info what,
                             size_t room, void *to, size_t *size)
{
    static const char log[] = "line 7: no such word\nand more";

    (void)p;
    (void)d;
    (void)what;
    (void)size;
    return tell(log, sizeof log, room, to);
}

cl_kernel clCreateKernel(cl_program p, const char *name, cl_int *error)
{
    (void)p;
    (void)name;
    return make(step(), 0, error);
}

cl_mem clCreateBuffer(cl_context c, cl_mem_flags flags, size_t n, void *host,
                      cl_int *error)
{
    cl_int e = step();

    (void)c;
    (void)flags;
    (void)host;
    return make(e                             ? e
                : fake.used + n > fake.memory ? CL_MEM_OBJECT_ALLOCATION_FAILURE
                                              : CL_SUCCESS,
                n, error);
}

void *clEnqueueMapBuffer(cl_command_queue q, cl_mem m, cl_bool wait, cl_map_flags flags,
                         size_t at, size_t n, cl_uint waits, const cl_event *list,
                         cl_event *done, cl_int *error)
{
    object *o = (object *)(void *)m;
    cl_int e = step();

    (void)q;
    (void)wait;
    (void)flags;
    (void)waits;
    (void)list;
    (void)done;
    *error = e == CL_SUCCESS && at + n > o->bytes ? CL_INVALID_VALUE : e;
    return *error == CL_SUCCESS ? o->data + at : NULL;
}

cl_int clEnqueueUnmapMemObject(cl_command_queue q, cl_mem m, void *p, cl_uint waits,
                               const cl_event *list, cl_event *done)
{
    (void)q;
    (void)m;
    (void)p;
    (void)waits;
    (void)list;
    (void)done;
    return step();
}

cl_int clEnqueueWriteBuffer(cl_command_queue q, cl_mem m, cl_bool wait, size_t at,
                            size_t n, const void *from, cl_uint waits,
                            const cl_event *list, cl_event *done)
{
    object *o = (object *)(void *)m;
    cl_int e = step();

    (void)q;
    (void)wait;
    (void)waits;
    (void)list;
    if (e == CL_SUCCESS) {
        memcpy(o->data + at, from, n);
        fake.up += n;
    }
    return event(e, done);
}

cl_int clEnqueueReadBufferRect(cl_command_queue q, cl_mem m, cl_bool wait,
                               const size_t *origin, const size_t *to_origin,
                               const size_t *region, size_t row, size_t slice,
                               size_t to_row, size_t to_slice, void *to, cl_uint waits,
                               const cl_event *list, cl_event *done)
{
    object *o = (object *)(void *)m;
    cl_int e = step();
    size_t y;

    (void)q;
    (void)wait;
    (void)origin;
    (void)to_origin;
    (void)slice;
    (void)to_slice;
    (void)waits;
    (void)list;
    (void)done;
    for (y = 0; e == CL_SUCCESS && y < region[1]; y++) {
        memcpy((unsigned char *)to + y * to_row, o->data + y * row, region[0]);
        fake.down += region[0];
    }
    return e;
}

cl_int clSetKernelArg(cl_kernel k, cl_uint i, size_t n, const void *value)
{
    (void)k;
    (void)i;
    (void)n;
    (void)value;
    return step();
}

cl_int clEnqueueNDRangeKernel(cl_command_queue q, cl_kernel k, cl_uint dims,
                              const size_t *offset, const size_t *global,
                              const size_t *local, cl_uint waits, const cl_event *list,
                              cl_event *done)
{
    uint64_t items = (uint64_t)local[0] * local[1] * local[2];

    (void)q;
    (void)k;
    (void)dims;
    (void)offset;
    (void)waits;
    (void)list;
    fake.launches++;
    fake.largest = items > fake.largest ? items : fake.largest;
    if (items > fake.group || global[0] % local[0] || global[1] % local[1]) {
        return CL_INVALID_WORK_GROUP_SIZE;
    }
    return event(step(), done);
}

cl_int clEnqueueBarrierWithWaitList(cl_command_queue q, cl_uint n, const cl_event *list,
                                    cl_event *done)
{
    (void)q;
    (void)n;
    (void)list;
    return event(step(), done);
}

cl_int clEnqueueMarkerWithWaitList(cl_command_queue q, cl_uint n, const cl_event *list,
                                   cl_event *done)
{
    (void)q;
    (void)n;
    (void)list;
    return event(step(), done);
}

cl_int clFlush(cl_command_queue q)
{
    (void)q;
    return step();
}

cl_int clFinish(cl_command_queue q)
{
    (void)q;
    return step();
}

cl_int clWaitForEvents(cl_uint n, const cl_event *list)
{
    (void)n;
    (void)list;
    return step();
}

cl_int clGetEventProfilingInfo(cl_event e, cl_profiling_info what, size_t room,
                               void *to, size_t *size)
{
    cl_ulong t = what == CL_PROFILING_COMMAND_END ? 1000 : 0;

    (void)e;
    (void)size;
    return tell(&t, sizeof t, room, to);
}

cl_int clReleaseContext(cl_context p)
{
    return drop(p);
}

cl_int clReleaseCommandQueue(cl_command_queue p)
{
    return drop(p);
}

cl_int clReleaseProgram(cl_program p)
{
    return drop(p);
}

cl_int clReleaseKernel(cl_kernel p)
{
    return drop(p);
}

cl_int clReleaseMemObject(cl_mem p)
{
    return drop(p);
}

cl_int clReleaseEvent(cl_event p)
{
    return drop(p);
}
