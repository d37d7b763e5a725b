/* SPDX-License-Identifier: MIT */
#include "motion/bench.h"

#include <math.h>
#include <stdlib.h>

#include "common/err.h"

plft_floor plft_floor_of(const plft_series *s, int k, int axis)
{
    double t0 = 0, m = 0, tt = 0, tm = 0, ss = 0, rr = 0;
    plft_floor f = {0, NAN, NAN, NAN, NAN};
    int t;

    for (t = 0; t < s->frames; t++) {
        double v = plft_series_value(s, t, k, axis);
        if (isfinite(v)) {
            double e = plft_series_sigma(s, t, k, axis);
            f.n++;
            t0 += t;
            m += v;
            ss += e * e;
        }
    }
    if (f.n < 3) {
        return f;
    }
    t0 /= f.n;
    m /= f.n;
    for (t = 0; t < s->frames; t++) {
        double v = plft_series_value(s, t, k, axis);
        if (isfinite(v)) {
            tt += (t - t0) * (t - t0);
            tm += (t - t0) * (v - m);
        }
    }
    for (t = 0; t < s->frames; t++) {
        double v = plft_series_value(s, t, k, axis);
        if (isfinite(v)) {
            double r = v - m - tm / tt * (t - t0);
            rr += r * r;
        }
    }
    f.scatter = sqrt(rr / (f.n - 2));
    f.stated = sqrt(ss / f.n);
    f.drift = tm / tt * (s->frames - 1);
    f.drift_sigma = f.scatter / sqrt(tt) * (s->frames - 1);
    return f;
}

/* ---- steps ---- */

/* Measured value of region k at step n; NaN when flagged or not commanded. */
static double at_step(const plft_series *s, const plft_steps *steps, int n, int k,
                      int axis)
{
    int t = steps->frame[n] - s->first;

    return isfinite(steps->mm[n]) && t >= 0 && t < s->frames
               ? plft_series_value(s, t, k, axis)
               : (double)NAN;
}

typedef struct own { /* line of one region */
    double mean_c, mean_v, cc, cv;
    int n;
} own;

static own own_line(const plft_series *s, const plft_steps *steps, int k, int axis)
{
    own o = {0, 0, 0, 0, 0};
    int n;

    for (n = 0; n < steps->n; n++) {
        double v = at_step(s, steps, n, k, axis);
        if (isfinite(v)) {
            o.n++;
            o.mean_c += steps->mm[n];
            o.mean_v += v;
        }
    }
    o.mean_c /= o.n > 0 ? o.n : 1;
    o.mean_v /= o.n > 0 ? o.n : 1;
    for (n = 0; n < steps->n; n++) {
        double v = at_step(s, steps, n, k, axis);
        if (isfinite(v)) {
            o.cc += (steps->mm[n] - o.mean_c) * (steps->mm[n] - o.mean_c);
            o.cv += (steps->mm[n] - o.mean_c) * (v - o.mean_v);
        }
    }
    return o;
}

static int fit_scale(const own *o, int regions, plft_line *line)
{
    double cc = 0, cv = 0, spread = 0, scale;
    int used = 0, k;

    for (k = 0; k < regions; k++) {
        cc += o[k].cc;
        cv += o[k].cv;
    }
    scale = cc > 0 ? cv / cc : 0.0;
    if (!(fabs(scale) > 1e-9)) {
        return PLFT_DATA;
    }
    for (k = 0; k < regions; k++) {
        if (o[k].cc > 0) {
            double e = o[k].cv / o[k].cc - scale;
            spread += e * e;
            used++;
        }
    }
    line->mm_per_unit = 1.0 / scale;
    line->sigma =
        used > 1 ? sqrt(spread / (used - 1) / used) / (scale * scale) : (double)NAN;
    return 0;
}

static void judge_steps(const plft_series *s, const plft_steps *steps, int axis,
                        const own *o, plft_line *line, double *residual)
{
    double low = HUGE_VAL, high = -HUGE_VAL, within = 0, free = 0;
    int n, k;

    for (n = 0; n < steps->n; n++) {
        double sum = 0, square = 0;
        int m = 0;
        for (k = 0; k < s->cfg.regions; k++) {
            double v = at_step(s, steps, n, k, axis);
            if (isfinite(v) && o[k].n > 1) {
                double mm = (v - o[k].mean_v) * line->mm_per_unit + o[k].mean_c;
                sum += mm - steps->mm[n];
                square += (mm - steps->mm[n]) * (mm - steps->mm[n]);
                m++;
            } else {
                line->missing += isfinite(steps->mm[n]);
            }
        }
        if (m > 0) {
            within += square - sum * sum / m;
            free += m - 1;
            line->worst = fmax(line->worst, fabs(sum / m));
            low = fmin(low, steps->mm[n]);
            high = fmax(high, steps->mm[n]);
        }
        if (residual != NULL) {
            residual[n] = m > 0 ? sum / m : (double)NAN;
        }
        line->samples += m;
    }
    line->range = high - low;
    line->noise = sqrt(within / (free > 0 ? free : 1));
}

int plft_line_fit(const plft_series *s, const plft_steps *steps, int axis,
                  plft_line *line, double *residual)
{
    own o[PLFX_ROI_MAX];
    int n = 0, k;

    line->worst = 0.0;
    line->samples = line->missing = 0;
    for (k = 0; k < s->cfg.regions; k++) {
        o[k] = own_line(s, steps, k, axis);
        n = o[k].n > n ? o[k].n : n;
    }
    if (n < 3 || fit_scale(o, s->cfg.regions, line)) {
        return plft_fail(PLFT_DATA,
                         "axis %c: want 3 steps at least that differ and that a region "
                         "measured; the first frame of a step is %d",
                         "uvw"[axis], s -> first);
    }
    judge_steps(s, steps, axis, o, line, residual);
    return 0;
}
