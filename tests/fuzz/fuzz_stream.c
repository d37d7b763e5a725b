/* SPDX-License-Identifier: MIT
 * The streaming driver: random geometry, plan and profile, the arms of the stream
 * preset too, in a workspace of the very size it asks for, rows in bands of any height,
 * rows of the table in place or fed with anything in them, calls in any order.  What is
 * popped equals nothing here (test_stream does that); nothing may break, and a frame
 * that was fed in full ends. */
#define _POSIX_C_SOURCE 200809L
#include "fuzz.h"

#include "plenofix/preset.h"
#include "plenofix/stream.h"

#define SIDE   14 /* lenses, at most */
#define SENSOR 200

static uint8_t blob[4096], flags[SIDE * SIDE];
static plfx_lut lut;
static plfx_plan plan;
static plfx_frame_cfg frame;

static int make_table(fuzz_input *in)
{
    plfx_lut_desc d;
    int32_t i;

    memset(&d, 0, sizeof d);
    d.lattice.kind = fuzz_range(in, 0, 1);
    d.lattice.nx = fuzz_range(in, 3, SIDE);
    d.lattice.ny = fuzz_range(in, 3, SIDE);
    d.lattice.origin.x_q16 = fuzz_range(in, -8, 20) * 65536;
    d.lattice.origin.y_q16 = fuzz_range(in, -8, 20) * 65536;
    d.lattice.a.x_q22 = fuzz_range(in, 4 << 8, 14 << 8) * 16384;
    d.lattice.a.y_q22 = fuzz_range(in, -1000, 1000) * 4096;
    d.lattice.b.x_q22 = fuzz_range(in, -1000, 1000) * 4096;
    d.lattice.b.y_q22 = fuzz_range(in, 4 << 8, 14 << 8) * 16384;
    d.lattice.odd.x_q22 = d.lattice.kind ? d.lattice.a.x_q22 / 2 : 0;
    d.sensor_w = fuzz_range(in, 1, SENSOR);
    d.sensor_h = fuzz_range(in, 1, SENSOR);
    d.sensor_bits = 12;
    for (i = 0; i < SIDE * SIDE; i++) {
        flags[i] = i % 11 == 5 ? PLFX_LENS_MISSING : 0;
    }
    d.flags = fuzz_u8(in) & 1u ? flags : NULL;
    return plfx_lut_write(&d, blob, sizeof blob) == PLFX_OK &&
           plfx_lut_open(&lut, blob, sizeof blob) == PLFX_OK;
}

/* What a gradient takes: a cross of five views. */
static void make_cross(plfx_cfg *c)
{
    int16_t step = (int16_t)(c->at[0].u_q8 / 2);
    int32_t k;

    c->n = 5;
    c->ref = 0;
    for (k = 0; k < 5; k++) {
        c->at[k].u_q8 = (int16_t)(k == 2 ? step : k == 1 ? -step : 0);
        c->at[k].v_q8 = (int16_t)(k == 4 ? step : k == 3 ? -step : 0);
    }
}

static int make_plan(fuzz_input *in)
{
    plfx_cfg c;
    int32_t k;

    memset(&c, 0, sizeof c);
    c.method = (uint8_t)fuzz_range(in, 0, 4);
    if (c.method > PLFX_METHOD_ARMS) {
        c.method = PLFX_METHOD_PAIRS;
        c.cost = PLFX_COST_ZNCC;
    }
    c.fit = (uint8_t)fuzz_range(in, 0, 1);
    c.window = (uint8_t)(3 + 2 * fuzz_range(in, 0, 3));
    c.bits = (uint8_t)fuzz_range(in, 8, 12);
    c.n = (uint8_t)fuzz_range(in, 2, 6);
    c.ref = (uint8_t)fuzz_range(in, 0, 5);
    c.labels = (uint16_t)fuzz_range(in, 3, 12);
    c.texture = (uint16_t)fuzz_range(in, 0, 100);
    c.unique_u16 = (uint16_t)fuzz_range(in, 0, 20000);
    c.slope_min_q16 = fuzz_range(in, -30000, 30000);
    c.slope_max_q16 = c.slope_min_q16 + fuzz_range(in, 0, 60000);
    c.cost = (uint8_t)(c.method == PLFX_METHOD_PAIRS ? fuzz_range(in, 0, 1) : 0);
    if (c.method == PLFX_METHOD_ARMS) {
        fuzz_must(plfx_preset(PLFX_PRESET_STREAM, &c, &frame) == PLFX_OK);
    }
    for (k = 0; k < c.n; k++) {
        c.at[k].u_q8 = (int16_t)fuzz_range(in, -1200, 1200);
        c.at[k].v_q8 = (int16_t)fuzz_range(in, -1200, 1200);
    }
    if (c.method == PLFX_METHOD_GRADIENT) {
        make_cross(&c);
    }
    return plfx_plan_init(&plan, &c, &lut, lut.lattice.nx, lut.lattice.ny) == PLFX_OK;
}

static plfx_stream_cfg make_cfg(fuzz_input *in)
{
    plfx_stream_cfg c;

    memset(&c, 0, sizeof c);
    c.plan = &plan;
    c.lut = &lut;
    c.tone = plfx_tone_unity(plan.cfg.bits);
    c.tone.dx_q8 = (int16_t)fuzz_range(in, -256, 256);
    c.tone.dy_q8 = (int16_t)fuzz_range(in, -256, 256);
    c.tone.shift = (int8_t)fuzz_range(in, -8, 8);
    c.profile = (uint8_t)fuzz_range(in, 0, 1);
    c.white = (uint8_t)fuzz_range(in, 0, 1);
    c.format = (uint8_t)fuzz_range(in, 0, PLFX_RAW_FORMATS);
    c.bits = (uint8_t)fuzz_range(in, 8, 16);
    c.open_rows = fuzz_u8(in) & 1u ? plfx_stream_open_rows(&lut, &plan, &c.tone)
                                   : fuzz_range(in, 0, 9);
    c.j0 = fuzz_range(in, 0, 3);
    c.j1 = lut.lattice.ny - fuzz_range(in, 0, 3);
    c.fed = (uint8_t)fuzz_range(in, 0, 1);
    if (plan.cfg.method == PLFX_METHOD_ARMS) {
        frame.arms = (uint8_t)(4 * fuzz_range(in, 1, 2));
        frame.keep = (uint8_t)fuzz_range(in, 1, 4);
        frame.median1 = (uint8_t)(2 * fuzz_range(in, 0, 3) + 1);
        frame.median1 = frame.median1 == 1 ? 0 : frame.median1;
        frame.gweight_q4 = (uint16_t)fuzz_range(in, 0, 31);
        frame.shrink = (uint8_t)fuzz_range(in, 0, 1);
        frame.axes = (uint8_t)fuzz_range(in, 0, 1);
        c.frame = &frame;
    }
    return c;
}

typedef struct planes {
    int32_t slope[SIDE];
    uint16_t conf[SIDE];
    uint8_t flags[SIDE];
} planes;

static int32_t pop_all(plfx_stream *s, int32_t ready)
{
    planes p;
    plfx_map row = {p.slope, p.conf, NULL, p.flags, lut.lattice.nx, 1, SIDE};
    int32_t j = 0;
    int32_t n = 0;

    while (ready > 0) { /* at most a map's rows */
        fuzz_must(plfx_stream_pop(s, &j, &row, &ready) == PLFX_OK);
        fuzz_must(j >= s->cfg.j0 && j < s->cfg.j1);
        n++;
    }
    return n;
}

/* Row j of the table with anything in it; the status. */
static plfx_status feed_row(fuzz_input *in, plfx_stream *s, int32_t j, int32_t *ready)
{
    int16_t resid[2 * SIDE];
    uint16_t gain[SIDE];
    uint8_t some[SIDE];
    uint32_t with = fuzz_u8(in);
    plfx_lens_row row = {NULL, NULL, NULL};
    int32_t i;

    for (i = 0; i < SIDE; i++) {
        resid[2 * i] = (int16_t)(fuzz_u8(in) * 16u);
        resid[2 * i + 1] = (int16_t)(fuzz_u16(in));
        some[i] = (uint8_t)(fuzz_u8(in) >> 5);
        gain[i] = (uint16_t)(fuzz_u8(in) * 257u);
    }
    row.resid_q12 = with & 1u ? resid : NULL;
    row.flags = with & 2u ? some : NULL;
    row.lens_gain_u13 = with & 4u ? gain : NULL;
    return plfx_stream_feed(s, j, &row, ready);
}

/* What the stream wants of the table; rows popped, -1 when a row was refused. */
static int32_t feed_table(fuzz_input *in, plfx_stream *s)
{
    int32_t popped = 0;
    int32_t j;

    while ((j = plfx_stream_wants(s)) >= 0) { /* at most once a row of the table */
        int32_t ready = 0;
        plfx_status status = feed_row(in, s, j, &ready);
        fuzz_must(s->cfg.fed && (status == PLFX_OK || status == PLFX_E_RANGE));
        if (status != PLFX_OK) {
            return -1;
        }
        popped += pop_all(s, ready);
    }
    return popped;
}

/* The whole frame in bands, popping as rows come. */
static void feed(fuzz_input *in, plfx_stream *s, const plfx_raw *raw)
{
    size_t row_bits = (size_t)raw->w * (size_t)plfx_raw_bpp(raw->format);
    int32_t popped = 0;
    int32_t y = 0;

    while (y < raw->h) { /* at most 3 rounds a row: each takes, pops or feeds one */
        plfx_raw band = *raw;
        int32_t used = 0;
        int32_t ready = 0;
        int32_t fed = feed_table(in, s);
        plfx_status status;
        if (fed < 0) {
            return;
        }
        popped += fed;
        band.h = 1 + fuzz_range(in, 0, 16);
        band.h = band.h < raw->h - y ? band.h : raw->h - y;
        if (row_bits * (size_t)y % 8u != 0) {
            break; /* a band begins at a whole byte */
        }
        band.bytes = raw->bytes + row_bits * (size_t)y / 8u;
        band.size = raw->size - row_bits * (size_t)y / 8u;
        status = plfx_stream_push_band(s, y, &band, &used, &ready);
        fuzz_must(status != PLFX_OK || used >= 0);
        if (status != PLFX_OK) {
            return;
        }
        fuzz_must(used > 0 || ready > 0 || plfx_stream_wants(s) >= 0);
        y += used;
        popped += pop_all(s, ready);
    }
    if (y == raw->h) {
        int32_t fed = feed_table(in, s);
        if (fed < 0) {
            return;
        }
        popped += fed;
        fuzz_must(plfx_stream_finish(s) == PLFX_OK);
        fuzz_must(popped == s->cfg.j1 - s->cfg.j0);
    }
}

/* Calls out of order: refused or taken, never a break. */
static void stumble(fuzz_input *in, plfx_stream *s, const plfx_raw *raw)
{
    int32_t k;

    for (k = 0; k < 20 && in->left; k++) {
        int32_t y = fuzz_range(in, -1, raw->h);
        int32_t ready = 0;
        plfx_raw_row row;
        if (plfx_raw_row_at(raw, y, &row) == PLFX_OK) {
            fuzz_must(plfx_stream_push(s, y, &row, &ready) <= PLFX_OK);
        }
        if (fuzz_u8(in) & 1u) {
            fuzz_must(feed_row(in, s, fuzz_range(in, -1, SIDE), &ready) <= PLFX_OK);
        }
        if (fuzz_u8(in) & 1u) {
            (void)pop_all(s, ready);
        }
    }
    fuzz_must(plfx_stream_reset(s) == PLFX_OK);
}

static void run(fuzz_input *in, const plfx_stream_cfg *cfg)
{
    size_t size = plfx_stream_ws(cfg);
    void *ws = NULL;
    plfx_stream s;
    plfx_raw raw;
    uint8_t *px;
    size_t i;

    if (size == 0) {
        return;
    }
    fuzz_must(posix_memalign(&ws, PLFX_ALIGN, size) == 0);
    raw.format = cfg->format;
    raw.bits = cfg->bits;
    raw.w = lut.sensor_w;
    raw.h = lut.sensor_h;
    raw.size = plfx_raw_bytes(raw.format, raw.w, raw.h);
    px = fuzz_room(raw.size);
    for (i = 0; i < raw.size; i++) {
        px[i] = (uint8_t)(in->left ? in->at[i % in->left] + i * 7u / 5u : i * 31u >> 3);
    }
    raw.bytes = px;
    if (raw.size && plfx_stream_init(&s, cfg, ws, size) == PLFX_OK) {
        if (fuzz_u8(in) & 1u) {
            stumble(in, &s, &raw);
        }
        feed(in, &s, &raw);
    }
    free(px);
    free(ws);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    plfx_stream_cfg cfg;

    if (make_table(&in) && make_plan(&in)) {
        cfg = make_cfg(&in);
        run(&in, &cfg);
    }
    return 0;
}
