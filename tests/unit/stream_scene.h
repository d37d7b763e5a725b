/* SPDX-License-Identifier: MIT
 * Scenes of the tests of streams: random tables, frames, tones and plans, and a frame
 * pushed row by row or band by band. */
#ifndef PLENOFIX_TEST_STREAM_SCENE_H
#define PLENOFIX_TEST_STREAM_SCENE_H

#include "suite.h"
#include "plenofix/frame.h"
#include "plenofix/preset.h"
#include "plenofix/stream.h"
#include "ref.h"
#include "kernels.h"

#include <math.h>

#define MAX_NX       24
#define MAX_NY       20
#define MAX_N        9
#define MAX_W        460
#define MAX_H        380
#define CELLS        (MAX_NX * MAX_NY)
#define PLANES_CELLS CELLS
#define WS_BYTES     (1024 * 1024)

#include "planes.h"

static uint16_t frame[MAX_W * MAX_H];
static uint8_t packed[MAX_W * MAX_H * 2];
static unsigned char blob[16384];
static int16_t scene_resid[CELLS * 2]; /* what the table is written from */
static uint8_t scene_flags[CELLS];
static uint16_t scene_gain[CELLS];
static unsigned char memory[WS_BYTES + 64];

enum { SUMS, ARMS, NCC, GRADIENT };

typedef struct scene {
    plfx_lut lut;
    plfx_plan plan;
    plfx_tone tone;
    plfx_raw raw;  /* unpacked */
    plfx_raw sent; /* as pushed */
    int32_t white;
    int32_t kind; /* SUMS .. GRADIENT */
    plfx_frame_cfg frame;
} scene;

static inline unsigned char *workspace(void)
{
    return memory + (64 - (uintptr_t)memory % 64) % 64;
}

static inline int32_t q22(double px)
{
    return (int32_t)lround(px * 4194304);
}

/* A lattice of nx x ny lenses that fits MAX_W x MAX_H. */
static inline void describe(plfx_lut_desc *d, ref_rng *rng)
{
    double pitch = 9 + ref_range(rng, 0, 700) / 100.0;
    double turn = ref_range(rng, 0, 2) ? ref_range(rng, -300, 300) / 10000.0 : 0;
    double c = cos(turn);
    double s = sin(turn);
    double row = pitch;

    memset(d, 0, sizeof *d);
    d->lattice.nx = ref_range(rng, 5, MAX_NX);
    d->lattice.ny = ref_range(rng, 5, MAX_NY);
    d->lattice.kind = ref_range(rng, 0, 1);
    if (d->lattice.kind == PLFX_LATTICE_HEX) {
        row = pitch * 0.8660254;
        d->lattice.odd.x_q22 = q22(c * pitch / 2);
        d->lattice.odd.y_q22 = q22(s * pitch / 2);
    }
    d->lattice.a.x_q22 = q22(c * pitch);
    d->lattice.a.y_q22 = q22(s * pitch);
    d->lattice.b.x_q22 = q22(-s * row);
    d->lattice.b.y_q22 = q22(c * row);
    d->lattice.origin.x_q16 = ref_range(rng, 3 * 65536, 14 * 65536);
    d->lattice.origin.y_q16 = ref_range(rng, 3 * 65536, 14 * 65536);
    d->sensor_w = ref_range(rng, (int32_t)(pitch * (d->lattice.nx + 1)), MAX_W);
    d->sensor_h = ref_range(rng, (int32_t)(pitch * (d->lattice.ny + 1)), MAX_H);
    d->radius_q8 = 4 * 256;
}

static inline int open_table(scene *sc, ref_rng *rng, int32_t bits)
{
    static uint16_t profile[81];
    plfx_lut_desc d;

    describe(&d, rng);
    d.sensor_bits = bits;
    for (int i = 0; i < CELLS; i++) {
        scene_resid[2 * i] = (int16_t)ref_range(rng, -900, 900);
        scene_resid[2 * i + 1] = (int16_t)ref_range(rng, -900, 900);
        scene_flags[i] = ref_range(rng, 0, 15) ? 0 : PLFX_LENS_MISSING;
        scene_gain[i] = (uint16_t)ref_range(rng, 6000, 12000);
    }
    for (int i = 0; i < 81; i++) {
        profile[i] = (uint16_t)ref_range(rng, 7000, 12000);
    }
    d.resid_q12 = ref_range(rng, 0, 1) ? scene_resid : NULL;
    d.flags = ref_range(rng, 0, 1) ? scene_flags : NULL;
    sc->white = ref_range(rng, 0, 1);
    if (sc->white) {
        d.zones_x = 1;
        d.zones_y = 1;
        d.profile_r = 4;
        d.profile_u13 = profile;
        d.lens_gain_u13 = scene_gain;
    }
    assert_true(plfx_lut_bytes(&d) <= sizeof blob);
    return plfx_lut_write(&d, blob, sizeof blob) == PLFX_OK &&
           plfx_lut_open(&sc->lut, blob, plfx_lut_bytes(&d)) == PLFX_OK;
}

static inline plfx_cfg random_cfg(ref_rng *rng, int32_t bits)
{
    int32_t across = ref_range(rng, 0, 1);
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.method = (uint8_t)(ref_range(rng, 0, 2) == 0);
    c.fit = (uint8_t)ref_range(rng, 0, 1);
    c.window = (uint8_t)(2 * ref_range(rng, 1, 3) + 1);
    c.bits = (uint8_t)bits;
    c.n = (uint8_t)ref_range(rng, 2, 6);
    c.ref = (uint8_t)ref_range(rng, 0, c.n - 1);
    c.labels = (uint16_t)ref_range(rng, 3, 9);
    c.texture = (uint16_t)(ref_range(rng, 0, 1) ? ref_range(rng, 1, 3000) : 0);
    c.unique_u16 = (uint16_t)(ref_range(rng, 0, 1) ? ref_range(rng, 0, 9000) : 0);
    c.slope_min_q16 = ref_range(rng, -40000, 20000);
    c.slope_max_q16 = c.slope_min_q16 + ref_range(rng, 1, 50000);
    for (int32_t k = 0; k < c.n; k++) {
        c.at[k].u_q8 = (int16_t)ref_range(rng, -900, 900);
        c.at[k].v_q8 = (int16_t)(across ? ref_range(rng, -700, 700) : 0);
    }
    return c;
}

/* A frame in one bit stream, least significant bit first. */
static inline void pack(scene *sc, int32_t format)
{
    int32_t bpp = plfx_raw_bpp(format);
    size_t n = (size_t)sc->raw.w * (size_t)sc->raw.h;

    sc->sent = sc->raw;
    sc->sent.format = (uint8_t)format;
    if (format == PLFX_RAW_U16) {
        return;
    }
    memset(packed, 0, sizeof packed);
    for (size_t i = 0; i < n; i++) {
        for (int32_t b = 0; b < sc->raw.bits; b++) {
            size_t at = i * (size_t)bpp + (size_t)b;
            packed[at / 8] |= (uint8_t)((frame[i] >> b & 1) << at % 8);
        }
    }
    sc->sent.bytes = packed;
    sc->sent.size = sizeof packed;
}

static inline void expose(scene *sc, ref_rng *rng, int32_t bits)
{
    static const int32_t formats[5][2] = {{PLFX_RAW_U8, PLFX_RAW_U16},
                                          {PLFX_RAW_MONO10P, PLFX_RAW_U16},
                                          {PLFX_RAW_MONO12P, PLFX_RAW_U16LE},
                                          {PLFX_RAW_U16LE, PLFX_RAW_U16},
                                          {PLFX_RAW_U16LE, PLFX_RAW_U16}};
    size_t n = (size_t)sc->lut.sensor_w * (size_t)sc->lut.sensor_h;

    for (size_t i = 0; i < n; i++) {
        frame[i] = (uint16_t)ref_range(rng, 0, (1 << bits) - 1);
    }
    sc->raw.bytes = (const uint8_t *)frame;
    sc->raw.size = sizeof frame;
    sc->raw.format = PLFX_RAW_U16;
    sc->raw.bits = (uint8_t)bits;
    sc->raw.w = sc->lut.sensor_w;
    sc->raw.h = sc->lut.sensor_h;
    pack(sc, formats[(bits - 8) / 2][ref_range(rng, 0, 1)]);
}

/* Views in arms, all around, and how they are matched. */
static inline void spread(scene *sc, plfx_cfg *c, ref_rng *rng)
{
    static const uint8_t medians[4] = {0, 3, 5, 7};

    assert_int_equal(plfx_preset(PLFX_PRESET_STREAM, c, &sc->frame), PLFX_OK);
    c->window = (uint8_t)(2 * ref_range(rng, 1, 3) + 1);
    c->texture = (uint16_t)(ref_range(rng, 0, 1) ? ref_range(rng, 1, 3000) : 0);
    c->unique_u16 = (uint16_t)ref_range(rng, 0, 9000);
    c->n = (uint8_t)ref_range(rng, 2, MAX_N);
    c->ref = (uint8_t)ref_range(rng, 0, c->n - 1);
    for (int32_t k = 0; k < c->n; k++) {
        c->at[k].u_q8 = (int16_t)ref_range(rng, -900, 900);
        c->at[k].v_q8 = (int16_t)ref_range(rng, -700, 700);
    }
    sc->frame.arms = ref_range(rng, 0, 1) ? 8 : 4;
    sc->frame.keep = (uint8_t)ref_range(rng, 1, 4);
    sc->frame.shrink = (uint8_t)ref_range(rng, 0, 1);
    sc->frame.axes = (uint8_t)ref_range(rng, 0, 1);
    sc->frame.median1 = medians[ref_range(rng, 0, 3)];
    sc->frame.trunc_q4 = (uint16_t)ref_range(rng, 1, 1024);
    sc->frame.gweight_q4 = (uint16_t)(ref_range(rng, 0, 2) ? 0 : ref_range(rng, 1, 31));
    sc->frame.noise_q4 = (uint16_t)ref_range(rng, 0, 11);
}

/* A cross of five views. */
static inline void cross(plfx_cfg *c, ref_rng *rng)
{
    int16_t step = (int16_t)ref_range(rng, 50, 700);
    int16_t u = (int16_t)ref_range(rng, -200, 200);
    int16_t v = (int16_t)ref_range(rng, -200, 200);

    c->method = PLFX_METHOD_GRADIENT;
    c->n = 5;
    c->ref = 0;
    for (int32_t k = 0; k < 5; k++) {
        c->at[k].u_q8 = (int16_t)(u + (k == 2 ? step : k == 1 ? -step : 0));
        c->at[k].v_q8 = (int16_t)(v + (k == 4 ? step : k == 3 ? -step : 0));
    }
}

/* Views that move by whole lenses a label every other time. */
static inline void correlate(plfx_cfg *c, const plfx_lattice *l, ref_rng *rng)
{
    c->method = PLFX_METHOD_PAIRS;
    c->cost = PLFX_COST_ZNCC;
    c->fuse = (uint8_t)ref_range(rng, 0, 1);
    if (ref_range(rng, 0, 1) && l->kind == PLFX_LATTICE_SQUARE) {
        c->slope_min_q16 = -65536;
        c->slope_max_q16 = 65536;
        c->labels = 3;
        for (int32_t k = 0; k < c->n; k++) {
            c->at[k].u_q8 = (int16_t)(256 * (k - c->ref));
            c->at[k].v_q8 = 0;
        }
    }
}

/* A scene of a kind; 0: its plan or table does not fit. */
static inline int make(scene *sc, int32_t kind, ref_rng *rng)
{
    int32_t bits = 8 + 2 * ref_range(rng, 0, 4);
    plfx_cfg c = random_cfg(rng, ref_range(rng, 8, 12));

    sc->kind = kind;
    if (sc->kind == ARMS) {
        spread(sc, &c, rng);
    }
    if (!open_table(sc, rng, bits)) {
        return 0;
    }
    if (sc->kind == NCC) {
        correlate(&c, &sc->lut.lattice, rng);
    } else if (sc->kind == GRADIENT) {
        cross(&c, rng);
    }
    sc->tone = plfx_tone_unity(c.bits);
    sc->tone.black_u16 = (uint16_t)ref_range(rng, 0, 3000);
    sc->tone.gain_q12 = (uint16_t)ref_range(rng, 4096, 8191);
    sc->tone.shift = (int8_t)ref_range(rng, -1, 1);
    sc->tone.sat_u16 = (uint16_t)ref_range(rng, 50000, 65535);
    sc->tone.dx_q8 = (int16_t)ref_range(rng, -256, 256);
    sc->tone.dy_q8 = (int16_t)ref_range(rng, -256, 256);
    expose(sc, rng, bits);
    return plfx_plan_init(&sc->plan, &c, &sc->lut, sc->lut.lattice.nx,
                          sc->lut.lattice.ny) == PLFX_OK &&
           plfx_stream_open_rows(&sc->lut, &sc->plan, &sc->tone) > 0 &&
           (kind != ARMS || plfx_frame_ws(&sc->plan, &sc->frame) > 0);
}

/* The first seed whose scene fits and has some rows. */
static inline scene some_scene(int32_t kind)
{
    scene sc;

    for (uint32_t seed = 1; seed < 100; seed++) {
        ref_rng rng = {seed};
        if (make(&sc, kind, &rng) && sc.plan.ny > 8) {
            return sc;
        }
    }
    fail_msg("no scene");
    return sc;
}

static inline plfx_stream_cfg stream_cfg(const scene *sc, int32_t profile)
{
    plfx_stream_cfg c;

    memset(&c, 0, sizeof c);
    c.plan = &sc->plan;
    c.lut = &sc->lut;
    c.frame = sc->kind == ARMS ? &sc->frame : NULL;
    c.tone = sc->tone;
    c.profile = (uint8_t)profile;
    c.white = (uint8_t)sc->white;
    c.format = sc->sent.format;
    c.bits = sc->sent.bits;
    c.open_rows = plfx_stream_open_rows(&sc->lut, &sc->plan, &sc->tone);
    c.j0 = 0;
    c.j1 = sc->plan.ny;
    return c;
}

static inline plfx_map line_of(const plfx_plan *plan, int32_t j)
{
    size_t at = (size_t)j * (size_t)plan->nx;
    plfx_map m = {got.slope + at, got.conf + at, got.sigma + at,
                  got.flags + at, plan->nx,      1,
                  plan->nx};

    return m;
}

static inline void pop_all(plfx_stream *s, int32_t *next, int32_t ready)
{
    while (ready > 0) {
        int32_t j = -1;
        plfx_map line = line_of(s->cfg.plan, *next);
        assert_int_equal(plfx_stream_pop(s, &j, &line, &ready), PLFX_OK);
        assert_int_equal(j, *next);
        (*next)++;
    }
}

static inline void feed(plfx_stream *s, const scene *sc, int32_t from, int32_t end,
                        int32_t *next)
{
    for (int32_t y = from; y < end; y++) {
        plfx_raw_row row;
        int32_t ready = 0;
        assert_int_equal(plfx_raw_row_at(&sc->sent, y, &row), PLFX_OK);
        assert_int_equal(plfx_stream_push(s, y, &row, &ready), PLFX_OK);
        pop_all(s, next, ready);
    }
}

static inline void feed_bands(plfx_stream *s, const scene *sc, int32_t *next)
{
    int32_t y = 0;

    while (y < sc->raw.h) {
        plfx_raw band = sc->sent;
        int32_t used = 0;
        int32_t ready = 0;
        band.bytes += (size_t)y * (size_t)band.w * sizeof(uint16_t);
        band.size -= (size_t)y * (size_t)band.w * sizeof(uint16_t);
        band.h = sc->raw.h - y < 37 ? sc->raw.h - y : 37;
        assert_int_equal(plfx_stream_push_band(s, y, &band, &used, &ready), PLFX_OK);
        assert_true(used > 0);
        y += used;
        pop_all(s, next, ready);
    }
}

static inline void compare(const scene *sc, int32_t j0, int32_t j1, int32_t profile,
                           unsigned seed)
{
    int32_t nx = sc->plan.nx;

    for (int32_t i = j0 * nx; i < j1 * nx; i++) {
        if (got.slope[i] != want.slope[i] || got.conf[i] != want.conf[i] ||
            got.flags[i] != want.flags[i] || got.sigma[i] != want.sigma[i]) {
            fail_msg("seed %u profile %d (%d,%d) of %dx%d: slope %d/%d conf %u/%u "
                     "flags %u/%u",
                     seed, (int)profile, (int)(i % nx), (int)(i / nx), (int)nx,
                     (int)sc->plan.ny, (int)got.slope[i], (int)want.slope[i],
                     got.conf[i], want.conf[i], got.flags[i], want.flags[i]);
        }
    }
}

#endif
