/* SPDX-License-Identifier: MIT
 * A progress bar on stderr for work over a second; silent when stderr is no terminal or
 * after plft_quiet(1). */
#ifndef PLFT_PROGRESS_H
#define PLFT_PROGRESS_H

void plft_quiet(int quiet);
void plft_progress(const char *what, double done); /* 0 .. 1; 1 ends the line */

#endif
