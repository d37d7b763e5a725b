/* SPDX-License-Identifier: MIT
 * Small symmetric systems and order statistics. */
#include "calib/linalg.h"

#include <math.h>

/* Lower triangle of m becomes L with m = L*L'. */
static int cholesky(double *m, int n)
{
    int i, j, k;

    for (i = 0; i < n; i++) {
        double diagonal = m[i * n + i];
        for (j = 0; j <= i; j++) {
            double s = m[i * n + j];
            for (k = 0; k < j; k++) {
                s -= m[i * n + k] * m[j * n + k];
            }
            if (j < i) {
                m[i * n + j] = s / m[j * n + j];
            } else if (s > 1e-12 * diagonal) {
                m[i * n + i] = sqrt(s);
            } else {
                return -1;
            }
        }
    }
    return 0;
}

/* Column c of the inverse of L*L'. */
static void solve_unit(const double *l, int n, int c, double *x)
{
    int i, k;

    for (i = 0; i < n; i++) {
        double s = i == c ? 1.0 : 0.0;
        for (k = 0; k < i; k++) {
            s -= l[i * n + k] * x[k];
        }
        x[i] = s / l[i * n + i];
    }
    for (i = n - 1; i >= 0; i--) {
        double s = x[i];
        for (k = i + 1; k < n; k++) {
            s -= l[k * n + i] * x[k];
        }
        x[i] = s / l[i * n + i];
    }
}

int plft_spd_invert(double *m, int n)
{
    double inverse[PLFT_SPD_MAX * PLFT_SPD_MAX];
    int i;

    if (n < 1 || n > PLFT_SPD_MAX || cholesky(m, n) != 0) {
        return -1;
    }
    for (i = 0; i < n; i++) {
        solve_unit(m, n, i, inverse + i * n);
    }
    for (i = 0; i < n * n; i++) {
        m[i] = inverse[i];
    }
    return 0;
}

void plft_mat_vec(const double *m, const double *v, int n, double *x)
{
    int i, k;

    for (i = 0; i < n; i++) {
        x[i] = 0.0;
        for (k = 0; k < n; k++) {
            x[i] += m[i * n + k] * v[k];
        }
    }
}

double plft_select(double *v, int n, int k)
{
    int lo = 0, hi = n - 1;

    while (lo < hi) {
        double pivot = v[lo + (hi - lo) / 2];
        int i = lo, j = hi;
        while (i <= j) {
            while (v[i] < pivot) {
                i++;
            }
            while (v[j] > pivot) {
                j--;
            }
            if (i <= j) {
                double swap = v[i];
                v[i++] = v[j];
                v[j--] = swap;
            }
        }
        if (k <= j) {
            hi = j;
        } else if (k >= i) {
            lo = i;
        } else {
            break;
        }
    }
    return v[k];
}

double plft_median(double *v, int n)
{
    return n > 0 ? plft_select(v, n, (n - 1) / 2) : 0.0;
}
