/* SPDX-License-Identifier: MIT
 * Frames: upload, work and download on three queues, tied by events. */
#include "cl_state.h"

/* Arguments of a kernel in order: buffers are cl_mem, the rest int32. */
static cl_int arg_mem(plfx_cl *cl, int32_t k, cl_uint at, void *buffer)
{
    cl_mem m = buffer;

    return clSetKernelArg(cl->kernel[k], at, sizeof(cl_mem), &m);
}

static cl_int arg_int(plfx_cl *cl, int32_t k, cl_uint at, cl_int v)
{
    return clSetKernelArg(cl->kernel[k], at, sizeof v, &v);
}

static cl_int args(plfx_cl *cl, int32_t k, void *const *buffers, cl_uint n)
{
    cl_int e = CL_SUCCESS;
    cl_uint i;

    for (i = 0; i < n && e == CL_SUCCESS; i++) {
        e = arg_mem(cl, k, i, buffers[i]);
    }
    return e;
}

static size_t rounded(int32_t n, size_t group)
{
    return ((size_t)n + group - 1) / group * group;
}

/* Wait for a kernel and add its time by the device's clock. */
static cl_int add_time(plfx_cl *cl, int32_t k, cl_event done)
{
    cl_ulong from = 0;
    cl_ulong to = 0;
    cl_int e = clWaitForEvents(1, &done);

    e |= clGetEventProfilingInfo(done, CL_PROFILING_COMMAND_START, sizeof from, &from,
                                 NULL);
    e |= clGetEventProfilingInfo(done, CL_PROFILING_COMMAND_END, sizeof to, &to, NULL);
    clReleaseEvent(done);
    cl->kernel_ns[k] += to - from;
    return e;
}

/* x and y in groups, z one by one; `wait` may be NULL. */
static cl_int launch(plfx_cl *cl, int32_t k, int32_t x, int32_t y, int32_t z,
                     int32_t flat, cl_event wait)
{
    size_t local[3];
    size_t global[3];
    cl_event done = NULL;
    cl_int e;

    local[0] = flat ? cl->group_x * cl->group_y : cl->group_x;
    local[1] = flat ? 1 : cl->group_y;
    local[2] = 1;
    global[0] = rounded(x, local[0]);
    global[1] = rounded(y, local[1]);
    global[2] = (size_t)z;
    e = clEnqueueNDRangeKernel(cl->queue_work, cl->kernel[k], 3, NULL, global, local,
                               wait ? 1 : 0, wait ? &wait : NULL,
                               cl->timing ? &done : NULL);
    return e == CL_SUCCESS && cl->timing ? add_time(cl, k, done) : e;
}

static cl_int extract(plfx_cl *cl, int32_t slot, cl_event ready)
{
    void **b = cl->buffer;
    void *const in[] = {b[B_PARAMS], cl->input[slot], b[B_FRAME]};
    void *const out[] = {b[B_PARAMS],  b[B_FRAME], b[B_CENTRE], b[B_OFFSET],
                         b[B_MISSING], b[B_GAIN],  b[B_VIEWS]};
    cl_int e = args(cl, K_UNPACK, in, 3);

    e = e ? e : launch(cl, K_UNPACK, cl->raw_w, cl->raw_h, 1, 0, ready);
    e = e ? e : args(cl, K_EXTRACT, out, 7);
    return e ? e
             : launch(cl, K_EXTRACT, cl->plan.nx, cl->plan.ny, cl->plan.cfg.n, 0, NULL);
}

static int32_t bands(const plfx_cl *cl)
{
    int32_t rows = cl->plan.ny - cl->plan.cfg.window + 1;

    return (rows + cl->params[CL_BAND] - 1) / cl->params[CL_BAND];
}

/* Costs of view k: the first one of a sum starts it, the last one cuts it. */
static cl_int sad_view(plfx_cl *cl, int32_t k, int32_t first, int32_t last)
{
    void **b = cl->buffer;
    void *const in[] = {b[B_PARAMS], b[B_PADDED], b[B_SHIFT]};
    cl_int e = args(cl, K_SAD_ITEMS, in, 3);

    e = e ? e : arg_int(cl, K_SAD_ITEMS, 3, k);
    e = e ? e : arg_int(cl, K_SAD_ITEMS, 4, first);
    e = e ? e : arg_int(cl, K_SAD_ITEMS, 5, last ? cl->params[CL_SHIFT1] : 0);
    e = e ? e : arg_mem(cl, K_SAD_ITEMS, 6, b[B_ITEM]);
    return e ? e
             : launch(cl, K_SAD_ITEMS, cl->params[CL_WIDE] / 8, cl->plan.ny,
                      cl->plan.cfg.labels, 0, NULL);
}

/* Pair p, or all views when there is one sum. */
static cl_int sad_pair(plfx_cl *cl, int32_t p)
{
    void **b = cl->buffer;
    void *const column[] = {b[B_PARAMS], b[B_ITEM], b[B_COLUMN]};
    int32_t end = cl->params[CL_PAIRS] == 1 ? cl->plan.cfg.n - 1 : p + 1;
    cl_int e = CL_SUCCESS;
    int32_t q;

    for (q = p; q < end && !e; q++) {
        int32_t k = q < cl->plan.cfg.ref ? q : q + 1;
        e = sad_view(cl, k, q == p, q == end - 1);
    }
    e = e ? e : args(cl, K_SAD_COLUMNS, column, 3);
    return e ? e
             : launch(cl, K_SAD_COLUMNS, cl->params[CL_WIDE] / 8, cl->plan.cfg.labels,
                      bands(cl), 1, NULL);
}

static cl_int pad(plfx_cl *cl, void *views)
{
    void *const in[] = {cl->buffer[B_PARAMS], views, cl->buffer[B_PADDED]};
    cl_int e = args(cl, K_PAD, in, 3);

    return e ? e
             : launch(cl, K_PAD, cl->params[CL_STRIDE], cl->plan.ny, cl->plan.cfg.n, 0,
                      NULL);
}

static cl_int zncc_pair(plfx_cl *cl, void *views, int32_t p)
{
    void **b = cl->buffer;
    void *const in[] = {b[B_PARAMS], views, b[B_SHIFT]};
    cl_int e = args(cl, K_ZNCC_COLUMNS, in, 3);

    e = e ? e : arg_int(cl, K_ZNCC_COLUMNS, 3, p);
    e = e ? e : arg_mem(cl, K_ZNCC_COLUMNS, 4, b[B_PAIR_SUMS]);
    return e ? e
             : launch(cl, K_ZNCC_COLUMNS, cl->plan.nx, cl->plan.cfg.labels, bands(cl),
                      1, NULL);
}

static cl_int winners(plfx_cl *cl, int32_t p)
{
    void **b = cl->buffer;
    int32_t zncc = cl->params[CL_ZNCC];
    int32_t k = zncc ? K_ZNCC_WINNERS : K_SAD_WINNERS;
    void *const in[] = {b[B_PARAMS], b[zncc ? B_PAIR_SUMS : B_COLUMN], b[B_SUMS],
                        b[B_SPAN]};
    cl_int e = args(cl, k, in, 4);

    e = e ? e : arg_int(cl, k, 4, p);
    e = e ? e : arg_mem(cl, k, 5, b[B_SLOPE]);
    e = e ? e : arg_mem(cl, k, 6, b[B_CONF]);
    e = e ? e : arg_mem(cl, k, 7, b[B_WEIGHT]);
    e = e ? e : arg_mem(cl, k, 8, b[B_FLAGS]);
    return e ? e : launch(cl, k, cl->plan.nx, cl->plan.ny, 1, 0, NULL);
}

static cl_int fuse(plfx_cl *cl, int32_t slot)
{
    void **b = cl->buffer;
    void *const in[] = {b[B_PARAMS], b[B_SLOPE], b[B_CONF],
                        b[B_WEIGHT], b[B_FLAGS], b[B_BASELINE]};
    cl_int e = args(cl, K_FUSE, in, 6);
    cl_uint m;

    e = e ? e : arg_int(cl, K_FUSE, 6, cl->plan.cfg.method == PLFX_METHOD_PAIRS);
    for (m = 0; m < 3 && !e; m++) {
        e = arg_mem(cl, K_FUSE, 7 + m, cl->output[slot][m]);
    }
    return e ? e : launch(cl, K_FUSE, cl->plan.nx, cl->plan.ny, 1, 0, NULL);
}

static cl_int match(plfx_cl *cl, int32_t slot, void *views)
{
    void *const in[] = {cl->buffer[B_PARAMS], views, cl->buffer[B_SUMS]};
    cl_int e = args(cl, K_REF_COLUMNS, in, 3);
    int32_t p;

    e = e ? e : launch(cl, K_REF_COLUMNS, cl->plan.nx, 1, bands(cl), 1, NULL);
    e = e || cl->params[CL_ZNCC] ? e : pad(cl, views);
    for (p = 0; p < cl->params[CL_PAIRS] && !e; p++) {
        e = cl->params[CL_ZNCC] ? zncc_pair(cl, views, p) : sad_pair(cl, p);
        e = e ? e : winners(cl, p);
    }
    return e ? e : fuse(cl, slot);
}

static cl_int gradient(plfx_cl *cl, int32_t slot, void *views)
{
    void *const in[] = {cl->buffer[B_PARAMS], views, cl->buffer[B_CELLS]};
    void *const out[] = {cl->buffer[B_PARAMS], cl->buffer[B_CELLS], cl->output[slot][0],
                         cl->output[slot][1], cl->output[slot][2]};
    cl_int e = args(cl, K_GRADIENT_PRODUCTS, in, 3);

    e = e ? e : launch(cl, K_GRADIENT_PRODUCTS, cl->plan.nx, cl->plan.ny, 1, 0, NULL);
    e = e ? e : args(cl, K_GRADIENT_MAP, out, 5);
    return e ? e : launch(cl, K_GRADIENT_MAP, cl->plan.nx, cl->plan.ny, 1, 0, NULL);
}

static cl_int depth(plfx_cl *cl, int32_t slot)
{
    void *const in[] = {cl->buffer[B_PARAMS], cl->output[slot][0], cl->output[slot][3]};
    cl_int e = cl->depth ? args(cl, K_DEPTH, in, 3) : CL_SUCCESS;

    return e || !cl->depth ? e
                           : launch(cl, K_DEPTH, cl->plan.nx, cl->plan.ny, 1, 0, NULL);
}

/* All kernels of one frame; the last one's end is cl->worked[slot]. */
static cl_int work(plfx_cl *cl, int32_t slot)
{
    cl_event ready = cl->uploaded[slot];
    void *views = cl->from_raw ? cl->buffer[B_VIEWS] : cl->input[slot];
    cl_event done = NULL;
    cl_int e = cl->from_raw
                   ? extract(cl, slot, ready)
                   : clEnqueueBarrierWithWaitList(cl->queue_work, 1, &ready, NULL);

    if (e == CL_SUCCESS) {
        e = cl->plan.cfg.method == PLFX_METHOD_GRADIENT ? gradient(cl, slot, views)
                                                        : match(cl, slot, views);
    }
    e = e ? e : depth(cl, slot);
    e = e ? e : clEnqueueMarkerWithWaitList(cl->queue_work, 0, NULL, &done);
    cl->worked[slot] = done;
    return e ? e : clFlush(cl->queue_work);
}

static void forget(void **event)
{
    if (*event) {
        clReleaseEvent(*event);
        *event = NULL;
    }
}

plfx_status plfx_cl_submit(plfx_cl *cl, const void *bytes, size_t n)
{
    int32_t slot;
    cl_event done = NULL;
    cl_int e;

    if (!cl || !cl->context || !bytes) {
        return PLFX_E_ARG;
    }
    if (n < cl->input_bytes) {
        return PLFX_E_SIZE;
    }
    if (cl->count == PLFX_CL_SLOTS) {
        return PLFX_E_STATE;
    }
    slot = (cl->head + cl->count) % PLFX_CL_SLOTS;
    e = clEnqueueWriteBuffer(cl->queue_up, cl->input[slot], CL_TRUE, 0, cl->input_bytes,
                             bytes, 0, NULL, &done);
    cl->uploaded[slot] = done;
    e = e ? e : work(cl, slot);
    if (e != CL_SUCCESS) {
        forget(&cl->uploaded[slot]);
        forget(&cl->worked[slot]);
        return plfx_cl_fail(cl, "cannot start a frame", e);
    }
    cl->count++;
    return PLFX_OK;
}

/* One plane of the map, row by row into its stride. */
static cl_int download(plfx_cl *cl, int32_t slot, int32_t m, void *to, size_t item,
                       int32_t stride)
{
    static const size_t origin[3] = {0, 0, 0};
    size_t region[3];
    size_t row = item * (size_t)cl->plan.nx;
    cl_event ready = cl->worked[slot];

    if (!to) {
        return CL_SUCCESS;
    }
    region[0] = row;
    region[1] = (size_t)cl->plan.ny;
    region[2] = 1;
    return clEnqueueReadBufferRect(cl->queue_down, cl->output[slot][m], CL_TRUE, origin,
                                   origin, region, row, 0, item * (size_t)stride, 0, to,
                                   1, &ready, NULL);
}

static void no_sigma(const plfx_map *out)
{
    int32_t x;
    int32_t y;

    for (y = 0; out->sigma_u20 && y < out->h; y++) {
        for (x = 0; x < out->w; x++) {
            out->sigma_u20[(size_t)y * (size_t)out->stride + (size_t)x] =
                PLFX_SIGMA_NONE;
        }
    }
}

plfx_status plfx_cl_fetch(plfx_cl *cl, const plfx_map *out)
{
    return plfx_cl_fetch_depth(cl, out, NULL);
}

plfx_status plfx_cl_fetch_depth(plfx_cl *cl, const plfx_map *out, uint32_t *um)
{
    int32_t slot;
    cl_int e;

    if (!cl || !cl->context || !out || !out->slope_q16 || out->w != cl->plan.nx ||
        out->h != cl->plan.ny || out->stride < out->w || (um && !cl->depth)) {
        return PLFX_E_ARG;
    }
    if (cl->count == 0) {
        return PLFX_E_STATE;
    }
    slot = cl->head;
    e = download(cl, slot, 0, out->slope_q16, 4, out->stride);
    e = e ? e : download(cl, slot, 1, out->conf_u16, 2, out->stride);
    e = e ? e : download(cl, slot, 2, out->flags, 1, out->stride);
    e = e ? e : download(cl, slot, 3, um, 4, out->stride);
    forget(&cl->uploaded[slot]);
    forget(&cl->worked[slot]);
    cl->head = (slot + 1) % PLFX_CL_SLOTS;
    cl->count--;
    if (e != CL_SUCCESS) {
        return plfx_cl_fail(cl, "cannot fetch a frame", e);
    }
    no_sigma(out);
    return PLFX_OK;
}
