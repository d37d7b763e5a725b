/* SPDX-License-Identifier: MIT
 * Drift of the lattice against the reference, the truth, and in every raw format. */
#include "suite.h"
#include "ref_drift.h"
#include "ref.h"

#define W 300
#define H 260

static uint16_t frame[W * H];
static uint8_t packed[2 * W * H];
static unsigned char blob[4096];
static uint8_t flags[64 * 64];
static uint64_t memory[4096];
static ref_rng rng;

typedef struct drawn { /* how lenses lie and look */
    int hex, nx, ny;
    int left, above; /* columns and rows of the array before the usual first lens */
    double pitch, angle, width; /* px, radians, 1-sigma of a spot */
    double shift_x, shift_y, turn, grow, noise;
} drawn;

static void *workspace(void)
{
    return memory + (PLFX_ALIGN - (uintptr_t)memory % PLFX_ALIGN) % PLFX_ALIGN / 8u;
}

static plfx_lut table(const drawn *d, int bits)
{
    const double c = 4194304.0 * d->pitch * cos(d->angle);
    const double s = 4194304.0 * d->pitch * sin(d->angle);
    const double row = d->hex ? sqrt(0.75) : 1.0;
    plfx_lut_desc desc;
    plfx_lut lut;

    memset(&desc, 0, sizeof desc);
    desc.sensor_w = W;
    desc.sensor_h = H;
    desc.sensor_bits = bits;
    desc.lattice.kind = d->hex ? PLFX_LATTICE_HEX : PLFX_LATTICE_SQUARE;
    desc.lattice.nx = d->nx;
    desc.lattice.ny = d->ny;
    desc.lattice.origin.x_q16 = 22 * 65536 + 20000;
    desc.lattice.origin.y_q16 = 21 * 65536 + 5000;
    desc.lattice.a.x_q22 = (int32_t)lround(c);
    desc.lattice.a.y_q22 = (int32_t)lround(s);
    desc.lattice.b.x_q22 = (int32_t)lround(-row * s);
    desc.lattice.b.y_q22 = (int32_t)lround(row * c);
    desc.lattice.origin.x_q16 -=
        (d->left * desc.lattice.a.x_q22 + d->above * desc.lattice.b.x_q22) / 64;
    desc.lattice.origin.y_q16 -=
        (d->left * desc.lattice.a.y_q22 + d->above * desc.lattice.b.y_q22) / 64;
    desc.lattice.odd.x_q22 = d->hex ? (int32_t)lround(0.5 * c) : 0;
    desc.lattice.odd.y_q22 = d->hex ? (int32_t)lround(0.5 * s) : 0;
    desc.flags = flags;
    assert_true(plfx_lut_bytes(&desc) <= sizeof blob);
    assert_int_equal(plfx_lut_write(&desc, blob, sizeof blob), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, plfx_lut_bytes(&desc)), PLFX_OK);
    return lut;
}

/* Gaussian spots where the table has the lenses, moved; 16 bits. */
static void paint(const drawn *d, const plfx_lut *lut)
{
    const int reach = (int)(4.0 * d->width) + 1;
    int i, j, x, y;

    for (i = 0; i < W * H; i++) {
        frame[i] = (uint16_t)(2000 + ref_range(&rng, 0, 1) +
                              (int)(d->noise * ref_range(&rng, -1000, 1000)));
    }
    for (j = 0; j < d->ny; j++) {
        for (i = 0; i < d->nx; i++) {
            const plfx_point c = plfx_lut_centre(lut, i, j);
            const double tx = c.x_q16 / 65536.0 - 0.5 * (W - 1),
                         ty = c.y_q16 / 65536.0 - 0.5 * (H - 1);
            const double cx =
                c.x_q16 / 65536.0 + d->shift_x + d->grow * tx - d->turn * ty;
            const double cy =
                c.y_q16 / 65536.0 + d->shift_y + d->turn * tx + d->grow * ty;
            for (y = (int)cy - reach; y <= (int)cy + reach; y++) {
                for (x = (int)cx - reach; x <= (int)cx + reach; x++) {
                    const double r2 = (x - cx) * (x - cx) + (y - cy) * (y - cy);
                    if (x >= 0 && y >= 0 && x < W && y < H) {
                        frame[y * W + x] =
                            (uint16_t)(frame[y * W + x] +
                                       40000.0 *
                                           exp(-0.5 * r2 / (d->width * d->width)));
                    }
                }
            }
        }
    }
}

static plfx_raw raw(void)
{
    plfx_raw r = {(const uint8_t *)frame, sizeof frame, PLFX_RAW_U16, 16, W, H};

    return r;
}

static plfx_drift find(const plfx_lut *lut, const plfx_raw *r)
{
    plfx_drift d;

    assert_true(plfx_drift_ws(lut) > 0 && plfx_drift_ws(lut) <= sizeof memory - 64);
    assert_int_equal(plfx_drift_find(lut, r, 512, workspace(), sizeof memory - 64, &d),
                     PLFX_OK);
    return d;
}

static const drawn plain = {0, 18, 15, 0, 0, 14.3, 0.01, 1.7, 0.0, 0.0, 0.0, 0.0, 1.0};

static void within(double value, double want, double tolerance, const char *what)
{
    if (!(fabs(value - want) <= tolerance)) {
        print_message("# %s %.9g, want %.9g, seed %u\n", what, value, want,
                      (unsigned)rng.state);
    }
    assert_true(fabs(value - want) <= tolerance);
}

static void against(const drawn *d)
{
    const plfx_lut lut = table(d, 16);
    plfx_raw r = raw();
    plfx_drift got;
    ref_drift want;

    paint(d, &lut);
    got = find(&lut, &r);
    want = ref_drift_find(&lut, frame, 512);
    assert_int_equal(got.state, PLFX_DRIFT_MEASURED);
    within(got.lenses, want.lenses, 2, "lenses");
    assert_int_equal(got.tried, want.tried);
    within(got.shift_x_q20 / 1048576.0, want.p[0], 3e-4, "x");
    within(got.shift_y_q20 / 1048576.0, want.p[1], 3e-4, "y");
    within(got.rotation_q30 / 1073741824.0, want.p[2], 2e-6, "rotation");
    within(got.scale_q30 / 1073741824.0, want.p[3], 2e-6, "scale");
    within(got.rms_q20 / 1048576.0, want.rms, 5e-4, "rms");
}

static void equals_the_reference(void **state)
{
    int k;

    (void)state;
    rng.state = 2024u;
    for (k = 0; k < 2; k++) {
        drawn d = plain;
        d.hex = k & 1;
        d.pitch = 12.0 + 0.01 * ref_range(&rng, 0, 250);
        d.angle = 0.001 * ref_range(&rng, -20, 20);
        d.width = 1.2 + 0.01 * ref_range(&rng, 0, 150);
        d.shift_x = 0.001 * ref_range(&rng, -2000, 2000);
        d.shift_y = 0.001 * ref_range(&rng, -2000, 2000);
        d.turn = 1e-6 * ref_range(&rng, -2000, 2000);
        d.grow = 1e-6 * ref_range(&rng, -2000, 2000);
        d.ny = d.hex ? 16 : 15;
        against(&d);
    }
}

static void errors_are_as_stated(void **state)
{
    double sum = 0.0;
    int k;

    (void)state;
    rng.state = 7u;
    for (k = 0; k < 8; k++) {
        drawn d = plain;
        plfx_lut lut;
        plfx_raw r = raw();
        plfx_drift got;
        double e[4];
        int i;

        d.shift_x = 0.01 * (1 << k);
        d.shift_y = -0.7 * d.shift_x;
        d.turn = k % 2 ? 4e-4 : 0.0;
        d.grow = k % 3 ? -3e-4 : 0.0;
        lut = table(&d, 16);
        paint(&d, &lut);
        got = find(&lut, &r);
        assert_int_equal(got.state, PLFX_DRIFT_MEASURED);
        e[0] = (got.shift_x_q20 - 1048576.0 * d.shift_x) / got.shift_sigma_q20;
        e[1] = (got.shift_y_q20 - 1048576.0 * d.shift_y) / got.shift_sigma_q20;
        e[2] = (got.rotation_q30 - 1073741824.0 * d.turn) / got.rotation_sigma_q30;
        e[3] = (got.scale_q30 - 1073741824.0 * d.grow) / got.scale_sigma_q30;
        for (i = 0; i < 4; i++) {
            within(e[i], 0.0, 4.0, "error over sigma");
            sum += e[i] * e[i] / 32.0;
        }
    }
    within(sqrt(sum), 1.0, 0.7, "errors over sigma, rms");
}

/* The same pixels in another layout give the same numbers; a mosaic does not show. */
static void format_and_mosaic_do_not_matter(void **state)
{
    drawn d = plain;
    plfx_lut lut;
    plfx_raw r = raw();
    plfx_drift a, b;
    int k;

    (void)state;
    rng.state = 99u;
    d.shift_x = 0.3;
    lut = table(&d, 12);
    paint(&d, &lut);
    for (k = 0; k < W * H; k++) {
        frame[k] = (uint16_t)(frame[k] >> 4);
    }
    r.bits = 12;
    a = find(&lut, &r);
    for (k = 0; k < W * H; k += 2) {
        packed[k / 2 * 3] = (uint8_t)(frame[k] & 255);
        packed[k / 2 * 3 + 1] = (uint8_t)((frame[k] >> 8) | ((frame[k + 1] & 15) << 4));
        packed[k / 2 * 3 + 2] = (uint8_t)(frame[k + 1] >> 4);
    }
    r.bytes = packed;
    r.format = PLFX_RAW_MONO12P;
    b = find(&lut, &r);
    assert_memory_equal(&a, &b, sizeof a);
    for (k = 0; k < W * H; k++) {
        frame[k] = (uint16_t)(frame[k] * ((k % W + k / W) % 2 ? 3 : 2) / 3);
    }
    r = raw();
    r.bits = 12;
    b = find(&lut, &r);
    within(b.shift_x_q20 / 1048576.0, a.shift_x_q20 / 1048576.0, 0.002, "mosaic");
    assert_true(b.lenses == b.tried);
}

static void what_is_no_lattice_is_told_apart(void **state)
{
    drawn d = plain;
    plfx_lut lut = table(&d, 16);
    plfx_raw r = raw();
    plfx_drift got;
    int k;

    (void)state;
    rng.state = 5u;
    for (k = 0; k < W * H; k++) {
        frame[k] = 30000;
    }
    assert_int_equal(find(&lut, &r).state, PLFX_DRIFT_FLAT);
    for (k = 0; k < W * H; k++) {
        frame[k] = (uint16_t)ref_range(&rng, 0, 65535);
    }
    got = find(&lut, &r);
    assert_int_equal(got.state, PLFX_DRIFT_DISAGREE);
    assert_int_equal(got.shift_sigma_q20, 0);
    paint(&d, &lut);
    d.pitch = 12.9; /* another camera */
    lut = table(&d, 16);
    assert_int_equal(find(&lut, &r).state, PLFX_DRIFT_DISAGREE);
    d.nx = d.ny = 5;
    lut = table(&d, 16);
    assert_int_equal(find(&lut, &r).state, PLFX_DRIFT_FEW);
    d = plain;
    memset(flags, PLFX_LENS_MISSING, sizeof flags);
    lut = table(&d, 16);
    assert_int_equal(find(&lut, &r).state, PLFX_DRIFT_FEW);
    memset(flags, 0, sizeof flags);
}

/* Columns or rows more on a side of the array: what leaves the frame is not
 * looked at, the rest gives the same drift. */
static void lenses_off_the_frame_are_left_out(void **state)
{
    plfx_raw r = raw();
    int side;

    (void)state;
    for (side = 0; side < 4; side++) {
        drawn d = plain;
        plfx_lut lut;
        plfx_drift got;

        rng.state = 11u;
        d.shift_x = 0.21;
        d.shift_y = -0.13;
        d.left = side == 0 ? 2 : 0;
        d.above = side == 1 ? 2 : 0;
        d.nx += side == 2 ? 3 : d.left;
        d.ny += side == 3 ? 3 : d.above;
        lut = table(&d, 16);
        paint(&d, &lut);
        got = find(&lut, &r);
        assert_int_equal(got.state, PLFX_DRIFT_MEASURED);
        assert_in_range(got.tried, 16 * 13, 18 * 15);
        assert_true(got.tried < (d.nx - 2) * (d.ny - 2));
        within(got.shift_x_q20 / 1048576.0, 0.21, 4.0 * got.shift_sigma_q20 / 1048576.0,
               "x");
        within(got.shift_y_q20 / 1048576.0, -0.13,
               4.0 * got.shift_sigma_q20 / 1048576.0, "y");
    }
}

/* 270 lenses, 64 asked for: every third of every third row. */
static void no_more_lenses_are_tried_than_asked(void **state)
{
    plfx_lut lut = table(&plain, 16);
    plfx_raw r = raw();
    plfx_drift d;

    (void)state;
    rng.state = 3u;
    paint(&plain, &lut);
    assert_int_equal(plfx_drift_find(&lut, &r, 64, workspace(), sizeof memory - 64, &d),
                     PLFX_OK);
    assert_int_equal(d.state, PLFX_DRIFT_MEASURED);
    assert_int_equal(d.tried, 5 * 4);
    assert_int_equal(plfx_drift_find(&lut, &r, 72, workspace(), sizeof memory - 64, &d),
                     PLFX_OK);
    assert_int_equal(d.tried, 8 * 6); /* every second: 9 x 8 of the whole array */
}

/* Stripes have centroids along x alone; sixteen lenses of noise agree in nothing. */
static void stripes_are_flat_and_few_lenses_of_noise_disagree(void **state)
{
    drawn d = plain;
    plfx_lut lut = table(&d, 16);
    plfx_raw r = raw();
    plfx_drift got;
    int k;

    (void)state;
    d.angle = 0.0;
    lut = table(&d, 16);
    for (k = 0; k < W * H; k++) {
        frame[k] = (uint16_t)(30000 + 20000 * cos(2 * 3.14159265 / d.pitch * (k % W)));
    }
    assert_int_equal(find(&lut, &r).state, PLFX_DRIFT_FLAT);
    d.nx = d.ny = 6;
    lut = table(&d, 16);
    rng.state = 17u;
    for (k = 0; k < W * H; k++) {
        frame[k] = (uint16_t)ref_range(&rng, 0, 65535);
    }
    got = find(&lut, &r);
    assert_int_equal(got.state, PLFX_DRIFT_DISAGREE);
    assert_int_equal(got.tried, 16);
    assert_true(got.lenses < 16);
}

/* One random picture in every lens has no centre to settle on: the lattice wanders. */
static void pictures_without_a_centre_disagree(void **state)
{
    drawn d = plain;
    plfx_raw r = raw();
    plfx_lut lut;
    int wandered = 0;
    int n;

    (void)state;
    d.pitch = 14.0;
    d.angle = 0.0;
    lut = table(&d, 16);
    rng.state = 23u;
    for (n = 0; n < 6; n++) {
        uint16_t lens[14 * 14];
        plfx_drift got;
        int k;

        for (k = 0; k < 14 * 14; k++) {
            lens[k] = (uint16_t)ref_range(&rng, 20000, 40000);
        }
        for (k = 0; k < W * H; k++) {
            frame[k] = lens[k / W % 14 * 14 + k % W % 14];
        }
        got = find(&lut, &r);
        if (2 * got.lenses >= got.tried) {
            wandered += got.state == PLFX_DRIFT_DISAGREE;
        }
    }
    assert_true(wandered > 0);
}

static void dead_and_hot_lenses_do_not_pull(void **state)
{
    drawn d = plain;
    plfx_lut lut = table(&d, 16);
    plfx_raw r = raw();
    plfx_drift got;
    int k;

    (void)state;
    rng.state = 31u;
    d.shift_x = 0.05;
    paint(&d, &lut);
    for (k = 0; k < W * H / 200; k++) { /* half a percent of the pixels */
        frame[ref_range(&rng, 0, W * H - 1)] = 65535;
    }
    for (k = 0; k < H; k++) { /* a dark strip */
        memset(&frame[k * W + 40], 0, 30 * sizeof frame[0]);
    }
    got = find(&lut, &r);
    assert_int_equal(got.state, PLFX_DRIFT_MEASURED);
    assert_true(got.lenses < got.tried);
    within((got.shift_x_q20 / 1048576.0 - 0.05) / (got.shift_sigma_q20 / 1048576.0),
           0.0, 4.0, "error over sigma");
    within(got.shift_x_q20 / 1048576.0, 0.05, 0.02, "shift");
}

static void arguments_are_checked(void **state)
{
    plfx_lut lut = table(&plain, 16);
    plfx_raw r = raw(), bad;
    plfx_drift d, before;
    size_t n = plfx_drift_ws(&lut);

    (void)state;
    memset(&d, 0x55, sizeof d);
    before = d;
    assert_int_equal(plfx_drift_find(NULL, &r, 512, workspace(), n, &d), PLFX_E_ARG);
    assert_int_equal(plfx_drift_find(&lut, NULL, 512, workspace(), n, &d), PLFX_E_ARG);
    assert_int_equal(plfx_drift_find(&lut, &r, 512, NULL, n, &d), PLFX_E_ARG);
    assert_int_equal(plfx_drift_find(&lut, &r, 512, workspace(), n, NULL), PLFX_E_ARG);
    assert_int_equal(
        plfx_drift_find(&lut, &r, PLFX_DRIFT_LENSES_MIN - 1, workspace(), n, &d),
        PLFX_E_ARG);
    assert_int_equal(
        plfx_drift_find(&lut, &r, PLFX_DRIFT_LENSES_MAX + 1, workspace(), n, &d),
        PLFX_E_ARG);
    bad = r;
    bad.w--;
    assert_int_equal(plfx_drift_find(&lut, &bad, 512, workspace(), n, &d), PLFX_E_ARG);
    bad = r;
    bad.h--;
    assert_int_equal(plfx_drift_find(&lut, &bad, 512, workspace(), n, &d), PLFX_E_ARG);
    bad = r;
    bad.bytes = NULL;
    assert_int_equal(plfx_drift_find(&lut, &bad, 512, workspace(), n, &d), PLFX_E_ARG);
    bad = r;
    bad.bits = 7;
    assert_int_equal(plfx_drift_find(&lut, &bad, 512, workspace(), n, &d), PLFX_E_ARG);
    bad = r;
    bad.bits = 17;
    assert_int_equal(plfx_drift_find(&lut, &bad, 512, workspace(), n, &d), PLFX_E_ARG);
    bad = r;
    bad.format = PLFX_RAW_FORMATS;
    assert_int_equal(plfx_drift_find(&lut, &bad, 512, workspace(), n, &d), PLFX_E_ARG);
    bad = r;
    bad.size--;
    assert_int_equal(plfx_drift_find(&lut, &bad, 512, workspace(), n, &d), PLFX_E_SIZE);
    assert_int_equal(plfx_drift_find(&lut, &r, 512, workspace(), n - 1, &d),
                     PLFX_E_SIZE);
    assert_int_equal(plfx_drift_find(&lut, &r, 512, (char *)workspace() + 8, n, &d),
                     PLFX_E_SIZE);
    assert_int_equal(plfx_drift_ws(NULL), 0);
    lut.lattice.a.x_q22 = 300 << 22;
    lut.lattice.b.y_q22 = 300 << 22;
    assert_int_equal(plfx_drift_ws(&lut), 0);
    assert_int_equal(plfx_drift_find(&lut, &r, 512, workspace(), n, &d), PLFX_E_RANGE);
    assert_memory_equal(&d, &before, sizeof d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equals_the_reference),
        cmocka_unit_test(errors_are_as_stated),
        cmocka_unit_test(format_and_mosaic_do_not_matter),
        cmocka_unit_test(what_is_no_lattice_is_told_apart),
        cmocka_unit_test(lenses_off_the_frame_are_left_out),
        cmocka_unit_test(no_more_lenses_are_tried_than_asked),
        cmocka_unit_test(stripes_are_flat_and_few_lenses_of_noise_disagree),
        cmocka_unit_test(pictures_without_a_centre_disagree),
        cmocka_unit_test(dead_and_hot_lenses_do_not_pull),
        cmocka_unit_test(arguments_are_checked),
    };

    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
