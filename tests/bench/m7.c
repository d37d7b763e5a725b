/* SPDX-License-Identifier: MIT
 * A sweep on an emulated Cortex-M7, for the counting plug-in: icount.py builds it with
 * 0 and with 1 round and takes the difference. */
#include "plenofix/sweep.h"

#include <stdio.h>
#include <string.h>

#ifndef ROUNDS
#define ROUNDS 1
#endif
#ifndef BITS
#define BITS 12
#endif
#ifndef WINDOW
#define WINDOW 9
#endif
#define WIDTH  160
#define HEIGHT 60
#define LABELS 16

static uint16_t samples[2 * WIDTH * HEIGHT];
static int32_t slopes[WIDTH * HEIGHT];
#if defined(CONFIDENCE)
static uint16_t conf[WIDTH * HEIGHT];
#define CONF conf
#else
#define CONF NULL
#endif
static uint64_t memory[24 * 1024];

static void draw(void)
{
    uint32_t state = 1;

    for (int i = 0; i < 2 * WIDTH * HEIGHT; i++) {
        state = state * 1664525u + 1013904223u;
        samples[i] = (uint16_t)((state >> 16) & ((1u << BITS) - 1u));
    }
}

/* So that builds can be compared. */
static uint32_t digest(const plfx_map *m)
{
    uint32_t d = 0;

    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        d = d * 31u + (uint32_t)m->slope_q16[i] + (m->conf_u16 ? m->conf_u16[i] : 0u);
    }
    return d;
}

int main(void)
{
    plfx_views v = {samples, WIDTH, HEIGHT, 2};
    plfx_map m = {slopes, CONF, NULL, NULL, WIDTH, HEIGHT, WIDTH};
    static plfx_plan plan;
    plfx_cfg c;
    size_t shift = (64u - (size_t)memory % 64u) % 64u;

    memset(&c, 0, sizeof c);
    c.window = WINDOW;
    c.bits = BITS;
    c.n = 2;
    c.labels = LABELS;
    c.at[1].u_q8 = -16 * 256;
    c.slope_max_q16 = (LABELS - 1) * 4096;
    draw();
    if (plfx_plan_init(&plan, &c, NULL, WIDTH, HEIGHT) != PLFX_OK) {
        return 1;
    }
    for (int i = 0; i < ROUNDS; i++) {
        if (plfx_sweep(&plan, &v, &m, (char *)memory + shift, sizeof memory - 64) !=
            PLFX_OK) {
            return 2;
        }
    }
    printf("%08lx\n", (unsigned long)digest(&m));
    return 0;
}
