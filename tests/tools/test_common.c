/* SPDX-License-Identifier: MIT
 * Readers and writers of the tools: round trips, every cut of every format, options. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <tiffio.h>

#include "common/args.h"
#include "common/band_pass.h"
#include "common/colour.h"
#include "common/csv.h"
#include "common/err.h"
#include "common/folder.h"
#include "common/frame.h"
#include "common/json.h"
#include "common/out.h"
#include "common/pfm.h"
#include "common/square.h"

static char folder[] = "/tmp/plenofix-test-XXXXXX";
static char path[64];

static const char *in_folder(const char *name)
{
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* A reader of n bytes: 0 when it took them. */
typedef int reader(const unsigned char *bytes, size_t n);

static int read_pfm(const unsigned char *bytes, size_t n)
{
    plft_map map;
    int rc = plft_pfm_parse(&map, bytes, n, "cut");

    plft_map_free(&map);
    return rc;
}

static int read_png(const unsigned char *bytes, size_t n)
{
    plft_frame f;
    int rc = plft_png_parse(&f, bytes, n, "cut");

    plft_frame_free(&f);
    return rc;
}

static int read_tiff(const unsigned char *bytes, size_t n)
{
    plft_frame f;
    int rc = plft_tiff_parse(&f, bytes, n, "cut");

    plft_frame_free(&f);
    return rc;
}

static int read_json(const unsigned char *bytes, size_t n)
{
    json_t *root = NULL;
    int rc = plft_json_parse(&root, (const char *)bytes, n, "cut");

    json_decref(root);
    return rc;
}

/* Every shorter file is refused; every file with one byte turned is survived. */
static void cut_and_turn(const char *file, reader *read, size_t slack)
{
    unsigned char *bytes, *copy;
    size_t n, k;

    assert_int_equal(plft_in_bytes(file, &bytes, &n), 0);
    assert_int_equal(read(bytes, n), 0);
    for (k = 0; k + slack < n; k++) {
        copy =
            (unsigned char *)malloc(k > 0 ? k : 1); /* exact: a read beyond it shows */
        assert_non_null(copy);
        memcpy(copy, bytes, k);
        assert_int_equal(read(copy, k), PLFT_DATA);
        free(copy);
    }
    for (k = 0; k < n; k++) {
        bytes[k] ^= (unsigned char)(1u << k % 8);
        (void)read(bytes, n);
        bytes[k] ^= (unsigned char)(1u << k % 8);
    }
    free(bytes);
}

static void fill(plft_frame *f, int w, int h, int channels, int bits)
{
    size_t k, n = (size_t)w * (size_t)h * (size_t)channels;

    assert_int_equal(
        plft_frame_alloc(f, (unsigned long)w, (unsigned long)h, channels, "made"), 0);
    f->bits = bits;
    for (k = 0; k < n; k++) {
        f->px[k] = (uint16_t)((k * 2654435761u >> 7) & ((1u << bits) - 1u));
    }
}

static void png_round_trip(void **state)
{
    static const int bits[] = {8, 10, 12, 16};
    int b, c;

    (void)state;
    for (b = 0; b < 4; b++) {
        for (c = 1; c <= 3; c += 2) {
            plft_frame out, in;
            fill(&out, 13, 7, c, bits[b]);
            assert_int_equal(plft_png_write(in_folder("a.png"), &out), 0);
            assert_int_equal(plft_frame_read(&in, path, bits[b]), 0);
            assert_int_equal(in.w, 13);
            assert_int_equal(in.h, 7);
            assert_int_equal(in.channels, c);
            assert_memory_equal(in.px, out.px, 13u * 7u * (size_t)c * 2u);
            plft_frame_free(&in);
            plft_frame_free(&out);
            cut_and_turn(path, read_png, 0);
        }
    }
}

static void write_tiff(const char *file, const plft_frame *f)
{
    TIFF *t = TIFFOpen(file, "w");
    size_t n = (size_t)f->w * (size_t)f->channels, k;
    unsigned char narrow[128];
    uint16_t wide[128];
    int y;

    assert_non_null(t);
    assert_true(n <= 128);
    TIFFSetField(t, TIFFTAG_IMAGEWIDTH, f->w);
    TIFFSetField(t, TIFFTAG_IMAGELENGTH, f->h);
    TIFFSetField(t, TIFFTAG_SAMPLESPERPIXEL, f->channels);
    TIFFSetField(t, TIFFTAG_BITSPERSAMPLE, f->bits > 8 ? 16 : 8);
    TIFFSetField(t, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(t, TIFFTAG_ROWSPERSTRIP, 3);
    TIFFSetField(t, TIFFTAG_PHOTOMETRIC,
                 f->channels == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
    for (y = 0; y < f->h; y++) {
        for (k = 0; k < n; k++) {
            wide[k & 127] = f->px[(size_t)y * n + k];
            narrow[k & 127] = (unsigned char)wide[k & 127];
        }
        assert_int_equal(
            TIFFWriteScanline(t, f->bits > 8 ? (void *)wide : narrow, (uint32_t)y, 0),
            1);
    }
    TIFFClose(t);
}

static void tiff_frames(void **state)
{
    int bits, c;

    (void)state;
    for (bits = 8; bits <= 16; bits += 8) {
        for (c = 1; c <= 3; c += 2) {
            plft_frame out, in;
            fill(&out, 11, 8, c, bits);
            write_tiff(in_folder("a.tif"), &out);
            assert_int_equal(plft_frame_read(&in, path, 0), 0);
            assert_int_equal(in.bits, bits);
            assert_memory_equal(in.px, out.px, 11u * 8u * (size_t)c * 2u);
            plft_frame_free(&in);
            plft_frame_free(&out);
            /* The directory comes last: what lies behind it may be missing. */
            cut_and_turn(path, read_tiff, 0);
        }
    }
}

static void pfm_round_trip(void **state)
{
    float v[35];
    plft_map map;
    int k;

    (void)state;
    for (k = 0; k < 35; k++) {
        v[k] = k % 6 == 0 ? (float)NAN : (float)k / 7.0f - 2.0f;
    }
    assert_int_equal(plft_pfm_write(in_folder("a.pfm"), v, 7, 5), 0);
    assert_int_equal(plft_pfm_read(&map, path), 0);
    assert_int_equal(map.w, 7);
    assert_int_equal(map.h, 5);
    for (k = 0; k < 35; k++) {
        assert_true(k % 6 == 0 ? isnan(map.v[k]) : map.v[k] == v[k]);
    }
    plft_map_free(&map);
    cut_and_turn(path, read_pfm, 0);
}

/* Big-endian and the last row first, as the format says. */
static void pfm_order(void **state)
{
    static const unsigned char file[] = "Pf\n1 2\n1.0\n\x3f\x80\0\0\x40\0\0\0";
    plft_map map;

    (void)state;
    assert_int_equal(plft_pfm_parse(&map, file, sizeof file - 1, "made"), 0);
    assert_true(map.v[0] == 2.0f && map.v[1] == 1.0f);
    plft_map_free(&map);
}

static void csv_tables(void **state)
{
    static const char good[] = "# c\nrow, Col ;x\n1,2,3\r\n\n 4\t5 6\n7;;9";
    static const char *const bad[] = {"",          "a,b\n",        "1,2\n3\n",
                                      "1\nx\n",    "1,2\n3,4,5\n", "1e,2\n3,4x\n",
                                      "# only\n\n"};
    plft_csv csv;
    size_t k;

    (void)state;
    assert_int_equal(plft_csv_parse(&csv, good, sizeof good - 1, "made"), 0);
    assert_int_equal(csv.rows, 3);
    assert_int_equal(csv.cols, 3);
    assert_true(csv.v[5] == 6.0 && isnan(csv.v[7]) && csv.v[8] == 9.0);
    assert_int_equal(plft_csv_column(&csv, "col"), 1);
    assert_int_equal(plft_csv_column(&csv, "x"), 2);
    assert_int_equal(plft_csv_column(&csv, "y"), -1);
    plft_csv_free(&csv);
    for (k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        assert_int_equal(plft_csv_parse(&csv, bad[k], strlen(bad[k]), "bad"),
                         PLFT_DATA);
    }
}

static void json_objects(void **state)
{
    static const char text[] = "{\"a\": 1.5, \"b\": \"no\", \"c\": 9}";
    json_t *root;
    double v = 7.0;

    (void)state;
    assert_int_equal(plft_out_bytes(in_folder("a.json"), text, sizeof text - 1), 0);
    assert_int_equal(plft_json_read(&root, path), 0);
    assert_int_equal(plft_json_real(root, "a", 0, 2, 1, &v, "made"), 0);
    assert_true(v == 1.5);
    assert_int_equal(plft_json_real(root, "d", 0, 2, 0, &v, "made"), 0);
    assert_true(v == 1.5);
    assert_int_equal(plft_json_real(root, "d", 0, 2, 1, &v, "made"), PLFT_DATA);
    assert_int_equal(plft_json_real(root, "b", 0, 2, 1, &v, "made"), PLFT_DATA);
    assert_int_equal(plft_json_real(root, "c", 0, 2, 1, &v, "made"), PLFT_DATA);
    json_decref(root);
    cut_and_turn(in_folder("a.json"), read_json, 0);
}

static void names_in_order(void **state)
{
    (void)state;
    assert_true(plft_name_order("view_2_9.png", "view_2_10.png") < 0);
    assert_true(plft_name_order("view_10_1.png", "view_9_2.png") > 0);
    assert_true(plft_name_order("in_007.png", "in_7.png") == 0);
    assert_true(plft_name_order("a1", "b0") < 0);
    assert_true(plft_name_order("a", "a1") < 0);
    assert_true(plft_name_order("99999999999999999999", "100000000000000000000") < 0);
}

static void options(void **state)
{
    int flag = 0, whole = 0, word = 0, n, helped;
    double real = 0.0;
    const char *text = NULL, *operand[2];
    const plft_option table[] = {{"--flag", PLFT_FLAG, &flag, NULL, 0, 0, "f"},
                                 {"--whole", PLFT_INT, &whole, "N", -5, 5, "w"},
                                 {"--real", PLFT_REAL, &real, "R", -1, 1, "r"},
                                 {"--word", PLFT_WORD, &word, "no|yes", 0, 0, "w"},
                                 {"-o", PLFT_TEXT, &text, "OUT", 0, 0, "o"},
                                 {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    const plft_usage usage = {"test", "", ""};
    char a[][12] = {"test", "one",    "--whole", "-3",  "--real=0.5", "--word",
                    "yes",  "--flag", "-o",      "out", "--",         "--two"};
    char *argv[12];
    static const char *const wrong[][2] = {
        {"--whole", "6"}, {"--whole", "1.5"},  {"--real", "nan"}, {"--real", "1x"},
        {"--word", "ye"}, {"-o", ""},          {"--other", "1"},  {"--flag=1", "x"},
        {"--whole", ""},  {"--word", "no|yes"}};
    size_t k;

    (void)state;
    for (k = 0; k < 12; k++) {
        argv[k] = a[k];
    }
    assert_int_equal(plft_args(12, argv, &usage, table, operand, 2, &n, &helped), 0);
    assert_int_equal(n, 2);
    assert_string_equal(operand[0], "one");
    assert_string_equal(operand[1], "--two");
    assert_true(flag == 1 && whole == -3 && real == 0.5 && word == 1 && !helped);
    assert_string_equal(text, "out");
    assert_int_equal(plft_args(12, argv, &usage, table, operand, 1, &n, &helped),
                     PLFT_USAGE);
    for (k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        char first[16], second[16];
        char *two[3];
        (void)snprintf(first, sizeof first, "%s", wrong[k][0]);
        (void)snprintf(second, sizeof second, "%s", wrong[k][1]);
        two[0] = a[0];
        two[1] = first;
        two[2] = second;
        assert_int_equal(plft_args(3, two, &usage, table, operand, 2, &n, &helped),
                         PLFT_USAGE);
    }
}

static void outputs_are_whole(void **state)
{
    unsigned char *bytes;
    size_t n;
    plft_out out;

    (void)state;
    assert_int_equal(plft_out_bytes(in_folder("whole"), "old", 3), 0);
    assert_int_equal(plft_out_open(&out, path), 0);
    assert_int_equal(fprintf(out.file, "new"), 3);
    plft_out_abort(&out);
    plft_out_abort(&out);
    assert_int_equal(plft_in_bytes(path, &bytes, &n), 0);
    assert_string_equal((char *)bytes, "old");
    free(bytes);
    assert_int_equal(plft_out_check(path), 0);
    assert_int_equal(plft_out_check(NULL), 0);
    assert_int_equal(plft_out_check(folder), PLFT_DATA);
    assert_int_equal(plft_out_check("/no/such/folder/x"), PLFT_DATA);
}

static int brightness(float t)
{
    uint8_t c[3];

    plft_colour(t, c);
    return 299 * c[0] + 587 * c[1] + 114 * c[2];
}

static void colours_rise(void **state)
{
    uint8_t nan[3];
    int k;

    (void)state;
    for (k = 1; k <= 64; k++) {
        assert_true(brightness((float)k / 64.0f) > brightness((float)(k - 1) / 64.0f));
    }
    assert_int_equal(brightness(-1.0f), brightness(0.0f));
    assert_int_equal(brightness(9.0f), brightness(1.0f));
    plft_colour((float)NAN, nan);
    assert_true(nan[0] == 128 && nan[1] == 128 && nan[2] == 128);
}

/* A hexagonal array drawn square: 7 rows of 0.866 pitch are 6 pixels tall, and the
 * picture of x is x. */
static void hexagons_drawn_square(void **state)
{
    plfx_lattice l;
    plft_square sq;
    uint16_t px[7 * 10], flat[128];
    int i, j, x, y;

    (void)state;
    memset(&l, 0, sizeof l);
    l.kind = PLFX_LATTICE_HEX;
    l.nx = 10;
    l.ny = 7;
    l.a.x_q22 = 10 << 22;
    l.b.y_q22 = 36324200; /* 8.6603 px */
    l.odd.x_q22 = 5 << 22;
    assert_int_equal(plft_square_init(&sq, &l, 10, 7), 0);
    assert_int_equal(sq.h, 6);
    assert_true(sq.w * sq.h <= 128);
    for (j = 0; j < 7; j++) {
        for (i = 0; i < 10; i++) {
            px[j * 10 + i] = (uint16_t)(100 * i + (j % 2 != 0 ? 50 : 0));
        }
    }
    plft_square_view(&sq, px, 10, flat);
    for (y = 0; y < sq.h; y++) {
        for (x = 1; x < 9; x++) {
            assert_true(abs(flat[y * sq.w + x] - 100 * x) <= 1);
        }
    }
    plft_square_free(&sq);
}

static int start(void **state)
{
    (void)state;
    /* Thousands of refusals, each a line. */
    return mkdtemp(folder) != NULL && freopen("/dev/null", "w", stderr) != NULL ? 0
                                                                                : -1;
}

static int finish(void **state)
{
    static const char *const names[] = {"a.png", "a.tif", "a.pfm", "a.json", "whole"};
    size_t k;

    (void)state;
    for (k = 0; k < sizeof names / sizeof names[0]; k++) {
        (void)unlink(in_folder(names[k]));
    }
    return rmdir(folder);
}

#define BAND_X 13
#define BAND_Y 9

static long at_rim(const uint16_t *px, int x, int y)
{
    x = x < 0 ? 0 : x >= BAND_X ? BAND_X - 1 : x;
    y = y < 0 ? 0 : y >= BAND_Y ? BAND_Y - 1 : y;
    return px[(size_t)y * 2 * BAND_X + (size_t)x];
}

/* The formula of band_pass.h, sample by sample; rows of two views lie in turns. */
static uint16_t band_sample(const uint16_t *px, int x, int y, int bits)
{
    long full = (1l << bits) - 1, v = 0;
    int i, j;

    for (j = -3; j <= 3; j++) {
        for (i = -3; i <= 3; i++) {
            long weight = abs(i) < 2 && abs(j) < 2 ? (2 - abs(i)) * (2 - abs(j)) : 0;
            v += (49 * weight - 16) * at_rim(px, x + i, y + j);
        }
    }
    v = (long)floor((double)v / 784 + (double)(1l << (bits - 1)) + 0.5);
    v = v < 0 ? 0 : v > full - 1 ? full - 1 : v;
    return (uint16_t)(at_rim(px, x, y) >= full ? full : v);
}

static void band_pass_is_the_formula(void **state)
{
    static uint16_t px[2 * BAND_X * BAND_Y], old[2 * BAND_X * BAND_Y];
    plfx_views views = {px, BAND_X, BAND_Y, 2};
    int bits, i, k, x, y;

    (void)state;
    srand(7);
    for (bits = 8; bits <= 12; bits += 2) {
        for (i = 0; i < 2 * BAND_X * BAND_Y; i++) { /* extremes, then anything */
            px[i] =
                (uint16_t)((rand() % 3 ? rand() : -(rand() % 2)) & ((1 << bits) - 1));
        }
        memcpy(old, px, sizeof old);
        assert_int_equal(plft_band_pass(&views, bits), 0);
        for (k = 0; k < 2; k++) {
            for (i = 0; i < BAND_X * BAND_Y; i++) {
                x = i % BAND_X;
                y = i / BAND_X;
                assert_int_equal(px[(2 * y + k) * BAND_X + x],
                                 band_sample(old + (size_t)k * BAND_X, x, y, bits));
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(png_round_trip),
                                       cmocka_unit_test(tiff_frames),
                                       cmocka_unit_test(pfm_round_trip),
                                       cmocka_unit_test(pfm_order),
                                       cmocka_unit_test(csv_tables),
                                       cmocka_unit_test(json_objects),
                                       cmocka_unit_test(names_in_order),
                                       cmocka_unit_test(options),
                                       cmocka_unit_test(outputs_are_whole),
                                       cmocka_unit_test(colours_rise),
                                       cmocka_unit_test(hexagons_drawn_square),
                                       cmocka_unit_test(band_pass_is_the_formula)};

    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, start, finish);
}
