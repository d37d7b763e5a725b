/* SPDX-License-Identifier: MIT
 * Regions: textures displaced by known amounts, in images and in raw frames; flags;
 * camera shake; arguments. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <string.h>

#include "plenofix/plenofix.h"
#include "square_table.h"

#define PI 3.14159265358979323846
#define W  96
#define H  64

static uint16_t image[H * W];
static uint8_t blob[512];
static plfx_lut lut;
static union {
    uint64_t align[8];
    unsigned char bytes[220000];
} memory;
static plfx_roi_cfg cfg;
static plfx_roi roi;
static plfx_roi_result out[PLFX_ROI_MAX];
static uint32_t seed;

static unsigned char *aligned(void)
{
    return memory.bytes + (64u - (uintptr_t)memory.bytes % 64u) % 64u;
}

/* Drawn in single precision: cores without double need minutes otherwise. */
static float noise(float sigma)
{
    uint32_t sum = 0;
    int k;

    for (k = 0; k < 12; k++) {
        seed = seed * 1664525u + 1013904223u;
        sum += seed >> 8;
    }
    return sigma * ((float)sum / 16777216.0f - 6.0f);
}

/* Waves of 4 to 12 samples, 0 .. 1. */
static float texture(float x, float y)
{
    static const float k[8][3] = {{0.22f, 0.05f, 0.3f},  {0.08f, -0.2f, 1.1f},
                                  {-0.13f, 0.14f, 2.5f}, {0.1f, 0.12f, 4.0f},
                                  {0.02f, 0.24f, 5.1f},  {0.16f, -0.1f, 0.9f},
                                  {0.19f, 0.13f, 3.3f},  {-0.05f, 0.11f, 1.9f}};
    float v = 0;
    int n;

    for (n = 0; n < 8; n++) {
        v += sinf(2 * (float)PI * (k[n][0] * x + k[n][1] * y) + k[n][2]);
    }
    return 0.5f + v / 18.0f;
}

static uint16_t digital(float v, float light, float sigma)
{
    float s = floorf(4095.0f * 0.8f * light * v + noise(sigma) + 0.5f);

    return (uint16_t)(s < 0 ? 0 : s > 4095 ? 4095 : s);
}

static void draw(double x, double y, double light, double sigma)
{
    int i;
    int j;

    for (j = 0; j < H; j++) {
        for (i = 0; i < W; i++) {
            float t = texture((float)(i - x), (float)(j - y));
            image[j * W + i] = digital(t, (float)light, (float)sigma);
        }
    }
}

/* 10 x 7 lenses of 9 px: pixel (u,v) of a lens sees texture(3*(i-x-d*u), ...). */
#define LENS 9
static uint16_t raw[LENS * 18 * LENS * 24];

static double fine;     /* texture of 0.7 cycle a lens, alike in all views */
static double bar = -9; /* lens column of a dark bar at another depth */

static float clean[LENS * 18 * LENS * 24]; /* the scene drawn last, without noise */

static void draw_clean(double x, double y, double d)
{
    int w = LENS * 24;
    int h = LENS * 18;
    int i;
    int j;

    for (j = 0; j < h; j++) {
        for (i = 0; i < w; i++) {
            int u = i % LENS - LENS / 2;
            int v = j % LENS - LENS / 2;
            float at = (float)(i / LENS) - (float)x;
            float t =
                texture(at - (float)(d * u), (float)(j / LENS) - (float)(y + d * v));
            if (fine > 0) {
                t += (float)fine * sinf(2 * (float)PI * 0.7f * at);
            }
            t = fabsf((float)(i / LENS) + 0.15f * (float)u - (float)bar) < 0.8f ? 0.05f
                                                                                : t;
            clean[j * w + i] = t;
        }
    }
}

static void draw_raw(double x, double y, double d, double light, double sigma)
{
    static double last[5] = {NAN};
    double now[5] = {x, y, d, fine, bar};
    int i;

    if (memcmp(last, now, sizeof now) != 0) {
        draw_clean(x, y, d);
        memcpy(last, now, sizeof now);
    }
    for (i = 0; i < LENS * 18 * LENS * 24; i++) {
        raw[i] = digital(clean[i], (float)light, (float)sigma);
    }
}

static plfx_roi_frame frame_of_image(void)
{
    static plfx_image m;
    plfx_roi_frame f = {NULL, &m};

    m.px = image;
    m.w = W;
    m.h = H;
    m.stride = W;
    return f;
}

static plfx_roi_frame frame_of_raw(void)
{
    static plfx_raw r;
    plfx_roi_frame f = {&r, NULL};

    r.bytes = (const uint8_t *)raw;
    r.size = sizeof raw;
    r.format = PLFX_RAW_U16;
    r.bits = 12;
    r.w = LENS * 24;
    r.h = LENS * 18;
    return f;
}

static void image_cfg(void)
{
    int k;

    memset(&cfg, 0, sizeof cfg);
    cfg.nx = W;
    cfg.ny = H;
    cfg.bits = 12;
    cfg.tone = plfx_tone_unity(12);
    cfg.views = 1;
    cfg.regions = 4;
    for (k = 0; k < 4; k++) {
        cfg.region[k].i = (int16_t)(20 + 18 * k);
        cfg.region[k].j = (int16_t)(k % 2 ? 22 : 42);
        cfg.region[k].hx = 8;
        cfg.region[k].hy = 8;
        cfg.region[k].reference = (uint8_t)(k != 2);
    }
    cfg.rest = 4;
    cfg.steps = 2;
    cfg.residual_q8 = 640;
}

static void raw_cfg(void)
{
    plfx_lut_desc d = square_table(24, 18, LENS);
    int k;

    d.radius_q8 = 4 << 8;
    assert_true(plfx_lut_bytes(&d) <= sizeof blob);
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, plfx_lut_bytes(&d)), PLFX_OK);
    memset(&cfg, 0, sizeof cfg);
    cfg.lut = &lut;
    cfg.tone = plfx_tone_unity(12);
    cfg.views = 9;
    for (k = 0; k < 2; k++) {
        cfg.at[4 * k + 1].u_q8 = (int16_t)(384 * (k + 1));
        cfg.at[4 * k + 2].u_q8 = (int16_t)(-384 * (k + 1));
        cfg.at[4 * k + 3].v_q8 = (int16_t)(384 * (k + 1));
        cfg.at[4 * k + 4].v_q8 = (int16_t)(-384 * (k + 1));
    }
    cfg.regions = 2;
    for (k = 0; k < 2; k++) {
        cfg.region[k].i = (int16_t)(7 + 9 * k);
        cfg.region[k].j = 8;
        cfg.region[k].hx = 3;
        cfg.region[k].hy = 4;
    }
    cfg.rest = 8;
    cfg.steps = 2;
    cfg.residual_q8 = 640;
}

static void start(const plfx_roi_frame *frame, double sigma)
{
    size_t need = plfx_roi_ws(&cfg);
    int k;

    assert_true(need > 0 && need + 64u <= sizeof memory.bytes);
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), need - 1u), PLFX_E_SIZE);
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), need), PLFX_OK);
    assert_int_equal(plfx_roi_measure(&roi, frame, out), PLFX_E_STATE);
    seed = 7;
    for (k = 0; k < cfg.rest; k++) {
        if (cfg.lut) {
            draw_raw(0, 0, 0, 1, sigma);
        } else {
            draw(0, 0, 1, sigma);
        }
        assert_int_equal(plfx_roi_rest(&roi, frame), PLFX_OK);
    }
    assert_int_equal(plfx_roi_rest(&roi, frame), PLFX_E_STATE);
}

static double lens(int32_t q24)
{
    return q24 / 16777216.0;
}

static void images_are_followed(void **s)
{
    plfx_roi_frame f = frame_of_image();
    int t;
    int k;
    (void)s;
    image_cfg();
    start(&f, 4);
    for (t = 0; t < 40; t++) {
        double x = 2.0 * sin(0.21 * t);
        double y = 1.3 * sin(0.29 * t);
        draw(x, y, 1, 4);
        assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
        for (k = 0; k < 4; k++) {
            assert_int_equal(out[k].flags, 0);
            assert_true(fabs(lens(out[k].u_q24) - x) < 0.012);
            assert_true(fabs(lens(out[k].v_q24) - y) < 0.012);
            assert_int_equal(out[k].w_q24, PLFX_ROI_NONE);
        }
    }
}

/* Stated errors against the scatter of 120 still frames. */
static void stated_errors_are_the_scatter(void **s)
{
    plfx_roi_frame f = frame_of_raw();
    double sum[3] = {0, 0, 0};
    double stated[3] = {0, 0, 0};
    int t;
    int k;
    (void)s;
    raw_cfg();
    start(&f, 12);
    for (t = 0; t < 120; t++) {
        draw_raw(0, 0, 0, 1, 12);
        assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
        for (k = 0; k < 2; k++) {
            assert_int_equal(out[k].flags, 0);
            sum[0] += lens(out[k].u_q24) * lens(out[k].u_q24);
            sum[1] += lens(out[k].v_q24) * lens(out[k].v_q24);
            sum[2] += lens(out[k].w_q24) * lens(out[k].w_q24);
            stated[0] += lens((int32_t)out[k].u_sigma_q24) / 240;
            stated[1] += lens((int32_t)out[k].v_sigma_q24) / 240;
            stated[2] += lens((int32_t)out[k].w_sigma_q24) / 240;
        }
    }
    for (k = 0; k < 3; k++) {
        double ratio = stated[k] / sqrt(sum[k] / 240);
        assert_true(ratio > 0.75 && ratio < 1.25);
    }
}

static void slopes_and_flicker_are_separated(void **s)
{
    plfx_roi_frame f = frame_of_raw();
    int t;
    int k;
    (void)s;
    raw_cfg();
    start(&f, 2);
    for (t = 0; t < 24; t++) {
        double x = 0.3 * sin(0.4 * t);
        double d = 0.02 * sin(0.9 * t);
        double light = 1 + 0.1 * sin(1.3 * t);
        draw_raw(x, -x, d, light, 2);
        assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
        for (k = 0; k < 2; k++) {
            assert_int_equal(out[k].flags, 0);
            assert_true(fabs(lens(out[k].u_q24) - x) < 0.01);
            assert_true(fabs(lens(out[k].v_q24) + x) < 0.01);
            assert_true(fabs(lens(out[k].w_q24) - d) < 0.0015);
            assert_true(fabs(out[k].light_q12 / 4096.0 - light) < 0.02);
        }
    }
}

/* What the interpolator misses is alike in all views: u is less sure, w is not. */
static void fine_texture_widens_the_plane_alone(void **s)
{
    plfx_roi_frame f = frame_of_raw();
    double rest[2];
    int t;
    (void)s;
    raw_cfg();
    fine = 0.06;
    start(&f, 12);
    draw_raw(0, 0, 0, 1, 12);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    rest[0] = lens((int32_t)out[0].u_sigma_q24);
    rest[1] = lens((int32_t)out[0].w_sigma_q24);
    for (t = 0; t < 12; t++) {
        double x = 0.4 * sin(0.7 * t + 0.3);
        draw_raw(x, 0, 0.004, 1, 12);
        assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
        assert_true(lens((int32_t)out[0].w_sigma_q24) < 1.4 * rest[1]);
        assert_true(fabs(lens(out[0].w_q24) - 0.004) < 4.5 * rest[1]);
        if (fabs(x) > 0.2 && out[0].flags == 0) {
            assert_true(lens((int32_t)out[0].u_sigma_q24) > 2 * rest[0]);
        }
    }
    fine = 0;
}

/* A bar at another depth before the margin of the rest state, beside the region: the
 * region, columns 4 to 10, reads up to column 13. */
static void a_bar_before_the_margin_is_flagged(void **s)
{
    plfx_roi_frame f = frame_of_raw();
    (void)s;
    raw_cfg();
    bar = 12;
    start(&f, 4);
    draw_raw(0.3, 0, 0, 1, 4);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_equal(out[0].flags, PLFX_ROI_OCCLUDED);
    assert_int_equal(out[0].w_q24, PLFX_ROI_NONE);
    bar = 16.5;
    start(&f, 4);
    draw_raw(0.3, 0, 0, 1, 4);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_equal(out[0].flags, 0);
    bar = -9;
}

static void darkness_and_cover_are_flagged(void **s)
{
    plfx_roi_frame f = frame_of_image();
    int j;
    int i;
    (void)s;
    image_cfg();
    start(&f, 4);
    draw(0, 0, 0.1, 4);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_not_equal(out[0].flags & PLFX_ROI_LIGHT, 0);
    draw(0, 0, 0, 0);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_not_equal(out[0].flags & PLFX_ROI_LIGHT, 0);
    draw(0, 0, 1, 4);
    for (j = 0; j < H; j++) {
        for (i = 17; i < 22; i++) {
            image[j * W + i] = 400;
        }
    }
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_not_equal(out[0].flags & PLFX_ROI_OCCLUDED, 0);
    assert_int_equal(out[2].flags, 0);
    draw(0, 0, 1, 4);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_equal(out[0].flags, 0);
}

static void lost_regions_are_sought(void **s)
{
    plfx_roi_frame f = frame_of_image();
    (void)s;
    image_cfg();
    cfg.seek = 6;
    start(&f, 4);
    draw(5.2, -3.4, 1, 4);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_equal(out[1].flags, 0);
    assert_true(fabs(lens(out[1].u_q24) - 5.2) < 0.012);
    assert_true(fabs(lens(out[1].v_q24) + 3.4) < 0.012);
}

static void smooth_edge_and_clipped_regions_are_flagged(void **s)
{
    plfx_roi_frame f = frame_of_image();
    int k;
    int i;
    (void)s;
    image_cfg();
    cfg.region[1].i = 9; /* leaves by its margin */
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), plfx_roi_ws(&cfg)), PLFX_OK);
    for (k = 0; k < cfg.rest; k++) {
        draw(0, 0, 1, 2);
        for (i = 0; i < H * W; i++) {
            if (i % W >= 60 && i % W < 73 + 15) {
                image[i] = (uint16_t)(1000 + 400 * (i % W % 5)); /* stripes */
            }
            if (i % W < 34) {
                image[i] = 2000;
            }
        }
        assert_int_equal(plfx_roi_rest(&roi, &f), PLFX_OK);
    }
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_equal(out[0].flags, PLFX_ROI_TEXTURE);
    assert_int_equal(out[1].flags, PLFX_ROI_EDGE);
    assert_int_equal(out[3].flags, PLFX_ROI_TEXTURE);
    assert_int_equal(out[0].u_q24, PLFX_ROI_NONE);
    assert_int_equal(out[2].flags, 0);
    for (i = 0; i < H * W; i++) {
        image[i] = (uint16_t)(image[i] > 1500 ? 4095 : image[i]);
    }
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_OK);
    assert_int_not_equal(out[2].flags, 0);
}

static void shake_is_taken_off(void **s)
{
    plfx_roi_shake shake;
    int k;
    (void)s;
    image_cfg();
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), plfx_roi_ws(&cfg)), PLFX_OK);
    memset(out, 0, sizeof out);
    for (k = 0; k < 4; k++) { /* 0.4 lens, a turn of 0.001, tilt of w; region 2 moves */
        double i = cfg.region[k].i - 40.0;
        double j = cfg.region[k].j - 30.0;
        double more = k == 2 ? 0.125 : 0;
        out[k].u_q24 = (int32_t)((0.4 - 0.001 * j + 0.0004 * i + more) * 16777216);
        out[k].v_q24 = (int32_t)((-0.2 + 0.001 * i + 0.0004 * j) * 16777216);
        out[k].w_q24 = (int32_t)((0.01 + 0.0002 * i - 0.0001 * j) * 16777216);
    }
    assert_int_equal(plfx_roi_shake_fit(&roi, out, &shake), PLFX_OK);
    assert_int_equal(shake.n, 3);
    plfx_roi_steady(&roi, &shake, out);
    for (k = 0; k < 4; k++) {
        assert_true(fabs(lens(out[k].u_q24) - (k == 2 ? 0.125 : 0)) < 1e-4);
        assert_true(fabs(lens(out[k].v_q24)) < 1e-4);
        assert_true(fabs(lens(out[k].w_q24)) < 1e-4);
        out[k].flags = PLFX_ROI_OCCLUDED;
    }
    assert_int_equal(plfx_roi_shake_fit(&roi, out, &shake), PLFX_OK);
    assert_int_equal(shake.n, 0);
}

/* Three references about the middle of lenses (20, 20), (56, 20), (38, 52): what is
 * taken off is less sure far from them; references keep their own error. */
static void shake_adds_its_error(void **s)
{
    static const int16_t at[4][2] = {{20, 20}, {56, 20}, {38, 52}, {80, 52}};
    double spread = 2 * 18 * 18 + 2 * (32.0 / 3) * (32.0 / 3) + (64.0 / 3) * (64.0 / 3);
    double i = 80 - 38;
    double j = 52 - 92.0 / 3;
    double u = sqrt(4 + 1 / 3.0 + (i * i + j * j) / spread);
    double w = sqrt(4 + 1 / 3.0 + i * i / 648 + j * j / (spread - 648));
    plfx_roi_shake shake;
    int k;
    (void)s;
    image_cfg();
    for (k = 0; k < 4; k++) {
        cfg.region[k].i = at[k][0];
        cfg.region[k].j = at[k][1];
        cfg.region[k].reference = k < 3;
    }
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), plfx_roi_ws(&cfg)), PLFX_OK);
    memset(out, 0, sizeof out);
    for (k = 0; k < 4; k++) {
        out[k].u_sigma_q24 = out[k].v_sigma_q24 = k < 3 ? 10000 : 20000;
        out[k].w_sigma_q24 = out[k].u_sigma_q24;
    }
    assert_int_equal(plfx_roi_shake_fit(&roi, out, &shake), PLFX_OK);
    assert_int_equal(shake.uv_sigma_q24, 10000);
    plfx_roi_steady(&roi, &shake, out);
    assert_int_equal(out[0].u_sigma_q24, 10000);
    assert_true(fabs(out[3].u_sigma_q24 - 10000 * u) < 100);
    assert_true(fabs(out[3].v_sigma_q24 - 10000 * u) < 100);
    assert_true(fabs(out[3].w_sigma_q24 - 10000 * w) < 100);
}

/* One reference: its own error, however far the region; no turn can be told.  Errors
 * end at INT32_MAX. */
static void one_reference_adds_its_error_alone(void **s)
{
    plfx_roi_shake shake;
    int k;
    (void)s;
    image_cfg();
    for (k = 0; k < 4; k++) {
        cfg.region[k].reference = k == 0;
    }
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), plfx_roi_ws(&cfg)), PLFX_OK);
    memset(out, 0, sizeof out);
    for (k = 0; k < 4; k++) {
        out[k].u_sigma_q24 = out[k].v_sigma_q24 = out[k].w_sigma_q24 = 30000;
    }
    out[3].v_sigma_q24 = INT32_MAX;
    assert_int_equal(plfx_roi_shake_fit(&roi, out, &shake), PLFX_OK);
    assert_int_equal(shake.n, 1);
    plfx_roi_steady(&roi, &shake, out);
    assert_int_equal(out[0].u_sigma_q24, 30000);
    assert_true(fabs(out[3].u_sigma_q24 - 30000 * sqrt(2)) < 2);
    assert_true(fabs(out[3].w_sigma_q24 - 30000 * sqrt(2)) < 2);
    assert_int_equal(out[3].v_sigma_q24, INT32_MAX);
}

static void packed_frames_give_the_same_bits(void **s)
{
    static uint8_t packed[LENS * 18 * LENS * 24 * 3 / 2];
    static plfx_roi_result first[2];
    plfx_roi_frame f = frame_of_raw();
    plfx_raw p = {packed, sizeof packed, PLFX_RAW_MONO12P, 12, LENS * 24, LENS * 18};
    plfx_roi_frame g = {&p, NULL};
    size_t k;
    (void)s;
    raw_cfg();
    start(&f, 5);
    draw_raw(0.1, 0.05, 0.01, 1, 5);
    assert_int_equal(plfx_roi_measure(&roi, &f, first), PLFX_OK);
    for (k = 0; k < sizeof packed; k += 3) {
        uint32_t a = raw[2 * (k / 3)];
        uint32_t b = raw[2 * (k / 3) + 1];
        packed[k] = (uint8_t)(a & 255u);
        packed[k + 1] = (uint8_t)((a >> 8 | b << 4) & 255u);
        packed[k + 2] = (uint8_t)(b >> 4);
    }
    assert_int_equal(plfx_roi_measure(&roi, &g, out), PLFX_OK);
    for (k = 0; k < 2; k++) {
        assert_int_equal(out[k].u_q24, first[k].u_q24);
        assert_int_equal(out[k].w_q24, first[k].w_q24);
        assert_int_equal(out[k].u_sigma_q24, first[k].u_sigma_q24);
    }
    p.size--;
    assert_int_equal(plfx_roi_measure(&roi, &g, out), PLFX_E_SIZE);
    p.w--;
    assert_int_equal(plfx_roi_measure(&roi, &g, out), PLFX_E_ARG);
}

static void bad_configurations_are_refused(void **s)
{
    (void)s;
    image_cfg();
    assert_true(plfx_roi_ws(&cfg) > 0);
    assert_int_equal(plfx_roi_ws(NULL), 0);
    cfg.regions = PLFX_ROI_MAX + 1;
    assert_int_equal(plfx_roi_ws(&cfg), 0);
    image_cfg();
    cfg.region[3].hx = 0;
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), 1000000), PLFX_E_ARG);
    image_cfg();
    cfg.views = 2;
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), 1000000), PLFX_E_ARG);
    image_cfg();
    cfg.rest = 17;
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), 1000000), PLFX_E_ARG);
    image_cfg();
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned() + 1, 1000000), PLFX_E_SIZE);
    raw_cfg();
    lut.lattice.kind = PLFX_LATTICE_HEX;
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(), 1000000), PLFX_E_RANGE);
    assert_int_equal(plfx_roi_init(&roi, &cfg, NULL, 1000000), PLFX_E_ARG);
}

static void the_macro_bounds_the_function(void **s)
{
    size_t bound = PLFX_ROI_WS(4, 17u, 17u, 1u, 0, 0u);
    (void)s;
    image_cfg();
    assert_true(plfx_roi_ws(&cfg) <= bound);
    raw_cfg();
    bound = PLFX_ROI_WS(2, 7u, 9u, 9u, 0, 24u);
    assert_true(plfx_roi_ws(&cfg) <= bound);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_are_followed),
        cmocka_unit_test(stated_errors_are_the_scatter),
        cmocka_unit_test(slopes_and_flicker_are_separated),
        cmocka_unit_test(fine_texture_widens_the_plane_alone),
        cmocka_unit_test(a_bar_before_the_margin_is_flagged),
        cmocka_unit_test(darkness_and_cover_are_flagged),
        cmocka_unit_test(lost_regions_are_sought),
        cmocka_unit_test(smooth_edge_and_clipped_regions_are_flagged),
        cmocka_unit_test(shake_is_taken_off),
        cmocka_unit_test(shake_adds_its_error),
        cmocka_unit_test(one_reference_adds_its_error_alone),
        cmocka_unit_test(packed_frames_give_the_same_bits),
        cmocka_unit_test(bad_configurations_are_refused),
        cmocka_unit_test(the_macro_bounds_the_function),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
