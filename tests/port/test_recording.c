/* SPDX-License-Identifier: MIT
 * Recordings: cut off, damaged, on a full disk, and with the recorder killed. */
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "../unit/suite.h"
#include "scratch.h"
#include "posix/checksum.h"
#include "posix/recording.h"
#include "store/crc.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#define W       37
#define H       11
#define PAYLOAD ((W * H * 12 + 7) / 8)
#define SEED    0xcafeu

static uint8_t pixels[PAYLOAD];

static plfx_recording_info info_of(void)
{
    plfx_recording_info i = {W, H, PLFX_RAW_MONO12P, 12, PLFX_BAYER_GRBG, 77, 0x1234};

    return i;
}

/* Frame k: bytes, time and numbers that tell it from others. */
static plfx_camera_frame frame_of(uint32_t k)
{
    plfx_camera_frame f;
    size_t i;

    memset(&f, 0, sizeof f);
    for (i = 0; i < PAYLOAD; i++) {
        pixels[i] = (uint8_t)((i * 7u + k * 31u) ^ (i >> 3));
    }
    f.raw.bytes = pixels;
    f.raw.size = PAYLOAD;
    f.raw.format = PLFX_RAW_MONO12P;
    f.raw.bits = 12;
    f.raw.w = W;
    f.raw.h = H;
    f.rows = H;
    f.time_ns = 5000000000u + k * 1000003ull;
    f.clock = PLFX_CLOCK_MONOTONIC;
    f.sequence = k + 65500u;
    f.dropped = k % 3u;
    return f;
}

static void record(const char *path, uint32_t n)
{
    plfx_recording_info info = info_of();
    plfx_recording r;
    uint32_t k;

    (void)unlink(path);
    assert_int_equal(plfx_recording_create(&r, path, &info), PLFX_OK);
    for (k = 0; k < n; k++) {
        plfx_camera_frame f = frame_of(k);
        assert_int_equal(plfx_recording_add(&r, &f), PLFX_OK);
    }
    assert_int_equal(plfx_recording_sync(&r), PLFX_OK);
    assert_int_equal(r.synced, n);
    plfx_recording_close(&r);
}

static void check(plfx_recording *r, uint32_t k)
{
    uint8_t back[PAYLOAD];
    plfx_camera_frame f;
    plfx_camera_frame want = frame_of(k);

    assert_int_equal(plfx_recording_read(r, k, back, sizeof back, &f), PLFX_OK);
    assert_memory_equal(back, pixels, PAYLOAD);
    assert_int_equal(f.time_ns, want.time_ns);
    assert_int_equal(f.sequence, want.sequence);
    assert_int_equal(f.dropped, want.dropped);
    assert_int_equal(f.clock, PLFX_CLOCK_MONOTONIC);
    assert_int_equal(f.bayer, PLFX_BAYER_GRBG);
    assert_ptr_equal(f.raw.bytes, back);
}

static void frames_come_back(void **state)
{
    plfx_recording r;
    struct stat about;
    uint32_t k;

    (void)state;
    record(scratch("a"), 9);
    assert_int_equal(stat(scratch("a"), &about), 0);
    assert_int_equal(plfx_recording_open(&r, scratch("a"), 0), PLFX_OK);
    assert_int_equal(r.count, 9);
    assert_int_equal(r.cut, 0);
    assert_int_equal(r.stride, 1024);
    assert_int_equal(about.st_size, 4096 + 9 * 1024);
    assert_int_equal(r.info.camera_id, 77);
    assert_int_equal(r.info.table_crc, 0x1234);
    for (k = 0; k < 9; k++) {
        check(&r, k);
    }
    plfx_recording_close(&r);
    plfx_recording_close(&r);
}

static void fast_checksum_is_the_slow_one(void **state)
{
    size_t from;
    size_t n;

    (void)state;
    (void)frame_of(3);
    assert_int_equal(plfx_checksum(0, (const uint8_t *)"123456789", 9), 0xcbf43926u);
    for (from = 0; from < 9; from++) {
        for (n = 0; n < 70; n++) {
            assert_int_equal(plfx_checksum(0x55aau, pixels + from, n),
                             plfx_port_crc32(0x55aau, pixels + from, n));
        }
    }
}

/* Cut at every byte: all whole frames are there, and the file can be gone on with. */
static void cut_files_are_good_to_the_last_whole_frame(void **state)
{
    char path[128];
    long size;

    (void)state;
    strcpy(path, scratch("b"));
    for (size = 4096 + 3 * 1024; size >= 0; size -= size > 4096 ? 1 : 64) {
        plfx_recording r;
        uint32_t whole = size < 4096 + 64 + PAYLOAD
                             ? 0u
                             : 1u + (uint32_t)(size - 4096 - 64 - PAYLOAD) / 1024u;
        plfx_camera_frame f;
        if (size == 4096 + 3 * 1024 || size % 16 == 0) {
            record(path, 3);
        }
        assert_int_equal(truncate(path, size), 0);
        if (size < 4096) {
            assert_int_equal(plfx_recording_open(&r, path, 0), PLFX_E_FORMAT);
            continue;
        }
        assert_int_equal(plfx_recording_open(&r, path, 0), PLFX_OK);
        assert_int_equal(r.count, whole);
        plfx_recording_close(&r);
        if (size % 16 == 1) {
            assert_int_equal(plfx_recording_open(&r, path, 1), PLFX_OK);
            f = frame_of(whole);
            assert_int_equal(plfx_recording_add(&r, &f), PLFX_OK);
            assert_int_equal(r.count, whole + 1u);
            check(&r, whole);
            plfx_recording_close(&r);
            record(path, 3);
            assert_int_equal(truncate(path, size), 0);
        }
    }
}

static void flip(const char *path, long at)
{
    uint8_t b;
    int file = open(path, O_RDWR);

    assert_true(file >= 0);
    assert_int_equal(pread(file, &b, 1, at), 1);
    b ^= 0x10;
    assert_int_equal(pwrite(file, &b, 1, at), 1);
    assert_int_equal(close(file), 0);
}

static void damage_is_found_wherever_it_is(void **state)
{
    char path[128];
    uint8_t back[PAYLOAD];
    plfx_recording r;
    plfx_camera_frame f;
    long k;

    (void)state;
    strcpy(path, scratch("c"));
    record(path, 3);
    for (k = 0; k < 64 + PAYLOAD; k++) {
        flip(path, 4096 + 2 * 1024 + k); /* the last record */
        assert_int_equal(plfx_recording_open(&r, path, 0), PLFX_OK);
        assert_int_equal(r.count, 2);
        assert_int_not_equal(r.cut, 0);
        plfx_recording_close(&r);
        flip(path, 4096 + 2 * 1024 + k);
        flip(path, 4096 + 1024 + k); /* the one before: the last still counts */
        assert_int_equal(plfx_recording_open(&r, path, 0), PLFX_OK);
        assert_int_equal(r.count, 3);
        assert_int_equal(plfx_recording_read(&r, 1, back, sizeof back, &f),
                         PLFX_E_FORMAT);
        check(&r, 2);
        plfx_recording_close(&r);
        flip(path, 4096 + 1024 + k);
    }
    for (k = 0; k < 64; k++) {
        flip(path, k); /* the header */
        assert_int_equal(plfx_recording_open(&r, path, 0), PLFX_E_FORMAT);
        flip(path, k);
    }
}

/* Room for 2 records and a half: the third is refused, the two stay. */
static void full_disk_keeps_what_was_recorded(void **state)
{
    plfx_recording_info info = info_of();
    struct rlimit was;
    struct rlimit now;
    plfx_recording r;
    plfx_camera_frame f;
    uint32_t k;

    (void)state;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &was), 0);
    assert_int_equal(plfx_recording_create(&r, scratch("d"), &info), PLFX_OK);
    now = was;
    now.rlim_cur = 4096 + 2 * 1024 + 500;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &now), 0);
    for (k = 0; k < 4; k++) {
        f = frame_of(k);
        assert_int_equal(plfx_recording_add(&r, &f), k < 2 ? PLFX_OK : PLFX_E_IO);
    }
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &was), 0);
    assert_int_equal(r.error, EFBIG);
    assert_int_equal(r.count, 2);
    f = frame_of(2); /* room again */
    assert_int_equal(plfx_recording_add(&r, &f), PLFX_OK);
    for (k = 0; k < 3; k++) {
        check(&r, k);
    }
    plfx_recording_close(&r);
}

static void wrong_calls_are_refused(void **state)
{
    plfx_recording_info info = info_of();
    uint8_t back[PAYLOAD];
    plfx_recording r;
    plfx_camera_frame f = frame_of(0);

    (void)state;
    record(scratch("e"), 1);
    assert_int_equal(plfx_recording_create(&r, scratch("e"), &info), PLFX_E_IO);
    assert_int_equal(r.error, EEXIST);
    info.format = PLFX_RAW_U16; /* a machine's own order is no file format */
    assert_int_equal(plfx_recording_create(&r, scratch("f"), &info), PLFX_E_ARG);
    assert_int_equal(plfx_recording_open(&r, scratch("absent"), 0), PLFX_E_IO);
    assert_int_equal(r.error, ENOENT);
    assert_int_equal(plfx_recording_open(&r, scratch("e"), 0), PLFX_OK);
    assert_int_equal(plfx_recording_add(&r, &f), PLFX_E_STATE);
    assert_int_equal(plfx_recording_sync(&r), PLFX_E_STATE);
    assert_int_equal(plfx_recording_read(&r, 1, back, sizeof back, &f), PLFX_E_ARG);
    assert_int_equal(plfx_recording_read(&r, 0, back, 10, &f), PLFX_E_SIZE);
    plfx_recording_close(&r);
    assert_int_equal(plfx_recording_open(&r, scratch("e"), 1), PLFX_OK);
    f = frame_of(0);
    f.raw.w--;
    assert_int_equal(plfx_recording_add(&r, &f), PLFX_E_ARG);
    f = frame_of(0);
    f.raw.format = PLFX_RAW_MONO12PACKED;
    assert_int_equal(plfx_recording_add(&r, &f), PLFX_E_ARG);
    plfx_recording_close(&r);
}

#define KW 640
#define KH 480

/* The recorder: frames without end, every fourth call synced and told to the parent. */
static void recorder(const char *path, int tell)
{
    static uint8_t big[KW * KH];
    plfx_recording_info info = {KW, KH, PLFX_RAW_U8, 8, 0, 0, 0};
    plfx_camera_frame f = frame_of(0);
    plfx_recording r;
    uint32_t k;

    f.raw.bytes = big;
    f.raw.size = sizeof big;
    f.raw.format = PLFX_RAW_U8;
    f.raw.bits = 8;
    f.raw.w = KW;
    f.raw.h = f.rows = KH;
    if (plfx_recording_create(&r, path, &info) != PLFX_OK) {
        _exit(3);
    }
    for (k = 0; k < 1000000u; k++) {
        uint32_t synced;
        memset(big, (int)(k & 255u), sizeof big);
        f.sequence = k;
        if (plfx_recording_add(&r, &f) != PLFX_OK) {
            _exit(4);
        }
        if (k % 4u == 3u) {
            synced = k + 1u;
            if (plfx_recording_sync(&r) != PLFX_OK ||
                write(tell, &synced, sizeof synced) != (ssize_t)sizeof synced) {
                _exit(5);
            }
        }
    }
    _exit(0);
}

/* Frames that the killed recorder had synced and that are not there.  begun: it is
 * killed after it has synced once.  *kept: frames that are. */
static uint32_t lost_after_kill(const char *path, long delay_us, int begun,
                                uint64_t *kept)
{
    static uint8_t back[KW * KH];
    struct timespec wait = {0, delay_us * 1000};
    uint32_t synced = 0;
    uint32_t n = 0;
    uint32_t lost = 0;
    plfx_recording r;
    int pipe_of[2];
    pid_t child;

    (void)unlink(path);
    assert_int_equal(pipe(pipe_of), 0);
    child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        recorder(path, pipe_of[1]);
    }
    (void)close(pipe_of[1]);
    if (begun && read(pipe_of[0], &n, sizeof n) == (ssize_t)sizeof n) {
        synced = n;
    }
    (void)nanosleep(&wait, NULL);
    (void)kill(child, SIGKILL);
    (void)waitpid(child, NULL, 0);
    while (read(pipe_of[0], &n, sizeof n) == (ssize_t)sizeof n) {
        synced = n;
    }
    (void)close(pipe_of[0]);
    if (plfx_recording_open(&r, path, 1) != PLFX_OK) {
        return synced;
    }
    for (n = 0; n < synced; n++) {
        plfx_camera_frame f;
        lost += plfx_recording_read(&r, n, back, sizeof back, &f) != PLFX_OK ||
                f.sequence != n || back[5] != (n & 255u);
    }
    *kept += r.count;
    plfx_recording_close(&r);
    return lost;
}

static void killed_recorder_loses_nothing_synced(void **state)
{
    char path[128];
    uint32_t random = SEED;
    uint64_t kept = 0;
    uint32_t lost = 0;
    int k;

    (void)state;
    strcpy(path, scratch("k"));
    for (k = 0; k < 100; k++) {
        random = random * 1664525u + 1013904223u;
        lost +=
            lost_after_kill(path, 500 + (long)(random >> 8) % 30000, k % 8 != 0, &kept);
    }
    print_message("# 100 kills, %u frames kept, %u synced frames lost (seed %x)\n",
                  (unsigned)kept, (unsigned)lost, SEED);
    assert_int_equal(lost, 0);
    assert_true(kept > 100u);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(frames_come_back),
    cmocka_unit_test(fast_checksum_is_the_slow_one),
    cmocka_unit_test(cut_files_are_good_to_the_last_whole_frame),
    cmocka_unit_test(damage_is_found_wherever_it_is),
    cmocka_unit_test(full_disk_keeps_what_was_recorded),
    cmocka_unit_test(wrong_calls_are_refused),
    cmocka_unit_test(killed_recorder_loses_nothing_synced),
};

int main(void)
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, scratch_make, scratch_drop);
}
