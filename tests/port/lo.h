/* SPDX-License-Identifier: MIT
 * A network of one's own: a namespace in which only loopback exists, so that cameras
 * served by a test are seen by nobody else.  Needs root or user namespaces. */
#ifndef PLENOFIX_TESTS_LO_H
#define PLENOFIX_TESTS_LO_H

#include <net/if.h>
#include <sched.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

/* Enter it.  0, or -1: this system does not allow it; then open no socket. */
static int lo_enter(void)
{
    struct ifreq request;
    int s;
    int failed;

    if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
        return -1;
    }
    s = socket(AF_INET, SOCK_DGRAM, 0);
    if (s < 0) {
        return -1;
    }
    memset(&request, 0, sizeof request);
    strcpy(request.ifr_name, "lo");
    request.ifr_flags = IFF_UP | IFF_RUNNING | IFF_LOOPBACK;
    failed = ioctl(s, SIOCSIFFLAGS, &request);
    (void)close(s);
    return failed ? -1 : 0;
}

#endif
