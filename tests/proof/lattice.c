/* SPDX-License-Identifier: MIT
 * Arithmetic of the table reader by Frama-C's Eva, which follows the intervals of all
 * values: whatever numbers stand in a table, nothing overflows, no shift is out of
 * range, no division by zero.  .ci/checks/proof.py runs it. */
#include "lut.c"

volatile int32_t any_i32; /* each reading may give any value */
volatile uint8_t any_u8;

static int32_t between(int32_t lo, int32_t hi)
{
    int32_t v = any_i32;

    return v < lo ? lo : v > hi ? hi : v;
}

static plfx_vec_q22 any_vector(void)
{
    plfx_vec_q22 v;

    v.x_q22 = any_i32;
    v.y_q22 = any_i32;
    return v;
}

static plfx_lattice any_lattice(void)
{
    plfx_lattice l;

    l.kind = any_i32;
    l.nx = any_i32;
    l.ny = any_i32;
    l.origin.x_q16 = any_i32;
    l.origin.y_q16 = any_i32;
    l.a = any_vector();
    l.b = any_vector();
    l.odd = any_vector();
    return l;
}

/* Any lens, with and without a residual, beside any sensor. */
static int32_t any_lens(plfx_lut *t)
{
    uint8_t residual[4] = {any_u8, any_u8, any_u8, any_u8};
    plfx_point c;
    int32_t i = between(0, PLFX_LENSES_MAX - 1);
    int32_t j = between(0, PLFX_LENSES_MAX - 1);

    t->blob = residual;
    t->rows = any_u8 & 1u ? residual : NULL; /* of a fed stream, which holds one */
    t->held = 1;
    t->resi.offset = 0;
    t->resi.length = any_u8 & 1u;
    if (t->resi.length) { /* that of the first column stands for every residual */
        t->lattice.nx = 0;
        i = 0;
    }
    c = plfx_lut_centre(t, i, j);
    return near_sensor(c, between(1, 32767), between(1, 32767), plfx_lut_pitch_q16(t));
}

int32_t main(void)
{
    plfx_lut t;

    t.lattice = any_lattice();
    return plfx_lattice_ok(&t.lattice) + any_lens(&t);
}
