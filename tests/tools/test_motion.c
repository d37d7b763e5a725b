/* SPDX-License-Identifier: MIT
 * Where regions are proposed, and how modes are kept apart. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "motion/pick.h"
#include "motion/thin.h"
#include "plenofix/modal.h"

#define COLS  80
#define ROWS  10
#define LEFT  7
#define UPPER 6
#define PI    3.14159265358979323846

/* A long surface on which a region can lie everywhere; `middle`: how much richer in
 * texture its middle rows are. */
static void surface(plft_pick_places *places, double middle)
{
    int k;

    memset(places, 0, sizeof *places);
    places->list = calloc((size_t)COLS * ROWS, sizeof *places->list);
    assert_non_null(places->list);
    places->n = COLS * ROWS;
    for (k = 0; k < places->n; k++) {
        plft_pick *p = &places->list[k];
        p->i = LEFT + k % COLS;
        p->j = UPPER + k / COLS;
        p->weak = abs(2 * (k / COLS) - ROWS + 1) < ROWS / 2 ? 0.2 * middle : 0.2;
    }
}

static void none_meet(const plft_pick_wish *w, const plft_pick *p, int n)
{
    int a, b;

    for (a = 0; a < n; a++) {
        for (b = 0; b < a; b++) {
            assert_true(abs(p[a].i - p[b].i) >= w->w || abs(p[a].j - p[b].j) >= w->h);
        }
    }
}

/* Both rims and both ends, whatever the number of regions and where texture is best. */
static void regions_cover_a_long_surface(void **state)
{
    static const int wanted[] = {4, 6, 8, 12, 16};
    static const double middle[] = {1.0, 1.5, 2.0};
    size_t c, m;
    (void)state;

    for (c = 0; c < sizeof wanted / sizeof *wanted; c++) {
        for (m = 0; m < sizeof middle / sizeof *middle; m++) {
            plft_pick_wish w = {wanted[c], 9, 7, 0, 0.03};
            plft_pick_places places;
            plft_pick p[PLFX_ROI_MAX];
            int n = 0, upper = 0, lower = 0, left = COLS, right = 0, k;

            surface(&places, middle[m]);
            assert_int_equal(plft_pick_choose(&places, &w, p, &n), 0);
            free(places.list);
            assert_int_equal(n, wanted[c]);
            none_meet(&w, p, n);
            for (k = 0; k < n; k++) {
                upper += p[k].j <= UPPER + 2;
                lower += p[k].j >= UPPER + ROWS - 3;
                left = p[k].i < left ? p[k].i : left;
                right = p[k].i > right ? p[k].i : right;
            }
            assert_true(4 * upper >= n && 4 * lower >= n);
            assert_true(left <= LEFT + 9 && right >= LEFT + COLS - 10);
        }
    }
}

static void one_region_lies_where_texture_is_best(void **state)
{
    plft_pick_wish w = {1, 9, 7, 0, 0.03};
    plft_pick_places places;
    plft_pick p[PLFX_ROI_MAX];
    int n = 0;
    (void)state;

    surface(&places, 1.0);
    places.list[333].weak = 0.25;
    assert_int_equal(plft_pick_choose(&places, &w, p, &n), 0);
    assert_int_equal(n, 1);
    assert_true(p[0].i == places.list[333].i && p[0].j == places.list[333].j);
    free(places.list);
}

static void what_the_core_refuses_is_not_proposed_again(void **state)
{
    plft_pick_wish w = {12, 9, 7, 0, 0.03};
    plft_pick_places places;
    plft_pick p[PLFX_ROI_MAX], bad;
    int n = 0, k;
    (void)state;

    surface(&places, 1.0);
    bad = places.list[0];
    plft_pick_avoid(&places, &w, &bad);
    assert_int_equal(places.n, COLS * ROWS - 4 * 3); /* a corner: 0 .. 3, 0 .. 2 */
    assert_int_equal(plft_pick_choose(&places, &w, p, &n), 0);
    assert_int_equal(n, 12);
    for (k = 0; k < n; k++) {
        assert_true(p[k].i > bad.i + 3 || p[k].j > bad.j + 2);
    }
    free(places.list);
}

/* Largest thinned sample of a channel for a mode at `to` that sees a tone at `from`. */
static double passes(double rate, int every, double from, double to)
{
    plfx_modal_cfg c = {(uint32_t)lround(rate * 1000), (uint32_t)lround(to * 1e6),
                        every, 64, 16};
    plfx_modal m;
    double most = 0;
    int k;

    assert_int_equal(plfx_modal_init(&m, &c), PLFX_OK);
    for (k = 0; k < 400 * every; k++) {
        double x = 30000 * sin(2 * PI * from * k / rate);
        if (plfx_modal_push(&m, (int16_t)lround(x)) && k > 40 * every) {
            most = fmax(most, hypot(m.y_re, m.y_im));
        }
    }
    return most;
}

static void leaks_are_those_of_the_core(void **state)
{
    static const double rate = 200.0, to = 22.0;
    int every;
    (void)state;

    for (every = 9; every < 18; every++) {
        double own = passes(rate, every, to, to);
        double want = plft_thin_leak(rate, every, 6.2, to);
        double got = passes(rate, every, 6.2, to) / own;
        assert_true(fabs(got - want) < 0.003 + 0.02 * want);
    }
}

static void thinning_keeps_other_modes_out(void **state)
{
    static const double freq[] = {6.2, 22.0, 38.9, 22.3};
    int plain = plft_thin_every(200.0, &freq[1], 1, 0, 0.012);
    int three = plft_thin_every(200.0, freq, 3, 1, 0.012);
    int four = plft_thin_every(200.0, freq, 4, 1, 0.012);
    (void)state;

    assert_int_equal(plain, plfx_modal_every(200000, 22000000, 12000));
    assert_true(three >= 0.6 * plain && three <= 1.2 * plain);
    assert_true(plft_thin_leak(200.0, three, 6.2, 22.0) < 0.01);
    assert_true(plft_thin_leak(200.0, plain, 6.2, 22.0) > 0.05);
    assert_int_equal(four, three); /* 22.3 Hz is no other mode */
    assert_true(plft_thin_apart(200.0, three, 6.2, 22.0));
    assert_false(plft_thin_apart(200.0, three, 22.3, 22.0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regions_cover_a_long_surface),
        cmocka_unit_test(one_region_lies_where_texture_is_best),
        cmocka_unit_test(what_the_core_refuses_is_not_proposed_again),
        cmocka_unit_test(leaks_are_those_of_the_core),
        cmocka_unit_test(thinning_keeps_other_modes_out),
    };

    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
