/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "common/progress.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

#define BAR_COLUMNS 40

static int is_quiet;

void plft_quiet(int quiet)
{
    is_quiet = quiet;
}

static double now_s(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void draw(const char *what, double done)
{
    int full = (int)(done * BAR_COLUMNS);
    int i;

    fprintf(stderr, "\r%-12s [", what);
    for (i = 0; i < BAR_COLUMNS; i++) {
        fputc(i < full ? '#' : ' ', stderr);
    }
    fprintf(stderr, "] %3d %%%s", (int)(done * 100.0), done >= 1.0 ? "\n" : "");
}

void plft_progress(const char *what, double done)
{
    static double start, last; /* 0: no bar is running */

    if (is_quiet || !isatty(STDERR_FILENO)) {
        return;
    }
    if (start <= 0.0) {
        start = now_s();
        last = start;
    }
    /* Nothing for a second, then 10 times a second; the end closes a bar. */
    if (now_s() - last > (last > start ? 0.1 : 1.0) || (done >= 1.0 && last > start)) {
        last = now_s();
        draw(what, done < 0.0 ? 0.0 : done > 1.0 ? 1.0 : done);
    }
    if (done >= 1.0) {
        start = 0.0;
    }
}
