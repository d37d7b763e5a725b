/* SPDX-License-Identifier: MIT
 * Limits of the arguments of tables, raw rows, views and plans. */
#include "limits.h"
#include "ref.h"
#include "bytes.h"
#include "crc32.h"
#include "lut_format.h"

#include "plenofix/gradient.h"
#include "plenofix/plan.h"
#include "plenofix/view.h"

#define NX  9
#define NY  8
#define PX  (1 << 22) /* a pixel, q22 */
#define OK  PLFX_OK
#define ARG PLFX_E_ARG

static uint16_t profile[2 * 2 * 3 * 3], lens_gain[NX * NY];
static uint8_t flags[NX * NY], text[8];
static int16_t resid[2 * NX * NY];
static uint8_t blob[4096];
static size_t blob_size;

static plfx_lut_desc describe(void)
{
    plfx_lut_desc d;

    memset(&d, 0, sizeof d);
    d.sensor_w = 100;
    d.sensor_h = 90;
    d.sensor_bits = 12;
    d.lattice.nx = NX;
    d.lattice.ny = NY;
    d.lattice.origin.x_q16 = 6 << 16;
    d.lattice.origin.y_q16 = 6 << 16;
    d.lattice.a.x_q22 = 10 * PX;
    d.lattice.b.y_q22 = 10 * PX;
    d.radius_q8 = 1024;
    d.resid_q12 = resid;
    d.flags = flags;
    d.zones_x = d.zones_y = 2;
    d.profile_r = 1;
    d.profile_u13 = profile;
    d.lens_gain_u13 = lens_gain;
    d.has_dark = 1;
    d.opti = text;
    d.opti_len = sizeof text;
    d.meta = text;
    d.meta_len = sizeof text;
    return d;
}

static plfx_lut open_table(void)
{
    plfx_lut_desc d = describe();
    plfx_lut t;

    blob_size = plfx_lut_bytes(&d);
    assert_in_range(blob_size, 1, sizeof blob);
    assert_int_equal(plfx_lut_write(&d, blob, blob_size), OK);
    assert_int_equal(plfx_lut_open(&t, blob, blob_size), OK);
    return t;
}

static int32_t call_bytes(void *args)
{
    return plfx_lut_bytes(args) != 0 ? OK : ARG;
}

static void table_to_write(void **state)
{
#define D(field, value, status) LIMIT(plfx_lut_desc, field, value, status)
    static const limit table[] = {
        D(lattice.kind, 2, ARG),
        D(lattice.kind, -1, ARG),
        D(lattice.kind, 1, OK),
        D(lattice.nx, 0, ARG),
        D(lattice.nx, PLFX_LENSES_MAX, OK),
        D(lattice.nx, PLFX_LENSES_MAX + 1, ARG),
        D(lattice.ny, 0, ARG),
        D(lattice.ny, 1, OK),
        D(lattice.ny, PLFX_LENSES_MAX, OK),
        D(lattice.ny, PLFX_LENSES_MAX + 1, ARG),
        D(lattice.a.x_q22, PX - 64, ARG),
        D(lattice.a.x_q22, PX, OK),
        D(lattice.a.x_q22, -PX, OK),
        D(lattice.b.y_q22, PX - 64, ARG),
        D(lattice.b.y_q22, PX, OK),
        D(lattice.a.y_q22, 30 * PX, OK),
        D(lattice.a.y_q22, 50 * PX, ARG), /* sine under 1/4 */
        D(sensor_w, 0, ARG),
        D(sensor_w, 1, OK),
        D(sensor_w, 32767, OK),
        D(sensor_w, 32768, ARG),
        D(sensor_h, 0, ARG),
        D(sensor_h, 1, OK),
        D(sensor_h, 32767, OK),
        D(sensor_h, 32768, ARG),
        D(sensor_bits, 7, ARG),
        D(sensor_bits, 8, OK),
        D(sensor_bits, 16, OK),
        D(sensor_bits, 17, ARG),
        D(radius_q8, -1, ARG),
        D(radius_q8, 0, OK),
        D(radius_q8, 32768, OK),
        D(radius_q8, 32769, ARG),
        D(zones_x, 0, ARG),
        D(zones_x, 1, OK),
        D(zones_x, 16, OK),
        D(zones_x, 17, ARG),
        D(zones_y, 0, ARG),
        D(zones_y, 1, OK),
        D(zones_y, 16, OK),
        D(zones_y, 17, ARG),
        D(profile_r, 0, ARG),
        D(profile_r, 127, OK),
        D(profile_r, 128, ARG),
        D(opti_len, 1 << 20, OK),
        D(opti_len, (1 << 20) + 1, ARG),
        D(meta_len, 1 << 20, OK),
        D(meta_len, (1 << 20) + 1, ARG),
        D(resid_q12, 0, OK),
        D(profile_u13, 0, OK),
        D(lens_gain_u13, 0, OK),
        D(flags, 0, OK),
        D(opti, 0, OK),
        D(meta, 0, OK),
    };
#undef D
    plfx_lut_desc d = describe();

    (void)state;
    limits(&d, sizeof d, table, COUNT(table), call_bytes);
}

/* One gain pointer without the other is no gain, whatever the zones say. */
static void half_a_gain_is_none(void **state)
{
    plfx_lut_desc d = describe();
    plfx_lut t;

    (void)state;
    d.lens_gain_u13 = NULL;
    d.zones_x = 99;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), OK);
    assert_int_equal(plfx_lut_open(&t, blob, sizeof blob), OK);
    assert_int_equal(t.gain.length, 0);
}

/* Entry of a section; its payload and the header are made to hold again. */
static void mend(void)
{
    uint32_t header = plfx_get_u32(blob + LUT_AT_HEADER);
    uint32_t at;

    for (at = LUT_HEADER; at < header; at += LUT_ENTRY) {
        uint32_t from = plfx_get_u32(blob + at + 4);
        uint32_t length = plfx_get_u32(blob + at + 8);
        plfx_put_u32(blob + at + 12, plfx_crc32(0, blob + from, length));
    }
    plfx_put_u32(blob + LUT_AT_CRC, 0);
    plfx_put_u32(blob + LUT_AT_CRC, plfx_crc32(0, blob, header));
}

typedef struct patch { /* of 16 bits at a place of the blob */
    uint32_t at, value;
    int32_t status;
} patch;

static void try_patches(const patch *p, size_t n)
{
    size_t k;

    for (k = 0; k < n; k++) {
        uint32_t was = plfx_get_u16(blob + p[k].at);
        plfx_lut t;
        plfx_status status;
        mark(&t, sizeof t);
        plfx_put_u16(blob + p[k].at, p[k].value);
        mend();
        status = plfx_lut_open(&t, blob, blob_size);
        if (status != p[k].status) {
            fail_msg("%u at %u: status %d, not %d", (unsigned)p[k].value,
                     (unsigned)p[k].at, (int)status, (int)p[k].status);
        }
        assert_true(status == OK || marked(&t, sizeof t));
        plfx_put_u16(blob + p[k].at, was);
        mend();
        assert_int_equal(plfx_lut_open(&t, blob, blob_size), OK);
    }
}

static void fields_of_a_stored_table(void **state)
{
    const int32_t bad = PLFX_E_FORMAT;
    const patch table[] = {
        {LUT_AT_SENSOR, 0, bad},
        {LUT_AT_SENSOR, 32768, bad},
        {LUT_AT_SENSOR, 32767, OK},
        {LUT_AT_SENSOR + 2, 0, bad},
        {LUT_AT_SENSOR + 2, 32768, bad},
        {LUT_AT_SENSOR + 2, 32767, OK},
        {LUT_AT_BITS, 7, bad},
        {LUT_AT_BITS, 8, OK},
        {LUT_AT_BITS, 16, OK},
        {LUT_AT_BITS, 17, bad},
        {LUT_AT_RADIUS + 2, 0x8000, bad}, /* negative */
        {LUT_AT_RADIUS + 2, 1, bad},
        {LUT_AT_LENSES, 0, bad},
        {LUT_AT_STEPS, 1, OK},
        {LUT_AT_SECTIONS, 65, bad},
        {LUT_AT_HEADER, 0, bad},
    };

    (void)state;
    (void)open_table();
    try_patches(table, COUNT(table));
}

static void fields_of_a_stored_gain(void **state)
{
    const int32_t bad = PLFX_E_FORMAT;
    const plfx_lut t = open_table();
    const uint32_t g = t.gain.offset;
    const patch table[] = {
        {g, 0, bad},       {g, 17, bad},      {g, 1, bad},       {g, 4, bad},
        {g + 2, 0, bad},   {g + 2, 17, bad},  {g + 2, 1, bad},   {g + 4, 0, bad},
        {g + 4, 128, bad}, {g + 4, 127, bad}, {g + 4, 2, bad},   {g + 6, 1, bad},
        {g + 8, 1, OK},    {g + 8, 0, OK},    {g + 8, 9999, OK},
    };

    (void)state;
    try_patches(table, COUNT(table));
}

/* A directory entry of another length: the next section is moved along. */
static void lengths_of_stored_sections(void **state)
{
    static const char *const tags[] = {"RESI", "FLAG", "GAIN", "DARK"};
    plfx_lut t = open_table();
    uint32_t header = plfx_get_u32(blob + LUT_AT_HEADER);
    size_t k;

    (void)state;
    for (k = 0; k < COUNT(tags); k++) {
        uint32_t at = LUT_HEADER;
        uint32_t length;
        (void)open_table();
        while (memcmp(blob + at, tags[k], 4) != 0) {
            at += LUT_ENTRY;
            assert_in_range(at, 0, header - LUT_ENTRY);
        }
        /* the section gives its last byte to one with a tag that nobody knows */
        length = plfx_get_u32(blob + at + 8);
        plfx_put_u32(blob + at + 8, length - 1);
        memcpy(blob + at + LUT_ENTRY, "ABCD", 4);
        plfx_put_u32(blob + at + LUT_ENTRY + 4,
                     plfx_get_u32(blob + at + LUT_ENTRY + 4) - 1);
        plfx_put_u32(blob + at + LUT_ENTRY + 8,
                     plfx_get_u32(blob + at + LUT_ENTRY + 8) + 1);
        mend();
        assert_int_equal(plfx_lut_open(&t, blob, blob_size), PLFX_E_FORMAT);
    }
}

/* A gain section too short for its own head. */
static void gain_without_head(void **state)
{
    plfx_lut_desc d = describe();
    plfx_lut t;

    (void)state;
    d.profile_u13 = NULL;
    blob_size = plfx_lut_bytes(&d);
    assert_int_equal(plfx_lut_write(&d, blob, blob_size), OK);
    assert_int_equal(plfx_lut_open(&t, blob, blob_size), OK);
    memcpy(blob + LUT_HEADER + 2 * LUT_ENTRY, "GAIN", 4); /* was DARK: 2 bytes */
    mend();
    assert_int_equal(plfx_lut_open(&t, blob, blob_size), PLFX_E_FORMAT);
}

/* Lenses more than a pitch beyond each side of the sensor. */
static void lenses_beyond_each_side(void **state)
{
    static const int32_t shift[5][3] = {
        {0, 0, OK}, {-17, 0, 1}, {0, -17, 1}, {24, 0, 1}, {0, 25, 1}};
    size_t k;

    (void)state;
    for (k = 0; k < 5; k++) {
        plfx_lut_desc d = describe();
        plfx_lut t;
        d.lattice.origin.x_q16 += shift[k][0] * 65536;
        d.lattice.origin.y_q16 += shift[k][1] * 65536;
        assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), OK);
        assert_int_equal(plfx_lut_open(&t, blob, sizeof blob),
                         shift[k][2] == OK ? OK : PLFX_E_FORMAT);
    }
}

static void gain_row(void **state)
{
    const plfx_lut t = open_table();
    uint16_t row[NX];

    (void)state;
    mark(row, sizeof row);
    assert_int_equal(plfx_lut_gain_row(NULL, 0, 0, 0, row), ARG);
    assert_int_equal(plfx_lut_gain_row(&t, -1, 0, 0, row), ARG);
    assert_int_equal(plfx_lut_gain_row(&t, NY, 0, 0, row), ARG);
    assert_true(marked(row, sizeof row));
    assert_int_equal(plfx_lut_gain_row(&t, NY - 1, 0, 0, row), OK);
}

static uint16_t frame[100 * 90];

static int32_t call_row_at(void *args)
{
    plfx_raw_row row;

    mark(&row, sizeof row);
    return kept(plfx_raw_row_at(args, 1, &row), &row, sizeof row);
}

static void raw_frame(void **state)
{
#define R(field, value, status) LIMIT(plfx_raw, field, value, status)
    static const limit table[] = {
        R(bytes, 0, ARG),
        R(format, PLFX_RAW_FORMATS, ARG),
        R(format, 255, ARG),
        R(w, 0, ARG),
        R(w, -1, ARG),
        R(w, 32767, PLFX_E_SIZE),
        R(w, 32768, ARG),
        R(h, 0, ARG),
        R(h, 1, ARG), /* row 1 of one row */
        R(h, 32767, PLFX_E_SIZE),
        R(h, 32768, ARG),
        R(bits, 7, ARG),
        R(bits, 8, OK),
        R(bits, 16, OK),
        R(bits, 17, ARG),
        R(format, PLFX_RAW_U8, ARG), /* 12 bits in 8 */
        R(size, 100 * 90 * 2 - 1, PLFX_E_SIZE),
    };
#undef R
    plfx_raw raw = {(const uint8_t *)frame, sizeof frame, PLFX_RAW_U16LE, 12, 100, 90};
    plfx_raw_row row;

    (void)state;
    limits(&raw, sizeof raw, table, COUNT(table), call_row_at);
    assert_int_equal(plfx_raw_row_at(NULL, 0, &row), ARG);
    assert_int_equal(plfx_raw_row_at(&raw, 0, NULL), ARG);
    assert_int_equal(plfx_raw_row_at(&raw, -1, &row), ARG);
    assert_int_equal(plfx_raw_row_at(&raw, 90, &row), ARG);
    assert_int_equal(plfx_raw_bpp(-1), 0);
    assert_int_equal(plfx_raw_bpp(PLFX_RAW_FORMATS), 0);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_U8, 1, 0), 0);
    raw.format = PLFX_RAW_U8;
    raw.bits = 8;
    assert_int_equal(plfx_raw_row_at(&raw, 0, &row), OK);
}

typedef struct unpack_args {
    plfx_raw_row row;
    int32_t x0, n;
} unpack_args;

static int32_t call_unpack(void *args)
{
    const unpack_args *a = args;
    uint16_t out[8];

    mark(out, sizeof out);
    return kept(plfx_raw_unpack(&a->row, a->x0, a->n, out), out, sizeof out);
}

static void raw_row(void **state)
{
#define U(field, value, status) LIMIT(unpack_args, field, value, status)
    static const limit ten[] = {
        U(row.bytes, 0, ARG), U(row.format, PLFX_RAW_FORMATS, ARG),
        U(row.bits, 7, ARG),  U(row.bits, 17, ARG),
        U(row.width, 0, ARG), U(row.width, 32768, ARG),
        U(row.bit, 1, ARG),   U(row.bit, 2, OK),
        U(row.bit, 6, OK),    U(row.bit, 8, ARG),
        U(x0, -1, ARG),       U(x0, 9, ARG),
        U(n, -1, ARG),        U(n, 9, ARG),
        U(n, 0, OK),
    };
    static const limit twelve[] = {
        U(row.bit, 2, ARG),
        U(row.bit, 4, OK),
        U(row.bit, 8, ARG),
    };
    static const limit bytes[] = {
        U(row.bit, 4, ARG),
        U(row.bits, 9, ARG),
        U(row.bit, 0, OK),
    };
#undef U
    static const uint8_t from[32] = {0};
    unpack_args a = {{from, PLFX_RAW_MONO10P, 10, 0, 8}, 0, 8};
    uint16_t out[8];

    (void)state;
    limits(&a, sizeof a, ten, COUNT(ten), call_unpack);
    a.row.format = PLFX_RAW_MONO12P;
    a.row.bits = 12;
    limits(&a, sizeof a, twelve, COUNT(twelve), call_unpack);
    a.row.format = PLFX_RAW_U8;
    a.row.bits = 8;
    limits(&a, sizeof a, bytes, COUNT(bytes), call_unpack);
    assert_int_equal(plfx_raw_unpack(NULL, 0, 1, out), ARG);
    assert_int_equal(plfx_raw_unpack(&a.row, 0, 1, NULL), ARG);
}

static void bayer(void **state)
{
    static const uint16_t row[6] = {1, 2, 3, 4, 5, 6};
    uint16_t out[6];

    (void)state;
    mark(out, sizeof out);
    assert_int_equal(plfx_raw_bayer_grey(NULL, row, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_grey(row, NULL, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_grey(row, row, 6, NULL), ARG);
    assert_int_equal(plfx_raw_bayer_grey(row, row, 1, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(0, 0, 0, row, row, row, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(5, 0, 0, row, row, row, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, -1, 0, row, row, row, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 3, 0, row, row, row, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 0, -1, row, row, row, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 0, 0, row, NULL, row, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 0, 0, row, row, row, 6, NULL), ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 0, 0, row, out, row, 6, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 0, 0, row, row, row, 1, out), ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 0, 0, NULL, row, NULL, 6, out), ARG);
    assert_true(marked(out, sizeof out));
    assert_int_equal(plfx_raw_bayer_channel(4, 2, 0, NULL, row, row, 6, out), OK);
    assert_int_equal(plfx_raw_bayer_channel(1, 2, 1, row, row, NULL, 2, out), OK);
}

static uint16_t samples[NX * NY * 5];

typedef struct view_args {
    plfx_raw raw;
    plfx_tone tone;
    plfx_views out;
    plfx_offset at;
    int32_t j0, j1, k, white;
    const plfx_lut *lut;
} view_args;

static int32_t call_view(void *args)
{
    const view_args *a = args;

    mark(samples, sizeof samples);
    return kept(plfx_view_rows(a->lut, &a->raw, &a->tone, a->at, a->white, a->j0, a->j1,
                               &a->out, a->k),
                samples, sizeof samples);
}

static void view_rows(void **state)
{
#define V(field, value, status) LIMIT(view_args, field, value, status)
    static const limit table[] = {
        V(lut, 0, ARG),
        V(raw.bytes, 0, ARG),
        V(raw.w, 99, ARG),
        V(raw.h, 89, ARG),
        V(raw.bits, 7, ARG),
        V(raw.bits, 17, ARG),
        V(raw.bits, 8, OK),
        V(raw.bits, 16, OK),
        V(raw.size, sizeof frame - 1, PLFX_E_SIZE),
        V(raw.format, PLFX_RAW_FORMATS, ARG),
        V(raw.format, PLFX_RAW_U8, ARG), /* 12 bits in 8 */
        V(tone.bits, PLFX_BITS_MIN - 1, ARG),
        V(tone.bits, PLFX_BITS_MIN, OK),
        V(tone.bits, PLFX_BITS_MAX, OK),
        V(tone.bits, PLFX_BITS_MAX + 1, ARG),
        V(tone.gain_q12, 4095, ARG),
        V(tone.gain_q12, 4096, OK),
        V(tone.gain_q12, 8191, OK),
        V(tone.gain_q12, 8192, ARG),
        V(tone.shift, -9, ARG),
        V(tone.shift, -8, OK),
        V(tone.shift, 8, OK),
        V(tone.shift, 9, ARG),
        V(tone.dx_q8, -257, ARG),
        V(tone.dx_q8, -256, OK),
        V(tone.dx_q8, 256, OK),
        V(tone.dx_q8, 257, ARG),
        V(tone.dy_q8, -257, ARG),
        V(tone.dy_q8, -256, OK),
        V(tone.dy_q8, 256, OK),
        V(tone.dy_q8, 257, ARG),
        V(tone.sat_u16, 1, OK),
        V(out.px, 0, ARG),
        V(out.n, 0, ARG),
        V(out.n, PLFX_DECODE_MAX + 1, ARG),
        V(out.nx, NX - 1, ARG),
        V(out.ny, NY + 1, ARG),
        V(k, -1, ARG),
        V(k, 5, ARG),
        V(k, 4, OK),
        V(j0, -1, ARG),
        V(j0, NY, OK), /* no row */
        V(j0, NY + 1, ARG),
        V(j1, NY + 1, ARG),
        V(j1, 0, OK),
        V(white, 0, OK),
    };
#undef V
    const plfx_lut t = open_table();
    const plfx_offset at[5] = {{0, 0}, {256, 0}, {-256, 0}, {0, 256}, {0, -256}};
    view_args a = {{(const uint8_t *)frame, sizeof frame, PLFX_RAW_U16, 12, 100, 90},
                   {0, 65535u, 4096u, 0, 10, 0, 0},
                   {samples, NX, NY, 5},
                   {128, -128},
                   0,
                   NY,
                   0,
                   1,
                   &t};

    (void)state;
    limits(&a, sizeof a, table, COUNT(table), call_view);
    assert_int_equal(plfx_view_rows(&t, NULL, &a.tone, a.at, 0, 0, NY, &a.out, 0), ARG);
    assert_int_equal(plfx_view_rows(&t, &a.raw, NULL, a.at, 0, 0, NY, &a.out, 0), ARG);
    assert_int_equal(plfx_view_rows(&t, &a.raw, &a.tone, a.at, 0, 0, NY, NULL, 0), ARG);
    assert_int_equal(plfx_view_all(NULL, &a.raw, &a.tone, at, 0, &a.out), ARG);
    assert_int_equal(plfx_view_all(&t, &a.raw, &a.tone, NULL, 0, &a.out), ARG);
    assert_int_equal(plfx_view_all(&t, &a.raw, &a.tone, at, 0, NULL), ARG);
    assert_int_equal(plfx_view_all(&t, NULL, &a.tone, at, 0, &a.out), ARG);
    assert_int_equal(plfx_view_all(&t, &a.raw, &a.tone, at, 1, &a.out), OK);
    a.raw.format = PLFX_RAW_U16LE;
    assert_int_equal(plfx_view_all(&t, &a.raw, &a.tone, at, 0, &a.out), OK);
}

static plfx_cfg cross(void)
{
    static const plfx_offset at[5] = {{0, 0}, {-256, 0}, {256, 0}, {0, -256}, {0, 256}};
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.window = 5;
    c.bits = 10;
    c.n = 5;
    c.labels = 9;
    c.slope_min_q16 = -65536;
    c.slope_max_q16 = 65536;
    memcpy(c.at, at, sizeof at);
    return c;
}

static int32_t call_plan(void *args)
{
    static plfx_plan plan;

    mark(&plan, sizeof plan);
    return kept(plfx_plan_init(&plan, args, NULL, NX, NY), &plan, sizeof plan);
}

static void plan(void **state)
{
#define C(field, value, status) LIMIT(plfx_cfg, field, value, status)
    static const limit sweep[] = {
        C(cost, PLFX_COST_ZNCC, ARG),
        C(fit, PLFX_FIT_VEE, OK),
        C(fit, 2, ARG),
        C(fuse, PLFX_FUSE_CORRELATION, OK),
        C(fuse, 2, ARG),
        C(window, 1, ARG),
        C(window, 3, OK),
        C(window, 4, ARG),
        C(window, 9, ARG), /* wider than 8 rows */
        C(window, PLFX_WINDOW_MAX + 2, ARG),
        C(bits, PLFX_BITS_MIN - 1, ARG),
        C(bits, PLFX_BITS_MIN, OK),
        C(bits, PLFX_BITS_MAX, OK),
        C(bits, PLFX_BITS_MAX + 1, ARG),
        C(n, 1, ARG),
        C(n, 2, OK),
        C(n, PLFX_VIEWS_MAX + 1, ARG),
        C(ref, 5, ARG),
        C(ref, 4, OK),
        C(labels, PLFX_LABELS_MIN - 1, ARG),
        C(labels, PLFX_LABELS_MIN, OK),
        C(labels, PLFX_LABELS_MAX, OK),
        C(labels, PLFX_LABELS_MAX + 1, ARG),
        C(slope_min_q16, -32 * 65536 - 1, ARG),
        C(slope_min_q16, 65536, ARG),
        C(slope_min_q16, 65535, OK),
        C(slope_min_q16, -8 * 65536, PLFX_E_RANGE),
        C(slope_max_q16, 32 * 65536 + 1, ARG),
        C(at[3].v_q8, 0, ARG), /* the reference's own offset */
        C(at[3].v_q8, 9 * 256, PLFX_E_RANGE),
        C(at[1].u_q8, -10 * 256, PLFX_E_RANGE),
        C(method, 4, ARG),
        C(method, PLFX_METHOD_ARMS, OK),
        C(method, PLFX_METHOD_PAIRS, OK),
        C(method, PLFX_METHOD_GRADIENT, OK),
    };
    static const limit pairs[] = {
        C(cost, PLFX_COST_ZNCC, OK),
        C(cost, 2, ARG),
    };
    static const limit arms[] = {
        C(cost, PLFX_COST_ZNCC, ARG),
        C(cost, 0, OK),
    };
    static const limit gradient[] = {
        C(n, 4, ARG),          C(ref, 1, ARG),        C(at[1].u_q8, -255, ARG),
        C(at[1].v_q8, 1, ARG), C(at[2].u_q8, 1, ARG), C(at[2].v_q8, 1, ARG),
        C(at[3].u_q8, 1, ARG), C(at[3].v_q8, 1, ARG), C(at[4].u_q8, 1, ARG),
        C(at[4].v_q8, 1, ARG),
    };
#undef C
    static plfx_plan p;
    plfx_cfg c = cross();
    plfx_lut t = open_table();

    (void)state;
    limits(&c, sizeof c, sweep, COUNT(sweep), call_plan);
    c.method = PLFX_METHOD_PAIRS;
    limits(&c, sizeof c, pairs, COUNT(pairs), call_plan);
    c.method = PLFX_METHOD_ARMS;
    limits(&c, sizeof c, arms, COUNT(arms), call_plan);
    c.method = PLFX_METHOD_GRADIENT;
    limits(&c, sizeof c, gradient, COUNT(gradient), call_plan);
    assert_int_equal(plfx_plan_init(NULL, &c, NULL, NX, NY), ARG);
    assert_int_equal(plfx_plan_init(&p, NULL, NULL, NX, NY), ARG);
    assert_int_equal(plfx_plan_init(&p, &c, NULL, 4, NY), ARG);
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, 4), ARG);
    assert_int_equal(plfx_plan_init(&p, &c, NULL, PLFX_LENSES_MAX + 1, NY), ARG);
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, PLFX_LENSES_MAX + 1), ARG);
    assert_int_equal(plfx_plan_init(&p, &c, &t, NX + 1, NY), ARG);
    assert_int_equal(plfx_plan_init(&p, &c, &t, NX, NY + 1), ARG);
    assert_int_equal(plfx_plan_init(&p, &c, &t, NX, NY), OK);
    assert_int_equal(plfx_plan_init(&p, &p.cfg, &t, NX, NY), OK); /* in place */
}

/* 18 views of 12 bits add up to more than 16 bits. */
static void sums_that_do_not_fit(void **state)
{
    static plfx_plan p;
    plfx_cfg c = cross();
    int32_t k;

    (void)state;
    c.bits = 12;
    for (k = 0; k < 20; k++) {
        c.at[k].u_q8 = (int16_t)(k * 8);
        c.at[k].v_q8 = 0;
    }
    c.n = 17;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, NY), OK);
    c.n = 18;
    assert_int_equal(plfx_plan_init(&p, &c, NULL, NX, NY), PLFX_E_RANGE);
}

typedef struct gradient_args {
    plfx_views views;
    plfx_map out;
    void *ws;
    size_t size;
    uint32_t method;
} gradient_args;

static plfx_plan gradient_plan;
static int32_t slope[NX * NY];

static int32_t call_gradient(void *args)
{
    const gradient_args *a = args;
    plfx_status status;

    mark(slope, sizeof slope);
    gradient_plan.cfg.method = (uint8_t)a->method;
    status = plfx_gradient(&gradient_plan, &a->views, &a->out, a->ws, a->size);
    gradient_plan.cfg.method = PLFX_METHOD_GRADIENT;
    assert_true(status == OK || marked(slope, sizeof slope));
    return status;
}

static void gradient(void **state)
{
#define G(field, value, status) LIMIT(gradient_args, field, value, status)
    static const limit table[] = {
        G(method, PLFX_METHOD_SWEEP, ARG),
        G(views.px, 0, ARG),
        G(views.nx, NX - 1, ARG),
        G(views.ny, NY - 1, ARG),
        G(views.n, 4, ARG),
        G(out.slope_q16, 0, ARG),
        G(out.w, NX - 1, ARG),
        G(out.h, NY - 1, ARG),
        G(out.stride, NX - 1, ARG),
        G(ws, 0, PLFX_E_SIZE),
        G(size, 0, PLFX_E_SIZE),
        G(size, 8192, OK),
    };
#undef G
    static uint64_t room[1 + 16384 / 8];
    uint8_t *ws = (uint8_t *)room;
    plfx_cfg c = cross();
    gradient_args a = {{samples, NX, NY, 5},
                       {slope, NULL, NULL, NULL, NX, NY, NX},
                       NULL,
                       8192,
                       PLFX_METHOD_GRADIENT};

    (void)state;
    while ((uintptr_t)ws % PLFX_ALIGN != 0) {
        ws++;
    }
    a.ws = ws;
    c.method = PLFX_METHOD_GRADIENT;
    assert_int_equal(plfx_plan_init(&gradient_plan, &c, NULL, NX, NY), OK);
    assert_in_range(plfx_gradient_ws(&gradient_plan), 1, 8192);
    memset(samples, 0, sizeof samples);
    limits(&a, sizeof a, table, COUNT(table), call_gradient);
    a.ws = ws + 1;
    assert_int_equal(call_gradient(&a), PLFX_E_SIZE);
    a.ws = ws;
    assert_int_equal(plfx_gradient(NULL, &a.views, &a.out, ws, 8192), ARG);
    assert_int_equal(plfx_gradient(&gradient_plan, NULL, &a.out, ws, 8192), ARG);
    assert_int_equal(plfx_gradient(&gradient_plan, &a.views, NULL, ws, 8192), ARG);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(table_to_write),
    cmocka_unit_test(half_a_gain_is_none),
    cmocka_unit_test(fields_of_a_stored_table),
    cmocka_unit_test(fields_of_a_stored_gain),
    cmocka_unit_test(lengths_of_stored_sections),
    cmocka_unit_test(gain_without_head),
    cmocka_unit_test(lenses_beyond_each_side),
    cmocka_unit_test(gain_row),
    cmocka_unit_test(raw_frame),
    cmocka_unit_test(raw_row),
    cmocka_unit_test(bayer),
    cmocka_unit_test(view_rows),
    cmocka_unit_test(plan),
    cmocka_unit_test(sums_that_do_not_fit),
    cmocka_unit_test(gradient),
};

SUITE(tests)
