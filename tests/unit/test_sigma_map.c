/* SPDX-License-Identifier: MIT
 * Standard errors of a map against the formulas of sigma_map.c in double: rivals by the
 * margin, boundaries by the share of neighbours on another surface. */
#include "suite.h"

#include "frame_state.h"

#include <math.h>

#define NX      14
#define NY      12
#define CELLS   (NX * NY)
#define GATE_Q8 128
#define R_Q8    64
#define COLUMNS 64    /* a unit of slope */
#define USUAL   1024u /* misfit of all: none is over the usual one */

static int32_t e_q16[CELLS];
static uint16_t conf[CELLS], sigma[CELLS];
static uint32_t base[CELLS], misfit[CELLS], lever[CELLS];
static uint64_t scratch[1024];

/* A state as the refinement leaves it, its own errors 0. */
static plfx_frame_state state_of(uint16_t noise_q4)
{
    plfx_frame_state s;

    memset(&s, 0, sizeof s);
    s.nx = NX;
    s.ny = NY;
    s.base_q8 = COLUMNS * 256;
    s.cfg.window = 5;
    s.cfg.gate_q8 = GATE_Q8;
    s.cfg.rival_q8 = R_Q8;
    s.cfg.noise_q4 = noise_q4;
    s.conf = conf;
    s.sigma = sigma;
    s.base = base;
    s.misfit = misfit;
    s.lever = lever;
    s.scratch = scratch;
    assert_true(plfx_sigma_scratch(&s) <= sizeof scratch);
    for (int i = 0; i < CELLS; i++) {
        base[i] = 0;
        misfit[i] = USUAL;
        lever[i] = 99u << 20;
        conf[i] = (uint16_t)(i * 65535 / (CELLS - 1));
    }
    return s;
}

/* Neighbours of 7x7 at least a gate away; rows beyond the map are its last ones. */
static int outside(int x, int y)
{
    int n = 0;

    for (int dy = -3; dy <= 3; dy++) {
        for (int dx = -3; dx <= 3; dx++) {
            int row = y + dy < 0 ? 0 : y + dy >= NY ? NY - 1 : y + dy;
            if (x + dx >= 0 && x + dx < NX) {
                n += abs(e_q16[row * NX + x + dx] - e_q16[y * NX + x]) >= GATE_Q8 * 256;
            }
        }
    }
    return n;
}

static double formula(int x, int y, double noise)
{
    double c = conf[y * NX + x] / 65536.0;
    double o = outside(x, y) / 49.0;
    double rival = fmax(0.0, 1.0 - c * (1.0 + noise / 14.0) / 0.64);
    double bound = (1.0 - c / 1.39) * (0.55 * o + 11.6 * o * o * o * o);

    return R_Q8 / 256.0 * hypot(rival * rival * rival, bound);
}

/* Columns; the factors are of 1/256, cubed. */
static void compare(const plfx_frame_state *s, double noise)
{
    plfx_sigma_map(s, e_q16);
    for (int y = 0; y < NY; y++) {
        for (int x = 0; x < NX; x++) {
            double want = formula(x, y, noise);
            double got = sigma[y * NX + x] * COLUMNS / 1048576.0;
            if (fabs(got - want) > 0.01 * want + 0.004 * R_Q8 / 256.0) {
                fail_msg("(%d,%d) confidence %u outside %d: %g, formula %g", x, y,
                         conf[y * NX + x], outside(x, y), got, want);
            }
        }
    }
}

/* A step of just a gate along a diagonal: shares from 0 to most of a window. */
static void shares_of_a_step(void **state)
{
    plfx_frame_state s = state_of(0);
    int most = 0;

    (void)state;
    for (int i = 0; i < CELLS; i++) {
        e_q16[i] = i % NX + i / NX < 12 ? 0 : GATE_Q8 * 256;
    }
    e_q16[5 * NX + 5] = -GATE_Q8 * 256 - 1; /* one alone: 48 of 49 */
    for (int i = 0; i < CELLS; i++) {
        most = outside(i % NX, i / NX) > most ? outside(i % NX, i / NX) : most;
    }
    assert_int_equal(most, 48);
    compare(&s, 0.0);
}

/* Steps under the gate count for nothing. */
static void steps_under_the_gate(void **state)
{
    plfx_frame_state s = state_of(0);

    (void)state;
    for (int i = 0; i < CELLS; i++) {
        e_q16[i] = i % NX < NX / 2 ? 0 : GATE_Q8 * 256 - 1;
    }
    for (int i = 0; i < CELLS; i++) {
        assert_int_equal(outside(i % NX, i / NX), 0);
    }
    compare(&s, 0.0);
}

/* Noise lowers margins: a rival is told by a larger one. */
static void noise_widens_margins(void **state)
{
    plfx_frame_state s = state_of(7 * 16);

    (void)state;
    memset(e_q16, 0, sizeof e_q16);
    compare(&s, 7.0);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(shares_of_a_step),
    cmocka_unit_test(steps_under_the_gate),
    cmocka_unit_test(noise_widens_margins),
};

SUITE(tests)
