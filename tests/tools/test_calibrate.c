/* SPDX-License-Identifier: MIT
 * Lattice conventions, ordering, frames into one picture, gains, drift. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bench/draw.h"
#include "calib/calib.h"
#include "calib/drift.h"
#include "calib/order.h"
#include "calib/save.h"
#include "plenofix/lut.h"

static const draw_spec plain = {DRAW_DOTS, 0,   22,    18,  13.0, 0.4, 20.3, 19.7, 1.5,
                                8,         0.8, 0.004, 0.0, 0.0,  0.0, 1.0,  0.0,  5,
                                0.0,       0.0, 0.0,   0.0, 0.0,  0.0, 0.0};

static unsigned seed = 12345u;

static double noise(void) /* -1 .. 1 */
{
    seed = seed * 1664525u + 1013904223u;
    return (double)(seed >> 8) / 8388608.0 - 1.0;
}

/* Calibrate a drawn frame; the frame's pixels go to `grey`. */
static int calibrate(const draw_spec *s, draw_frame *f, plft_grey *g, plft_calib *c)
{
    const plft_calib_options o = {PLFT_LATTICE_AUTO, 0.0, 1};

    draw(f, s);
    plft_grey_take(g, f->px, f->w, f->h, s->bits);
    f->px = NULL;
    plft_grey_finish(g, NULL);
    plft_grey_drop_hot(g);
    return plft_calibrate(c, g, &o);
}

static void release(draw_frame *f, plft_grey *g, plft_calib *c)
{
    draw_free(f);
    plft_grey_free(g);
    plft_calib_free(c);
}

static void basis_reduces_to_the_shortest(void **state)
{
    plft_vec a = {130.0, 3.0}, b = {117.1, 14.2};
    plft_lattice l;

    (void)state;
    plft_basis_reduce(&a, &b); /* 12.9 x -11.2 steps apart, then (13,0)-like ones */
    assert_true(hypot(a.x, a.y) <= hypot(b.x, b.y) + 1e-9);
    assert_true(fabs(a.x * b.x + a.y * b.y) <= 0.5 * (a.x * a.x + a.y * a.y) + 1e-9);
    a.x = 0.0;
    a.y = 14.0;
    b.x = 14.0 * sqrt(0.75);
    b.y = 7.0;
    assert_int_equal(plft_lattice_orient(a, b, PLFT_LATTICE_AUTO, &l), 0);
    assert_int_equal(l.kind, PLFX_LATTICE_HEX);
    assert_int_equal(l.turned, 1);
    assert_true(l.a.y > 13.9 && l.b.x < -12.0 && fabs(l.b.y) < 1e-9);
    assert_int_equal(plft_lattice_orient(a, b, PLFX_LATTICE_SQUARE, &l), -1);
}

static void nearest_lens_is_found(void **state)
{
    plft_lattice l;
    plft_vec a = {10.0, 0.5}, b = {4.8, 8.7};
    int i, j, k;

    (void)state;
    assert_int_equal(plft_lattice_orient(a, b, PLFT_LATTICE_AUTO, &l), 0);
    for (k = 0; k < 200; k++) {
        const int i0 = k % 14 - 7, j0 = k / 14 - 7;
        plft_vec p = plft_lattice_at(&l, i0, j0);
        p.x += 3.0 * noise();
        p.y += 3.0 * noise();
        plft_lattice_nearest(&l, p, &i, &j);
        assert_int_equal(i, i0);
        assert_int_equal(j, j0);
    }
}

/* Points of a distorted hexagonal lattice with holes, shuffled. */
static void order_survives_distortion_and_holes(void **state)
{
    enum { NX = 41, NY = 33 };
    static double xy[2 * NX * NY];
    static int place[NX * NY];
    plft_order o;
    int n = 0, k;

    (void)state;
    for (k = 0; k < NX * NY; k++) {
        const double u = k % NX + (k / NX % 2 != 0 ? 0.5 : 0.0),
                     v = k / NX * sqrt(0.75);
        const double r2 = (u - 20) * (u - 20) + (v - 14) * (v - 14);
        if (k != 0 && k != NX - 1 &&
            (k % 17 == 3 || (u > 10 && u < 14 && v > 6 && v < 9))) {
            continue;
        }
        xy[2 * n] = 100 + 12.0 * (u - 20) * (1 - 3e-5 * r2) + 0.5 * noise();
        xy[2 * n + 1] = 100 + 12.0 * (v - 14) * (1 - 3e-5 * r2) + 0.5 * noise();
        place[n++] = k;
    }
    for (k = n - 1; k > 0; k--) {
        const int q = (int)((noise() + 1.0) * 0.49999 * (k + 1));
        const double x = xy[2 * k], y = xy[2 * k + 1];
        const int p = place[k];
        xy[2 * k] = xy[2 * q];
        xy[2 * k + 1] = xy[2 * q + 1];
        place[k] = place[q];
        xy[2 * q] = x;
        xy[2 * q + 1] = y;
        place[q] = p;
    }
    assert_int_equal(plft_order_points(xy, n, PLFT_LATTICE_AUTO, &o), 0);
    assert_int_equal(o.placed, n);
    assert_int_equal(o.lattice.kind, PLFX_LATTICE_HEX);
    assert_int_equal(o.lattice.nx, NX);
    assert_int_equal(o.lattice.ny, NY);
    for (k = 0; k < n; k++) {
        assert_int_equal(o.col[k], place[k] % NX);
        assert_int_equal(o.row[k], place[k] / NX);
    }
    plft_order_free(&o);
}

static void order_refuses_disorder(void **state)
{
    static double xy[2 * 400];
    plft_order o;
    int k;

    (void)state;
    for (k = 0; k < 800; k++) {
        xy[k] = 500.0 * noise();
    }
    assert_int_equal(plft_order_points(xy, 400, PLFT_LATTICE_AUTO, &o), -1);
    assert_int_equal(plft_order_points(xy, 8, PLFT_LATTICE_AUTO, &o), -1);
}

static void straight_columns_are_turned(void **state)
{
    draw_spec s = plain;
    draw_frame f;
    plft_grey g;
    plft_calib c;
    int k;

    (void)state;
    s.hex = 1;
    s.rotation = 91.0;
    assert_int_equal(calibrate(&s, &f, &g, &c), 0);
    assert_int_equal(c.lattice.turned, 1);
    assert_int_equal(c.lattice.nx, s.nx);
    assert_int_equal(c.lattice.ny, s.ny);
    assert_true(fabs(plft_lattice_rotation(&c.lattice) - 1.0) < 0.002);
    for (k = 0; k < f.lenses; k++) { /* same order: a points down, b to the left */
        assert_true(hypot(c.final[k].x - f.xy[2 * k], c.final[k].y - f.xy[2 * k + 1]) <
                    0.01);
    }
    release(&f, &g, &c);
}

/* Mean of frames, dark level and mosaic leave the centres where they are. */
static void frames_dark_and_mosaic(void **state)
{
    const plft_calib_options o = {PLFT_LATTICE_AUTO, 0.0, 1};
    draw_spec s = plain;
    draw_frame f[3];
    uint16_t *dark;
    plft_grey g;
    plft_calib c;
    int k, q, n;

    (void)state;
    memset(&g, 0, sizeof g);
    s.bits = 12;
    for (q = 0; q < 3; q++) {
        s.seed = 40u + (unsigned)q;
        draw(&f[q], &s);
        n = f[q].w * f[q].h;
        for (k = 0; k < n; k++) { /* a strong mosaic and a dark level */
            const int odd = (k % f[q].w + k / f[q].w) % 2;
            f[q].px[k] = (uint16_t)(300 + f[q].px[k] * (odd ? 5 : 9) / 10);
        }
        assert_int_equal(plft_grey_add(&g, f[q].px, f[q].w, f[q].h, 12), 0);
    }
    dark = malloc((size_t)(f[0].w * f[0].h) * sizeof *dark);
    for (k = 0; k < f[0].w * f[0].h; k++) {
        dark[k] = 300;
    }
    assert_int_equal(plft_grey_add(&g, f[0].px, f[0].w - 1, f[0].h, 12), -1);
    assert_int_equal(plft_grey_finish(&g, dark), 0);
    assert_int_equal(plft_grey_is_mosaic(&g), 1);
    plft_grey_merge_mosaic(&g);
    assert_int_equal(plft_calibrate(&c, &g, &o), 0);
    assert_int_equal(c.found, f[0].lenses);
    for (k = 0; k < f[0].lenses; k++) {
        assert_true(hypot(c.final[k].x - f[0].xy[2 * k],
                          c.final[k].y - f[0].xy[2 * k + 1]) < 0.01);
    }
    free(dark);
    for (q = 1; q < 3; q++) {
        draw_free(&f[q]);
    }
    release(&f[0], &g, &c);
}

/* The table's gains times the white frame give one level at the middle of the
 * lenses. */
static void gains_flatten_a_white_frame(void **state)
{
    draw_spec s = plain;
    draw_frame f;
    plft_grey g;
    plft_calib c;
    plft_saved saved;
    plfx_lut lut;
    uint8_t *blob;
    uint16_t gain[64];
    size_t bytes;
    double lo = 1e9, hi = 0.0;
    int i, j;

    (void)state;
    s.spot = DRAW_FLAT;
    s.gradient = 3.0;
    s.noise = 0.0;
    s.bits = 12;
    assert_int_equal(calibrate(&s, &f, &g, &c), 0);
    assert_int_equal(c.input, PLFT_INPUT_WHITE);
    assert_int_equal(plft_saved_init(&saved, &c, &g), 0);
    assert_int_equal(plft_saved_gain(&saved, &c, &g), 0);
    bytes = plfx_lut_bytes(&saved.desc);
    blob = malloc(bytes);
    assert_int_equal(plfx_lut_write(&saved.desc, blob, bytes), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, bytes), PLFX_OK);
    for (j = 1; j < lut.lattice.ny - 1; j++) {
        assert_int_equal(plfx_lut_gain_row(&lut, j, 0, 0, gain), PLFX_OK);
        for (i = 1; i < lut.lattice.nx - 1; i++) {
            const plfx_point p = plfx_lut_centre(&lut, i, j);
            const int x = (p.x_q16 + 32768) >> 16, y = (p.y_q16 + 32768) >> 16;
            const double v = (double)g.px[y * g.w + x] * gain[i] / 8192.0;
            lo = fmin(lo, v);
            hi = fmax(hi, v);
        }
    }
    assert_true(hi / lo < 1.03); /* 3:1 before */
    free(blob);
    plft_saved_free(&saved);
    release(&f, &g, &c);
}

/* Light that spreads over lens borders takes the default radius down. */
static void crosstalk_lowers_the_radius(void **state)
{
    double radius[2];
    int k;

    (void)state;
    for (k = 0; k < 2; k++) {
        draw_spec s = plain;
        draw_frame f;
        plft_grey g;
        plft_calib c;
        s.spot = DRAW_FLAT;
        s.pitch = 24.0;
        s.nx = 14;
        s.ny = 12;
        s.spread = k == 0 ? 0.3 : 2.6;
        assert_int_equal(calibrate(&s, &f, &g, &c), 0);
        assert_int_equal(c.input, PLFT_INPUT_WHITE);
        radius[k] = c.usable_radius;
        print_message("# radius %.2f of %.2f, cross-talk %.3f\n", c.usable_radius,
                      c.edge_radius, c.crosstalk);
        if (k == 0) {
            assert_true(fabs(radius[0] - (c.edge_radius - 2.5)) < 1e-9);
        } else { /* a neighbour's straight edge, spread, adds about 2 % there */
            const double off = 24.0 - 0.46 * 24.0 - radius[1];
            const double light = 0.5 * 0.75 * erfc(off / (2.6 * sqrt(2.0)));
            assert_true(radius[1] < c.edge_radius - 2.5 - 0.2);
            assert_true(light < 0.025 && light > 0.002);
        }
        release(&f, &g, &c);
    }
}

static void drift_is_measured(void **state)
{
    draw_spec s = plain;
    draw_frame f;
    plft_grey g;
    plft_calib c;
    plft_saved saved;
    plft_drift d;
    plft_frame frame;
    plfx_lut lut;
    uint8_t *blob;
    size_t bytes;

    (void)state;
    assert_int_equal(calibrate(&s, &f, &g, &c), 0);
    assert_int_equal(plft_saved_init(&saved, &c, &g), 0);
    bytes = plfx_lut_bytes(&saved.desc);
    blob = malloc(bytes);
    assert_int_equal(plfx_lut_write(&saved.desc, blob, bytes), PLFX_OK);
    assert_int_equal(plfx_lut_open(&lut, blob, bytes), PLFX_OK);
    frame.px = g.px;
    frame.w = g.w;
    frame.h = g.h;
    frame.channels = 1;
    frame.bits = 16;
    assert_int_equal(plft_drift_find(&d, &lut, &frame, 1024), 0);
    assert_int_equal(d.moved, 0);
    lut.lattice.origin.x_q16 -= 65536 / 4; /* the table says 1/4 px too far left */
    assert_int_equal(plft_drift_find(&d, &lut, &frame, 1024), 0);
    assert_int_equal(d.moved, 1);
    assert_true(fabs(d.shift_x - 0.25) < 0.002 && fabs(d.shift_y) < 0.002);
    assert_true(fabs(d.shift_x - 0.25) < 4.0 * d.shift_sigma + 1e-4);
    lut.sensor_w++;
    assert_int_equal(plft_drift_find(&d, &lut, &frame, 1024), -1);
    free(blob);
    plft_saved_free(&saved);
    release(&f, &g, &c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(basis_reduces_to_the_shortest),
        cmocka_unit_test(nearest_lens_is_found),
        cmocka_unit_test(order_survives_distortion_and_holes),
        cmocka_unit_test(order_refuses_disorder),
        cmocka_unit_test(straight_columns_are_turned),
        cmocka_unit_test(frames_dark_and_mosaic),
        cmocka_unit_test(gains_flatten_a_white_frame),
        cmocka_unit_test(crosstalk_lowers_the_radius),
        cmocka_unit_test(drift_is_measured),
    };

    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
