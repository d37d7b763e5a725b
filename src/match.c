/* SPDX-License-Identifier: MIT */
#include "match.h"
#include "store.h"
#include "fix.h"

#include <string.h>

static int32_t other_view(const plfx_plan *plan, int32_t o)
{
    return o < plan->cfg.ref ? o : o + 1;
}

/* What a slide leaves for the winners lies behind the sums. */
static plfx_lead *lead_of(const plfx_match *m)
{
    return (plfx_lead *)(void *)(m->sum + m->cells + PLFX_LANES);
}

/* What the labels ask of the views: pads of each, rows around the target. */
typedef struct survey {
    int32_t flat, above, below;
} survey;

static void survey_shift(survey *v, int32_t *pads, const plfx_plan *plan, plfx_shift s)
{
    int32_t turn = s.ky != 0 || s.fy_q4 != 0;
    int32_t odd = turn ? plfx_max_i32(plan->odd_q4, -plan->odd_q4) : 0;
    int32_t x_q4 = 16 * s.kx + s.fx_q4;

    pads[0] = plfx_max_i32(pads[0], -plfx_asr_i32(x_q4 - odd, 4));
    pads[1] = plfx_max_i32(pads[1], plfx_asr_i32(x_q4 + odd, 4) + 1);
    v->flat &= !turn;
    v->above = plfx_max_i32(v->above, -s.ky);
    v->below = plfx_max_i32(v->below, s.ky + (s.fy_q4 > 0));
}

static survey survey_view(const plfx_plan *plan, int32_t view, int32_t pads[2])
{
    survey v = {1, 0, 0};
    int32_t l;

    pads[0] = 0;
    pads[1] = 0;
    if (view != plan->cfg.ref) {
        for (l = 0; l < plan->cfg.labels; l++) {
            survey_shift(&v, pads, plan, plfx_plan_shift(plan, view, l));
        }
    }
    return v;
}

static void layout(plfx_match *m, const plfx_plan *plan, int32_t leave)
{
    int32_t w = plan->cfg.window;
    int32_t k;

    m->plan = plan;
    m->others = plan->cfg.n - 1;
    m->pairs = plan->cfg.method == PLFX_METHOD_PAIRS ? m->others : 1;
    if (leave == PLFX_LEAVE_COSTS && m->pairs == m->others) {
        leave = PLFX_LEAVE_ROWS; /* one view a cost: cheaper twice than kept */
    }
    m->leave = leave;
    m->labels = plan->cfg.labels;
    m->floor_cost = (uint16_t)plfx_sad_floor(plan);
    m->blocks = plfx_max_i32((plan->nx + PLFX_LANES - 1) / PLFX_LANES, w);
    m->cells = m->labels * PLFX_LANES;
    m->flat = 1;
    m->above = 0;
    m->below = 0;
    m->slot_len = 0;
    for (k = 0; k < plan->cfg.n; k++) {
        int32_t pads[2];
        survey v = survey_view(plan, k, pads);
        m->flat &= v.flat;
        m->above = plfx_max_i32(m->above, v.above);
        m->below = plfx_max_i32(m->below, v.below);
        m->slot_len += (pads[0] + m->blocks + pads[1]) * PLFX_LANES;
    }
    m->depth = 1 + m->above + m->below + (leave == PLFX_LEAVE_ROWS ? w : 0);
}

static void carve_taps(plfx_match *m, plfx_arena *a)
{
    size_t n = (size_t)(m->others * m->labels);

    m->tap[0][0] = plfx_take(a, n, sizeof(plfx_tap));
    m->tap[0][1] = m->tap[0][0];
    m->tap[1][0] = m->tap[0][0];
    m->tap[1][1] = m->tap[0][0];
    m->shift_q4 = NULL;
    if (!m->flat) {
        m->shift_q4 = plfx_take(a, 2 * n, sizeof(int32_t));
        m->tap[0][1] = plfx_take(a, n, sizeof(plfx_tap));
        m->tap[1][0] = m->leave == PLFX_LEAVE_ROWS ? plfx_take(a, n, sizeof(plfx_tap))
                                                   : m->tap[0][0];
        m->tap[1][1] = m->leave == PLFX_LEAVE_ROWS ? plfx_take(a, n, sizeof(plfx_tap))
                                                   : m->tap[0][1];
    }
}

static void carve_rows(plfx_match *m, plfx_arena *a)
{
    size_t n = m->plan->cfg.n;
    size_t nx = (size_t)m->plan->nx;
    size_t wide = (size_t)m->blocks * PLFX_LANES;
    size_t cells = (size_t)m->cells;

    m->tag =
        plfx_take(a, (size_t)m->depth + 3u * n + (size_t)m->pairs, sizeof(int32_t));
    if (m->tag != NULL) { /* a dry run has nothing to divide */
        m->row_at = m->tag + m->depth;
        m->pads = m->row_at + n;
        m->step = m->pads + 2u * n;
    }
    m->strip = plfx_take(a, (size_t)m->depth * (size_t)m->slot_len, sizeof(int16_t));
    m->code = plfx_take(a, 2u * wide, sizeof(int16_t));
    m->conf = plfx_behind(m->code, wide, sizeof(uint16_t));
    m->line = m->code; /* a row is striped before its winners are known */
    m->code_row = plfx_take(a, 3u * nx > cells ? 3u * nx : cells, sizeof(int16_t));
    m->conf_row = plfx_behind(m->code_row, nx, sizeof(uint16_t));
    m->no_row = plfx_behind(m->conf_row, nx, sizeof(uint16_t));
    m->tex_ring = NULL;
    m->tex_above = NULL;
    m->tex_now = NULL;
    m->tex_col = NULL;
    m->tex = NULL;
    if (m->plan->cfg.texture > 0) {
        m->tex_ring = plfx_take(a, (size_t)m->plan->cfg.window * nx, sizeof(uint16_t));
        m->tex_above = plfx_take(a, 2u * nx, sizeof(uint16_t));
        m->tex_now = plfx_behind(m->tex_above, nx, sizeof(uint16_t));
        m->tex_col = plfx_take(a, 2u * nx, sizeof(uint32_t));
        m->tex = plfx_behind(m->tex_col, nx, sizeof(uint32_t));
    }
}

void plfx_match_carve(plfx_match *m, const plfx_plan *plan, int32_t leave,
                      plfx_arena *a)
{
    size_t cells;
    size_t columns;
    size_t cell = sizeof(uint16_t);

    layout(m, plan, leave);
    cells = (size_t)m->cells;
    columns = (size_t)m->pairs * (size_t)m->blocks * cells;
    carve_taps(m, a);
    carve_rows(m, a);
    m->col = plfx_take(a, columns + PLFX_LANES, cell);
    m->ring = NULL;
    if (m->leave == PLFX_LEAVE_COSTS) {
        m->ring = plfx_take(a, (size_t)plan->cfg.window * columns, cell);
    }
    m->item = (uint16_t *)m->code_row; /* judged when all costs have entered */
    m->gone = m->leave == PLFX_LEAVE_ROWS ? plfx_take(a, cells, cell) : NULL;
    m->zero = plfx_take(a, cells, cell);
    m->order = plfx_take(a, cells, cell);
    m->sum = plfx_take(a, cells + 2u * PLFX_LANES + sizeof(plfx_lead) / sizeof(int16_t),
                       cell);
    m->sum = m->sum ? m->sum + PLFX_LANES : NULL;
    m->span = plfx_take(a, (size_t)m->pairs * (size_t)m->labels, sizeof(plfx_span));
}

static void meet(plfx_span *to, plfx_span with)
{
    to->x0 = (int16_t)plfx_max_i32(to->x0, with.x0);
    to->x1 = (int16_t)plfx_min_i32(to->x1, with.x1);
    to->y0 = (int16_t)plfx_max_i32(to->y0, with.y0);
    to->y1 = (int16_t)plfx_min_i32(to->y1, with.y1);
}

/* Shift, tap and span of one view at one label. */
static void place(plfx_match *m, int32_t o, int32_t l)
{
    const plfx_plan *plan = m->plan;
    int32_t view = other_view(plan, o);
    plfx_shift s = plfx_plan_shift(plan, view, l);
    size_t at = (size_t)(o * m->labels + l);
    int32_t p = m->pairs > 1 ? o : 0;
    plfx_span span = plfx_span_of(plan, s, plan->cfg.window / 2);
    plfx_span *to = m->span + p * m->labels + l;

    if (m->pairs > 1 || o == 0) {
        *to = span;
    } else {
        meet(to, span);
    }
    m->tap[0][0][at].off = m->row_at[view] + s.kx * PLFX_LANES;
    m->tap[0][0][at].f_q15 = (int16_t)(s.fx_q4 * 2048);
    m->tap[0][0][at].w_q4 = 16;
    if (!m->flat) {
        m->shift_q4[2 * at] = 16 * s.kx + s.fx_q4;
        m->shift_q4[2 * at + 1] = 16 * s.ky + s.fy_q4;
    }
}

/* Samples between labels when one other view moves by whole, even steps; else 0. */
static int32_t even_step(const plfx_match *m, int32_t o)
{
    const plfx_tap *t = m->tap[0][0] + o * m->labels;
    int32_t step = t[1].off - t[0].off;
    int32_t l;

    if (!m->flat || m->others > m->pairs || t[0].f_q15 != 0) {
        return 0;
    }
    for (l = 1; l < m->labels; l++) {
        if (t[l].f_q15 != 0) { /* whole ones are even: shifts are a line, rounded */
            return 0;
        }
    }
    return step;
}

static void prepare(plfx_match *m)
{
    int32_t at = 0;
    int32_t k;
    int32_t l;

    for (k = 0; k < m->plan->cfg.n; k++) {
        (void)survey_view(m->plan, k, m->pads + 2 * k);
        m->row_at[k] = at + m->pads[2 * k] * PLFX_LANES;
        at = m->row_at[k] + (m->blocks + m->pads[2 * k + 1]) * PLFX_LANES;
    }
    for (k = 0; k < m->others; k++) {
        for (l = 0; l < m->labels; l++) {
            place(m, k, l);
        }
        if (k < m->pairs) {
            m->step[k] = even_step(m, k);
        }
    }
    for (k = 0; k < m->cells; k++) {
        m->order[k] = (int16_t)(m->cells - k);
    }
    memset(m->zero, 0, (size_t)m->cells * sizeof(uint16_t));
}

void plfx_match_start(plfx_match *m, int32_t y0)
{
    size_t columns = (size_t)m->pairs * (size_t)m->blocks * (size_t)m->cells;
    size_t cells = (size_t)m->cells + 2u * PLFX_LANES;
    int32_t k;

    prepare(m);
    memset(m->col, 0, (columns + PLFX_LANES) * sizeof(uint16_t));
    memset(m->sum - PLFX_LANES, 0, cells * sizeof(int16_t));
    if (m->ring) {
        memset(m->ring, 0, (size_t)m->plan->cfg.window * columns * sizeof(uint16_t));
    }
    for (k = 0; k < m->depth; k++) {
        m->tag[k] = -1;
    }
    m->first = y0 - m->plan->cfg.window / 2;
    m->next = m->first;
    plfx_match_texture_start(m);
}

int32_t plfx_match_from(const plfx_match *m)
{
    int32_t before = m->plan->cfg.texture > 0 ? plfx_max_i32(m->above, 1) : m->above;

    return plfx_max_i32(m->first - before, 0);
}

void plfx_match_fetch(const plfx_match *m, const plfx_rows *src, int32_t r, int32_t k,
                      uint16_t *row)
{
    size_t n = m->plan->cfg.n;
    size_t nx = (size_t)m->plan->nx;

    if (r < src->packed_end) {
        size_t at = (size_t)(r % src->packed_depth) * n + (size_t)k;
        size_t len = plfx_store_bytes(m->plan->nx, m->plan->cfg.bits);
        plfx_store_get(src->packed + at * len, m->plan->nx, m->plan->cfg.bits, row);
    } else {
        memcpy(row, src->px + ((size_t)(r % src->depth) * n + (size_t)k) * nx,
               nx * sizeof(uint16_t));
    }
}

static void load_view(plfx_match *m, const plfx_rows *src, int32_t r, int32_t k,
                      int16_t *slot)
{
    int32_t nx = m->plan->nx;
    int16_t last;
    int32_t i;

    plfx_match_fetch(m, src, r, k, (uint16_t *)m->line);
    last = m->line[nx - 1];
    for (i = nx; i < m->blocks * PLFX_LANES; i++) {
        m->line[i] = last;
    }
    plfx_k_stripe(m->line, m->blocks, slot + m->row_at[k]);
    plfx_k_pads(slot + m->row_at[k], m->blocks, m->pads[2 * k], m->pads[2 * k + 1],
                m->line[0], last);
}

static void load_row(plfx_match *m, const plfx_rows *src, int32_t r)
{
    int32_t slot = r % m->depth;
    int32_t k;

    if (m->tag[slot] == r) {
        return;
    }
    for (k = 0; k < m->plan->cfg.n; k++) {
        load_view(m, src, r, k, m->strip + slot * m->slot_len);
    }
    m->tag[slot] = r;
}

/* Striped rows around target row y are in their slots. */
static void load(plfx_match *m, const plfx_rows *src, int32_t y)
{
    int32_t r0 = plfx_max_i32(y - m->above, 0);
    int32_t r1 = plfx_min_i32(y + m->below, m->plan->ny - 1);
    int32_t r;

    for (r = r0; r <= r1; r++) {
        load_row(m, src, r);
    }
}

void plfx_match_feed(plfx_match *m, const plfx_rows *src, int32_t r)
{
    if (r == m->first - 1) {
        plfx_match_texture_before(m, src, r);
    }
    if (m->leave != PLFX_LEAVE_DROP && r >= m->first - m->above) {
        load_row(m, src, r);
    }
}

/* Tap of a source row for target row y. */
static plfx_tap tap_at(const plfx_match *m, int32_t view, int32_t x_q4, int32_t y,
                       int32_t row, int32_t w_q4)
{
    int32_t r = plfx_clamp_i32(row, 0, m->plan->ny - 1);
    int32_t x = x_q4 + m->plan->odd_q4 * ((y & 1) - (r & 1));
    int32_t k = plfx_asr_i32(x, 4);
    plfx_tap t;

    t.off = (r % m->depth) * m->slot_len + m->row_at[view] + k * PLFX_LANES;
    t.f_q15 = (int16_t)((x - 16 * k) * 2048);
    t.w_q4 = (uint16_t)w_q4;
    return t;
}

/* Taps of target row y into set 0 (entering) or 1 (leaving). */
static void aim(plfx_match *m, int32_t y, int32_t set)
{
    int32_t n = m->others * m->labels;
    int32_t at;

    if (m->flat) {
        return;
    }
    for (at = 0; at < n; at++) {
        int32_t view = other_view(m->plan, at / m->labels);
        int32_t x = m->shift_q4[2 * at];
        int32_t ky = plfx_asr_i32(m->shift_q4[2 * at + 1], 4);
        int32_t fy = m->shift_q4[2 * at + 1] - 16 * ky;
        m->tap[set][0][at] = tap_at(m, view, x, y, y + ky, 16 - fy);
        m->tap[set][1][at] = tap_at(m, view, x, y, y + ky + (fy > 0), fy);
    }
}

/* A cost row that enters or leaves: its slot and taps. */
typedef struct stripe {
    const int16_t *ref;  /* reference view, block 0 */
    const int16_t *base; /* taps count from here, block 0 */
    int32_t set;         /* which taps */
} stripe;

static stripe stripe_of(const plfx_match *m, int32_t y, int32_t set)
{
    const int16_t *slot = m->strip + (y % m->depth) * m->slot_len;
    stripe s;

    s.ref = slot + m->row_at[m->plan->cfg.ref];
    s.base = m->flat ? slot : m->strip;
    s.set = set;
    return s;
}

/* Costs of block b for pair p. */
static void block_cost(const plfx_match *m, int32_t p, const stripe *s, int32_t b,
                       uint16_t *item)
{
    const int16_t *c = s->ref + b * PLFX_LANES;
    const int16_t *base = s->base + b * PLFX_LANES;
    int32_t per_pair = m->pairs > 1 ? 1 : m->others;
    int32_t k;

    for (k = 0; k < per_pair; k++) {
        size_t at = (size_t)((p + k) * m->labels);
        if (m->flat) {
            plfx_k_cost(item, c, base, m->tap[0][0] + at, m->labels, k == 0);
        } else {
            plfx_k_cost_2d(item, c, base, m->tap[s->set][0] + at,
                           m->tap[s->set][1] + at, m->labels, k == 0);
        }
    }
    if (m->plan->sad_shift1) {
        plfx_k_scale(item, m->cells, m->plan->sad_shift1);
    }
}

/* One cost row enters the columns; emit: winners are wanted as the window slides. */
typedef struct pass {
    stripe in, out;
    int32_t leaves; /* 1: `out` leaves */
    uint16_t *held; /* ring row of pair 0, or NULL */
    int32_t emit;
    int32_t conf; /* 1: confidence wanted */
} pass;

/* Where the winners of output block `at` go. */
static plfx_winners winners_at(const plfx_match *m, const pass *s, int32_t at)
{
    plfx_winners out;

    out.code = m->code + at * PLFX_LANES;
    out.conf = s->conf ? m->conf + at * PLFX_LANES : NULL;
    out.floor_cost = m->floor_cost;
    out.best = NULL;
    out.rest = NULL;
    return out;
}

static void winners(const plfx_match *m, const pass *s, int32_t b)
{
    int32_t at = b - m->plan->cfg.window + 1;

    if (at >= 0) {
        plfx_winners out = winners_at(m, s, at);
        plfx_k_select(m->sum, lead_of(m), m->order, m->labels, m->plan->cfg.fit, &out);
    }
}

static void run_whole(plfx_match *m, int32_t p, const pass *s, uint16_t *cols)
{
    int32_t to = m->tap[0][0][p * m->labels].off;
    int32_t near = m->step[p] == PLFX_LANES || m->step[p] == -PLFX_LANES;
    const int16_t *none = (const int16_t *)m->zero;
    plfx_winners out = winners_at(m, s, 0);
    plfx_whole_row k;

    k.col = cols;
    k.sum = m->sum;
    k.zero = m->zero;
    k.left = s->in.ref;
    k.right = s->in.base + to;
    k.left_gone = s->leaves ? s->out.ref : none;
    k.right_gone = s->leaves ? s->out.base + to : none;
    k.step = m->step[p];
    k.gone_step = s->leaves || near ? m->step[p] : 0;
    if (!s->leaves && k.gone_step < 0) { /* zeros by the same steps where they reach */
        k.right_gone += m->cells - PLFX_LANES;
    }
    k.gone_next = s->leaves ? PLFX_LANES : 0;
    k.blocks = m->blocks;
    k.window = m->plan->cfg.window;
    k.labels = m->labels;
    k.s1 = m->plan->sad_shift1;
    k.s2 = m->plan->sad_shift2;
    k.fit = m->plan->cfg.fit;
    k.order = m->order;
    k.lead = lead_of(m);
    k.out = s->emit ? &out : NULL;
    plfx_k_whole(&k);
}

static void run_general(plfx_match *m, int32_t p, const pass *s, uint16_t *cols)
{
    size_t cells = (size_t)m->cells;
    size_t ahead = (size_t)m->plan->cfg.window * cells;
    plfx_update_block u = {
        NULL, m->sum, m->item, NULL, NULL, m->labels, m->plan->sad_shift2, lead_of(m)};
    int32_t b;

    for (b = 0; b < m->blocks; b++) {
        uint16_t *col = cols + (size_t)b * cells;
        const uint16_t *leave = b < m->plan->cfg.window ? m->zero : col - ahead;
        const uint16_t *gone = m->zero;
        uint16_t *held = NULL;
        block_cost(m, p, &s->in, b, m->item);
        if (s->held) {
            held = s->held + (size_t)(p * m->blocks + b) * cells;
            gone = held;
        } else if (s->leaves) {
            block_cost(m, p, &s->out, b, m->gone);
            gone = m->gone;
        }
        u.col = col;
        u.gone = gone;
        u.leave = leave;
        plfx_k_update(&u);
        if (held) {
            memcpy(held, m->item, cells * sizeof(uint16_t));
        }
        if (s->emit) {
            winners(m, s, b);
        }
    }
}

/* Blocks a segment on, whose windows reach into the next one. */
static void next_segment(plfx_match *m, const pass *s, const uint16_t *cols)
{
    size_t cells = (size_t)m->cells;
    int32_t w = m->plan->cfg.window;
    int32_t b;

    for (b = m->blocks; b < m->blocks + w - 1; b++) {
        plfx_k_slide(m->sum, cols + (size_t)(b - m->blocks) * cells + 1,
                     cols + (size_t)(b - w) * cells, m->labels, m->plan->sad_shift2,
                     lead_of(m));
        winners(m, s, b);
    }
}

static void run_pair(plfx_match *m, int32_t p, const pass *s)
{
    size_t cells = (size_t)m->cells;
    uint16_t *cols = m->col + (size_t)(p * m->blocks) * cells;
    int32_t b;

    for (b = 0; b < m->cells; b++) {
        m->sum[b] = INT16_MIN;
    }
    if (m->step[p]) { /* rows leave then, not costs */
        run_whole(m, p, s, cols);
        return;
    }
    run_general(m, p, s, cols);
    if (PLFX_LANES > 1 && s->emit) {
        next_segment(m, s, cols);
    }
}

static void collect(plfx_match *m, int32_t p, int32_t y, const pass *s,
                    const plfx_line *line)
{
    plfx_judge judge = {m->plan,
                        m->code_row,
                        m->conf_row,
                        m->no_row,
                        NULL,
                        m->tex,
                        m->span + p * m->labels};
    int32_t r = m->plan->cfg.window / 2;
    int32_t n = m->plan->nx - 2 * r;

    plfx_k_unstripe(m->code, m->blocks, n, m->code_row + r);
    if (s->conf) {
        plfx_k_unstripe((const int16_t *)m->conf, m->blocks, n,
                        (int16_t *)m->conf_row + r);
    }
    plfx_judge_row(&judge, y, s->conf, line);
}

/* Row y of the source becomes ready to enter. */
static pass begin(plfx_match *m, const plfx_rows *src, int32_t y)
{
    int32_t w = m->plan->cfg.window;
    pass s;

    load(m, src, y);
    aim(m, y, 0);
    s.in = stripe_of(m, y, 0);
    s.out = s.in;
    s.leaves = m->leave == PLFX_LEAVE_ROWS && y - w >= m->first;
    if (s.leaves) {
        aim(m, y - w, 1);
        s.out = stripe_of(m, y - w, 1);
    }
    s.held = NULL;
    if (m->leave == PLFX_LEAVE_COSTS) {
        size_t row = (size_t)(m->pairs * m->blocks) * (size_t)m->cells;
        s.held = m->ring + (size_t)(y % w) * row;
    }
    s.emit = 0;
    s.conf = 0;
    return s;
}

static void enter_row(plfx_match *m, const plfx_rows *src, const plfx_line *lines,
                      int32_t y)
{
    pass s;
    int32_t p;

    if (m->next == m->first && m->first > 0) {
        plfx_match_texture_before(m, src, m->first - 1);
    }
    s = begin(m, src, m->next);
    plfx_match_texture_row(m, m->next);
    if (lines) {
        s.emit = 1;
        s.conf = lines->conf_u16 || m->plan->cfg.unique_u16 > 0;
        plfx_match_texture_sums(m);
    }
    for (p = 0; p < m->pairs; p++) {
        run_pair(m, p, &s);
        if (lines) {
            collect(m, p, y, &s, lines + p);
        }
    }
    m->next++;
}

void plfx_match_enter(plfx_match *m, const plfx_rows *src, int32_t last)
{
    int32_t rows = last - m->next + 1;
    int32_t i;

    for (i = 0; i < rows; i++) {
        enter_row(m, src, NULL, 0);
    }
}

void plfx_match_row(plfx_match *m, const plfx_rows *src, int32_t y,
                    const plfx_line *lines)
{
    plfx_match_enter(m, src, y + m->plan->cfg.window / 2 - 1);
    enter_row(m, src, lines, y);
}

void plfx_match_drop(plfx_match *m, const plfx_rows *src, int32_t y)
{
    int32_t row = y - m->plan->cfg.window / 2;
    plfx_update_block u = {NULL,    m->sum,    m->zero, m->item,
                           m->zero, m->labels, 0,       lead_of(m)};
    stripe s;
    int32_t p;
    int32_t b;

    load(m, src, row);
    aim(m, row, 0);
    s = stripe_of(m, row, 0);
    for (p = 0; p < m->pairs; p++) {
        for (b = 0; b < m->blocks; b++) {
            size_t at = (size_t)(p * m->blocks + b) * (size_t)m->cells;
            block_cost(m, p, &s, b, m->item);
            u.col = m->col + at;
            plfx_k_update(&u);
        }
    }
}
