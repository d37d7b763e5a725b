/* SPDX-License-Identifier: MIT
 * plfx_winner_row() at every column and row length around its chunks, against the plain
 * definition: first least, least two labels off, equiangular fit. */
#include "suite.h"
#include "frame_state.h"
#include "ref.h"

#define MAX_NX 131
#define LABELS 9
#define ROWS   2
#define SPARE  64 /* read past the last label, as sgm.c leaves it */

static int16_t sum[LABELS * MAX_NX + SPARE];
static int32_t e[ROWS * MAX_NX];
static uint16_t conf[ROWS * MAX_NX];
static uint8_t flags[ROWS * MAX_NX];
static uint64_t work[128];
static plfx_plan plan;

static plfx_frame_state state_of(int32_t nx, int32_t labels, int32_t paths)
{
    plfx_frame_state s;
    plfx_cfg c;

    memset(&s, 0, sizeof s);
    memset(&c, 0, sizeof c);
    c.window = 3;
    c.bits = 8;
    c.n = 2;
    c.at[1].u_q8 = 256;
    c.labels = (uint16_t)labels;
    c.slope_min_q16 = -65536;
    c.slope_max_q16 = -65536 + 32768 * (labels - 1);
    assert_int_equal(plfx_plan_init(&plan, &c, NULL, MAX_NX, 12), PLFX_OK);
    s.plan = &plan;
    s.cfg.paths = (uint8_t)paths;
    s.nx = nx;
    s.ny = ROWS;
    s.kept = ROWS;
    s.labels = labels;
    s.base_q8 = 256;
    s.e_a = e;
    s.conf = conf;
    s.flags = flags;
    return s;
}

/* Half a label is 8 sixteenths; halves away from zero. */
static int32_t fit_q4(int32_t before, int32_t best, int32_t after)
{
    int32_t rise = (before > after ? before : after) - best;
    int32_t twice = rise > 0 ? 16 * (before - after) : 0;

    if (rise <= 0) {
        return 0;
    }
    return twice >= 0 ? (twice + rise) / (2 * rise) : -((-twice + rise) / (2 * rise));
}

static void check_pixel(const plfx_frame_state *s, int32_t x, size_t at)
{
    int32_t best = 0;
    int32_t second = INT16_MAX;
    int32_t least;
    int32_t q4;
    int32_t end;

    for (int32_t l = 1; l < s->labels; l++) {
        best = sum[l * s->nx + x] < sum[best * s->nx + x] ? l : best;
    }
    for (int32_t l = 0; l < s->labels; l++) {
        int32_t v = sum[l * s->nx + x];
        second = (l < best - 1 || l > best + 1) && v < second ? v : second;
    }
    least = sum[best * s->nx + x];
    end = best == 0 || best == s->labels - 1;
    q4 = 16 * best;
    if (!end) {
        q4 += fit_q4(sum[(best - 1) * s->nx + x], least, sum[(best + 1) * s->nx + x]);
    }
    assert_int_equal(e[at], -65536 + 2048 * q4);
    assert_int_equal(conf[at],
                     (uint32_t)(second - least) * 65535u /
                         (uint32_t)(second + 8 * (s->cfg.paths ? s->cfg.paths : 1)));
    assert_int_equal(flags[at], end ? PLFX_FLAG_RANGE_END : 0);
}

static void one_row(ref_rng *rng, int32_t nx, int32_t labels, int32_t top)
{
    plfx_frame_state s = state_of(nx, labels, ref_range(rng, 0, 2) * 4);
    int32_t y = ref_range(rng, 0, ROWS - 1);

    for (int32_t i = 0; i < labels * nx + SPARE; i++) {
        sum[i] = (int16_t)ref_range(rng, 0, top);
    }
    memset(e, 0x5a, sizeof e);
    memset(conf, 0x5a, sizeof conf);
    memset(flags, 0x5a, sizeof flags);
    assert_true(plfx_winner_scratch() <= sizeof work);
    plfx_winner_row(&s, y, sum, work);
    for (int32_t x = 0; x < nx; x++) {
        check_pixel(&s, x, (size_t)(y * nx + x));
    }
    for (int32_t i = 0; i < ROWS * MAX_NX; i++) { /* and nothing else is written */
        if (i < y * nx || i >= (y + 1) * nx) {
            assert_int_equal(flags[i], 0x5a);
            assert_int_equal(conf[i], 0x5a5a);
        }
    }
}

static void every_column_is_judged(void **state)
{
    ref_rng rng = {9};

    (void)state;
    for (int32_t nx = 1; nx <= MAX_NX; nx++) {
        one_row(&rng, nx, ref_range(&rng, 3, LABELS), 3); /* ties */
        one_row(&rng, nx, ref_range(&rng, 3, LABELS), 200);
        one_row(&rng, nx, ref_range(&rng, 3, LABELS), INT16_MAX);
    }
}

static void rows_of_one_cost_are_their_first_label(void **state)
{
    ref_rng rng = {10};

    (void)state;
    one_row(&rng, 70, 3, 0);
    for (int32_t i = 0; i < 3 * 70 + SPARE; i++) {
        sum[i] = INT16_MAX;
    }
    {
        plfx_frame_state s = state_of(70, 3, 8);
        plfx_winner_row(&s, 0, sum, work);
        check_pixel(&s, 0, 0);
        check_pixel(&s, 69, 69);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(every_column_is_judged),
    cmocka_unit_test(rows_of_one_cost_are_their_first_label),
};

SUITE(tests)
