/* SPDX-License-Identifier: MIT
 * Recordings, replayed cameras and mapped tables on a system whose operation i fails,
 * for every i, once and for ever; whose signals interrupt operation i; whose transfers
 * are short.  What was acknowledged stays, what is handed out is right, nothing is left
 * open, and after a failure that passes the call can be repeated. */
#define FAIL_NOT_HERE
#include "fail.h"

#include "../unit/suite.h"
#include "scratch.h"

#include "posix/clock.h"
#include "posix/replay.h"
#include "posix/table.h"

#include <stdarg.h>

#define W       20
#define H       9
#define PAYLOAD (W * H)
#define SLOT    192
#define FRAMES  3u
#define MOST    80u /* operations of a session, at most */

enum { SOUND, ONCE, EVER, SIGNAL };

/* The system. */
static struct {
    uint32_t count, when;
    int how;
    size_t most; /* bytes of a transfer; 0: all */
    int held;    /* files that are open */
} os;

/* Operation `when` comes to grief: errno is set. */
static int grief(int interrupted)
{
    uint32_t now = os.count++;

    if (os.how == SOUND || (os.how == EVER ? now < os.when : now != os.when) ||
        (os.how == SIGNAL && !interrupted)) {
        return 0;
    }
    errno = os.how == SIGNAL ? EINTR : EIO;
    return 1;
}

static size_t some(size_t n)
{
    return os.most && os.most < n ? os.most : n;
}

int fail_open(const char *path, int how, ...)
{
    int file = grief(0) ? -1 : open(path, how, 0600);

    os.held += file >= 0;
    return file;
}

int fail_close(int file)
{
    os.held--;
    return close(file);
}

int fail_fstat(int file, struct stat *about)
{
    return grief(0) ? -1 : fstat(file, about);
}

int fail_ftruncate(int file, off_t size)
{
    return grief(0) ? -1 : ftruncate(file, size);
}

int fail_sync(int file)
{
    (void)file;
    return grief(0) ? -1 : 0;
}

off_t fail_lseek(int file, off_t at, int from)
{
    return grief(0) ? -1 : lseek(file, at, from);
}

ssize_t fail_pread(int file, void *bytes, size_t n, off_t at)
{
    return grief(1) ? -1 : pread(file, bytes, some(n), at);
}

ssize_t fail_pwrite(int file, const void *bytes, size_t n, off_t at)
{
    return grief(0) ? -1 : pwrite(file, bytes, n, at);
}

ssize_t fail_writev(int file, const struct iovec *part, int n)
{
    struct iovec first = part[0];

    if (grief(1)) {
        return -1;
    }
    if (os.most == 0) {
        return writev(file, part, n);
    }
    first.iov_len = some(first.iov_len);
    return writev(file, &first, 1);
}

void *fail_mmap(void *at, size_t n, int protection, int how, int file, off_t from)
{
    return grief(0) ? MAP_FAILED : mmap(at, n, protection, how, file, from);
}

static void sound(void)
{
    os.count = 0;
    os.how = SOUND;
    os.most = 0;
}

static void fault(int how, uint32_t when)
{
    sound();
    os.how = how;
    os.when = when;
}

static void tell(uint32_t tried)
{
    print_message("# count: operations that failed, %u tried, 0 missed\n",
                  (unsigned)tried);
}

static uint8_t pixels[PAYLOAD];

static plfx_camera_frame frame_of(uint32_t k)
{
    plfx_camera_frame f;
    uint32_t i;

    for (i = 0; i < PAYLOAD; i++) {
        pixels[i] = (uint8_t)((i + 1u) * (k * 2u + 3u));
    }
    memset(&f, 0, sizeof f);
    f.raw.bytes = pixels;
    f.raw.size = PAYLOAD;
    f.raw.bits = 8;
    f.raw.w = W;
    f.raw.h = f.rows = H;
    f.clock = PLFX_CLOCK_CAMERA;
    f.time_ns = k * 1000000u;
    f.sequence = k;
    return f;
}

/* A call, made again once when it failed and failures pass: then it must succeed. */
static plfx_status again(plfx_status first, plfx_status second)
{
    if (first != PLFX_OK && os.how == ONCE) {
        assert_int_equal(second, PLFX_OK);
    }
    return first == PLFX_OK ? first : second;
}

#define TRY(call) (last = (call), last == PLFX_OK ? last : again(last, (call)))

/* Frames that the recorder was told are on the medium.  *failed: calls that said so. */
static uint32_t write_frames(const char *path, uint32_t *failed)
{
    plfx_recording_info info = {W, H, PLFX_RAW_U8, 8, 0, 0, 0};
    plfx_recording r;
    plfx_status last;
    uint32_t kept = 0;
    uint32_t k;

    *failed = 0;
    (void)unlink(path);
    if (TRY(plfx_recording_create(&r, path, &info)) != PLFX_OK) {
        assert_int_equal(last, PLFX_E_IO);
        assert_int_equal(r.error, EIO);
        assert_int_equal(access(path, F_OK), -1); /* no head: no file */
        *failed = 1;
        return 0;
    }
    *failed += last != PLFX_OK;
    for (k = 0; k < FRAMES; k++) {
        plfx_camera_frame f = frame_of(k);
        if (TRY(plfx_recording_add(&r, &f)) == PLFX_OK &&
            TRY(plfx_recording_sync(&r)) == PLFX_OK) {
            kept = k + 1;
        } else {
            assert_int_equal(last, PLFX_E_IO);
            assert_int_equal(r.error, EIO);
            ++*failed;
            break;
        }
    }
    plfx_recording_close(&r);
    return kept;
}

/* Every frame that a sound system finds is right; there are `least` and more. */
static void check_file(const char *path, uint32_t least)
{
    plfx_recording r;
    plfx_camera_frame f;
    uint8_t back[PAYLOAD];
    uint32_t k;

    sound();
    if (plfx_recording_open(&r, path, 0) != PLFX_OK) {
        assert_int_equal(least, 0);
        return;
    }
    assert_in_range(r.count, least, FRAMES);
    for (k = 0; k < r.count; k++) {
        (void)frame_of(k);
        assert_int_equal(plfx_recording_read(&r, k, back, PAYLOAD, &f), PLFX_OK);
        assert_memory_equal(back, pixels, PAYLOAD);
        assert_int_equal(f.sequence, k);
    }
    plfx_recording_close(&r);
}

static void recording_keeps_what_it_acknowledged(void **state)
{
    static const int hows[] = {ONCE, EVER, SIGNAL};
    uint32_t failed;
    uint32_t total;
    uint32_t i;
    size_t h;

    (void)state;
    sound();
    assert_int_equal(write_frames(scratch("w"), &failed), FRAMES);
    total = os.count;
    assert_in_range(total, 12, MOST);
    for (h = 0; h < sizeof hows / sizeof hows[0]; h++) {
        for (i = 0; i < total; i++) {
            uint32_t kept;
            fault(hows[h], i);
            kept = write_frames(scratch("w"), &failed);
            assert_int_equal(kept < FRAMES, hows[h] == EVER);
            assert_int_equal(os.held, 0);
            check_file(scratch("w"), kept);
        }
    }
    tell(3u * total);
    sound();
    os.most = 7;
    assert_int_equal(write_frames(scratch("w"), &failed), FRAMES);
    check_file(scratch("w"), FRAMES);
}

/* Open, read everything, and when `append` one frame more. */
static uint32_t read_frames(const char *path, int append)
{
    uint8_t back[PAYLOAD];
    plfx_camera_frame f;
    plfx_recording r;
    plfx_status last;
    uint32_t good = 0;
    uint32_t k;

    if (TRY(plfx_recording_open(&r, path, append)) != PLFX_OK) {
        assert_int_equal(last, PLFX_E_IO);
        assert_int_equal(r.error, EIO);
        return 0;
    }
    assert_int_equal(r.count, FRAMES);
    for (k = 0; k < FRAMES; k++) {
        memset(&f, 0x55, sizeof f);
        if (TRY(plfx_recording_read(&r, k, back, PAYLOAD, &f)) == PLFX_OK) {
            (void)frame_of(k);
            assert_memory_equal(back, pixels, PAYLOAD);
            good++;
        } else {
            assert_int_equal(last, PLFX_E_IO);
            assert_int_equal(f.sequence, 0x55555555u); /* untouched */
        }
    }
    plfx_recording_close(&r);
    return good;
}

static void reading_never_takes_a_failure_for_data(void **state)
{
    static const int hows[] = {ONCE, EVER, SIGNAL};
    uint32_t failed;
    size_t h;
    int append;

    (void)state;
    sound();
    assert_int_equal(write_frames(scratch("r"), &failed), FRAMES);
    for (append = 0; append < 2; append++) {
        uint32_t total;
        uint32_t i;
        sound();
        assert_int_equal(read_frames(scratch("r"), append), FRAMES);
        total = os.count;
        for (h = 0; h < sizeof hows / sizeof hows[0]; h++) {
            for (i = 0; i < total; i++) {
                fault(hows[h], i);
                assert_int_equal(read_frames(scratch("r"), append) < FRAMES,
                                 hows[h] == EVER);
                assert_int_equal(os.held, 0);
            }
        }
        tell(3u * total);
        check_file(scratch("r"), FRAMES);
        os.most = 1;
        assert_int_equal(read_frames(scratch("r"), append), FRAMES);
    }
}

static uint8_t memory[2 * SLOT];
static uint64_t fake_ns;

static uint64_t fake_now(void *context)
{
    (void)context;
    return fake_ns;
}

static plfx_status fake_sleep(void *context, uint64_t ns)
{
    (void)context;
    fake_ns = ns;
    return grief(0) ? PLFX_E_IO : PLFX_OK;
}

static plfx_camera_cfg wish(int bare)
{
    plfx_camera_cfg c;

    memset(&c, 0, sizeof c);
    if (bare) {
        c.w = W;
        c.h = H;
        c.bits = 8;
    }
    return c;
}

/* One frame, by rows when the camera gives bands. */
static plfx_status grab(plfx_replay *r, plfx_camera_frame *f)
{
    plfx_status last;
    plfx_status status = TRY(r->camera.acquire(r, 1000, f));

    if (status == PLFX_OK && r->bands) {
        status = TRY(r->camera.rows(r, f, 2, 1000));
        if (status == PLFX_OK) {
            status = TRY(r->camera.rows(r, f, H, 1000));
        }
        if (status != PLFX_OK) {
            assert_int_equal(r->camera.release(r, f), PLFX_OK);
        }
    }
    return status;
}

/* Plays a file; frames that came. */
static uint32_t play(const char *path, int bare, int bands)
{
    plfx_clock clock = {NULL, fake_now, fake_sleep, PLFX_CLOCK_MONOTONIC};
    plfx_pool pool = {memory, SLOT, 2};
    plfx_camera_cfg cfg = wish(bare);
    plfx_camera_frame f;
    plfx_replay r;
    plfx_status last;
    uint32_t good = 0;
    uint32_t k;

    plfx_replay_init(&r, path, clock);
    r.bare = bare;
    r.bands = bands;
    if (TRY(r.camera.open(&r, &cfg, &pool)) != PLFX_OK) {
        assert_int_equal(last, PLFX_E_DEVICE);
        assert_int_equal(r.camera.start(&r), PLFX_E_STATE);
        return 0;
    }
    assert_int_equal(r.camera.start(&r), PLFX_OK);
    for (k = 0; k < FRAMES; k++) {
        plfx_status status = grab(&r, &f);
        if (status != PLFX_OK) {
            assert_true(status == PLFX_E_DEVICE || status == PLFX_E_IO);
            break;
        }
        (void)frame_of(k);
        assert_memory_equal(f.raw.bytes, pixels, PAYLOAD);
        assert_int_equal(f.rows, H);
        assert_int_equal(r.camera.release(&r, &f), PLFX_OK);
        good++;
    }
    assert_int_equal(r.camera.stop(&r), PLFX_OK);
    r.camera.close(&r);
    return good;
}

static void bare_file(const char *path)
{
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    uint32_t k;

    assert_true(file >= 0);
    for (k = 0; k < FRAMES; k++) {
        (void)frame_of(k);
        assert_int_equal(write(file, pixels, PAYLOAD), PAYLOAD);
    }
    (void)close(file);
}

static void replay_fails_at(const char *path, int bare, int bands)
{
    static const int hows[] = {ONCE, EVER, SIGNAL};
    uint32_t total;
    uint32_t i;
    size_t h;

    sound();
    assert_int_equal(play(path, bare, bands), FRAMES);
    total = os.count;
    assert_in_range(total, 5, MOST);
    for (h = 0; h < sizeof hows / sizeof hows[0]; h++) {
        for (i = 0; i < total; i++) {
            fault(hows[h], i);
            assert_int_equal(play(path, bare, bands) < FRAMES, hows[h] == EVER);
            assert_int_equal(os.held, 0);
        }
    }
    sound();
    os.most = 5;
    assert_int_equal(play(path, bare, bands), FRAMES);
    tell(3u * total);
}

static void replayed_camera_fails_at_every_operation(void **state)
{
    uint32_t failed;
    int bands;

    (void)state;
    sound();
    assert_int_equal(write_frames(scratch("p"), &failed), FRAMES);
    for (bands = 0; bands < 2; bands++) {
        replay_fails_at(scratch("p"), 0, bands);
    }
    bare_file(scratch("b"));
    for (bands = 0; bands < 2; bands++) {
        replay_fails_at(scratch("b"), 1, bands);
    }
}

static void table_file(const char *path)
{
    static uint8_t blob[512];
    plfx_lut_desc d;
    int file;

    memset(&d, 0, sizeof d);
    d.sensor_w = d.sensor_h = 40;
    d.sensor_bits = 8;
    d.lattice.nx = d.lattice.ny = 2;
    d.lattice.origin.x_q16 = d.lattice.origin.y_q16 = 10 << 16;
    d.lattice.a.x_q22 = d.lattice.b.y_q22 = 10 * 4194304;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), PLFX_OK);
    file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    assert_true(file >= 0);
    assert_int_equal(write(file, blob, plfx_lut_bytes(&d)), plfx_lut_bytes(&d));
    (void)close(file);
}

static void mapped_table_fails_at_every_operation(void **state)
{
    plfx_posix_table t;
    uint32_t total;
    uint32_t i;

    (void)state;
    table_file(scratch("t"));
    sound();
    assert_int_equal(plfx_posix_table_open(&t, scratch("t")), PLFX_OK);
    plfx_posix_table_close(&t);
    total = os.count;
    assert_int_equal(total, 3);
    for (i = 0; i < total; i++) {
        fault(ONCE, i);
        assert_int_equal(plfx_posix_table_open(&t, scratch("t")), PLFX_E_IO);
        assert_null(t.map);
        assert_int_equal(os.held, 0);
        assert_int_equal(plfx_posix_table_open(&t, scratch("t")), PLFX_OK);
        plfx_posix_table_close(&t);
    }
    tell(total);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(recording_keeps_what_it_acknowledged),
    cmocka_unit_test(reading_never_takes_a_failure_for_data),
    cmocka_unit_test(replayed_camera_fails_at_every_operation),
    cmocka_unit_test(mapped_table_fails_at_every_operation),
};

int main(void)
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, scratch_make, scratch_drop);
}
