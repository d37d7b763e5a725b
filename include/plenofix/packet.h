/* SPDX-License-Identifier: MIT
 * Telemetry: CCSDS space packets (133.0-B) that carry displacements of regions, modes
 * and health over a thin link.  All fields big-endian, decoded byte by byte.
 *
 *   0   6  primary header: version 0, telemetry, secondary header present, APID,
 *          unsegmented, sequence count, length of the data field - 1
 *   6  14  secondary header: time u64 ns, table u32 (plfx_lut.crc), kind u8, layout u8
 *  20   .  payload of the kind
 *   .   2  CRC-16 (polynomial 0x1021, start 0xffff) of everything before it
 *
 * The CRC finds every burst of up to 16 bits and any 1, 2 or 3 flipped bits. */
#ifndef PLENOFIX_PACKET_H
#define PLENOFIX_PACKET_H

#include "plenofix/base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_PACKET_HEAD     20u /* bytes before the payload */
#define PLFX_PACKET_OVERHEAD 22u /* with the CRC */
#define PLFX_PACKET_APID_MAX 2046u
#define PLFX_PACKET_SEQ_MASK 0x3fffu
#define PLFX_PACKET_LAYOUT   1u

#define PLFX_PACKET_REGION_BYTES 8u
#define PLFX_PACKET_REGION_HEAD  4u
#define PLFX_PACKET_REGIONS_MAX  255
#define PLFX_PACKET_MODE_BYTES   32u
#define PLFX_PACKET_MODES_MAX    64
#define PLFX_PACKET_HEALTH_BYTES 40u
/* Bytes of the longest packet. */
#define PLFX_PACKET_MAX (PLFX_PACKET_OVERHEAD + PLFX_PACKET_MODES_MAX * 32u)

typedef enum plfx_packet_kind {
    PLFX_PACKET_REGIONS = 1,
    PLFX_PACKET_MODES = 2,
    PLFX_PACKET_HEALTH = 3
} plfx_packet_kind;

typedef struct plfx_packet_head {
    uint64_t time_ns; /* middle of the exposure */
    uint32_t table;   /* plfx_lut.crc of the lens table */
    uint16_t apid;    /* 0 .. PLFX_PACKET_APID_MAX; 2047 is CCSDS's idle packet */
    uint16_t seq;     /* 0 .. 16383, of this APID */
    uint8_t kind;     /* plfx_packet_kind */
} plfx_packet_head;

/* An opened packet: payload inside the caller's bytes. */
typedef struct plfx_packet {
    plfx_packet_head head;
    const uint8_t *payload;
    size_t size;  /* of the payload */
    size_t whole; /* of the packet: the next one starts after it */
} plfx_packet;

/* Displacement of a region, 8 bytes.  Shifts say what an int16 step is:
 * 2^-uv_shift lens pitches, 2^-w_shift of slope.  -32768 in w: not measured. */
typedef struct plfx_packet_region {
    int16_t u, v, w;
    uint8_t sigma; /* plfx_packet_sigma() of w's standard error, or of u's without w */
    uint8_t flags; /* PLFX_ROI_* */
} plfx_packet_region;

typedef struct plfx_packet_regions {
    plfx_packet_head head;
    uint8_t first, n;          /* regions first .. first+n-1 */
    uint8_t uv_shift, w_shift; /* 0 .. 24 */
} plfx_packet_regions;

/* A mode, 32 bytes. */
typedef struct plfx_packet_mode {
    uint8_t mode, channel;
    uint8_t flags; /* PLFX_MODE_* */
    uint32_t freq_uhz, freq_sigma_uhz;
    int32_t damp_ppm; /* millionths of critical damping */
    uint32_t damp_sigma_ppm;
    uint32_t amp, amp_sigma; /* rms, in steps of the channel's samples, q8 */
    uint32_t record_ms;      /* length of record behind the values */
} plfx_packet_mode;

typedef struct plfx_packet_health {
    uint32_t frames, lost, late; /* frames seen, missing, with time going backwards */
    uint32_t latency_us;         /* worst since the last packet */
    uint32_t rejected;           /* region measurements flagged since the start */
    int32_t shake_q24[3];        /* camera motion: u, v lens pitches, w slope */
    uint16_t light_q12;          /* brightness against the rest state */
    uint16_t regions, valid;     /* configured, valid in the last frame */
    uint16_t alarms;             /* modes in alarm */
} plfx_packet_health;

/* Sequence count after `seq`. */
uint16_t plfx_packet_next(uint16_t seq);

/* Standard error in a byte: round(8*log2(sigma_q24)) + 1 for sigma_q24 = 1 .. 2^31, 0
 * for "none" (sigma_q24 = 0).  Steps of 9 %, so at most 4.6 % off. */
uint8_t plfx_packet_sigma(uint32_t sigma_q24);

/* Its value back, q24; 0 for code 0. */
uint32_t plfx_packet_sigma_q24(uint8_t code);

/* Write a packet of n regions; n = info->n, 1 .. 255.  *len is its length.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE. */
plfx_status plfx_packet_put_regions(const plfx_packet_regions *info,
                                    const plfx_packet_region *records, uint8_t *buf,
                                    size_t size, size_t *len) PLFX_MUST_USE;

/* Write n modes, 1 .. PLFX_PACKET_MODES_MAX.  head->kind is ignored. */
plfx_status plfx_packet_put_modes(const plfx_packet_head *head,
                                  const plfx_packet_mode *modes, int32_t n,
                                  uint8_t *buf, size_t size, size_t *len) PLFX_MUST_USE;

plfx_status plfx_packet_put_health(const plfx_packet_head *head,
                                   const plfx_packet_health *health, uint8_t *buf,
                                   size_t size, size_t *len) PLFX_MUST_USE;

/* Open the packet at the start of buf: lengths, CRC, header, payload length against
 * kind.  PLFX_OK; PLFX_E_SIZE when size ends inside it; PLFX_E_FORMAT. */
plfx_status plfx_packet_open(const uint8_t *buf, size_t size,
                             plfx_packet *packet) PLFX_MUST_USE;

/* Read an opened packet.  `max` is the room at records.
 * PLFX_OK, PLFX_E_ARG (another kind), PLFX_E_SIZE (more records than max). */
plfx_status plfx_packet_get_regions(const plfx_packet *packet,
                                    plfx_packet_regions *info,
                                    plfx_packet_region *records,
                                    int32_t max) PLFX_MUST_USE;
plfx_status plfx_packet_get_modes(const plfx_packet *packet, plfx_packet_mode *modes,
                                  int32_t max, int32_t *n) PLFX_MUST_USE;
plfx_status plfx_packet_get_health(const plfx_packet *packet,
                                   plfx_packet_health *health) PLFX_MUST_USE;

/* What fits a link: of `regions` regions and `modes` modes at rate_mhz frames a 1000 s,
 * `count` regions every `every` frames, one packet of modes and one of health a second.
 * All regions are kept as long as every 4th frame can be sent at least; then fewer
 * regions, never under 1.  bits_s: what is sent, bit/s.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_RANGE (not even 1 region every 256th frame fits). */
typedef struct plfx_packet_rate {
    int32_t every, count;
    uint32_t bits_s;
} plfx_packet_rate;

plfx_status plfx_packet_fit(uint32_t link_bits_s, uint32_t rate_mhz, int32_t regions,
                            int32_t modes, plfx_packet_rate *rate) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
