/* SPDX-License-Identifier: MIT
 * Opening a lens table, centres and flags. */
#include "plenofix/lut.h"
#include "lut_format.h"
#include "lut_rows.h"
#include "bytes.h"
#include "crc32.h"
#include "fix.h"

#include <string.h>

static plfx_vec_q22 vector(const uint8_t *p)
{
    plfx_vec_q22 v;

    v.x_q22 = plfx_get_i32(p);
    v.y_q22 = plfx_get_i32(p + 4);
    return v;
}

static void read_header(plfx_lut *t, const uint8_t *p)
{
    t->blob = p;
    t->size = plfx_get_u32(p + LUT_AT_SIZE);
    t->camera_id = plfx_get_u32(p + LUT_AT_CAMERA);
    t->sensor_w = (int32_t)plfx_get_u16(p + LUT_AT_SENSOR);
    t->sensor_h = (int32_t)plfx_get_u16(p + LUT_AT_SENSOR + 2);
    t->sensor_bits = p[LUT_AT_BITS];
    t->lattice.kind = p[LUT_AT_KIND];
    t->lattice.nx = (int32_t)plfx_get_u16(p + LUT_AT_LENSES);
    t->lattice.ny = (int32_t)plfx_get_u16(p + LUT_AT_LENSES + 2);
    t->lattice.origin.x_q16 = plfx_get_i32(p + LUT_AT_ORIGIN);
    t->lattice.origin.y_q16 = plfx_get_i32(p + LUT_AT_ORIGIN + 4);
    t->lattice.a = vector(p + LUT_AT_STEPS);
    t->lattice.b = vector(p + LUT_AT_STEPS + 8);
    t->lattice.odd = vector(p + LUT_AT_STEPS + 16);
    t->radius_q8 = plfx_get_i32(p + LUT_AT_RADIUS);
    t->crc = plfx_get_u32(p + LUT_AT_CRC);
}

/* CRC of header and directory, the CRC field itself taken as 0. */
static uint32_t header_crc(const uint8_t *p, uint32_t header)
{
    static const uint8_t zero[4] = {0, 0, 0, 0};
    uint32_t crc = plfx_crc32(0, p, LUT_AT_CRC);

    crc = plfx_crc32(crc, zero, sizeof zero);
    return plfx_crc32(crc, p + LUT_HEADER, header - LUT_HEADER);
}

/* Steps cut to q16: at least 1 px long each, not parallel (sine of their angle over
 * 1/4), so that no division by them can fail. */
static int32_t steps_ok(const plfx_lattice *l)
{
    int64_t ax = plfx_asr_i32(l->a.x_q22, 6);
    int64_t ay = plfx_asr_i32(l->a.y_q22, 6);
    int64_t bx = plfx_asr_i32(l->b.x_q22, 6);
    int64_t by = plfx_asr_i32(l->b.y_q22, 6);
    int64_t aa = ax * ax + ay * ay; /* < 2^51 */
    int64_t bb = bx * bx + by * by;
    int64_t cross = plfx_asr_i64(ax * by - ay * bx, 20); /* q12, <= 2^31 */

    return aa >= (int64_t)1 << 32 && bb >= (int64_t)1 << 32 &&
           16 * plfx_asr_i64(cross * cross, 8) >=
               plfx_asr_i64(aa, 24) * plfx_asr_i64(bb, 24);
}

int32_t plfx_lattice_ok(const plfx_lattice *l)
{
    return (l->kind == PLFX_LATTICE_SQUARE || l->kind == PLFX_LATTICE_HEX) &&
           l->nx >= 1 && l->nx <= PLFX_LENSES_MAX && l->ny >= 1 &&
           l->ny <= PLFX_LENSES_MAX && steps_ok(l);
}

static int32_t fields_ok(const plfx_lut *t)
{
    return t->sensor_w >= 1 && t->sensor_w <= 32767 && t->sensor_h >= 1 &&
           t->sensor_h <= 32767 && t->sensor_bits >= 8 && t->sensor_bits <= 16 &&
           plfx_lattice_ok(&t->lattice) && t->radius_q8 >= 0 &&
           t->radius_q8 <= 128 * 256;
}

static int32_t tag_is(const uint8_t *p, const char *tag)
{
    return p[0] == (uint8_t)tag[0] && p[1] == (uint8_t)tag[1] &&
           p[2] == (uint8_t)tag[2] && p[3] == (uint8_t)tag[3];
}

static plfx_section *slot(plfx_lut *t, const uint8_t *tag)
{
    return tag_is(tag, "RESI")   ? &t->resi
           : tag_is(tag, "FLAG") ? &t->flag
           : tag_is(tag, "GAIN") ? &t->gain
           : tag_is(tag, "DARK") ? &t->dark
           : tag_is(tag, "OPTI") ? &t->opti
           : tag_is(tag, "META") ? &t->meta
                                 : NULL;
}

/* One directory entry: its section must begin where the one before ended. */
static int32_t take_section(plfx_lut *t, const uint8_t *entry, uint32_t *end)
{
    uint32_t offset = plfx_get_u32(entry + 4);
    uint32_t length = plfx_get_u32(entry + 8);
    plfx_section *s = slot(t, entry);

    if (offset != *end || length > t->size - offset ||
        plfx_crc32(0, t->blob + offset, length) != plfx_get_u32(entry + 12)) {
        return 0;
    }
    if (s) {
        if (s->length != 0) {
            return 0; /* twice the same tag */
        }
        s->offset = offset;
        s->length = length;
    }
    *end = offset + length;
    return 1;
}

static int32_t take_directory(plfx_lut *t, uint32_t sections, uint32_t header)
{
    uint32_t end = header;
    uint32_t k;

    for (k = 0; k < sections; k++) {
        if (!take_section(t, t->blob + LUT_HEADER + LUT_ENTRY * k, &end)) {
            return 0;
        }
    }
    return end == t->size;
}

static int32_t gain_ok(const plfx_lut *t)
{
    const uint8_t *p = t->blob + t->gain.offset;
    uint32_t zx;
    uint32_t zy;
    uint32_t side;
    uint32_t lenses = (uint32_t)t->lattice.nx * (uint32_t)t->lattice.ny;

    if (t->gain.length == 0) {
        return 1;
    }
    if (t->gain.length < LUT_GAIN_HEAD) {
        return 0;
    }
    zx = plfx_get_u16(p);
    zy = plfx_get_u16(p + 2);
    side = 2 * plfx_get_u16(p + 4) + 1;
    return zx >= 1 && zx <= 16 && zy >= 1 && zy <= 16 && side >= 3 && side <= 255 &&
           plfx_get_u16(p + 6) == 0 &&
           t->gain.length == LUT_GAIN_HEAD + 2 * (zx * zy * side * side + lenses);
}

static int32_t sections_ok(const plfx_lut *t)
{
    uint32_t lenses = (uint32_t)t->lattice.nx * (uint32_t)t->lattice.ny;

    return (t->resi.length == 0 || t->resi.length == 4 * lenses) &&
           (t->flag.length == 0 || t->flag.length == lenses) &&
           (t->dark.length == 0 || t->dark.length == 2) && gain_ok(t);
}

static int32_t near_sensor(plfx_point c, int32_t w, int32_t h, int32_t margin_q16)
{
    int64_t x = c.x_q16;
    int64_t y = c.y_q16;

    return x >= -(int64_t)margin_q16 && y >= -(int64_t)margin_q16 &&
           x <= ((int64_t)(w - 1) << 16) + margin_q16 &&
           y <= ((int64_t)(h - 1) << 16) + margin_q16;
}

/* Every lens in use lies within a pitch of the sensor. */
static int32_t centres_ok(const plfx_lut *t)
{
    int32_t pitch = plfx_lut_pitch_q16(t);
    int32_t i;
    int32_t j;

    for (j = 0; j < t->lattice.ny; j++) {
        for (i = 0; i < t->lattice.nx; i++) {
            if (!(plfx_lut_flags(t, i, j) & PLFX_LENS_MISSING) &&
                !near_sensor(plfx_lut_centre(t, i, j), t->sensor_w, t->sensor_h,
                             pitch)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Magic, version and sizes of the fixed part; n bytes are readable. */
static plfx_status check_frame(const uint8_t *p, size_t n)
{
    uint32_t header;

    if (n < LUT_HEADER) {
        return PLFX_E_SIZE;
    }
    if (!tag_is(p, "PLUT") || plfx_get_u16(p + LUT_AT_VERSION) != LUT_MAJOR) {
        return PLFX_E_FORMAT;
    }
    header = plfx_get_u32(p + LUT_AT_HEADER);
    if (plfx_get_u16(p + LUT_AT_SECTIONS) > LUT_SECTIONS ||
        header != LUT_HEADER + LUT_ENTRY * plfx_get_u16(p + LUT_AT_SECTIONS) ||
        plfx_get_u32(p + LUT_AT_SIZE) < header) {
        return PLFX_E_FORMAT;
    }
    return n < plfx_get_u32(p + LUT_AT_SIZE) ? PLFX_E_SIZE : PLFX_OK;
}

plfx_status plfx_lut_open(plfx_lut *lut, const void *blob, size_t n)
{
    const uint8_t *p = blob;
    uint32_t header;
    plfx_status status;
    plfx_lut t;

    if (!lut || !blob) {
        return PLFX_E_ARG;
    }
    status = check_frame(p, n);
    if (status != PLFX_OK) {
        return status;
    }
    memset(&t, 0, sizeof t);
    read_header(&t, p);
    header = plfx_get_u32(p + LUT_AT_HEADER);
    if (header_crc(p, header) != t.crc || !fields_ok(&t) ||
        !take_directory(&t, plfx_get_u16(p + LUT_AT_SECTIONS), header) ||
        !sections_ok(&t) || !centres_ok(&t)) {
        return PLFX_E_FORMAT;
    }
    *lut = t;
    return PLFX_OK;
}

void plfx_lut_walk_from(const plfx_lut *lut, int32_t i, int32_t j, plfx_lut_walk *w)
{
    const plfx_lattice *l = &lut->lattice;

    /* terms < 2^12 * 2^31 */
    w->x_q22 = (int64_t)i * l->a.x_q22 + (int64_t)j * l->b.x_q22 + 32;
    w->y_q22 = (int64_t)i * l->a.y_q22 + (int64_t)j * l->b.y_q22 + 32;
    if (j & 1) {
        w->x_q22 += l->odd.x_q22;
        w->y_q22 += l->odd.y_q22;
    }
    w->resi = NULL;
    if (lut->resi.length) {
        w->resi = plfx_lut_resi_row(lut, j) + 4 * (size_t)i;
    }
}

plfx_point plfx_lut_walk_on(const plfx_lut *lut, plfx_lut_walk *w)
{
    int64_t x = w->x_q22;
    int64_t y = w->y_q22;
    plfx_point c;

    if (w->resi) {
        x += (int64_t)plfx_get_i16(w->resi) * 1024;
        y += (int64_t)plfx_get_i16(w->resi + 2) * 1024;
        w->resi += 4;
    }
    c.x_q16 = plfx_sat_i32(lut->lattice.origin.x_q16 + plfx_asr_i64(x, 6));
    c.y_q16 = plfx_sat_i32(lut->lattice.origin.y_q16 + plfx_asr_i64(y, 6));
    w->x_q22 += lut->lattice.a.x_q22;
    w->y_q22 += lut->lattice.a.y_q22;
    return c;
}

plfx_point plfx_lut_centre(const plfx_lut *lut, int32_t i, int32_t j)
{
    const plfx_lattice *l = &lut->lattice;
    int64_t odd = j & 1; /* terms: 2^12 * 2^31 + 2^38 < 2^44 */
    int64_t x = (int64_t)l->origin.x_q16 * 64 + (int64_t)i * l->a.x_q22 +
                (int64_t)j * l->b.x_q22 + odd * l->odd.x_q22;
    int64_t y = (int64_t)l->origin.y_q16 * 64 + (int64_t)i * l->a.y_q22 +
                (int64_t)j * l->b.y_q22 + odd * l->odd.y_q22;
    plfx_point c;

    if (lut->resi.length) {
        const uint8_t *r = plfx_lut_resi_row(lut, j) + 4 * (size_t)i;
        x += (int64_t)plfx_get_i16(r) * 1024;
        y += (int64_t)plfx_get_i16(r + 2) * 1024;
    }
    c.x_q16 = plfx_sat_i32(plfx_round_shift_i64(x, 6));
    c.y_q16 = plfx_sat_i32(plfx_round_shift_i64(y, 6));
    return c;
}

uint32_t plfx_lut_flags(const plfx_lut *lut, int32_t i, int32_t j)
{
    if (lut->flag.length == 0) {
        return 0;
    }
    return plfx_lut_flag_row(lut, j)[i];
}

/* |v| in q16; components under 2^31 are cut to q16 first. */
static int32_t length_q16(int64_t x_q22, int64_t y_q22)
{
    int64_t x = plfx_asr_i64(x_q22, 6);
    int64_t y = plfx_asr_i64(y_q22, 6);

    return (int32_t)plfx_isqrt_u64((uint64_t)(x * x + y * y));
}

int32_t plfx_lut_pitch_q16(const plfx_lut *lut)
{
    const plfx_lattice *l = &lut->lattice;
    int64_t x = l->b.x_q22;
    int64_t y = l->b.y_q22;

    if (l->kind == PLFX_LATTICE_HEX) {
        x += l->odd.x_q22;
        y += l->odd.y_q22;
    }
    return plfx_min_i32(length_q16(l->a.x_q22, l->a.y_q22), length_q16(x, y));
}
