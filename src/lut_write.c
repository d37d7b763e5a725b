/* SPDX-License-Identifier: MIT
 * Writing a lens table. */
#include "lut_format.h"
#include "bytes.h"
#include "crc32.h"

#include <string.h>

#define TEXT_LIMIT (1u << 20) /* bytes of META or OPTI */

typedef struct writer {
    uint8_t *buf;
    uint32_t sections, end; /* entries written, end of the last section */
} writer;

static int32_t gain_wanted(const plfx_lut_desc *d)
{
    return d->profile_u13 && d->lens_gain_u13;
}

static int32_t gain_ok(const plfx_lut_desc *d)
{
    return !gain_wanted(d) ||
           (d->zones_x >= 1 && d->zones_x <= 16 && d->zones_y >= 1 &&
            d->zones_y <= 16 && d->profile_r >= 1 && d->profile_r <= 127);
}

static int32_t desc_ok(const plfx_lut_desc *d)
{
    return d && plfx_lattice_ok(&d->lattice) && d->sensor_w >= 1 &&
           d->sensor_w <= 32767 && d->sensor_h >= 1 && d->sensor_h <= 32767 &&
           d->sensor_bits >= 8 && d->sensor_bits <= 16 && d->radius_q8 >= 0 &&
           d->radius_q8 <= 128 * 256 && gain_ok(d) && d->opti_len <= TEXT_LIMIT &&
           d->meta_len <= TEXT_LIMIT;
}

static uint32_t lenses(const plfx_lut_desc *d)
{
    return (uint32_t)d->lattice.nx * (uint32_t)d->lattice.ny;
}

static uint32_t gain_bytes(const plfx_lut_desc *d)
{
    uint32_t side = 2 * (uint32_t)d->profile_r + 1;

    return LUT_GAIN_HEAD +
           2 * ((uint32_t)d->zones_x * (uint32_t)d->zones_y * side * side + lenses(d));
}

static uint32_t section_count(const plfx_lut_desc *d)
{
    return (d->resid_q12 ? 1u : 0u) + (d->flags ? 1u : 0u) +
           (gain_wanted(d) ? 1u : 0u) + (d->has_dark ? 1u : 0u) + (d->opti ? 1u : 0u) +
           (d->meta ? 1u : 0u);
}

size_t plfx_lut_bytes(const plfx_lut_desc *desc)
{
    size_t n;

    if (!desc_ok(desc)) {
        return 0;
    }
    n = LUT_HEADER + LUT_ENTRY * (size_t)section_count(desc);
    n += desc->resid_q12 ? 4 * (size_t)lenses(desc) : 0;
    n += desc->flags ? lenses(desc) : 0;
    n += gain_wanted(desc) ? gain_bytes(desc) : 0;
    n += desc->has_dark ? 2 : 0;
    n += desc->opti ? desc->opti_len : 0;
    n += desc->meta ? desc->meta_len : 0;
    return n;
}

/* Directory entry of the section whose `length` bytes were put at w->end. */
static void enter(writer *w, const char *tag, uint32_t length)
{
    uint8_t *entry = w->buf + LUT_HEADER + LUT_ENTRY * w->sections;

    memcpy(entry, tag, 4);
    plfx_put_u32(entry + 4, w->end);
    plfx_put_u32(entry + 8, length);
    plfx_put_u32(entry + 12, plfx_crc32(0, w->buf + w->end, length));
    w->sections++;
    w->end += length;
}

static void put_words(uint8_t *to, const uint16_t *from, uint32_t n)
{
    uint32_t i;

    for (i = 0; i < n; i++) {
        plfx_put_u16(to + 2 * (size_t)i, from[i]);
    }
}

static void put_residuals(uint8_t *to, const int16_t *from, uint32_t n)
{
    uint32_t i;

    for (i = 0; i < n; i++) {
        plfx_put_u16(to + 2 * (size_t)i, (uint16_t)from[i]);
    }
}

static void put_gain(writer *w, const plfx_lut_desc *d)
{
    uint8_t *p = w->buf + w->end;
    uint32_t words = (gain_bytes(d) - LUT_GAIN_HEAD) / 2 - lenses(d);

    plfx_put_u16(p, (uint32_t)d->zones_x);
    plfx_put_u16(p + 2, (uint32_t)d->zones_y);
    plfx_put_u16(p + 4, (uint32_t)d->profile_r);
    plfx_put_u16(p + 6, 0);
    put_words(p + LUT_GAIN_HEAD, d->profile_u13, words);
    put_words(p + LUT_GAIN_HEAD + 2 * (size_t)words, d->lens_gain_u13, lenses(d));
    enter(w, "GAIN", gain_bytes(d));
}

static void put_bytes(writer *w, const char *tag, const uint8_t *from, uint32_t n)
{
    memcpy(w->buf + w->end, from, n);
    enter(w, tag, n);
}

static void put_sections(writer *w, const plfx_lut_desc *d)
{
    if (d->resid_q12) {
        put_residuals(w->buf + w->end, d->resid_q12, 2 * lenses(d));
        enter(w, "RESI", 4 * lenses(d));
    }
    if (d->flags) {
        put_bytes(w, "FLAG", d->flags, lenses(d));
    }
    if (gain_wanted(d)) {
        put_gain(w, d);
    }
    if (d->has_dark) {
        plfx_put_u16(w->buf + w->end, d->dark_u16);
        enter(w, "DARK", 2);
    }
    if (d->opti) {
        put_bytes(w, "OPTI", d->opti, d->opti_len);
    }
    if (d->meta) {
        put_bytes(w, "META", d->meta, d->meta_len);
    }
}

static void put_vector(uint8_t *p, plfx_vec_q22 v)
{
    plfx_put_u32(p, (uint32_t)v.x_q22);
    plfx_put_u32(p + 4, (uint32_t)v.y_q22);
}

static void put_header(uint8_t *p, const plfx_lut_desc *d, uint32_t size)
{
    memcpy(p, "PLUT", 4);
    plfx_put_u16(p + LUT_AT_VERSION, LUT_MAJOR);
    plfx_put_u16(p + LUT_AT_VERSION + 2, LUT_MINOR);
    plfx_put_u32(p + LUT_AT_SIZE, size);
    plfx_put_u32(p + LUT_AT_HEADER, LUT_HEADER + LUT_ENTRY * section_count(d));
    plfx_put_u32(p + LUT_AT_CAMERA, d->camera_id);
    plfx_put_u16(p + LUT_AT_SENSOR, (uint32_t)d->sensor_w);
    plfx_put_u16(p + LUT_AT_SENSOR + 2, (uint32_t)d->sensor_h);
    p[LUT_AT_BITS] = (uint8_t)d->sensor_bits;
    p[LUT_AT_KIND] = (uint8_t)d->lattice.kind;
    plfx_put_u16(p + LUT_AT_SECTIONS, section_count(d));
    plfx_put_u16(p + LUT_AT_LENSES, (uint32_t)d->lattice.nx);
    plfx_put_u16(p + LUT_AT_LENSES + 2, (uint32_t)d->lattice.ny);
    plfx_put_u32(p + LUT_AT_ORIGIN, (uint32_t)d->lattice.origin.x_q16);
    plfx_put_u32(p + LUT_AT_ORIGIN + 4, (uint32_t)d->lattice.origin.y_q16);
    put_vector(p + LUT_AT_STEPS, d->lattice.a);
    put_vector(p + LUT_AT_STEPS + 8, d->lattice.b);
    put_vector(p + LUT_AT_STEPS + 16, d->lattice.odd);
    plfx_put_u32(p + LUT_AT_RADIUS, (uint32_t)d->radius_q8);
    plfx_put_u32(p + LUT_AT_CRC, 0);
}

plfx_status plfx_lut_write(const plfx_lut_desc *desc, uint8_t *buf, size_t size)
{
    size_t need = plfx_lut_bytes(desc);
    writer w;

    if (need == 0 || !buf) {
        return PLFX_E_ARG;
    }
    if (size < need) {
        return PLFX_E_SIZE;
    }
    w.buf = buf;
    w.sections = 0;
    w.end = LUT_HEADER + LUT_ENTRY * section_count(desc);
    put_header(buf, desc, (uint32_t)need);
    put_sections(&w, desc);
    plfx_put_u32(buf + LUT_AT_CRC,
                 plfx_crc32(0, buf, LUT_HEADER + LUT_ENTRY * section_count(desc)));
    return PLFX_OK;
}
