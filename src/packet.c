/* SPDX-License-Identifier: MIT
 * Packets out: headers, records, CRC; and what fits a link. */
#include "plenofix/packet.h"
#include "packet_format.h"
#include "bigend.h"
#include "fix.h"

uint16_t plfx_packet_next(uint16_t seq)
{
    return (uint16_t)((seq + 1u) & PLFX_PACKET_SEQ_MASK);
}

uint32_t plfx_crc16(const uint8_t *bytes, size_t n)
{
    static const uint16_t table[16] = {0x0000, 0x1021, 0x2042, 0x3063, 0x4084, 0x50a5,
                                       0x60c6, 0x70e7, 0x8108, 0x9129, 0xa14a, 0xb16b,
                                       0xc18c, 0xd1ad, 0xe1ce, 0xf1ef};
    uint32_t crc = 0xffffu;
    size_t i;

    for (i = 0; i < n; i++) {
        crc = (crc << 4 & 0xffffu) ^ table[crc >> 12 ^ (uint32_t)(bytes[i] >> 4)];
        crc = (crc << 4 & 0xffffu) ^ table[crc >> 12 ^ (bytes[i] & 15u)];
    }
    return crc;
}

/* sigma = 2^((code-1)/8): mantissas of the eight steps, q16. */
static const uint32_t eighth_q16[9] = {65536u,  71468u,  77936u,  84990u, 92682u,
                                       101070u, 110218u, 120194u, 131072u};

uint32_t plfx_packet_sigma_q24(uint8_t code)
{
    uint32_t octave;

    if (code == 0) {
        return 0;
    }
    octave = ((uint32_t)code - 1u) / 8u; /* at most 31 */
    return (uint32_t)((((uint64_t)eighth_q16[(code - 1u) % 8u] << octave) + 32768u) >>
                      16);
}

uint8_t plfx_packet_sigma(uint32_t sigma_q24)
{
    uint32_t octave = 0;
    uint32_t m = sigma_q24;
    uint32_t step = 0;
    uint32_t code;

    if (sigma_q24 == 0) {
        return 0;
    }
    while (m > 1u) { /* at most 31 */
        m >>= 1;
        octave++;
    }
    m = (uint32_t)(((uint64_t)sigma_q24 << 16) >> octave); /* 1 .. 2, q16 */
    /* at most 8 */
    while (step < 8u && m > (eighth_q16[step] + eighth_q16[step + 1u]) / 2u) {
        step++;
    }
    code = 8u * octave + step + 1u;
    return (uint8_t)(code > 249u ? 249u : code); /* 249: 2^31 */
}

static int32_t head_ok(const plfx_packet_head *head)
{
    return head->apid <= PLFX_PACKET_APID_MAX && head->seq <= PLFX_PACKET_SEQ_MASK;
}

/* Headers of a packet of `whole` bytes. */
static void put_head(const plfx_packet_head *head, uint32_t kind, size_t whole,
                     uint8_t *p)
{
    plfx_be_put16(p, 0x0800u | head->apid); /* version 0, telemetry, secondary */
    plfx_be_put16(p + 2, 0xc000u | head->seq);
    plfx_be_put16(p + 4, (uint32_t)(whole - 7u));
    plfx_be_put32(p + 6, (uint32_t)(head->time_ns >> 32));
    plfx_be_put32(p + 10, (uint32_t)(head->time_ns & 0xffffffffu));
    plfx_be_put32(p + 14, head->table);
    p[18] = (uint8_t)kind;
    p[19] = PLFX_PACKET_LAYOUT;
}

static void put_crc(uint8_t *p, size_t whole)
{
    plfx_be_put16(p + whole - 2u, plfx_crc16(p, whole - 2u));
}

plfx_status plfx_packet_put_regions(const plfx_packet_regions *info,
                                    const plfx_packet_region *records, uint8_t *buf,
                                    size_t size, size_t *len)
{
    uint8_t *p;
    size_t whole;
    uint32_t i;

    if (!info || !records || !buf || !len || !head_ok(&info->head) || info->n < 1 ||
        info->first + info->n > PLFX_PACKET_REGIONS_MAX || info->uv_shift > 24 ||
        info->w_shift > 24) {
        return PLFX_E_ARG;
    }
    whole = PLFX_PACKET_OVERHEAD + PLFX_PACKET_REGION_HEAD +
            PLFX_PACKET_REGION_BYTES * (size_t)info->n;
    if (size < whole) {
        return PLFX_E_SIZE;
    }
    put_head(&info->head, PLFX_PACKET_REGIONS, whole, buf);
    p = buf + PLFX_PACKET_HEAD;
    p[0] = info->first;
    p[1] = info->n;
    p[2] = info->uv_shift;
    p[3] = info->w_shift;
    for (i = 0; i < info->n; i++) {
        p = buf + PLFX_PACKET_HEAD + PLFX_PACKET_REGION_HEAD + 8u * (size_t)i;
        plfx_be_put16(p, (uint32_t)records[i].u & 0xffffu);
        plfx_be_put16(p + 2, (uint32_t)records[i].v & 0xffffu);
        plfx_be_put16(p + 4, (uint32_t)records[i].w & 0xffffu);
        p[6] = records[i].sigma;
        p[7] = records[i].flags;
    }
    put_crc(buf, whole);
    *len = whole;
    return PLFX_OK;
}

static void put_mode(const plfx_packet_mode *m, uint8_t *p)
{
    p[0] = m->mode;
    p[1] = m->channel;
    p[2] = m->flags;
    p[3] = 0;
    plfx_be_put32(p + 4, m->freq_uhz);
    plfx_be_put32(p + 8, m->freq_sigma_uhz);
    plfx_be_put32(p + 12, (uint32_t)m->damp_ppm);
    plfx_be_put32(p + 16, m->damp_sigma_ppm);
    plfx_be_put32(p + 20, m->amp);
    plfx_be_put32(p + 24, m->amp_sigma);
    plfx_be_put32(p + 28, m->record_ms);
}

plfx_status plfx_packet_put_modes(const plfx_packet_head *head,
                                  const plfx_packet_mode *modes, int32_t n,
                                  uint8_t *buf, size_t size, size_t *len)
{
    size_t whole;
    int32_t i;

    if (!head || !modes || !buf || !len || !head_ok(head) || n < 1 ||
        n > PLFX_PACKET_MODES_MAX) {
        return PLFX_E_ARG;
    }
    whole = PLFX_PACKET_OVERHEAD + PLFX_PACKET_MODE_BYTES * (size_t)n;
    if (size < whole) {
        return PLFX_E_SIZE;
    }
    put_head(head, PLFX_PACKET_MODES, whole, buf);
    for (i = 0; i < n; i++) {
        put_mode(&modes[i],
                 buf + PLFX_PACKET_HEAD + PLFX_PACKET_MODE_BYTES * (size_t)i);
    }
    put_crc(buf, whole);
    *len = whole;
    return PLFX_OK;
}

plfx_status plfx_packet_put_health(const plfx_packet_head *head,
                                   const plfx_packet_health *health, uint8_t *buf,
                                   size_t size, size_t *len)
{
    const size_t whole = PLFX_PACKET_OVERHEAD + PLFX_PACKET_HEALTH_BYTES;
    uint8_t *p;
    int32_t k;

    if (!head || !health || !buf || !len || !head_ok(head)) {
        return PLFX_E_ARG;
    }
    if (size < whole) {
        return PLFX_E_SIZE;
    }
    put_head(head, PLFX_PACKET_HEALTH, whole, buf);
    p = buf + PLFX_PACKET_HEAD;
    plfx_be_put32(p, health->frames);
    plfx_be_put32(p + 4, health->lost);
    plfx_be_put32(p + 8, health->late);
    plfx_be_put32(p + 12, health->latency_us);
    plfx_be_put32(p + 16, health->rejected);
    for (k = 0; k < 3; k++) {
        plfx_be_put32(p + 20 + 4 * k, (uint32_t)health->shake_q24[k]);
    }
    plfx_be_put16(p + 32, health->light_q12);
    plfx_be_put16(p + 34, health->regions);
    plfx_be_put16(p + 36, health->valid);
    plfx_be_put16(p + 38, health->alarms);
    put_crc(buf, whole);
    *len = whole;
    return PLFX_OK;
}

/* Bits of a packet of n regions. */
static uint64_t region_bits(int32_t n)
{
    return 8u * (uint64_t)(PLFX_PACKET_OVERHEAD + PLFX_PACKET_REGION_HEAD +
                           PLFX_PACKET_REGION_BYTES * (uint32_t)n);
}

plfx_status plfx_packet_fit(uint32_t link_bits_s, uint32_t rate_mhz, int32_t regions,
                            int32_t modes, plfx_packet_rate *rate)
{
    uint64_t slow = 8u * (PLFX_PACKET_OVERHEAD + PLFX_PACKET_HEALTH_BYTES);
    int32_t every;
    int32_t count;

    if (!rate || rate_mhz < 1u || regions < 1 || regions > PLFX_PACKET_REGIONS_MAX ||
        modes < 0 || modes > PLFX_PACKET_MODES_MAX) {
        return PLFX_E_ARG;
    }
    if (modes > 0) {
        slow += 8u * (PLFX_PACKET_OVERHEAD + PLFX_PACKET_MODE_BYTES * (uint32_t)modes);
    }
    /* at most 9 */
    for (every = 1; every <= 256; every *= 2) {
        int32_t least = every < 4 ? regions : 1;
        for (count = regions; count >= least; count--) {
            /* < 2^15 bits * 2^32 */
            uint64_t fast =
                (region_bits(count) * rate_mhz + 1000u * (uint32_t)every - 1u) /
                (1000u * (uint32_t)every);
            if (slow + fast <= link_bits_s) {
                rate->every = every;
                rate->count = count;
                rate->bits_s = (uint32_t)(slow + fast);
                return PLFX_OK;
            }
        }
    }
    return PLFX_E_RANGE;
}
