/* SPDX-License-Identifier: MIT
 * Spectra in 32-bit fixed point against a transform in double. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "fft/fft.h"
#include "plenofix/modal.h"

#define PI   3.14159265358979323846
#define LOG2 10
#define N    1024

static uint64_t ws[PLFX_FFT_WORDS(LOG2)];
static plfx_fft fft;
static uint32_t seed = 5;

static double uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return ((double)(seed >> 8) + 0.5) / 16777216.0;
}

/* Signal over error of the whole spectrum of tones at `peak` of full scale, dB. */
static double quality(double peak)
{
    static double re[N], im[N];
    double signal = 0;
    double error = 0;
    int k;
    int t;

    for (t = 0; t < N; t++) {
        double h = 0.5 - 0.5 * cos(2 * PI * t / N);
        double v = 0.6 * sin(2 * PI * 37.3 * t / N) +
                   0.25 * cos(2 * PI * 99.7 * t / N) +
                   1e-3 * sin(2 * PI * 200.2 * t / N) + 1e-4 * (uniform() - 0.5);
        fft.in[2 * t] = (int32_t)floor(peak * 2147483647.0 * h * v);
        fft.in[2 * t + 1] = 0;
    }
    for (k = 0; k < N; k++) {
        re[k] = 0;
        im[k] = 0;
        for (t = 0; t < N; t++) {
            double a = 2 * PI * (double)(k * t % N) / N;
            re[k] += fft.in[2 * t] * cos(a) / N;
            im[k] -= fft.in[2 * t] * sin(a) / N;
        }
    }
    plfx_fft_run(&fft);
    for (k = 0; k < N; k++) {
        double a = fft.out[2 * k] - re[k];
        double b = fft.out[2 * k + 1] - im[k];
        signal += re[k] * re[k] + im[k] * im[k];
        error += a * a + b * b;
    }
    return 10 * log10(signal / error);
}

static void transforms_keep_their_bits(void **s)
{
    double full;
    double weak;
    (void)s;
    assert_int_equal(plfx_fft_init(&fft, LOG2, ws, PLFX_FFT_WORDS(LOG2)), PLFX_OK);
    full = quality(1.0);
    weak = quality(0.01);
    print_message("# %s: %.0f dB at full scale, %.0f dB at -40 dB\n", plfx_fft_name(),
                  full, weak);
    assert_true(full > 130);
    assert_true(weak > 92);
}

/* Tones in noise: the core finds them in the spectrum of the port. */
static void tones_are_found_in_spectra(void **s)
{
    static int16_t x[8000];
    static uint32_t power[N / 2 + 1];
    plfx_peak peak[4];
    int32_t scale = 0;
    int32_t n = 0;
    int t;
    (void)s;
    for (t = 0; t < 8000; t++) {
        x[t] = (int16_t)floor(1000 + 200 * sin(2 * PI * 6.2 * t / 200) +
                              60 * sin(2 * PI * 22 * t / 200) + 40 * (uniform() - 0.5));
    }
    assert_int_equal(plfx_fft_init(&fft, LOG2, ws, PLFX_FFT_WORDS(LOG2)), PLFX_OK);
    assert_int_equal(plfx_fft_welch(&fft, x, 8000, power, &scale), PLFX_OK);
    assert_int_equal(plfx_modal_peaks(power, N / 2 + 1, 4, 32, peak, 4, &n), PLFX_OK);
    assert_int_equal(n, 2);
    assert_true(fabs(peak[0].bin_q8 / 256.0 * 200 / N - 6.2) < 0.03);
    assert_true(fabs(peak[1].bin_q8 / 256.0 * 200 / N - 22.0) < 0.03);
    assert_true(power[(int)(6.2 * N / 200)] < 0x80000000u);
    for (t = 0; t < 8000; t++) {
        x[t] = -32768;
    }
    assert_int_equal(plfx_fft_welch(&fft, x, 8000, power, &scale), PLFX_OK);
    for (t = 0; t <= N / 2; t++) {
        assert_int_equal(power[t], 0);
    }
    for (t = 0; t < 8000; t++) { /* the strongest there is */
        x[t] = (int16_t)(t % 2 ? 32767 : -32768);
    }
    assert_int_equal(plfx_fft_welch(&fft, x, 8000, power, &scale), PLFX_OK);
    assert_true(power[N / 2] >= 0x40000000u && power[N / 2] < 0x80000000u);
}

static void bad_arguments_are_refused(void **s)
{
    int16_t x[N] = {0};
    uint32_t power[N / 2 + 1];
    int32_t scale;
    (void)s;
    assert_int_equal(plfx_fft_init(NULL, LOG2, ws, 9999), PLFX_E_ARG);
    assert_int_equal(plfx_fft_init(&fft, LOG2, NULL, 9999), PLFX_E_ARG);
    assert_int_equal(plfx_fft_init(&fft, 4, ws, 9999), PLFX_E_ARG);
    assert_int_equal(plfx_fft_init(&fft, 15, ws, 9999), PLFX_E_ARG);
    assert_int_equal(plfx_fft_init(&fft, LOG2, ws, PLFX_FFT_WORDS(LOG2) - 1),
                     PLFX_E_SIZE);
    assert_int_equal(plfx_fft_init(&fft, LOG2, ws, PLFX_FFT_WORDS(LOG2)), PLFX_OK);
    assert_int_equal(plfx_fft_welch(NULL, x, N, power, &scale), PLFX_E_ARG);
    assert_int_equal(plfx_fft_welch(&fft, x, N - 1, power, &scale), PLFX_E_ARG);
    assert_int_equal(plfx_fft_welch(&fft, x, N, NULL, &scale), PLFX_E_ARG);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transforms_keep_their_bits),
        cmocka_unit_test(tones_are_found_in_spectra),
        cmocka_unit_test(bad_arguments_are_refused),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
