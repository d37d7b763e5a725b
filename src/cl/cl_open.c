/* SPDX-License-Identifier: MIT
 * Opening and closing a context: everything is taken here and given back here. */
#include "cl_state.h"
#include "../rows.h"

#include <string.h>

const char *const plfx_cl_kernel_name[K_COUNT] = {
    "unpack",      "extract",           "pad",
    "sad_items",   "sad_columns",       "sad_winners",
    "ref_columns", "zncc_columns",      "zncc_winners",
    "fuse",        "gradient_products", "gradient_map",
    "depth",
};

void plfx_cl_append(char *to, size_t room, const char *text)
{
    size_t at = strlen(to);
    size_t n = strlen(text);

    if (at + 1 < room) {
        n = n < room - 1 - at ? n : room - 1 - at;
        memcpy(to + at, text, n);
        to[at + n] = 0;
    }
}

static void append_number(char *to, size_t room, cl_int v)
{
    char digits[12];
    char *p = digits + sizeof digits - 1;
    cl_long rest = v < 0 ? -(cl_long)v : v;
    int32_t i;

    *p = 0;
    for (i = 0; i < 10 && (rest > 0 || i == 0); i++) {
        *--p = (char)('0' + rest % 10);
        rest /= 10;
    }
    if (v < 0) {
        *--p = '-';
    }
    plfx_cl_append(to, room, p);
}

plfx_status plfx_cl_fail(plfx_cl *cl, const char *what, cl_int error)
{
    cl->message[0] = 0;
    plfx_cl_append(cl->message, sizeof cl->message, what);
    plfx_cl_append(cl->message, sizeof cl->message, ": OpenCL error ");
    append_number(cl->message, sizeof cl->message, error);
    return PLFX_E_DEVICE;
}

/* While opening, what cannot be had is a size. */
static plfx_status fail_open(plfx_cl *cl, const char *what, cl_int error)
{
    plfx_status status = plfx_cl_fail(cl, what, error);

    return error == CL_MEM_OBJECT_ALLOCATION_FAILURE || error == CL_OUT_OF_RESOURCES ||
                   error == CL_OUT_OF_HOST_MEMORY || error == CL_INVALID_BUFFER_SIZE
               ? PLFX_E_SIZE
               : status;
}

/* The first line of what the kernels' compiler said, before the error's number. */
static plfx_status fail_build(plfx_cl *cl, cl_device_id device, cl_int error)
{
    static const char what[] = "cannot build the kernels";
    char log[4096];
    char *end;

    memset(log, 0, sizeof log);
    if (!cl->program ||
        clGetProgramBuildInfo(cl->program, device, CL_PROGRAM_BUILD_LOG, sizeof log - 1,
                              log, NULL) != CL_SUCCESS) {
        log[0] = 0; /* a log that is longer is not given in part */
    }
    end = strchr(log, '\n');
    if (end) {
        *end = 0;
    }
    (void)plfx_cl_fail(cl, what, error);
    plfx_cl_append(cl->message, sizeof cl->message,
                   " (can the driver write its kernel cache?)");
    if (log[0]) {
        plfx_cl_append(cl->message, sizeof cl->message, ": ");
        plfx_cl_append(cl->message, sizeof cl->message, log);
    }
    return PLFX_E_DEVICE;
}

static int32_t apart(const int32_t *d_q8, int32_t n)
{
    int32_t k;

    for (k = 0; k < n; k++) {
        if (d_q8[k] != 0) {
            return 1;
        }
    }
    return 0;
}

static void plan_params(int32_t *p, const plfx_plan *plan)
{
    const plfx_cfg *c = &plan->cfg;

    p[CL_NX] = plan->nx;
    p[CL_NY] = plan->ny;
    p[CL_VIEWS] = c->n;
    p[CL_REF] = c->ref;
    p[CL_LABELS] = c->labels;
    p[CL_WINDOW] = c->window;
    p[CL_BITS] = c->bits;
    p[CL_PAIRS] = c->method == PLFX_METHOD_PAIRS ? c->n - 1 : 1;
    p[CL_ZNCC] = c->cost == PLFX_COST_ZNCC;
    p[CL_VEE] = c->fit == PLFX_FIT_VEE;
    p[CL_WEIGHTED] = c->fuse == PLFX_FUSE_CORRELATION;
    p[CL_TEXTURE] = c->texture;
    p[CL_UNIQUE] = c->unique_u16;
    p[CL_SHIFT1] = plan->sad_shift1;
    p[CL_SHIFT2] = plan->sad_shift2;
    p[CL_FLOOR] = (int32_t)plfx_sad_floor(plan);
    p[CL_HEX] = plan->hex;
    p[CL_ODD] = plan->odd_q4;
    p[CL_MIN] = c->slope_min_q16;
    p[CL_MAX] = c->slope_max_q16;
    p[CL_USES_U] = apart(plan->du_q8, c->n);
    p[CL_USES_V] = apart(plan->dv_q8, c->n);
    p[CL_COL] = plan->col_q16;
    p[CL_ROW] = plan->row_q16;
    p[CL_STEP] = plan->du_q8[2];
    p[CL_BAND] = 32;
    p[CL_PAD] = plfx_cl_pad(plan);
    p[CL_STRIDE] = plan->nx + 2 * p[CL_PAD] + 8;
    p[CL_WIDE] = (plan->nx + 7) / 8 * 8;
}

static void depth_params(int32_t *p, const plfx_optics *o)
{
    uint64_t gain = (uint64_t)o->gain_q24;

    p[CL_INVERSE] = o->inv0_q24;
    p[CL_LOW] = (int32_t)(uint32_t)(gain & 0xffffffffu);
    p[CL_HIGH] = (int32_t)(uint32_t)(gain >> 32);
}

static void raw_params(int32_t *p, const plfx_cl_input *in)
{
    uint32_t full = ((1u << in->bits) - 1u) << (16 - in->bits);

    p[CL_RAW_W] = in->lut->sensor_w;
    p[CL_RAW_H] = in->lut->sensor_h;
    p[CL_FORMAT] = in->format;
    p[CL_RAW_BITS] = in->bits;
    p[CL_BLACK] = in->tone.black_u16;
    p[CL_CLIPPED] = (int32_t)(full < in->tone.sat_u16 ? full : in->tone.sat_u16);
    p[CL_GAIN] = in->tone.gain_q12;
    p[CL_DOWN] = 28 - in->tone.bits - in->tone.shift;
    p[CL_WHITE] = in->white != 0;
}

static cl_int take_queues(plfx_cl *cl, cl_device_id device)
{
    cl_int e;

    cl->context = clCreateContext(NULL, 1, &device, NULL, NULL, &e);
    if (e == CL_SUCCESS) {
        cl->queue_up = clCreateCommandQueue(cl->context, device, 0, &e);
    }
    if (e == CL_SUCCESS) {
        cl->queue_work =
            clCreateCommandQueue(cl->context, device, CL_QUEUE_PROFILING_ENABLE, &e);
    }
    if (e == CL_SUCCESS) {
        cl->queue_down = clCreateCommandQueue(cl->context, device, 0, &e);
    }
    return e;
}

static cl_int build(plfx_cl *cl, cl_device_id device)
{
    const char *text = plfx_cl_source;
    cl_int e;
    int32_t k;

    cl->program = clCreateProgramWithSource(cl->context, 1, &text, NULL, &e);
    if (e == CL_SUCCESS) {
        e = clBuildProgram(cl->program, 1, &device, "-cl-std=CL1.2", NULL, NULL);
    }
    for (k = 0; k < K_COUNT && e == CL_SUCCESS; k++) {
        cl->kernel[k] = clCreateKernel(cl->program, plfx_cl_kernel_name[k], &e);
    }
    return e;
}

static cl_int take_one(plfx_cl *cl, void **to, uint64_t bytes, cl_mem_flags flags)
{
    cl_int e = CL_SUCCESS;

    if (bytes > 0) {
        *to = clCreateBuffer(cl->context, flags, (size_t)bytes, NULL, &e);
    }
    return e;
}

static cl_int take_slots(plfx_cl *cl, const plfx_cl_sizes *s)
{
    /* slope, confidence, flags, depth */
    const uint32_t plane[PLFX_CL_PLANES] = {4, 2, 1, cl->depth ? 4u : 0u};
    cl_int e = CL_SUCCESS;
    int32_t k;
    int32_t m;

    for (k = 0; k < PLFX_CL_SLOTS && e == CL_SUCCESS; k++) {
        e = take_one(cl, &cl->input[k], s->input, CL_MEM_READ_ONLY);
        for (m = 0; m < PLFX_CL_PLANES && e == CL_SUCCESS; m++) {
            e = take_one(cl, &cl->output[k][m], plane[m] * s->lenses,
                         CL_MEM_READ_WRITE);
        }
    }
    return e;
}

static cl_int take_buffers(plfx_cl *cl, const plfx_cl_sizes *s)
{
    cl_int e = CL_SUCCESS;
    int32_t k;

    for (k = 0; k < B_COUNT && e == CL_SUCCESS; k++) {
        e = take_one(cl, &cl->buffer[k], s->buffer[k], CL_MEM_READ_WRITE);
    }
    return e == CL_SUCCESS ? take_slots(cl, s) : e;
}

/* Work-group of at most 16x16 that the device allows; 64 work-items do. */
static void choose_group(plfx_cl *cl, uint32_t most)
{
    cl->group_x = most >= 256 ? 32 : most >= 64 ? 16 : 1;
    cl->group_y = most >= 256 ? 8 : most >= 64 ? 4 : 1;
}

static plfx_status take_all(plfx_cl *cl, cl_device_id device, const plfx_cl_sizes *s,
                            const plfx_cl_input *input)
{
    cl_int e = take_queues(cl, device);

    if (e != CL_SUCCESS) {
        return fail_open(cl, "cannot open the device", e);
    }
    e = build(cl, device);
    if (e != CL_SUCCESS) {
        return fail_build(cl, device, e);
    }
    e = take_buffers(cl, s);
    if (e != CL_SUCCESS) {
        return fail_open(cl, "cannot take device memory", e);
    }
    e = plfx_cl_upload_plan(cl);
    e = e == CL_SUCCESS && input->lut ? plfx_cl_upload_table(cl, input) : e;
    return e == CL_SUCCESS ? PLFX_OK : fail_open(cl, "cannot upload the plan", e);
}

/* What plan and input are, in numbers. */
static void settle(plfx_cl *cl, const plfx_plan *plan, const plfx_cl_input *input)
{
    memset(cl->params, 0, sizeof cl->params);
    cl->plan = *plan;
    plan_params(cl->params, plan);
    cl->from_raw = input->lut != NULL;
    cl->depth = input->optics != NULL;
    if (input->optics) {
        depth_params(cl->params, input->optics);
    }
    if (input->lut) {
        raw_params(cl->params, input);
        cl->raw_w = input->lut->sensor_w;
        cl->raw_h = input->lut->sensor_h;
        cl->format = input->format;
        cl->table_crc = input->lut->crc;
    }
}

static int32_t same_table(const plfx_cl *cl, const plfx_cl_input *in)
{
    return !in->lut ||
           (in->lut->crc == cl->table_crc && in->lut->sensor_w == cl->raw_w &&
            in->lut->sensor_h == cl->raw_h && in->format == cl->format &&
            (in->white != 0) == cl->params[CL_WHITE]);
}

/* Would plan and input take the buffers that are there? */
static int32_t same_memory(const plfx_cl *cl, const plfx_plan *plan,
                           const plfx_cl_input *in)
{
    const plfx_cfg *c = &plan->cfg;
    const plfx_cfg *was = &cl->plan.cfg;

    return plan->nx == cl->plan.nx && plan->ny == cl->plan.ny && c->n == was->n &&
           c->labels == was->labels && c->method == was->method &&
           c->cost == was->cost && plfx_cl_pad(plan) == cl->params[CL_PAD] &&
           cl->from_raw == (in->lut != NULL) && cl->depth == (in->optics != NULL) &&
           same_table(cl, in);
}

plfx_status plfx_cl_retune(plfx_cl *cl, const plfx_plan *plan,
                           const plfx_cl_input *input)
{
    cl_int e;

    if (!cl || !cl->context || !plfx_cl_input_ok(plan, input) ||
        !same_memory(cl, plan, input)) {
        return PLFX_E_ARG;
    }
    if (cl->count != 0) {
        return PLFX_E_STATE;
    }
    settle(cl, plan, input);
    e = plfx_cl_upload_plan(cl);
    e = e == CL_SUCCESS && input->lut ? plfx_cl_upload_table(cl, input) : e;
    return e == CL_SUCCESS ? PLFX_OK : plfx_cl_fail(cl, "cannot upload the plan", e);
}

plfx_status plfx_cl_open(plfx_cl *cl, int32_t device, const plfx_plan *plan,
                         const plfx_cl_input *input)
{
    plfx_cl_info info;
    plfx_cl_sizes sizes;
    cl_device_id id;
    cl_platform_id platform;
    plfx_status status;

    if (!cl || !plfx_cl_input_ok(plan, input)) {
        return PLFX_E_ARG;
    }
    memset(cl, 0, sizeof *cl);
    settle(cl, plan, input);
    status = plfx_cl_describe(device, &info);
    if (status != PLFX_OK || !plfx_cl_device_at(device, &id, &platform)) {
        if (plfx_cl_look(cl->message, sizeof cl->message) == PLFX_OK) {
            plfx_cl_append(cl->message, sizeof cl->message, "no such OpenCL device");
        }
        return status == PLFX_OK ? PLFX_E_ARG : status;
    }
    cl->bytes = plfx_cl_bytes(plan, input);
    if (cl->bytes > info.memory) {
        plfx_cl_append(cl->message, sizeof cl->message,
                       "the device has too little memory");
        return PLFX_E_SIZE;
    }
    choose_group(cl, info.group);
    sizes = plfx_cl_sizes_of(plan, input);
    cl->input_bytes = (size_t)sizes.input;
    status = take_all(cl, id, &sizes, input);
    if (status != PLFX_OK) {
        char message[sizeof cl->message];
        memcpy(message, cl->message, sizeof message);
        plfx_cl_close(cl);
        memcpy(cl->message, message, sizeof message);
    }
    return status;
}

static void drop(void **buffer)
{
    if (*buffer) {
        clReleaseMemObject(*buffer);
    }
}

static void drop_event(void *event)
{
    if (event) {
        clReleaseEvent(event);
    }
}

static void drop_queue(void *queue)
{
    if (queue) {
        clFinish(queue);
        clReleaseCommandQueue(queue);
    }
}

static void drop_slot(plfx_cl *cl, int32_t k)
{
    int32_t m;

    drop_event(cl->uploaded[k]);
    drop_event(cl->worked[k]);
    drop(&cl->input[k]);
    for (m = 0; m < PLFX_CL_PLANES; m++) {
        drop(&cl->output[k][m]);
    }
}

void plfx_cl_close(plfx_cl *cl)
{
    int32_t k;

    if (!cl) {
        return;
    }
    drop_queue(cl->queue_up);
    drop_queue(cl->queue_work);
    drop_queue(cl->queue_down);
    for (k = 0; k < PLFX_CL_SLOTS; k++) {
        drop_slot(cl, k);
    }
    for (k = 0; k < PLFX_CL_BUFFERS; k++) {
        drop(&cl->buffer[k]);
    }
    for (k = 0; k < PLFX_CL_KERNELS; k++) {
        if (cl->kernel[k]) {
            clReleaseKernel(cl->kernel[k]);
        }
    }
    if (cl->program) {
        clReleaseProgram(cl->program);
    }
    if (cl->context) {
        clReleaseContext(cl->context);
    }
    memset(cl, 0, sizeof *cl);
}
