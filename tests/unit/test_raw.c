/* SPDX-License-Identifier: MIT
 * Raw rows against a reference that places every bit by itself. */
#include "suite.h"
#include "ref.h"
#include "ref_raw.h"

#define SEED 0x51ab2u
#define W    37
#define H    5

static uint8_t frame[W * H * 2 + 8];

static void fill(uint32_t seed)
{
    ref_rng rng = {seed};
    size_t i;

    for (i = 0; i < sizeof frame; i++) {
        frame[i] = (uint8_t)ref_next(&rng);
    }
}

static plfx_raw frame_of(int32_t format, int32_t bits, int32_t w, int32_t h)
{
    plfx_raw raw;

    raw.bytes = frame;
    raw.size = plfx_raw_bytes(format, w, h);
    raw.format = (uint8_t)format;
    raw.bits = (uint8_t)bits;
    raw.w = w;
    raw.h = h;
    return raw;
}

static void check_row(const plfx_raw *raw, int32_t y, int32_t x0, int32_t n)
{
    uint16_t got[W + 1];
    plfx_raw_row row;
    int32_t i;

    memset(got, 0xa5, sizeof got);
    assert_int_equal(plfx_raw_row_at(raw, y, &row), PLFX_OK);
    assert_int_equal(plfx_raw_unpack(&row, x0, n, got), PLFX_OK);
    for (i = 0; i < n; i++) {
        size_t q = (size_t)y * (size_t)raw->w + (size_t)(x0 + i);
        uint32_t want = ref_raw_get(frame, raw->format, q) & ((1u << raw->bits) - 1u);
        if (got[i] != want) {
            fail_msg("format %d bits %d w %d y %d x %d from %d: %u, not %u (seed %x)",
                     raw->format, raw->bits, (int)raw->w, (int)y, (int)(x0 + i),
                     (int)x0, (unsigned)got[i], (unsigned)want, SEED);
        }
    }
    assert_int_equal(got[n], 0xa5a5);
}

/* Every row of frames of every width to 37, from every pixel on. */
static void every_format_width_and_phase(void **state)
{
    int32_t format;
    int32_t w;
    int32_t y;
    int32_t x0;

    (void)state;
    fill(SEED);
    for (format = 0; format < (int32_t)PLFX_RAW_FORMATS; format++) {
        if (format == (int32_t)PLFX_RAW_U16) {
            continue;
        }
        for (w = 1; w <= W; w++) {
            plfx_raw raw = frame_of(format, (int32_t)ref_raw_depth(format), w, H);
            for (y = 0; y < H; y++) {
                for (x0 = 0; x0 < w; x0++) {
                    check_row(&raw, y, x0, w - x0);
                    check_row(&raw, y, x0, (w - x0) / 2);
                }
            }
        }
    }
}

static void fewer_bits_mask_the_rest(void **state)
{
    int32_t format;
    int32_t bits;

    (void)state;
    fill(SEED + 1u);
    for (format = 0; format < (int32_t)PLFX_RAW_FORMATS; format++) {
        for (bits = 8; bits <= (format == 0 ? 8 : 16); bits++) {
            plfx_raw raw = frame_of(format, bits, W, H);
            if (format != (int32_t)PLFX_RAW_U16) {
                check_row(&raw, 3, 0, W);
            }
        }
    }
}

static void machine_order_is_the_machine_s(void **state)
{
    static uint16_t px[W];
    uint16_t got[W];
    plfx_raw_row row;
    int32_t i;

    (void)state;
    for (i = 0; i < W; i++) {
        px[i] = (uint16_t)(i * 1771);
    }
    row.bytes = (const uint8_t *)px;
    row.format = PLFX_RAW_U16;
    row.bits = 16;
    row.bit = 0;
    row.width = W;
    assert_int_equal(plfx_raw_unpack(&row, 5, W - 5, got), PLFX_OK);
    assert_memory_equal(got, px + 5, (W - 5) * sizeof *px);
}

/* A lone set bit reaches exactly one bit of one pixel, or none (the unused bits of
 * MONO10PACKED). */
static void one_bit_makes_one_bit(void **state)
{
    static const uint8_t unused[PLFX_RAW_FORMATS] = {0, 0, 0, 0, 0, 4, 0, 0, 0};
    int32_t format;
    size_t at;

    (void)state;
    for (format = 0; format < (int32_t)PLFX_RAW_FORMATS; format++) {
        size_t bits = plfx_raw_bytes(format, 4, 1) * 8u;
        size_t seen = 0;
        if (format == (int32_t)PLFX_RAW_U16) {
            continue;
        }
        for (at = 0; at < bits; at++) {
            plfx_raw raw = frame_of(format, 16, 4, 1);
            uint16_t px[4];
            plfx_raw_row row;
            uint32_t all;
            memset(frame, 0, sizeof frame);
            frame[at / 8u] = (uint8_t)(1u << at % 8u);
            raw.bits = format == 0 ? 8 : 16;
            assert_int_equal(plfx_raw_row_at(&raw, 0, &row), PLFX_OK);
            assert_int_equal(plfx_raw_unpack(&row, 0, 4, px), PLFX_OK);
            all = (uint32_t)px[0] + px[1] + px[2] + px[3];
            assert_int_equal(all & (all - 1u), 0);
            seen += all != 0u;
        }
        assert_int_equal(seen, bits - 2u * unused[format]);
    }
}

static void sizes_of_frames(void **state)
{
    (void)state;
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_U8, 7, 3), 21);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_U16LE, 7, 3), 42);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_MONO10P, 7, 3), 27);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_MONO12P, 7, 3), 32);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_MONO10PACKED, 7, 3), 33);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_MONO12PACKED, 7, 3), 33);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_CSI10, 7, 3), 30);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_CSI12, 7, 3), 33);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_MONO12P, 4000, 3000), 18000000);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_U16, 32767, 32767), 2147352578u);
    assert_int_equal(plfx_raw_bytes(PLFX_RAW_FORMATS, 7, 3), 0);
    assert_int_equal(plfx_raw_bytes(-1, 7, 3), 0);
    assert_int_equal(plfx_raw_bytes(0, 0, 3), 0);
    assert_int_equal(plfx_raw_bytes(0, 7, 32768), 0);
    assert_int_equal(plfx_raw_bpp(PLFX_RAW_MONO10PACKED), 12);
    assert_int_equal(plfx_raw_bpp(99), 0);
}

static void bad_arguments_are_refused(void **state)
{
    plfx_raw raw = frame_of(PLFX_RAW_MONO12P, 12, W, H);
    uint16_t out[W] = {7};
    plfx_raw_row row;
    plfx_raw_row bad;

    (void)state;
    assert_int_equal(plfx_raw_row_at(&raw, H, &row), PLFX_E_ARG);
    assert_int_equal(plfx_raw_row_at(&raw, -1, &row), PLFX_E_ARG);
    assert_int_equal(plfx_raw_row_at(NULL, 0, &row), PLFX_E_ARG);
    raw.size--;
    assert_int_equal(plfx_raw_row_at(&raw, 0, &row), PLFX_E_SIZE);
    raw.size++;
    raw.bits = 17;
    assert_int_equal(plfx_raw_row_at(&raw, 0, &row), PLFX_E_ARG);
    raw.bits = 12;
    assert_int_equal(plfx_raw_row_at(&raw, 1, &row), PLFX_OK);
    assert_int_equal(row.bit, 4);
    assert_int_equal(plfx_raw_unpack(&row, 1, W, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_unpack(&row, -1, 2, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_unpack(&row, W + 1, 0, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_unpack(&row, 0, -1, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_unpack(&row, 0, 1, NULL), PLFX_E_ARG);
    bad = row;
    bad.bit = 2;
    assert_int_equal(plfx_raw_unpack(&bad, 0, 1, out), PLFX_E_ARG);
    bad = row;
    bad.format = PLFX_RAW_FORMATS;
    assert_int_equal(plfx_raw_unpack(&bad, 0, 1, out), PLFX_E_ARG);
    bad = row;
    bad.format = PLFX_RAW_U8;
    bad.bits = 9;
    bad.bit = 0;
    assert_int_equal(plfx_raw_unpack(&bad, 0, 1, out), PLFX_E_ARG);
    assert_int_equal(out[0], 7);
    assert_int_equal(plfx_raw_unpack(&row, W, 0, out), PLFX_OK);
}

/* A coloured constant frame gives each channel everywhere, at every phase. */
static void a_flat_mosaic_gives_flat_channels(void **state)
{
    static const char *const phase[] = {"", "RGGB", "GRBG", "GBRG", "BGGR"};
    static const uint16_t level[3] = {100, 2000, 30000};
    uint16_t mosaic[2][9];
    uint16_t out[9];
    int32_t bayer;
    int32_t channel;
    int32_t y;
    int32_t x;

    (void)state;
    for (bayer = 1; bayer <= 4; bayer++) {
        for (y = 0; y < 2; y++) {
            for (x = 0; x < 9; x++) {
                char c = phase[bayer][2 * y + x % 2];
                mosaic[y][x] = level[c == 'R' ? 0 : c == 'G' ? 1 : 2];
            }
        }
        for (channel = 0; channel < 3; channel++) {
            for (y = 0; y < 4; y++) {
                const uint16_t *other = mosaic[(y + 1) % 2];
                assert_int_equal(plfx_raw_bayer_channel(
                                     bayer, channel, y, y == 0 ? NULL : other,
                                     mosaic[y % 2], y == 3 ? NULL : other, 9, out),
                                 PLFX_OK);
                for (x = 0; x < 9; x++) {
                    assert_int_equal(out[x], level[channel]);
                }
            }
        }
        assert_int_equal(plfx_raw_bayer_grey(mosaic[0], mosaic[1], 9, mosaic[0]),
                         PLFX_OK);
        for (x = 0; x < 9; x++) {
            assert_int_equal(mosaic[0][x], (100 + 2 * 2000 + 30000 + 2) / 4);
        }
    }
}

static int own(int32_t bayer, int32_t channel, int32_t x, int32_t y)
{
    static const char *const phase[] = {"", "RGGB", "GRBG", "GBRG", "BGGR"};

    return phase[bayer][(y & 1) * 2 + (x & 1)] == "RGB"[channel];
}

/* Neighbours of the colour within 3x3, the nearest distance only, mirrored. */
static uint32_t ref_channel(uint16_t px[3][8], int32_t bayer, int32_t channel,
                            int32_t x, int32_t y)
{
    int32_t reach;

    if (own(bayer, channel, x, y)) {
        return px[1][x];
    }
    for (reach = 1; reach <= 2; reach++) {
        uint32_t sum = 0;
        uint32_t n = 0;
        int32_t dx;
        int32_t dy;
        for (dy = -1; dy <= 1; dy++) {
            for (dx = -1; dx <= 1; dx++) {
                int32_t at = x + dx < 0 ? 1 : x + dx > 7 ? 6 : x + dx;
                if (dx * dx + dy * dy == reach && own(bayer, channel, at, y + dy)) {
                    sum += px[1 + dy][at];
                    n++;
                }
            }
        }
        if (n != 0u) {
            return (sum + n / 2u) / n;
        }
    }
    return 0;
}

static void channels_agree_with_their_definition(void **state)
{
    ref_rng rng = {SEED};
    int32_t round;

    (void)state;
    for (round = 0; round < 500; round++) {
        uint16_t px[3][8];
        uint16_t out[8];
        int32_t bayer = ref_range(&rng, 1, 4);
        int32_t channel = ref_range(&rng, 0, 2);
        int32_t y = ref_range(&rng, 1, 2);
        int32_t x;
        for (x = 0; x < 24; x++) {
            px[x / 8][x % 8] =
                (uint16_t)(ref_range(&rng, 0, 3) == 0 ? 65535u : ref_next(&rng));
        }
        assert_int_equal(
            plfx_raw_bayer_channel(bayer, channel, y, px[0], px[1], px[2], 8, out),
            PLFX_OK);
        for (x = 0; x < 8; x++) {
            assert_int_equal(out[x], ref_channel(px, bayer, channel, x, y));
        }
    }
}

static void bad_mosaics_are_refused(void **state)
{
    uint16_t r[4] = {1, 2, 3, 4};
    uint16_t out[4] = {9, 9, 9, 9};

    (void)state;
    assert_int_equal(plfx_raw_bayer_grey(r, r, 1, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_bayer_grey(NULL, r, 4, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_bayer_channel(0, 1, 0, r, r, r, 4, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_bayer_channel(5, 1, 0, r, r, r, 4, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 3, 0, r, r, r, 4, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 1, -1, r, r, r, 4, out), PLFX_E_ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 1, 0, NULL, r, NULL, 4, out),
                     PLFX_E_ARG);
    assert_int_equal(plfx_raw_bayer_channel(1, 1, 0, r, r, r, 1, out), PLFX_E_ARG);
    assert_int_equal(out[0], 9);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(every_format_width_and_phase),
    cmocka_unit_test(fewer_bits_mask_the_rest),
    cmocka_unit_test(machine_order_is_the_machine_s),
    cmocka_unit_test(one_bit_makes_one_bit),
    cmocka_unit_test(sizes_of_frames),
    cmocka_unit_test(bad_arguments_are_refused),
    cmocka_unit_test(a_flat_mosaic_gives_flat_channels),
    cmocka_unit_test(channels_agree_with_their_definition),
    cmocka_unit_test(bad_mosaics_are_refused),
};

SUITE(tests)
