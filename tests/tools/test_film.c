/* SPDX-License-Identifier: MIT
 * What a simulated sequence does to its frames: lamp, cable, blur, loss of damping.
 * The light is compared before the sensor, so without noise. */
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

#include "sim/film.h"

#define PI 3.14159265358979323846

static plft_scene scene;
static plft_film film;

/* Open a sequence of a wall at 700 mm, of these objects before it and this motion. */
static void open_film(const char *objects, const char *motion)
{
    char path[64];
    FILE *f;

    (void)snprintf(path, sizeof path, "film_%ld.json", (long)getpid());
    f = fopen(path, "w");
    assert_non_null(f);
    (void)fprintf(f,
                  "{\"seed\": 3, \"rays\": 1, \"frames\": [],"
                  " \"camera\": {\"F_mm\": 50, \"focus_mm\": 500, \"f_mu_mm\": 0.5,"
                  " \"pitch_mm\": 0.125, \"pixel_mm\": 0.0074, \"lenses\": [14, 8]},"
                  " \"objects\": [%s {\"type\": \"plane\", \"z_mm\": 700}],"
                  " \"motion\": {%s}}",
                  objects, motion);
    assert_int_equal(fclose(f), 0);
    assert_int_equal(plft_scene_read(&scene, path), 0);
    assert_int_equal(remove(path), 0);
    assert_int_equal(plft_film_open(&film, &scene, NULL), 0);
}

static void close_film(void)
{
    plft_film_close(&film);
    plft_scene_free(&scene);
}

static plft_instant next_frame(void)
{
    plft_instant truth;

    assert_int_equal(plft_film_next(&film, &truth), 0);
    return truth;
}

static double light(void)
{
    size_t n = (size_t)scene.cam.w * (size_t)scene.cam.h;
    double sum = 0.0;
    size_t k;

    for (k = 0; k < n; k++) {
        sum += film.sum[k];
    }
    return sum;
}

/* Light of the micro-image at lens row 4. */
static double lens_light(int col)
{
    double x, y, sum = 0.0;
    int dx, dy;

    plft_camera_spot(&scene.cam, col, 4, &x, &y);
    for (dy = -4; dy <= 4; dy++) {
        for (dx = -4; dx <= 4; dx++) {
            sum += film.sum[((int)(y + 0.5) + dy) * scene.cam.w + (int)(x + 0.5) + dx];
        }
    }
    return sum;
}

/* Each frame is as bright as the sine says and as the truth tells. */
static void lamp_flickers(void **state)
{
    double still;
    int n;

    (void)state;
    open_film("", "\"rest\": 1, \"frames\": 8, \"rate_hz\": 200, \"flicker\": 0.4,"
                  " \"flicker_hz\": 33");
    assert_true(next_frame().lamp == 1.0);
    still = light();
    for (n = 0; n < 8; n++) {
        double lamp = 1.0 + 0.4 * sin(2.0 * PI * 33.0 * n / 200.0);
        assert_true(fabs(next_frame().lamp - lamp) < 1e-12);
        assert_true(fabs(light() / still - lamp) < 1e-9);
    }
    close_film();
}

/* A black cable at the plane in focus, one lens wide, hides the lens that it stands
 * before and no other; it is where its sway says. */
static void cable_hides_lenses_in_turn(void **state)
{
    double still[14];
    int n;

    (void)state;
    open_film("{\"type\": \"rect\", \"at_mm\": [0, 0, 500], \"size_mm\": [1.2, 60],"
              " \"swing_mm\": [4.5, 0, 0], \"swing_hz\": 10,"
              " \"texture\": {\"pattern\": \"none\", \"mean\": 0.0}},",
              "\"frames\": 10, \"rate_hz\": 100");
    for (n = 0; n < 10; n++) {
        double at = 4.5 * sin(2.0 * PI * 10.0 * n / 100.0); /* mm, at 500 mm */
        double col = at * scene.cam.L / 500.0 / scene.cam.pitch + 6.5;
        int dark = 0;
        int k;
        (void)next_frame();
        for (k = 0; k < 14; k++) {
            still[k] = lens_light(k);
            if (fabs(k - col) > 1.1) {
                assert_true(still[k] > 20.0);
            }
            dark = still[k] < still[dark] ? k : dark;
        }
        if (fabs(dark - col) > 0.7) {
            fail_msg("frame %d: lens %d is dark, the cable is at %.2f", n, dark, col);
        }
        assert_true(still[dark] < 0.6 * still[(dark + 7) % 14]);
    }
    close_film();
}

/* A frame blurred by 4 instants is the mean of four sharp frames at those instants. */
static void blur_is_the_mean_of_its_instants(void **state)
{
    static const char wall[] =
        "{\"type\": \"rect\", \"at_mm\": [0, 0, 500], \"size_mm\": [60, 60],"
        " \"texture\": {\"pattern\": \"speckle\", \"cell_mm\": 1}},";
    double *mean;
    double off = 0.0, moved = 0.0;
    plft_instant truth[5];
    size_t n, k;
    int i;

    (void)state;
    open_film(wall, "\"frames\": 4, \"rate_hz\": 800, \"exposure_s\": 0.00125,"
                    " \"shake_mm\": 2, \"shake_hz\": 60, \"stations\": [[4, 7]]");
    n = (size_t)scene.cam.w * (size_t)scene.cam.h;
    mean = calloc(2 * n, sizeof *mean);
    assert_non_null(mean);
    for (i = 0; i < 4; i++) {
        double shift = plft_motion_pose(&scene.motion, 0.00125 * (i + 0.5)).shift[0];
        truth[i] = next_frame();
        assert_true(fabs(truth[i].pose.shift[0] - shift) < 1e-12);
        for (k = 0; k < n; k++) {
            mean[k] += 0.25 * film.sum[k];
            mean[n + k] = i == 0 ? film.sum[k] : mean[n + k];
        }
    }
    close_film();
    open_film(wall, "\"frames\": 1, \"rate_hz\": 200, \"exposure_s\": 0.005,"
                    " \"blur_steps\": 4, \"shake_mm\": 2, \"shake_hz\": 60,"
                    " \"stations\": [[4, 7]]");
    truth[4] = next_frame();
    for (k = 0; k < n; k++) {
        off += fabs(film.sum[k] - mean[k]);
        moved += fabs(film.sum[k] - mean[n + k]);
    }
    assert_true(off < 1e-9 * (double)n && moved > 0.01 * (double)n);
    for (k = 1; k < 4; k++) { /* columns, rows, slope */
        double sum = truth[0].move[0][k] + truth[1].move[0][k] + truth[2].move[0][k] +
                     truth[3].move[0][k];
        assert_true(fabs(truth[4].move[0][k] - 0.25 * sum) < 1e-12);
    }
    assert_true(fabs(truth[4].time - 0.0025) < 1e-12);
    close_film();
    free(mean);
}

/* Decay of a mode without a force over one second from a place in the record; over it
 * the damping runs from 2 % to 0.5 %. */
static double decay(double part)
{
    plft_motion m;
    double e[2];
    int n;

    memset(&m, 0, sizeof m);
    m.rate = 200.0;
    m.modes = 1;
    m.mode[0].hz = 22.0;
    m.mode[0].damping = 0.02;
    m.mode[0].damping_end = 0.005;
    m.mode[0].x = 1.0;
    for (n = 0; n <= 3200; n++) { /* energy: (w x)^2 + v^2 */
        double w = 2.0 * PI * 22.0;
        if (n == 0 || n == 3200) {
            e[n > 0] = hypot(w * m.mode[0].x, m.mode[0].v);
        }
        plft_motion_step(&m, (uint64_t)n, part);
    }
    return log(e[0] / e[1]) / (2.0 * PI * 22.0);
}

static void damping_runs_down(void **state)
{
    (void)state;
    assert_true(fabs(decay(0.0) - 0.02) < 2e-4);
    assert_true(fabs(decay(0.5) - 0.0125) < 2e-4);
    assert_true(fabs(decay(1.0) - 0.005) < 2e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamp_flickers),
        cmocka_unit_test(cable_hides_lenses_in_turn),
        cmocka_unit_test(blur_is_the_mean_of_its_instants),
        cmocka_unit_test(damping_runs_down),
    };

    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
