/* SPDX-License-Identifier: MIT
 * Argument checks of the packets, one condition at a time: everything else is right, so
 * the status comes from the argument that is wrong. */
#include "suite.h"

#include "plenofix/packet.h"

static plfx_packet_head head = {1, 2, 3, 4, 0};
static plfx_packet_region region[2];
static plfx_packet_mode mode[2];
static plfx_packet_health health;
static uint8_t bytes[256];
static size_t length;

static plfx_packet_regions info_of(uint8_t first, uint8_t n, uint8_t uv, uint8_t w)
{
    plfx_packet_regions info = {head, first, n, uv, w};

    return info;
}

static void put_regions(void **state)
{
    plfx_packet_regions ok = info_of(0, 2, 24, 24);
    plfx_packet_regions bad[] = {info_of(0, 0, 1, 1),  info_of(254, 2, 1, 1),
                                 info_of(0, 2, 25, 1), info_of(0, 2, 1, 25),
                                 info_of(0, 2, 1, 1),  info_of(0, 2, 1, 1)};
    size_t i;

    (void)state;
    bad[4].head.apid = 2047;
    bad[5].head.seq = 16384;
    for (i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(
            plfx_packet_put_regions(&bad[i], region, bytes, sizeof bytes, &length),
            PLFX_E_ARG);
    }
    assert_int_equal(plfx_packet_put_regions(NULL, region, bytes, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_regions(&ok, NULL, bytes, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_regions(&ok, region, NULL, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_regions(&ok, region, bytes, 256, NULL),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_regions(&ok, region, bytes, 41, &length),
                     PLFX_E_SIZE);
    assert_int_equal(plfx_packet_put_regions(&ok, region, bytes, 42, &length), PLFX_OK);
    assert_int_equal(length, 42);
}

static void put_modes(void **state)
{
    (void)state;
    assert_int_equal(plfx_packet_put_modes(NULL, mode, 2, bytes, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_modes(&head, NULL, 2, bytes, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_modes(&head, mode, 2, NULL, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_modes(&head, mode, 2, bytes, 256, NULL),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_modes(&head, mode, 0, bytes, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_modes(&head, mode, 65, bytes, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_modes(&head, mode, 2, bytes, 85, &length),
                     PLFX_E_SIZE);
    assert_int_equal(plfx_packet_put_modes(&head, mode, 2, bytes, 86, &length),
                     PLFX_OK);
}

static void put_health(void **state)
{
    (void)state;
    assert_int_equal(plfx_packet_put_health(NULL, &health, bytes, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_health(&head, NULL, bytes, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_health(&head, &health, NULL, 256, &length),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_health(&head, &health, bytes, 256, NULL),
                     PLFX_E_ARG);
    assert_int_equal(plfx_packet_put_health(&head, &health, bytes, 61, &length),
                     PLFX_E_SIZE);
    assert_int_equal(plfx_packet_put_health(&head, &health, bytes, 62, &length),
                     PLFX_OK);
}

static void open_and_get(void **state)
{
    plfx_packet_regions ok = info_of(0, 2, 24, 24);
    plfx_packet_regions info;
    plfx_packet packet;
    int32_t n;

    (void)state;
    assert_int_equal(plfx_packet_put_regions(&ok, region, bytes, 256, &length),
                     PLFX_OK);
    assert_int_equal(plfx_packet_open(NULL, length, &packet), PLFX_E_ARG);
    assert_int_equal(plfx_packet_open(bytes, length, NULL), PLFX_E_ARG);
    assert_int_equal(plfx_packet_open(bytes, 5, &packet), PLFX_E_SIZE);
    assert_int_equal(plfx_packet_open(bytes, length - 1, &packet), PLFX_E_SIZE);
    assert_int_equal(plfx_packet_open(bytes, length, &packet), PLFX_OK);
    assert_int_equal(plfx_packet_get_regions(NULL, &info, region, 2), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_regions(&packet, NULL, region, 2), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_regions(&packet, &info, NULL, 2), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_regions(&packet, &info, region, 1), PLFX_E_SIZE);
    assert_int_equal(plfx_packet_get_modes(&packet, mode, 2, &n), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_health(&packet, &health), PLFX_E_ARG);
    packet.payload = NULL;
    assert_int_equal(plfx_packet_get_regions(&packet, &info, region, 2), PLFX_E_ARG);
}

static void get_modes_and_health(void **state)
{
    plfx_packet packet;
    int32_t n = 0;

    (void)state;
    assert_int_equal(plfx_packet_put_modes(&head, mode, 2, bytes, 256, &length),
                     PLFX_OK);
    assert_int_equal(plfx_packet_open(bytes, length, &packet), PLFX_OK);
    assert_int_equal(plfx_packet_get_modes(NULL, mode, 2, &n), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_modes(&packet, NULL, 2, &n), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_modes(&packet, mode, 2, NULL), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_modes(&packet, mode, 1, &n), PLFX_E_SIZE);
    assert_int_equal(plfx_packet_get_modes(&packet, mode, 2, &n), PLFX_OK);
    assert_int_equal(n, 2);
    assert_int_equal(plfx_packet_put_health(&head, &health, bytes, 256, &length),
                     PLFX_OK);
    assert_int_equal(plfx_packet_open(bytes, length, &packet), PLFX_OK);
    assert_int_equal(plfx_packet_get_health(NULL, &health), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_health(&packet, NULL), PLFX_E_ARG);
    assert_int_equal(plfx_packet_get_health(&packet, &health), PLFX_OK);
}

static void fit(void **state)
{
    plfx_packet_rate rate;

    (void)state;
    assert_int_equal(plfx_packet_fit(100000, 1000, 4, 2, NULL), PLFX_E_ARG);
    assert_int_equal(plfx_packet_fit(100000, 0, 4, 2, &rate), PLFX_E_ARG);
    assert_int_equal(plfx_packet_fit(100000, 1000, 0, 2, &rate), PLFX_E_ARG);
    assert_int_equal(plfx_packet_fit(100000, 1000, 256, 2, &rate), PLFX_E_ARG);
    assert_int_equal(plfx_packet_fit(100000, 1000, 4, -1, &rate), PLFX_E_ARG);
    assert_int_equal(plfx_packet_fit(100000, 1000, 4, 65, &rate), PLFX_E_ARG);
    assert_int_equal(plfx_packet_fit(100000, 1000, 4, 0, &rate), PLFX_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(put_regions),          cmocka_unit_test(put_modes),
        cmocka_unit_test(put_health),           cmocka_unit_test(open_and_get),
        cmocka_unit_test(get_modes_and_health), cmocka_unit_test(fit),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
