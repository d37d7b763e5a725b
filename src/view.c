/* SPDX-License-Identifier: MIT */
#include "plenofix/view.h"
#include "fix.h"
#include "mend.h"
#include "sure.h"

typedef struct sampler { /* what is the same for every lens of a call */
    const plfx_lut *lut;
    const plfx_raw *raw;
    const plfx_tone *tone;
    plfx_point shift; /* offset and tone displacement, q16 px */
    int32_t up;       /* 16 - raw bits: left-justifies a pixel */
    uint32_t clipped; /* a 16-bit sample from here on is clipped */
} sampler;

plfx_tone plfx_tone_unity(int32_t bits)
{
    plfx_tone t = {0, 65535u, 4096u, 0, 0, 0, 0};

    t.bits = (uint8_t)bits;
    return t;
}

plfx_point plfx_view_offset(const plfx_lut *lut, plfx_offset at)
{
    /* steps in q12 (< 2^21), offsets q8 (< 2^15): products under 2^37, << 8 under
     * 2^45 */
    int64_t ax = plfx_asr_i32(lut->lattice.a.x_q22, 10);
    int64_t ay = plfx_asr_i32(lut->lattice.a.y_q22, 10);
    int64_t len = (int64_t)plfx_isqrt_u64((uint64_t)(ax * ax + ay * ay));
    plfx_point p;

    p.x_q16 = (int32_t)plfx_div_round_i64((at.u_q8 * ax - at.v_q8 * ay) * 256, len);
    p.y_q16 = (int32_t)plfx_div_round_i64((at.u_q8 * ay + at.v_q8 * ax) * 256, len);
    return p;
}

/* Pixels x0 and x1 of row y, right-justified. */
static void two_pixels(const plfx_raw *raw, int32_t x0, int32_t x1, int32_t y,
                       uint32_t p[2])
{
    plfx_raw_row row;
    uint16_t v[2] = {0, 0};

    if (raw->format == PLFX_RAW_U16) {
        const uint16_t *px =
            (const uint16_t *)(const void *)raw->bytes + (size_t)y * (size_t)raw->w;
        p[0] = px[x0];
        p[1] = px[x1];
    } else {
        plfx_sure(plfx_raw_row_at(raw, y, &row));
        plfx_sure(plfx_raw_unpack(&row, x0, x1 - x0 + 1, v));
        p[0] = v[0];
        p[1] = v[x1 - x0];
    }
}

static uint32_t along_row(const sampler *s, int32_t x_q8, int32_t y)
{
    int32_t x = plfx_asr_i32(x_q8, 8);
    uint32_t f = (uint32_t)(x_q8 - 256 * x);
    int32_t x0 = plfx_clamp_i32(x, 0, s->raw->w - 1);
    int32_t x1 = plfx_clamp_i32(x + 1, 0, s->raw->w - 1);
    int32_t k = s->raw->bits - 8;
    uint32_t p[2] = {0, 0};

    two_pixels(s->raw, x0, x1, y, p);
    return (p[0] * (256u - f) + p[1] * f + ((1u << k) >> 1)) >> k;
}

/* Sample beside the centre c, 16 bits. */
static uint32_t sample_u16(const sampler *s, plfx_point c)
{
    int32_t x_q8 = plfx_asr_i32(c.x_q16 + s->shift.x_q16 + 128, 8);
    int32_t y_q8 = plfx_asr_i32(c.y_q16 + s->shift.y_q16 + 128, 8);
    int32_t y = plfx_asr_i32(y_q8, 8);
    uint32_t f = (uint32_t)(y_q8 - 256 * y);
    uint32_t h0 = along_row(s, x_q8, plfx_clamp_i32(y, 0, s->raw->h - 1));
    uint32_t h1 = along_row(s, x_q8, plfx_clamp_i32(y + 1, 0, s->raw->h - 1));

    return (h0 * (256u - f) + h1 * f + 128u) >> 8;
}

/* Black level, white gain, tone: the view sample of a 16-bit sample. */
static uint16_t toned(const sampler *s, uint32_t v, uint32_t gain_u13)
{
    const plfx_tone *t = s->tone;
    uint32_t top = (1u << t->bits) - 1u;
    int32_t down = 28 - t->bits - t->shift; /* 8 .. 28 */
    uint32_t lit = v > t->black_u16 ? v - t->black_u16 : 0u;
    uint32_t even = (lit * gain_u13 + 4096u) >> 13; /* 19 bits */
    uint64_t out = ((uint64_t)even * t->gain_q12 + ((uint64_t)1 << (down - 1))) >> down;

    if (v >= s->clipped || out > top) {
        return (uint16_t)top;
    }
    return (uint16_t)out;
}

static int32_t tone_ok(const plfx_tone *t)
{
    return t && t->bits >= PLFX_BITS_MIN && t->bits <= PLFX_BITS_MAX &&
           t->gain_q12 >= 4096u && t->gain_q12 <= 8191u && t->shift >= -8 &&
           t->shift <= 8 && t->dx_q8 >= -256 && t->dx_q8 <= 256 && t->dy_q8 >= -256 &&
           t->dy_q8 <= 256;
}

static int32_t raw_ok(const plfx_lut *lut, const plfx_raw *raw)
{
    return raw && raw->w == lut->sensor_w && raw->h == lut->sensor_h;
}

static int32_t views_ok(const plfx_lut *lut, const plfx_views *v)
{
    return v && v->px && v->n >= 1 && v->n <= PLFX_VIEWS_MAX &&
           v->nx == lut->lattice.nx && v->ny == lut->lattice.ny;
}

static void fill_row(const sampler *s, int32_t j, int32_t nx, uint16_t *row)
{
    int32_t i;

    for (i = 0; i < nx; i++) { /* row[i] holds the gain until it is replaced */
        if (plfx_lut_flags(s->lut, i, j) & PLFX_LENS_MISSING) {
            row[i] = 0; /* mended below */
        } else {
            row[i] = toned(s, sample_u16(s, plfx_lut_centre(s->lut, i, j)), row[i]);
        }
    }
    plfx_mend_row(s->lut, j, row);
}

static void gains(const plfx_lut *lut, plfx_offset at, int32_t white, int32_t j,
                  uint16_t *row)
{
    int32_t i;

    for (i = 0; i < lut->lattice.nx; i++) {
        row[i] = 8192u;
    }
    if (white) {
        plfx_sure(plfx_lut_gain_row(lut, j, at.u_q8, at.v_q8, row));
    }
}

static sampler start(const plfx_lut *lut, const plfx_raw *raw, const plfx_tone *tone,
                     plfx_offset at)
{
    sampler s;
    uint32_t full;

    s.lut = lut;
    s.raw = raw;
    s.tone = tone;
    s.shift = plfx_view_offset(lut, at);
    s.shift.x_q16 += 256 * tone->dx_q8;
    s.shift.y_q16 += 256 * tone->dy_q8;
    s.up = 16 - raw->bits;
    full = ((1u << raw->bits) - 1u) << s.up;
    s.clipped = full < tone->sat_u16 ? full : tone->sat_u16;
    return s;
}

plfx_status plfx_view_rows(const plfx_lut *lut, const plfx_raw *raw,
                           const plfx_tone *tone, plfx_offset at, int32_t white,
                           int32_t j0, int32_t j1, const plfx_views *out, int32_t k)
{
    plfx_raw_row first;
    plfx_status status;
    sampler s;
    int32_t j;

    if (!lut || !raw_ok(lut, raw) || !tone_ok(tone) || !views_ok(lut, out) || k < 0 ||
        k >= out->n || j0 < 0 || j1 > out->ny || j0 > j1) {
        return PLFX_E_ARG;
    }
    status = plfx_raw_row_at(raw, 0, &first); /* format, bits, size */
    if (status != PLFX_OK) {
        return status;
    }
    s = start(lut, raw, tone, at);
    for (j = j0; j < j1; j++) {
        uint16_t *row =
            out->px + ((size_t)j * (size_t)out->n + (size_t)k) * (size_t)out->nx;
        gains(lut, at, white, j, row);
        fill_row(&s, j, out->nx, row);
    }
    return PLFX_OK;
}

plfx_status plfx_view_all(const plfx_lut *lut, const plfx_raw *raw,
                          const plfx_tone *tone, const plfx_offset *at, int32_t white,
                          const plfx_views *out)
{
    plfx_status status = PLFX_OK;
    int32_t k;

    if (!lut || !at || !views_ok(lut, out)) {
        return PLFX_E_ARG;
    }
    for (k = 0; k < out->n && status == PLFX_OK; k++) {
        status = plfx_view_rows(lut, raw, tone, at[k], white, 0, out->ny, out, k);
    }
    return status;
}
