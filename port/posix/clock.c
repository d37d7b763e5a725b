/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "clock.h"

#include <errno.h>
#include <time.h>

#define SECOND 1000000000u

static uint64_t now(void *context)
{
    struct timespec t;

    (void)context;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * SECOND + (uint64_t)t.tv_nsec;
}

static plfx_status sleep_until(void *context, uint64_t ns)
{
    struct timespec t;
    int failed;

    (void)context;
    t.tv_sec = (time_t)(ns / SECOND);
    t.tv_nsec = (long)(ns % SECOND);
    do { /* again after each signal */
        failed = clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
    } while (failed == EINTR);
    return failed ? PLFX_E_IO : PLFX_OK;
}

plfx_clock plfx_posix_monotonic(void)
{
    plfx_clock c;

    c.context = NULL;
    c.now_ns = now;
    c.sleep_until = sleep_until;
    c.id = PLFX_CLOCK_MONOTONIC;
    return c;
}
