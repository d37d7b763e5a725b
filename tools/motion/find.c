/* SPDX-License-Identifier: MIT */
#include "motion/find.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"
#include "plenofix/modal.h"

#define ROWS_LEAST 128
#define LOG2_MOST  12
#define APART      4  /* bins between two peaks */
#define OVER_Q4    40 /* amplitude over the spectrum's mean, sixteenths */

typedef struct work {
    plfx_fft fft;
    uint64_t *ws;
    int16_t *x;
    uint32_t *power;
    double *sum;
} work;

/* A column of the series without its mean, its peak at 20000.  0: too little of it. */
static int column(const double *series, int rows, int step, int16_t *x)
{
    double mean = 0;
    double most = 0;
    int n = 0;
    int t;

    for (t = 0; t < rows; t++) {
        double v = series[(size_t)t * (size_t)step];
        if (isfinite(v)) {
            mean += v;
            n++;
        }
    }
    mean /= n > 0 ? n : 1;
    for (t = 0; t < rows; t++) {
        double v = series[(size_t)t * (size_t)step];
        if (isfinite(v)) {
            most = fabs(v - mean) > most ? fabs(v - mean) : most;
        }
    }
    for (t = 0; t < rows; t++) {
        double v = series[(size_t)t * (size_t)step];
        x[t] =
            (int16_t)(isfinite(v) && most > 0 ? lround(20000 * (v - mean) / most) : 0);
    }
    return most > 0 && 10 * n >= 9 * rows;
}

static int allot(work *w, int log2, int rows)
{
    size_t n = (size_t)1 << log2;

    w->ws = plft_alloc(PLFX_FFT_WORDS(log2), sizeof *w->ws);
    w->x = plft_alloc((size_t)rows, sizeof *w->x);
    w->power = plft_alloc(n / 2u + 1u, sizeof *w->power);
    w->sum = plft_alloc(n / 2u + 1u, sizeof *w->sum);
    return w->ws && w->x && w->power && w->sum &&
                   plfx_fft_init(&w->fft, log2, w->ws, PLFX_FFT_WORDS(log2)) == PLFX_OK
               ? 0
               : PLFT_DATA;
}

static void release(work *w)
{
    free(w->ws);
    free(w->x);
    free(w->power);
    free(w->sum);
}

/* Each region adds its power over its own mean power, so that a loud one does not hide
 * the rest. */
static void add_region(work *w, int rows, int bins)
{
    double mean = 0;
    int32_t scale = 0;
    int k;

    if (plfx_fft_welch(&w->fft, w->x, rows, w->power, &scale) != PLFX_OK) {
        return;
    }
    for (k = 1; k < bins; k++) {
        mean += w->power[k];
    }
    for (k = 1; mean > 0 && k < bins; k++) {
        w->sum[k] += w->power[k] / mean;
    }
}

int plft_spectrum_of(plft_spectrum *s, const double *series, int rows, int regions,
                     int axis, double rate)
{
    work w;
    double most = 0;
    int log2 = PLFX_FFT_LOG2_MIN;
    int rc;
    int k;

    memset(&w, 0, sizeof w);
    s->bins = 0;
    if (rows < ROWS_LEAST) {
        return 0;
    }
    while (log2 < LOG2_MOST && 2 << log2 <= rows) { /* three stretches */
        log2++;
    }
    rc = allot(&w, log2, rows);
    for (k = 0; rc == 0 && k < regions; k++) {
        if (column(series + 3 * k + axis, rows, 3 * regions, w.x)) {
            add_region(&w, rows, (1 << (log2 - 1)) + 1);
        }
    }
    if (rc == 0) {
        s->bins = (1 << (log2 - 1)) + 1;
        s->hz_bin = rate / (1 << log2);
        for (k = 0; k < s->bins; k++) {
            most = w.sum[k] > most ? w.sum[k] : most;
        }
        for (k = 0; k < s->bins; k++) {
            s->amplitude[k] =
                (uint32_t)(most > 0 ? 1e9 * sqrt(w.sum[k] / most) + 0.5 : 0);
        }
    }
    release(&w);
    return rc;
}

int plft_find_modes(const plft_spectrum *s, double *hz, int max)
{
    plfx_peak peak[32];
    int32_t n = 0;
    int k;

    if (s->bins < 3 || max > 32 ||
        plfx_modal_peaks(s->amplitude, s->bins, APART, OVER_Q4, peak, max, &n) !=
            PLFX_OK) {
        return 0;
    }
    for (k = 0; k < n; k++) {
        hz[k] = peak[k].bin_q8 / 256.0 * s->hz_bin;
    }
    return n;
}
