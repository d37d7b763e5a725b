/* SPDX-License-Identifier: MIT */
#include "motion/regions.h"

#include <math.h>
#include <stdio.h>

#include "common/csv.h"
#include "common/err.h"
#include "common/out.h"

static int whole(double v, double lo, double hi)
{
    return v >= lo && v <= hi && v == floor(v);
}

static int overlap(const plfx_roi_region *a, const plfx_roi_region *b)
{
    return fabs((double)a->i - b->i) <= a->hx + b->hx &&
           fabs((double)a->j - b->j) <= a->hy + b->hy;
}

/* Columns of i, j, hx, hy, reference; the last may be -1. */
static int columns(const plft_csv *csv, const char *path, int col[5])
{
    static const char *const name[5] = {"i", "j", "hx", "hy", "reference"};
    int k;

    for (k = 0; k < 5; k++) {
        col[k] = plft_csv_column(csv, name[k]);
        if (k < 4 && col[k] < 0) {
            return plft_fail(PLFT_DATA, "%s: no column %s; want i,j,hx,hy[,reference]",
                             path, name[k]);
        }
    }
    return 0;
}

static int fill(plfx_roi_cfg *cfg, const plft_csv *csv, const int col[5],
                const char *path)
{
    size_t r;
    int k;

    for (r = 0; r < csv->rows; r++) {
        const double *v = csv->v + r * (size_t)csv->cols;
        plfx_roi_region *q = &cfg->region[r];
        double ref = col[4] < 0 ? 0 : v[col[4]];
        if (!whole(v[col[0]], -4096, 8192) || !whole(v[col[1]], -4096, 8192) ||
            !whole(v[col[2]], 1, PLFX_ROI_HALF_MAX) ||
            !whole(v[col[3]], 1, PLFX_ROI_HALF_MAX) || !whole(ref, 0, 1)) {
            return plft_fail(PLFT_DATA,
                             "%s: region %zu: want whole lenses, half sizes 1 to %d, "
                             "reference 0 or 1",
                             path, r, PLFX_ROI_HALF_MAX);
        }
        q->i = (int16_t)v[col[0]];
        q->j = (int16_t)v[col[1]];
        q->hx = (uint8_t)v[col[2]];
        q->hy = (uint8_t)v[col[3]];
        q->reference = (uint8_t)ref;
        for (k = 0; k < (int)r; k++) {
            if (overlap(q, &cfg->region[k])) {
                plft_warn("%s: regions %d and %zu overlap: their errors are not "
                          "independent",
                          path, k, r);
            }
        }
    }
    cfg->regions = (int32_t)csv->rows;
    return 0;
}

int plft_regions_read(plfx_roi_cfg *cfg, const char *path)
{
    plft_csv csv;
    int col[5] = {0};
    int rc = plft_csv_read(&csv, path);

    if (rc != 0) {
        return rc;
    }
    rc = columns(&csv, path, col);
    if (rc == 0 && (csv.rows < 1 || csv.rows > PLFX_ROI_MAX)) {
        rc = plft_fail(PLFT_DATA, "%s: %zu regions, want 1 to %d", path, csv.rows,
                       PLFX_ROI_MAX);
    }
    rc = rc ? rc : fill(cfg, &csv, col, path);
    plft_csv_free(&csv);
    return rc;
}

static int places(const plft_csv *csv, const int col[3], const char *path,
                  double place[PLFX_ROI_MAX][3])
{
    size_t r;
    int k;

    for (r = 0; r < csv->rows && r < PLFX_ROI_MAX; r++) {
        for (k = 0; k < 3; k++) {
            place[r][k] = csv->v[r * (size_t)csv->cols + (size_t)col[k]];
            if (!isfinite(place[r][k])) {
                return plft_fail(PLFT_DATA, "%s: region %zu: want x_mm, y_mm and z_mm",
                                 path, r);
            }
        }
    }
    return 0;
}

int plft_regions_places(const char *path, double place[PLFX_ROI_MAX][3], int *known)
{
    static const char *const name[3] = {"x_mm", "y_mm", "z_mm"};
    int col[3];
    plft_csv csv;
    int rc = plft_csv_read(&csv, path);
    int k;

    *known = 0;
    if (rc != 0) {
        return rc;
    }
    for (k = 0; k < 3; k++) {
        col[k] = plft_csv_column(&csv, name[k]);
        *known += col[k] >= 0;
    }
    if (*known == 3) {
        rc = places(&csv, col, path, place);
    } else if (*known > 0) {
        rc = plft_fail(PLFT_DATA, "%s: want all of x_mm, y_mm, z_mm or none", path);
    }
    *known = *known == 3;
    plft_csv_free(&csv);
    return rc;
}

int plft_regions_write(const plfx_roi_region *region, int n, const char *path)
{
    plft_out out = {NULL, NULL, NULL};
    int rc = plft_out_open(&out, path);
    int k;

    if (rc == 0) {
        fprintf(out.file, "i,j,hx,hy,reference\n");
        for (k = 0; k < n; k++) {
            fprintf(out.file, "%d,%d,%d,%d,%d\n", region[k].i, region[k].j,
                    region[k].hx, region[k].hy, region[k].reference);
        }
        rc = plft_out_commit(&out);
    }
    return rc;
}
