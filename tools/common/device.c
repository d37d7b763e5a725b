/* SPDX-License-Identifier: MIT */
#include "common/device.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"
#include "plenofix/gradient.h"
#include "plenofix/sweep.h"
#ifdef PLFT_OPENCL
#include "plenofix/cl.h"
#endif

static int on_core(const plfx_plan *plan, const plfx_views *views, const plfx_map *map)
{
    int gradient = plan->cfg.method == PLFX_METHOD_GRADIENT;
    size_t n = gradient ? plfx_gradient_ws(plan) : plfx_sweep_ws(plan);
    void *ws = plft_alloc_ws(n);
    plfx_status status;

    if (ws == NULL) {
        return PLFT_DATA;
    }
    status = gradient ? plfx_gradient(plan, views, map, ws, n)
                      : plfx_sweep(plan, views, map, ws, n);
    free(ws);
    return status == PLFX_OK
               ? 0
               : plft_fail(PLFT_DATA, "matching failed with status %d", (int)status);
}

#ifdef PLFT_OPENCL
static int known(int device)
{
    int n = (int)plfx_cl_devices();
    char why[256];

    if (plfx_cl_look(why, sizeof why) != PLFX_OK) {
        return plft_fail(PLFT_DATA,
                         "--device cl: %s; pocl-opencl-icd is a driver that runs on "
                         "any CPU",
                         why);
    }
    if (device >= n) {
        return plft_fail(PLFT_USAGE,
                         "--device cl:%d: there are %d; see plenofix devices", device,
                         n);
    }
    return 0;
}

static plfx_cl *kept; /* the context of the call before, for frames like its own */
static int kept_device;

static void forget(void)
{
    plfx_cl_close(kept);
    free(kept);
    kept = NULL;
}

/* A context for plan and input: the one that is there, or another. */
static plfx_status context(int device, const plfx_plan *plan,
                           const plfx_cl_input *input)
{
    if (kept != NULL && kept_device == device &&
        plfx_cl_retune(kept, plan, input) == PLFX_OK) {
        return PLFX_OK;
    }
    if (kept == NULL) {
        kept = calloc(1, sizeof *kept);
        if (kept == NULL || atexit(forget) != 0) {
            return PLFX_E_SIZE;
        }
    }
    plfx_cl_close(kept);
    kept_device = device;
    return plfx_cl_open(kept, device, plan, input);
}

static int once(int device, const plfx_plan *plan, const plfx_cl_input *input,
                const void *bytes, size_t n, const plfx_map *map)
{
    plfx_status status = context(device, plan, input);

    status = status == PLFX_OK ? plfx_cl_submit(kept, bytes, n) : status;
    status = status == PLFX_OK ? plfx_cl_fetch(kept, map) : status;
    if (status == PLFX_OK) {
        return 0;
    }
    return plft_fail(PLFT_DATA, "--device cl:%d: %s (status %d)", device,
                     kept == NULL       ? "out of memory"
                     : kept->message[0] ? kept->message
                                        : "frame and plan do not match",
                     (int)status);
}

static int on_opencl(int device, const plfx_plan *plan, const plfx_views *views,
                     const plfx_map *map)
{
    size_t n = 2 * (size_t)views->nx * (size_t)views->ny * (size_t)views->n;
    plfx_cl_input input;

    memset(&input, 0, sizeof input);
    return once(device, plan, &input, views->px, n, map);
}

int plft_device_raw(int device, const plfx_plan *plan, const plft_device_frame *f,
                    const plfx_map *map)
{
    plfx_cl_input input;

    memset(&input, 0, sizeof input);
    input.lut = f->lut;
    input.format = PLFX_RAW_U16;
    input.bits = (uint8_t)f->bits;
    input.white = (uint8_t)f->white;
    input.tone = f->tone;
    return once(device, plan, &input, f->px,
                plfx_raw_bytes(PLFX_RAW_U16, f->lut->sensor_w, f->lut->sensor_h), map);
}
#else
static int known(int device)
{
    (void)device;
    return plft_fail(PLFT_DATA, "--device cl: built without OpenCL; install "
                                "ocl-icd-opencl-dev and build again");
}

static int on_opencl(int device, const plfx_plan *plan, const plfx_views *views,
                     const plfx_map *map)
{
    (void)plan;
    (void)views;
    (void)map;
    return known(device);
}

int plft_device_raw(int device, const plfx_plan *plan, const plft_device_frame *f,
                    const plfx_map *map)
{
    (void)plan;
    (void)f;
    (void)map;
    return known(device);
}
#endif

int plft_device_parse(int *device, const char *text)
{
    char rest;

    *device = PLFT_CPU;
    if (text == NULL || strcmp(text, "cpu") == 0) {
        return 0;
    }
    if (strcmp(text, "cl") == 0) {
        *device = 0;
    } else if (sscanf(text, "cl:%d%c", device, &rest) != 1 || *device < 0) {
        return plft_fail(PLFT_USAGE, "--device %s: want cpu, cl or cl:N", text);
    }
    return known(*device);
}

int plft_device_match(int device, const plfx_plan *plan, const plfx_views *views,
                      const plfx_map *map)
{
    return device == PLFT_CPU ? on_core(plan, views, map)
                              : on_opencl(device, plan, views, map);
}
