/* SPDX-License-Identifier: MIT
 * Tables of a plan and of a lens table, written straight into mapped device memory. */
#include "cl_state.h"
#include "../rows.h"
#include "../fix.h"

#include <string.h>

static void *map(plfx_cl *cl, int32_t k, size_t bytes, cl_int *e)
{
    return clEnqueueMapBuffer(cl->queue_work, cl->buffer[k], CL_TRUE, CL_MAP_WRITE, 0,
                              bytes, 0, NULL, NULL, e);
}

static cl_int unmap(plfx_cl *cl, int32_t k, void *p)
{
    cl_int e = clEnqueueUnmapMemObject(cl->queue_work, cl->buffer[k], p, 0, NULL, NULL);

    return e == CL_SUCCESS ? clFinish(cl->queue_work) : e;
}

static cl_int upload_shifts(plfx_cl *cl)
{
    const plfx_plan *plan = &cl->plan;
    size_t n = (size_t)plan->cfg.n * plan->cfg.labels;
    cl_int e;
    cl_int *to = map(cl, B_SHIFT, 8 * n, &e);
    size_t i;

    if (e != CL_SUCCESS) {
        return e;
    }
    for (i = 0; i < n; i++) {
        plfx_shift s = plfx_plan_shift(plan, (int32_t)(i / plan->cfg.labels),
                                       (int32_t)(i % plan->cfg.labels));
        to[2 * i] = 16 * s.kx + s.fx_q4;
        to[2 * i + 1] = 16 * s.ky + s.fy_q4;
    }
    return unmap(cl, B_SHIFT, to);
}

static plfx_span meet(plfx_span a, plfx_span b)
{
    a.x0 = (int16_t)plfx_max_i32(a.x0, b.x0);
    a.x1 = (int16_t)plfx_min_i32(a.x1, b.x1);
    a.y0 = (int16_t)plfx_max_i32(a.y0, b.y0);
    a.y1 = (int16_t)plfx_min_i32(a.y1, b.y1);
    return a;
}

/* Span of pair p at label l; in a sweep those of all views meet. */
static plfx_span span_at(const plfx_plan *plan, int32_t pairs, int32_t p, int32_t l)
{
    int32_t last = pairs == 1 ? plan->cfg.n - 1 : p + 1;
    plfx_span s = {0, INT16_MAX, 0, INT16_MAX};
    int32_t q;

    for (q = p; q < last; q++) {
        int32_t k = q < plan->cfg.ref ? q : q + 1;
        s = meet(s,
                 plfx_span_of(plan, plfx_plan_shift(plan, k, l), plan->cfg.window / 2));
    }
    return s;
}

static cl_int upload_spans(plfx_cl *cl)
{
    int32_t pairs = cl->params[CL_PAIRS];
    int32_t labels = cl->plan.cfg.labels;
    cl_int e;
    cl_short *to = map(cl, B_SPAN, 8 * (size_t)pairs * (size_t)labels, &e);
    int32_t i;

    if (e != CL_SUCCESS) {
        return e;
    }
    for (i = 0; i < pairs * labels; i++) {
        plfx_span s = span_at(&cl->plan, pairs, i / labels, i % labels);
        to[4 * i] = s.x0;
        to[4 * i + 1] = s.x1;
        to[4 * i + 2] = s.y0;
        to[4 * i + 3] = s.y1;
    }
    return unmap(cl, B_SPAN, to);
}

static cl_int upload_baselines(plfx_cl *cl)
{
    const plfx_plan *plan = &cl->plan;
    int32_t pairs = cl->params[CL_PAIRS];
    cl_int e;
    cl_ushort *to = map(cl, B_BASELINE, 2 * (size_t)pairs, &e);
    int32_t p;

    if (e != CL_SUCCESS) {
        return e;
    }
    for (p = 0; p < pairs; p++) {
        to[p] = plfx_baseline_weight(plan, p < plan->cfg.ref ? p : p + 1);
    }
    return unmap(cl, B_BASELINE, to);
}

cl_int plfx_cl_upload_plan(plfx_cl *cl)
{
    cl_int e = clEnqueueWriteBuffer(cl->queue_work, cl->buffer[B_PARAMS], CL_TRUE, 0,
                                    4 * CL_PARAMS, cl->params, 0, NULL, NULL);

    if (cl->plan.cfg.method == PLFX_METHOD_GRADIENT) {
        return e;
    }
    e = e == CL_SUCCESS ? upload_shifts(cl) : e;
    e = e == CL_SUCCESS ? upload_spans(cl) : e;
    return e == CL_SUCCESS ? upload_baselines(cl) : e;
}

static cl_int upload_offsets(plfx_cl *cl, const plfx_cl_input *in)
{
    cl_int e;
    cl_int *to = map(cl, B_OFFSET, 8 * (size_t)cl->plan.cfg.n, &e);
    int32_t k;

    if (e != CL_SUCCESS) {
        return e;
    }
    for (k = 0; k < cl->plan.cfg.n; k++) {
        plfx_point p = plfx_view_offset(in->lut, cl->plan.cfg.at[k]);
        to[2 * k] = p.x_q16 + 256 * in->tone.dx_q8;
        to[2 * k + 1] = p.y_q16 + 256 * in->tone.dy_q8;
    }
    return unmap(cl, B_OFFSET, to);
}

static cl_int upload_centres(plfx_cl *cl, const plfx_cl_input *in)
{
    int32_t nx = cl->plan.nx;
    int32_t lenses = nx * cl->plan.ny;
    cl_int e;
    cl_int *to = map(cl, B_CENTRE, 8 * (size_t)lenses, &e);
    int32_t i;

    if (e != CL_SUCCESS) {
        return e;
    }
    for (i = 0; i < lenses; i++) {
        plfx_point p = plfx_lut_centre(in->lut, i % nx, i / nx);
        to[2 * i] = p.x_q16;
        to[2 * i + 1] = p.y_q16;
    }
    return unmap(cl, B_CENTRE, to);
}

static cl_int upload_missing(plfx_cl *cl, const plfx_cl_input *in)
{
    int32_t nx = cl->plan.nx;
    int32_t lenses = nx * cl->plan.ny;
    cl_int e;
    cl_uchar *to = map(cl, B_MISSING, (size_t)lenses, &e);
    int32_t i;

    if (e != CL_SUCCESS) {
        return e;
    }
    for (i = 0; i < lenses; i++) {
        to[i] = (plfx_lut_flags(in->lut, i % nx, i / nx) & PLFX_LENS_MISSING) != 0;
    }
    return unmap(cl, B_MISSING, to);
}

static cl_int upload_gains(plfx_cl *cl, const plfx_cl_input *in)
{
    int32_t n = cl->plan.cfg.n;
    size_t row = (size_t)cl->plan.nx;
    cl_int e;
    uint16_t *to = map(cl, B_GAIN, 2 * row * (size_t)cl->plan.ny * (size_t)n, &e);
    plfx_status s = PLFX_OK;
    int32_t i;

    if (e != CL_SUCCESS) {
        return e;
    }
    for (i = 0; i < cl->plan.ny * n && s == PLFX_OK; i++) {
        plfx_offset at = cl->plan.cfg.at[i % n];
        s = plfx_lut_gain_row(in->lut, i / n, at.u_q8, at.v_q8, to + row * (size_t)i);
    }
    e = unmap(cl, B_GAIN, to);
    return s == PLFX_OK ? e : CL_INVALID_VALUE;
}

cl_int plfx_cl_upload_table(plfx_cl *cl, const plfx_cl_input *input)
{
    cl_int e = upload_offsets(cl, input);

    e = e == CL_SUCCESS ? upload_centres(cl, input) : e;
    e = e == CL_SUCCESS ? upload_missing(cl, input) : e;
    return e == CL_SUCCESS && input->white ? upload_gains(cl, input) : e;
}
