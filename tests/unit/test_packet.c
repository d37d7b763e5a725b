/* SPDX-License-Identifier: MIT
 * Packets: golden bytes, round trips, every flipped bit, every cut, rates. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <string.h>

#include "plenofix/plenofix.h"

static uint8_t buf[PLFX_PACKET_MAX];
static plfx_packet_region regions[PLFX_PACKET_REGIONS_MAX];
static plfx_packet_region back[PLFX_PACKET_REGIONS_MAX];
static plfx_packet_mode modes[PLFX_PACKET_MODES_MAX];
static plfx_packet_mode modes_back[PLFX_PACKET_MODES_MAX];

static uint32_t state = 1;

static uint32_t next(void)
{
    state = state * 1664525u + 1013904223u;
    return state >> 8 ^ state << 16;
}

static plfx_packet_head head(void)
{
    plfx_packet_head h = {0x0102030405060708u, 0xa1b2c3d4u, 0x123, 0x2345, 0};

    return h;
}

static size_t one_region(void)
{
    plfx_packet_regions info;
    plfx_packet_region r = {-2, 258, -32768, 77, 0x85};
    size_t len = 0;

    info.head = head();
    info.first = 3;
    info.n = 1;
    info.uv_shift = 14;
    info.w_shift = 20;
    assert_int_equal(plfx_packet_put_regions(&info, &r, buf, sizeof buf, &len),
                     PLFX_OK);
    return len;
}

/* CRC-16 of the 32 bytes by polynomial division, done apart from the library. */
static uint32_t slow_crc(const uint8_t *p, size_t n)
{
    uint32_t crc = 0xffffu;
    size_t i;
    int bit;

    for (i = 0; i < n; i++) {
        for (bit = 7; bit >= 0; bit--) {
            uint32_t in = (uint32_t)(p[i] >> bit & 1) ^ (crc >> 15 & 1u);
            crc = (crc << 1 & 0xffffu) ^ (in ? 0x1021u : 0u);
        }
    }
    return crc;
}

static void bytes_are_golden(void **s)
{
    static const uint8_t want[32] = {0x09, 0x23, 0xe3, 0x45, 0x00, 0x1b, 1,    2,
                                     3,    4,    5,    6,    7,    8,    0xa1, 0xb2,
                                     0xc3, 0xd4, 1,    1,    3,    1,    14,   20,
                                     0xff, 0xfe, 0x01, 0x02, 0x80, 0x00, 77,   0x85};
    size_t len = one_region();
    uint32_t crc;
    (void)s;
    assert_int_equal(len, 34);
    assert_memory_equal(buf, want, 32);
    crc = slow_crc(want, 32);
    assert_int_equal(buf[32], crc >> 8);
    assert_int_equal(buf[33], crc & 255u);
    assert_int_equal(slow_crc((const uint8_t *)"123456789", 9), 0x29b1);
}

static void every_flipped_bit_is_found(void **s)
{
    plfx_packet p;
    size_t len = one_region();
    size_t bit;
    (void)s;
    for (bit = 0; bit < 8u * len; bit++) {
        buf[bit / 8u] = (uint8_t)(buf[bit / 8u] ^ 1u << bit % 8u);
        assert_int_not_equal(plfx_packet_open(buf, len, &p), PLFX_OK);
        buf[bit / 8u] = (uint8_t)(buf[bit / 8u] ^ 1u << bit % 8u);
    }
    assert_int_equal(plfx_packet_open(buf, len, &p), PLFX_OK);
    print_message("# count: single-bit flips, %u tried, 0 missed\n", (unsigned)bit);
}

static void every_cut_is_found(void **s)
{
    plfx_packet p;
    size_t len = one_region();
    size_t n;
    (void)s;
    for (n = 0; n < len; n++) {
        assert_int_equal(plfx_packet_open(buf, n, &p), PLFX_E_SIZE);
    }
}

static void heads_are_equal(const plfx_packet_head *a, const plfx_packet_head *b)
{
    assert_true(a->time_ns == b->time_ns);
    assert_int_equal(a->table, b->table);
    assert_int_equal(a->apid, b->apid);
    assert_int_equal(a->seq, b->seq);
}

static void regions_come_back(void **s)
{
    plfx_packet p;
    plfx_packet_regions info;
    plfx_packet_regions got;
    size_t len = 0;
    int k;
    int n;
    (void)s;
    memset(regions, 0, sizeof regions);
    for (n = 1; n <= PLFX_PACKET_REGIONS_MAX; n += 127) {
        for (k = 0; k < n; k++) {
            regions[k].u = (int16_t)((int32_t)(next() & 0xffffu) - 0x8000);
            regions[k].v = (int16_t)((int32_t)(next() & 0xffffu) - 0x8000);
            regions[k].w = (int16_t)((int32_t)(next() & 0xffffu) - 0x8000);
            regions[k].sigma = (uint8_t)(next() & 255u);
            regions[k].flags = (uint8_t)(next() & 255u);
        }
        info.head = head();
        info.first = 0;
        info.n = (uint8_t)n;
        info.uv_shift = 24;
        info.w_shift = 0;
        assert_int_equal(plfx_packet_put_regions(&info, regions, buf, sizeof buf, &len),
                         PLFX_OK);
        assert_int_equal(plfx_packet_open(buf, sizeof buf, &p), PLFX_OK);
        assert_int_equal(p.whole, len);
        assert_int_equal(plfx_packet_get_regions(&p, &got, back, n - 1), PLFX_E_SIZE);
        assert_int_equal(plfx_packet_get_regions(&p, &got, back, n), PLFX_OK);
        heads_are_equal(&got.head, &info.head);
        assert_int_equal(got.n, n);
        for (k = 0; k < n; k++) {
            assert_int_equal(back[k].u, regions[k].u);
            assert_int_equal(back[k].v, regions[k].v);
            assert_int_equal(back[k].w, regions[k].w);
            assert_int_equal(back[k].sigma, regions[k].sigma);
            assert_int_equal(back[k].flags, regions[k].flags);
        }
    }
}

static void random_mode(plfx_packet_mode *m)
{
    memset(m, 0, sizeof *m);
    m->mode = (uint8_t)(next() & 255u);
    m->channel = (uint8_t)(next() & 255u);
    m->flags = (uint8_t)(next() & 255u);
    m->freq_uhz = next();
    m->freq_sigma_uhz = next();
    m->damp_ppm = -(int32_t)(next() & 0x7fffffffu);
    m->damp_sigma_ppm = next();
    m->amp = next();
    m->amp_sigma = next();
    m->record_ms = next();
}

static void modes_come_back(void **s)
{
    plfx_packet p;
    plfx_packet_head h = head();
    size_t len = 0;
    int32_t n = 0;
    int32_t k;
    (void)s;
    for (k = 0; k < PLFX_PACKET_MODES_MAX; k++) {
        random_mode(&modes[k]);
    }
    modes[0].damp_ppm = INT32_MIN;
    assert_int_equal(
        plfx_packet_put_modes(&h, modes, PLFX_PACKET_MODES_MAX, buf, sizeof buf, &len),
        PLFX_OK);
    assert_int_equal(len, PLFX_PACKET_MAX);
    assert_int_equal(plfx_packet_open(buf, len, &p), PLFX_OK);
    assert_int_equal(plfx_packet_get_modes(&p, modes_back, PLFX_PACKET_MODES_MAX, &n),
                     PLFX_OK);
    assert_int_equal(n, PLFX_PACKET_MODES_MAX);
    for (k = 0; k < n; k++) {
        assert_int_equal(modes_back[k].mode, modes[k].mode);
        assert_int_equal(modes_back[k].channel, modes[k].channel);
        assert_int_equal(modes_back[k].flags, modes[k].flags);
        assert_int_equal(modes_back[k].freq_uhz, modes[k].freq_uhz);
        assert_int_equal(modes_back[k].freq_sigma_uhz, modes[k].freq_sigma_uhz);
        assert_int_equal(modes_back[k].damp_ppm, modes[k].damp_ppm);
        assert_int_equal(modes_back[k].damp_sigma_ppm, modes[k].damp_sigma_ppm);
        assert_int_equal(modes_back[k].amp, modes[k].amp);
        assert_int_equal(modes_back[k].amp_sigma, modes[k].amp_sigma);
        assert_int_equal(modes_back[k].record_ms, modes[k].record_ms);
    }
}

static void health_comes_back(void **s)
{
    plfx_packet_health a = {1u,   2u, 0xffffffffu, 4u, 5u, {-1, INT32_MIN, INT32_MAX},
                            4096, 24, 23,          2};
    plfx_packet_health b;
    plfx_packet p;
    plfx_packet_head h = head();
    size_t len = 0;
    (void)s;
    assert_int_equal(plfx_packet_put_health(&h, &a, buf, 61, &len), PLFX_E_SIZE);
    assert_int_equal(plfx_packet_put_health(&h, &a, buf, 62, &len), PLFX_OK);
    assert_int_equal(plfx_packet_open(buf, len, &p), PLFX_OK);
    memset(&b, 0, sizeof b);
    assert_int_equal(plfx_packet_get_health(&p, &b), PLFX_OK);
    assert_memory_equal(&a, &b, sizeof a);
    assert_int_equal(plfx_packet_get_modes(&p, modes_back, 1, &(int32_t){0}),
                     PLFX_E_ARG);
}

static void sigmas_stay_within_five_percent(void **s)
{
    uint32_t v;
    (void)s;
    assert_int_equal(plfx_packet_sigma(0), 0);
    assert_int_equal(plfx_packet_sigma_q24(0), 0);
    for (v = 64; v < 0x80000000u; v += v / 37u) {
        int64_t d = (int64_t)plfx_packet_sigma_q24(plfx_packet_sigma(v)) - (int64_t)v;
        assert_true((d < 0 ? -d : d) * 1000 <= 62 * (int64_t)v);
    }
    assert_int_equal(plfx_packet_sigma(0xffffffffu), 249);
}

static void a_thin_link_is_filled_and_not_overrun(void **s)
{
    plfx_packet_rate r;
    (void)s;
    assert_int_equal(plfx_packet_fit(57600, 200000, 24, 8, &r), PLFX_OK);
    assert_true(r.bits_s <= 57600u);
    assert_true(r.every <= 4 && r.count >= 4); /* 4 regions at 50 Hz and more */
    assert_int_equal(plfx_packet_fit(1000000, 200000, 24, 8, &r), PLFX_OK);
    assert_int_equal(r.every, 1);
    assert_int_equal(r.count, 24);
    assert_int_equal(plfx_packet_fit(300, 200000, 24, 8, &r), PLFX_E_RANGE);
    assert_int_equal(plfx_packet_fit(300, 0, 24, 8, &r), PLFX_E_ARG);
}

static void bad_arguments_write_nothing(void **s)
{
    plfx_packet_regions info;
    size_t len = 7;
    (void)s;
    info.head = head();
    info.first = 255;
    info.n = 1;
    info.uv_shift = 0;
    info.w_shift = 0;
    memset(buf, 0x5a, sizeof buf);
    assert_int_equal(plfx_packet_put_regions(&info, regions, buf, sizeof buf, &len),
                     PLFX_E_ARG);
    info.first = 0;
    info.head.apid = 2047;
    assert_int_equal(plfx_packet_put_regions(&info, regions, buf, sizeof buf, &len),
                     PLFX_E_ARG);
    info.head.apid = 1;
    assert_int_equal(plfx_packet_put_regions(&info, regions, buf, 33, &len),
                     PLFX_E_SIZE);
    assert_int_equal(len, 7);
    assert_int_equal(buf[0], 0x5a);
    assert_int_equal(plfx_packet_next(16383), 0);
    assert_int_equal(plfx_packet_next(5), 6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_golden),
        cmocka_unit_test(every_flipped_bit_is_found),
        cmocka_unit_test(every_cut_is_found),
        cmocka_unit_test(regions_come_back),
        cmocka_unit_test(modes_come_back),
        cmocka_unit_test(health_comes_back),
        cmocka_unit_test(sigmas_stay_within_five_percent),
        cmocka_unit_test(a_thin_link_is_filled_and_not_overrun),
        cmocka_unit_test(bad_arguments_write_nothing),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
