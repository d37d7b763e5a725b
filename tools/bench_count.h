/* SPDX-License-Identifier: MIT
 * Instructions of one case of `plenofix bench`, counted by valgrind. */
#ifndef PLFT_BENCH_COUNT_H
#define PLFT_BENCH_COUNT_H

/* Functions of the core that a case times; NULL ends the list. */
typedef const char *const *plft_counted;

/* Is valgrind here?  0, or PLFT_DATA with one line. */
int plft_count_ready(void);

/* Runs this program's `bench --only NAME`, one round, under callgrind and counts what
 * the functions execute.  Slow: some fifty times the time.  0, or PLFT_DATA with one
 * line. */
int plft_count(const char *name, plft_counted functions, double *instructions);

#endif
