/* SPDX-License-Identifier: MIT
 * Modes: known oscillators in, frequency, damping, amplitude and their errors out. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "plenofix/plenofix.h"
#include "ln.h"

#define PI     3.14159265358979323846
#define RATE   200.0
#define RECORD 12000 /* samples: 60 s */

static uint32_t seed;
static plfx_modal m, other;

static double uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return ((double)(seed >> 8) + 0.5) / 16777216.0;
}

static double gauss(void)
{
    double r = sqrt(-2.0 * log(uniform()));

    return r * cos(2.0 * PI * uniform());
}

typedef struct oscillator { /* driven by white kicks, unit variance of x */
    double x, v;
    double xx, xv, vx, vv, kick;
} oscillator;

static oscillator make(double f, double zeta)
{
    double w = 2.0 * PI * f;
    double d = w * sqrt(1.0 - zeta * zeta);
    double e = exp(-zeta * w / RATE);
    double c = cos(d / RATE);
    double s = sin(d / RATE);
    oscillator o = {0, 0, 0, 0, 0, 0, 0};

    o.xx = e * (c + zeta * w / d * s);
    o.xv = e * s / d;
    o.vx = -e * w * w / d * s;
    o.vv = e * (c - zeta * w / d * s);
    o.kick = sqrt(4.0 * zeta * w * w * w / RATE);
    return o;
}

static double run(oscillator *o)
{
    double x = o->xx * o->x + o->xv * o->v;
    double v = o->vx * o->x + o->vv * o->v;

    o->x = x;
    o->v = v + o->kick * gauss();
    return x;
}

static void start(double f, double zeta, double seconds)
{
    plfx_modal_cfg cfg = {200000, 0, 0, 0, 8};

    cfg.freq_uhz = (uint32_t)(f * 1e6);
    cfg.every = plfx_modal_every(cfg.rate_mhz, cfg.freq_uhz, (int32_t)(zeta * 1e6));
    cfg.block = (int32_t)(seconds * RATE / cfg.every / PLFX_MODAL_BLOCKS);
    assert_int_equal(plfx_modal_init(&m, &cfg), PLFX_OK);
}

static int16_t sample(double v)
{
    return (int16_t)(v < -32767 ? -32767 : v > 32767 ? 32767 : floor(v + 0.5));
}

/* Twelve records of a mode, 20 % white noise: means within 3 sigma of the truth, every
 * value within 4.5 stated sigmas. */
static void measure(double f, double zeta)
{
    plfx_mode mode;
    double mean_f = 0;
    double mean_z = 0;
    double sd_f = 0;
    double sd_z = 0;
    int k;
    int i;

    for (k = 0; k < 12; k++) {
        oscillator o = make(f, zeta);
        seed = (uint32_t)(k + 1);
        start(f * 1.01, zeta, 60);
        for (i = 0; i < 1000; i++) {
            (void)run(&o);
        }
        for (i = 0; i < RECORD; i++) {
            (void)plfx_modal_push(&m, sample(2000.0 * (run(&o) + 0.2 * gauss())));
        }
        assert_int_equal(plfx_modal_read(&m, PLFX_MODAL_BLOCKS, &mode), PLFX_OK);
        assert_int_equal(mode.flags, PLFX_MODE_VALID);
        assert_true(fabs(mode.freq_uhz - f * 1e6) < 4.5 * mode.freq_sigma_uhz);
        assert_true(fabs(mode.damp_ppm - zeta * 1e6) < 4.5 * mode.damp_sigma_ppm);
        assert_true(fabs(mode.amp_q8 / 256.0 - 2000.0) < 4.5 / 256 * mode.amp_sigma_q8);
        assert_true(mode.record_ms > 55000u && mode.record_ms <= 60000u);
        mean_f += mode.freq_uhz / 12e6;
        mean_z += mode.damp_ppm / 12e6;
        sd_f = mode.freq_sigma_uhz / 1e6;
        sd_z = mode.damp_sigma_ppm / 1e6;
    }
    assert_true(fabs(mean_f - f) < 3.0 * sd_f / sqrt(12));
    assert_true(fabs(mean_z - zeta) < 3.0 * sd_z / sqrt(12));
}

static void wing_modes_are_measured(void **s)
{
    (void)s;
    measure(6.2, 0.015);
    measure(22.0, 0.012);
    measure(38.9, 0.010);
}

static void a_pure_tone_has_no_damping(void **s)
{
    plfx_mode mode;
    int i;
    (void)s;
    start(10.0, 0.01, 60);
    for (i = 0; i < RECORD; i++) {
        (void)plfx_modal_push(&m, sample(1000 * sin(2 * PI * 10.03 * i / RATE) + 300));
    }
    assert_int_equal(plfx_modal_read(&m, PLFX_MODAL_BLOCKS, &mode), PLFX_OK);
    assert_int_equal(mode.flags, PLFX_MODE_VALID);
    assert_true(fabs(mode.freq_uhz - 10030000.0) < 200.0);
    assert_true(mode.damp_ppm > -100 && mode.damp_ppm < 100);
    assert_true(fabs(mode.amp_q8 / 256.0 - 707.1) < 15.0);
}

/* A tone that stands off its expected place by a share of the thinned rate. */
static uint32_t flags_beside(double share)
{
    plfx_mode mode;
    double f;
    int i;

    start(38.9, 0.01, 60);
    f = 38.9 + share * RATE / m.cfg.every;
    for (i = 0; i < RECORD; i++) {
        (void)plfx_modal_push(&m, sample(1000 * sin(2 * PI * f * i / RATE)));
    }
    assert_int_equal(plfx_modal_read(&m, PLFX_MODAL_BLOCKS, &mode), PLFX_OK);
    assert_true(mode.flags & PLFX_MODE_LOST || fabs(mode.freq_uhz / 1e6 - f) < 0.01);
    return mode.flags;
}

static void another_mode_is_not_taken_for_the_expected(void **s)
{
    (void)s;
    assert_int_equal(flags_beside(0.2), PLFX_MODE_VALID);
    assert_int_equal(flags_beside(-0.2), PLFX_MODE_VALID);
    assert_int_equal(flags_beside(0.3), PLFX_MODE_LOST);
    assert_int_equal(flags_beside(-0.3), PLFX_MODE_LOST);
}

static void growth_is_negative_damping_and_alarms(void **s)
{
    plfx_mode mode;
    int i;
    (void)s;
    start(10.0, 0.01, 32);
    for (i = 0; i < 4000; i++) {
        (void)plfx_modal_push(&m, sample(20 * exp(0.001 * 2 * PI * 10 * i / RATE) *
                                         sin(2 * PI * 10 * i / RATE)));
    }
    assert_int_equal(plfx_modal_alarm(&m, 2000, 0, &mode), PLFX_OK);
    assert_true(mode.damp_ppm < 0);
    assert_int_equal(mode.flags & PLFX_MODE_ALARM, PLFX_MODE_ALARM);
}

static void well_damped_motion_does_not_alarm(void **s)
{
    plfx_mode mode;
    oscillator o = make(22.0, 0.03);
    int i;
    (void)s;
    seed = 9;
    start(22.0, 0.012, 60);
    for (i = 0; i < 2 * RECORD; i++) {
        (void)plfx_modal_push(&m, sample(2000.0 * run(&o)));
        if (i % 200 == 0) {
            assert_int_equal(plfx_modal_alarm(&m, 10000, 512, &mode), PLFX_OK);
            assert_int_equal(mode.flags & PLFX_MODE_ALARM, 0);
        }
    }
}

static void noise_and_stillness_are_lost(void **s)
{
    plfx_mode mode;
    int i;
    (void)s;
    seed = 4;
    start(22.0, 0.012, 60);
    assert_int_equal(plfx_modal_read(&m, 1, &mode), PLFX_OK);
    assert_int_equal(mode.flags, PLFX_MODE_SHORT);
    for (i = 0; i < RECORD; i++) {
        (void)plfx_modal_push(&m, sample(500.0 * gauss()));
    }
    assert_int_equal(plfx_modal_read(&m, PLFX_MODAL_BLOCKS, &mode), PLFX_OK);
    assert_int_equal(mode.flags, PLFX_MODE_LOST);
    assert_int_equal(mode.damp_ppm, 0);
    start(22.0, 0.012, 60);
    for (i = 0; i < RECORD; i++) {
        (void)plfx_modal_push(&m, 32767);
    }
    assert_int_equal(plfx_modal_read(&m, PLFX_MODAL_BLOCKS, &mode), PLFX_OK);
    assert_int_equal(mode.flags, PLFX_MODE_LOST);
}

/* The sum of watch_add() in double, from the same thinned samples. */
typedef struct watched {
    double a0, a1, gain, sum, last;
    int primed;
} watched;

static void watched_start(watched *w, double f, double healthy, double limit)
{
    double period = m.cfg.every / RATE;
    double u;
    double spline[3] = {0, 0, 0}; /* R(0), R(1), all */
    int i;
    int j;

    w->a0 = 2 * PI * f * healthy * period;
    w->a1 = 2 * PI * f * limit * period;
    w->sum = 0;
    w->primed = 0;
    u = sqrt(w->a0 * w->a1);
    for (i = -100; i <= 100; i++) { /* two triangles of half width 1 */
        for (j = -100; j <= 100; j++) {
            double v = (100.0 - abs(i)) * (100.0 - abs(j));
            spline[0] += v * exp(-u * fabs((i - j) / 100.0));
            spline[1] += v * exp(-u * fabs(1 + (i - j) / 100.0));
            spline[2] += v;
        }
    }
    w->gain = (spline[0] - spline[1]) / (u * spline[0]);
}

static void watched_add(watched *w)
{
    double e[2] = {(double)m.now.energy[0], (double)m.now.energy[1]};
    double r[2] = {(double)m.now.re[1], (double)m.now.im[1]};
    double n = m.now.n;
    double q;
    int b;

    for (b = 0; b < m.used; b++) {
        e[0] += (double)m.ring[b].energy[0];
        e[1] += (double)m.ring[b].energy[1];
        r[0] += (double)m.ring[b].re[1];
        r[1] += (double)m.ring[b].im[1];
        n += m.ring[b].n;
    }
    if (n < 64) {
        w->primed = 0;
        return;
    }
    q = w->gain * n * ((double)m.y_re * m.y_re + (double)m.y_im * m.y_im) /
        (e[0] + e[1] - 2 * sqrt(r[0] * r[0] + r[1] * r[1]));
    if (w->primed && m.since > 1) {
        w->sum += (w->a0 - w->a1) * (q - w->last) +
                  (w->a0 * w->a0 - w->a1 * w->a1) * (q + w->last) / 2 - (w->a0 - w->a1);
        w->sum = w->sum < 0 ? 0 : w->sum;
    }
    w->last = q;
    w->primed = 1;
}

/* Two minutes at healthy damping, then at a quarter of it: no alarm, then one. */
static void a_loss_of_damping_is_watched(void **s)
{
    oscillator healthy = make(22.0, 0.02);
    oscillator worn = make(22.0, 0.005);
    plfx_modal_watch w;
    watched want;
    int late = 0;
    int i;
    (void)s;
    worn.kick = healthy.kick;
    seed = 11;
    start(22.0, 0.015, 60);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 20000, 2560), PLFX_OK);
    watched_start(&want, 22.0, 0.02, 0.01);
    for (i = 0; i < 3 * RECORD; i++) {
        oscillator *o = i < 2 * RECORD ? &healthy : &worn;
        if (i == RECORD) {
            plfx_modal_gap(&m, 4400); /* whole turns */
        }
        if (i == 2 * RECORD) {
            worn.x = healthy.x;
            worn.v = healthy.v;
        }
        if (plfx_modal_push(&m, sample(1000.0 * (run(o) + 0.2 * gauss())))) {
            int32_t alarm = plfx_modal_watch_add(&w, &m);
            watched_add(&want);
            assert_true(fabs(w.evidence_q20 / 1048576.0 - want.sum) <
                        0.02 + 0.002 * want.sum);
            assert_true(i >= 2 * RECORD || !alarm);
            late += i < 2 * RECORD + 1600 && alarm;
        }
    }
    assert_true(late > 0); /* within eight seconds */
}

static void watch_refuses_what_it_cannot_tell(void **s)
{
    plfx_modal_watch w;
    int i;
    (void)s;
    start(22.0, 0.015, 60);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 1, 20000, 2560), PLFX_E_RANGE);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 900000, 2560), PLFX_E_RANGE);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 20000, 2560), PLFX_OK);
    seed = 3;
    for (i = 0; i < 2 * RECORD; i++) { /* noise without a mode, then silence */
        if (plfx_modal_push(&m, i < RECORD ? sample(500.0 * gauss()) : 0)) {
            assert_int_equal(plfx_modal_watch_add(&w, &m), 0);
        }
    }
}

/* Records of 11 samples on: what is called valid is no absurdity. */
static void short_records_are_sober(void **s)
{
    plfx_mode mode;
    int k;
    int i;
    (void)s;
    for (k = 0; k < 300; k++) {
        oscillator o = make(6.2, 0.015);
        seed = (uint32_t)(k + 1);
        start(6.2, 0.015, 60);
        for (i = 0; i < 350 + 3 * k; i++) {
            double v = run(&o) + (k % 3) * gauss();
            if (plfx_modal_push(&m, sample(1000.0 * v))) {
                assert_int_equal(plfx_modal_read(&m, 16, &mode), PLFX_OK);
                assert_true(mode.damp_ppm < 1000000 && mode.damp_ppm > -1000000);
                assert_true(mode.freq_uhz < 9000000u);
                assert_true((mode.flags & PLFX_MODE_VALID) || mode.freq_uhz == 0);
            }
        }
    }
}

/* A record with a hole: the oscillator keeps its phase, the block is marked. */
static void a_gap_is_marked_and_bridged(void **s)
{
    plfx_mode mode;
    int i;
    (void)s;
    start(10.0, 0.01, 60);
    for (i = 0; i < RECORD; i++) {
        if (i == 5000) {
            i += 777;
            plfx_modal_gap(&m, 777);
        }
        (void)plfx_modal_push(&m, sample(1000 * sin(2 * PI * 10.01 * i / RATE)));
    }
    assert_int_equal(plfx_modal_read(&m, PLFX_MODAL_BLOCKS, &mode), PLFX_OK);
    assert_int_equal(mode.flags, PLFX_MODE_VALID | PLFX_MODE_GAP);
    assert_true(fabs(mode.freq_uhz - 10010000.0) < 500.0);
    assert_int_equal(plfx_modal_read(&m, 1, &mode), PLFX_OK);
    assert_int_equal(mode.flags & PLFX_MODE_GAP, 0);
}

static void extremes_do_not_overflow(void **s)
{
    plfx_modal_cfg cfg = {200000, 49000000, 2048, 8, 16};
    plfx_mode mode;
    int32_t i;
    (void)s;
    assert_int_equal(plfx_modal_init(&m, &cfg), PLFX_OK);
    for (i = 0; i < 2048 * 300; i++) {
        (void)plfx_modal_push(&m, i % 4 < 2 ? 32767 : -32768);
    }
    assert_int_equal(plfx_modal_read(&m, PLFX_MODAL_BLOCKS, &mode), PLFX_OK);
    assert_true(m.y_re < 1 << 21 && m.y_re > -(1 << 21));
}

static void shapes_keep_sign_and_size(void **s)
{
    plfx_modal_shape shape = {0, 0, 0};
    int i;
    (void)s;
    start(10.0, 0.01, 60);
    other = m;
    for (i = 0; i < RECORD; i++) {
        double x = sin(2 * PI * 10.03 * i / RATE);
        int32_t a = plfx_modal_push(&m, sample(-500 * x));
        int32_t b = plfx_modal_push(&other, sample(1000 * x));
        if (a && b) {
            plfx_modal_shape_add(&shape, &m, &other);
        }
    }
    assert_true(fabs((double)shape.re / (double)shape.ref + 0.5) < 0.002);
    assert_true(fabs((double)shape.im / (double)shape.ref) < 0.002);
}

static void peaks_are_found_in_order(void **s)
{
    static uint32_t p[256];
    plfx_peak peak[8];
    int32_t n = 0;
    int k;
    (void)s;
    for (k = 0; k < 256; k++) {
        double a = (k - 40.25) / 2.0;
        double b = (k - 100.0) / 2.0;
        p[k] = (uint32_t)(1e6 * exp(-a * a) + 3e6 * exp(-b * b) + 100.0);
    }
    p[0] = 0xffffffffu;
    assert_int_equal(plfx_modal_peaks(p, 256, 4, 32, peak, 8, &n), PLFX_OK);
    assert_int_equal(n, 2);
    assert_true(peak[0].bin_q8 > 25590 && peak[0].bin_q8 < 25610);
    assert_true(peak[1].bin_q8 > 10294 && peak[1].bin_q8 < 10314);
    assert_int_equal(plfx_modal_peaks(p, 2, 4, 32, peak, 8, &n), PLFX_E_ARG);
    assert_int_equal(plfx_modal_peaks(NULL, 256, 4, 32, peak, 8, &n), PLFX_E_ARG);
}

static void logarithm_and_angle_follow_libm(void **s)
{
    int k;
    (void)s;
    seed = 77;
    assert_int_equal(plfx_log2_q20(1), 0);
    assert_int_equal(plfx_log2_q20((uint64_t)1 << 63), 63 << 20);
    for (k = 0; k < 20000; k++) {
        double x = (2 * uniform() - 1) * pow(2, 29.9 * uniform());
        double y = (2 * uniform() - 1) * pow(2, 29.9 * uniform());
        int32_t a = (int32_t)x;
        int32_t b = (int32_t)y;
        double want = atan2(b, a) / (2 * PI);
        double got = plfx_angle_u32(a, b) / 4294967296.0;
        uint64_t v = (uint64_t)(uniform() * pow(2, 62.0 * uniform())) + 1u;
        got -= floor(got - want + 0.5);
        assert_true(a == 0 || fabs(got - want) < 7e-9);
        assert_true(fabs(plfx_log2_q20(v) / 1048576.0 - log((double)v) / log(2.0)) <
                    2e-6);
    }
}

static void thinning_stays_in_its_range(void **s)
{
    (void)s;
    assert_true(plfx_modal_every(8000000, 1, 0) >= 1);
    assert_int_equal(plfx_modal_every(1000, 4000000000u, 1000000), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wing_modes_are_measured),
        cmocka_unit_test(a_pure_tone_has_no_damping),
        cmocka_unit_test(another_mode_is_not_taken_for_the_expected),
        cmocka_unit_test(growth_is_negative_damping_and_alarms),
        cmocka_unit_test(well_damped_motion_does_not_alarm),
        cmocka_unit_test(noise_and_stillness_are_lost),
        cmocka_unit_test(a_loss_of_damping_is_watched),
        cmocka_unit_test(watch_refuses_what_it_cannot_tell),
        cmocka_unit_test(short_records_are_sober),
        cmocka_unit_test(a_gap_is_marked_and_bridged),
        cmocka_unit_test(extremes_do_not_overflow),
        cmocka_unit_test(shapes_keep_sign_and_size),
        cmocka_unit_test(peaks_are_found_in_order),
        cmocka_unit_test(logarithm_and_angle_follow_libm),
        cmocka_unit_test(thinning_stays_in_its_range),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
