/* SPDX-License-Identifier: MIT
 * Tables of numbers as text: comma, semicolon, tab or blanks between fields, one
 * optional line of names, lines of '#' and blank lines skipped. */
#ifndef PLFT_CSV_H
#define PLFT_CSV_H

#include <stddef.h>

typedef struct plft_csv {
    double *v; /* [rows][cols]; an empty field is NaN */
    size_t rows;
    int cols;
    char *header; /* the header line as it stood, or NULL */
} plft_csv;

#define PLFT_CSV_COLS_MAX 64

/* Every line must have as many fields as the first.  0 or PLFT_DATA with a message that
 * names the line. */
int plft_csv_read(plft_csv *csv, const char *path);

/* The same from text of n bytes (a zero byte after its end); `name` is for messages. */
int plft_csv_parse(plft_csv *csv, const char *text, size_t n, const char *name);

/* Column of a name of the header (case ignored), or -1. */
int plft_csv_column(const plft_csv *csv, const char *name);

void plft_csv_free(plft_csv *csv);

#endif
