/* SPDX-License-Identifier: MIT
 * Scatter and bias of the mode tracker over records of 60 s, and shapes of a wing.
 * usage: bench_modal_scatter [records]
 * Each record: one mode of known frequency and damping under random excitation with
 * 20 % white noise, tracked from 1 % off.  Bound (Gersch 1974): sd f/f =
 * sqrt(zeta/(2*pi*n)), sd zeta/zeta = sqrt(1/(2*pi*zeta*n)), n = f*T cycles.
 * Exit status 1 when a figure is over its limit. */
#include <stdio.h>
#include <stdlib.h>

#include "oscillator.h"
#include "plenofix/modal.h"

#define RATE    200.0
#define SECONDS 60
#define SAMPLES 12000
#define STATION 8

static plfx_modal m, channel[STATION];
static int failures;

static void judge(const char *what, double value, double limit)
{
    printf("  %-44s %9.4f (limit %.4f)%s\n", what, value, limit,
           value <= limit ? "" : "  OVER");
    failures += !(value <= limit);
}

static int start(plfx_modal *t, double f, double z)
{
    plfx_modal_cfg c = {200000, 0, 0, 0, 8};

    c.freq_uhz = (uint32_t)(f * 1.01e6);
    c.every = plfx_modal_every(c.rate_mhz, c.freq_uhz, (int32_t)(z * 1e6));
    c.block = (int32_t)(SECONDS * RATE / c.every / PLFX_MODAL_BLOCKS);
    return plfx_modal_init(t, &c);
}

static int mode(double f, double z, int records)
{
    double sum[4] = {0, 0, 0, 0}; /* f, f*f, z, z*z, relative errors */
    double stated[2] = {0, 0};
    double cycles = f * SECONDS;
    double bound_f = sqrt(z / (2 * PI * cycles));
    double bound_z = sqrt(1 / (2 * PI * z * cycles));
    double sd_f;
    double sd_z;
    int valid = 0;
    int k;
    int t;

    for (k = 0; k < records; k++) {
        oscillator o = {0, 0};
        plfx_mode out;
        double e;
        if (start(&m, f, z)) {
            return 1;
        }
        for (t = 0; t < 4000; t++) {
            (void)swing(&o, f, z, z, RATE);
        }
        for (t = 0; t < SAMPLES; t++) {
            double x = swing(&o, f, z, z, RATE) + 0.2 * gauss();
            (void)plfx_modal_push(&m, sample(2000.0 * x));
        }
        if (plfx_modal_read(&m, PLFX_MODAL_BLOCKS, &out)) {
            return 1;
        }
        if (out.flags != PLFX_MODE_VALID) {
            continue;
        }
        valid++;
        e = out.freq_uhz / 1e6 / f - 1;
        sum[0] += e;
        sum[1] += e * e;
        e = out.damp_ppm / 1e6 / z - 1;
        sum[2] += e;
        sum[3] += e * e;
        stated[0] += out.freq_sigma_uhz / 1e6 / f;
        stated[1] += out.damp_sigma_ppm / 1e6 / z;
    }
    for (k = 0; k < 4; k++) {
        sum[k] /= valid;
    }
    sd_f = sqrt(sum[1] - sum[0] * sum[0]);
    sd_z = sqrt(sum[3] - sum[2] * sum[2]);
    printf("%.1f Hz, %.1f %%: %d of %d valid; f sd %.3f %% (bound %.3f), damping sd "
           "%.1f %% (bound %.1f), its bias %+.1f +- %.1f %%\n",
           f, 100 * z, valid, records, 100 * sd_f, 100 * bound_f, 100 * sd_z,
           100 * bound_z, 100 * sum[2], 100 * sd_z / sqrt(valid));
    judge("frequency rms, % (0.5 or 1.5 x bound)", 100 * sqrt(sum[1]),
          1.5 * bound_f > 0.005 ? 150 * bound_f : 0.5);
    judge("frequency rms over bound", sqrt(sum[1]) / bound_f, 1.5);
    judge("damping bias, %", 100 * fabs(sum[2]), 10);
    judge("stated f sigma off by, %", 100 * fabs(stated[0] / valid / sd_f - 1), 25);
    judge("stated damping sigma off by, %", 100 * fabs(stated[1] / valid / sd_z - 1),
          25);
    judge("records not valid, %", 100.0 - 100.0 * valid / records, 1);
    return 0;
}

/* Deflection at x of a cantilever's bending mode, 1 at the tip. */
static double bending(int order, double x)
{
    static const double beta[2] = {1.87510407, 4.69409113};
    double b = beta[order];
    double s = (cosh(b) + cos(b)) / (sinh(b) + sin(b));
    double tip = cosh(b) - cos(b) - s * (sinh(b) - sin(b));

    return (cosh(b * x) - cos(b * x) - s * (sinh(b * x) - sin(b * x))) / tip;
}

/* Four stations along each edge of the wing; the modes and the share of each. */
static double shape(int k, int station)
{
    double x = 0.25 * (station % 4 + 1);
    double side = station < 4 ? 1 : -1;

    return k == 0   ? bending(0, x)
           : k == 1 ? 0.4 * bending(1, x)
                    : 0.25 * side * sin(PI / 2 * x);
}

static int shapes(void)
{
    static const double f[3] = {6.2, 22.0, 38.9};
    static const double z[3] = {0.015, 0.012, 0.010};
    int k;

    printf("shapes at 8 stations, three modes at once, 5 %% noise\n");
    for (k = 0; k < 3; k++) {
        plfx_modal_shape sum[STATION] = {{0, 0, 0}};
        oscillator o[3] = {{0, 0}, {0, 0}, {0, 0}};
        double tt = 0;
        double rr = 0;
        double tr = 0;
        int t;
        int c;
        for (c = 0; c < STATION; c++) {
            if (start(&channel[c], f[k], z[k])) {
                return 1;
            }
        }
        for (t = 0; t < SAMPLES; t++) {
            double q[3];
            int ready = 0;
            for (c = 0; c < 3; c++) {
                q[c] = swing(&o[c], f[c], z[c], z[c], RATE);
            }
            for (c = 0; c < STATION; c++) {
                double x = q[0] * shape(0, c) + q[1] * shape(1, c) + q[2] * shape(2, c);
                ready =
                    plfx_modal_push(&channel[c], sample(2000 * (x + 0.05 * gauss())));
            }
            for (c = 0; ready && c < STATION; c++) {
                plfx_modal_shape_add(&sum[c], &channel[c], &channel[3]);
            }
        }
        for (c = 0; c < STATION; c++) {
            double s = (double)sum[c].re / (double)sum[c].ref;
            tr += s * shape(k, c);
            tt += shape(k, c) * shape(k, c);
            rr += s * s;
        }
        printf("  %.1f Hz", f[k]);
        judge("1 - MAC against the true shape", 1 - tr * tr / (tt * rr), 0.05);
    }
    return 0;
}

int main(int argc, char **argv)
{
    int records = argc > 1 ? atoi(argv[1]) : 200;

    if (records < 10 || mode(6.2, 0.015, records) || mode(22.0, 0.012, records) ||
        mode(38.9, 0.010, records) || shapes()) {
        return 2;
    }
    return failures > 0;
}
