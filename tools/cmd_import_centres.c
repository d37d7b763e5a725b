/* SPDX-License-Identifier: MIT
 * import-centres: a lens table from centres that another program measured. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/linalg.h"
#include "calib/order.h"
#include "commands.h"
#include "common/args.h"
#include "common/csv.h"
#include "common/err.h"
#include "common/memory.h"
#include "common/out.h"
#include "common/table.h"

#define POINTS_MIN 9
#define TERMS_MAX  10 /* of the smooth residual: cubic in x and y */

typedef struct request {
    const char *csv, *size, *out;
    double radius;
    int lattice; /* 0 auto, 1 square, 2 hex */
    int bits, smooth, w, h, camera;
} request;

typedef struct centres { /* measured, one a point */
    double *xy;
    int *row, *col;
    uint8_t *flags;
    int n, has_flags;
} centres;

static void centres_free(centres *c)
{
    free(c->xy);
    free(c->row);
    free(c->col);
    free(c->flags);
}

static int centres_alloc(centres *c, size_t n)
{
    memset(c, 0, sizeof *c);
    c->n = (int)n;
    c->xy = (double *)plft_alloc(n, 2 * sizeof *c->xy);
    c->row = (int *)plft_alloc(n, sizeof *c->row);
    c->col = (int *)plft_alloc(n, sizeof *c->col);
    c->flags = (uint8_t *)plft_alloc(n, 1);
    return c->xy != NULL && c->row != NULL && c->col != NULL && c->flags != NULL
               ? 0
               : PLFT_DATA;
}

/* Which columns hold what: by name, else by their number. */
static int columns(const plft_csv *csv, const char *path, int at[5])
{
    static const char *const names[5] = {"row", "col", "x", "y", "flags"};
    int k;

    for (k = 0; k < 5; k++) {
        at[k] = plft_csv_column(csv, names[k]);
    }
    if (csv->header == NULL && csv->cols == 2) {
        at[2] = 0;
        at[3] = 1;
    } else if (csv->header == NULL && (csv->cols == 4 || csv->cols == 5)) {
        for (k = 0; k < csv->cols; k++) {
            at[k] = k;
        }
    }
    if (at[2] < 0 || at[3] < 0 || (at[0] < 0) != (at[1] < 0)) {
        return plft_fail(PLFT_DATA, "%s: want columns row,col,x,y[,flags] or x,y",
                         path);
    }
    for (k = 0; k < 5; k++) {
        if (at[k] >= csv->cols) {
            return plft_fail(PLFT_DATA,
                             "%s: the header names more columns than there are", path);
        }
    }
    return 0;
}

static int take_point(centres *c, const double *v, const int at[5], int k,
                      const char *path)
{
    double x = v[at[2]], y = v[at[3]];

    if (!(fabs(x) < 40000.0 && fabs(y) < 40000.0)) {
        return plft_fail(PLFT_DATA, "%s: point %d has no place on a sensor", path,
                         k + 1);
    }
    c->xy[2 * k] = x;
    c->xy[2 * k + 1] = y;
    if (at[0] >= 0) {
        double row = v[at[0]], col = v[at[1]];
        if (!(fabs(row) < 30000.0 && fabs(col) < 30000.0) || row != floor(row) ||
            col != floor(col)) {
            return plft_fail(PLFT_DATA, "%s: point %d has no whole row and column",
                             path, k + 1);
        }
        c->row[k] = (int)row;
        c->col[k] = (int)col;
    }
    if (at[4] >= 0) {
        c->flags[k] =
            (uint8_t)((unsigned)(v[at[4]] > 0.0 && v[at[4]] < 256.0 ? v[at[4]] : 0.0) &
                      15u);
        c->has_flags = 1;
    }
    return 0;
}

static int read_centres(centres *c, const char *path, int *labelled)
{
    plft_csv csv;
    int at[5], k, rc = plft_csv_read(&csv, path);

    memset(c, 0, sizeof *c);
    if (rc != 0) {
        return rc;
    }
    rc = columns(&csv, path, at);
    if (rc == 0 && (csv.rows < POINTS_MIN || csv.rows > 4000000)) {
        rc = plft_fail(PLFT_DATA, "%s: %zu centres; want %d to 4 million", path,
                       csv.rows, POINTS_MIN);
    }
    rc = rc != 0 ? rc : centres_alloc(c, csv.rows);
    for (k = 0; k < c->n && rc == 0; k++) {
        rc = take_point(c, csv.v + (size_t)k * (size_t)csv.cols, at, k, path);
    }
    *labelled = at[0] >= 0;
    plft_csv_free(&csv);
    return rc;
}

/* Least squares of x and y on `terms` functions of a point; coef[terms][2]. */
typedef void basis(const centres *c, int k, double *f);

static int fit(const centres *c, basis *b, int terms, const double *target,
               double *coef)
{
    double m[TERMS_MAX * TERMS_MAX] = {0}, rhs[2][TERMS_MAX] = {{0}, {0}};
    double f[TERMS_MAX], x[TERMS_MAX];
    int k, p, q;

    for (k = 0; k < c->n; k++) {
        if (c->row[k] < 0 || (c->flags[k] & PLFX_LENS_MISSING) != 0) {
            continue;
        }
        b(c, k, f);
        for (p = 0; p < terms; p++) {
            for (q = 0; q < terms; q++) {
                m[p * terms + q] += f[p] * f[q];
            }
            rhs[0][p] += f[p] * target[2 * k];
            rhs[1][p] += f[p] * target[2 * k + 1];
        }
    }
    if (plft_spd_invert(m, terms) != 0) {
        return PLFT_DATA;
    }
    for (q = 0; q < 2; q++) {
        plft_mat_vec(m, rhs[q], terms, x);
        for (p = 0; p < terms; p++) {
            coef[2 * p + q] = x[p];
        }
    }
    return 0;
}

/* In hundreds of lenses, which keeps the normal equations tame. */
static void lattice_basis(const centres *c, int k, double *f)
{
    f[0] = 1.0;
    f[1] = c->col[k] / 100.0;
    f[2] = c->row[k] / 100.0;
    f[3] = c->row[k] % 2;
}

static void cubic_basis(const centres *c, int k, double *f)
{
    double x = c->xy[2 * k] / 1000.0, y = c->xy[2 * k + 1] / 1000.0;

    f[0] = 1.0;
    f[1] = x;
    f[2] = y;
    f[3] = x * x;
    f[4] = x * y;
    f[5] = y * y;
    f[6] = x * x * x;
    f[7] = x * x * y;
    f[8] = x * y * y;
    f[9] = y * y * y;
}

/* Rows and columns from 0. */
static int number_from_zero(centres *c, int *nx, int *ny, const char *path)
{
    int k, r0 = 1 << 20, c0 = 1 << 20, r1 = -(1 << 20), c1 = -(1 << 20);

    for (k = 0; k < c->n; k++) {
        r0 = c->row[k] < r0 ? c->row[k] : r0;
        r1 = c->row[k] > r1 ? c->row[k] : r1;
        c0 = c->col[k] < c0 ? c->col[k] : c0;
        c1 = c->col[k] > c1 ? c->col[k] : c1;
    }
    for (k = 0; k < c->n; k++) {
        c->row[k] -= r0;
        c->col[k] -= c0;
    }
    *nx = c1 - c0 + 1;
    *ny = r1 - r0 + 1;
    if (*nx < 2 || *ny < 2 || *nx > PLFX_LENSES_MAX || *ny > PLFX_LENSES_MAX) {
        return plft_fail(PLFT_DATA, "%s: %d x %d lenses; want 2 to %d on a side", path,
                         *nx, *ny, PLFX_LENSES_MAX);
    }
    return 0;
}

static void set_lattice(plft_lattice *l, const double *coef, int kind, int nx, int ny)
{
    memset(l, 0, sizeof *l);
    l->kind = kind;
    l->nx = nx;
    l->ny = ny;
    l->origin.x = coef[0];
    l->origin.y = coef[1];
    l->a.x = coef[2] / 100.0;
    l->a.y = coef[3] / 100.0;
    l->b.x = coef[4] / 100.0;
    l->b.y = coef[5] / 100.0;
    if (kind == PLFX_LATTICE_HEX) {
        l->odd.x = coef[6];
        l->odd.y = coef[7];
    }
}

/* Lattice through labelled centres; hexagonal when odd rows stand 0.3 to 0.7 of a step
 * beside the even ones. */
static int fit_lattice(const centres *c, int want, int nx, int ny, plft_lattice *l)
{
    double coef[8], along, a2;
    int kind = want;

    if (want != PLFX_LATTICE_SQUARE) {
        if (fit(c, lattice_basis, 4, c->xy, coef) != 0) {
            return PLFT_DATA;
        }
        a2 = (coef[2] * coef[2] + coef[3] * coef[3]) / 1e4;
        along = fabs(coef[6] * coef[2] + coef[7] * coef[3]) / 100.0 / a2;
        if (want == PLFT_LATTICE_AUTO) {
            kind = along > 0.3 && along < 0.7 ? PLFX_LATTICE_HEX : PLFX_LATTICE_SQUARE;
        }
    }
    if (kind == PLFX_LATTICE_SQUARE && fit(c, lattice_basis, 3, c->xy, coef) != 0) {
        return PLFT_DATA;
    }
    set_lattice(l, coef, kind, nx, ny);
    return 0;
}

static int place(centres *c, int labelled, int want, plft_lattice *l, const char *path)
{
    plft_order order;
    int nx, ny, k;

    if (labelled) {
        int rc = number_from_zero(c, &nx, &ny, path);
        if (rc != 0) {
            return rc;
        }
    } else {
        if (plft_order_points(c->xy, c->n, want, &order) != 0) {
            return plft_fail(PLFT_DATA, "%s: the points form no lattice of lenses",
                             path);
        }
        for (k = 0; k < c->n; k++) {
            c->row[k] = order.row[k];
            c->col[k] = order.col[k];
        }
        *l = order.lattice;
        if (order.placed < c->n) {
            plft_warn("%s: %d of %d points fit no place and are left out", path,
                      c->n - order.placed, c->n);
        }
        plft_order_free(&order);
        return 0;
    }
    return fit_lattice(c, want, nx, ny, l) == 0
               ? 0
               : plft_fail(PLFT_DATA, "%s: the points form no lattice of lenses", path);
}

typedef struct planes {
    int16_t *resid;
    uint8_t *flags;
} planes;

static int on_sensor(const request *r, plft_vec p)
{
    return p.x > -0.5 && p.y > -0.5 && p.x < r->w - 0.5 && p.y < r->h - 0.5;
}

static int put_resid(planes *p, const centres *c, int k, const double *d, size_t at,
                     const char *path)
{
    double x = floor(d[0] * 4096.0 + 0.5), y = floor(d[1] * 4096.0 + 0.5);

    if (fabs(x) > 32767.0 || fabs(y) > 32767.0) {
        return plft_fail(PLFT_DATA,
                         "%s: point %d (row %d, column %d) lies %.1f px off the "
                         "lattice, over the 8 px of a table",
                         path, k + 1, c->row[k], c->col[k], hypot(d[0], d[1]));
    }
    p->resid[2 * at] = (int16_t)x;
    p->resid[2 * at + 1] = (int16_t)y;
    return 0;
}

/* Offsets of the points from the lattice, as they are or through a cubic. */
static int residuals(const request *r, const centres *c, const plft_lattice *l,
                     double *d)
{
    double coef[2 * TERMS_MAX], f[TERMS_MAX];
    int k, p;

    for (k = 0; k < c->n; k++) {
        plft_vec at = plft_lattice_at(l, c->col[k], c->row[k]);
        d[2 * k] = c->xy[2 * k] - at.x;
        d[2 * k + 1] = c->xy[2 * k + 1] - at.y;
    }
    if (!r->smooth) {
        return 0;
    }
    if (fit(c, cubic_basis, TERMS_MAX, d, coef) != 0) {
        return plft_fail(PLFT_DATA, "%s: too few points for --smooth", r->csv);
    }
    for (k = 0; k < c->n; k++) {
        cubic_basis(c, k, f);
        d[2 * k] = d[2 * k + 1] = 0.0;
        for (p = 0; p < TERMS_MAX; p++) {
            d[2 * k] += coef[2 * p] * f[p];
            d[2 * k + 1] += coef[2 * p + 1] * f[p];
        }
    }
    return 0;
}

static int fill(const request *r, const centres *c, const plft_lattice *l, planes *p)
{
    size_t n = (size_t)l->nx * (size_t)l->ny, at;
    double *d = (double *)plft_alloc((size_t)c->n, 2 * sizeof *d);
    int k, rc = d == NULL ? PLFT_DATA : residuals(r, c, l, d);

    memset(p->flags, PLFX_LENS_MISSING, n);
    for (k = 0; k < c->n && rc == 0; k++) {
        plft_vec v;
        v.x = c->xy[2 * k];
        v.y = c->xy[2 * k + 1];
        if (c->row[k] < 0 || !on_sensor(r, v)) {
            continue;
        }
        at = (size_t)c->row[k] * (size_t)l->nx + (size_t)c->col[k];
        if ((p->flags[at] & PLFX_LENS_MISSING) == 0) {
            rc = plft_fail(PLFT_DATA, "%s: two points for row %d, column %d", r->csv,
                           c->row[k], c->col[k]);
            break;
        }
        p->flags[at] = c->flags[k];
        if ((c->flags[k] & PLFX_LENS_MISSING) == 0) {
            rc = put_resid(p, c, k, d + 2 * k, at, r->csv);
        }
    }
    free(d);
    return rc;
}

static int write_table(const request *r, const centres *c, const plft_lattice *l,
                       const planes *p)
{
    static const char made[] = "plenofix import-centres";
    plfx_lut_desc desc;
    size_t i, n = (size_t)l->nx * (size_t)l->ny;
    long missing = 0;
    double radius =
        r->radius > 0.0 ? r->radius : plft_usable_radius(plft_lattice_pitch(l));
    int rc;

    memset(&desc, 0, sizeof desc);
    desc.sensor_w = r->w;
    desc.sensor_h = r->h;
    desc.sensor_bits = r->bits;
    desc.camera_id = (uint32_t)r->camera;
    if (radius > plft_lattice_pitch(l) / 2.0) {
        return plft_fail(PLFT_USAGE, "--radius %g: over half the lens pitch, %.2f px",
                         radius, plft_lattice_pitch(l) / 2.0);
    }
    if (plft_lattice_quantise(l, &desc.lattice) != 0) {
        return plft_fail(PLFT_DATA, "%s: the lattice does not fit a lens table",
                         r->csv);
    }
    desc.lattice.nx = l->nx;
    desc.lattice.ny = l->ny;
    desc.radius_q8 = (int32_t)lround(radius * 256.0);
    desc.resid_q12 = p->resid;
    desc.flags = p->flags;
    desc.meta = (const uint8_t *)made;
    desc.meta_len = (uint32_t)(sizeof made - 1);
    for (i = 0; i < n; i++) {
        missing += (p->flags[i] & PLFX_LENS_MISSING) != 0;
    }
    rc = plft_table_write(r->out, &desc);
    if (rc == 0) {
        printf("%s: %d x %d lenses, %s, pitch %.4f px, %d centres, %ld missing, radius "
               "%.2f px\n",
               r->out, l->nx, l->ny,
               l->kind == PLFX_LATTICE_HEX ? "hexagonal" : "square",
               plft_lattice_pitch(l), c->n, missing, radius);
    }
    return rc;
}

static int run(const request *r)
{
    centres c;
    plft_lattice l = {0};
    planes p = {NULL, NULL};
    size_t n;
    int labelled, rc = read_centres(&c, r->csv, &labelled);

    rc = rc != 0 ? rc
                 : place(&c, labelled,
                         r->lattice == 0   ? PLFT_LATTICE_AUTO
                         : r->lattice == 1 ? PLFX_LATTICE_SQUARE
                                           : PLFX_LATTICE_HEX,
                         &l, r->csv);
    if (rc == 0) {
        n = (size_t)l.nx * (size_t)l.ny;
        p.resid = (int16_t *)plft_alloc(n, 2 * sizeof *p.resid);
        p.flags = (uint8_t *)plft_alloc(n, 1);
        rc = p.resid == NULL || p.flags == NULL ? PLFT_DATA : fill(r, &c, &l, &p);
    }
    rc = rc != 0 ? rc : write_table(r, &c, &l, &p);
    free(p.resid);
    free(p.flags);
    centres_free(&c);
    return rc;
}

static int parse_size(request *r)
{
    char rest;

    if (r->size == NULL) {
        return plft_fail(PLFT_USAGE, "want --size WxH, the sensor in pixels");
    }
    if (sscanf(r->size, "%dx%d%c", &r->w, &r->h, &rest) != 2 || r->w < 8 || r->h < 8 ||
        r->w > 32767 || r->h > 32767) {
        return plft_fail(PLFT_USAGE,
                         "--size %s: want WIDTHxHEIGHT, 8 to 32767 pixels each",
                         r->size);
    }
    return 0;
}

static const plft_usage usage = {
    "import-centres", "CENTRES.csv --size WxH -o CAM.plut [options]",
    "A lens table from centres measured elsewhere: rows \"row,col,x,y[,flags]\", or "
    "\"x,y\"\n"
    "in any order.  Pixel centres are at whole numbers, the first pixel's at 0."};

int plft_cmd_import_centres(int argc, char **argv)
{
    request r;
    const char *operand[1] = {NULL};
    int n, helped, rc;
    const plft_option options[] = {
        {"-o", PLFT_TEXT, &r.out, "CAM.plut", 0, 0, "the table"},
        {"--size", PLFT_TEXT, &r.size, "WxH", 0, 0, "sensor, pixels"},
        {"--radius", PLFT_REAL, &r.radius, "R", 0.5, 127,
         "usable radius of a lens, pixels; half the pitch less 2.5"},
        {"--lattice", PLFT_WORD, &r.lattice, "auto|square|hex", 0, 0, "kind of array"},
        {"--bits", PLFT_INT, &r.bits, "N", 8, 16, "of the sensor; 8"},
        {"--smooth", PLFT_FLAG, &r.smooth, NULL, 0, 0,
         "a cubic through the residuals: for centres in whole pixels"},
        {"--camera", PLFT_INT, &r.camera, "ID", 1, 2147483647,
         "whose table it is, as grab prints it; other cameras are refused"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};

    memset(&r, 0, sizeof r);
    r.bits = 8;
    rc = plft_args(argc, argv, &usage, options, operand, 1, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    r.csv = operand[0];
    if (n != 1 || r.out == NULL) {
        return plft_fail(PLFT_USAGE, "want CENTRES.csv and -o CAM.plut");
    }
    rc = parse_size(&r);
    rc = rc != 0 ? rc : plft_out_check(r.out);
    return rc != 0 ? rc : run(&r);
}
