/* SPDX-License-Identifier: MIT
 * Recordings, through a file in memory.  First byte odd: the checksums of the header
 * and of the first record's head are made to hold.  Bit 1: opened to go on. */
#define _GNU_SOURCE
#include "fuzz.h"

#include "posix/checksum.h"
#include "posix/recording.h"
#include "store/bytes.h"

#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#define HEADER 4096u
#define HEAD   64u

static void mend(uint8_t *b, size_t n)
{
    if (n >= HEAD) {
        plfx_store_u32(b + 60, plfx_checksum(0, b, 60));
    }
    if (n >= HEADER + HEAD) {
        plfx_store_u32(b + HEADER + 36,
                       plfx_checksum(0, b + HEADER + HEAD, n - HEADER - HEAD));
        plfx_store_u32(b + HEADER + 60, plfx_checksum(0, b + HEADER, 60));
    }
}

static void use(const char *path, int append)
{
    plfx_camera_frame frame;
    plfx_recording r;
    uint8_t *room;
    uint64_t i;

    if (plfx_recording_open(&r, path, append) != PLFX_OK) {
        return;
    }
    if (r.payload < 1u << 20) {
        room = fuzz_room(r.payload);
        for (i = 0; i <= r.count && i < 4; i++) {
            plfx_status s = plfx_recording_read(&r, i, room, r.payload, &frame);
            fuzz_must(i < r.count || s == PLFX_E_ARG);
        }
        free(room);
    }
    plfx_recording_close(&r);
}

/* Inputs are short: the bytes from 64 on stand behind the header's page. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint32_t how = fuzz_u8(&in);
    size_t size = in.left > HEAD ? in.left + HEADER - HEAD : in.left;
    uint8_t *copy = fuzz_room(size);
    int file = memfd_create("input", 0);
    char path[32];

    memcpy(copy, in.at, in.left < HEAD ? in.left : HEAD);
    if (in.left > HEAD) {
        memcpy(copy + HEADER, in.at + HEAD, in.left - HEAD);
    }
    if (how & 1u) {
        mend(copy, size);
    }
    if (file >= 0 && write(file, copy, size) == (ssize_t)size) {
        (void)snprintf(path, sizeof path, "/proc/self/fd/%d", file);
        use(path, (how & 2u) != 0);
    }
    if (file >= 0) {
        (void)close(file);
    }
    free(copy);
    return 0;
}
