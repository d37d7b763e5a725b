/* SPDX-License-Identifier: MIT
 * The ray model against closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sim/motion.h"
#include "sim/rng.h"
#include "sim/sensor.h"
#include "sim/trace.h"

static plft_camera camera(int hex)
{
    plft_camera cam;

    memset(&cam, 0, sizeof cam);
    cam.F = 50.0;
    cam.focus = 480.0;
    cam.pupil_r = 6.8;
    cam.f_mu = 0.5;
    cam.pitch = 0.125;
    cam.pixel = 0.0074;
    cam.rotation = 0.004;
    cam.offset_x = 0.0021;
    cam.fill = 1.0;
    cam.hex = hex;
    cam.nx = 24;
    cam.ny = 15;
    assert_int_equal(plft_camera_ready(&cam, 7), 0);
    return cam;
}

/* A frontal plane at depth z without end. */
static plft_world plane(double z, plft_texture *texture)
{
    static plft_quad quad;
    plft_world world = {&quad, 1, texture, 1, 0.0};

    memset(&quad, 0, sizeof quad);
    quad.o[2] = z;
    quad.e1[0] = quad.e2[1] = 1.0;
    quad.id = 1;
    plft_quad_ready(&quad);
    return world;
}

/* Material point seen by the middle ray of lens point `a` for a pixel u, v beside its
 * micro-image centre. */
static plft_hit seen(const plft_camera *cam, const plft_world *world, double ax,
                     double ay, double u, double v)
{
    double k = 1.0 + cam->f_mu / cam->L;
    plft_ray ray = plft_trace_ray(cam, ax, ay, ax, ay, ax * k + u * cam->pixel,
                                  ay * k + v * cam->pixel);

    return plft_world_trace(world, &ray);
}

/* What (0,0) sees at c is seen at offset (u,v) by a lens D*P*(u,v) away. */
static void plane_has_its_slope(void **state)
{
    plft_camera cam = camera(0);
    double depth[] = {300.0, 400.0, 480.0, 700.0, 2000.0};
    int k;

    (void)state;
    for (k = 0; k < 5; k++) {
        plft_texture none = {0, 0, 1.0, 0.5, NULL};
        plft_world world = plane(depth[k], &none);
        double d = plft_camera_slope(&cam, depth[k]) * cam.pitch;
        plft_hit here = seen(&cam, &world, 0.8, -0.3, 0.0, 0.0);
        plft_hit there = seen(&cam, &world, 0.8 + 5.0 * d, -0.3 - 3.0 * d, 5.0, -3.0);
        assert_true(fabs(here.a - there.a) < 1e-9 && fabs(here.b - there.b) < 1e-9);
        assert_true(fabs(here.z - depth[k]) < 1e-9);
    }
    assert_true(plft_camera_slope(&cam, 300.0) < 0.0);
    assert_true(fabs(plft_camera_slope(&cam, 480.0)) < 1e-12);
    plft_camera_free(&cam);
}

/* Bilinear sample of a frame. */
static double sample(const double *frame, int w, double x, double y)
{
    int ix = (int)floor(x);
    int iy = (int)floor(y);
    double fx = x - ix;
    double fy = y - iy;
    const double *p = frame + (size_t)iy * (size_t)w + ix;

    return (p[0] * (1 - fx) + p[1] * fx) * (1 - fy) +
           (p[w] * (1 - fx) + p[w + 1] * fx) * fy;
}

/* Least-squares shift in lenses between the views at -u and +u: two refinements of
 * sum(gradient*difference)/sum(gradient^2) about the middle of the lens row. */
static double measured_slope(const plft_camera *cam, const double *frame, double u)
{
    double num = 0.0;
    double den = 0.0;
    int i, j;

    for (j = 2; j < cam->ny - 2; j++) {
        for (i = 2; i < cam->nx - 2; i++) {
            double v[3][2]; /* lens i-1, i, i+1 at -u and +u */
            int k, side;
            for (k = 0; k < 3; k++) {
                for (side = 0; side < 2; side++) {
                    double x, y;
                    plft_camera_spot(cam, i + k - 1, j, &x, &y);
                    v[k][side] = sample(frame, cam->w, x + (side ? u : -u), y);
                }
            }
            {
                double g = 0.25 * (v[2][0] - v[0][0] + v[2][1] - v[0][1]);
                num -= g * (v[1][1] - v[1][0]);
                den += g * g;
            }
        }
    }
    return num / den / (2.0 * u);
}

static void frame_has_its_slope(void **state)
{
    plft_camera cam = camera(0);
    plft_texture_desc desc = {.pattern = PLFT_PATTERN_NOISE,
                              .mean = 0.5,
                              .contrast = 0.15,
                              .cell_mm = 9.0,
                              .octaves = 1,
                              .persistence = 1.0,
                              .seed = 3};
    plft_texture texture;
    double depth[] = {430.0, 480.0, 540.0};
    size_t n = (size_t)cam.w * (size_t)cam.h;
    double *frame = malloc(n * sizeof *frame);
    double *white = malloc(n * sizeof *white);
    size_t i;
    int k;

    (void)state;
    assert_non_null(frame);
    assert_non_null(white);
    assert_int_equal(plft_texture_make(&texture, &desc, 0.25, 256), 0);
    for (k = 0; k < 3; k++) {
        plft_world world = plane(depth[k], &texture);
        plft_trace t = {&cam, &world, NULL, cam.pupil_r, 2, 0, {1.0, 1.0, 1.0}};
        double want = plft_camera_slope(&cam, depth[k]);
        double got;
        assert_int_equal(plft_trace_frame(&t, frame), 0);
        t.world = NULL;
        assert_int_equal(plft_trace_frame(&t, white), 0);
        for (i = 0; i < n; i++) {
            frame[i] /= white[i] > 0.5 ? white[i] : 1.0;
        }
        got = measured_slope(&cam, frame, 3.0);
        if (fabs(got - want) > 0.004) {
            fail_msg("depth %g: slope %g, want %g", depth[k], got, want);
        }
    }
    plft_texture_free(&texture);
    plft_camera_free(&cam);
    free(frame);
    free(white);
}

/* All light of the pupil falls into the micro-image: area and centre, on both lattices.
 * The centroid of a hard disc sampled by pixels strays by 0.01 px. */
static void micro_image_is_the_pupil(void **state)
{
    int hex;

    (void)state;
    for (hex = 0; hex < 2; hex++) {
        plft_camera cam = camera(hex);
        plft_trace t = {&cam, NULL, NULL, 2.0, 1, 0, {1.0, 1.0, 1.0}};
        double r = 2.0 * cam.f_mu / (cam.L * cam.pixel);
        double x, y, sum = 0.0, mx = 0.0, my = 0.0;
        int dx, dy;
        plft_camera_spot(&cam, 3, 4, &x, &y);
        for (dy = -7; dy <= 7; dy++) {
            for (dx = -7; dx <= 7; dx++) {
                int px = (int)floor(x + 0.5) + dx;
                int py = (int)floor(y + 0.5) + dy;
                double v = plft_trace_pixel(&t, px, py);
                sum += v;
                mx += v * px;
                my += v * py;
            }
        }
        assert_true(fabs(sum / (3.14159265358979 * r * r) - 1.0) < 0.02);
        assert_true(fabs(mx / sum - x) < 0.015 && fabs(my / sum - y) < 0.015);
        plft_camera_free(&cam);
    }
}

/* A pupil larger than the pitch sends light under the neighbours. */
static void wide_pupil_overlaps(void **state)
{
    plft_camera cam = camera(0);
    plft_trace t = {&cam, NULL, NULL, 0.0, 1, 0, {1.0, 1.0, 1.0}};
    double x, y;

    (void)state;
    plft_camera_spot(&cam, 11, 7, &x, &y);
    t.pupil_r = 1.25 * 0.5 * cam.pitch * cam.L / cam.f_mu;
    assert_true(plft_trace_pixel(&t, (int)(x + 8.5), (int)y) > 1.9);
    t.pupil_r = 0.85 * 0.5 * cam.pitch * cam.L / cam.f_mu;
    assert_true(plft_trace_pixel(&t, (int)(x + 8.5), (int)y) < 0.1);
    plft_camera_free(&cam);
}

/* The box mean of a texture against the sum of finer ones. */
static void texture_box_is_a_mean(void **state)
{
    plft_texture_desc desc = {.pattern = PLFT_PATTERN_SPECKLE,
                              .mean = 0.5,
                              .contrast = 0.3,
                              .cell_mm = 2.0,
                              .octaves = 1,
                              .persistence = 1.0,
                              .seed = 5};
    plft_texture t;
    double part = 0.0;
    int i, j;

    (void)state;
    assert_int_equal(plft_texture_make(&t, &desc, 0.25, 64), 0);
    for (j = 0; j < 4; j++) {
        for (i = 0; i < 4; i++) {
            part +=
                plft_texture_box(&t, -3.1 + 0.4 * i, 21.7 + 0.3 * j, 0.4, 0.3) / 16.0;
        }
    }
    assert_true(fabs(part - plft_texture_box(&t, -2.5, 22.15, 1.6, 1.2)) < 1e-9);
    assert_true(fabs(plft_texture_box(&t, 1.0, 2.0, 0.7, 0.7) -
                     plft_texture_box(&t, 17.0, -14.0, 0.7, 0.7)) < 1e-9);
    plft_texture_free(&t);
}

static void nearest_surface_hides_the_rest(void **state)
{
    plft_texture none = {0, 0, 1.0, 0.5, NULL};
    plft_quad quads[2];
    plft_world world = {quads, 2, &none, 1, 0.0};
    plft_ray ray = {0.0, 0.0, 0.01, 0.0};

    (void)state;
    memset(quads, 0, sizeof quads);
    quads[0].o[2] = 500.0;
    quads[1].o[2] = 400.0;
    quads[1].w = quads[1].h = 3.0; /* covers X = 0 .. 3 */
    quads[0].e1[0] = quads[0].e2[1] = quads[1].e1[0] = quads[1].e2[1] = 1.0;
    plft_quad_ready(&quads[0]);
    plft_quad_ready(&quads[1]);
    assert_ptr_equal(plft_world_trace(&world, &ray).quad, &quads[0]);
    ray.dx = 0.005;
    assert_ptr_equal(plft_world_trace(&world, &ray).quad, &quads[1]);
}

/* Mean and variance of the counts of an even field. */
static void noise_is_as_stated(void **state)
{
    enum { N = 40000 };
    static double signal[N];
    static uint16_t counts[N];
    plft_sensor s = {12, 20000.0, 10.0, 100.0, 0.0, 0.8};
    double scale = 3995.0 / 20000.0;
    double want = (0.5 * 0.8 * 20000.0 + 100.0) * scale * scale + 1.0 / 12.0;
    double sum = 0.0, square = 0.0;
    int i;

    (void)state;
    for (i = 0; i < N; i++) {
        signal[i] = 0.5;
    }
    plft_sensor_expose(&s, signal, NULL, N, 3, 1, counts);
    for (i = 0; i < N; i++) {
        sum += counts[i] - 1698.0;
        square += (counts[i] - 1698.0) * (counts[i] - 1698.0);
    }
    assert_true(fabs(sum / N) < 1.0);
    assert_true(fabs(square / N / want - 1.0) < 0.03);
}

/* The steady state of a mode: rms, and period by the sign changes of q. */
static void mode_has_its_rms_and_frequency(void **state)
{
    enum { N = 400000 };
    plft_motion m;
    double square = 0.0, last = 0.0;
    int n, crossings = 0;

    (void)state;
    memset(&m, 0, sizeof m);
    m.rate = 200.0;
    m.modes = 1;
    m.mode[0].hz = 22.0;
    m.mode[0].damping = m.mode[0].damping_end = 0.03;
    m.mode[0].rms = 1.5;
    m.seed = 9;
    plft_motion_start(&m, 2.0);
    for (n = 0; n < N; n++) {
        plft_motion_step(&m, (uint64_t)n, 0.0);
        square += m.mode[0].x * m.mode[0].x;
        crossings += m.mode[0].x * last < 0.0;
        last = m.mode[0].x;
    }
    assert_true(fabs(sqrt(square / N) / 1.5 - 1.0) < 0.08);
    assert_true(fabs(crossings / (2.0 * N / 3200.0) / 22.0 - 1.0) < 0.01);
}

/* Ring-down of the exact transition against the formula. */
static void ring_down_is_exact(void **state)
{
    plft_motion m;
    double w = 2.0 * 3.14159265358979 * 5.0, z = 0.02, t = 0.0;
    double wd = w * sqrt(1.0 - z * z);
    int n;

    (void)state;
    memset(&m, 0, sizeof m);
    m.rate = 50.0;
    m.modes = 1;
    m.mode[0].hz = 5.0;
    m.mode[0].damping = m.mode[0].damping_end = z;
    m.mode[0].x = 2.0;
    for (n = 0; n < 500; n++) {
        plft_motion_step(&m, (uint64_t)n, 0.0);
        t = (n + 1) / 800.0;
    }
    t = 2.0 * exp(-z * w * t) * (cos(wd * t) + z * w / wd * sin(wd * t));
    assert_true(fabs(m.mode[0].x - t) < 1e-9);
}

static void wing_bends_towards_the_camera(void **state)
{
    plft_texture none = {0, 0, 1.0, 0.5, NULL};
    plft_world world = plane(500.0, &none);
    plft_bend bend = {100.0, 30.0, {3.0, -1.0, 0.5}};
    plft_ray ray = {2.0, 0.0, 0.19, 0.05}; /* meets the plane at (97, 25) */
    plft_hit hit;
    double lift;

    (void)state;
    world.quad->w = 100.0;
    world.quad->h = 30.0;
    world.quad->bend = &bend;
    hit = plft_world_trace(&world, &ray);
    lift = plft_bend_at(&bend, hit.a, hit.b);
    assert_ptr_equal(hit.quad, world.quad);
    assert_true(fabs(hit.z - (500.0 - lift)) < 1e-9);
    assert_true(fabs(hit.a - (2.0 + 0.19 * hit.z)) < 1e-9);
    assert_true(fabs(plft_bend_at(&bend, 100.0, 15.0) - 2.0) < 1e-6);
    assert_true(fabs(plft_bend_at(&bend, 0.0, 30.0)) < 1e-9);
    assert_true(fabs(plft_bend_at(&bend, 100.0, 30.0) - 2.5) < 1e-6);
}

/* A point on a ray of the moved camera is on the ray of the camera at rest. */
static void pose_and_its_inverse(void **state)
{
    plft_pose pose = {{0.5, -0.3, 0.8}, {0.001, -0.002, 0.0015}};
    plft_ray ray = {1.0, -2.0, 0.05, 0.03};
    plft_ray seen = plft_pose_ray(&pose, &ray);
    double world[3] = {seen.px + 450.0 * seen.dx, seen.py + 450.0 * seen.dy, 450.0};
    double at[3];

    (void)state;
    plft_pose_inverse(&pose, world, at);
    assert_true(fabs(at[0] - (ray.px + at[2] * ray.dx)) < 1e-9);
    assert_true(fabs(at[1] - (ray.py + at[2] * ray.dy)) < 1e-9);
}

/* The same draws on every machine. */
static void draws_are_fixed(void **state)
{
    (void)state;
    assert_true(plft_mix(0) == 0xE220A8397B1DCDAFu);
    assert_true(plft_gauss(plft_key(1, 2, 3)) == plft_gauss(plft_key(1, 2, 3)));
    assert_true(plft_key(1, 2, 3) != plft_key(1, 3, 3));
    assert_int_equal(plft_bayer_colour(PLFT_BAYER_GRBG, 1, 0), 0);
    assert_int_equal(plft_bayer_colour(PLFT_BAYER_BGGR, 0, 0), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plane_has_its_slope),
        cmocka_unit_test(frame_has_its_slope),
        cmocka_unit_test(micro_image_is_the_pupil),
        cmocka_unit_test(wide_pupil_overlaps),
        cmocka_unit_test(texture_box_is_a_mean),
        cmocka_unit_test(nearest_surface_hides_the_rest),
        cmocka_unit_test(noise_is_as_stated),
        cmocka_unit_test(mode_has_its_rms_and_frequency),
        cmocka_unit_test(ring_down_is_exact),
        cmocka_unit_test(wing_bends_towards_the_camera),
        cmocka_unit_test(pose_and_its_inverse),
        cmocka_unit_test(draws_are_fixed),
    };

    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
