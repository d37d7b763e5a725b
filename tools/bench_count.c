/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L /* popen(), getpid() */
#include "bench_count.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/err.h"

#define COMMAND_MAX 1024

int plft_count_ready(void)
{
    if (system("valgrind --version >/dev/null 2>&1") == 0) {
        return 0;
    }
    return plft_fail(PLFT_DATA,
                     "bench: --instructions needs valgrind, which does not run "
                     "here: install it or leave the option out");
}

/* The number behind "Collected :" in what a command says, 0 when there is none. */
static double collected(const char *command)
{
    char line[512];
    double found = 0;
    FILE *said = popen(command, "r");

    while (said != NULL && fgets(line, sizeof line, said) != NULL) {
        const char *at = strstr(line, "Collected :");
        found = at != NULL ? strtod(at + strlen("Collected :"), NULL) : found;
    }
    return said != NULL && pclose(said) == 0 ? found : 0;
}

/* A name holds no quote: it is one of our own. */
int plft_count(const char *name, plft_counted functions, double *instructions)
{
    char command[COMMAND_MAX] =
        "valgrind --tool=callgrind --callgrind-out-file=/dev/null";
    size_t n = strlen(command);

    for (size_t i = 0; functions[i] != NULL; i++) {
        n += (size_t)snprintf(command + n, sizeof command - n, " --toggle-collect=%s",
                              functions[i]);
    }
    (void)snprintf(command + n, sizeof command - n,
                   " /proc/%ld/exe bench --rounds 1 --only '%s' 2>&1", (long)getpid(),
                   name);
    *instructions = collected(command);
    if (*instructions > 0) {
        return 0;
    }
    return plft_fail(PLFT_DATA,
                     "bench: valgrind counts nothing in '%s': is the program "
                     "stripped of its symbols?",
                     name);
}
