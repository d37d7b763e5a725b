/* SPDX-License-Identifier: MIT
 * Modes at the ends of their ranges: read from sums of lags made by hand, watched over
 * what cannot be watched, mixed without thinning. */
#include "suite.h"

#include "plenofix/modal.h"

#define ONE ((int64_t)1 << 40) /* energy of a record made by hand */

static plfx_modal m;

/* A channel of 200 samples a second. */
static void start(uint32_t freq_uhz, int32_t every)
{
    plfx_modal_cfg cfg = {200000, 0, 0, 16, 8};

    cfg.freq_uhz = freq_uhz;
    cfg.every = every;
    assert_int_equal(plfx_modal_init(&m, &cfg), PLFX_OK);
}

/* Sums of n samples whose lag l is first*ratio^(l-1)/den^(l-1) of the energy. */
static void lags(int32_t n, int64_t first, int64_t ratio, int64_t den)
{
    int64_t r = first;
    int32_t l;

    memset(&m.now, 0, sizeof m.now);
    m.now.n = n;
    m.now.energy[0] = ONE;
    for (l = 1; l <= PLFX_MODAL_LAGS; l++) {
        m.now.energy[l] = ONE;
        m.now.re[l] = r;
        r = r * ratio / den;
    }
}

/* Lags of one size, turned by an eighth of a turn each, up or down. */
static void eighths(int32_t n, int64_t up)
{
    static const int64_t q10[6][2] = {{1024, 0},   {724, 724}, {0, 1024},
                                      {-724, 724}, {-1024, 0}, {-724, -724}};
    int32_t l;

    lags(n, ONE, 1, 1);
    for (l = 1; l <= PLFX_MODAL_LAGS; l++) {
        m.now.re[l] = ONE / 1024 * q10[l][0];
        m.now.im[l] = ONE / 1024 * q10[l][1] * up;
    }
}

static plfx_mode reading(void)
{
    plfx_mode mode;

    assert_int_equal(plfx_modal_read(&m, 1, &mode), PLFX_OK);
    return mode;
}

static void lost(void)
{
    plfx_mode mode = reading();

    assert_int_equal(mode.flags, PLFX_MODE_LOST);
    assert_int_equal(mode.freq_uhz, 0);
    assert_int_equal(mode.damp_ppm, 0);
    assert_int_equal(mode.amp_q8, 0);
}

static void no_correlation_is_lost(void **s)
{
    (void)s;
    start(5000000, 40);
    lags(400, 0, 1, 1);
    lost();
}

/* An eighth of a turn a lag is 25 Hz, inside the band of a quarter. */
static void frequencies_beyond_their_range_are_lost(void **s)
{
    plfx_mode mode;

    (void)s;
    start(60000000, 1);
    eighths(400, 1);
    mode = reading();
    assert_int_equal(mode.flags, PLFX_MODE_VALID);
    assert_in_range(mode.freq_uhz, 84999000, 85001000);
    start(80000000, 1); /* half of the rate is 100 Hz */
    eighths(400, 1);
    lost();
    start(30000000, 1);
    eighths(4000, -1);
    mode = reading();
    assert_int_equal(mode.flags, PLFX_MODE_VALID);
    assert_in_range(mode.freq_uhz, 4999000, 5001000);
    start(20000000, 1);
    eighths(4000, -1);
    lost();
}

/* Halved each lag, 200 lags a second, at 5 Hz: 4.4 of critical; doubled: -4.4.  The
 * same at 5 lags a second: 0.11. */
static void damping_beyond_critical_is_lost(void **s)
{
    plfx_mode mode;

    (void)s;
    start(5000000, 1);
    lags(400, ONE / 2, 1, 2);
    lost();
    lags(400, ONE / 16, 2, 1);
    m.now.re[2] = ONE / 4;
    lost();
    start(5000000, 40);
    lags(400, ONE / 2, 1, 2);
    mode = reading();
    assert_int_equal(mode.flags, PLFX_MODE_VALID);
    assert_in_range(mode.damp_ppm, 110200, 110400); /* ln 2 / 2 pi */
    lags(400, ONE / 8, 2, 1);
    mode = reading();
    assert_int_equal(mode.flags, PLFX_MODE_VALID);
    assert_in_range(-mode.damp_ppm, 110200, 110400);
}

/* The fit's own R(0) scales the amplitude, from half to 16 times the energy seen. */
static void shares_of_noise_are_cut(void **s)
{
    plfx_mode half;
    plfx_mode least;
    plfx_mode even;

    (void)s;
    start(5000000, 40);
    lags(400, ONE, 1, 1);
    even = reading();
    lags(400, 2 * ONE, 1, 2); /* 4 at lag 0: cut to 2 */
    half = reading();
    assert_int_equal(half.flags, PLFX_MODE_VALID);
    assert_true((uint64_t)half.amp_q8 * half.amp_q8 / 2u / even.amp_q8 + 1u >=
                even.amp_q8);
    assert_true((uint64_t)half.amp_q8 * half.amp_q8 / 2u / even.amp_q8 <=
                even.amp_q8 + 1u);
    lags(400, ONE / 4, 1, 1); /* the steep end weighs most: 2^-9 at lag 0 */
    m.now.re[4] = ONE / 2;
    m.now.re[5] = ONE * 2;
    least = reading();
    assert_int_equal(least.flags, PLFX_MODE_VALID);
    assert_in_range(least.amp_q8 * 4u, even.amp_q8 * 98u / 100u,
                    even.amp_q8 * 102u / 100u);
}

/* 2^20 thinned samples of 2048 at one a second: 68 years in milliseconds. */
static void records_longer_than_their_field_saturate(void **s)
{
    plfx_modal_cfg cfg = {1000, 1000, 2048, 16, 8};
    plfx_mode mode;

    (void)s;
    assert_int_equal(plfx_modal_init(&m, &cfg), PLFX_OK);
    lags(1 << 20, ONE, 1, 1);
    mode = reading();
    assert_int_equal(mode.record_ms, UINT32_MAX);
    lags(2000, ONE, 1, 1);
    mode = reading();
    assert_int_equal(mode.record_ms, 2000u * 2048u * 1000u);
}

/* Ten samples in a millisecond of a mode of half a hertz: under a thousandth cycle. */
static void no_whole_thousandth_of_a_cycle(void **s)
{
    plfx_modal_cfg cfg = {8000000, 500000, 1, 16, 8};
    plfx_mode mode;

    (void)s;
    assert_int_equal(plfx_modal_init(&m, &cfg), PLFX_OK);
    lags(10, ONE, 1, 1);
    mode = reading();
    assert_int_equal(mode.record_ms, 1);
    assert_int_equal(mode.flags, PLFX_MODE_VALID | PLFX_MODE_SHORT);
    assert_true(mode.damp_sigma_ppm > 500000u); /* says nothing, and says so */
}

/* Every sample is one thinned sample, mixed, one late; without motion of the mean. */
static void without_thinning_samples_pass_one_late(void **s)
{
    static const int16_t x[6] = {1000, -3000, 5000, 7000, -9000, 11000};
    int32_t k;

    (void)s;
    start(50000000, 1); /* a quarter turn a sample */
    m.primed = 1;
    m.cfg.mean_log2 = 16;
    for (k = 0; k < 6; k++) {
        int32_t was = k > 0 ? x[k - 1] : 0;
        int32_t want_re = k % 4 == 1 ? was : k % 4 == 3 ? -was : 0;
        int32_t want_im = k % 4 == 2 ? -was : k % 4 == 0 ? was : 0;
        assert_int_equal(plfx_modal_push(&m, x[k]), 1);
        assert_in_range(m.y_re - want_re + 8, 0, 16);
        assert_in_range(m.y_im - want_im + 8, 0, 16);
    }
}

static void a_gap_of_nothing_is_none(void **s)
{
    static plfx_modal was;
    int32_t k;

    (void)s;
    start(5000000, 8);
    for (k = 0; k < 300; k++) {
        (void)plfx_modal_push(&m, (int16_t)(k % 40 < 20 ? 900 : -900));
    }
    was = m;
    plfx_modal_gap(&m, 0);
    assert_memory_equal(&m, &was, sizeof m);
    plfx_modal_gap(&m, 1);
    assert_memory_not_equal(&m, &was, sizeof m);
}

/* The decay over a thinned period is at most 1, at least 2^-12. */
static void watches_know_their_reach(void **s)
{
    plfx_modal_watch w;

    (void)s;
    start(5000000, 8); /* 1.2566 * damping */
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 795000, 2560), PLFX_OK);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 797000, 2560), PLFX_E_RANGE);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 195, 10000, 2560), PLFX_OK);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 193, 10000, 2560), PLFX_E_RANGE);
}

static void silence_is_no_evidence(void **s)
{
    plfx_modal_watch w;
    int32_t k;

    (void)s;
    start(5000000, 8);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 20000, 2560), PLFX_OK);
    w.primed = 1;
    w.evidence_q20 = 5000;
    for (k = 0; k < 8 * 100; k++) {
        if (plfx_modal_push(&m, 0)) {
            assert_int_equal(plfx_modal_watch_add(&w, &m), 0);
            assert_int_equal(w.primed, 0);
            assert_int_equal(w.evidence_q20, 5000); /* kept, not added to */
        }
    }
}

/* A steady tone has no damping at all: evidence grows to its end and stays. */
static void evidence_is_cut_at_its_end(void **s)
{
    static const int16_t tone[8] = {0, 7071, 10000, 7071, 0, -7071, -10000, -7071};
    const int32_t end = 1 << 30;
    plfx_modal_watch w;
    int32_t reached = 0;
    int32_t k;

    (void)s;
    start(25000000, 8); /* a turn every eight samples */
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 20000, 2560), PLFX_OK);
    w.evidence_q20 = end;
    for (k = 0; k < 8 * 600; k++) {
        int32_t v = tone[k % 8] + (k * 7919 % 31 - 15);
        if (plfx_modal_push(&m, (int16_t)v) && plfx_modal_watch_add(&w, &m)) {
            assert_true(w.evidence_q20 <= end);
            reached += w.primed && w.evidence_q20 == end;
        }
    }
    assert_true(reached > 100);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(no_correlation_is_lost),
    cmocka_unit_test(frequencies_beyond_their_range_are_lost),
    cmocka_unit_test(damping_beyond_critical_is_lost),
    cmocka_unit_test(shares_of_noise_are_cut),
    cmocka_unit_test(records_longer_than_their_field_saturate),
    cmocka_unit_test(no_whole_thousandth_of_a_cycle),
    cmocka_unit_test(without_thinning_samples_pass_one_late),
    cmocka_unit_test(a_gap_of_nothing_is_none),
    cmocka_unit_test(watches_know_their_reach),
    cmocka_unit_test(silence_is_no_evidence),
    cmocka_unit_test(evidence_is_cut_at_its_end),
};

SUITE(tests)
