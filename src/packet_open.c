/* SPDX-License-Identifier: MIT
 * Packets in: every length, field and CRC is checked before anything is believed. */
#include "plenofix/packet.h"
#include "packet_format.h"
#include "bigend.h"

PLFX_STATIC_ASSERT(PLFX_PACKET_OVERHEAD +
                           (PLFX_PACKET_MODES_MAX + 1) * PLFX_PACKET_MODE_BYTES >
                       PLFX_PACKET_MAX,
                   the_longest_packet_bounds_its_modes);

/* The fields of the headers that have one legal value. */
static int32_t head_ok(const uint8_t *p)
{
    return (plfx_be_u16(p) & 0xf800u) == 0x0800u &&
           (plfx_be_u16(p) & 0x07ffu) <= PLFX_PACKET_APID_MAX &&
           (plfx_be_u16(p + 2) & 0xc000u) == 0xc000u && p[19] == PLFX_PACKET_LAYOUT;
}

/* Payload of n bytes against its kind. */
static int32_t payload_ok(uint32_t kind, const uint8_t *p, size_t n)
{
    switch (kind) {
    case PLFX_PACKET_REGIONS:
        return n > PLFX_PACKET_REGION_HEAD && p[1] >= 1u && p[2] <= 24u &&
               p[3] <= 24u && (uint32_t)p[0] + p[1] <= PLFX_PACKET_REGIONS_MAX &&
               n == PLFX_PACKET_REGION_HEAD + PLFX_PACKET_REGION_BYTES * (size_t)p[1];
    case PLFX_PACKET_MODES:
        return n > 0 && n % PLFX_PACKET_MODE_BYTES == 0;
    case PLFX_PACKET_HEALTH:
        return n == PLFX_PACKET_HEALTH_BYTES;
    default:
        return 0;
    }
}

plfx_status plfx_packet_open(const uint8_t *buf, size_t size, plfx_packet *packet)
{
    size_t whole;

    if (!buf || !packet) {
        return PLFX_E_ARG;
    }
    if (size < 6u) {
        return PLFX_E_SIZE;
    }
    whole = plfx_be_u16(buf + 4) + 7u;
    if (whole < PLFX_PACKET_OVERHEAD || whole > PLFX_PACKET_MAX) {
        return PLFX_E_FORMAT;
    }
    if (size < whole) {
        return PLFX_E_SIZE;
    }
    if (plfx_crc16(buf, whole - 2u) != plfx_be_u16(buf + whole - 2u) || !head_ok(buf) ||
        !payload_ok(buf[18], buf + PLFX_PACKET_HEAD, whole - PLFX_PACKET_OVERHEAD)) {
        return PLFX_E_FORMAT;
    }
    packet->head.apid = (uint16_t)(plfx_be_u16(buf) & 0x07ffu);
    packet->head.seq = (uint16_t)(plfx_be_u16(buf + 2) & PLFX_PACKET_SEQ_MASK);
    packet->head.time_ns = (uint64_t)plfx_be_u32(buf + 6) << 32 | plfx_be_u32(buf + 10);
    packet->head.table = plfx_be_u32(buf + 14);
    packet->head.kind = buf[18];
    packet->payload = buf + PLFX_PACKET_HEAD;
    packet->size = whole - PLFX_PACKET_OVERHEAD;
    packet->whole = whole;
    return PLFX_OK;
}

plfx_status plfx_packet_get_regions(const plfx_packet *packet,
                                    plfx_packet_regions *info,
                                    plfx_packet_region *records, int32_t max)
{
    const uint8_t *p;
    int32_t i;

    if (!packet || !packet->payload || !info || !records ||
        packet->head.kind != PLFX_PACKET_REGIONS) {
        return PLFX_E_ARG;
    }
    p = packet->payload;
    if (p[1] > max) {
        return PLFX_E_SIZE;
    }
    info->head = packet->head;
    info->first = p[0];
    info->n = p[1];
    info->uv_shift = p[2];
    info->w_shift = p[3];
    for (i = 0; i < info->n; i++) {
        const uint8_t *r = p + PLFX_PACKET_REGION_HEAD + 8 * i;
        records[i].u = (int16_t)plfx_be_i16(r);
        records[i].v = (int16_t)plfx_be_i16(r + 2);
        records[i].w = (int16_t)plfx_be_i16(r + 4);
        records[i].sigma = r[6];
        records[i].flags = r[7];
    }
    return PLFX_OK;
}

static void get_mode(const uint8_t *p, plfx_packet_mode *m)
{
    m->mode = p[0];
    m->channel = p[1];
    m->flags = p[2];
    m->freq_uhz = plfx_be_u32(p + 4);
    m->freq_sigma_uhz = plfx_be_u32(p + 8);
    m->damp_ppm = plfx_be_i32(p + 12);
    m->damp_sigma_ppm = plfx_be_u32(p + 16);
    m->amp = plfx_be_u32(p + 20);
    m->amp_sigma = plfx_be_u32(p + 24);
    m->record_ms = plfx_be_u32(p + 28);
}

plfx_status plfx_packet_get_modes(const plfx_packet *packet, plfx_packet_mode *modes,
                                  int32_t max, int32_t *n)
{
    int32_t count;
    int32_t i;

    if (!packet || !packet->payload || !modes || !n ||
        packet->head.kind != PLFX_PACKET_MODES) {
        return PLFX_E_ARG;
    }
    count = (int32_t)(packet->size / PLFX_PACKET_MODE_BYTES);
    if (count > max) {
        return PLFX_E_SIZE;
    }
    for (i = 0; i < count; i++) {
        get_mode(packet->payload + PLFX_PACKET_MODE_BYTES * (size_t)i, &modes[i]);
    }
    *n = count;
    return PLFX_OK;
}

plfx_status plfx_packet_get_health(const plfx_packet *packet,
                                   plfx_packet_health *health)
{
    const uint8_t *p;
    int32_t k;

    if (!packet || !packet->payload || !health ||
        packet->head.kind != PLFX_PACKET_HEALTH) {
        return PLFX_E_ARG;
    }
    p = packet->payload;
    health->frames = plfx_be_u32(p);
    health->lost = plfx_be_u32(p + 4);
    health->late = plfx_be_u32(p + 8);
    health->latency_us = plfx_be_u32(p + 12);
    health->rejected = plfx_be_u32(p + 16);
    for (k = 0; k < 3; k++) {
        health->shake_q24[k] = plfx_be_i32(p + 20 + 4 * k);
    }
    health->light_q12 = (uint16_t)plfx_be_u16(p + 32);
    health->regions = (uint16_t)plfx_be_u16(p + 34);
    health->valid = (uint16_t)plfx_be_u16(p + 36);
    health->alarms = (uint16_t)plfx_be_u16(p + 38);
    return PLFX_OK;
}
