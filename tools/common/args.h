/* SPDX-License-Identifier: MIT
 * Command lines: one table of options a sub-command, from which parsing, --help and
 * error messages come. */
#ifndef PLFT_ARGS_H
#define PLFT_ARGS_H

#include <stddef.h>

typedef enum plft_kind {
    PLFT_FLAG, /* int *: set to 1 */
    PLFT_INT,  /* int *, within [lo, hi] */
    PLFT_REAL, /* double *, within [lo, hi] */
    PLFT_TEXT, /* const char ** */
    PLFT_WORD  /* int *: index in the list `words` "a|b|c" */
} plft_kind;

typedef struct plft_option {
    const char *name; /* "--window" or "-o"; NULL ends the table */
    plft_kind kind;
    void *target;
    const char *words; /* PLFT_WORD: the list; else what --help calls the value */
    double lo, hi;
    const char *help;
} plft_option;

typedef struct plft_usage {
    const char *command;  /* "depth" */
    const char *synopsis; /* "RAW --lut CAM.plut -o OUT.pfm [options]" */
    const char *about;    /* one or two lines */
} plft_usage;

/* Parse argv[1..): options fill their targets, operands go to `operands` (at most
 * `max`, count in *n).  --help prints and sets *helped.  0, or PLFT_USAGE with one line
 * that names the option, the value and what is allowed. */
int plft_args(int argc, char **argv, const plft_usage *usage,
              const plft_option *options, const char **operands, int max, int *n,
              int *helped);

#endif
