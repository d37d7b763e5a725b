/* SPDX-License-Identifier: MIT
 * Workspaces on this target, which .ci/checks/sizes.py compares: a 16-megapixel frame
 * of 289x193 lenses 16.93 pixels apart, 12 bits, window 9 or the preset's, 17 slopes.
 * Prints "name bytes" a line. */
#include "plenofix/plenofix.h"

#include <stdio.h>
#include <string.h>

#define VIEWS   25 /* of the frame presets and of regions */
#define REGIONS 24

static plfx_lut lut;

static void camera(void)
{
    lut.sensor_w = 4904;
    lut.sensor_h = 3280;
    lut.sensor_bits = 12;
    lut.lattice.nx = 289;
    lut.lattice.ny = 193;
    lut.lattice.a.x_q22 = 71009567; /* 16.93 */
    lut.lattice.b.y_q22 = 71009567;
}

/* A cross: the middle, then pairs ever farther along u and v. */
static void cross(plfx_offset *at, int32_t n)
{
    for (int32_t k = 1; k < n; k++) {
        int32_t d = (k % 2 ? -6 : 6) * 256 * ((k + 3) / 4) / ((n + 2) / 4);
        at[k].u_q8 = (int16_t)((k - 1) / 2 % 2 ? 0 : d);
        at[k].v_q8 = (int16_t)((k - 1) / 2 % 2 ? d : 0);
    }
}

static void row(plfx_offset *at, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        at[k].u_q8 = (int16_t)(6 * 256 * (2 * k - (n - 1)) / (n - 1));
    }
}

static plfx_cfg cfg_of(int32_t method, int32_t cost, int32_t n)
{
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.method = (uint8_t)method;
    c.cost = (uint8_t)cost;
    c.window = 9;
    c.bits = 12;
    c.labels = 17;
    c.slope_min_q16 = -10000;
    c.slope_max_q16 = 10000;
    c.n = (uint8_t)n;
    return c;
}

static size_t stream_bytes(const plfx_cfg *c, const plfx_frame_cfg *frame, int32_t fast)
{
    static plfx_plan plan;
    plfx_stream_cfg s;

    memset(&s, 0, sizeof s);
    if (plfx_plan_init(&plan, c, &lut, lut.lattice.nx, lut.lattice.ny) != PLFX_OK) {
        return 0;
    }
    s.plan = &plan;
    s.lut = &lut;
    s.frame = frame;
    s.tone = plfx_tone_unity(12);
    s.profile = (uint8_t)fast;
    s.format = PLFX_RAW_MONO12P;
    s.bits = 12;
    s.open_rows = 1;
    s.j1 = lut.lattice.ny;
    return plfx_stream_ws(&s);
}

static void print(const char *name, size_t bytes)
{
    printf("%s %lu\n", name, (unsigned long)bytes);
}

static void streams(int32_t fast, const char *five, const char *nine)
{
    plfx_cfg c = cfg_of(PLFX_METHOD_SWEEP, PLFX_COST_SAD, 5);

    c.ref = 2;
    row(c.at, 5);
    print(five, stream_bytes(&c, NULL, fast));
    c.n = 9;
    c.ref = 4;
    row(c.at, 9);
    print(nine, stream_bytes(&c, NULL, fast));
}

static void other_streams(void)
{
    plfx_cfg c = cfg_of(PLFX_METHOD_PAIRS, PLFX_COST_ZNCC, 5);
    plfx_frame_cfg frame;

    c.ref = 2;
    row(c.at, 5);
    print("stream_ncc_5_views", stream_bytes(&c, NULL, 0));
    c = cfg_of(PLFX_METHOD_GRADIENT, PLFX_COST_SAD, 5);
    c.at[1].u_q8 = c.at[3].v_q8 = -768;
    c.at[2].u_q8 = c.at[4].v_q8 = 768;
    print("stream_gradient", stream_bytes(&c, NULL, 0));
    c = cfg_of(PLFX_METHOD_ARMS, PLFX_COST_SAD, 9);
    if (plfx_preset(PLFX_PRESET_STREAM, &c, &frame) == PLFX_OK) {
        c.bits = 12;
        c.n = 9;
        cross(c.at, 9);
        print("stream_arms_8_views", stream_bytes(&c, &frame, 0));
    }
}

static void whole_frames(void)
{
    static const char *const name[3] = {"", "frame_onboard_25_views",
                                        "frame_precise_25_views"};
    static plfx_plan plan;

    for (int32_t preset = PLFX_PRESET_ONBOARD; preset <= PLFX_PRESET_PRECISE;
         preset++) {
        plfx_cfg c = cfg_of(PLFX_METHOD_ARMS, PLFX_COST_SAD, VIEWS);
        plfx_frame_cfg frame;
        if (plfx_preset(preset, &c, &frame) == PLFX_OK) {
            c.bits = 12;
            c.n = VIEWS;
            cross(c.at, VIEWS);
            if (plfx_plan_init(&plan, &c, &lut, lut.lattice.nx, lut.lattice.ny) ==
                PLFX_OK) {
                print(name[preset], plfx_frame_ws(&plan, &frame));
            }
        }
    }
}

static void motion(void)
{
    static plfx_roi_cfg c;

    c.lut = &lut;
    c.tone = plfx_tone_unity(12);
    c.views = VIEWS;
    cross(c.at, VIEWS);
    c.regions = REGIONS;
    for (int32_t k = 0; k < REGIONS; k++) {
        c.region[k] = (plfx_roi_region){(int16_t)(20 + 40 * (k % 6)),
                                        (int16_t)(20 + 40 * (k / 6)), 3, 4, k < 4};
    }
    c.rest = 8;
    c.steps = 2;
    c.residual_q8 = 640;
    print("roi_24_regions_25_views", plfx_roi_ws(&c));
    print("drift", plfx_drift_ws(&lut));
}

int main(void)
{
    camera();
    streams(0, "stream_small_5_views", "stream_small_9_views");
    streams(1, "stream_fast_5_views", "stream_fast_9_views");
    other_streams();
    whole_frames();
    motion();
    return 0;
}
