/* SPDX-License-Identifier: MIT */
#include "plenofix/stream.h"
#include "arms_stream.h"
#include "engine.h"
#include "gather.h"
#include "lut_rows.h"
#include "ringed.h"
#include "store.h"
#include "fix.h"

#include <string.h>

/* Build with -DPLFX_STREAM_ARMS=0 to leave arms of views out of what a program links:
 * plans of them are then refused. */
#ifndef PLFX_STREAM_ARMS
#define PLFX_STREAM_ARMS 1
#endif

typedef struct state {
    plfx_engine *engine;    /* of SWEEP and PAIRS */
    plfx_arms_stream *arms; /* of ARMS */
    plfx_ringed *ringed;    /* of NCC and GRADIENT */
    plfx_gather gather;
    int32_t below;   /* lens rows after its own that a map row waits for */
    plfx_lut *table; /* of a fed stream: its rows in the workspace */
    uint8_t *rows;
    int32_t fed_end;       /* lens rows before it were fed */
    plfx_rows_span fed_to; /* farthest ends of their sensor rows */
    uint8_t *store;        /* [store_depth] view rows at rest, small profile */
    int32_t store_depth;
    int32_t open_end;  /* lens rows before it are open or whole */
    int32_t whole_end; /* lens rows before it are whole */
    int32_t store_end; /* lens rows before it are at rest */
    int32_t from, to;  /* lens rows needed: from .. to - 1 */
    int32_t y0, y1;    /* map rows that are matched: y0 .. y1 - 1 */
} state;

static int32_t small(const plfx_stream_cfg *c)
{
    return c->profile == PLFX_PROFILE_SMALL;
}

static int32_t tone_ok(const plfx_tone *t)
{
    return t->gain_q12 >= 4096u && t->gain_q12 <= 8191u && t->shift >= -8 &&
           t->shift <= 8 && t->dx_q8 >= -256 && t->dx_q8 <= 256 && t->dy_q8 >= -256 &&
           t->dy_q8 <= 256;
}

static int32_t raw_ok(const plfx_stream_cfg *c)
{
    return plfx_raw_bpp(c->format) > 0 && c->bits >= 8 && c->bits <= 16;
}

static plfx_arms_stream *arms_of(const state *s)
{
    return PLFX_STREAM_ARMS ? s->arms : NULL;
}

static int32_t is_arms(const plfx_stream_cfg *c)
{
    return PLFX_STREAM_ARMS && c->plan->cfg.method == PLFX_METHOD_ARMS;
}

static int32_t method_ok(const plfx_stream_cfg *c)
{
    if (is_arms(c)) {
        return plfx_arms_streams(c->plan, c->frame);
    }
    return plfx_ringed_is(c->plan) || (c->plan->cfg.method <= PLFX_METHOD_PAIRS &&
                                       c->plan->cfg.cost == PLFX_COST_SAD);
}

static int32_t cfg_ok(const plfx_stream_cfg *c)
{
    if (!c || !c->plan || !c->lut || c->profile > PLFX_PROFILE_FAST || !raw_ok(c) ||
        !tone_ok(&c->tone)) {
        return 0;
    }
    return c->plan->nx == c->lut->lattice.nx && c->plan->ny == c->lut->lattice.ny &&
           c->fed <= 1 && method_ok(c) && c->tone.bits == c->plan->cfg.bits &&
           c->open_rows >= 1 && c->open_rows <= PLFX_STREAM_OPEN_MAX && c->j0 >= 0 &&
           c->j0 < c->j1 && c->j1 <= c->plan->ny;
}

/* Where the state is NULL, sizes alone are wanted. */
static void carve_arms(state *s, const plfx_stream_cfg *c, plfx_arena *a)
{
    plfx_arms_stream dry;
    plfx_arms_stream *arms = plfx_take(a, 1, sizeof *arms);
    void *base = plfx_take(a, plfx_arms_carve(&dry, c->plan, c->frame, NULL), 1);

    if (s) {
        (void)plfx_arms_carve(arms, c->plan, c->frame, base);
        s->arms = arms;
        s->below = plfx_arms_below(arms);
    }
}

static void carve_engine(state *s, const plfx_stream_cfg *c, plfx_arena *a)
{
    plfx_engine dry;
    plfx_engine *e = plfx_take(a, 1, sizeof *e);
    plfx_engine *to;
    size_t row = plfx_store_bytes(c->plan->nx, c->plan->cfg.bits) * c->plan->cfg.n;
    uint8_t *store = NULL;
    int32_t depth;

    memset(&dry, 0, sizeof dry);
    to = e ? e : &dry;
    plfx_engine_carve(to, c->plan, small(c) ? PLFX_LEAVE_DROP : PLFX_LEAVE_COSTS, a);
    depth = small(c) ? c->plan->cfg.window + to->match.above + to->match.below - 1 : 1;
    if (small(c)) {
        store = plfx_take(a, (size_t)depth, row);
    }
    if (s) {
        s->engine = e;
        s->store = store;
        s->store_depth = depth;
        s->below = to->match.below + c->plan->cfg.window / 2;
    }
}

static void carve_ringed(state *s, const plfx_stream_cfg *c, plfx_arena *a)
{
    plfx_ringed dry;
    plfx_ringed *r = plfx_take(a, 1, sizeof *r);
    plfx_ringed *to;

    memset(&dry, 0, sizeof dry);
    to = r ? r : &dry;
    plfx_ringed_carve(to, c->plan, a);
    if (s) {
        s->ringed = r;
        s->below = to->below + c->plan->cfg.window / 2;
    }
}

static void carve_gather(state *s, const plfx_stream_cfg *c, plfx_arena *a)
{
    plfx_gather dry;

    plfx_gather_carve(s ? &s->gather : &dry, c, a);
}

/* Room for the rows of the table that are in use. */
static void carve_rows(state *s, const plfx_stream_cfg *c, plfx_arena *a)
{
    size_t lenses = (size_t)c->open_rows * (size_t)c->lut->lattice.nx;
    plfx_lut *table = c->fed ? plfx_take(a, 1, sizeof *table) : NULL;
    uint8_t *rows = c->fed ? plfx_take(a, lenses, PLFX_LUT_ROW_BYTES) : NULL;

    if (s && rows) {
        *table = *c->lut;
        table->rows = rows;
        table->held = c->open_rows;
        table->resi.length = 1; /* there is one */
        table->flag.length = 1;
        s->rows = rows;
        s->table = table;
        s->gather.lut = table;
    }
}

/* The state itself comes first, then what it points to. */
static void carve(state *s, const plfx_stream_cfg *c, plfx_arena *a)
{
    (void)plfx_take(a, 1, sizeof(state));
    if (s) {
        memset(s, 0, sizeof *s);
    }
    carve_gather(s, c, a);
    carve_rows(s, c, a);
    if (PLFX_STREAM_ARMS && is_arms(c)) {
        carve_arms(s, c, a);
    } else if (plfx_ringed_is(c->plan)) {
        carve_ringed(s, c, a);
    } else {
        carve_engine(s, c, a);
    }
}

size_t plfx_stream_ws(const plfx_stream_cfg *cfg)
{
    plfx_arena a = {NULL, 0};

    if (!cfg_ok(cfg)) {
        return 0;
    }
    carve(NULL, cfg, &a);
    return a.used;
}

/* The first lens row that map row y0 needs. */
static int32_t start_rows(const state *s)
{
    if (s->ringed) {
        const plfx_ringed *r = s->ringed;
        plfx_ringed_start(s->ringed, s->y0);
        return plfx_max_i32(s->y0 - r->plan->cfg.window / 2 - r->above, 0);
    }
    plfx_match_start(&s->engine->match, s->y0);
    return plfx_match_from(&s->engine->match);
}

/* Map rows that hold a window, and the lens rows they depend on. */
static void choose_rows(state *s, const plfx_stream_cfg *c)
{
    int32_t ny = c->plan->ny;
    int32_t r = s->ringed ? s->ringed->margin : c->plan->cfg.window / 2;

    if (arms_of(s)) {
        plfx_arms_range rows = plfx_arms_start(s->arms, c->j0, c->j1);
        s->y0 = c->j0;
        s->y1 = c->j1;
        s->from = rows.from;
        s->to = rows.to;
        return;
    }
    s->y0 = plfx_clamp_i32(c->j0, r, plfx_max_i32(ny - r, r));
    s->y1 = plfx_clamp_i32(c->j1, s->y0, plfx_max_i32(ny - r, s->y0));
    s->from = start_rows(s);
    s->to = plfx_min_i32(s->y1 + s->below, ny);
    if (s->y0 >= s->y1) {
        s->to = s->from;
    }
}

/* Open lens rows until `open` are, each after the one before it. */
static void open_more(state *s)
{
    int32_t end = plfx_min_i32(s->whole_end + s->gather.open, s->to);

    end = s->rows ? plfx_min_i32(end, s->fed_end) : end;
    for (; s->open_end < end; s->open_end++) {
        plfx_gather_open(&s->gather, s->open_end);
    }
}

/* Map rows up to here need nothing more. */
static int32_t poppable(const state *s, const plfx_stream_cfg *c)
{
    if (s->whole_end == s->to) {
        return c->j1;
    }
    return plfx_clamp_i32(s->whole_end - s->below, plfx_min_i32(s->y0, c->j1), c->j1);
}

static void begin(plfx_stream *s)
{
    state *t = s->state;

    choose_rows(t, &s->cfg);
    t->open_end = t->from;
    t->whole_end = t->from;
    t->store_end = t->from;
    t->fed_end = t->from;
    t->fed_to.lo = 0;
    t->fed_to.hi = 0;
    open_more(t);
    s->y = 0;
    s->j = s->cfg.j0;
    s->ready = poppable(t, &s->cfg);
    s->started = 0;
}

/* A lens row must be whole before its slot is opened again: neither end of the rows'
 * spans may go back, and row j + open begins after row j ends. */
static int32_t fits(const plfx_gather *g, int32_t open, int32_t ny)
{
    int32_t lo = 0;
    int32_t hi = 0;
    int32_t j;

    for (j = 0; j < ny; j++) {
        plfx_rows_span s = plfx_gather_span(g, j);
        if (s.hi < s.lo) {
            continue;
        }
        if (s.lo < lo || s.hi < hi) {
            return 0;
        }
        lo = s.lo;
        hi = s.hi;
        if (j + open < ny) {
            plfx_rows_span next = plfx_gather_span(g, j + open);
            if (next.lo <= s.hi) { /* never of a row without lenses */
                return 0;
            }
        }
    }
    return 1;
}

int32_t plfx_stream_open_rows(const plfx_lut *lut, const plfx_plan *plan,
                              const plfx_tone *tone)
{
    plfx_gather g;
    int32_t open;

    if (!lut || !plan || !tone || plan->ny != lut->lattice.ny) {
        return 0;
    }
    g.lut = lut;
    g.tone = *tone;
    g.at = plan->cfg.at;
    g.n = plan->cfg.n;
    g.shift = NULL;
    plfx_gather_start(&g);
    for (open = 1; open <= PLFX_STREAM_OPEN_MAX; open++) {
        if (fits(&g, open, plan->ny)) {
            return open;
        }
    }
    return 0;
}

plfx_status plfx_stream_init(plfx_stream *s, const plfx_stream_cfg *cfg, void *ws,
                             size_t ws_size)
{
    plfx_arena a;
    state *t = ws;
    int32_t open;

    if (!s || !cfg_ok(cfg)) {
        return PLFX_E_ARG;
    }
    if (!ws || !plfx_aligned(ws) || ws_size < plfx_stream_ws(cfg)) {
        return PLFX_E_SIZE;
    }
    open = cfg->fed ? 1 : plfx_stream_open_rows(cfg->lut, cfg->plan, &cfg->tone);
    if (open == 0 || open > cfg->open_rows) {
        return PLFX_E_RANGE;
    }
    s->cfg = *cfg;
    s->state = ws;
    a.base = ws;
    a.used = 0;
    carve(t, &s->cfg, &a);
    plfx_gather_start(&t->gather);
    begin(s);
    return PLFX_OK;
}

void plfx_stream_rows(const plfx_stream *s, int32_t *first, int32_t *last)
{
    const state *t = s->state;
    int32_t j;

    *first = t->rows ? 0 : INT32_MAX;
    *last = t->rows ? s->cfg.lut->sensor_h - 1 : -1;
    for (j = t->from; j < t->to && !t->rows; j++) {
        plfx_rows_span r = plfx_gather_span(&t->gather, j);
        *first = plfx_min_i32(*first, r.lo);
        *last = plfx_max_i32(*last, r.hi);
    }
}

static plfx_rows source(const state *s)
{
    plfx_rows r;

    r.px = s->gather.rows;
    r.depth = s->gather.open;
    r.packed = s->store;
    r.packed_depth = s->store_depth;
    r.packed_end = s->store ? s->store_end : 0;
    return r;
}

/* Whole rows come to rest as far as the store has room: rows that a window still needs
 * are never overwritten. */
static void rest(state *s, const plfx_stream_cfg *c)
{
    size_t n = c->plan->cfg.n;
    size_t len = plfx_store_bytes(c->plan->nx, c->plan->cfg.bits);
    size_t k;

    for (; s->store && s->store_end < s->whole_end; s->store_end++) {
        const uint16_t *row = s->gather.rows + (size_t)(s->store_end % s->gather.open) *
                                                   n * (size_t)c->plan->nx;
        uint8_t *to = s->store + (size_t)(s->store_end % s->store_depth) * n * len;
        for (k = 0; k < n; k++) {
            plfx_store_put(to + k * len, c->plan->nx, c->plan->cfg.bits,
                           row + k * (size_t)c->plan->nx);
        }
    }
}

/* Lens row whole_end - 1 is new to the matcher: its costs enter as far as no map row
 * waits for them. */
static void enter(const plfx_stream *s, state *t)
{
    int32_t r = s->cfg.plan->cfg.window / 2;
    int32_t j = t->whole_end - 1;
    plfx_rows src = source(t);
    const uint16_t *row =
        src.px + (size_t)(j % src.depth) * s->cfg.plan->cfg.n * (size_t)s->cfg.plan->nx;
    int32_t cost;

    if (t->ringed) {
        plfx_ringed_put(t->ringed, j, row);
        return;
    }
    if (arms_of(t)) {
        plfx_arms_put(t->arms, j, row);
        plfx_arms_enter(t->arms, j, s->j);
        return;
    }
    plfx_match_feed(&t->engine->match, &src, j);
    cost = t->whole_end == t->to ? j : j - t->engine->match.below;
    plfx_match_enter(&t->engine->match, &src,
                     plfx_min_i32(cost, plfx_max_i32(s->j, t->y0) + r - 1));
}

static void close_row(plfx_stream *s)
{
    state *t = s->state;

    plfx_gather_close(&t->gather, t->whole_end);
    t->whole_end++;
    enter(s, t);
    s->ready = poppable(t, &s->cfg);
    if (s->ready <= s->j) {
        rest(t, &s->cfg);
        open_more(t);
    }
}

/* Rows that are whole by sensor row y, as long as no map row waits. */
static void close_rows(plfx_stream *s)
{
    state *t = s->state;

    /* at most as many as there are lens rows */
    while (s->ready <= s->j && t->whole_end < t->open_end &&
           t->gather.hi[t->whole_end % t->gather.open] < s->y) {
        close_row(s);
    }
}

int32_t plfx_stream_wants(const plfx_stream *s)
{
    const state *t = s ? s->state : NULL;

    if (!t || !t->rows || (s->started && s->ready > s->j)) {
        return -1;
    }
    return t->fed_end < plfx_min_i32(t->whole_end + t->gather.open, t->to) ? t->fed_end
                                                                           : -1;
}

static void put_u16(uint8_t *to, uint32_t v)
{
    to[0] = (uint8_t)(v & 255u);
    to[1] = (uint8_t)(v >> 8 & 255u);
}

/* A lens row into its place, in the bytes of a table. */
static void keep_row(state *t, int32_t j, const plfx_lens_row *row)
{
    int32_t nx = t->table->lattice.nx;
    size_t held = (size_t)t->table->held * (size_t)nx;
    size_t at = (size_t)(j % t->table->held) * (size_t)nx;
    uint8_t *resi = t->rows + 4u * at;
    uint8_t *flag = t->rows + 4u * held + at;
    uint8_t *gain = t->rows + 5u * held + 2u * at;
    int32_t i;

    for (i = 0; i < nx; i++) {
        put_u16(resi + 4 * i, row->resid_q12 ? (uint16_t)row->resid_q12[2 * i] : 0u);
        put_u16(resi + 4 * i + 2,
                row->resid_q12 ? (uint16_t)row->resid_q12[2 * i + 1] : 0u);
        flag[i] = row->flags ? row->flags[i] : 0;
        put_u16(gain + 2 * i, row->lens_gain_u13 ? row->lens_gain_u13[i] : 8192u);
    }
}

/* Sensor rows of a lens row that was fed: none that went by, none before those of the
 * rows above. */
static int32_t in_order(const plfx_stream *s, state *t, int32_t j)
{
    plfx_rows_span r = plfx_gather_span(&t->gather, j);

    if (r.hi < r.lo) {
        return 1;
    }
    if (r.lo < t->fed_to.lo || r.hi < t->fed_to.hi || (s->started && r.lo < s->y)) {
        return 0;
    }
    t->fed_to = r;
    return 1;
}

plfx_status plfx_stream_feed(plfx_stream *s, int32_t j, const plfx_lens_row *row,
                             int32_t *ready)
{
    state *t;

    if (!s || !s->state || !row || !ready) {
        return PLFX_E_ARG;
    }
    if (j < 0 || j != plfx_stream_wants(s)) {
        return PLFX_E_STATE;
    }
    t = s->state;
    keep_row(t, j, row);
    if (!in_order(s, t, j)) {
        return PLFX_E_RANGE;
    }
    t->fed_end++;
    open_more(t);
    if (s->started) {
        close_rows(s);
    }
    *ready = s->started ? s->ready - s->j : 0;
    return PLFX_OK;
}

static int32_t row_ok(const plfx_stream_cfg *c, const plfx_raw_row *row)
{
    uint16_t probe;

    if (!row || row->format != c->format || row->bits != c->bits ||
        row->width != c->lut->sensor_w ||
        plfx_raw_unpack(row, 0, 1, &probe) != PLFX_OK) {
        return 0;
    }
    return c->format != PLFX_RAW_U16 || ((uintptr_t)row->bytes & 1u) == 0;
}

/* In order, and nothing that a wanted row needs was passed over. */
static int32_t in_turn(const plfx_stream *s, int32_t y)
{
    const state *t = s->state;
    int32_t first = INT32_MAX;

    if (s->started) {
        return y == s->y;
    }
    if (t->from < t->to) {
        first = t->gather.lo[t->from % t->gather.open];
    }
    return y <= first;
}

plfx_status plfx_stream_push(plfx_stream *s, int32_t y, const plfx_raw_row *row,
                             int32_t *ready)
{
    state *t;
    int32_t j;

    if (!s || !s->state || !ready || !row_ok(&s->cfg, row) || y < 0 ||
        y >= s->cfg.lut->sensor_h) {
        return PLFX_E_ARG;
    }
    if (plfx_stream_wants(s) >= 0 || !in_turn(s, y) ||
        (s->started && s->ready > s->j)) {
        return PLFX_E_STATE;
    }
    t = s->state;
    if (t->open_end > t->whole_end) {
        plfx_gather_unpack(&t->gather, row);
    }
    for (j = t->whole_end; j < t->open_end; j++) {
        plfx_gather_taps(&t->gather, j, y, row);
    }
    s->y = y + 1;
    s->started = 1;
    close_rows(s);
    *ready = s->ready - s->j;
    return PLFX_OK;
}

plfx_status plfx_stream_push_band(plfx_stream *s, int32_t y, const plfx_raw *band,
                                  int32_t *used, int32_t *ready)
{
    int32_t i;

    if (!s || !s->state || !band || !used || !ready || band->h < 1) {
        return PLFX_E_ARG;
    }
    *used = 0;
    *ready = 0;
    for (i = 0; i < band->h && *ready == 0 && (i == 0 || plfx_stream_wants(s) < 0);
         i++) {
        plfx_raw_row row;
        plfx_status status = plfx_raw_row_at(band, i, &row);
        if (status == PLFX_OK) {
            status = plfx_stream_push(s, y + i, &row, ready);
        }
        if (status != PLFX_OK) {
            return status;
        }
        *used = i + 1;
    }
    return PLFX_OK;
}

static void match_row(const state *t, int32_t j, const plfx_map *row)
{
    plfx_rows src = source(t);

    if (j < t->y0 || j >= t->y1) {
        plfx_map_edge(row);
    } else if (t->ringed) {
        plfx_ringed_row(t->ringed, j, row);
    } else if (arms_of(t)) {
        plfx_arms_row(t->arms, j, row);
    } else {
        plfx_engine_row(t->engine, &src, j, row);
        if (t->store) {
            plfx_match_drop(&t->engine->match, &src, j);
        }
    }
}

static int32_t map_ok(const plfx_stream *s, const plfx_map *m)
{
    return m && m->slope_q16 && m->w == s->cfg.plan->nx && m->h == 1;
}

plfx_status plfx_stream_pop(plfx_stream *s, int32_t *j, const plfx_map *row,
                            int32_t *ready)
{
    state *t;

    if (!s || !s->state || !j || !ready || !map_ok(s, row)) {
        return PLFX_E_ARG;
    }
    if (s->ready <= s->j) {
        return PLFX_E_STATE;
    }
    t = s->state;
    *j = s->j;
    match_row(t, s->j, row);
    s->j++;
    if (s->ready <= s->j) {
        rest(t, &s->cfg);
        open_more(t);
        close_rows(s);
    }
    *ready = s->ready - s->j;
    return PLFX_OK;
}

plfx_status plfx_stream_finish(const plfx_stream *s)
{
    if (!s || !s->state) {
        return PLFX_E_ARG;
    }
    return s->j == s->cfg.j1 ? PLFX_OK : PLFX_E_STATE;
}

plfx_status plfx_stream_reset(plfx_stream *s)
{
    if (!s || !s->state) {
        return PLFX_E_ARG;
    }
    begin(s);
    return PLFX_OK;
}
