/* SPDX-License-Identifier: MIT
 * What a plan needs on the device, told before anything is taken. */
#include "cl_state.h"

#include <string.h>

int32_t plfx_cl_pad(const plfx_plan *plan)
{
    return plan->reach_x + 2;
}

static void match_sizes(const plfx_plan *plan, plfx_cl_sizes *s)
{
    uint64_t pairs = plan->cfg.method == PLFX_METHOD_PAIRS ? plan->cfg.n - 1u : 1u;
    uint64_t cells = s->lenses * plan->cfg.labels;

    s->buffer[B_SHIFT] = 8u * (uint64_t)plan->cfg.n * plan->cfg.labels;
    s->buffer[B_SPAN] = 8u * pairs * plan->cfg.labels;
    s->buffer[B_SUMS] = 12u * s->lenses;
    s->buffer[B_SLOPE] = 4u * pairs * s->lenses;
    s->buffer[B_CONF] = 2u * pairs * s->lenses;
    s->buffer[B_WEIGHT] = 2u * pairs * s->lenses;
    s->buffer[B_FLAGS] = pairs * s->lenses;
    s->buffer[B_BASELINE] = 2u * pairs;
    if (plan->cfg.cost == PLFX_COST_ZNCC) {
        s->buffer[B_PAIR_SUMS] = 12u * cells;
    } else {
        s->buffer[B_PADDED] = 2u * (uint64_t)(plan->nx + 2 * plfx_cl_pad(plan) + 8) *
                              plan->cfg.n * (uint64_t)plan->ny;
        cells =
            8u * (uint64_t)((plan->nx + 7) / 8) * (uint64_t)plan->ny * plan->cfg.labels;
        s->buffer[B_ITEM] = 2u * cells;
        s->buffer[B_COLUMN] = 2u * cells;
    }
}

static void raw_sizes(const plfx_plan *plan, const plfx_cl_input *in, plfx_cl_sizes *s)
{
    uint64_t w = (uint64_t)in->lut->sensor_w;
    uint64_t h = (uint64_t)in->lut->sensor_h;

    s->input = plfx_raw_bytes(in->format, in->lut->sensor_w, in->lut->sensor_h);
    s->buffer[B_FRAME] = 2u * w * h;
    s->buffer[B_CENTRE] = 8u * s->lenses;
    s->buffer[B_OFFSET] = 8u * (uint64_t)plan->cfg.n;
    s->buffer[B_MISSING] = s->lenses;
    s->buffer[B_GAIN] = in->white ? 2u * plan->cfg.n * s->lenses : 2u;
    s->buffer[B_VIEWS] = 2u * plan->cfg.n * s->lenses;
}

plfx_cl_sizes plfx_cl_sizes_of(const plfx_plan *plan, const plfx_cl_input *input)
{
    plfx_cl_sizes s;

    memset(&s, 0, sizeof s);
    s.lenses = (uint64_t)plan->nx * (uint64_t)plan->ny;
    s.buffer[B_PARAMS] = 4u * CL_PARAMS;
    if (input->lut) {
        raw_sizes(plan, input, &s);
    } else {
        s.input = 2u * plan->cfg.n * s.lenses;
    }
    if (plan->cfg.method == PLFX_METHOD_GRADIENT) {
        s.buffer[B_CELLS] = 40u * s.lenses;
    } else {
        match_sizes(plan, &s);
    }
    return s;
}

static int32_t tone_ok(const plfx_plan *plan, const plfx_tone *t)
{
    return t->bits == plan->cfg.bits && t->gain_q12 >= 4096u && t->gain_q12 <= 8191u &&
           t->shift >= -8 && t->shift <= 8 && t->dx_q8 >= -256 && t->dx_q8 <= 256 &&
           t->dy_q8 >= -256 && t->dy_q8 <= 256;
}

int32_t plfx_cl_input_ok(const plfx_plan *plan, const plfx_cl_input *input)
{
    if (!plan || !input || plan->nx < 1 || plan->ny < 1 || plan->cfg.n < 2 ||
        plan->cfg.n > PLFX_VIEWS_MAX || plan->cfg.ref >= plan->cfg.n) {
        return 0; /* no plan of plfx_plan_init() */
    }
    return !input->lut ||
           (input->lut->lattice.nx == plan->nx && input->lut->lattice.ny == plan->ny &&
            input->bits >= 8 && input->bits <= 16 &&
            plfx_raw_bytes(input->format, input->lut->sensor_w, input->lut->sensor_h) >
                0 &&
            tone_ok(plan, &input->tone));
}

uint64_t plfx_cl_bytes(const plfx_plan *plan, const plfx_cl_input *input)
{
    plfx_cl_sizes s;
    uint64_t sum;
    int32_t k;

    if (!plfx_cl_input_ok(plan, input)) {
        return 0;
    }
    s = plfx_cl_sizes_of(plan, input);
    sum = PLFX_CL_SLOTS * (s.input + (input->optics ? 11u : 7u) * s.lenses);
    for (k = 0; k < B_COUNT; k++) {
        sum += s.buffer[k];
    }
    return sum;
}
