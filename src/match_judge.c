/* SPDX-License-Identifier: MIT
 * From winners to slopes, confidences and flags along one row; texture of the
 * reference. The numbers are those of winner.c and texture.c, in loops over the row. */
#include "match.h"
#include "fix.h"

#include <string.h>

/* The tie mark of the codes and the confidence become refusals. */
static void refuse_unsure(int16_t *restrict code, const uint16_t *restrict conf,
                          uint16_t *restrict no, int32_t n, uint16_t unique)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        no[i] = (uint16_t)((code[i] < 0 ? PLFX_FLAG_UNIQUE : 0u) |
                           (conf[i] < unique ? PLFX_FLAG_UNIQUE : 0u));
        code[i] = (int16_t)(code[i] & INT16_MAX);
    }
}

/* The same without confidences. */
static void refuse_ties(int16_t *restrict code, uint16_t *restrict no, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        no[i] = code[i] < 0 ? PLFX_FLAG_UNIQUE : 0u;
        code[i] = (int16_t)(code[i] & INT16_MAX);
    }
}

/* With three labels the middle one has no other: no margin, and no tie. */
static void middle_alone(const plfx_judge *m)
{
    int32_t r = m->plan->cfg.window / 2;
    int32_t i;

    for (i = r; i < m->plan->nx - r; i++) {
        if (((m->code_row[i] & INT16_MAX) >> 5) == 1) {
            m->code_row[i] = (int16_t)(m->code_row[i] & INT16_MAX);
            m->conf_row[i] = 0;
        }
    }
}

static void refuse_unlit(const plfx_judge *m)
{
    int32_t r = m->plan->cfg.window / 2;
    int32_t i;

    for (i = r; i < m->plan->nx - r; i++) {
        m->no_row[i] |= (uint16_t)(m->lit_row[i] == 0 ? PLFX_FLAG_TEXTURE : 0u);
    }
}

static void refuse_flat(const plfx_judge *m)
{
    uint32_t w = m->plan->cfg.window;
    uint32_t limit = m->plan->cfg.texture * w * w;
    int32_t r = m->plan->cfg.window / 2;
    int32_t i;

    for (i = r; i < m->plan->nx - r; i++) {
        if (16u * m->tex[i] < limit) {
            m->no_row[i] |= PLFX_FLAG_TEXTURE;
        }
    }
}

/* Windows that leave a view: lenses x0 .. x1-1 one by one. */
static void refuse_range(const plfx_judge *m, const plfx_span *span, int32_t y,
                         int32_t x0, int32_t x1)
{
    int32_t i;

    for (i = x0; i < x1; i++) {
        const plfx_span *s = span + (m->code_row[i] >> 5);
        if (i < s->x0 || i > s->x1 || y < s->y0 || y > s->y1) {
            m->no_row[i] |= PLFX_FLAG_EDGE;
        }
    }
}

/* The lenses where no label leaves a view need no look-up. */
static void refuse_edges(const plfx_judge *m, const plfx_span *span, int32_t y)
{
    int32_t r = m->plan->cfg.window / 2;
    int32_t end = m->plan->nx - r;
    int32_t x0 = r;
    int32_t x1 = end;
    int32_t l;

    for (l = 0; l < m->plan->cfg.labels; l++) {
        x0 = plfx_max_i32(x0, span[l].x0);
        x1 = plfx_min_i32(x1, span[l].x1 + 1);
        if (y < span[l].y0 || y > span[l].y1) {
            x0 = end;
        }
    }
    x0 = plfx_min_i32(x0, end);
    x1 = plfx_clamp_i32(x1, x0, end);
    refuse_range(m, span, y, r, x0);
    refuse_range(m, span, y, x1, end);
}

/* slope = min + round(span*t/d), t = 16*label + fraction, d = 16*(labels-1): with span
 * = whole*d + part the quotient is whole*t + (part*t + d/2)/d, the dividend under
 * 2^24, and x/d = x*m >> 36 with m = 2^36/d + 1 (error under 1/d for d <= 2^12). */
static void write_slopes(const plfx_judge *m, int32_t *restrict slope)
{
    const plfx_cfg *c = &m->plan->cfg;
    const int16_t *restrict code = m->code_row;
    const uint16_t *restrict no = m->no_row;
    uint32_t d = 16u * (c->labels - 1u);
    uint32_t span = (uint32_t)(c->slope_max_q16 - c->slope_min_q16);
    /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): a plan has 3 labels or more */
    uint32_t whole = span / d;
    uint32_t part = span % d;
    uint32_t half = d / 2;
    uint32_t factor = (uint32_t)((((uint64_t)1 << 36) / d) + 1u);
    uint32_t base = (uint32_t)c->slope_min_q16;
    int32_t r = c->window / 2;
    int32_t end = m->plan->nx - r;
    int32_t i;

    if (part == 0) { /* labels whole steps of 2^-16 apart: nothing to divide */
        for (i = r; i < end; i++) {
            uint16_t t = (uint16_t)(((code[i] >> 1) & ~15) + (code[i] & 31) - 8);
            uint32_t s = base + whole * t;
            slope[i] = no[i] ? PLFX_SLOPE_NONE : (int32_t)s;
        }
        return;
    }
    for (i = r; i < end; i++) {
        uint32_t t = (uint32_t)(16 * (code[i] >> 5) + (code[i] & 31) - 8);
        uint32_t q = (uint32_t)(((uint64_t)(part * t + half) * factor) >> 36);
        uint32_t s = base + whole * t + q;
        slope[i] = no[i] ? PLFX_SLOPE_NONE : (int32_t)s;
    }
}

static void write_flags(const plfx_judge *m, uint8_t *restrict flags)
{
    const int16_t *restrict code = m->code_row;
    const uint16_t *restrict no = m->no_row;
    int32_t r = m->plan->cfg.window / 2;
    int32_t end = m->plan->nx - r;
    int32_t last = m->plan->cfg.labels - 1;
    int32_t i;

    for (i = r; i < end; i++) {
        int32_t l = code[i] >> 5;
        flags[i] = (uint8_t)(no[i] | (l == 0 || l == last ? PLFX_FLAG_RANGE_END : 0u));
    }
}

static void write_borders(const plfx_judge *m, const plfx_line *out)
{
    int32_t r = m->plan->cfg.window / 2;
    int32_t nx = m->plan->nx;
    int32_t i;

    for (i = 0; i < 2 * r; i++) {
        int32_t x = i < r ? i : nx - 2 * r + i;
        out->slope_q16[x] = PLFX_SLOPE_NONE;
        if (out->conf_u16) {
            out->conf_u16[x] = 0;
        }
        if (out->flags) {
            out->flags[x] = PLFX_FLAG_EDGE;
        }
    }
}

static void write_conf(const plfx_judge *m, uint16_t *restrict conf, int32_t keep)
{
    const uint16_t *restrict rated = m->conf_row;
    const uint16_t *restrict no = m->no_row;
    int32_t r = m->plan->cfg.window / 2;
    int32_t end = m->plan->nx - r;
    int32_t i;

    for (i = r; i < end; i++) {
        conf[i] = no[i] && !keep ? 0u : rated[i];
    }
}

void plfx_judge_row(const plfx_judge *m, int32_t y, int32_t conf, const plfx_line *out)
{
    const plfx_plan *plan = m->plan;
    int32_t r = plan->cfg.window / 2;
    int32_t n = plan->nx - 2 * r;

    if (plan->cfg.labels == 3) {
        middle_alone(m);
    }
    if (conf) {
        refuse_unsure(m->code_row + r, m->conf_row + r, m->no_row + r, n,
                      plan->cfg.unique_u16);
    } else {
        refuse_ties(m->code_row + r, m->no_row + r, n);
    }
    if (plan->cfg.texture > 0) {
        refuse_flat(m);
    }
    if (m->lit_row) {
        refuse_unlit(m);
    }
    refuse_edges(m, m->span, y);
    write_slopes(m, out->slope_q16);
    write_borders(m, out);
    if (out->flags) {
        write_flags(m, out->flags);
    }
    if (out->conf_u16) {
        write_conf(m, out->conf_u16, 0);
    }
    if (out->weight_u16) {
        write_conf(m, out->weight_u16, 1);
    }
}

static int32_t axes(const plfx_plan *p)
{
    int32_t a = 0;
    int32_t k;

    for (k = 0; k < p->cfg.n; k++) {
        a |= (p->du_q8[k] != 0 ? 1 : 0) | (p->dv_q8[k] != 0 ? 2 : 0);
    }
    return a;
}

void plfx_match_texture_start(plfx_match *m)
{
    size_t nx = (size_t)m->plan->nx;

    m->tex_ready = m->plan->cfg.texture == 0;
    if (!m->tex_ready) {
        memset(m->tex_ring, 0, (size_t)m->plan->cfg.window * nx * sizeof(uint16_t));
        memset(m->tex_col, 0, nx * sizeof(uint32_t));
    }
}

void plfx_match_texture_before(plfx_match *m, const plfx_rows *src, int32_t r)
{
    if (!m->tex_ready) {
        plfx_match_fetch(m, src, r, m->plan->cfg.ref, m->tex_above);
        m->tex_ready = 1;
    }
}

static uint16_t apart(uint16_t a, uint16_t b)
{
    return (uint16_t)(a > b ? a - b : b - a);
}

void plfx_match_texture_row(plfx_match *m, int32_t y)
{
    size_t nx = (size_t)m->plan->nx;
    int32_t a = axes(m->plan);
    const int16_t *slot = m->strip + (y % m->depth) * m->slot_len;
    uint16_t *now = m->tex_now;
    const uint16_t *above = m->tex_ready ? m->tex_above : now;
    uint16_t *held;
    size_t i;

    if (m->plan->cfg.texture == 0) {
        return;
    }
    plfx_k_unstripe(slot + m->row_at[m->plan->cfg.ref], m->blocks, m->plan->nx,
                    (int16_t *)now);
    held = m->tex_ring + (size_t)(y % m->plan->cfg.window) * nx;
    for (i = 0; i < nx; i++) {
        uint16_t d = (uint16_t)((a & 2 ? apart(now[i], above[i]) : 0) +
                                (a & 1 && i > 0 ? apart(now[i], now[i - 1]) : 0));
        m->tex_col[i] += (uint32_t)d - held[i];
        held[i] = d;
    }
    memcpy(m->tex_above, now, nx * sizeof(uint16_t));
    m->tex_ready = 1;
}

void plfx_match_texture_sums(plfx_match *m)
{
    int32_t w = m->plan->cfg.window;
    uint32_t sum = 0;
    int32_t i;

    for (i = 0; m->plan->cfg.texture > 0 && i < m->plan->nx; i++) {
        sum += m->tex_col[i];
        if (i >= w) {
            sum -= m->tex_col[i - w];
        }
        if (i >= w - 1) {
            m->tex[i - w / 2] = sum;
        }
    }
}
