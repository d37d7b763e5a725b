/* SPDX-License-Identifier: MIT
 * Samples of a patch from a raw frame or an image: as view.h defines them, kept at 16
 * bits. */
#include "roi_state.h"
#include "fix.h"
#include "sure.h"

typedef struct source {
    const plfx_lut *lut;
    const plfx_raw *raw;
    plfx_point shift;
    uint32_t clipped, black;
} source;

plfx_status plfx_roi_frame_ok(const plfx_roi *roi, const plfx_roi_frame *frame)
{
    const plfx_roi_cfg *c = &roi->cfg;
    plfx_raw_row row;

    if (!frame) {
        return PLFX_E_ARG;
    }
    if (!c->lut) {
        const plfx_image *m = frame->image;
        return m && m->px && m->w == c->nx && m->h == c->ny && m->stride >= m->w
                   ? PLFX_OK
                   : PLFX_E_ARG;
    }
    if (!frame->raw || frame->raw->w != c->lut->sensor_w ||
        frame->raw->h != c->lut->sensor_h) {
        return PLFX_E_ARG;
    }
    return plfx_raw_row_at(frame->raw, frame->raw->h - 1, &row);
}

/* Pixels x and x1 = x or x+1 of row y. */
static void two(const plfx_raw *raw, int32_t x, int32_t x1, int32_t y, uint32_t v[2])
{
    uint16_t p[2] = {0, 0};
    plfx_raw_row row;

    if (raw->format == PLFX_RAW_U16) {
        const uint16_t *px =
            (const uint16_t *)(const void *)raw->bytes + (size_t)y * (size_t)raw->w;
        p[0] = px[x];
        p[1] = px[x1];
    } else {
        plfx_sure(plfx_raw_row_at(raw, y, &row));
        plfx_sure(plfx_raw_unpack(&row, x, x1 - x + 1, p));
        p[1] = p[x1 - x];
    }
    v[0] = p[0];
    v[1] = p[1];
}

static uint32_t along(const plfx_raw *raw, int32_t x_q8, int32_t y)
{
    int32_t x = plfx_asr_i32(x_q8, 8);
    uint32_t f = (uint32_t)(x_q8 - 256 * x);
    int32_t k = raw->bits - 8;
    uint32_t v[2];

    two(raw, plfx_clamp_i32(x, 0, raw->w - 1), plfx_clamp_i32(x + 1, 0, raw->w - 1),
        plfx_clamp_i32(y, 0, raw->h - 1), v);
    return (v[0] * (256u - f) + v[1] * f + ((1u << k) >> 1)) >> k;
}

/* Sample beside the centre c, less black, 16 bits. */
static uint32_t beside(const source *s, plfx_point c, uint32_t gain_u13)
{
    int32_t x_q8 = plfx_asr_i32(c.x_q16 + s->shift.x_q16 + 128, 8);
    int32_t y_q8 = plfx_asr_i32(c.y_q16 + s->shift.y_q16 + 128, 8);
    int32_t y = plfx_asr_i32(y_q8, 8);
    uint32_t f = (uint32_t)(y_q8 - 256 * y);
    uint32_t v =
        (along(s->raw, x_q8, y) * (256u - f) + along(s->raw, x_q8, y + 1) * f + 128u) >>
        8;
    uint32_t lit = v > s->black ? v - s->black : 0u;

    if (v >= s->clipped) {
        return PLFX_ROI_UNUSED;
    }
    lit = (lit * gain_u13 + 4096u) >> 13;
    return lit < PLFX_ROI_UNUSED ? lit : PLFX_ROI_UNUSED;
}

/* From here on 16-bit samples of so many bits count as clipped. */
static uint32_t clipped(const plfx_roi *roi, int32_t bits)
{
    uint32_t full = ((1u << bits) - 1u) << (16 - bits);
    uint32_t limit = roi->cfg.tone.sat_u16;

    return full < limit ? full : limit;
}

static void from_image(const plfx_roi *roi, const plfx_image *m, int32_t i, int32_t j,
                       int32_t n, uint16_t *out)
{
    const uint16_t *row = m->px + (size_t)j * (size_t)m->stride;
    uint32_t limit = clipped(roi, roi->cfg.bits);
    int32_t up = 16 - roi->cfg.bits;
    int32_t x;

    for (x = 0; x < n; x++) {
        uint32_t v = (uint32_t)row[i + x] << up;
        out[x] = (uint16_t)(v >= limit ? PLFX_ROI_UNUSED : v);
    }
}

/* Gains of the row, of the nearest lens that the patch knows. */
static const uint16_t *gains(const plfx_roi *roi, const plfx_roi_patch *p, int32_t k,
                             int32_t y)
{
    int32_t h = p->h + 2 * PLFX_ROI_MARGIN;
    int32_t w = p->w + 2 * PLFX_ROI_MARGIN;
    int32_t r = plfx_clamp_i32(y + p->kj + PLFX_ROI_MARGIN, 0, h - 1);
    (void)roi;

    return p->gain ? p->gain + (size_t)(k * h + r) * (size_t)w : NULL;
}

void plfx_roi_sample(const plfx_roi *roi, const plfx_roi_frame *frame,
                     const plfx_roi_patch *p, int32_t k, int32_t y, int32_t x0,
                     int32_t n, uint16_t *out)
{
    int32_t i = p->i0 + p->ki + x0;
    int32_t j = p->j0 + p->kj + y;
    const uint16_t *gain = gains(roi, p, k, y);
    int32_t last = p->w + 2 * PLFX_ROI_MARGIN - 1;
    source s;
    int32_t x;

    if (!roi->cfg.lut) {
        from_image(roi, frame->image, i, j, n, out);
        return;
    }
    s.lut = roi->cfg.lut;
    s.raw = frame->raw;
    s.shift = roi->shift[k];
    s.black = roi->cfg.tone.black_u16;
    s.clipped = clipped(roi, s.raw->bits);
    for (x = 0; x < n; x++) {
        int32_t g = plfx_clamp_i32(x0 + x + p->ki + PLFX_ROI_MARGIN, 0, last);
        out[x] = (uint16_t)beside(&s, plfx_lut_centre(s.lut, i + x, j),
                                  gain ? gain[g] : 8192u);
    }
}
