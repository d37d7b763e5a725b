/* SPDX-License-Identifier: MIT
 * A GigE Vision camera served by this program to itself, over the loopback of a network
 * of its own.
 * usage: test_port_aravis CAMERA.xml [figures]   figures: the frame rate alone */
#define _GNU_SOURCE
#include "../unit/suite.h"
#include "lo.h"
#include "aravis/aravis.h"
#include "aravis/pfnc.h"

#include "plenofix/plenofix.h"

#include <arv.h>
#include <time.h>

#define SEED     42
#define SLOTS    6
#define BIG_W    4000
#define BIG_H    3000
#define BIG_SIZE 18000000u
#define LOSSY    400u
#define STAMP    4u   /* bytes: the number of the frame */
#define EVERY    512u /* bytes from stamp to stamp, less than a packet */

static uint8_t memory[SLOTS][(BIG_SIZE + 63u) / 64u * 64u]
    __attribute__((aligned(PLFX_ALIGN)));
static uint8_t served[BIG_SIZE]; /* what the camera sends */
static const char *xml;
static char ptp_xml[] = "/tmp/plenofix-ptp-XXXXXX";
static int64_t shift_ns; /* added to the time stamps that the camera sends */
static unsigned serial;
static guint32 frames_sent;

typedef struct server {
    ArvGvFakeCamera *gv;
    ArvFakeCamera *camera;
    char name[64];
} server;

/* Stamp n bytes all over: a part that stayed behind from an earlier frame shows. */
static void stamp_all(uint8_t *to, size_t n, uint32_t number)
{
    size_t k;

    for (k = 0; k + STAMP <= n; k += EVERY) {
        memcpy(to + k, &number, STAMP);
    }
}

/* Each frame is `served` with its number all over. */
static void fill(ArvBuffer *b, void *user, guint32 exposure, guint32 gain,
                 ArvPixelFormat format)
{
    size_t size;
    uint8_t *to = (uint8_t *)(uintptr_t)arv_buffer_get_data(b, &size);
    size_t n = arv_fake_camera_get_payload(user);

    (void)exposure;
    (void)gain;
    (void)format;
    memcpy(to, served, n);
    frames_sent++;
    stamp_all(to, n, frames_sent);
    arv_buffer_set_timestamp(b, arv_buffer_get_timestamp(b) +
                                    (guint64)g_atomic_pointer_get(&shift_ns));
}

/* What a camera with IEEE 1588 offers besides: registers that nothing else uses. */
#define ENABLE 0x2000
#define STATUS 0x2004
#define LATCH  0x2008
#define LOCKED 8 /* of the status: slave */

static const char ptp_nodes[] =
    "<IntReg Name='E'><Address>0x2000</Address><Length>4</Length>"
    "<AccessMode>RW</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable>"
    "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>"
    "<IntReg Name='S'><Address>0x2004</Address><Length>4</Length>"
    "<AccessMode>RO</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable>"
    "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>"
    "<IntReg Name='L'><Address>0x2008</Address><Length>4</Length>"
    "<AccessMode>RW</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable>"
    "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>"
    "<Boolean Name='PtpEnable'><pValue>E</pValue></Boolean>"
    "<Command Name='PtpDataSetLatch'><pValue>L</pValue>"
    "<CommandValue>1</CommandValue></Command>"
    "<Enumeration Name='PtpStatus'>"
    "<EnumEntry Name='Initializing'><Value>0</Value></EnumEntry>"
    "<EnumEntry Name='Listening'><Value>3</Value></EnumEntry>"
    "<EnumEntry Name='Uncalibrated'><Value>7</Value></EnumEntry>"
    "<EnumEntry Name='Slave'><Value>8</Value></EnumEntry>"
    "<pValue>S</pValue></Enumeration>";

/* The description of the camera that the tests serve, and those nodes. */
static void describe_ptp(void)
{
    gchar *text = NULL;
    gsize n = 0;
    gchar *at;
    int file = mkstemp(ptp_xml);

    assert_true(file >= 0 && g_file_get_contents(xml, &text, &n, NULL));
    at = strstr(text, "  <Port Name");
    assert_non_null(at);
    assert_int_equal(write(file, text, (size_t)(at - text)), at - text);
    assert_int_equal(write(file, ptp_nodes, sizeof ptp_nodes - 1),
                     sizeof ptp_nodes - 1);
    assert_int_equal(write(file, at, strlen(at)), strlen(at));
    (void)close(file);
    g_free(text);
}

static void serve_as(server *s, const char *description, double lost)
{
    char number[16];
    guint32 k;

    for (k = 0; k < BIG_SIZE; k++) {
        served[k] = (uint8_t)(k * 2654435761u >> 24);
    }
    (void)snprintf(number, sizeof number, "P%u", ++serial);
    (void)snprintf(s->name, sizeof s->name, "Aravis-Fake-%s", number);
    s->gv = arv_gv_fake_camera_new_full("127.0.0.1", number, description);
    assert_true(arv_gv_fake_camera_is_running(s->gv));
    s->camera = arv_gv_fake_camera_get_fake_camera(s->gv);
    arv_fake_camera_write_register(s->camera, ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH,
                                   BIG_W);
    arv_fake_camera_write_register(s->camera, ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT,
                                   BIG_H);
    arv_fake_camera_set_fill_pattern(s->camera, fill, s->camera);
    frames_sent = 0;
    if (lost > 0) {
        g_random_set_seed(SEED);
        g_object_set(s->gv, "gvsp-lost-ratio", lost, NULL);
    }
}

static void serve(server *s, double lost)
{
    serve_as(s, xml, lost);
}

static plfx_camera_cfg config(int32_t w, int32_t h, uint8_t format, uint8_t bits)
{
    plfx_camera_cfg c;

    memset(&c, 0, sizeof c);
    c.w = w;
    c.h = h;
    c.format = format;
    c.bits = bits;
    c.gain_mdb = INT32_MIN;
    c.rate_mhz = 100000;
    c.exposure_us = 2000;
    return c;
}

static plfx_pool pool_of(int32_t slots)
{
    plfx_pool p = {memory[0], sizeof memory[0], slots};

    return p;
}

/* Many small slots: a busy machine may let a camera wait for long. */
static plfx_pool pool_for(const plfx_camera_cfg *cfg)
{
    size_t n = PLFX_ALIGNED(plfx_raw_bytes(cfg->format, cfg->w, cfg->h));
    plfx_pool p = {memory[0], n, (int32_t)(sizeof memory / n)};

    p.slots = p.slots < PLFX_ARAVIS_SLOTS ? p.slots : PLFX_ARAVIS_SLOTS;
    return p;
}

static void open_camera(plfx_aravis *a, const server *s, plfx_camera_cfg *cfg)
{
    plfx_pool pool = pool_for(cfg);
    plfx_status status;

    plfx_aravis_init(a, s->name);
    status = a->camera.open(a, cfg, &pool);
    if (status != PLFX_OK) {
        fail_msg("open: %d %s", status, a->message);
    }
    status = a->camera.start(a);
    if (status != PLFX_OK) {
        fail_msg("start: %d %s", status, a->message);
    }
}

static void end(plfx_aravis *a, server *s)
{
    (void)a->camera.stop(a);
    a->camera.close(a);
    a->camera.close(a);
    g_object_unref(s->gv);
}

static uint32_t stamp_of(const plfx_camera_frame *f)
{
    uint32_t n;

    memcpy(&n, f->raw.bytes, STAMP);
    return n;
}

static int whole(const plfx_camera_frame *f, size_t n)
{
    const uint8_t *p = f->raw.bytes;
    size_t k;

    for (k = 0; k + STAMP <= n; k += EVERY) {
        size_t rest = (n - k < EVERY ? n - k : EVERY) - STAMP;
        if (memcmp(p + k, p, STAMP) != 0 ||
            memcmp(p + k + STAMP, served + k + STAMP, rest) != 0) {
            return 0;
        }
    }
    return 1;
}

/* Every format: the bytes that were sent, in the caller's own memory. */
static void formats_arrive_byte_for_byte(void **state)
{
    static const plfx_pfnc list[] = {{0, PLFX_RAW_U8, 8, 0},
                                     {0, PLFX_RAW_U16LE, 16, 0},
                                     {0, PLFX_RAW_MONO10P, 10, 0},
                                     {0, PLFX_RAW_MONO12P, 12, 0},
                                     {0, PLFX_RAW_MONO12PACKED, 12, 0},
                                     {0, PLFX_RAW_MONO12P, 12, PLFX_BAYER_GRBG},
                                     {0, PLFX_RAW_MONO12P, 12, PLFX_BAYER_RGGB}};
    size_t k;

    (void)state;
    for (k = 0; k < sizeof list / sizeof list[0]; k++) {
        plfx_camera_cfg cfg = config(642, 480, list[k].format, list[k].bits);
        size_t n = plfx_raw_bytes(list[k].format, 642, 480);
        plfx_camera_count count;
        plfx_aravis a;
        server s;
        int i;
        serve(&s, 0);
        cfg.bayer = list[k].bayer;
        open_camera(&a, &s, &cfg);
        assert_int_equal(cfg.bayer, list[k].bayer);
        for (i = 0; i < 4; i++) {
            plfx_camera_frame f;
            assert_int_equal(a.camera.acquire(&a, 2000, &f), PLFX_OK);
            assert_ptr_equal(f.raw.bytes,
                             a.pool.bytes + (size_t)f.slot * a.pool.slot_size);
            assert_int_equal(f.raw.format, list[k].format);
            assert_int_equal(f.raw.size, n);
            assert_true(whole(&f, n));
            assert_int_equal(f.sequence, stamp_of(&f));
            assert_int_equal(f.clock, PLFX_CLOCK_CAMERA);
            assert_true(f.time_ns > 0);
            assert_int_equal(a.camera.release(&a, &f), PLFX_OK);
            assert_int_equal(a.camera.release(&a, &f), PLFX_E_ARG);
        }
        a.camera.count(&a, &count);
        assert_int_equal(count.good, 4);
        assert_int_equal(count.incomplete + count.misfit, 0);
        end(&a, &s);
    }
}

/* 1 % of the packets is lost, before and after the frame number's wrap at frame 136:
 * every frame is either whole or counted. */
static void lossy_wire_gives_whole_frames_or_none(void **state)
{
    plfx_camera_cfg cfg = config(320, 200, PLFX_RAW_MONO12P, 12);
    size_t n = plfx_raw_bytes(PLFX_RAW_MONO12P, 320, 200);
    plfx_camera_count count;
    plfx_aravis a;
    plfx_camera_frame f;
    server s;
    uint32_t last = 0;
    uint32_t good = 0;
    uint32_t dropped = 0;

    (void)state;
    serve(&s, 0.01);
    cfg.packet_size = 1400;
    open_camera(&a, &s, &cfg);
    while (last < LOSSY) {
        assert_int_equal(a.camera.acquire(&a, 4000, &f), PLFX_OK);
        assert_true(whole(&f, n));
        assert_int_equal(stamp_of(&f) - last, 1 + f.dropped);
        dropped += f.dropped;
        last = stamp_of(&f);
        good++;
        assert_int_equal(a.camera.release(&a, &f), PLFX_OK);
    }
    a.camera.count(&a, &count);
    print_message("# %u sent, %u good, %u incomplete, %u missed (seed %d)\n",
                  (unsigned)last, (unsigned)count.good, (unsigned)count.incomplete,
                  (unsigned)count.missed, SEED);
    assert_int_equal(count.good, good);
    assert_int_equal(count.incomplete + count.missed, dropped);
    assert_int_equal(f.sequence, last); /* none lost otherwise */
    assert_true(count.incomplete > LOSSY / 4);
    assert_true(a.last_id < 65401u); /* it did come round */
    end(&a, &s);
}

/* Aravis' camera counts from 65401: the wrap lies after 135 frames. */
static void frame_numbers_go_on_after_the_wrap(void **state)
{
    plfx_camera_cfg cfg = config(64, 48, PLFX_RAW_U8, 8);
    plfx_camera_count count;
    plfx_aravis a;
    plfx_camera_frame f;
    server s;
    uint32_t k;

    (void)state;
    serve(&s, 0);
    cfg.rate_mhz = 200000;
    open_camera(&a, &s, &cfg);
    for (k = 1; k < 160; k = f.sequence) {
        assert_int_equal(a.camera.acquire(&a, 2000, &f), PLFX_OK);
        assert_int_equal(f.sequence, stamp_of(&f));
        assert_int_equal(a.camera.release(&a, &f), PLFX_OK);
    }
    assert_true(a.last_id < 65401u); /* it did come round */
    a.camera.count(&a, &count);
    assert_int_equal(count.good + count.missed + count.incomplete, k);
    end(&a, &s);
}

static double seconds(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#define ROUNDS 5    /* of 20 frames; the best counts, for the machine has other work */
static int figures; /* 1: the frame rate is judged, not only printed */

static void twelve_megapixels_pass_without_a_copy(void **state)
{
    plfx_camera_cfg cfg = config(BIG_W, BIG_H, PLFX_RAW_MONO12P, 12);
    plfx_camera_count count;
    plfx_aravis a;
    plfx_camera_frame f;
    server s;
    double begin = 0;
    double rate = 0;
    int k;

    (void)state;
    serve(&s, 0);
    cfg.packet_size = 8000;
    open_camera(&a, &s, &cfg);
    for (k = 0; k <= 20 * (figures ? ROUNDS : 1); k++) {
        assert_int_equal(a.camera.acquire(&a, 5000, &f), PLFX_OK);
        if (k % 20 == 0) {
            double now = seconds();
            rate = k > 0 ? MAX(rate, 20 / (now - begin)) : 0;
            begin = now;
        }
        assert_ptr_equal(f.raw.bytes, a.pool.bytes + (size_t)f.slot * a.pool.slot_size);
        assert_int_equal(f.raw.size, BIG_SIZE);
        assert_true(k % 10 != 0 || whole(&f, BIG_SIZE));
        assert_int_equal(a.camera.release(&a, &f), PLFX_OK);
    }
    a.camera.count(&a, &count);
    print_message("# %dx%d Mono12p: %.1f frames/s, %u incomplete, %u missed\n", BIG_W,
                  BIG_H, rate, (unsigned)count.incomplete, (unsigned)count.missed);
    assert_true(!figures || rate >= 10);
    end(&a, &s);
}

/* Settings arrive in the camera's registers. */
static void settings_are_the_camera_s(void **state)
{
    plfx_camera_cfg cfg = config(320, 240, PLFX_RAW_U8, 8);
    plfx_aravis a;
    server s;
    guint32 v = 0;

    (void)state;
    serve(&s, 0);
    cfg.x0 = 16;
    cfg.y0 = 8;
    cfg.exposure_us = 3000;
    cfg.gain_mdb = 7000;
    cfg.rate_mhz = 40000;
    cfg.packet_size = 1400;
    open_camera(&a, &s, &cfg);
    assert_int_equal(cfg.x0, 16);
    assert_int_equal(cfg.packet_size, 1400);
    arv_fake_camera_read_register(s.camera, ARV_FAKE_CAMERA_REGISTER_Y_OFFSET, &v);
    assert_int_equal(v, 8);
    arv_fake_camera_read_register(s.camera, ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US,
                                  &v);
    assert_int_equal(v, 3000);
    arv_fake_camera_read_register(s.camera, ARV_FAKE_CAMERA_REGISTER_GAIN_RAW, &v);
    assert_int_equal(v, 7);
    arv_fake_camera_read_register(
        s.camera, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, &v);
    assert_int_equal(v, 25000);
    end(&a, &s);
}

static plfx_camera_frame one(plfx_aravis *a)
{
    plfx_camera_frame f;

    assert_int_equal(a->camera.acquire(a, 4000, &f), PLFX_OK);
    assert_int_equal(a->camera.release(a, &f), PLFX_OK);
    return f;
}

/* Frames until one says `clock`: at most 400. */
static int says_in_time(plfx_aravis *a, uint8_t clock)
{
    int k;

    for (k = 0; k < 400; k++) {
        if (one(a).clock == clock) {
            return 1;
        }
    }
    return 0;
}

static void network_time_is_said_while_it_is_kept(void **state)
{
    plfx_camera_cfg cfg = config(64, 48, PLFX_RAW_U8, 8);
    plfx_aravis a;
    server s;
    guint32 v = 0;

    (void)state;
    describe_ptp();
    serve_as(&s, ptp_xml, 0);
    open_camera(&a, &s, &cfg);
    arv_fake_camera_read_register(s.camera, ENABLE, &v);
    assert_int_equal(v, 1); /* asked for */
    assert_int_equal(one(&a).clock, PLFX_CLOCK_CAMERA);
    arv_fake_camera_write_register(s.camera, STATUS, LOCKED);
    assert_true(says_in_time(&a, PLFX_CLOCK_PTP));
    arv_fake_camera_read_register(s.camera, LATCH, &v);
    assert_int_equal(v, 1); /* the status was latched before it was read */
    arv_fake_camera_write_register(s.camera, STATUS, LOCKED - 1);
    assert_true(says_in_time(&a, PLFX_CLOCK_CAMERA));
    end(&a, &s);
    (void)unlink(ptp_xml);
}

static void clock_that_jumps_back_is_counted(void **state)
{
    plfx_camera_cfg cfg = config(64, 48, PLFX_RAW_U8, 8);
    plfx_camera_count count;
    plfx_aravis a;
    plfx_camera_frame f;
    server s;
    uint64_t before;
    int k;

    (void)state;
    serve(&s, 0);
    open_camera(&a, &s, &cfg);
    before = one(&a).time_ns;
    g_atomic_pointer_set(&shift_ns, -3600000000000);
    for (k = 0; k < 100; k++) { /* until the shift arrives */
        f = one(&a);
        if (f.time_ns < before) {
            break;
        }
    }
    assert_true(f.time_ns < before);
    (void)one(&a);
    g_atomic_pointer_set(&shift_ns, 0);
    a.camera.count(&a, &count);
    assert_int_equal(count.back, 1);
    end(&a, &s);
}

static plfx_lut small_table(uint8_t *blob, size_t n)
{
    plfx_lut_desc d;
    plfx_lut t;

    memset(&d, 0, sizeof d);
    d.sensor_w = 642;
    d.sensor_h = 480;
    d.sensor_bits = 12;
    d.lattice.nx = 40;
    d.lattice.ny = 30;
    d.lattice.origin.x_q16 = d.lattice.origin.y_q16 = 9 << 16;
    d.lattice.a.x_q22 = d.lattice.b.y_q22 = 15 * 4194304 + 1234567;
    d.radius_q8 = 6 * 256;
    assert_int_equal(plfx_lut_write(&d, blob, n), PLFX_OK);
    assert_int_equal(plfx_lut_open(&t, blob, n), PLFX_OK);
    return t;
}

/* Raw frame to map, by a sweep over five views in a row. */
static void map_of(const plfx_lut *lut, const plfx_raw *raw, int32_t *slope)
{
    static uint16_t px[5 * 40 * 30];
    static uint8_t ws[1u << 22] __attribute__((aligned(PLFX_ALIGN)));
    plfx_views views = {px, 40, 30, 5};
    plfx_tone tone = plfx_tone_unity(10);
    plfx_map map;
    plfx_plan plan;
    plfx_cfg cfg;
    int k;

    memset(&cfg, 0, sizeof cfg);
    memset(&map, 0, sizeof map);
    cfg.window = 5;
    cfg.bits = 10;
    cfg.n = 5;
    cfg.ref = 2;
    cfg.labels = 16;
    cfg.fit = PLFX_FIT_VEE;
    cfg.slope_min_q16 = -20000;
    cfg.slope_max_q16 = 20000;
    for (k = 0; k < 5; k++) {
        cfg.at[k].u_q8 = (int16_t)((k - 2) * 512);
    }
    map.slope_q16 = slope;
    map.w = map.stride = 40;
    map.h = 30;
    assert_int_equal(plfx_plan_init(&plan, &cfg, lut, 40, 30), PLFX_OK);
    assert_int_equal(plfx_view_all(lut, raw, &tone, cfg.at, 0, &views), PLFX_OK);
    assert_in_range(plfx_sweep_ws(&plan), 1, sizeof ws);
    assert_int_equal(plfx_sweep(&plan, &views, &map, ws, sizeof ws), PLFX_OK);
}

static void served_frame_gives_the_file_s_map(void **state)
{
    static int32_t of_camera[40 * 30];
    static int32_t of_file[40 * 30];
    static uint8_t blob[256];
    plfx_camera_cfg cfg = config(642, 480, PLFX_RAW_MONO12P, 12);
    plfx_lut lut = small_table(blob, sizeof blob);
    plfx_aravis a;
    plfx_camera_frame f;
    plfx_raw file;
    uint32_t stamp;
    server s;

    (void)state;
    serve(&s, 0);
    open_camera(&a, &s, &cfg);
    assert_int_equal(a.camera.acquire(&a, 2000, &f), PLFX_OK);
    stamp = stamp_of(&f);
    file = f.raw;
    stamp_all(served, file.size, stamp);
    file.bytes = served;
    map_of(&lut, &f.raw, of_camera);
    map_of(&lut, &file, of_file);
    assert_memory_equal(of_camera, of_file, sizeof of_file);
    end(&a, &s);
}

static void starving_is_named_and_survived(void **state)
{
    plfx_camera_cfg cfg = config(64, 48, PLFX_RAW_U8, 8);
    plfx_pool pool = pool_of(SLOTS);
    plfx_camera_count count;
    plfx_aravis a;
    plfx_camera_frame f[SLOTS + 1];
    server s;
    int k;

    (void)state;
    serve(&s, 0);
    plfx_aravis_init(&a, s.name);
    assert_int_equal(a.camera.open(&a, &cfg, &pool), PLFX_OK);
    assert_int_equal(a.camera.start(&a), PLFX_OK);
    for (k = 0; k < SLOTS; k++) {
        assert_int_equal(a.camera.acquire(&a, 2000, &f[k]), PLFX_OK);
    }
    assert_int_equal(a.camera.acquire(&a, 10, &f[SLOTS]), PLFX_E_STATE);
    g_usleep(100000);
    assert_int_equal(a.camera.release(&a, &f[0]), PLFX_OK);
    assert_int_equal(a.camera.acquire(&a, 2000, &f[SLOTS]), PLFX_OK);
    assert_true(f[SLOTS].dropped > 0);
    a.camera.count(&a, &count);
    assert_true(count.starved > 0);
    end(&a, &s); /* with frames still in the caller's hands */
}

/* The camera changes its size behind our back. */
static void other_sizes_are_counted_not_shown(void **state)
{
    plfx_camera_cfg cfg = config(64, 48, PLFX_RAW_U8, 8);
    plfx_camera_count count;
    plfx_aravis a;
    plfx_camera_frame f;
    server s;

    (void)state;
    serve(&s, 0);
    open_camera(&a, &s, &cfg);
    assert_int_equal(a.camera.acquire(&a, 2000, &f), PLFX_OK);
    assert_int_equal(a.camera.release(&a, &f), PLFX_OK);
    arv_fake_camera_write_register(s.camera, ARV_FAKE_CAMERA_REGISTER_HEIGHT, 40);
    g_usleep(100000);
    while (a.camera.acquire(&a, 200, &f) == PLFX_OK) { /* at most what was on the way */
        assert_int_equal(f.raw.h, 48);
        assert_int_equal(a.camera.release(&a, &f), PLFX_OK);
    }
    a.camera.count(&a, &count);
    assert_true(count.misfit + count.incomplete > 0);
    end(&a, &s);
}

static void impossible_wishes_are_refused(void **state)
{
    plfx_camera_cfg cfg = config(64, 48, PLFX_RAW_U8, 8);
    plfx_pool pool = pool_of(2);
    plfx_aravis a;
    plfx_camera_frame f;
    server s;

    (void)state;
    serve(&s, 0);
    plfx_aravis_init(&a, "Aravis-Fake-none");
    assert_int_equal(a.camera.open(&a, &cfg, &pool), PLFX_E_DEVICE);
    assert_true(a.message[0] != 0);
    plfx_aravis_init(&a, s.name);
    cfg.format = PLFX_RAW_CSI10; /* no format of the wire */
    cfg.bits = 10;
    assert_int_equal(a.camera.open(&a, &cfg, &pool), PLFX_E_ARG);
    cfg = config(64, 48, PLFX_RAW_U16LE, 14); /* not offered by this camera */
    assert_int_equal(a.camera.open(&a, &cfg, &pool), PLFX_E_ARG);
    cfg = config(64, 48, PLFX_RAW_U8, 8);
    pool.slot_size = 64 * 47;
    assert_int_equal(a.camera.open(&a, &cfg, &pool), PLFX_E_SIZE);
    pool.slot_size = 64 * 48;
    assert_int_equal(a.camera.acquire(&a, 0, &f), PLFX_E_STATE);
    assert_int_equal(a.camera.open(&a, &cfg, &pool), PLFX_OK);
    assert_int_equal(a.camera.open(&a, &cfg, &pool), PLFX_E_ARG);
    assert_int_equal(a.camera.stop(&a), PLFX_E_STATE);
    end(&a, &s);
}

/* The camera is unplugged: acquire says so, and closing works. */
static void unplugged_camera_is_noticed(void **state)
{
    plfx_camera_cfg cfg = config(64, 48, PLFX_RAW_U8, 8);
    plfx_status status = PLFX_OK;
    plfx_aravis a;
    plfx_camera_frame f;
    server s;
    int k;

    (void)state;
    serve(&s, 0);
    open_camera(&a, &s, &cfg);
    assert_int_equal(a.camera.acquire(&a, 2000, &f), PLFX_OK);
    assert_int_equal(a.camera.release(&a, &f), PLFX_OK);
    g_object_unref(s.gv);
    for (k = 0; k < 200 && status != PLFX_E_DEVICE; k++) {
        status = a.camera.acquire(&a, 100, &f);
        if (status == PLFX_OK) {
            assert_int_equal(a.camera.release(&a, &f), PLFX_OK);
        }
    }
    assert_int_equal(status, PLFX_E_DEVICE);
    (void)a.camera.stop(&a);
    a.camera.close(&a);
}

static void formats_and_numbers_belong_together(void **state)
{
    const plfx_pfnc *f = plfx_pfnc_find(0x010c0047u);

    (void)state;
    assert_non_null(f);
    assert_int_equal(f->format, PLFX_RAW_MONO12P);
    assert_int_equal(plfx_pfnc_code(PLFX_RAW_MONO12P, 12, PLFX_BAYER_NONE),
                     0x010c0047u);
    assert_int_equal(plfx_pfnc_code(PLFX_RAW_U8, 8, PLFX_BAYER_RGGB),
                     ARV_PIXEL_FORMAT_BAYER_RG_8);
    assert_int_equal(plfx_pfnc_code(PLFX_RAW_MONO10P, 10, PLFX_BAYER_GBRG),
                     ARV_PIXEL_FORMAT_BAYER_GB_10P);
    assert_int_equal(plfx_pfnc_code(PLFX_RAW_MONO12P, 12, PLFX_BAYER_BGGR),
                     ARV_PIXEL_FORMAT_BAYER_BG_12P);
    assert_int_equal(plfx_pfnc_code(PLFX_RAW_MONO12PACKED, 12, PLFX_BAYER_GRBG),
                     ARV_PIXEL_FORMAT_BAYER_GR_12_PACKED);
    assert_int_equal(plfx_pfnc_code(PLFX_RAW_CSI12, 12, 0), 0);
    assert_null(plfx_pfnc_find(ARV_PIXEL_FORMAT_RGB_8_PACKED));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(formats_and_numbers_belong_together),
    cmocka_unit_test(formats_arrive_byte_for_byte),
    cmocka_unit_test(lossy_wire_gives_whole_frames_or_none),
    cmocka_unit_test(frame_numbers_go_on_after_the_wrap),
    cmocka_unit_test(settings_are_the_camera_s),
    cmocka_unit_test(network_time_is_said_while_it_is_kept),
    cmocka_unit_test(clock_that_jumps_back_is_counted),
    cmocka_unit_test(twelve_megapixels_pass_without_a_copy),
    cmocka_unit_test(served_frame_gives_the_file_s_map),
    cmocka_unit_test(starving_is_named_and_survived),
    cmocka_unit_test(other_sizes_are_counted_not_shown),
    cmocka_unit_test(impossible_wishes_are_refused),
    cmocka_unit_test(unplugged_camera_is_noticed),
};

int main(int argc, char **argv)
{
    if (lo_enter() != 0) {
        printf("1..0 # SKIP no network namespace of our own on this system\n");
        return 0;
    }
    xml = argc > 1 ? argv[1] : "camera.xml";
    figures = argc > 2 && strcmp(argv[2], "figures") == 0;
    cmocka_set_message_output(CM_OUTPUT_TAP);
    if (figures) {
        cmocka_set_test_filter("twelve*");
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
