/* SPDX-License-Identifier: MIT
 * The reference set-up of structural sensing for tests/bench/multiplies.py: 96 x 20
 * lenses, 24 regions of 7 x 9, a centre and 24 views, 12 bits, speckle of three lenses.
 *   regions CASE N   N measurements of one frame: still, moved by 0.3 or 0.8 of a lens,
 *                    or dark, so that every region is lost */
#include "plenofix/roi.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NX      96
#define NY      20
#define PITCH   17
#define SW      (PITCH * NX + 13)
#define SH      (PITCH * NY + 9)
#define REGIONS 24
#define ARM     6 /* views along each direction, a pixel apart */
#define REST    2
#define CELL    3 /* lenses between the numbers that make the speckle */
#define ONE     256

static uint16_t pixel[SH * SW];
static uint64_t memory[PLFX_ROI_WS(REGIONS, 7u, 9u, 4u * ARM + 1u, 0, NX) / 8u + 8u];
static uint64_t blob[8192];
static plfx_lut lut;
static plfx_roi_cfg cfg;
static plfx_roi roi;
static uint32_t noise = 1;

static int32_t number(int32_t x, int32_t y)
{
    uint32_t v = (uint32_t)x * 0x9e3779b1u ^ (uint32_t)y * 0x85ebca77u;

    v = (v ^ v >> 15) * 0x2c1b3c6du;
    return (int32_t)(v >> 20);
}

/* Between two numbers; t 0 .. 256, smooth at both ends. */
static int32_t blend(int32_t a, int32_t b, int32_t t)
{
    return a + (b - a) * (t * t / ONE * (3 * ONE - 2 * t) / ONE) / ONE;
}

/* Brightness, 12 bits, at lens coordinates in 1/256. */
static int32_t speckle(int32_t x, int32_t y)
{
    int32_t i = x / (CELL * ONE);
    int32_t j = y / (CELL * ONE);
    int32_t s = x % (CELL * ONE) / CELL;
    int32_t t = y % (CELL * ONE) / CELL;

    return blend(blend(number(i, j), number(i + 1, j), s),
                 blend(number(i, j + 1), number(i + 1, j + 1), s), t);
}

/* Eight levels of noise, about what 30 ke- leave at half of full scale. */
static uint16_t seen(int32_t v)
{
    noise = noise * 1664525u + 1013904223u;
    v += (int32_t)(noise >> 26) - 32;
    return (uint16_t)(v < 0 ? 0 : v > 4095 ? 4095 : v);
}

static void draw(int32_t shift, int32_t percent)
{
    for (int32_t y = 0; y < SH; y++) {
        for (int32_t x = 0; x < SW; x++) {
            int32_t i = x / PITCH;
            int32_t j = y / PITCH;
            int32_t v = speckle((i + 8) * ONE - shift, (j + 8) * ONE - shift);
            pixel[y * SW + x] = seen((400 + v * 3 / 4) * percent / 100);
        }
    }
}

static int table(void)
{
    plfx_lut_desc d;

    memset(&d, 0, sizeof d);
    d.sensor_w = SW;
    d.sensor_h = SH;
    d.sensor_bits = 12;
    d.lattice.kind = PLFX_LATTICE_SQUARE;
    d.lattice.nx = NX;
    d.lattice.ny = NY;
    d.lattice.origin.x_q16 = PITCH / 2 * 65536;
    d.lattice.origin.y_q16 = PITCH / 2 * 65536;
    d.lattice.a.x_q22 = PITCH * 4194304;
    d.lattice.b.y_q22 = PITCH * 4194304;
    d.radius_q8 = 8 * 256;
    return plfx_lut_bytes(&d) > sizeof blob ||
           plfx_lut_write(&d, (uint8_t *)blob, sizeof blob) != PLFX_OK ||
           plfx_lut_open(&lut, (const uint8_t *)blob, plfx_lut_bytes(&d)) != PLFX_OK;
}

static void configure(void)
{
    cfg.lut = &lut;
    cfg.tone = plfx_tone_unity(12);
    cfg.views = 4 * ARM + 1;
    for (int k = 1; k <= ARM; k++) {
        cfg.at[4 * k - 3].u_q8 = (int16_t)(256 * k);
        cfg.at[4 * k - 2].u_q8 = (int16_t)(-256 * k);
        cfg.at[4 * k - 1].v_q8 = (int16_t)(256 * k);
        cfg.at[4 * k].v_q8 = (int16_t)(-256 * k);
    }
    cfg.regions = REGIONS;
    for (int k = 0; k < REGIONS; k++) {
        cfg.region[k].i = (int16_t)(7 + 81 * (k % 12) / 11);
        cfg.region[k].j = (int16_t)(k < 12 ? 7 : 12);
        cfg.region[k].hx = 3;
        cfg.region[k].hy = 4;
    }
    cfg.rest = REST;
    cfg.steps = 2;
    cfg.residual_q8 = 640;
}

static int rest(const plfx_roi_frame *frame)
{
    size_t shift = (64u - (size_t)memory % 64u) % 64u;
    int wrong = plfx_roi_init(&roi, &cfg, (char *)memory + shift,
                              sizeof memory - shift) != PLFX_OK;

    for (int k = 0; k < REST && !wrong; k++) {
        draw(0, 100);
        wrong = plfx_roi_rest(&roi, frame) != PLFX_OK;
    }
    return wrong;
}

int main(int argc, char **argv)
{
    static plfx_roi_result result[PLFX_ROI_MAX];
    plfx_raw raw = {(const uint8_t *)pixel, sizeof pixel, PLFX_RAW_U16, 12, SW, SH};
    plfx_roi_frame frame = {&raw, NULL};
    int dark = argc > 1 && strcmp(argv[1], "dark") == 0;
    int valid = 0;

    configure();
    if (argc != 3 || table() || rest(&frame)) {
        return 2;
    }
    draw(dark ? 0 : (int32_t)(strtol(argv[1], NULL, 10) * ONE / 100), dark ? 1 : 100);
    for (long n = strtol(argv[2], NULL, 10); n > 0; n--) {
        if (plfx_roi_measure(&roi, &frame, result) != PLFX_OK) {
            return 3;
        }
    }
    for (int k = 0; k < REGIONS; k++) {
        valid += result[k].flags == 0;
    }
    printf("%d valid\n", valid);
    return 0;
}
