/* SPDX-License-Identifier: MIT
 * Raw rows: where they lie and how their pixels are packed. */
#include "plenofix/raw.h"
#include "bytes.h"

#define SIDE_LIMIT 32767

int32_t plfx_raw_bpp(int32_t format)
{
    static const uint8_t bpp[PLFX_RAW_FORMATS] = {8, 16, 16, 10, 12, 12, 12, 10, 12};

    return format >= 0 && format < PLFX_RAW_FORMATS ? bpp[format] : 0;
}

/* Pixels and bytes of a group of the format. */
static uint32_t group_pixels(int32_t format)
{
    switch (format) {
    case PLFX_RAW_MONO10P:
    case PLFX_RAW_CSI10:
        return 4;
    case PLFX_RAW_MONO12P:
    case PLFX_RAW_MONO10PACKED:
    case PLFX_RAW_MONO12PACKED:
    case PLFX_RAW_CSI12:
        return 2;
    default:
        return 1;
    }
}

size_t plfx_raw_bytes(int32_t format, int32_t w, int32_t h)
{
    uint64_t pixels;
    uint32_t group;
    uint32_t bits;

    if (plfx_raw_bpp(format) == 0 || w < 1 || w > SIDE_LIMIT || h < 1 ||
        h > SIDE_LIMIT) {
        return 0;
    }
    pixels = (uint64_t)w * (uint64_t)h;
    group = group_pixels(format);
    bits = (uint32_t)plfx_raw_bpp(format);
    if (format == PLFX_RAW_MONO10PACKED || format == PLFX_RAW_MONO12PACKED ||
        format == PLFX_RAW_CSI10 || format == PLFX_RAW_CSI12) {
        pixels = (pixels + group - 1u) / group * group; /* low bits stand last */
    }
    return (size_t)((pixels * bits + 7u) / 8u);
}

static int32_t bits_ok(int32_t format, int32_t bits)
{
    return bits >= 8 && bits <= 16 && bits <= (plfx_raw_bpp(format) + 7) / 8 * 8;
}

plfx_status plfx_raw_row_at(const plfx_raw *raw, int32_t y, plfx_raw_row *row)
{
    uint64_t at;
    size_t need;

    if (!raw || !raw->bytes || !row || y < 0 || y >= raw->h ||
        !bits_ok(raw->format, raw->bits)) {
        return PLFX_E_ARG;
    }
    need = plfx_raw_bytes(raw->format, raw->w, raw->h);
    if (need == 0) {
        return PLFX_E_ARG;
    }
    if (raw->size < need) {
        return PLFX_E_SIZE;
    }
    at = (uint64_t)raw->w * (uint64_t)y * (uint64_t)plfx_raw_bpp(raw->format);
    row->bytes = raw->bytes + (size_t)(at / 8u);
    row->bit = (uint8_t)(at % 8u);
    row->format = raw->format;
    row->bits = raw->bits;
    row->width = raw->w;
    return PLFX_OK;
}

/* Any bit stream, least significant bit first, up to 12 bits from bit `at`. */
static uint32_t stream_lsb(const uint8_t *p, uint32_t at, uint32_t bits)
{
    const uint8_t *q = p + at / 8u;
    uint32_t low = at % 8u;
    uint32_t v = q[0];

    if (low + bits > 8u) {
        v |= (uint32_t)q[1] << 8;
    }
    if (low + bits > 16u) {
        v |= (uint32_t)q[2] << 16;
    }
    return v >> low & ((1u << bits) - 1u);
}

/* Two pixels in three bytes, high bytes outside, low nibbles in the middle. */
static uint32_t packed12(const uint8_t *base, uint32_t q)
{
    const uint8_t *g = base + (size_t)(q / 2u) * 3u;

    return q % 2u ? (uint32_t)g[2] << 4 | (uint32_t)g[1] >> 4
                  : (uint32_t)g[0] << 4 | (g[1] & 15u);
}

static uint32_t packed10(const uint8_t *base, uint32_t q)
{
    const uint8_t *g = base + (size_t)(q / 2u) * 3u;

    return q % 2u ? (uint32_t)g[2] << 2 | (g[1] >> 4 & 3u)
                  : (uint32_t)g[0] << 2 | (g[1] & 3u);
}

static uint32_t csi10(const uint8_t *base, uint32_t q)
{
    const uint8_t *g = base + (size_t)(q / 4u) * 5u;

    return (uint32_t)g[q % 4u] << 2 | ((uint32_t)g[4] >> 2u * (q % 4u) & 3u);
}

static uint32_t csi12(const uint8_t *base, uint32_t q)
{
    const uint8_t *g = base + (size_t)(q / 2u) * 3u;

    return (uint32_t)g[q % 2u] << 4 | ((uint32_t)g[2] >> 4u * (q % 2u) & 15u);
}

/* Pixel x of a row; `phase` pixels of its first group belong to the row before. */
static uint32_t pixel(const plfx_raw_row *row, uint32_t x)
{
    uint32_t half = row->bit / 4u;    /* 12-bit groups: 0, 1 */
    uint32_t quarter = row->bit / 2u; /* 10-bit groups: 0 .. 3 */

    switch (row->format) {
    case PLFX_RAW_U8:
        return row->bytes[x];
    case PLFX_RAW_U16LE:
        return plfx_get_u16(row->bytes + 2u * (size_t)x);
    case PLFX_RAW_U16:
        return ((const uint16_t *)(const void *)row->bytes)[x];
    case PLFX_RAW_MONO10P:
        return stream_lsb(row->bytes, row->bit + 10u * x, 10);
    case PLFX_RAW_MONO12P:
        return stream_lsb(row->bytes, row->bit + 12u * x, 12);
    case PLFX_RAW_MONO10PACKED:
        return packed10(row->bytes - half, x + half);
    case PLFX_RAW_MONO12PACKED:
        return packed12(row->bytes - half, x + half);
    case PLFX_RAW_CSI10:
        return csi10(row->bytes - quarter, x + quarter);
    default:
        return csi12(row->bytes - half, x + half);
    }
}

/* Bits at which a row of the format may begin. */
static int32_t bit_ok(const plfx_raw_row *row)
{
    int32_t bpp = plfx_raw_bpp(row->format);

    return row->bit == 0 || (bpp == 12 && row->bit == 4) ||
           (bpp == 10 && (row->bit == 2 || row->bit == 4 || row->bit == 6));
}

plfx_status plfx_raw_unpack(const plfx_raw_row *row, int32_t x0, int32_t n,
                            uint16_t *out)
{
    uint32_t mask;
    int32_t i;

    if (!row || !row->bytes || !out || plfx_raw_bpp(row->format) == 0 ||
        !bits_ok(row->format, row->bits) || !bit_ok(row) || row->width < 1 ||
        row->width > SIDE_LIMIT || x0 < 0 || n < 0 || x0 > row->width ||
        n > row->width - x0) {
        return PLFX_E_ARG;
    }
    mask = (1u << row->bits) - 1u;
    for (i = 0; i < n; i++) {
        out[i] = (uint16_t)(pixel(row, (uint32_t)(x0 + i)) & mask);
    }
    return PLFX_OK;
}
