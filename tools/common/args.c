/* SPDX-License-Identifier: MIT */
#include "common/args.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/progress.h"

static void print_option(const plft_option *o)
{
    char left[80];

    (void)snprintf(left, sizeof left, "%s%s%s", o->name,
                   o->kind == PLFT_FLAG ? "" : " ",
                   o->kind == PLFT_FLAG ? "" : o->words);
    printf("  %-28s %s\n", left, o->help);
}

static void print_help(const plft_usage *usage, const plft_option *o)
{
    printf("usage: plenofix %s %s\n\n%s\n\n", usage->command, usage->synopsis,
           usage->about);
    for (; o->name != NULL; o++) {
        print_option(o);
    }
    printf("  %-28s %s\n", "--quiet", "no progress bar");
    printf("  %-28s %s\n", "--help", "this text");
}

static int bad_value(const plft_option *o, const char *text)
{
    if (o->kind == PLFT_WORD) {
        return plft_fail(PLFT_USAGE, "%s %s: want one of %s", o->name, text, o->words);
    }
    return plft_fail(PLFT_USAGE, "%s %s: want %s from %g to %g", o->name, text,
                     o->kind == PLFT_INT ? "a whole number" : "a number", o->lo, o->hi);
}

static int set_number(const plft_option *o, const char *text)
{
    char *end;
    double v = strtod(text, &end);

    if (end == text || *end != '\0' || !(v >= o->lo && v <= o->hi)) {
        return bad_value(o, text);
    }
    if (o->kind == PLFT_REAL) {
        *(double *)o->target = v;
        return 0;
    }
    if (v != floor(v)) {
        return bad_value(o, text);
    }
    *(int *)o->target = (int)v;
    return 0;
}

static int set_word(const plft_option *o, const char *text)
{
    const char *w = o->words;
    size_t n = strlen(text);
    int k;

    for (k = 0; w != NULL; k++) {
        const char *bar = strchr(w, '|');
        size_t m = bar != NULL ? (size_t)(bar - w) : strlen(w);
        if (m == n && memcmp(w, text, n) == 0) {
            *(int *)o->target = k;
            return 0;
        }
        w = bar != NULL ? bar + 1 : NULL;
    }
    return bad_value(o, text);
}

static int set_value(const plft_option *o, const char *text)
{
    switch (o->kind) {
    case PLFT_INT:
    case PLFT_REAL:
        return set_number(o, text);
    case PLFT_WORD:
        return set_word(o, text);
    case PLFT_TEXT:
        if (text[0] == '\0') {
            return plft_fail(PLFT_USAGE, "%s: want %s, not an empty word", o->name,
                             o->words);
        }
        *(const char **)o->target = text;
        return 0;
    case PLFT_FLAG:
    default:
        *(int *)o->target = 1;
        return 0;
    }
}

/* The option that `arg` names, "--name=value" too; *value then points into `arg`. */
static const plft_option *find(const plft_option *o, char *arg, char **value)
{
    for (*value = NULL; o->name != NULL; o++) {
        size_t n = strlen(o->name);
        if (strncmp(arg, o->name, n) == 0) {
            if (arg[n] == '\0') {
                return o;
            }
            if (arg[n] == '=' && n > 2) {
                *value = arg + n + 1;
                return o;
            }
        }
    }
    return NULL;
}

static int take_option(const plft_usage *usage, const plft_option *options, int argc,
                       char **argv, int *i)
{
    char *value;
    const plft_option *o = find(options, argv[*i], &value);

    if (o == NULL) {
        return plft_fail(PLFT_USAGE, "%s: no option %s; see plenofix %s --help",
                         usage->command, argv[*i], usage->command);
    }
    if (o->kind == PLFT_FLAG) {
        return value == NULL ? set_value(o, "")
                             : plft_fail(PLFT_USAGE, "%s takes no value", o->name);
    }
    if (value == NULL && *i + 1 >= argc) {
        return plft_fail(PLFT_USAGE, "%s: want %s after it", o->name, o->words);
    }
    return set_value(o, value != NULL ? value : argv[++*i]);
}

int plft_args(int argc, char **argv, const plft_usage *usage,
              const plft_option *options, const char **operands, int max, int *n,
              int *helped)
{
    int i, rc = 0, plain = 0;

    *n = 0;
    *helped = 0;
    for (i = 1; i < argc && rc == 0; i++) {
        if (!plain && strcmp(argv[i], "--help") == 0) {
            print_help(usage, options);
            *helped = 1;
            return 0;
        }
        if (!plain && strcmp(argv[i], "--quiet") == 0) {
            plft_quiet(1);
        } else if (!plain && strcmp(argv[i], "--") == 0) {
            plain = 1;
        } else if (!plain && argv[i][0] == '-' && argv[i][1] != '\0') {
            rc = take_option(usage, options, argc, argv, &i);
        } else if (*n == max) {
            rc = plft_fail(PLFT_USAGE,
                           "%s: one operand too many: %s; see plenofix %s "
                           "--help",
                           usage->command, argv[i], usage->command);
        } else {
            operands[(*n)++] = argv[i];
        }
    }
    return rc;
}
