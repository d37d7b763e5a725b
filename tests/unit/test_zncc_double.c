/* SPDX-License-Identifier: MIT
 * Winners of the fixed-point NCC beside those of double on the same samples: the same
 * on 99.95 % of the pixels of a scene; where they differ, double's own scores lie so
 * close that noise decides. */
#include "suite.h"
#include "ref.h"

#include <math.h>

#define NX       200
#define NY       60
#define LABELS   17
#define WS_BYTES (2u << 20)

static uint16_t samples[NX * NY * 2];
static uint16_t seen[LABELS][NX * NY]; /* the other view as the first sees it */
static int32_t slope[NX * NY];
static unsigned char memory[WS_BYTES + 64];

typedef struct scene {
    const char *name;
    int bits, window;
    double contrast, noise; /* of full scale; counts */
    int related;            /* 0: two images of noise */
    int step_q8;            /* of a label: 256 a column */
} scene;

typedef struct tally {
    long pixels, other, missing; /* another winner; none, or a tie */
    double loss; /* most that another winner's correlation is short of */
} tally;

static double gauss(ref_rng *rng)
{
    double sum = 0;

    for (int i = 0; i < 12; i++) {
        sum += ref_next(rng) / 4294967296.0;
    }
    return sum - 6;
}

/* Waves of 3 to 24 columns. */
static double texture(double x, double y)
{
    double sum = 0;

    for (int k = 0; k < 12; k++) {
        double length = 3 * pow(8, k / 11.0);
        double turn = 2.4 * k;
        sum += sin(6.2831853 * (x * cos(turn) + y * sin(turn)) / length + k * k);
    }
    return sum / 12;
}

static void draw(const scene *c, uint32_t seed)
{
    ref_rng rng = {seed};
    double full = (1 << c->bits) - 1;

    for (int y = 0; y < NY; y++) {
        double apart = 1 + (LABELS - 3) * y / (double)NY;
        for (int k = 0; k < 2; k++) {
            for (int x = 0; x < NX; x++) {
                double v =
                    c->related ? texture(x + k * apart * c->step_q8 / 256, y) : 0;
                v = full * (0.5 + c->contrast * v) + c->noise * gauss(&rng);
                v = v < 0 ? 0 : v > full ? full : v;
                samples[(y * 2 + k) * NX + x] = (uint16_t)(v + 0.5);
            }
        }
    }
}

static plfx_plan plan_of(const scene *c)
{
    plfx_cfg g;
    plfx_plan p;

    memset(&g, 0, sizeof g);
    g.method = PLFX_METHOD_PAIRS;
    g.cost = PLFX_COST_ZNCC;
    g.window = (uint8_t)c->window;
    g.bits = (uint8_t)c->bits;
    g.n = 2;
    g.labels = LABELS;
    g.at[1].u_q8 = (int16_t)(-16 * c->step_q8);
    g.slope_max_q16 = (LABELS - 1) * 4096;
    assert_int_equal(plfx_plan_init(&p, &g, NULL, NX, NY), PLFX_OK);
    return p;
}

static void look(const plfx_plan *p, const plfx_views *v)
{
    for (int l = 0; l < LABELS; l++) {
        for (int i = 0; i < NX * NY; i++) {
            seen[l][i] = ref_sample(p, v, 1, l, i % NX, i / NX);
        }
    }
}

/* Correlation at a label in double, of the samples that both see; NaN without
 * contrast. */
static double correlation(int window, int l, int x, int y)
{
    int r = window / 2;
    double n = window * window;
    double a = 0;
    double b = 0;
    double aa = 0;
    double bb = 0;
    double ab = 0;

    for (int j = -r; j <= r; j++) {
        for (int i = -r; i <= r; i++) {
            double s = samples[(y + j) * 2 * NX + x + i];
            double t = seen[l][(y + j) * NX + x + i];
            a += s;
            b += t;
            aa += s * s;
            bb += t * t;
            ab += s * t;
        }
    }
    aa -= a * a / n;
    bb -= b * b / n;
    return aa > 0 && bb > 0 ? (ab - a * b / n) / sqrt(aa * bb) : NAN;
}

static void judge(int window, int x, int y, tally *t)
{
    double score[LABELS];
    double found = slope[y * NX + x] / 4096.0;
    int best = 0;

    for (int l = 0; l < LABELS; l++) {
        score[l] = correlation(window, l, x, y);
        best = score[l] > score[best] ? l : best;
    }
    t->pixels++;
    if (slope[y * NX + x] == PLFX_SLOPE_NONE) {
        t->missing++;
    } else if (fabs(found - best) > 0.5) { /* the fit moves by half a label at most */
        double short_of = score[best] - score[(int)(found + 0.5)];
        t->other++;
        t->loss = short_of > t->loss ? short_of : t->loss;
    }
}

/* All pixels whose windows stay inside at every label. */
static tally run(const scene *c, uint32_t seed)
{
    static unsigned char *ws;
    plfx_plan p = plan_of(c);
    plfx_views v = {samples, NX, NY, 2};
    plfx_map m = {slope, NULL, NULL, NULL, NX, NY, NX};
    tally t = {0, 0, 0, 0};
    int r = c->window / 2;

    ws = aligned(memory);
    draw(c, seed);
    look(&p, &v);
    assert_true(plfx_sweep_ws(&p) <= WS_BYTES);
    assert_int_equal(plfx_sweep(&p, &v, &m, ws, plfx_sweep_ws(&p)), PLFX_OK);
    for (int y = r; y < NY - r; y++) {
        for (int x = r + LABELS; x < NX - r - LABELS; x++) {
            judge(c->window, x, y, &t);
        }
    }
    print_message(
        "# %s: %ld pixels, another winner %ld, none %ld, its correlation short "
        "by %.6f at most\n",
        c->name, t.pixels, t.other, t.missing, t.loss);
    return t;
}

static void same_winner_on_scenes(void **state)
{
    static const scene scenes[] = {
        {"8 bit, window 9", 8, 9, 0.9, 1, 1, 256},
        {"8 bit, window 9, noise 8", 8, 9, 0.5, 8, 1, 256},
        {"8 bit, window 15", 8, 15, 0.5, 1, 1, 256},
        {"8 bit, window 5", 8, 5, 0.9, 1, 1, 256},
        {"10 bit, window 9", 10, 9, 0.9, 4, 1, 256},
        {"12 bit, window 9", 12, 9, 0.9, 16, 1, 256},
        {"8 bit, window 9, labels of 0.7 columns", 8, 9, 0.9, 1, 1, 179},
        {"12 bit, window 9, labels of 0.7 columns", 12, 9, 0.5, 16, 1, 179},
    };
    tally all = {0, 0, 0, 0};

    (void)state;
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
        tally t = run(&scenes[k], (uint32_t)k + 1);
        assert_true((double)(t.other + t.missing) <= 0.0005 * (double)t.pixels);
        all.loss = t.loss > all.loss ? t.loss : all.loss;
    }
    assert_true(all.loss < 0.001);
}

/* Nothing to find: every label is as good but for chance. */
static void near_winner_on_noise(void **state)
{
    static const scene scenes[] = {
        {"noise, 8 bit", 8, 9, 0, 40, 0, 256},
        {"noise, 12 bit", 12, 9, 0, 600, 0, 256},
        {"faint noise, 8 bit", 8, 9, 0, 1, 0, 256},
    };

    (void)state;
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
        tally t = run(&scenes[k], (uint32_t)k + 100);
        assert_true((double)t.other <= 0.003 * (double)t.pixels);
        assert_true(t.loss < 0.001);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(same_winner_on_scenes),
    cmocka_unit_test(near_winner_on_noise),
};

SUITE(tests)
