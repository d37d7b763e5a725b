/* SPDX-License-Identifier: MIT */
#include "common/err.h"

#include <stdarg.h>
#include <stdio.h>

/* One line whatever the message holds: a file name may contain a newline. */
static void say(const char *lead, const char *format, va_list args)
{
    char line[1024];
    size_t i;

    if (vsnprintf(line, sizeof line, format, args) < 0) {
        line[0] = '\0';
    }
    for (i = 0; line[i] != '\0'; i++) {
        if ((unsigned char)line[i] < 32 || line[i] == 127) {
            line[i] = '?';
        }
    }
    fprintf(stderr, "plenofix: %s%s\n", lead, line);
}

int plft_fail(int status, const char *format, ...)
{
    va_list args;

    va_start(args, format);
    say("", format, args);
    va_end(args);
    return status;
}

void plft_warn(const char *format, ...)
{
    va_list args;

    va_start(args, format);
    say("warning: ", format, args);
    va_end(args);
}
