/* SPDX-License-Identifier: MIT
 * Finding devices. */
#include "cl_state.h"

#include <string.h>

#define PLATFORMS 16

static cl_uint platforms(cl_platform_id ids[PLATFORMS])
{
    cl_uint n = 0;

    if (clGetPlatformIDs(PLATFORMS, ids, &n) != CL_SUCCESS) {
        return 0;
    }
    return n < PLATFORMS ? n : PLATFORMS;
}

static cl_uint devices_of(cl_platform_id p, cl_uint room, cl_device_id *ids)
{
    cl_uint n = 0;

    if (clGetDeviceIDs(p, CL_DEVICE_TYPE_ALL, room, ids, &n) != CL_SUCCESS) {
        return 0;
    }
    return n;
}

int32_t plfx_cl_devices(void)
{
    cl_platform_id ids[PLATFORMS];
    cl_uint n = platforms(ids);
    cl_uint sum = 0;
    cl_uint i;

    for (i = 0; i < n; i++) {
        sum += devices_of(ids[i], 0, NULL);
    }
    return (int32_t)sum;
}

plfx_status plfx_cl_look(char *message, size_t n)
{
    cl_platform_id ids[PLATFORMS];
    char name[128];

    if (!message || n == 0) {
        return PLFX_E_ARG;
    }
    message[0] = 0;
    if (plfx_cl_devices() > 0) {
        return PLFX_OK;
    }
    if (platforms(ids) == 0) {
        plfx_cl_append(message, n, "no OpenCL driver here");
        return PLFX_E_DEVICE;
    }
    memset(name, 0, sizeof name);
    (void)clGetPlatformInfo(ids[0], CL_PLATFORM_NAME, sizeof name - 1, name, NULL);
    plfx_cl_append(message, n, name);
    plfx_cl_append(message, n,
                   " is here but lists no device; can it write its kernel cache? "
                   "(POCL_CACHE_DIR, or ~/.cache/pocl)");
    return PLFX_E_DEVICE;
}

int32_t plfx_cl_device_at(int32_t n, cl_device_id *device, cl_platform_id *platform)
{
    cl_platform_id ids[PLATFORMS];
    cl_device_id list[PLATFORMS];
    cl_uint count = platforms(ids);
    cl_uint left = (cl_uint)n;
    cl_uint i;

    for (i = 0; n >= 0 && i < count; i++) {
        cl_uint have = devices_of(ids[i], PLATFORMS, list);
        have = have < PLATFORMS ? have : PLATFORMS;
        if (left < have) {
            *device = list[left];
            *platform = ids[i];
            return 1;
        }
        left -= have;
    }
    return 0;
}

plfx_status plfx_cl_describe(int32_t device, plfx_cl_info *info)
{
    cl_device_id d;
    cl_platform_id p;
    plfx_cl_info t;
    cl_ulong bytes = 0;
    cl_ulong local = 0;
    cl_uint units = 0;
    size_t group = 0;
    cl_int e;

    if (!info || !plfx_cl_device_at(device, &d, &p)) {
        return PLFX_E_ARG;
    }
    memset(&t, 0, sizeof t);
    e = clGetDeviceInfo(d, CL_DEVICE_NAME, sizeof t.name - 1, t.name, NULL);
    e |=
        clGetPlatformInfo(p, CL_PLATFORM_NAME, sizeof t.platform - 1, t.platform, NULL);
    e |= clGetDeviceInfo(d, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    e |= clGetDeviceInfo(d, CL_DEVICE_LOCAL_MEM_SIZE, sizeof local, &local, NULL);
    e |= clGetDeviceInfo(d, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL);
    e |= clGetDeviceInfo(d, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof group, &group, NULL);
    if (e != CL_SUCCESS) {
        return PLFX_E_DEVICE;
    }
    t.memory = bytes;
    t.local_memory = local;
    t.units = units;
    t.group = (uint32_t)group;
    *info = t;
    return PLFX_OK;
}
