/* SPDX-License-Identifier: MIT
 * Limits of the arguments of packets, modes and regions. */
#include "limits.h"
#include "square_table.h"

#include "bigend.h"
#include "packet_format.h"

#include "plenofix/modal.h"
#include "plenofix/packet.h"
#include "plenofix/roi.h"

#define OK  PLFX_OK
#define ARG PLFX_E_ARG

static uint8_t bytes[PLFX_PACKET_MAX];
static size_t length;

/* A byte of the packet set, its CRC made to hold: the status of opening it. */
static plfx_status with(size_t at, uint8_t value)
{
    uint8_t was = bytes[at];
    plfx_packet p;
    plfx_status status;

    mark(&p, sizeof p);
    bytes[at] = value;
    plfx_be_put16(bytes + length - 2, plfx_crc16(bytes, length - 2));
    status = plfx_packet_open(bytes, length, &p);
    assert_true(status == OK || marked(&p, sizeof p));
    bytes[at] = was;
    plfx_be_put16(bytes + length - 2, plfx_crc16(bytes, length - 2));
    return status;
}

static void regions_packet(uint8_t first, uint8_t n)
{
    static plfx_packet_region region[PLFX_PACKET_REGIONS_MAX];
    plfx_packet_regions info = {{1, 2, 3, 4, 0}, first, n, 24, 24};

    assert_int_equal(
        plfx_packet_put_regions(&info, region, bytes, sizeof bytes, &length), OK);
    assert_int_equal(with(0, bytes[0]), OK);
}

static void packet_heads(void **state)
{
    const plfx_status bad = PLFX_E_FORMAT;

    (void)state;
    regions_packet(0, 2);
    assert_int_equal(with(0, bytes[0] & 0xf7u), bad); /* no secondary header */
    assert_int_equal(with(0, bytes[0] | 0x20u), bad); /* version */
    assert_int_equal(with(0, bytes[0] | 0x10u), bad); /* a command */
    bytes[1] = 0xff;
    assert_int_equal(with(0, bytes[0] | 7u), bad); /* the idle packet */
    bytes[1] = 0xfe;
    assert_int_equal(with(0, bytes[0] | 7u), OK);
    assert_int_equal(with(2, bytes[2] & 0x7fu), bad); /* segmented */
    assert_int_equal(with(2, bytes[2] & 0xbfu), bad);
    assert_int_equal(with(19, (uint8_t)(bytes[19] + 1u)), bad); /* layout */
    assert_int_equal(with(18, 0), bad);                         /* kind */
    assert_int_equal(with(18, 4), bad);
}

static void packets_of_regions(void **state)
{
    const plfx_status bad = PLFX_E_FORMAT;

    (void)state;
    regions_packet(0, 2);
    assert_int_equal(with(PLFX_PACKET_HEAD + 1, 0), bad);
    assert_int_equal(with(PLFX_PACKET_HEAD + 1, 1), bad);
    assert_int_equal(with(PLFX_PACKET_HEAD + 1, 3), bad);
    assert_int_equal(with(PLFX_PACKET_HEAD + 2, 25), bad);
    assert_int_equal(with(PLFX_PACKET_HEAD + 3, 25), bad);
    assert_int_equal(with(PLFX_PACKET_HEAD, PLFX_PACKET_REGIONS_MAX - 2), OK);
    assert_int_equal(with(PLFX_PACKET_HEAD, PLFX_PACKET_REGIONS_MAX - 1), bad);
}

/* A packet cut down to n bytes of payload, lengths and CRC in order. */
static plfx_status cut_to(uint8_t kind, size_t n)
{
    plfx_packet p;

    length = PLFX_PACKET_OVERHEAD + n;
    plfx_be_put16(bytes + 4, (uint32_t)length - 7u);
    bytes[18] = kind;
    plfx_be_put16(bytes + length - 2, plfx_crc16(bytes, length - 2));
    return plfx_packet_open(bytes, length, &p);
}

static void payload_lengths(void **state)
{
    const plfx_status bad = PLFX_E_FORMAT;

    (void)state;
    regions_packet(0, 2);
    assert_int_equal(cut_to(PLFX_PACKET_REGIONS, PLFX_PACKET_REGION_HEAD), bad);
    assert_int_equal(cut_to(PLFX_PACKET_REGIONS, 0), bad);
    assert_int_equal(cut_to(PLFX_PACKET_MODES, 0), bad);
    assert_int_equal(cut_to(PLFX_PACKET_MODES, PLFX_PACKET_MODE_BYTES), OK);
    assert_int_equal(cut_to(PLFX_PACKET_MODES, PLFX_PACKET_MODE_BYTES + 1), bad);
    assert_int_equal(cut_to(PLFX_PACKET_HEALTH, PLFX_PACKET_HEALTH_BYTES), OK);
    assert_int_equal(cut_to(PLFX_PACKET_HEALTH, PLFX_PACKET_HEALTH_BYTES + 1), bad);
    length = 6 + 1;
    plfx_be_put16(bytes + 4, PLFX_PACKET_OVERHEAD - 8u); /* one short of the least */
    assert_int_equal(plfx_packet_open(bytes, sizeof bytes, &(plfx_packet){0}), bad);
    plfx_be_put16(bytes + 4, PLFX_PACKET_MAX - 6u); /* one over the longest */
    assert_int_equal(plfx_packet_open(bytes, sizeof bytes, &(plfx_packet){0}), bad);
}

static void longest_packet_of_modes(void **state)
{
    static plfx_packet_mode mode[PLFX_PACKET_MODES_MAX];
    plfx_packet_head head = {1, 2, 3, 4, 0};
    plfx_packet p;

    (void)state;
    assert_int_equal(plfx_packet_put_modes(&head, mode, PLFX_PACKET_MODES_MAX, bytes,
                                           sizeof bytes, &length),
                     OK);
    assert_int_equal(plfx_packet_open(bytes, length, &p), OK);
    assert_int_equal(length, PLFX_PACKET_MAX); /* one more does not fit a packet */
}

static void heads_to_write(void **state)
{
    static plfx_packet_mode mode[1];
    plfx_packet_health health = {0};
    plfx_packet_head bad = {1, 2, 2047, 4, 0};

    (void)state;
    length = 0x5a5a;
    mark(bytes, sizeof bytes);
    assert_int_equal(plfx_packet_put_modes(&bad, mode, 1, bytes, sizeof bytes, &length),
                     ARG);
    assert_int_equal(
        plfx_packet_put_health(&bad, &health, bytes, sizeof bytes, &length), ARG);
    assert_true(marked(bytes, sizeof bytes) && length == 0x5a5a);
}

static void opened_by_hand(void **state)
{
    static plfx_packet_region record[1];
    plfx_packet p = {{1, 2, 3, 4, PLFX_PACKET_MODES}, NULL, 32, 54};
    plfx_packet_mode mode;
    plfx_packet_health health;
    plfx_packet_regions info;
    int32_t n;

    (void)state;
    assert_int_equal(plfx_packet_get_modes(&p, &mode, 1, &n), ARG);
    p.payload = bytes;
    assert_int_equal(plfx_packet_get_regions(&p, &info, record, 1), ARG);
    p.payload = NULL;
    p.head.kind = PLFX_PACKET_REGIONS;
    assert_int_equal(plfx_packet_get_regions(&p, &info, record, 1), ARG);
    p.head.kind = PLFX_PACKET_HEALTH;
    assert_int_equal(plfx_packet_get_health(&p, &health), ARG);
}

/* 200 samples a second at 5 Hz. */
static const plfx_modal_cfg channel = {200000, 5000000, 8, 100, 8};

static int32_t call_modal(void *args)
{
    static plfx_modal m;

    mark(&m, sizeof m);
    return kept(plfx_modal_init(&m, args), &m, sizeof m);
}

static void modal_configuration(void **state)
{
#define M(field, value, status) LIMIT(plfx_modal_cfg, field, value, status)
    static const limit table[] = {
        M(rate_mhz, 999, ARG),
        M(rate_mhz, 8000001, ARG),
        M(rate_mhz, 8000000, OK),
        M(freq_uhz, 0, ARG),
        M(freq_uhz, 1, OK),
        M(freq_uhz, 99999999, OK),
        M(freq_uhz, 100000000, ARG),
        M(every, 0, ARG),
        M(every, 1, OK),
        M(every, 2048, OK),
        M(every, 2049, ARG),
        M(block, 7, ARG),
        M(block, 8, OK),
        M(block, 1 << 17, OK),
        M(block, (1 << 17) + 1, ARG),
        M(mean_log2, 3, ARG),
        M(mean_log2, 4, OK),
        M(mean_log2, 16, OK),
        M(mean_log2, 17, ARG),
    };
#undef M
    plfx_modal_cfg cfg = channel;
    static plfx_modal m;

    (void)state;
    limits(&cfg, sizeof cfg, table, COUNT(table), call_modal);
    assert_int_equal(plfx_modal_init(NULL, &cfg), ARG);
    assert_int_equal(plfx_modal_init(&m, NULL), ARG);
    cfg.rate_mhz = 1000;
    cfg.freq_uhz = 100000;
    assert_int_equal(plfx_modal_init(&m, &cfg), OK);
}

static void modal_watch_arguments(void **state)
{
    static plfx_modal m;
    static plfx_modal_watch w;

    (void)state;
    assert_int_equal(plfx_modal_init(&m, &channel), OK);
    mark(&w, sizeof w);
    assert_int_equal(plfx_modal_watch_init(NULL, &m, 10000, 20000, 2560), ARG);
    assert_int_equal(plfx_modal_watch_init(&w, NULL, 10000, 20000, 2560), ARG);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 0, 20000, 2560), ARG);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 20000, 20000, 2560), ARG);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 1000001, 2560), ARG);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 20000, 255), ARG);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 20000, 131073), ARG);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 1, 2, 2560), PLFX_E_RANGE);
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 1000000, 2560), PLFX_E_RANGE);
    assert_true(marked(&w, sizeof w));
    assert_int_equal(plfx_modal_watch_init(&w, &m, 10000, 20000, 2560), OK);
}

static void modal_read_arguments(void **state)
{
    static plfx_modal m;
    plfx_mode mode;

    (void)state;
    mark(&mode, sizeof mode);
    assert_int_equal(plfx_modal_read(NULL, 1, &mode), ARG);
    assert_int_equal(plfx_modal_read(&m, 1, NULL), ARG);
    assert_int_equal(plfx_modal_read(&m, 0, &mode), ARG);
    assert_int_equal(plfx_modal_read(&m, PLFX_MODAL_BLOCKS + 1, &mode), ARG);
    assert_int_equal(plfx_modal_alarm(NULL, 1000, 256, &mode), ARG);
    assert_int_equal(plfx_modal_alarm(&m, 1000, 256, NULL), ARG);
    assert_int_equal(plfx_modal_alarm(&m, -1, 256, &mode), ARG);
    assert_int_equal(plfx_modal_alarm(&m, 1000001, 256, &mode), ARG);
    assert_int_equal(plfx_modal_alarm(&m, 1000, -1, &mode), ARG);
    assert_int_equal(plfx_modal_alarm(&m, 1000, 65536, &mode), ARG);
    assert_true(marked(&mode, sizeof mode));
}

typedef struct peak_args {
    const uint32_t *power;
    plfx_peak *peaks;
    int32_t *count;
    int32_t n, apart, floor_q4, max;
} peak_args;

static plfx_peak peaks[4];
static int32_t peak_count;

static int32_t call_peaks(void *args)
{
    const peak_args *a = args;
    plfx_status status;

    mark(peaks, sizeof peaks);
    peak_count = 77;
    status = plfx_modal_peaks(a->power, a->n, a->apart, a->floor_q4, a->peaks, a->max,
                              a->count);
    assert_true(status == OK || (marked(peaks, sizeof peaks) && peak_count == 77));
    return status;
}

static void peak_arguments(void **state)
{
#define P(field, value, status) LIMIT(peak_args, field, value, status)
    static const limit table[] = {
        P(power, 0, ARG),     P(peaks, 0, ARG),      P(count, 0, ARG),
        P(n, 2, ARG),         P(n, 3, OK),           P(n, (1 << 20) + 1, ARG),
        P(apart, 0, ARG),     P(apart, 1 << 20, OK), P(apart, (1 << 20) + 1, ARG),
        P(floor_q4, -1, ARG), P(floor_q4, 0, OK),    P(max, 0, ARG),
        P(max, 1, OK),        P(max, 1025, ARG),
    };
#undef P
    static const uint32_t power[9] = {9, 1, 8, 0, 0, 7, 7, 1, 9};
    peak_args a = {power, peaks, &peak_count, 9, 1, 16, 4};

    (void)state;
    limits(&a, sizeof a, table, COUNT(table), call_peaks);
    assert_int_equal(call_peaks(&a), OK); /* ends and the left of a plateau are none */
    assert_int_equal(peak_count, 2);
    assert_int_equal(peaks[0].power, 8);
    assert_int_equal(peaks[1].power, 7);
    a.apart = 5; /* too near the first */
    assert_int_equal(call_peaks(&a), OK);
    assert_int_equal(peak_count, 1);
    a.max = 1;
    a.apart = 1;
    assert_int_equal(call_peaks(&a), OK);
    assert_int_equal(peak_count, 1);
    a.floor_q4 = 16 * 100; /* nothing that high */
    assert_int_equal(call_peaks(&a), OK);
    assert_int_equal(peak_count, 0);
}

/* Neighbours without power count as 1; a plateau has no bend. */
static void peaks_beside_nothing(void **state)
{
    static const uint32_t lone[5] = {0, 0, 1, 0, 0};
    static const uint32_t flat[5] = {0, 1, 1, 0, 0};
    static const uint32_t none[5] = {0, 0, 0, 0, 0};
    peak_args a = {lone, peaks, &peak_count, 5, 1, 0, 4};

    (void)state;
    assert_int_equal(call_peaks(&a), OK);
    assert_int_equal(peak_count, 1);
    assert_int_equal(peaks[0].bin_q8, 512);
    a.power = flat;
    assert_int_equal(call_peaks(&a), OK);
    assert_int_equal(peaks[0].bin_q8, 512);
    a.power = none;
    assert_int_equal(call_peaks(&a), OK);
    assert_int_equal(peak_count, 0);
}

/* Twelve lenses by ten of 9 pixels, with gains, a missing and dim lenses. */
#define NX   24
#define NY   18
#define LENS 9

static uint16_t frame[NX * LENS * NY * LENS];
static uint8_t blob[16384], flags[NX * NY];
static uint16_t profile[9], gain[NX * NY];
static plfx_lut lut;
static plfx_roi_cfg cfg;
static plfx_roi roi;
static uint64_t memory[30000];

static uint8_t *room(void)
{
    return aligned(memory);
}

static void make_cfg(void)
{
    plfx_lut_desc d = square_table(NX, NY, LENS);
    int32_t i;

    for (i = 0; i < NX * NY; i++) {
        gain[i] = 8192;
    }
    for (i = 0; i < 9; i++) {
        profile[i] = 8192;
    }
    d.flags = flags;
    d.zones_x = d.zones_y = 1;
    d.profile_r = 1;
    d.profile_u13 = profile;
    d.lens_gain_u13 = gain;
    assert_int_equal(plfx_lut_write(&d, blob, sizeof blob), OK);
    assert_int_equal(plfx_lut_open(&lut, blob, sizeof blob), OK);
    memset(&cfg, 0, sizeof cfg);
    cfg.lut = &lut;
    cfg.tone = plfx_tone_unity(12);
    cfg.white = 1;
    cfg.views = 3;
    cfg.at[1].u_q8 = 512;
    cfg.at[2].v_q8 = -512;
    cfg.regions = 2;
    for (i = 0; i < 2; i++) {
        cfg.region[i].i = (int16_t)(7 + 9 * i);
        cfg.region[i].j = 8;
        cfg.region[i].hx = 3;
        cfg.region[i].hy = 4;
    }
    cfg.rest = 2;
    cfg.steps = 2;
    cfg.residual_q8 = 640;
}

static int32_t call_ws(void *args)
{
    return plfx_roi_ws(args) ? OK : ARG;
}

static void region_configuration(void **state)
{
#define R(field, value, status) LIMIT(plfx_roi_cfg, field, value, status)
    static const limit table[] = {
        R(region[1].hx, 0, ARG),
        R(region[1].hx, 1, OK),
        R(region[1].hx, PLFX_ROI_HALF_MAX, OK),
        R(region[1].hx, PLFX_ROI_HALF_MAX + 1, ARG),
        R(region[1].hy, 0, ARG),
        R(region[1].hy, PLFX_ROI_HALF_MAX, OK),
        R(region[1].hy, PLFX_ROI_HALF_MAX + 1, ARG),
        R(region[0].i, -PLFX_LENSES_MAX, OK),
        R(region[0].i, -PLFX_LENSES_MAX - 1, ARG),
        R(region[0].i, 2 * PLFX_LENSES_MAX, OK),
        R(region[0].i, 2 * PLFX_LENSES_MAX + 1, ARG),
        R(region[0].j, -PLFX_LENSES_MAX, OK),
        R(region[0].j, -PLFX_LENSES_MAX - 1, ARG),
        R(region[0].j, 2 * PLFX_LENSES_MAX, OK),
        R(region[0].j, 2 * PLFX_LENSES_MAX + 1, ARG),
        R(region[0].reference, 1, OK),
        R(region[0].reference, 2, ARG),
        R(tone.dx_q8, -257, ARG),
        R(tone.dx_q8, -256, OK),
        R(tone.dx_q8, 256, OK),
        R(tone.dx_q8, 257, ARG),
        R(tone.dy_q8, -257, ARG),
        R(tone.dy_q8, -256, OK),
        R(tone.dy_q8, 256, OK),
        R(tone.dy_q8, 257, ARG),
        R(views, 0, ARG),
        R(views, 1, OK),
        R(views, PLFX_VIEWS_MAX, OK),
        R(views, PLFX_VIEWS_MAX + 1, ARG),
        R(regions, 0, ARG),
        R(regions, 1, OK),
        R(regions, PLFX_ROI_MAX + 1, ARG),
        R(rest, 0, ARG),
        R(rest, PLFX_ROI_REST_MAX, OK),
        R(rest, PLFX_ROI_REST_MAX + 1, ARG),
        R(steps, 0, ARG),
        R(steps, PLFX_ROI_STEPS_MAX, OK),
        R(steps, PLFX_ROI_STEPS_MAX + 1, ARG),
        R(seek, -1, ARG),
        R(seek, PLFX_ROI_SEEK_MAX, OK),
        R(seek, PLFX_ROI_SEEK_MAX + 1, ARG),
        R(residual_q8, 255, ARG),
        R(residual_q8, 256, OK),
        R(residual_q8, 65535, OK),
        R(residual_q8, 65536, ARG),
        R(white, 0, OK),
    };
    static const limit images[] = {
        R(views, 2, ARG),  R(nx, 0, ARG),  R(nx, 1, OK),     R(nx, 32767, OK),
        R(nx, 32768, ARG), R(ny, 0, ARG),  R(ny, 32767, OK), R(ny, 32768, ARG),
        R(bits, 7, ARG),   R(bits, 8, OK), R(bits, 16, OK),  R(bits, 17, ARG),
        R(white, 1, OK),
    };
#undef R

    (void)state;
    make_cfg();
    limits(&cfg, sizeof cfg, table, COUNT(table), call_ws);
    cfg.lut = NULL;
    cfg.views = 1;
    cfg.nx = cfg.ny = 60;
    cfg.bits = 12;
    limits(&cfg, sizeof cfg, images, COUNT(images), call_ws);
    assert_int_equal(plfx_roi_init(NULL, &cfg, room(), sizeof memory - 64), ARG);
    assert_int_equal(plfx_roi_init(&roi, NULL, room(), sizeof memory - 64), ARG);
    assert_int_equal(plfx_roi_init(&roi, &cfg, NULL, sizeof memory - 64), ARG);
}

static void draw(int32_t shift)
{
    int32_t x;
    int32_t y;

    for (y = 0; y < NY * LENS; y++) {
        for (x = 0; x < NX * LENS; x++) {
            int32_t i = x / LENS;
            int32_t j = y / LENS;
            int32_t v = (i * 7 + j * 13 + i * j * 5 + shift) % 17;
            frame[y * NX * LENS + x] = (uint16_t)(600 + 150 * v);
        }
    }
}

static plfx_raw raw_frame(void)
{
    plfx_raw r = {
        (const uint8_t *)frame, sizeof frame, PLFX_RAW_U16, 12, NX * LENS, NY * LENS};

    return r;
}

static void frames_and_order(void **state)
{
    static plfx_roi_result out[2];
    plfx_raw r = raw_frame();
    plfx_roi_frame f = {&r, NULL};
    plfx_roi_frame none = {NULL, NULL};
    plfx_roi empty = {0};

    (void)state;
    make_cfg();
    draw(0);
    assert_int_equal(plfx_roi_init(&roi, &cfg, room(), sizeof memory - 64), OK);
    mark(out, sizeof out);
    assert_int_equal(plfx_roi_rest(NULL, &f), ARG);
    assert_int_equal(plfx_roi_rest(&empty, &f), ARG);
    assert_int_equal(plfx_roi_rest(&roi, NULL), ARG);
    assert_int_equal(plfx_roi_rest(&roi, &none), ARG);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_E_STATE);
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
    assert_int_equal(plfx_roi_rest(&roi, &f), PLFX_E_STATE);
    assert_int_equal(plfx_roi_measure(NULL, &f, out), ARG);
    assert_int_equal(plfx_roi_measure(&empty, &f, out), ARG);
    assert_int_equal(plfx_roi_measure(&roi, &f, NULL), ARG);
    assert_int_equal(plfx_roi_measure(&roi, &none, out), ARG);
    r.h--;
    assert_int_equal(plfx_roi_measure(&roi, &f, out), ARG);
    r.h++;
    r.w--;
    assert_int_equal(plfx_roi_measure(&roi, &f, out), ARG);
    r.w++;
    r.size--;
    assert_int_equal(plfx_roi_measure(&roi, &f, out), PLFX_E_SIZE);
    r.size++;
    r.bits = 17;
    assert_int_equal(plfx_roi_measure(&roi, &f, out), ARG);
    assert_true(marked(out, sizeof out));
    r.bits = 12;
    assert_int_equal(plfx_roi_measure(&roi, &f, out), OK);
    assert_int_equal(out[0].u_q24, 0);
}

static void images_of_another_shape(void **state)
{
    static uint16_t px[60 * 60];
    plfx_image m = {px, 60, 60, 60};
    plfx_roi_frame f = {NULL, &m};

    (void)state;
    make_cfg();
    cfg.lut = NULL;
    cfg.views = 1;
    cfg.nx = cfg.ny = 60;
    cfg.bits = 12;
    assert_int_equal(plfx_roi_init(&roi, &cfg, room(), sizeof memory - 64), OK);
    m.px = NULL;
    assert_int_equal(plfx_roi_rest(&roi, &f), ARG);
    m.px = px;
    m.w = 59;
    assert_int_equal(plfx_roi_rest(&roi, &f), ARG);
    m.w = 60;
    m.h = 61;
    assert_int_equal(plfx_roi_rest(&roi, &f), ARG);
    m.h = 60;
    m.stride = 59;
    assert_int_equal(plfx_roi_rest(&roi, &f), ARG);
    m.stride = 60;
    f.image = NULL;
    assert_int_equal(plfx_roi_rest(&roi, &f), ARG);
    f.image = &m;
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
}

static void aims(void **state)
{
    plfx_roi empty = {0};

    (void)state;
    make_cfg();
    assert_int_equal(plfx_roi_init(&roi, &cfg, room(), sizeof memory - 64), OK);
    assert_int_equal(plfx_roi_aim(NULL, 0, 0, 0), ARG);
    assert_int_equal(plfx_roi_aim(&empty, 0, 0, 0), ARG);
    assert_int_equal(plfx_roi_aim(&roi, -1, 0, 0), ARG);
    assert_int_equal(plfx_roi_aim(&roi, 2, 0, 0), ARG);
    assert_int_equal(plfx_roi_aim(&roi, 0, -PLFX_LENSES_MAX - 1, 0), ARG);
    assert_int_equal(plfx_roi_aim(&roi, 0, PLFX_LENSES_MAX + 1, 0), ARG);
    assert_int_equal(plfx_roi_aim(&roi, 0, 0, -PLFX_LENSES_MAX - 1), ARG);
    assert_int_equal(plfx_roi_aim(&roi, 0, 0, PLFX_LENSES_MAX + 1), ARG);
    assert_int_equal(plfx_roi_aim(&roi, 1, -PLFX_LENSES_MAX, PLFX_LENSES_MAX), OK);
}

/* Aimed off the lattice on each side: EDGE, nothing read. */
static void aimed_off_each_side(void **state)
{
    static const int32_t by[4][2] = {{-5, 0}, {0, -5}, {15, 0}, {0, 7}};
    static plfx_roi_result out[2];
    plfx_raw r = raw_frame();
    plfx_roi_frame f = {&r, NULL};
    int32_t k;

    (void)state;
    make_cfg();
    draw(0);
    assert_int_equal(plfx_roi_init(&roi, &cfg, room(), sizeof memory - 64), OK);
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
    for (k = 0; k < 4; k++) {
        assert_int_equal(plfx_roi_aim(&roi, 0, by[k][0], by[k][1]), OK);
        assert_int_equal(plfx_roi_measure(&roi, &f, out), OK);
        assert_int_equal(out[0].flags, PLFX_ROI_EDGE);
        assert_int_equal(out[0].u_q24, PLFX_ROI_NONE);
        assert_int_equal(out[1].flags, 0);
    }
}

/* Regions whose margin leaves the lattice on each side. */
static void regions_off_each_side(void **state)
{
    static const int16_t at[4][2] = {{5, 8}, {7, 6}, {18, 8}, {7, 11}};
    static plfx_roi_result out[2];
    plfx_raw r = raw_frame();
    plfx_roi_frame f = {&r, NULL};
    int32_t k;

    (void)state;
    draw(0);
    for (k = 0; k < 4; k++) {
        make_cfg();
        cfg.region[0].i = at[k][0];
        cfg.region[0].j = at[k][1];
        assert_int_equal(plfx_roi_init(&roi, &cfg, room(), sizeof memory - 64), OK);
        assert_int_equal(plfx_roi_rest(&roi, &f), OK);
        assert_int_equal(plfx_roi_rest(&roi, &f), OK);
        assert_int_equal(plfx_roi_measure(&roi, &f, out), OK);
        assert_int_equal(out[0].flags, PLFX_ROI_EDGE);
        assert_int_equal(out[1].flags, 0);
    }
}

/* A missing lens inside a region is mended; over an eighth of dim ones is LENS. */
static void weak_lenses(void **state)
{
    static plfx_roi_result out[2];
    plfx_raw r = raw_frame();
    plfx_roi_frame f = {&r, NULL};
    int32_t i;

    (void)state;
    flags[8 * NX + 7] = PLFX_LENS_MISSING;
    for (i = 0; i < 9; i++) {
        flags[(4 + i) * NX + 16] = PLFX_LENS_DIM;
    }
    make_cfg();
    memset(flags, 0, sizeof flags);
    draw(0);
    assert_int_equal(plfx_roi_init(&roi, &cfg, room(), sizeof memory - 64), OK);
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), OK);
    assert_int_equal(out[0].flags, 0);
    assert_int_equal(out[1].flags, PLFX_ROI_LENS);
}

/* Clipped at rest: over half of the samples are of no use. */
static void clipped_at_rest(void **state)
{
    static plfx_roi_result out[2];
    plfx_raw r = raw_frame();
    plfx_roi_frame f = {&r, NULL};
    int32_t i;

    (void)state;
    make_cfg();
    draw(0);
    for (i = 0; i < NX * LENS * NY * LENS; i++) {
        frame[i] = i % (NX * LENS) < 12 * LENS ? 4095 : frame[i];
    }
    assert_int_equal(plfx_roi_init(&roi, &cfg, room(), sizeof memory - 64), OK);
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
    assert_int_equal(plfx_roi_rest(&roi, &f), OK);
    assert_int_equal(plfx_roi_measure(&roi, &f, out), OK);
    assert_int_equal(out[0].flags, PLFX_ROI_SATURATED);
}

static void shake_arguments(void **state)
{
    static plfx_roi_result out[3];
    plfx_roi_shake s;
    int32_t k;

    (void)state;
    make_cfg();
    cfg.regions = 3;
    for (k = 0; k < 3; k++) {
        cfg.region[k] = cfg.region[0];
        cfg.region[k].reference = 1;
    }
    assert_int_equal(plfx_roi_init(&roi, &cfg, room(), sizeof memory - 64), OK);
    mark(&s, sizeof s);
    assert_int_equal(plfx_roi_shake_fit(NULL, out, &s), ARG);
    assert_int_equal(plfx_roi_shake_fit(&roi, NULL, &s), ARG);
    assert_int_equal(plfx_roi_shake_fit(&roi, out, NULL), ARG);
    assert_true(marked(&s, sizeof s));
    for (k = 0; k < 3; k++) { /* all in one place: a translation, no turn, no tilt */
        out[k].u_q24 = 1000;
        out[k].v_q24 = -1000;
        out[k].w_q24 = k ? PLFX_ROI_NONE : 300;
    }
    assert_int_equal(plfx_roi_shake_fit(&roi, out, &s), OK);
    assert_int_equal(s.n, 3);
    assert_int_equal(s.u_q24, 1000);
    assert_int_equal(s.w_q24, 100);
    assert_true(s.turn_q24 == 0 && s.zoom_q24 == 0 && s.wi_q24 == 0);
    out[1].flags = PLFX_ROI_EDGE;
    out[1].u_q24 = PLFX_ROI_NONE;
    plfx_roi_steady(&roi, &s, out);
    assert_int_equal(out[0].u_q24, 0);
    assert_int_equal(out[1].u_q24, PLFX_ROI_NONE);
    assert_int_equal(out[2].w_q24, PLFX_ROI_NONE);
    out[0].flags = out[2].flags = PLFX_ROI_LIGHT; /* no reference left */
    assert_int_equal(plfx_roi_shake_fit(&roi, out, &s), OK);
    assert_int_equal(s.n, 0);
    out[0].u_q24 = 5;
    plfx_roi_steady(&roi, &s, out);
    assert_int_equal(out[0].u_q24, 5);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(packet_heads),
    cmocka_unit_test(packets_of_regions),
    cmocka_unit_test(payload_lengths),
    cmocka_unit_test(longest_packet_of_modes),
    cmocka_unit_test(heads_to_write),
    cmocka_unit_test(opened_by_hand),
    cmocka_unit_test(modal_configuration),
    cmocka_unit_test(modal_watch_arguments),
    cmocka_unit_test(modal_read_arguments),
    cmocka_unit_test(peak_arguments),
    cmocka_unit_test(peaks_beside_nothing),
    cmocka_unit_test(region_configuration),
    cmocka_unit_test(frames_and_order),
    cmocka_unit_test(images_of_another_shape),
    cmocka_unit_test(aims),
    cmocka_unit_test(aimed_off_each_side),
    cmocka_unit_test(regions_off_each_side),
    cmocka_unit_test(weak_lenses),
    cmocka_unit_test(clipped_at_rest),
    cmocka_unit_test(shake_arguments),
};

SUITE(tests)
