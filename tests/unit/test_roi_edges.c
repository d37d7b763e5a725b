/* SPDX-License-Identifier: MIT
 * Regions at their ends: what a rest state cannot be learnt from, light and slopes out
 * of range, samples off the sensor, clipped and black ones, few references. */
#include <math.h>

#include "suite.h"
#include "square_table.h"

#include "plenofix/roi.h"
#include "roi_state.h"

#define W    56 /* single images */
#define H    40
#define NX   20 /* lenses of a raw frame, LENS pixels on a side */
#define NY   16
#define LENS 5

static uint16_t image[W * H], raw[NX * LENS * NY * LENS];
static uint8_t blob[512];
static plfx_lut lut;
static uint64_t memory[10000];
static plfx_roi_cfg cfg;
static plfx_roi roi;
static plfx_roi_result out[3];
static plfx_image picture = {image, W, H, W};
static plfx_raw frame;
static const plfx_roi_frame still = {&frame, &picture}; /* whichever is asked for */

/* Waves of 5 to 9 samples, -1 .. 1. */
static double waves(double x, double y)
{
    return (sin(1.2 * x + 0.3 * y) + sin(0.4 * x - 1.1 * y + 1) +
            sin(0.7 * x + 0.6 * y + 2) + sin(-0.8 * x + 0.5 * y + 4)) /
           4;
}

static uint16_t level(double v)
{
    return (uint16_t)(v < 0 ? 0 : v > 4095 ? 4095 : v + 0.5);
}

static void draw(double x, double y, double mean, double swing)
{
    int32_t k;

    for (k = 0; k < W * H; k++) {
        image[k] = level(mean + swing * waves(k % W - x, (double)(k / W) - y));
    }
}

/* Pixel (u, v) of a lens sees the scene d*u, d*v lenses aside. */
static void draw_raw(double d, double mean)
{
    int32_t k;

    for (k = 0; k < NX * LENS * NY * LENS; k++) {
        int32_t px = k % (NX * LENS);
        int32_t py = k / (NX * LENS);
        double x = px / LENS - d * (px % LENS - LENS / 2);
        double y = py / LENS - d * (py % LENS - LENS / 2);
        raw[k] = level(mean + 1200 * waves(x, y));
    }
}

static void image_cfg(void)
{
    memset(&cfg, 0, sizeof cfg);
    cfg.nx = W;
    cfg.ny = H;
    cfg.bits = 12;
    cfg.tone = plfx_tone_unity(12);
    cfg.views = 1;
    cfg.regions = 2;
    cfg.region[0] = (plfx_roi_region){14, 20, 5, 5, 1};
    cfg.region[1] = (plfx_roi_region){42, 20, 5, 5, 1};
    cfg.rest = 2;
    cfg.steps = 2;
    cfg.residual_q8 = 640;
}

static void raw_cfg(void)
{
    plfx_lut_desc d = square_table(NX, NY, LENS);
    int32_t k;

    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, sizeof blob), PLFX_OK);
    image_cfg();
    cfg.lut = &lut;
    cfg.views = 5;
    for (k = 0; k < 2; k++) {
        cfg.at[1 + k].u_q8 = (int16_t)(1024 * k - 512);
        cfg.at[3 + k].v_q8 = (int16_t)(1024 * k - 512);
    }
    cfg.region[0] = (plfx_roi_region){6, 8, 3, 3, 1};
    cfg.region[1] = (plfx_roi_region){13, 8, 3, 3, 1};
    frame = (plfx_raw){
        (const uint8_t *)raw, sizeof raw, PLFX_RAW_U16, 12, NX * LENS, NY * LENS};
}

/* The rest state is what is drawn now. */
static void rest(void)
{
    int32_t k;

    assert_true(plfx_roi_ws(&cfg) <= sizeof memory - 64u);
    assert_int_equal(plfx_roi_init(&roi, &cfg, aligned(memory), sizeof memory - 64u),
                     PLFX_OK);
    for (k = 0; k < cfg.rest; k++) {
        assert_int_equal(plfx_roi_rest(&roi, &still), PLFX_OK);
    }
}

static void measure(void)
{
    assert_int_equal(plfx_roi_measure(&roi, &still, out), PLFX_OK);
}

static double lens(int32_t q24)
{
    return q24 / 16777216.0;
}

static void black_and_oblique_stripes_are_no_texture(void **s)
{
    int32_t k;

    (void)s;
    image_cfg();
    for (k = 0; k < W * H; k++) { /* the left half black, the right half oblique */
        image[k] = k % W < W / 2 ? 0 : level(2000 + 1500 * sin(k % W + k / W));
    }
    rest();
    measure();
    assert_int_equal(out[0].flags, PLFX_ROI_TEXTURE);
    assert_int_equal(out[1].flags, PLFX_ROI_TEXTURE);
    assert_int_equal(out[1].u_q24, PLFX_ROI_NONE);
}

static void one_frame_at_rest_knows_no_noise(void **s)
{
    int32_t k;

    (void)s;
    image_cfg();
    cfg.rest = 1;
    draw(0, 0, 2000, 1500);
    rest();
    draw(0.25, -0.125, 2000, 1500);
    for (k = 0; k < W * H; k++) {
        image[k] = k % W > 40 && k % W < 44 ? 1000 : image[k]; /* a cover */
    }
    measure();
    assert_int_equal(out[0].flags, 0);
    assert_int_equal(out[0].residual_q8, 0);
    assert_true(fabs(lens(out[0].u_q24) - 0.25) < 0.01);
    assert_true(fabs(lens(out[0].v_q24) + 0.125) < 0.01);
    assert_int_equal(out[1].flags & PLFX_ROI_OCCLUDED, 0);
    assert_int_equal(out[1].residual_q8, 0);
}

/* Nine samples of one value amid texture move but tell nothing of the light; with some
 * contrast they do. */
static void the_least_region_knows_its_light(void **s)
{
    int32_t k;

    (void)s;
    image_cfg();
    cfg.region[0].hx = cfg.region[0].hy = 1;
    cfg.region[1].hx = cfg.region[1].hy = 1;
    draw(0, 0, 2000, 400);
    for (k = 0; k < 9; k++) {
        image[(19 + k / 3) * W + 13 + k % 3] = 2000;
    }
    rest();
    draw(0, 0, 2400, 480);
    measure();
    assert_int_equal(out[0].light_q12, 4096);
    assert_true(fabs(out[1].light_q12 / 4096.0 - 1.2) < 0.01);
}

static void light_over_four_times_is_flagged(void **s)
{
    (void)s;
    image_cfg();
    draw(0, 0, 400, 300);
    rest();
    draw(0, 0, 1560, 1170);
    measure();
    assert_int_equal(out[0].flags & PLFX_ROI_LIGHT, 0);
    draw(0, 0, 1640, 1230);
    measure();
    assert_int_equal(out[0].flags & PLFX_ROI_LIGHT, PLFX_ROI_LIGHT);
    assert_true(fabs(out[0].light_q12 / 4096.0 - 4.1) < 0.05);
}

static void clip(uint16_t *px, int32_t w, int32_t x0, int32_t x1, int32_t n)
{
    int32_t k;

    for (k = 0; k < n; k++) {
        if (k % w >= x0 && k % w < x1) {
            px[k] = 4095;
        }
    }
}

/* Over a 64th of a region's samples at full scale, in images and in raw frames. */
static void clipped_samples_are_flagged(void **s)
{
    (void)s;
    image_cfg();
    draw(0, 0, 2000, 1500);
    rest();
    measure();
    assert_int_equal(out[0].flags, 0);
    clip(image, W, 14, 15, W * H);
    measure();
    assert_int_equal(out[0].flags & PLFX_ROI_SATURATED, PLFX_ROI_SATURATED);
    assert_int_equal(out[1].flags, 0);
    draw(0, 0, 2000, 1500);
    cfg.tone.sat_u16 = 3000 << 4; /* the user's own limit */
    rest();
    clip(image, W, 14, 15, W * H);
    measure();
    assert_int_equal(out[0].flags & PLFX_ROI_SATURATED, PLFX_ROI_SATURATED);
    raw_cfg();
    draw_raw(0, 2000);
    rest();
    clip(raw, NX * LENS, 6 * LENS, 7 * LENS, NX * LENS * NY * LENS);
    measure();
    assert_int_equal(out[0].flags & PLFX_ROI_SATURATED, PLFX_ROI_SATURATED);
    assert_int_equal(out[1].flags, 0);
}

/* Share of noise of two views at `d` pixels from each other. */
static double spline(double d)
{
    double t = fabs(d);
    double r = 2 - t;

    return t < 1 ? 1 - 1.5 * t * t + 0.75 * t * t * t : t < 2 ? r * r * r / 4 : 0;
}

/* g of sample i of a view along columns, rows, slope, less what the light takes off;
 * over the square roots of the information. */
static void response(const plfx_roi_patch *p, int32_t view, size_t i, double g[3])
{
    int32_t k;

    g[0] = p->gx[i];
    g[1] = p->gy[i];
    g[2] = (g[0] * roi.lean_q12[view][0] + g[1] * roi.lean_q12[view][1]) / 4096;
    for (k = 0; k < 3; k++) {
        int32_t off = p->ref[i] >= p->split ? p->alpha_q12[k] : p->beta_q12[k];
        g[k] = (g[k] - off / 4096.0) / (double)p->scale[k];
    }
}

/* Standard error for unit noise: diagonal of I^-1 C I^-1, summed sample by sample. */
static double spread(const plfx_roi_patch *p, int32_t k)
{
    size_t n = (size_t)(p->w * p->h);
    double sum = 0;
    int32_t pair;
    size_t i;

    for (pair = 0; pair < cfg.views * cfg.views; pair++) {
        int32_t a = pair / cfg.views;
        int32_t b = pair % cfg.views;
        double weight = spline((cfg.at[a].u_q8 - cfg.at[b].u_q8) / 256.0) *
                        spline((cfg.at[a].v_q8 - cfg.at[b].v_q8) / 256.0);
        for (i = 0; i < n; i++) {
            size_t ia = n * (size_t)a + i;
            size_t ib = n * (size_t)b + i;
            double ga[3];
            double gb[3];
            double la = 0;
            double lb = 0;
            int32_t l;
            if (p->ref[ia] == PLFX_ROI_UNUSED || p->ref[ib] == PLFX_ROI_UNUSED) {
                continue;
            }
            response(p, a, ia, ga);
            response(p, b, ib, gb);
            for (l = 0; l < 3; l++) {
                la += p->inv_q24[k][l] / 16777216.0 * ga[l];
                lb += p->inv_q24[k][l] / 16777216.0 * gb[l];
            }
            sum += weight * la * lb;
        }
    }
    return sqrt(sum);
}

/* A lens that is clipped at rest in one view takes part in the others alone. */
static void a_sample_clipped_in_one_view_at_rest(void **s)
{
    int32_t k;

    (void)s;
    raw_cfg();
    for (k = 1; k < cfg.views; k++) { /* near enough to share pixels */
        cfg.at[k].u_q8 /= 2;
        cfg.at[k].v_q8 /= 2;
    }
    draw_raw(0, 2000);
    raw[(8 * LENS + 2) * NX * LENS + 6 * LENS + 3] = 4095; /* u = 1 of lens (6, 8) */
    rest();
    assert_int_equal(roi.patch[0].used, 5 * 49 - 1);
    measure();
    assert_int_equal(out[0].flags, 0);
    assert_int_equal(out[0].u_q24, 0);
    for (k = 0; k < 3; k++) {
        double want = 4096 * spread(&roi.patch[0], k);
        assert_true(fabs(roi.patch[0].spread_q12[k] - want) < 2 + 0.001 * want);
    }
}

static void slopes_out_of_range_are_flagged(void **s)
{
    int32_t sign;

    (void)s;
    raw_cfg();
    draw_raw(0, 2000);
    rest();
    for (sign = -1; sign <= 1; sign += 2) {
        draw_raw(0.1 * sign, 2000);
        measure();
        assert_int_equal(out[0].flags & PLFX_ROI_RANGE, 0);
        assert_true(fabs(lens(out[0].w_q24) - 0.1 * sign) < 0.01);
        draw_raw(0.35 * sign, 2000); /* 0.7 lenses at the rim */
        measure();
        assert_int_equal(out[0].flags & PLFX_ROI_RANGE, PLFX_ROI_RANGE);
    }
}

static void one_view_of_a_table_has_no_slope(void **s)
{
    (void)s;
    raw_cfg();
    cfg.views = 1;
    draw_raw(0, 2000);
    rest();
    measure();
    assert_int_equal(out[0].flags, 0);
    assert_int_equal(out[0].u_q24, 0);
    assert_int_equal(out[0].w_q24, PLFX_ROI_NONE);
    assert_int_equal(out[0].w_sigma_q24, 0);
}

static void white_of_a_table_without_gains_is_one(void **s)
{
    plfx_roi_result plain;

    (void)s;
    raw_cfg();
    draw_raw(0, 2000);
    rest();
    draw_raw(0.05, 1900);
    measure();
    plain = out[0];
    cfg.white = 1;
    draw_raw(0, 2000);
    rest();
    draw_raw(0.05, 1900);
    measure();
    assert_int_equal(out[0].w_q24, plain.w_q24);
    assert_int_equal(out[0].light_q12, plain.light_q12);
}

/* Sampled at whole pixels: black taken off by the tone or beforehand is the same. */
static void samples_under_black_are_black(void **s)
{
    plfx_roi_result want;
    int32_t k;

    (void)s;
    raw_cfg();
    draw_raw(0, 2000);
    for (k = 0; k < NX * LENS * NY * LENS; k++) {
        raw[k] = (uint16_t)(raw[k] > 1800 ? raw[k] - 1800 : 0);
    }
    rest();
    raw[(8 * LENS + 2) * NX * LENS + 6 * LENS + 2] += 100;
    measure();
    want = out[0];
    cfg.tone.black_u16 = 1800 << 4;
    draw_raw(0, 2000);
    rest();
    raw[(8 * LENS + 2) * NX * LENS + 6 * LENS + 2] += 100;
    measure();
    assert_int_equal(out[0].u_q24, want.u_q24);
    assert_int_equal(out[0].light_q12, want.light_q12);
    assert_int_not_equal(out[0].u_q24, 0);
}

/* Measures a displaced scene from 16-bit and from packed frames; equal. */
static void packed_reads_the_same(void)
{
    static uint8_t packed[sizeof raw / 4 * 3];
    plfx_roi_result plain[2];
    size_t k;

    draw_raw(0, 2000);
    rest();
    draw_raw(0.02, 2000);
    measure();
    memcpy(plain, out, sizeof plain);
    draw_raw(0, 2000);
    rest();
    draw_raw(0.02, 2000);
    for (k = 0; k < sizeof packed; k += 3) {
        uint32_t a = raw[k / 3 * 2];
        uint32_t b = raw[k / 3 * 2 + 1];
        packed[k] = (uint8_t)(a & 255u);
        packed[k + 1] = (uint8_t)((a >> 8 | b << 4) & 255u);
        packed[k + 2] = (uint8_t)(b >> 4);
    }
    frame.bytes = packed;
    frame.size = sizeof packed;
    frame.format = PLFX_RAW_MONO12P;
    measure();
    for (k = 0; k < 2; k++) {
        assert_int_equal(out[k].u_q24, plain[k].u_q24);
        assert_int_equal(out[k].v_q24, plain[k].v_q24);
        assert_int_equal(out[k].w_q24, plain[k].w_q24);
        assert_int_equal(out[k].u_sigma_q24, plain[k].u_sigma_q24);
        assert_int_not_equal(out[k].u_q24, PLFX_ROI_NONE);
    }
}

/* A view beyond the sensor's side reads its last column or row, packed or not. */
static void views_off_the_sensor_take_its_last_column(void **s)
{
    (void)s;
    raw_cfg();
    cfg.at[2].u_q8 = 5 * 256 + 128;
    cfg.region[1].i = NX - 7;
    packed_reads_the_same();
}

static void views_off_the_sensor_take_its_last_row(void **s)
{
    (void)s;
    raw_cfg();
    cfg.at[3].v_q8 = -17 * 256 - 128; /* half a row over the first, under the last */
    cfg.at[4].v_q8 = 17 * 256 + 128;
    cfg.region[0].j = 6;
    cfg.region[1].j = NY - 7;
    packed_reads_the_same();
}

/* Lost beside the image's side: sought on the inner side only; aimed off it: found
 * again where a search reaches. */
static void regions_are_sought_inside_alone(void **s)
{
    (void)s;
    image_cfg();
    cfg.region[0].i = 8; /* its margin ends at the side */
    cfg.seek = 6;
    draw(0, 0, 2000, 1500);
    rest();
    draw(4.25, 0, 2000, 1500);
    measure();
    assert_int_equal(out[0].flags, 0);
    assert_true(fabs(lens(out[0].u_q24) - 4.25) < 0.02);
    assert_int_equal(plfx_roi_aim(&roi, 0, -5, 0), PLFX_OK);
    draw(0, 0, 2000, 1500);
    measure();
    assert_int_equal(out[0].flags, 0);
    assert_int_equal(out[0].u_q24, 0);
    cfg.seek = 0;
    rest();
    assert_int_equal(plfx_roi_aim(&roi, 0, -5, 0), PLFX_OK);
    measure();
    assert_int_equal(out[0].flags, PLFX_ROI_EDGE);
}

/* Displacements of a camera that turns, zooms and tilts, seen at n references. */
static plfx_roi_shake shaken(int32_t n, const int16_t at[3][2])
{
    plfx_roi_shake shake;
    int32_t k;

    image_cfg();
    cfg.regions = 3;
    memset(out, 0, sizeof out);
    for (k = 0; k < 3; k++) {
        double i = at[k][0];
        double j = at[k][1];
        cfg.region[k] = (plfx_roi_region){at[k][0], at[k][1], 1, 1, k < n};
        out[k].u_q24 = (int32_t)(16777216 * (0.1 - 0.001 * j + 0.0005 * i));
        out[k].v_q24 = (int32_t)(16777216 * (0.2 + 0.001 * i + 0.0005 * j));
        out[k].w_q24 = (int32_t)(16777216 * (0.01 + 0.0002 * i - 0.0001 * j));
    }
    roi.cfg = cfg;
    assert_int_equal(plfx_roi_shake_fit(&roi, out, &shake), PLFX_OK);
    assert_int_equal(shake.n, n);
    return shake;
}

static void motions_need_references_enough(void **s)
{
    static const int16_t near[3][2] = {{2, 3}, {30, 5}, {10, 38}};
    plfx_roi_shake one = shaken(1, near);
    plfx_roi_shake two = shaken(2, near);
    plfx_roi_shake three = shaken(3, near);

    (void)s;
    assert_true(fabs(lens(one.u_q24) - 0.098) < 1e-5);
    assert_true(one.turn_q24 == 0 && one.zoom_q24 == 0 && one.wi_q24 == 0);
    assert_true(fabs(lens(two.turn_q24) - 0.001) < 1e-5);
    assert_true(fabs(lens(two.zoom_q24) - 0.0005) < 1e-5);
    assert_true(two.wi_q24 == 0 && two.wj_q24 == 0);
    assert_true(fabs(lens(three.wi_q24) - 0.0002) < 2e-6);
    assert_true(fabs(lens(three.wj_q24) + 0.0001) < 2e-6);
}

/* Sums of squares over 2^12: along columns, along rows. */
static void references_may_be_far_apart(void **s)
{
    static const int16_t wide[3][2] = {{-100, 10}, {300, 40}, {100, 70}};
    static const int16_t high[3][2] = {{10, -100}, {40, 300}, {70, 100}};
    plfx_roi_shake w = shaken(3, wide);
    plfx_roi_shake h = shaken(3, high);

    (void)s;
    assert_true(fabs(lens(w.wi_q24) - 0.0002) < 2e-6);
    assert_true(fabs(lens(w.wj_q24) + 0.0001) < 2e-5);
    assert_true(fabs(lens(h.wi_q24) - 0.0002) < 2e-5);
    assert_true(fabs(lens(h.wj_q24) + 0.0001) < 2e-6);
    assert_true(fabs(lens(h.turn_q24) - 0.001) < 1e-5);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(black_and_oblique_stripes_are_no_texture),
    cmocka_unit_test(one_frame_at_rest_knows_no_noise),
    cmocka_unit_test(the_least_region_knows_its_light),
    cmocka_unit_test(light_over_four_times_is_flagged),
    cmocka_unit_test(clipped_samples_are_flagged),
    cmocka_unit_test(a_sample_clipped_in_one_view_at_rest),
    cmocka_unit_test(slopes_out_of_range_are_flagged),
    cmocka_unit_test(one_view_of_a_table_has_no_slope),
    cmocka_unit_test(white_of_a_table_without_gains_is_one),
    cmocka_unit_test(samples_under_black_are_black),
    cmocka_unit_test(views_off_the_sensor_take_its_last_column),
    cmocka_unit_test(views_off_the_sensor_take_its_last_row),
    cmocka_unit_test(regions_are_sought_inside_alone),
    cmocka_unit_test(motions_need_references_enough),
    cmocka_unit_test(references_may_be_far_apart),
};

SUITE(tests)
