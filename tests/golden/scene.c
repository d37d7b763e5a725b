/* SPDX-License-Identifier: MIT
 * Integers only: the scene itself must be the same everywhere. */
#include "scene.h"

#include <string.h>

#include "golden.h"

#define PITCH 10 /* pixels */

uint16_t scene_frame[SCENE_W * SCENE_H];
uint8_t scene_blob[16384];
uint16_t scene_samples[SCENE_NX * SCENE_NY * SCENE_VIEWS];
scene_map scene_out;
static uint64_t memory[(SCENE_WS + PLFX_ALIGN) / 8u];

/* The order of gradient.h: centre, -u, +u, -v, +v, 3 pixels. */
const plfx_offset scene_at[SCENE_VIEWS] = {
    {0, 0}, {-768, 0}, {768, 0}, {0, -768}, {0, 768}};

void *scene_ws(void)
{
    return memory + (PLFX_ALIGN - (uintptr_t)memory % PLFX_ALIGN) % PLFX_ALIGN / 8u;
}

static int32_t knot(int32_t i, int32_t j)
{
    uint32_t s = (uint32_t)i * 2654435761u ^ (uint32_t)j * 2246822519u;

    (void)golden_random(&s);
    return (int32_t)((golden_random(&s) >> 20) & 0xfffu);
}

/* Value noise, 0 .. 4095, a knot every lens and a half; x, y in lenses, q8, > 0. */
static int32_t world(int32_t x_q8, int32_t y_q8)
{
    int32_t x = x_q8 * 2 / 3;
    int32_t y = y_q8 * 2 / 3;
    int32_t i = x / 256;
    int32_t j = y / 256;
    int32_t fx = x % 256;
    int32_t fy = y % 256;
    int32_t top = knot(i, j) * (256 - fx) + knot(i + 1, j) * fx;
    int32_t low = knot(i, j + 1) * (256 - fx) + knot(i + 1, j + 1) * fx;

    return (top / 256 * (256 - fy) + low / 256 * fy) / 256;
}

/* One pixel: the lens it lies under, its offset from the centre, the world there. */
static uint16_t pixel(int32_t x, int32_t y, int32_t row_step, int32_t odd)
{
    int32_t j = y / row_step;
    int32_t shift = j % 2 != 0 ? odd : 0;
    int32_t i = (x + PITCH - shift) / PITCH;
    int32_t u = x + PITCH - shift - i * PITCH - PITCH / 2;
    int32_t v = y - j * row_step - row_step / 2;
    int32_t slope_q8 = x < SCENE_W / 2 ? 13 : -16;
    int32_t x_q8 = 1024 + i * 256 + shift * 256 / PITCH - slope_q8 * u;
    int32_t y_q8 = 1024 + j * 256 * row_step / PITCH - slope_q8 * v;

    return (uint16_t)world(x_q8, y_q8);
}

static void draw(int32_t row_step, int32_t odd)
{
    int32_t x;
    int32_t y;

    for (y = 0; y < SCENE_H; y++) {
        for (x = 0; x < SCENE_W; x++) {
            scene_frame[y * SCENE_W + x] = pixel(x, y, row_step, odd);
        }
    }
    for (x = 0; x < 300; x++) { /* a clipped patch */
        scene_frame[(150 + x / 20) * SCENE_W + 100 + x % 20] = 4095;
    }
}

static size_t describe(int32_t kind, int32_t row_step, int32_t odd)
{
    static int16_t residual[SCENE_NX * SCENE_NY * 2];
    static uint16_t gain[SCENE_NX * SCENE_NY];
    static uint16_t profile[4 * 11 * 11];
    static uint8_t flags[SCENE_NX * SCENE_NY];
    static const uint8_t meta[] = "made";
    uint32_t seed = 7;
    plfx_lut_desc d;
    int32_t k;

    for (k = 0; k < SCENE_NX * SCENE_NY; k++) {
        residual[2 * k] = (int16_t)((int32_t)(golden_random(&seed) >> 23) - 256);
        residual[2 * k + 1] = (int16_t)((int32_t)(golden_random(&seed) >> 23) - 256);
        gain[k] = (uint16_t)(8192u + (golden_random(&seed) >> 22));
        flags[k] = k % 97 == 5 ? PLFX_LENS_MISSING : k % 89 == 3 ? PLFX_LENS_DIM : 0u;
    }
    for (k = 0; k < 4 * 11 * 11; k++) {
        profile[k] = (uint16_t)(8192u + (golden_random(&seed) >> 21));
    }
    memset(&d, 0, sizeof d);
    d.camera_id = 0x1234u;
    d.sensor_w = SCENE_W;
    d.sensor_h = SCENE_H;
    d.sensor_bits = SCENE_BITS;
    d.lattice.kind = kind;
    d.lattice.nx = SCENE_NX;
    d.lattice.ny = SCENE_NY;
    d.lattice.origin.x_q16 = PITCH / 2 * 65536;
    d.lattice.origin.y_q16 = row_step / 2 * 65536;
    d.lattice.a.x_q22 = PITCH * 4194304;
    d.lattice.a.y_q22 = 1000;
    d.lattice.b.x_q22 = -1000;
    d.lattice.b.y_q22 = row_step * 4194304;
    d.lattice.odd.x_q22 = odd * 4194304;
    d.radius_q8 = 4 * 256;
    d.resid_q12 = residual;
    d.flags = flags;
    d.zones_x = 2;
    d.zones_y = 2;
    d.profile_r = 5;
    d.profile_u13 = profile;
    d.lens_gain_u13 = gain;
    d.dark_u16 = 500;
    d.has_dark = 1;
    d.meta = meta;
    d.meta_len = sizeof meta - 1u;
    if (plfx_lut_bytes(&d) > sizeof scene_blob) {
        return 0;
    }
    return plfx_lut_write(&d, scene_blob, sizeof scene_blob) == PLFX_OK
               ? plfx_lut_bytes(&d)
               : 0;
}

size_t scene_make(int32_t kind, plfx_lut *lut)
{
    int32_t hex = kind == PLFX_LATTICE_HEX;
    int32_t row_step = hex ? 9 : PITCH;
    int32_t odd = hex ? PITCH / 2 : 0;
    size_t n = describe(kind, row_step, odd);

    draw(row_step, odd);
    if (n == 0 || plfx_lut_open(lut, scene_blob, n) != PLFX_OK) {
        return 0;
    }
    return n;
}

plfx_raw scene_raw(void)
{
    plfx_raw raw = {(const uint8_t *)scene_frame,
                    sizeof scene_frame,
                    PLFX_RAW_U16,
                    SCENE_BITS,
                    SCENE_W,
                    SCENE_H};

    return raw;
}

plfx_tone scene_tone(void)
{
    plfx_tone tone = plfx_tone_unity(10);

    tone.black_u16 = 300;
    tone.sat_u16 = 65000;
    tone.gain_q12 = 4500;
    return tone;
}

plfx_status scene_views(const plfx_lut *lut, plfx_views *views)
{
    plfx_raw raw = scene_raw();
    plfx_tone tone = scene_tone();

    views->px = scene_samples;
    views->nx = SCENE_NX;
    views->ny = SCENE_NY;
    views->n = SCENE_VIEWS;
    return plfx_view_all(lut, &raw, &tone, scene_at, 1, views);
}

plfx_cfg scene_cfg(int32_t method, int32_t cost, int32_t fit)
{
    plfx_cfg cfg;

    memset(&cfg, 0, sizeof cfg);
    cfg.method = (uint8_t)method;
    cfg.cost = (uint8_t)cost;
    cfg.fit = (uint8_t)fit;
    cfg.window = 5;
    cfg.bits = 10;
    cfg.n = SCENE_VIEWS;
    cfg.labels = SCENE_LABEL;
    cfg.texture = 40;
    cfg.unique_u16 = 600;
    cfg.slope_min_q16 = -7864;
    cfg.slope_max_q16 = 7864;
    memcpy(cfg.at, scene_at, sizeof scene_at);
    return cfg;
}

plfx_status scene_stream(plfx_stream *s, int32_t profile)
{
    static plfx_plan plan;
    static plfx_lut lut;
    plfx_cfg cfg = scene_cfg(PLFX_METHOD_SWEEP, PLFX_COST_SAD, PLFX_FIT_VEE);
    plfx_stream_cfg sc;

    memset(&sc, 0, sizeof sc);
    if (scene_make(PLFX_LATTICE_SQUARE, &lut) == 0 ||
        plfx_plan_init(&plan, &cfg, &lut, SCENE_NX, SCENE_NY) != PLFX_OK) {
        return PLFX_E_ARG;
    }
    sc.plan = &plan;
    sc.lut = &lut;
    sc.tone = scene_tone();
    sc.profile = (uint8_t)profile;
    sc.white = 1;
    sc.format = PLFX_RAW_U16;
    sc.bits = SCENE_BITS;
    sc.open_rows = plfx_stream_open_rows(&lut, &plan, &sc.tone);
    sc.j1 = SCENE_NY;
    return plfx_stream_init(s, &sc, scene_ws(), SCENE_WS);
}

plfx_map scene_empty(void)
{
    plfx_map map = {scene_out.slope, scene_out.conf, scene_out.sigma, scene_out.flags,
                    SCENE_NX,        SCENE_NY,       SCENE_NX};

    memset(&scene_out, 0xa5, sizeof scene_out);
    return map;
}
