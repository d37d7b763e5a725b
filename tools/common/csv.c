/* SPDX-License-Identifier: MIT */
#include "common/csv.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"
#include "common/out.h"

static int is_gap(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

static int is_mark(char c)
{
    return c == ',' || c == ';';
}

static const char *skip_gaps(const char *p, const char *end)
{
    while (p < end && is_gap(*p)) {
        p++;
    }
    return p;
}

/* One field at *p, up to `end` of the line; leaves *p at the next field.  0, or
 * PLFT_DATA when it is no number. */
static int field(const char **p, const char *end, double *v)
{
    char text[64];
    size_t n = 0;
    char *stop;

    *p = skip_gaps(*p, end);
    while (*p < end && !is_gap(**p) && !is_mark(**p) && n + 1 < sizeof text) {
        text[n++] = *(*p)++;
    }
    text[n] = '\0';
    *p = skip_gaps(*p, end);
    if (*p < end && is_mark(**p)) {
        (*p)++;
    }
    if (n == 0) {
        *v = (double)NAN;
        return 0;
    }
    *v = strtod(text, &stop);
    return *stop == '\0' ? 0 : PLFT_DATA;
}

/* Fields of a line into v[]; -1 when one is no number, or there are too many. */
static int split(const char *p, const char *end, double *v)
{
    const char *last = p;
    int n = 0;

    p = skip_gaps(p, end);
    while (p < end) {
        if (n == PLFT_CSV_COLS_MAX || field(&p, end, &v[n]) != 0) {
            return -1;
        }
        last = p - 1;
        n++;
    }
    if (n > 0 && n < PLFT_CSV_COLS_MAX && is_mark(*last)) { /* an empty last field */
        v[n++] = (double)NAN;
    }
    return n;
}

static int keep_header(plft_csv *csv, const char *p, const char *end)
{
    size_t n = (size_t)(end - p);

    csv->header = (char *)plft_alloc(n + 1, 1);
    if (csv->header == NULL) {
        return PLFT_DATA;
    }
    memcpy(csv->header, p, n);
    return 0;
}

static int add_row(plft_csv *csv, size_t *room, const double *v)
{
    size_t cols = (size_t)csv->cols;

    if (csv->rows == *room) {
        size_t more = *room == 0 ? 256 : *room * 2;
        double *p = (double *)realloc(csv->v, more * cols * sizeof *p);
        if (p == NULL) {
            return plft_fail(PLFT_DATA, "out of memory: %zu rows", more);
        }
        csv->v = p;
        *room = more;
    }
    memcpy(csv->v + csv->rows * cols, v, cols * sizeof *v);
    csv->rows++;
    return 0;
}

static int take_line(plft_csv *csv, size_t *room, const char *p, const char *end,
                     size_t line, const char *name)
{
    double v[PLFT_CSV_COLS_MAX];
    int n;

    p = skip_gaps(p, end);
    if (p == end || *p == '#') {
        return 0;
    }
    n = split(p, end, v);
    if (n < 0 && csv->rows == 0 && csv->header == NULL) {
        return keep_header(csv, p, end);
    }
    if (n < 1) {
        return plft_fail(PLFT_DATA, "%s: line %zu: not a row of numbers", name, line);
    }
    if (csv->rows == 0) {
        csv->cols = n;
    }
    if (n != csv->cols) {
        return plft_fail(PLFT_DATA,
                         "%s: line %zu: %d fields where the first row has %d", name,
                         line, n, csv->cols);
    }
    return add_row(csv, room, v);
}

int plft_csv_parse(plft_csv *csv, const char *text, size_t n, const char *name)
{
    const char *p = text, *end = text + n;
    size_t room = 0, line = 1;
    int rc = 0;

    memset(csv, 0, sizeof *csv);
    for (; p < end && rc == 0; line++) {
        const char *stop = (const char *)memchr(p, '\n', (size_t)(end - p));
        stop = stop != NULL ? stop : end;
        rc = take_line(csv, &room, p, stop, line, name);
        p = stop < end ? stop + 1 : end;
    }
    if (rc == 0 && csv->rows == 0) {
        rc = plft_fail(PLFT_DATA, "%s: holds no row of numbers", name);
    }
    if (rc != 0) {
        plft_csv_free(csv);
    }
    return rc;
}

int plft_csv_read(plft_csv *csv, const char *path)
{
    unsigned char *bytes = NULL;
    size_t n = 0;
    int rc = plft_in_bytes(path, &bytes, &n);

    memset(csv, 0, sizeof *csv);
    if (rc == 0) {
        rc = plft_csv_parse(csv, (const char *)bytes, n, path);
    }
    free(bytes);
    return rc;
}

static int same_name(const char *a, size_t n, const char *b)
{
    size_t i;

    for (i = 0; i < n && b[i] != '\0'; i++) {
        if (tolower((unsigned char)a[i]) != tolower((unsigned char)b[i])) {
            return 0;
        }
    }
    return i == n && b[i] == '\0';
}

int plft_csv_column(const plft_csv *csv, const char *name)
{
    const char *p = csv->header;
    int col = 0;

    while (p != NULL && *p != '\0') {
        size_t n = strcspn(p, ",; \t\r");
        if (same_name(p, n, name)) {
            return col;
        }
        p += n;
        p += strspn(p, ",; \t\r");
        col++;
    }
    return -1;
}

void plft_csv_free(plft_csv *csv)
{
    free(csv->v);
    free(csv->header);
    memset(csv, 0, sizeof *csv);
}
