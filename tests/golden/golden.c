/* SPDX-License-Identifier: MIT
 * Every stage of the core on made input, small enough for a bare Cortex-M.  A stage
 * that returns an error gives CRC 0. */
#include "golden.h"

#include <string.h>

#include "fix.h"
#include "scene.h"

#define CELLS (SCENE_NX * SCENE_NY)

static int64_t random_i64(uint32_t *seed, int32_t bits)
{
    uint64_t high = golden_random(seed);
    uint64_t v = (high << 32) | golden_random(seed);
    int64_t magnitude = (int64_t)(v >> (64 - bits));

    return (golden_random(seed) & 0x80000000u) != 0u ? -magnitude : magnitude;
}

static void add_i64(golden_crc *c, int64_t v)
{
    golden_add(c, (uint32_t)((uint64_t)v & 0xffffffffu), 4);
    golden_add(c, (uint32_t)((uint64_t)v >> 32), 4);
}

static void add_bytes(golden_crc *c, const uint8_t *p, size_t n)
{
    size_t i;

    for (i = 0; i < n; i++) {
        golden_add(c, p[i], 1);
    }
}

static void add_u16(golden_crc *c, const uint16_t *p, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        golden_add(c, p[i], 2);
    }
}

static uint32_t crc_map(void)
{
    golden_crc c;
    int32_t i;

    golden_begin(&c);
    for (i = 0; i < CELLS; i++) {
        golden_add(&c, (uint32_t)scene_out.slope[i], 4);
        golden_add(&c, scene_out.conf[i], 2);
        golden_add(&c, scene_out.sigma[i], 2);
        golden_add(&c, scene_out.flags[i], 1);
    }
    return golden_end(&c);
}

/* Rounding, saturation, root. */
static uint32_t run_fix(void)
{
    uint32_t seed = 1;
    golden_crc c;
    int32_t i;

    golden_begin(&c);
    for (i = 0; i < 500; i++) {
        int64_t n = random_i64(&seed, 1 + i % 60);
        int64_t d = random_i64(&seed, 1 + i % 31);
        add_i64(&c, plfx_round_shift_i64(n, 1 + i % 40));
        add_i64(&c, plfx_div_round_i64(n, d < 0 ? 1 - d : 1 + d));
        golden_add(&c, (uint32_t)plfx_sat_i32(n), 4);
        golden_add(&c, plfx_isqrt_u64((uint64_t)n), 4);
    }
    return golden_end(&c);
}

static const uint8_t format_bits[PLFX_RAW_FORMATS] = {8,  14, 12, 10, 12,
                                                      10, 12, 10, 12};

/* Every layout, rows of odd width, from the middle of a row too. */
static uint32_t run_raw(void)
{
    static uint8_t bytes[2048];
    uint16_t row[64];
    uint32_t seed = 2;
    golden_crc c;
    int32_t f;
    int32_t y;

    golden_begin(&c);
    for (y = 0; y < 2048; y++) {
        bytes[y] = (uint8_t)(golden_random(&seed) >> 24);
    }
    for (f = 0; f < PLFX_RAW_FORMATS; f++) {
        plfx_raw raw = {bytes, sizeof bytes, (uint8_t)f, format_bits[f], 53, 11};
        if (f == PLFX_RAW_U16) {
            continue; /* the machine's own order: not the same bytes everywhere */
        }
        for (y = 0; y < raw.h; y++) {
            plfx_raw_row at;
            if (plfx_raw_row_at(&raw, y, &at) != PLFX_OK ||
                plfx_raw_unpack(&at, y % 7, 40, row) != PLFX_OK) {
                return 0;
            }
            add_u16(&c, row, 40);
        }
    }
    return golden_end(&c);
}

static uint32_t run_bayer(void)
{
    uint16_t rows[3][60];
    uint16_t out[60];
    uint32_t seed = 3;
    golden_crc c;
    int32_t k;

    golden_begin(&c);
    for (k = 0; k < 180; k++) {
        rows[k / 60][k % 60] = (uint16_t)(golden_random(&seed) >> 16);
    }
    for (k = 0; k < 24; k++) {
        if (plfx_raw_bayer_channel(1 + k % 4, k % 3, k / 4, rows[0], rows[1], rows[2],
                                   59, out) != PLFX_OK) {
            return 0;
        }
        add_u16(&c, out, 59);
    }
    if (plfx_raw_bayer_grey(rows[0], rows[1], 60, out) != PLFX_OK) {
        return 0;
    }
    add_u16(&c, out, 60);
    return golden_end(&c);
}

static uint32_t run_lut(void)
{
    plfx_lut lut;
    size_t n = scene_make(PLFX_LATTICE_HEX, &lut);
    uint16_t gain[SCENE_NX];
    golden_crc c;
    int32_t k;

    if (n == 0) {
        return 0;
    }
    golden_begin(&c);
    add_bytes(&c, scene_blob, n);
    for (k = 0; k < CELLS; k++) {
        plfx_point p = plfx_lut_centre(&lut, k % SCENE_NX, k / SCENE_NX);
        golden_add(&c, (uint32_t)p.x_q16, 4);
        golden_add(&c, (uint32_t)p.y_q16, 4);
        golden_add(&c, plfx_lut_flags(&lut, k % SCENE_NX, k / SCENE_NX), 1);
    }
    golden_add(&c, (uint32_t)plfx_lut_pitch_q16(&lut), 4);
    for (k = 0; k < SCENE_NY; k++) {
        if (plfx_lut_gain_row(&lut, k, (int16_t)(64 * k - 900), (int16_t)(700 - 50 * k),
                              gain) != PLFX_OK) {
            return 0;
        }
        add_u16(&c, gain, SCENE_NX);
    }
    return golden_end(&c);
}

/* Round lenses a fifth of a pixel off the table of the scene. */
static uint32_t run_drift(void)
{
    plfx_raw raw = scene_raw();
    golden_crc c;
    plfx_drift d;
    plfx_lut lut;
    int32_t k;
    int32_t x;
    int32_t y;

    if (scene_make(PLFX_LATTICE_HEX, &lut) == 0) {
        return 0;
    }
    memset(scene_frame, 0, sizeof scene_frame);
    for (k = 0; k < CELLS; k++) {
        plfx_point p = plfx_lut_centre(&lut, k % SCENE_NX, k / SCENE_NX);
        int32_t x_q4 = plfx_asr_i32(p.x_q16, 12) + 3;
        int32_t y_q4 = plfx_asr_i32(p.y_q16, 12) - 2;
        for (y = y_q4 / 16 - 4; y <= y_q4 / 16 + 5; y++) {
            for (x = x_q4 / 16 - 4; x <= x_q4 / 16 + 5; x++) {
                int32_t dx = 16 * x - x_q4;
                int32_t dy = 16 * y - y_q4;
                int32_t v = 3600 - (dx * dx + dy * dy) / 2;
                if (v > 0 && x >= 0 && y >= 0 && x < SCENE_W && y < SCENE_H) {
                    scene_frame[y * SCENE_W + x] = (uint16_t)v;
                }
            }
        }
    }
    if (plfx_drift_find(&lut, &raw, 300, scene_ws(), SCENE_WS, &d) != PLFX_OK ||
        d.state != PLFX_DRIFT_MEASURED) {
        return 0;
    }
    golden_begin(&c);
    golden_add(&c, (uint32_t)d.shift_x_q20, 4);
    golden_add(&c, (uint32_t)d.shift_y_q20, 4);
    golden_add(&c, (uint32_t)d.rotation_q30, 4);
    golden_add(&c, (uint32_t)d.scale_q30, 4);
    golden_add(&c, (uint32_t)d.shift_sigma_q20, 4);
    golden_add(&c, (uint32_t)d.rotation_sigma_q30, 4);
    golden_add(&c, (uint32_t)d.scale_sigma_q30, 4);
    golden_add(&c, (uint32_t)d.rms_q20, 4);
    golden_add(&c, (uint32_t)d.lenses, 4);
    return golden_end(&c);
}

static uint32_t run_view(void)
{
    plfx_lut lut;
    plfx_views views;
    golden_crc c;

    if (scene_make(PLFX_LATTICE_SQUARE, &lut) == 0 ||
        scene_views(&lut, &views) != PLFX_OK) {
        return 0;
    }
    golden_begin(&c);
    add_u16(&c, scene_samples, CELLS * SCENE_VIEWS);
    return golden_end(&c);
}

static uint32_t run_plan(void)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_PAIRS, PLFX_COST_ZNCC, PLFX_FIT_PARABOLA);
    plfx_plan plan;
    plfx_lut lut;
    golden_crc c;
    int32_t k;

    if (scene_make(PLFX_LATTICE_HEX, &lut) == 0 ||
        plfx_plan_init(&plan, &cfg, &lut, SCENE_NX, SCENE_NY) != PLFX_OK) {
        return 0;
    }
    golden_begin(&c);
    for (k = 0; k < SCENE_LABEL * SCENE_VIEWS; k++) {
        plfx_shift s = plfx_plan_shift(&plan, k % SCENE_VIEWS, k / SCENE_VIEWS);
        golden_add(&c, (uint32_t)s.kx, 4);
        golden_add(&c, (uint32_t)s.fx_q4, 1);
        golden_add(&c, (uint32_t)s.ky, 4);
        golden_add(&c, (uint32_t)s.fy_q4, 1);
        golden_add(&c, (uint32_t)plfx_plan_slope_q16(&plan, k), 4);
    }
    return golden_end(&c);
}

static uint32_t match(int32_t kind, const plfx_cfg *cfg)
{
    plfx_plan plan;
    plfx_lut lut;
    plfx_views views;
    plfx_map map = scene_empty();
    plfx_status status;

    if (scene_make(kind, &lut) == 0 || scene_views(&lut, &views) != PLFX_OK ||
        plfx_plan_init(&plan, cfg, &lut, SCENE_NX, SCENE_NY) != PLFX_OK) {
        return 0;
    }
    if (cfg->method == PLFX_METHOD_GRADIENT) {
        status = plfx_gradient(&plan, &views, &map, scene_ws(), SCENE_WS);
    } else {
        status = plfx_sweep(&plan, &views, &map, scene_ws(), SCENE_WS);
    }
    return status == PLFX_OK ? crc_map() : 0;
}

static uint32_t run_sweep(void)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_SWEEP, PLFX_COST_SAD, PLFX_FIT_VEE);

    return match(PLFX_LATTICE_SQUARE, &cfg);
}

static uint32_t run_sweep_hex(void)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_SWEEP, PLFX_COST_SAD, PLFX_FIT_VEE);

    return match(PLFX_LATTICE_HEX, &cfg);
}

static uint32_t run_pairs_sad(void)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_PAIRS, PLFX_COST_SAD, PLFX_FIT_VEE);

    cfg.fuse = PLFX_FUSE_MEDIAN;
    return match(PLFX_LATTICE_SQUARE, &cfg);
}

static uint32_t run_pairs_zncc(void)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_PAIRS, PLFX_COST_ZNCC, PLFX_FIT_PARABOLA);

    cfg.fuse = PLFX_FUSE_CORRELATION;
    return match(PLFX_LATTICE_SQUARE, &cfg);
}

static uint32_t run_gradient(void)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_GRADIENT, PLFX_COST_SAD, PLFX_FIT_PARABOLA);

    return match(PLFX_LATTICE_SQUARE, &cfg);
}

static uint32_t run_gradient_hex(void)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_GRADIENT, PLFX_COST_SAD, PLFX_FIT_PARABOLA);

    return match(PLFX_LATTICE_HEX, &cfg);
}

static uint32_t run_refocus(void)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_SWEEP, PLFX_COST_SAD, PLFX_FIT_VEE);
    static uint16_t picture[CELLS];
    plfx_image out = {picture, SCENE_NX, SCENE_NY, SCENE_NX};
    plfx_plan plan;
    plfx_lut lut;
    plfx_views views;
    golden_crc c;

    if (scene_make(PLFX_LATTICE_HEX, &lut) == 0 ||
        scene_views(&lut, &views) != PLFX_OK ||
        plfx_plan_init(&plan, &cfg, &lut, SCENE_NX, SCENE_NY) != PLFX_OK ||
        plfx_refocus(&plan, &views, -3000, &out) != PLFX_OK) {
        return 0;
    }
    golden_begin(&c);
    add_u16(&c, picture, CELLS);
    return golden_end(&c);
}

static uint32_t run_fuse(void)
{
    int32_t slope[9];
    uint16_t weight[9];
    uint32_t seed = 4;
    golden_crc c;
    int32_t k;
    int32_t n;

    golden_begin(&c);
    for (n = 1; n <= 9; n++) {
        for (k = 0; k < n; k++) {
            slope[k] = (int32_t)random_i64(&seed, 19);
            weight[k] = (uint16_t)(golden_random(&seed) >> 16);
        }
        slope[n / 2] = n % 4 == 0 ? PLFX_SLOPE_NONE : slope[n / 2];
        golden_add(&c, (uint32_t)plfx_fuse_mean(slope, weight, n), 4);
        golden_add(&c, (uint32_t)plfx_fuse_median(slope, weight, n), 4);
    }
    return golden_end(&c);
}

static uint32_t run_depth(void)
{
    plfx_optics optics = {16777216, -123456789};
    int32_t slope[64];
    uint32_t um[64];
    uint32_t seed = 5;
    golden_crc c;
    int32_t k;

    golden_begin(&c);
    for (k = 0; k < 64; k++) {
        slope[k] =
            k % 11 == 0 ? PLFX_SLOPE_NONE : (int32_t)random_i64(&seed, 8 + k % 12);
    }
    plfx_depth_row(&optics, slope, 64, um);
    for (k = 0; k < 64; k++) {
        golden_add(&c, um[k], 4);
    }
    return golden_end(&c);
}

/* A whole frame by a preset; from a noise of 12 on views are smoothed first. */
static uint32_t frame(int32_t preset, int32_t noise_q4)
{
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_ARMS, PLFX_COST_SAD, PLFX_FIT_VEE);
    plfx_map map = scene_empty();
    plfx_frame_cfg how;
    plfx_views views;
    plfx_plan plan;
    plfx_lut lut;

    if (plfx_preset(preset, &cfg, &how) != PLFX_OK ||
        scene_make(PLFX_LATTICE_SQUARE, &lut) == 0 ||
        plfx_plan_init(&plan, &cfg, &lut, SCENE_NX, SCENE_NY) != PLFX_OK ||
        scene_views(&lut, &views) != PLFX_OK) {
        return 0;
    }
    how.noise_q4 = (uint16_t)noise_q4;
    return plfx_frame(&plan, &how, &views, NULL, &map, scene_ws(), SCENE_WS) == PLFX_OK
               ? crc_map()
               : 0;
}

static uint32_t run_frame_stream(void)
{
    return frame(PLFX_PRESET_STREAM, 0);
}

static uint32_t run_frame_onboard(void)
{
    return frame(PLFX_PRESET_ONBOARD, 0);
}

static uint32_t run_frame_precise(void)
{
    return frame(PLFX_PRESET_PRECISE, 16);
}

/* Map rows of the stream, put where the frame driver would put them. */
static plfx_status pop_all(plfx_stream *s, const plfx_map *map, int32_t ready)
{
    while (ready > 0) {
        plfx_map line = *map;
        int32_t j = s->j;
        plfx_status status;
        line.slope_q16 = map->slope_q16 + j * SCENE_NX;
        line.conf_u16 = map->conf_u16 + j * SCENE_NX;
        line.sigma_u20 = map->sigma_u20 + j * SCENE_NX;
        line.flags = map->flags + j * SCENE_NX;
        line.h = 1;
        status = plfx_stream_pop(s, &j, &line, &ready);
        if (status != PLFX_OK) {
            return status;
        }
    }
    return PLFX_OK;
}

static uint32_t stream(int32_t profile)
{
    plfx_map map = scene_empty();
    plfx_raw raw = scene_raw();
    plfx_stream s;
    int32_t y;

    if (scene_stream(&s, profile) != PLFX_OK) {
        return 0;
    }
    for (y = 0; y < SCENE_H; y++) {
        plfx_raw_row row;
        int32_t ready = 0;
        if (plfx_raw_row_at(&raw, y, &row) != PLFX_OK ||
            plfx_stream_push(&s, y, &row, &ready) != PLFX_OK ||
            pop_all(&s, &map, ready) != PLFX_OK) {
            return 0;
        }
    }
    return plfx_stream_finish(&s) == PLFX_OK ? crc_map() : 0;
}

static uint32_t run_stream_small(void)
{
    return stream(PLFX_PROFILE_SMALL);
}

static uint32_t run_stream_fast(void)
{
    return stream(PLFX_PROFILE_FAST);
}

static uint32_t run_packet(void)
{
    plfx_packet_head head = {0x0123456789abcdefu, 0xcafef00du, 77, 16383, 0};
    plfx_packet_health health = {1, 2, 3, 4, 5, {-6, 7, -8}, 9, 10, 11, 12};
    uint8_t bytes[128];
    size_t n = 0;
    golden_crc c;

    if (plfx_packet_put_health(&head, &health, bytes, sizeof bytes, &n) != PLFX_OK) {
        return 0;
    }
    golden_begin(&c);
    add_bytes(&c, bytes, n);
    return golden_end(&c);
}

/* stream = sweep: the two drivers give the same map. */
const golden_stage golden_stages[] = {
    {"fix", run_fix, 0x29ac5e74u},
    {"raw", run_raw, 0xb2c127cfu},
    {"bayer", run_bayer, 0xc60d1d16u},
    {"lut", run_lut, 0x2e31bdfdu},
    {"view", run_view, 0xb7dfbba0u},
    {"plan", run_plan, 0xbe726facu},
    {"sweep", run_sweep, 0xab2cfd99u},
    {"sweep hexagonal", run_sweep_hex, 0x95b8b8bbu},
    {"pairs sad", run_pairs_sad, 0x9aa19e48u},
    {"pairs zncc", run_pairs_zncc, 0x7dbfe297u},
    {"gradient", run_gradient, 0xd5c3ca48u},
    {"gradient hexagonal", run_gradient_hex, 0x0beb6c79u},
    {"refocus", run_refocus, 0x3016472eu},
    {"fuse", run_fuse, 0xbb6ec12du},
    {"depth", run_depth, 0x1a0032e8u},
    {"stream small", run_stream_small, 0xab2cfd99u},
    {"stream fast", run_stream_fast, 0xab2cfd99u},
    {"frame stream", run_frame_stream, 0x4f36685bu},
    {"frame onboard", run_frame_onboard, 0xb3224c16u},
    {"frame precise", run_frame_precise, 0x9682d770u},
    {"drift", run_drift, 0x9f757a7cu},
    {"packet", run_packet, 0xc2bb28a9u},
    {"regions", golden_regions, 0xc7d59feau},
    {"modes", golden_modes, 0xf5ba4dcfu},
    {"packets", golden_packets, 0xc9e4e0dfu},
};

const size_t golden_count = sizeof golden_stages / sizeof golden_stages[0];
