/* SPDX-License-Identifier: MIT
 * Samples of a patch from a raw frame or an image: as view.h defines them, kept at 16
 * bits. */
#include "roi_state.h"
#include "fix.h"
#include "lut_rows.h"
#include "sure.h"

typedef struct source {
    const plfx_raw *raw;
    int32_t y;             /* row over the sample, and */
    const uint16_t *px[2]; /* its pixels and those of the next, where they are U16 */
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

static void at_row(source *s, int32_t y)
{
    size_t first = (size_t)plfx_clamp_i32(y, 0, s->raw->h - 1);
    size_t step = y >= 0 && y < s->raw->h - 1 ? (size_t)s->raw->w : 0u;

    s->y = y;
    s->px[0] =
        (const uint16_t *)(const void *)s->raw->bytes + first * (size_t)s->raw->w;
    s->px[1] = s->px[0] + step;
}

/* Pixels x and x1 = x or x+1 of row s->y + k. */
static void two(const source *s, int32_t x, int32_t x1, int32_t k, uint32_t v[2])
{
    const plfx_raw *raw = s->raw;
    uint16_t p[2] = {0, 0};
    plfx_raw_row row;

    if (raw->format == PLFX_RAW_U16) {
        /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): at_row() came before */
        p[0] = s->px[k][x];
        p[1] = s->px[k][x1];
    } else {
        plfx_sure(plfx_raw_row_at(raw, plfx_clamp_i32(s->y + k, 0, raw->h - 1), &row));
        plfx_sure(plfx_raw_unpack(&row, x, x1 - x + 1, p));
        p[1] = p[x1 - x];
    }
    v[0] = p[0];
    v[1] = p[1];
}

/* a*(256 - f) + b*f of 16 bits by one product. */
static uint32_t mix(uint32_t a, uint32_t b, int32_t f)
{
    return (uint32_t)((int32_t)a * 256 + ((int32_t)b - (int32_t)a) * f);
}

static uint32_t along(const source *s, int32_t x_q8, int32_t k)
{
    const plfx_raw *raw = s->raw;
    int32_t x = plfx_asr_i32(x_q8, 8);
    int32_t down = raw->bits - 8;
    uint32_t v[2];

    two(s, plfx_clamp_i32(x, 0, raw->w - 1), plfx_clamp_i32(x + 1, 0, raw->w - 1), k,
        v);
    return (mix(v[0], v[1], x_q8 - 256 * x) + ((1u << down) >> 1)) >> down;
}

/* Sample at c, less black, 16 bits. */
static uint32_t sample(source *s, plfx_point c, const uint16_t *gain_u13)
{
    int32_t x_q8 = plfx_asr_i32(c.x_q16 + 128, 8);
    int32_t y_q8 = plfx_asr_i32(c.y_q16 + 128, 8);
    int32_t y = plfx_asr_i32(y_q8, 8);
    uint32_t v;
    uint32_t lit;

    if (y != s->y) {
        at_row(s, y);
    }
    v = (mix(along(s, x_q8, 0), along(s, x_q8, 1), y_q8 - 256 * y) + 128u) >> 8;
    lit = v > s->black ? v - s->black : 0u;
    if (v >= s->clipped) {
        return PLFX_ROI_UNUSED;
    }
    if (gain_u13) {
        lit = (lit * *gain_u13 + 4096u) >> 13;
        lit = lit < PLFX_ROI_UNUSED ? lit : PLFX_ROI_UNUSED;
    }
    return lit;
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
static const uint16_t *gains(const plfx_roi_patch *p, int32_t k, int32_t y)
{
    int32_t h = p->h + 2 * PLFX_ROI_MARGIN;
    int32_t w = p->w + 2 * PLFX_ROI_MARGIN;
    int32_t r = plfx_clamp_i32(y + p->kj + PLFX_ROI_MARGIN, 0, h - 1);

    return p->gain ? p->gain + (size_t)(k * h + r) * (size_t)w : NULL;
}

void plfx_roi_sample(const plfx_roi *roi, const plfx_roi_frame *frame,
                     const plfx_roi_patch *p, int32_t k, int32_t y, int32_t x0,
                     int32_t n, uint16_t *out)
{
    int32_t i = p->i0 + p->ki + x0;
    int32_t j = p->j0 + p->kj + y;
    const uint16_t *gain = gains(p, k, y);
    int32_t last = p->w + 2 * PLFX_ROI_MARGIN - 1;
    plfx_lut_walk at;
    source s;
    int32_t x;

    if (!roi->cfg.lut) {
        from_image(roi, frame->image, i, j, n, out);
        return;
    }
    plfx_lut_walk_from(roi->cfg.lut, i, j, &at);
    s.raw = frame->raw;
    s.black = roi->cfg.tone.black_u16;
    s.clipped = clipped(roi, s.raw->bits);
    s.y = INT32_MIN;
    s.px[0] = NULL;
    s.px[1] = NULL;
    for (x = 0; x < n; x++) {
        int32_t g = plfx_clamp_i32(x0 + x + p->ki + PLFX_ROI_MARGIN, 0, last);
        plfx_point c = plfx_lut_walk_on(roi->cfg.lut, &at);
        c.x_q16 += roi->shift[k].x_q16;
        c.y_q16 += roi->shift[k].y_q16;
        out[x] = (uint16_t)sample(&s, c, gain ? gain + g : NULL);
    }
}
