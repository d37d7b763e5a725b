/* SPDX-License-Identifier: MIT */
#include "motion/uff.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "common/out.h"

/* Kind of data: type, exponents of length, force, temperature, label, unit. */
static void axis(FILE *f, int type, const char *label, const char *unit)
{
    fprintf(f, "%10d%5d%5d%5d %-20s %-20s\n", type, 0, 0, 0, label, unit);
}

static void head(FILE *f, int region, int a, int rows, int missing, double dt,
                 const char *unit)
{
    fprintf(f, "    -1\n    58\n");
    fprintf(f, "region %d component %c\n", region, "uvw"[a]);
    fprintf(f, "samples not measured: %d\nNONE\nNONE\nNONE\n", missing);
    fprintf(f, "%5d%10d%5d%10d %-10s%10d%4d %-10s%10d%4d\n", 1, 0, 0, 0, "NONE",
            region + 1, a + 1, "NONE", 0, 0);
    fprintf(f, "%10d%10d%10d%13.5E%13.5E%13.5E\n", 4, rows, 1, 0.0, dt, 0.0);
    axis(f, 17, "time", "s");
    axis(f, 8, "displacement", unit);
    axis(f, 0, "NONE", "NONE");
    axis(f, 0, "NONE", "NONE");
}

static void one(FILE *f, const double *v, int rows, size_t step)
{
    int r;

    for (r = 0; r < rows; r++) {
        double x = v[(size_t)r * step];
        fprintf(f, "%20.12E%s", isfinite(x) ? x : 0.0,
                r % 4 == 3 || r == rows - 1 ? "\n" : "");
    }
    fprintf(f, "    -1\n");
}

/* Code 5: mm, mN; divide by the factors to come to m, N, K. */
static void nodes(FILE *f, const double (*place)[3], int regions)
{
    int k;

    fprintf(f, "    -1\n   164\n%10d%-20s%10d\n", 5, "mm (milli-newton)", 2);
    fprintf(f, "%25.17E%25.17E%25.17E\n%25.17E\n    -1\n", 1e3, 1e3, 1.0, 273.15);
    fprintf(f, "    -1\n    15\n");
    for (k = 0; k < regions; k++) {
        fprintf(f, "%10d%10d%10d%10d%13.5E%13.5E%13.5E\n", k + 1, 0, 0, 0, place[k][0],
                place[k][1], place[k][2]);
    }
    fprintf(f, "    -1\n");
}

int plft_uff_write(const char *path, const double *series, int rows, int regions,
                   double dt, const char *unit, const double (*place)[3])
{
    plft_out out = {NULL, NULL, NULL};
    size_t step = 3u * (size_t)regions;
    int rc = plft_out_open(&out, path);
    int k;
    int a;
    int r;

    if (rc == 0 && place != NULL) {
        nodes(out.file, place, regions);
    }
    for (k = 0; rc == 0 && k < regions; k++) {
        for (a = 0; a < 3; a++) {
            const double *v = series + 3 * k + a;
            int missing = 0;
            for (r = 0; r < rows; r++) {
                missing += !isfinite(v[(size_t)r * step]);
            }
            head(out.file, k, a, rows, missing, dt, unit);
            one(out.file, v, rows, step);
        }
    }
    return rc ? rc : plft_out_commit(&out);
}
