/* SPDX-License-Identifier: MIT
 * Lens tables: written, read back, and refused when anything is wrong with them. */
#include "suite.h"
#include "ref.h"
#include "bytes.h"
#include "crc32.h"
#include "fix.h"
#include "lut_format.h"

#include <math.h>

#define NX   5
#define NY   4
#define SEED 0x1eafu

static int16_t resid[NX * NY * 2];
static uint8_t flags[NX * NY];
static uint16_t profile[2 * 2 * 3 * 3];
static uint16_t lens_gain[NX * NY];
static const uint8_t opti[12] = {1, 2, 3};
static const uint8_t meta[] = "{\"camera\": \"plane\"}";
static uint8_t blob[1024];
static size_t blob_size;

static plfx_lut_desc describe(int32_t kind)
{
    plfx_lut_desc d;
    ref_rng rng = {SEED};
    int32_t i;

    memset(&d, 0, sizeof d);
    for (i = 0; i < NX * NY; i++) {
        resid[2 * i] = (int16_t)ref_range(&rng, -4096, 4096);
        resid[2 * i + 1] = (int16_t)ref_range(&rng, -4096, 4096);
        flags[i] = (uint8_t)(i % 7 == 3 ? PLFX_LENS_DIM : 0u);
        lens_gain[i] = (uint16_t)ref_range(&rng, 6000, 20000);
    }
    for (i = 0; i < (int32_t)(sizeof profile / sizeof *profile); i++) {
        profile[i] = (uint16_t)ref_range(&rng, 8192, 30000);
    }
    d.camera_id = 0xfeedf00du;
    d.sensor_w = 60;
    d.sensor_h = 48;
    d.sensor_bits = 12;
    d.lattice.kind = kind;
    d.lattice.nx = NX;
    d.lattice.ny = NY;
    d.lattice.origin.x_q16 = 5 << 16;
    d.lattice.origin.y_q16 = 6 * 65536 + 777;
    d.lattice.a.x_q22 = 10 * 4194304 + 12345;
    d.lattice.a.y_q22 = -54321;
    d.lattice.b.x_q22 = 54322;
    d.lattice.b.y_q22 = 10 * 4194304 - 999;
    if (kind == PLFX_LATTICE_HEX) {
        d.lattice.odd.x_q22 = 5 * 4194304;
        d.lattice.odd.y_q22 = -3;
    }
    d.radius_q8 = 4 * 256;
    d.resid_q12 = resid;
    d.flags = flags;
    d.zones_x = 2;
    d.zones_y = 2;
    d.profile_r = 1;
    d.profile_u13 = profile;
    d.lens_gain_u13 = lens_gain;
    d.dark_u16 = 4000;
    d.has_dark = 1;
    d.opti = opti;
    d.opti_len = sizeof opti;
    d.meta = meta;
    d.meta_len = sizeof meta - 1u;
    return d;
}

static void write_blob(const plfx_lut_desc *d)
{
    blob_size = plfx_lut_bytes(d);
    assert_in_range(blob_size, 1, sizeof blob);
    memset(blob, 0xee, sizeof blob);
    assert_int_equal(plfx_lut_write(d, blob, blob_size), PLFX_OK);
}

/* Make header and directory hold again after the test has changed them. */
static void mend_crc(void)
{
    uint32_t header = plfx_get_u32(blob + LUT_AT_HEADER);

    plfx_put_u32(blob + LUT_AT_CRC, 0);
    plfx_put_u32(blob + LUT_AT_CRC, plfx_crc32(0, blob, header));
}

static uint8_t *entry_of(const char *tag)
{
    uint32_t k;

    for (k = 0; k < plfx_get_u16(blob + LUT_AT_SECTIONS); k++) {
        uint8_t *entry = blob + LUT_HEADER + LUT_ENTRY * k;
        if (memcmp(entry, tag, 4) == 0) {
            return entry;
        }
    }
    fail_msg("no section %s", tag);
    return NULL;
}

static plfx_status open_blob(plfx_lut *lut)
{
    return plfx_lut_open(lut, blob, blob_size);
}

/* Centre by the formula of lut.h in units of 2^-22, rounded once. */
static int32_t ref_centre(int64_t origin_q16, int64_t a, int64_t b, int64_t odd,
                          int64_t res_q12, int32_t i, int32_t j)
{
    double q22 = 64.0 * (double)origin_q16 + (double)i * (double)a +
                 (double)j * (double)b + (j % 2 ? (double)odd : 0.0) +
                 1024.0 * (double)res_q12; /* exact: under 2^53 */

    return (int32_t)floor(q22 / 64.0 + 0.5);
}

static void check_round_trip(int32_t kind)
{
    plfx_lut_desc d = describe(kind);
    plfx_lut t;
    int32_t i;
    int32_t j;

    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_OK);
    assert_int_equal(t.camera_id, 0xfeedf00du);
    assert_int_equal(t.sensor_w, 60);
    assert_int_equal(t.sensor_h, 48);
    assert_int_equal(t.sensor_bits, 12);
    assert_int_equal(t.radius_q8, 1024);
    assert_int_equal(t.size, blob_size);
    assert_memory_equal(&t.lattice, &d.lattice, sizeof t.lattice);
    assert_int_equal(t.opti.length, sizeof opti);
    assert_memory_equal(blob + t.opti.offset, opti, sizeof opti);
    assert_memory_equal(blob + t.meta.offset, meta, t.meta.length);
    assert_int_equal(plfx_get_u16(blob + t.dark.offset), 4000);
    for (j = 0; j < NY; j++) {
        for (i = 0; i < NX; i++) {
            const int16_t *r = resid + 2 * (j * NX + i);
            const plfx_lattice *l = &d.lattice;
            plfx_point c = plfx_lut_centre(&t, i, j);
            assert_int_equal(c.x_q16, ref_centre(l->origin.x_q16, l->a.x_q22,
                                                 l->b.x_q22, l->odd.x_q22, r[0], i, j));
            assert_int_equal(c.y_q16, ref_centre(l->origin.y_q16, l->a.y_q22,
                                                 l->b.y_q22, l->odd.y_q22, r[1], i, j));
            assert_int_equal(plfx_lut_flags(&t, i, j), flags[j * NX + i]);
        }
    }
}

static void what_is_written_is_read(void **state)
{
    (void)state;
    check_round_trip(PLFX_LATTICE_SQUARE);
    check_round_trip(PLFX_LATTICE_HEX);
}

static void bytes_are_the_same_on_every_machine(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_HEX);

    (void)state;
    write_blob(&d);
    assert_memory_equal(blob, "PLUT\1\0\0\0", 8);
    assert_int_equal(plfx_crc32(0, (const uint8_t *)"123456789", 9), 0xcbf43926u);
    assert_int_equal(plfx_crc32(0, blob, blob_size), 0x2f933b39u);
}

static void bare_table_has_unit_gain_and_no_flags(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    uint16_t gain[NX];
    plfx_lut t;
    int32_t i;

    (void)state;
    d.resid_q12 = NULL;
    d.flags = NULL;
    d.profile_u13 = NULL;
    d.lens_gain_u13 = NULL;
    d.has_dark = 0;
    d.opti = NULL;
    d.meta = NULL;
    write_blob(&d);
    assert_int_equal(blob_size, 72);
    assert_int_equal(open_blob(&t), PLFX_OK);
    assert_int_equal(plfx_lut_flags(&t, 3, 0), 0);
    assert_int_equal(plfx_lut_gain_row(&t, 1, 300, -300, gain), PLFX_OK);
    for (i = 0; i < NX; i++) {
        assert_int_equal(gain[i], 8192);
    }
}

static void pitch_is_the_nearest_distance(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_HEX);
    plfx_lut t;

    (void)state;
    d.lattice.b.y_q22 = 36324064; /* 8.660254 px: equilateral */
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_OK);
    assert_in_range(plfx_lut_pitch_q16(&t), 655360 - 200, 655360 + 200);
}

/* No flip of a bit and no loss of a byte gets through. */
static void every_flipped_bit_is_noticed(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_HEX);
    plfx_lut t;
    size_t bit;

    (void)state;
    write_blob(&d);
    memset(&t, 0x77, sizeof t);
    for (bit = 0; bit < blob_size * 8u; bit++) {
        plfx_lut was = t;
        blob[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        assert_int_not_equal(open_blob(&t), PLFX_OK);
        assert_memory_equal(&was, &t, sizeof t);
        blob[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
    }
    assert_int_equal(open_blob(&t), PLFX_OK);
    print_message("# count: single-bit flips, %u tried, 0 missed\n", (unsigned)bit);
}

static void every_truncation_is_noticed(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    static uint8_t exact[1024];
    plfx_lut t;
    size_t n;

    (void)state;
    write_blob(&d);
    for (n = 0; n < blob_size; n++) {
        uint8_t *end = exact + sizeof exact - n; /* a tool sees reads past the end */
        memcpy(end, blob, n);
        assert_int_equal(plfx_lut_open(&t, end, n), PLFX_E_SIZE);
    }
    assert_int_equal(plfx_lut_open(&t, blob, sizeof blob),
                     PLFX_OK); /* flash behind it */
    assert_int_equal(plfx_lut_open(&t, NULL, 100), PLFX_E_ARG);
    assert_int_equal(plfx_lut_open(NULL, blob, blob_size), PLFX_E_ARG);
}

static void newer_major_is_refused_newer_minor_read(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    plfx_lut t;

    (void)state;
    write_blob(&d);
    plfx_put_u16(blob + LUT_AT_VERSION + 2, 9);
    mend_crc();
    assert_int_equal(open_blob(&t), PLFX_OK);
    plfx_put_u16(blob + LUT_AT_VERSION, LUT_MAJOR + 1u);
    mend_crc();
    assert_int_equal(open_blob(&t), PLFX_E_FORMAT);
}

static void unknown_sections_are_skipped_double_ones_refused(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    plfx_lut t;

    (void)state;
    write_blob(&d);
    memcpy(entry_of("OPTI"), "XTRA", 4);
    mend_crc();
    assert_int_equal(open_blob(&t), PLFX_OK);
    assert_int_equal(t.opti.length, 0);
    assert_int_not_equal(t.meta.length, 0);
    memcpy(entry_of("XTRA"), "META", 4);
    mend_crc();
    assert_int_equal(open_blob(&t), PLFX_E_FORMAT);
}

/* A field set to a value, its CRC in order. */
static void refuse_u32(size_t at, uint32_t v)
{
    uint32_t was = plfx_get_u32(blob + at);
    plfx_lut t;

    plfx_put_u32(blob + at, v);
    if (plfx_get_u32(blob + LUT_AT_HEADER) <= sizeof blob) {
        mend_crc();
    }
    if (open_blob(&t) == PLFX_OK) {
        fail_msg("offset %u: %08x was taken", (unsigned)at, (unsigned)v);
    }
    plfx_put_u32(blob + at, was);
    mend_crc();
}

static void sizes_that_overflow_or_disagree_are_refused(void **state)
{
    static const uint32_t wild[] = {0u,          1u,          0x7fffffffu, 0x80000000u,
                                    0xfffffff0u, 0xffffffffu, 0x40000000u, 0x10001u};
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    plfx_lut t;
    size_t k;

    (void)state;
    write_blob(&d);
    for (k = 0; k < sizeof wild / sizeof *wild; k++) {
        size_t section;
        refuse_u32(LUT_AT_SIZE, wild[k]);
        refuse_u32(LUT_AT_HEADER, wild[k]);
        refuse_u32(LUT_AT_LENSES, wild[k]);
        for (section = 0; section < 6; section++) {
            refuse_u32(LUT_HEADER + LUT_ENTRY * section + 4, wild[k]);
            refuse_u32(LUT_HEADER + LUT_ENTRY * section + 8, wild[k]);
        }
    }
    refuse_u32(LUT_AT_SENSOR, 60u);              /* height 0 */
    refuse_u32(LUT_AT_SENSOR, 48u << 16);        /* width 0 */
    refuse_u32(LUT_AT_RADIUS, 32769u);           /* over 128 px */
    refuse_u32(LUT_AT_BITS, 7u | 6u << 16);      /* 7 bits */
    refuse_u32(LUT_AT_BITS, 0x0212u | 6u << 16); /* kind 2 */
    refuse_u32(LUT_AT_BITS, 12u | 5u << 16);     /* a section fewer */
    assert_int_equal(open_blob(&t), PLFX_OK);
}

static void zero_short_and_parallel_steps_are_refused(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);

    (void)state;
    d.lattice.a.x_q22 = 0;
    d.lattice.a.y_q22 = 0;
    assert_int_equal(plfx_lut_bytes(&d), 0);
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_E_ARG);
    d = describe(PLFX_LATTICE_SQUARE);
    d.lattice.b = d.lattice.a;
    assert_int_equal(plfx_lut_bytes(&d), 0);
    d.lattice.a.x_q22 = INT32_MIN; /* the extremes multiply without overflow */
    d.lattice.a.y_q22 = INT32_MIN;
    d.lattice.b.x_q22 = INT32_MIN;
    d.lattice.b.y_q22 = INT32_MAX;
    assert_int_not_equal(plfx_lut_bytes(&d), 0);
    d = describe(PLFX_LATTICE_SQUARE);
    write_blob(&d);
    refuse_u32(LUT_AT_STEPS, 0);
}

static void lenses_off_the_sensor_must_be_flagged(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    plfx_lut t;

    (void)state;
    d.resid_q12 = NULL;
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_OK);
    d.lattice.origin.x_q16 = -9 * 65536; /* within a pitch */
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_OK);
    d.lattice.origin.x_q16 = -11 * 65536; /* column 0 is more than a pitch off */
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_E_FORMAT);
    flags[0] = flags[NX] = flags[2 * NX] = flags[3 * NX] = PLFX_LENS_MISSING;
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_OK);
    flags[NX] = PLFX_LENS_DIM;
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_E_FORMAT);
    flags[NX] = PLFX_LENS_MISSING;
    d.lattice.origin.x_q16 = 30 * 65536; /* the other side */
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_E_FORMAT);
}

static void writer_checks_before_it_writes(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    size_t need = plfx_lut_bytes(&d);

    (void)state;
    memset(blob, 0x5a, sizeof blob);
    assert_int_equal(plfx_lut_write(&d, blob, need - 1u), PLFX_E_SIZE);
    assert_int_equal(plfx_lut_write(&d, NULL, need), PLFX_E_ARG);
    assert_int_equal(plfx_lut_write(NULL, blob, need), PLFX_E_ARG);
    d.zones_x = 17;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_E_ARG);
    d.zones_x = 2;
    d.profile_r = 128;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_E_ARG);
    d.profile_r = 1;
    d.lattice.nx = PLFX_LENSES_MAX + 1;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_E_ARG);
    assert_int_equal(blob[0], 0x5a);
    assert_int_equal(plfx_lut_bytes(NULL), 0);
}

/* At most 8 bytes a lens without gains. */
static void large_table_is_small(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);

    (void)state;
    d.profile_u13 = NULL;
    d.lattice.nx = 400;
    d.lattice.ny = 400;
    d.meta_len = 0;
    assert_in_range(plfx_lut_bytes(&d), 400 * 400 * 5, 400 * 400 * 8);
}

static double clamp(double v, double lo, double hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

static double profile_at(int32_t zone, double u, double v)
{
    const uint16_t *p = profile + 9 * zone;
    double x = clamp(u, -1, 1) + 1;
    double y = clamp(v, -1, 1) + 1;
    int32_t x0 = (int32_t)clamp(floor(x), 0, 1);
    int32_t y0 = (int32_t)clamp(floor(y), 0, 1);

    x -= x0;
    y -= y0;
    p += 3 * y0 + x0;
    return (1 - y) * ((1 - x) * p[0] + x * p[1]) + y * ((1 - x) * p[3] + x * p[4]);
}

/* The formula of lut.h in double; two zones an axis. */
static double ref_gain(int32_t i, int32_t j, double u, double v)
{
    double x = clamp((i + 0.5) * 2 / NX - 0.5, 0, 1);
    double y = clamp((j + 0.5) * 2 / NY - 0.5, 0, 1);
    double top = (1 - x) * profile_at(0, u, v) + x * profile_at(1, u, v);
    double low = (1 - x) * profile_at(2, u, v) + x * profile_at(3, u, v);

    return clamp(((1 - y) * top + y * low) * lens_gain[j * NX + i] / 8192.0, 0, 65535);
}

/* Zone weights have 8 bits: half a step of the greatest difference between zones, and
 * a rounding at each of the four stages, all times the lens gain. */
static void gains_follow_their_formula(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    ref_rng rng = {SEED};
    plfx_lut t;
    int32_t round;

    (void)state;
    lens_gain[7] = 65535;
    lens_gain[8] = 0;
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_OK);
    for (round = 0; round < 2000; round++) {
        int32_t u =
            round < 4 ? (round % 2 ? 32767 : -32768) : ref_range(&rng, -300, 300);
        int32_t v =
            round < 4 ? (round / 2 ? 32767 : -32768) : ref_range(&rng, -300, 300);
        int32_t j = ref_range(&rng, 0, NY - 1);
        uint16_t gain[NX];
        int32_t i;
        assert_int_equal(plfx_lut_gain_row(&t, j, (int16_t)u, (int16_t)v, gain),
                         PLFX_OK);
        for (i = 0; i < NX; i++) {
            double want = ref_gain(i, j, u / 256.0, v / 256.0);
            double allowed = (22000.0 / 256 + 2) * lens_gain[j * NX + i] / 8192.0 + 1;
            if (fabs(gain[i] - want) > allowed) {
                fail_msg("lens %d,%d at %d,%d: %u, not %d (seed %x)", (int)i, (int)j,
                         (int)u, (int)v, (unsigned)gain[i], (int)want, SEED);
            }
        }
    }
    assert_int_equal(plfx_lut_gain_row(&t, NY, 0, 0, lens_gain), PLFX_E_ARG);
    assert_int_equal(plfx_lut_gain_row(&t, -1, 0, 0, lens_gain), PLFX_E_ARG);
    assert_int_equal(plfx_lut_gain_row(&t, 0, 0, 0, NULL), PLFX_E_ARG);
}

static void constant_gains_stay_constant(void **state)
{
    plfx_lut_desc d = describe(PLFX_LATTICE_SQUARE);
    uint16_t gain[NX];
    plfx_lut t;
    int32_t i;

    (void)state;
    for (i = 0; i < NX * NY; i++) {
        lens_gain[i] = 8192;
    }
    for (i = 0; i < 36; i++) {
        profile[i] = 12345;
    }
    write_blob(&d);
    assert_int_equal(open_blob(&t), PLFX_OK);
    assert_int_equal(plfx_lut_gain_row(&t, 2, 77, -19, gain), PLFX_OK);
    for (i = 0; i < NX; i++) {
        assert_int_equal(gain[i], 12345);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(what_is_written_is_read),
    cmocka_unit_test(bytes_are_the_same_on_every_machine),
    cmocka_unit_test(bare_table_has_unit_gain_and_no_flags),
    cmocka_unit_test(pitch_is_the_nearest_distance),
    cmocka_unit_test(every_flipped_bit_is_noticed),
    cmocka_unit_test(every_truncation_is_noticed),
    cmocka_unit_test(newer_major_is_refused_newer_minor_read),
    cmocka_unit_test(unknown_sections_are_skipped_double_ones_refused),
    cmocka_unit_test(sizes_that_overflow_or_disagree_are_refused),
    cmocka_unit_test(zero_short_and_parallel_steps_are_refused),
    cmocka_unit_test(lenses_off_the_sensor_must_be_flagged),
    cmocka_unit_test(writer_checks_before_it_writes),
    cmocka_unit_test(large_table_is_small),
    cmocka_unit_test(gains_follow_their_formula),
    cmocka_unit_test(constant_gains_stay_constant),
};

SUITE(tests)
