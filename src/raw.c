/* SPDX-License-Identifier: MIT
 * Raw rows.  A packed row is entered at any pixel: single pixels up to the next group
 * of whole bytes, then whole groups, then single pixels again. */
#include "plenofix/raw.h"

#include <string.h>

#define SIDE_MAX 32767

static const uint8_t bpp_of[PLFX_RAW_FORMATS] = {8, 16, 16, 10, 12, 12, 12, 10, 12};
/* Significant bits that a format can hold. */
static const uint8_t depth_of[PLFX_RAW_FORMATS] = {8, 16, 16, 10, 12, 10, 12, 10, 12};
/* Pixels of a group: the fewest that fill whole bytes. */
static const uint8_t group_of[PLFX_RAW_FORMATS] = {1, 1, 1, 4, 2, 2, 2, 4, 2};

int32_t plfx_raw_bpp(int32_t format)
{
    return format >= 0 && format < (int32_t)PLFX_RAW_FORMATS ? (int32_t)bpp_of[format]
                                                             : 0;
}

static int side_ok(int32_t n)
{
    return n >= 1 && n <= SIDE_MAX;
}

size_t plfx_raw_bytes(int32_t format, int32_t w, int32_t h)
{
    uint64_t px;

    if (plfx_raw_bpp(format) == 0 || !side_ok(w) || !side_ok(h)) {
        return 0;
    }
    px = (uint64_t)w * (uint64_t)h; /* < 2^30 */
    if (format >= (int32_t)PLFX_RAW_MONO10PACKED) {
        px = (px + group_of[format] - 1u) / group_of[format] * group_of[format];
    }
    return (size_t)((px * bpp_of[format] + 7u) / 8u); /* < 2^31 */
}

static int bits_ok(int32_t format, int32_t bits)
{
    return bits >= 8 && bits <= (bpp_of[format] == 8u ? 8 : 16);
}

plfx_status plfx_raw_row_at(const plfx_raw *raw, int32_t y, plfx_raw_row *row)
{
    uint64_t first;

    if (raw == NULL || row == NULL || raw->bytes == NULL) {
        return PLFX_E_ARG;
    }
    if (plfx_raw_bytes(raw->format, raw->w, raw->h) == 0u || y < 0 || y >= raw->h ||
        !bits_ok(raw->format, raw->bits)) {
        return PLFX_E_ARG;
    }
    if (raw->size < plfx_raw_bytes(raw->format, raw->w, raw->h)) {
        return PLFX_E_SIZE;
    }
    first = (uint64_t)y * (uint64_t)raw->w * bpp_of[raw->format]; /* bit, < 2^34 */
    row->bytes = raw->bytes + (size_t)(first / 8u);
    row->bit = (uint8_t)(first % 8u);
    row->format = raw->format;
    row->bits = raw->bits;
    row->width = raw->w;
    return PLFX_OK;
}

/* Place of pixel x in the row's groups.  In every layout a row that begins with pixel
 * `phase` of a group has its first byte `phase` bytes after the start of that group. */
typedef struct place {
    size_t start; /* first byte of the group + phase: >= phase */
    int32_t phase;
    int32_t k; /* pixel of the group */
} place;

static place place_of(const plfx_raw_row *row, int32_t x)
{
    int32_t n = group_of[row->format];
    int32_t bytes = n * bpp_of[row->format] / 8;
    place at;

    at.phase = row->bit / (n == 4 ? 2 : 4);
    at.k = (x + at.phase) % n;
    at.start = (size_t)((x + at.phase) / n) * (size_t)bytes;
    return at;
}

/* 16 bits from bit `pos` on, least significant first; pos % 8 + depth <= 16. */
static uint32_t stream_at(const uint8_t *b, size_t pos)
{
    const uint8_t *p = b + pos / 8u;

    return ((uint32_t)p[0] | (uint32_t)p[1] << 8) >> (pos % 8u);
}

/* Byte m of the group at `at`; m >= phase in the first group. */
static uint32_t byte_of(const plfx_raw_row *row, const place *at, int32_t m)
{
    return row->bytes[at->start + (size_t)m - (size_t)at->phase];
}

/* One pixel of a layout that splits pixels into high bytes and shared low bits. */
static uint32_t split_pixel(const plfx_raw_row *row, int32_t x)
{
    place at = place_of(row, x);
    uint32_t k = (uint32_t)at.k;

    switch (row->format) {
    case PLFX_RAW_MONO10PACKED:
        return byte_of(row, &at, at.k * 2) << 2 | (byte_of(row, &at, 1) >> 4 * k & 3u);
    case PLFX_RAW_MONO12PACKED:
        return byte_of(row, &at, at.k * 2) << 4 | (byte_of(row, &at, 1) >> 4 * k & 15u);
    case PLFX_RAW_CSI10:
        return byte_of(row, &at, at.k) << 2 | (byte_of(row, &at, 4) >> 2 * k & 3u);
    default: /* CSI12 */
        return byte_of(row, &at, at.k) << 4 | (byte_of(row, &at, 2) >> 4 * k & 15u);
    }
}

/* One pixel of any packed layout. */
static uint16_t packed_pixel(const plfx_raw_row *row, int32_t x)
{
    uint32_t v;

    if (row->format == PLFX_RAW_MONO10P) {
        v = stream_at(row->bytes, row->bit + (size_t)x * 10u) & 1023u;
    } else if (row->format == PLFX_RAW_MONO12P) {
        v = stream_at(row->bytes, row->bit + (size_t)x * 12u) & 4095u;
    } else {
        v = split_pixel(row, x);
    }
    return (uint16_t)v;
}

/* n groups of 4 pixels in 5 bytes, one bit stream. */
static void groups_10p(const uint8_t *b, int32_t n, uint16_t *out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        out[0] = (uint16_t)(b[0] | (b[1] & 3u) << 8);
        out[1] = (uint16_t)(b[1] >> 2 | (b[2] & 15u) << 6);
        out[2] = (uint16_t)(b[2] >> 4 | (b[3] & 63u) << 4);
        out[3] = (uint16_t)(b[3] >> 6 | (uint32_t)b[4] << 2);
        b += 5;
        out += 4;
    }
}

/* n groups of 4 high bytes and one of low bits. */
static void groups_csi10(const uint8_t *b, int32_t n, uint16_t *out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        out[0] = (uint16_t)((uint32_t)b[0] << 2 | (b[4] & 3u));
        out[1] = (uint16_t)((uint32_t)b[1] << 2 | (b[4] >> 2 & 3u));
        out[2] = (uint16_t)((uint32_t)b[2] << 2 | (b[4] >> 4 & 3u));
        out[3] = (uint16_t)((uint32_t)b[3] << 2 | b[4] >> 6);
        b += 5;
        out += 4;
    }
}

static void groups_12p(const uint8_t *b, int32_t n, uint16_t *out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        out[0] = (uint16_t)(b[0] | (b[1] & 15u) << 8);
        out[1] = (uint16_t)(b[1] >> 4 | (uint32_t)b[2] << 4);
        b += 3;
        out += 2;
    }
}

static void groups_10packed(const uint8_t *b, int32_t n, uint16_t *out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        out[0] = (uint16_t)((uint32_t)b[0] << 2 | (b[1] & 3u));
        out[1] = (uint16_t)((uint32_t)b[2] << 2 | (b[1] >> 4 & 3u));
        b += 3;
        out += 2;
    }
}

static void groups_12packed(const uint8_t *b, int32_t n, uint16_t *out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        out[0] = (uint16_t)((uint32_t)b[0] << 4 | (b[1] & 15u));
        out[1] = (uint16_t)((uint32_t)b[2] << 4 | b[1] >> 4);
        b += 3;
        out += 2;
    }
}

static void groups_csi12(const uint8_t *b, int32_t n, uint16_t *out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        out[0] = (uint16_t)((uint32_t)b[0] << 4 | (b[2] & 15u));
        out[1] = (uint16_t)((uint32_t)b[1] << 4 | b[2] >> 4);
        b += 3;
        out += 2;
    }
}

static void groups(int32_t format, const uint8_t *b, int32_t n, uint16_t *out)
{
    switch (format) {
    case PLFX_RAW_MONO10P:
        groups_10p(b, n, out);
        break;
    case PLFX_RAW_MONO12P:
        groups_12p(b, n, out);
        break;
    case PLFX_RAW_MONO10PACKED:
        groups_10packed(b, n, out);
        break;
    case PLFX_RAW_MONO12PACKED:
        groups_12packed(b, n, out);
        break;
    case PLFX_RAW_CSI10:
        groups_csi10(b, n, out);
        break;
    default:
        groups_csi12(b, n, out);
        break;
    }
}

static void unpack_packed(const plfx_raw_row *row, int32_t x0, int32_t n, uint16_t *out)
{
    int32_t size = group_of[row->format];
    place at = place_of(row, x0);
    int32_t head = at.k == 0 ? 0 : size - at.k;
    int32_t whole;
    int32_t i;

    head = head < n ? head : n;
    whole = (n - head) / size;
    for (i = 0; i < head; i++) {
        out[i] = packed_pixel(row, x0 + i);
    }
    if (whole > 0) {
        at = place_of(row, x0 + head);
        groups(row->format, row->bytes + (at.start - (size_t)at.phase), whole,
               out + head);
    }
    for (i = head + whole * size; i < n; i++) {
        out[i] = packed_pixel(row, x0 + i);
    }
}

static void unpack_plain(const plfx_raw_row *row, int32_t x0, int32_t n, uint16_t *out)
{
    const uint8_t *b = row->bytes;
    int32_t i;

    if (row->format == PLFX_RAW_U8) {
        for (i = 0; i < n; i++) {
            out[i] = b[x0 + i];
        }
    } else if (row->format == PLFX_RAW_U16LE) {
        b += (size_t)x0 * 2u;
        for (i = 0; i < n; i++) {
            out[i] = (uint16_t)(b[2 * i] | (uint32_t)b[2 * i + 1] << 8);
        }
    } else {
        (void)memcpy(out, b + (size_t)x0 * 2u, (size_t)n * 2u);
    }
}

static int row_ok(const plfx_raw_row *row)
{
    int step; /* legal values of `bit` are its multiples under 8 */

    if (row == NULL || row->bytes == NULL || row->format >= (uint8_t)PLFX_RAW_FORMATS ||
        !bits_ok(row->format, row->bits) || !side_ok(row->width)) {
        return 0;
    }
    step = group_of[row->format] == 4u ? 2 : group_of[row->format] == 2u ? 4 : 8;
    return row->bit < 8u && row->bit % step == 0;
}

plfx_status plfx_raw_unpack(const plfx_raw_row *row, int32_t x0, int32_t n,
                            uint16_t *out)
{
    uint32_t mask;
    int32_t i;

    if (!row_ok(row) || out == NULL || x0 < 0 || n < 0 || x0 > row->width ||
        n > row->width - x0) {
        return PLFX_E_ARG;
    }
    if (group_of[row->format] == 1u) {
        unpack_plain(row, x0, n, out);
    } else {
        unpack_packed(row, x0, n, out);
    }
    if (row->bits < depth_of[row->format]) {
        mask = (1u << row->bits) - 1u;
        for (i = 0; i < n; i++) {
            out[i] = (uint16_t)(out[i] & mask);
        }
    }
    return PLFX_OK;
}
