/* SPDX-License-Identifier: MIT
 * figures run: a program with its CPU time and peak memory. */
#define _DEFAULT_SOURCE 1 /* wait4() */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/err.h"
#include "figures/figures.h"

/* Lines of the log: label, CPU seconds, peak memory in MiB. */
static int note(const char *path, const char *label, const struct rusage *use)
{
    FILE *log = fopen(path, "a");
    double cpu = (double)(use->ru_utime.tv_sec + use->ru_stime.tv_sec) +
                 (double)(use->ru_utime.tv_usec + use->ru_stime.tv_usec) * 1e-6;
    int bad;

    if (log == NULL) {
        return plft_fail(PLFT_DATA, "%s: %s", path, strerror(errno));
    }
    bad = fprintf(log, "%s\t%.3f\t%.1f\n", label, cpu,
                  (double)use->ru_maxrss / 1024.0) < 0;
    bad |= fclose(log) != 0;
    return bad ? plft_fail(PLFT_DATA, "%s: cannot write", path) : 0;
}

int plft_figure_run(int argc, char **argv)
{
    struct rusage use;
    int status = 0;
    pid_t child;

    if (argc < 4) {
        return plft_fail(PLFT_USAGE, "run: want LOG LABEL PROGRAM ARGS...");
    }
    child = fork();
    if (child == 0) {
        (void)execvp(argv[3], argv + 3);
        _exit(127);
    }
    if (child < 0 || wait4(child, &status, 0, &use) != child) {
        return plft_fail(PLFT_DATA, "run: %s: %s", argv[3], strerror(errno));
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        return WIFEXITED(status) ? WEXITSTATUS(status) : PLFT_DATA;
    }
    return note(argv[1], argv[2], &use);
}
