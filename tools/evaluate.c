/* SPDX-License-Identifier: MIT */
#include "evaluate.h"

#include <math.h>
#include <stdlib.h>

#include "common/err.h"
#include "common/memory.h"

const double plft_thresholds[PLFT_BADPIX] = {0.07, 0.03, 0.01};

void plft_errors(const float *map, const float *truth, const uint8_t *mask, int w,
                 int h, int border, float *error, uint8_t *use, size_t *untrue)
{
    int x;
    int y;

    *untrue = 0;
    for (y = 0; y < h; y++) {
        for (x = 0; x < w; x++) {
            size_t i = (size_t)y * (size_t)w + (size_t)x;
            int in = x >= border && y >= border && x < w - border && y < h - border &&
                     (mask == NULL || mask[i] != 0);
            error[i] = map[i] - truth[i];
            use[i] = (uint8_t)(in && isfinite(truth[i]));
            *untrue += in && !isfinite(truth[i]);
            if (!isfinite(map[i])) {
                error[i] = NAN;
            }
        }
    }
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Sorted |error| and signed errors of the measured pixels. */
static size_t measured(const float *error, const uint8_t *use, size_t n, double *size,
                       double *value)
{
    size_t m = 0;
    size_t i;

    for (i = 0; i < n; i++) {
        if (use[i] && isfinite(error[i])) {
            size[m] = fabs((double)error[i]);
            value[m] = error[i];
            m++;
        }
    }
    qsort(size, m, sizeof *size, by_value);
    qsort(value, m, sizeof *value, by_value);
    return m;
}

static void count(const float *error, const uint8_t *use, size_t n, plft_figures *f)
{
    size_t bad[PLFT_BADPIX] = {0, 0, 0};
    double sum = 0;
    size_t i;
    int k;

    for (i = 0; i < n; i++) {
        if (!use[i]) {
            continue;
        }
        f->pixels++;
        f->missing += isfinite(error[i]) ? 0 : 1;
        for (k = 0; k < PLFT_BADPIX; k++) {
            bad[k] += !(fabs((double)error[i]) <= plft_thresholds[k]);
        }
        sum += isfinite(error[i]) ? (double)error[i] * error[i] : 0;
    }
    for (k = 0; k < PLFT_BADPIX; k++) {
        f->badpix[k] = 100.0 * (double)bad[k] / (double)(f->pixels ? f->pixels : 1);
    }
    f->mse100 =
        f->pixels > f->missing ? 100 * sum / (double)(f->pixels - f->missing) : 0;
}

int plft_figures_of(const float *error, const uint8_t *use, size_t n, plft_figures *f)
{
    double *size = plft_alloc(n, sizeof *size);
    double *value = plft_alloc(n, sizeof *value);
    plft_figures zero = {0, 0, f->untrue, {0, 0, 0}, 0, 0, 0, 0};
    size_t m = 0;

    *f = zero;
    if (size != NULL && value != NULL) {
        count(error, use, n, f);
        m = measured(error, use, n, size, value);
    }
    if (m > 0) {
        f->q25_100 = 100 * size[m / 4];
        f->median100 = 100 * size[m / 2];
        f->bias = value[m / 2];
    }
    free(size);
    free(value);
    return m > 0 ? 0
                 : plft_fail(PLFT_DATA, "no pixel to compare: the border, the mask or "
                                        "missing values leave none");
}

typedef struct judged {
    double trust;
    int bad;
} judged;

static int by_trust(const void *a, const void *b)
{
    const judged *x = a;
    const judged *y = b;

    return (x->trust < y->trust) - (x->trust > y->trust);
}

int plft_sparsify(const float *error, const uint8_t *use, const float *trust, size_t n,
                  double limit, double curve[PLFT_CURVE])
{
    judged *list = plft_alloc(n, sizeof *list);
    size_t m = 0;
    size_t i;
    int k;

    if (list == NULL) {
        return PLFT_DATA;
    }
    for (i = 0; i < n; i++) {
        if (use[i]) {
            list[m].trust = isfinite(trust[i]) ? (double)trust[i] : -1e30;
            list[m].bad = !(fabs((double)error[i]) <= limit);
            m++;
        }
    }
    qsort(list, m, sizeof *list, by_trust);
    for (k = 0; k < PLFT_CURVE; k++) {
        size_t keep = m * (size_t)(PLFT_CURVE - k) / PLFT_CURVE;
        size_t bad = 0;
        for (i = 0; i < keep; i++) {
            bad += (size_t)list[i].bad;
        }
        curve[k] = keep ? 100.0 * (double)bad / (double)keep : 0;
    }
    free(list);
    return 0;
}

double plft_scatter_ratio(const float *error, const uint8_t *use, const float *sigma,
                          size_t n)
{
    double *ratio = plft_alloc(n, sizeof *ratio);
    double result = NAN;
    size_t m = 0;
    size_t i;

    if (ratio == NULL) {
        return NAN;
    }
    for (i = 0; i < n; i++) {
        if (use[i] && isfinite(error[i]) && isfinite(sigma[i]) && sigma[i] > 0) {
            ratio[m++] = fabs((double)error[i]) / (double)sigma[i];
        }
    }
    if (m > 0) {
        qsort(ratio, m, sizeof *ratio, by_value);
        result = 1.4826 * ratio[m / 2];
    }
    free(ratio);
    return result;
}
