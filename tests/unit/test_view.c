/* SPDX-License-Identifier: MIT */
#include "suite.h"
#include "ref.h"

#include <math.h>

#define W  90
#define H  70
#define NX 8
#define NY 6
static uint16_t frame[W * H];
static uint16_t samples[NX * NY * 3];
static unsigned char blob[2048];
static uint8_t lens_flags[NX * NY];

static plfx_lut open_table(int32_t bits, double degrees, int with_gain)
{
    static uint16_t profile[81], gain[NX * NY];
    double c = cos(degrees * 0.017453292519943295) * 10.5 * 4194304;
    double s = sin(degrees * 0.017453292519943295) * 10.5 * 4194304;
    plfx_lut_desc d;
    plfx_lut lut;

    memset(&d, 0, sizeof d);
    d.sensor_w = W;
    d.sensor_h = H;
    d.sensor_bits = bits;
    d.lattice.nx = NX;
    d.lattice.ny = NY;
    d.lattice.origin.x_q16 = 7 * 65536 + 1234;
    d.lattice.origin.y_q16 = 6 * 65536 + 4321;
    d.lattice.a.x_q22 = (int32_t)lround(c);
    d.lattice.a.y_q22 = (int32_t)lround(s);
    d.lattice.b.x_q22 = (int32_t)lround(-s);
    d.lattice.b.y_q22 = (int32_t)lround(c);
    d.radius_q8 = 3 * 256;
    d.flags = lens_flags;
    if (with_gain) {
        for (int i = 0; i < 81; i++) {
            profile[i] = (uint16_t)(8192 + 50 * i);
        }
        for (int i = 0; i < NX * NY; i++) {
            gain[i] = (uint16_t)(8192 + 90 * i);
        }
        d.zones_x = 1;
        d.zones_y = 1;
        d.profile_r = 4;
        d.profile_u13 = profile;
        d.lens_gain_u13 = gain;
    }
    assert_true(plfx_lut_bytes(&d) <= sizeof blob);
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, plfx_lut_bytes(&d)), PLFX_OK);
    return lut;
}

static plfx_raw raw_of(int32_t bits)
{
    plfx_raw r = {
        (const uint8_t *)frame, sizeof frame, PLFX_RAW_U16, (uint8_t)bits, W, H};

    return r;
}

static void constant_stays_constant(void **state)
{
    plfx_views v = {samples, NX, NY, 1};

    (void)state;
    for (int32_t bits = 8; bits <= 16; bits += 2) {
        plfx_lut lut = open_table(bits, 3, 0);
        plfx_raw raw = raw_of(bits);
        uint32_t level = (uint32_t)1 << (bits - 2);
        for (int32_t out = 8; out <= 12; out++) {
            plfx_tone tone = plfx_tone_unity(out);
            plfx_offset at = {(int16_t)(300 * (out - 10)), 217};
            for (size_t i = 0; i < W * H; i++) {
                frame[i] = (uint16_t)level;
            }
            assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_OK);
            for (int i = 0; i < NX * NY; i++) {
                assert_int_equal(samples[i], 1 << (out - 2));
            }
        }
    }
}

/* Bilinear sample in double, tone applied, rounded. */
static double expected(const plfx_lut *lut, plfx_offset at, double gain, int i, int j)
{
    plfx_point c = plfx_lut_centre(lut, i, j);
    double ax = lut->lattice.a.x_q22;
    double ay = lut->lattice.a.y_q22;
    double n = sqrt(ax * ax + ay * ay);
    double u = at.u_q8 / 256.0;
    double w = at.v_q8 / 256.0;
    double x = c.x_q16 / 65536.0 + (u * ax - w * ay) / n;
    double y = c.y_q16 / 65536.0 + (u * ay + w * ax) / n;
    double fx = x - floor(x);
    double fy = y - floor(y);
    const uint16_t *p = frame + (int)floor(y) * W + (int)floor(x);

    return gain * ((p[0] * (1 - fx) + p[1] * fx) * (1 - fy) +
                   (p[W] * (1 - fx) + p[W + 1] * fx) * fy);
}

static void against_double(void **state)
{
    ref_rng rng = {31};
    plfx_raw raw = raw_of(12);
    plfx_views v = {samples, NX, NY, 3};
    plfx_offset at[3] = {{0, 0}, {700, 0}, {-300, 650}};
    plfx_tone tone = plfx_tone_unity(12);

    (void)state;
    for (size_t i = 0; i < W * H; i++) {
        frame[i] =
            (uint16_t)ref_range(&rng, 1000, 1100); /* steps of 100: position error */
    }
    for (int deg = -10; deg <= 10; deg += 10) {
        plfx_lut lut = open_table(12, deg, 0);
        lut.lattice.origin.x_q16 += deg < 0 ? 0 : 8 * 65536;
        assert_int_equal(plfx_view_all(&lut, &raw, &tone, at, 0, &v), PLFX_OK);
        for (int i = 0; i < NX * NY * 3; i++) {
            int k = i / NX % 3;
            int x = i % NX;
            int y = i / NX / 3;
            plfx_point c = plfx_lut_centre(&lut, x, y);
            if (c.x_q16 > 5 << 16 && c.x_q16 < (W - 6) << 16 && c.y_q16 > 5 << 16 &&
                c.y_q16 < (H - 6) << 16) {
                assert_true(fabs(samples[i] - expected(&lut, at[k], 1, x, y)) < 1.0);
            }
        }
    }
}

static void tone_and_gain(void **state)
{
    plfx_lut lut = open_table(12, 0, 1);
    plfx_raw raw = raw_of(12);
    plfx_views v = {samples, NX, NY, 1};
    plfx_tone tone = plfx_tone_unity(10);
    plfx_offset at = {0, 0};
    uint16_t gain[NX];

    (void)state;
    for (size_t i = 0; i < W * H; i++) {
        frame[i] = 600;
    }
    tone.black_u16 = 100 << 4;
    tone.gain_q12 = 6144; /* 1.5 */
    tone.shift = 1;
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 1, &v), PLFX_OK);
    for (int j = 0; j < NY; j++) {
        assert_int_equal(plfx_lut_gain_row(&lut, j, 0, 0, gain), PLFX_OK);
        for (int i = 0; i < NX; i++) {
            double want = 500.0 / 4 * 3 * gain[i] / 8192;
            assert_true(fabs(samples[j * NX + i] - (want > 1023 ? 1023 : want)) <=
                        0.51);
        }
    }
}

static void clipped_stays_clipped(void **state)
{
    plfx_lut lut = open_table(12, 0, 0);
    plfx_raw raw = raw_of(12);
    plfx_views v = {samples, NX, NY, 1};
    plfx_tone tone = plfx_tone_unity(10);
    plfx_offset at = {0, 0};

    (void)state;
    for (size_t i = 0; i < W * H; i++) {
        frame[i] = 4095;
    }
    tone.shift = -2;
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_OK);
    assert_int_equal(samples[9], 1023);
    frame[0] = 0;
    tone.sat_u16 = 1000 << 4;
    for (size_t i = 0; i < W * H; i++) {
        frame[i] = 1000;
    }
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_OK);
    assert_int_equal(samples[9], 1023);
}

/* Holes of one and two lenses, at both ends of a row, and a row without light. */
static void missing_lens_takes_its_neighbours(void **state)
{
    static const uint8_t hole[NX] = {1, 0, 1, 1, 0, 0, 0, 1};
    plfx_lut lut;
    plfx_raw raw = raw_of(12);
    plfx_views v = {samples, NX, NY, 1};
    plfx_tone tone = plfx_tone_unity(12);
    plfx_offset at = {0, 0};

    (void)state;
    for (int i = 0; i < 2 * NX; i++) {
        lens_flags[i] = i >= NX || hole[i] ? PLFX_LENS_MISSING : 0;
    }
    lut = open_table(12, 0, 0);
    memset(lens_flags, 0, sizeof lens_flags);
    for (size_t i = 0; i < W * H; i++) {
        frame[i] = (uint16_t)(100 + i % W);
    }
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_OK);
    assert_int_equal(samples[0], samples[1]);
    assert_int_equal(samples[2], (samples[1] + samples[4] + 1) / 2);
    assert_int_equal(samples[3], samples[2]);
    assert_true(samples[1] > 0 && samples[4] > samples[1]);
    assert_int_equal(samples[7], samples[6]);
    for (int i = 0; i < NX; i++) {
        assert_int_equal(samples[NX + i], 0);
    }
}

/* Every storage format gives the same samples. */
static void formats_agree(void **state)
{
    static uint8_t packed[W * H * 2];
    static uint16_t want[NX * NY];
    plfx_lut lut = open_table(12, 2, 0);
    plfx_raw raw = raw_of(12);
    plfx_views v = {samples, NX, NY, 1};
    plfx_tone tone = plfx_tone_unity(12);
    plfx_offset at = {100, -50};
    ref_rng rng = {8};

    (void)state;
    for (size_t i = 0; i < W * H; i++) {
        frame[i] = (uint16_t)ref_range(&rng, 0, 4094);
    }
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_OK);
    memcpy(want, samples, sizeof want);
    for (size_t i = 0; i < W * H; i += 2) {
        packed[i / 2 * 3] = (uint8_t)(frame[i] & 255);
        packed[i / 2 * 3 + 1] = (uint8_t)(frame[i] >> 8 | (frame[i + 1] & 15) << 4);
        packed[i / 2 * 3 + 2] = (uint8_t)(frame[i + 1] >> 4);
    }
    raw.bytes = packed;
    raw.size = W * H * 3 / 2;
    raw.format = PLFX_RAW_MONO12P;
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_OK);
    assert_memory_equal(samples, want, sizeof want);
    raw.size--;
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_E_SIZE);
}

#define WIDE 240
#define TALL 90
#define MANY 19       /* lenses of a row: two blocks and three */
#define GRID (19 * 3) /* views */

/* Most lenses at 1/8 of the sensor from its border: their views lie side by side. */
static plfx_lut open_wide(double degrees, int32_t bits)
{
    static uint16_t profile[81], gain[MANY * 4];
    static uint8_t flags[MANY * 4];
    plfx_lut_desc d;
    plfx_lut lut;

    memset(&d, 0, sizeof d);
    d.sensor_w = WIDE;
    d.sensor_h = TALL;
    d.sensor_bits = bits;
    d.lattice.nx = MANY;
    d.lattice.ny = 4;
    d.lattice.origin.x_q16 = 20 * 65536 + 1234;
    d.lattice.origin.y_q16 = 25 * 65536 + 4321;
    d.lattice.a.x_q22 = (int32_t)lround(cos(degrees / 57.29578) * 10.5 * 4194304);
    d.lattice.a.y_q22 = (int32_t)lround(sin(degrees / 57.29578) * 10.5 * 4194304);
    d.lattice.b.x_q22 = -d.lattice.a.y_q22;
    d.lattice.b.y_q22 = d.lattice.a.x_q22;
    d.radius_q8 = 3 * 256;
    for (int i = 0; i < MANY * 4; i++) {
        flags[i] = i % 11 == 3 ? PLFX_LENS_MISSING : 0;
        gain[i] = (uint16_t)(8192 + 50 * i);
        profile[i] = (uint16_t)(8192 + 50 * i);
    }
    d.flags = flags;
    d.zones_x = 1;
    d.zones_y = 1;
    d.profile_r = 4;
    d.profile_u13 = profile;
    d.lens_gain_u13 = gain;
    assert_true(plfx_lut_bytes(&d) <= sizeof blob);
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, plfx_lut_bytes(&d)), PLFX_OK);
    return lut;
}

/* Three runs of 19 views one pixel apart, the last one with gaps. */
static void place_grid(plfx_offset *at, ref_rng *rng)
{
    int32_t u0 = ref_range(rng, -3500, 500);

    for (int32_t k = 0; k < GRID; k++) {
        at[k].u_q8 = (int16_t)(u0 + 256 * (k % 19) + (k > GRID - 4 ? 7 * k : 0));
        at[k].v_q8 = (int16_t)(300 * (k / 19) - 200);
    }
}

/* Views side by side are sampled at once: the same as each on its own. */
static void grid_equals_single_views(void **state)
{
    static const double degrees[4] = {0, 0.05, -1, 4};
    static uint16_t picture[WIDE * TALL], at_once[MANY * 4 * GRID],
        single[MANY * 4 * GRID];
    ref_rng rng = {9};

    (void)state;
    for (int32_t t = 0; t < 64; t++) {
        int32_t bits = 8 + 2 * (t % 5);
        plfx_lut lut = open_wide(degrees[t / 4 % 4], bits);
        plfx_raw raw = {(const uint8_t *)picture,
                        sizeof picture,
                        PLFX_RAW_U16,
                        (uint8_t)bits,
                        WIDE,
                        TALL};
        plfx_views a = {at_once, MANY, 4, GRID};
        plfx_views b = {single, MANY, 4, GRID};
        plfx_tone tone = plfx_tone_unity(12);
        plfx_offset at[GRID];
        tone.black_u16 = (uint16_t)ref_range(&rng, 0, 9000);
        tone.gain_q12 = (uint16_t)ref_range(&rng, 4096, 8191);
        place_grid(at, &rng);
        for (size_t i = 0; i < WIDE * TALL; i++) {
            picture[i] = (uint16_t)ref_range(&rng, 0, (1 << bits) - 1);
        }
        assert_int_equal(plfx_view_all(&lut, &raw, &tone, at, t & 1, &a), PLFX_OK);
        for (int32_t k = 0; k < GRID; k++) {
            assert_int_equal(
                plfx_view_rows(&lut, &raw, &tone, at[k], t & 1, 0, 4, &b, k), PLFX_OK);
        }
        assert_memory_equal(at_once, single, sizeof single);
    }
}

/* Views side by side that leave the sensor to the left, to the right, above and below:
 * the border's pixels repeat, as for each view on its own. */
static void runs_off_each_side(void **state)
{
    static const int16_t from[5][2] = {{-24, 0}, {50, 0}, {0, -28}, {0, 36}, {0, 0}};
    static uint16_t picture[WIDE * TALL], at_once[MANY * 4 * 6], single[MANY * 4 * 6];
    plfx_lut lut = open_wide(0, 12);
    plfx_raw raw = {
        (const uint8_t *)picture, sizeof picture, PLFX_RAW_U16, 12, WIDE, TALL};
    plfx_views a = {at_once, MANY, 4, 6};
    plfx_views b = {single, MANY, 4, 6};
    plfx_tone tone = plfx_tone_unity(12);
    ref_rng rng = {77};

    (void)state;
    for (size_t i = 0; i < WIDE * TALL; i++) {
        picture[i] = (uint16_t)ref_range(&rng, 0, 4095);
    }
    for (int32_t side = 0; side < 5; side++) {
        plfx_offset at[6];
        for (int32_t k = 0; k < 6; k++) {
            at[k].u_q8 = (int16_t)(256 * (from[side][0] + k) + 77);
            at[k].v_q8 = (int16_t)(256 * from[side][1] - 33);
        }
        assert_int_equal(plfx_view_all(&lut, &raw, &tone, at, 0, &a), PLFX_OK);
        for (int32_t k = 0; k < 6; k++) {
            assert_int_equal(plfx_view_rows(&lut, &raw, &tone, at[k], 0, 0, 4, &b, k),
                             PLFX_OK);
        }
        assert_memory_equal(at_once, single, sizeof single);
    }
}

/* More views than are held at once, in runs that no chunk may cut. */
static void chunks_end_between_runs(void **state)
{
    enum { VIEWS = 200 };
    static uint16_t picture[WIDE * TALL], at_once[MANY * 4 * VIEWS],
        single[MANY * 4 * VIEWS];
    plfx_lut lut = open_wide(0, 12);
    plfx_raw raw = {
        (const uint8_t *)picture, sizeof picture, PLFX_RAW_U16, 12, WIDE, TALL};
    plfx_views a = {at_once, MANY, 4, VIEWS};
    plfx_views b = {single, MANY, 4, VIEWS};
    plfx_tone tone = plfx_tone_unity(12);
    plfx_offset at[VIEWS];
    ref_rng rng = {78};

    (void)state;
    for (size_t i = 0; i < WIDE * TALL; i++) {
        picture[i] = (uint16_t)ref_range(&rng, 0, 4095);
    }
    for (int32_t k = 0; k < VIEWS; k++) {
        at[k].u_q8 = (int16_t)(256 * (k % 19 - 9) + 50);
        at[k].v_q8 = (int16_t)(150 * (k / 19 - 5));
    }
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, at, 0, &a), PLFX_OK);
    for (int32_t k = 0; k < VIEWS; k++) {
        assert_int_equal(plfx_view_rows(&lut, &raw, &tone, at[k], 0, 0, 4, &b, k),
                         PLFX_OK);
    }
    assert_memory_equal(at_once, single, sizeof single);
}

static void white_without_gains_is_one(void **state)
{
    static uint16_t plain[NX * NY];
    plfx_lut lut = open_table(12, 1, 0);
    plfx_raw raw = raw_of(12);
    plfx_views v = {samples, NX, NY, 1};
    plfx_tone tone = plfx_tone_unity(12);
    plfx_offset at = {100, 50};

    (void)state;
    for (size_t i = 0; i < W * H; i++) {
        frame[i] = (uint16_t)(i * 2654435761u >> 20 & 4095u);
    }
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_OK);
    memcpy(plain, samples, sizeof plain);
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 1, &v), PLFX_OK);
    assert_memory_equal(samples, plain, sizeof plain);
}

static void bad_arguments(void **state)
{
    plfx_lut lut = open_table(12, 0, 0);
    plfx_raw raw = raw_of(12);
    plfx_views v = {samples, NX, NY, 2};
    plfx_tone tone = plfx_tone_unity(12);
    plfx_tone t;
    plfx_offset at = {0, 0};

    (void)state;
#define ROWS(l, r, o, j0, j1, w, k) plfx_view_rows(l, r, o, at, 0, j0, j1, w, k)
    assert_int_equal(ROWS(NULL, &raw, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    assert_int_equal(ROWS(&lut, NULL, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    assert_int_equal(ROWS(&lut, &raw, NULL, 0, 1, &v, 0), PLFX_E_ARG);
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, NULL, 0), PLFX_E_ARG);
    assert_int_equal(ROWS(&lut, &raw, &tone, -1, 1, &v, 0), PLFX_E_ARG);
    assert_int_equal(ROWS(&lut, &raw, &tone, 2, 1, &v, 0), PLFX_E_ARG);
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, NY + 1, &v, 0), PLFX_E_ARG);
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, 2), PLFX_E_ARG);
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, -1), PLFX_E_ARG);
    t = tone;
    t.bits = 7;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t.bits = 13;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t = tone;
    t.gain_q12 = 4095;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t.gain_q12 = 8192;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t = tone;
    t.shift = 9;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t.shift = -9;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t = tone;
    t.dx_q8 = 257;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t.dx_q8 = -257;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t.dx_q8 = 0;
    t.dy_q8 = 257;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    t.dy_q8 = -257;
    assert_int_equal(ROWS(&lut, &raw, &t, 0, 1, &v, 0), PLFX_E_ARG);
    raw.w--;
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    raw.w++;
    raw.h--;
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    raw.h++;
    raw.bits = 7;
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    raw.bits = 17;
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    raw.bits = 12;
    v.nx--;
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    v.nx++;
    v.ny++;
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    v.ny--;
    v.n = PLFX_DECODE_MAX + 1;
    assert_int_equal(ROWS(&lut, &raw, &tone, 0, 1, &v, 0), PLFX_E_ARG);
    v.n = 2;
    assert_int_equal(plfx_view_all(NULL, &raw, &tone, &at, 0, &v), PLFX_E_ARG);
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, NULL, 0, &v), PLFX_E_ARG);
    v.px = NULL;
    assert_int_equal(plfx_view_all(&lut, &raw, &tone, &at, 0, &v), PLFX_E_ARG);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(constant_stays_constant),
    cmocka_unit_test(against_double),
    cmocka_unit_test(tone_and_gain),
    cmocka_unit_test(clipped_stays_clipped),
    cmocka_unit_test(missing_lens_takes_its_neighbours),
    cmocka_unit_test(formats_agree),
    cmocka_unit_test(grid_equals_single_views),
    cmocka_unit_test(runs_off_each_side),
    cmocka_unit_test(chunks_end_between_runs),
    cmocka_unit_test(white_without_gains_is_one),
    cmocka_unit_test(bad_arguments),
};

SUITE(tests)
