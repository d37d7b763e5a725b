/* SPDX-License-Identifier: MIT
 * Errors of the tools.  A function that can fail returns 0, or the exit status of the
 * program after it has printed one line to stderr: what, where, what to do. */
#ifndef PLFT_ERR_H
#define PLFT_ERR_H

#define PLFT_DATA  1 /* bad data, I/O */
#define PLFT_USAGE 2 /* bad command line */

/* Print "plenofix: <message>\n" to stderr; returns `status`. */
int plft_fail(int status, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Print "plenofix: warning: <message>\n" to stderr. */
void plft_warn(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
