/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "arms_stream.h"
#include "fix.h"
#include "store.h"
#include "sure.h"

#define CHUNK PLFX_WINNER_CHUNK

int32_t plfx_arms_streams(const plfx_plan *plan, const plfx_frame_cfg *cfg)
{
    plfx_frame_state s;

    return cfg && cfg->paths == 0 && cfg->taps == 0 && cfg->median2 == 0 &&
           plfx_frame_derive(&s, plan, cfg, NULL) == PLFX_OK && !s.smooth;
}

static int32_t median_radius(const plfx_arms_stream *a)
{
    return a->frame.cfg.median1 / 2;
}

static int32_t radius(const plfx_arms_stream *a)
{
    return a->frame.plan->cfg.window / 2;
}

/* Rows of the reference that the texture test and the median look back at. */
static int32_t behind(const plfx_arms_stream *a)
{
    return plfx_max_i32(radius(a) + 1, median_radius(a));
}

/* Rows that any label of any view reads around its target. */
static void survey(plfx_arms_stream *a)
{
    const plfx_plan *plan = a->frame.plan;
    int32_t k;
    int32_t l;

    a->grad = a->frame.cfg.gweight_q4 > 0;
    a->before = 0;
    a->after = 0;
    for (k = 0; k < plan->cfg.n; k++) {
        for (l = 0; l < plan->cfg.labels; l++) {
            plfx_shift s = plfx_plan_shift(plan, k, l);
            a->before = plfx_max_i32(a->before, -s.ky);
            a->after = plfx_max_i32(a->after, s.ky + (s.fy_q4 > 0));
        }
    }
    a->before += a->grad;
    a->after += a->grad;
}

int32_t plfx_arms_below(const plfx_arms_stream *a)
{
    return median_radius(a) + 1 + radius(a) + a->after;
}

static size_t store_bytes(const plfx_arms_stream *a)
{
    return plfx_store_bytes(a->frame.nx, a->frame.plan->cfg.bits);
}

/* Rows of views at rest: a window with the row that leaves it, and what the labels
 * reach; of the reference also what is looked back at. */
static void carve_views(plfx_arms_stream *a, plfx_arena *arena)
{
    plfx_frame_state *s = &a->frame;
    size_t row = (size_t)s->stride;

    a->depth = s->plan->cfg.window + 1 + a->before + a->after;
    s->span = a->before + a->after + 1;
    s->ring = plfx_max_i32(a->depth, plfx_arms_below(a) + behind(a) + 1);
    s->kept = median_radius(a) + 1;
    s->arm_of = plfx_take(arena, (size_t)s->n, 1);
    a->slot = plfx_take(arena, (size_t)s->n, 1);
    s->slot = a->slot;
    s->bx_q16 = plfx_take(arena, (size_t)s->n, sizeof *s->bx_q16);
    s->by_q16 = plfx_take(arena, (size_t)s->n, sizeof *s->by_q16);
    s->p2_of = NULL;
    a->shift_q4 =
        plfx_take(arena, 2u * (size_t)s->n * (size_t)s->labels, sizeof *a->shift_q4);
    s->sample =
        plfx_take(arena, (size_t)s->ring * row + PLFX_WINNER_CHUNK, sizeof *s->sample);
    a->store = plfx_take(arena, (size_t)(s->n - 1) * (size_t)a->depth, store_bytes(a));
}

static void carve_winners(plfx_arms_stream *a, plfx_arena *arena)
{
    plfx_frame_state *s = &a->frame;
    size_t nx = (size_t)s->nx;
    size_t kept = (size_t)s->kept * nx;
    unsigned char *rows;

    s->e_a = plfx_take(arena, kept, sizeof *s->e_a);
    s->conf = plfx_take(arena, kept, sizeof *s->conf);
    s->flags = plfx_take(arena, kept, sizeof *s->flags);
    a->axis_label = s->cfg.axes ? plfx_take(arena, 4 * nx, 1) : NULL;
    a->e = plfx_take(arena, nx, sizeof *a->e);
    if (s->cfg.median1) {
        rows =
            plfx_take(arena, plfx_median_carve(s, &a->median, s->cfg.median1, NULL), 1);
        (void)plfx_median_carve(s, &a->median, s->cfg.median1, rows);
    }
}

static int32_t widest_arm(const plfx_frame_state *s)
{
    int32_t most = 0;
    int32_t k;

    for (k = 0; k < s->cfg.arms; k++) {
        most = plfx_max_i32(most, s->arm_n[k]);
    }
    return most;
}

static size_t carve_costs(plfx_arms_stream *a, void *base)
{
    plfx_arena arena = {base, 0};
    plfx_frame_state *s = &a->frame;
    size_t nx = (size_t)s->nx;
    size_t lines = a->grad ? 3 : 1;
    size_t wide = nx + (size_t)s->plan->cfg.window - 1;

    s->lines = plfx_take(&arena, (size_t)(widest_arm(s) * s->span) * (size_t)s->stride,
                         sizeof *s->lines);
    a->warp = plfx_take(&arena, 2 * nx, sizeof *a->warp);
    a->diff = plfx_take(&arena, lines * (nx + 2), sizeof *a->diff);
    a->arm = plfx_take(&arena, nx, sizeof *a->arm);
    a->wide = plfx_take(&arena, wide, sizeof *a->wide);
    a->least = plfx_take(&arena, PLFX_ARMS_LEVELS * nx, sizeof *a->least);
    a->axis = plfx_take(&arena, 2 * nx, sizeof *a->axis);
    a->best = plfx_take(&arena, 2 * nx, sizeof *a->best);
    return arena.used;
}

static size_t carve_sums(plfx_arms_stream *a, void *base)
{
    plfx_arena arena = {base, 0};

    a->sum = plfx_take(&arena, (size_t)a->frame.labels * CHUNK, sizeof *a->sum);
    a->chunk = plfx_take(&arena, plfx_winner_scratch(), 1);
    return arena.used;
}

/* What lives for one row's costs, one row's winners or one row's median. */
static void carve_shared(plfx_arms_stream *a, plfx_arena *arena)
{
    size_t most = carve_costs(a, NULL);
    size_t now = carve_sums(a, NULL);
    size_t median = plfx_median_work(a->frame.cfg.median1);

    most = now > most ? now : most;
    a->work = plfx_take(arena, median > most ? median : most, 1);
    (void)carve_costs(a, a->work);
    (void)carve_sums(a, a->work);
}

/* Columns and rows of the shift of view k at a label, sixteenths. */
static int32_t *shift_at(const plfx_arms_stream *a, int32_t k, int32_t label)
{
    return a->shift_q4 + 2u * (size_t)(k * a->frame.labels + label);
}

static void keep_shifts(const plfx_arms_stream *a)
{
    int32_t k;
    int32_t l;

    for (k = 0; k < a->frame.n; k++) {
        for (l = 0; l < a->frame.labels; l++) {
            plfx_shift s = plfx_plan_shift(a->frame.plan, k, l);
            shift_at(a, k, l)[0] = 16 * s.kx + s.fx_q4;
            shift_at(a, k, l)[1] = 16 * s.ky + s.fy_q4;
        }
    }
}

static plfx_shift shift_of(const plfx_arms_stream *a, int32_t k, int32_t label)
{
    const int32_t *q4 = shift_at(a, k, label);
    plfx_shift s;

    s.kx = plfx_asr_i32(q4[0], 4);
    s.fx_q4 = q4[0] & 15;
    s.ky = plfx_asr_i32(q4[1], 4);
    s.fy_q4 = q4[1] & 15;
    return s;
}

static void number_views(const plfx_arms_stream *a)
{
    const plfx_frame_state *s = &a->frame;
    int32_t k;
    int32_t i;

    for (k = 0; k < s->n; k++) {
        uint8_t before = 0;
        for (i = 0; i < k; i++) {
            before = (uint8_t)(before + (s->arm_of[i] == s->arm_of[k]));
        }
        a->slot[k] = before;
    }
}

size_t plfx_arms_carve(plfx_arms_stream *a, const plfx_plan *plan,
                       const plfx_frame_cfg *cfg, void *base)
{
    plfx_arena arena = {base, 0};
    size_t nx = (size_t)plan->nx;
    size_t labels = plan->cfg.labels;

    plfx_sure(plfx_frame_derive(&a->frame, plan, cfg, NULL));
    survey(a);
    carve_views(a, &arena);
    carve_winners(a, &arena);
    carve_shared(a, &arena);
    a->cost = plfx_take(&arena, labels * 3 * (nx + 2), sizeof *a->cost);
    a->col = plfx_take(&arena, (size_t)a->frame.arms * labels * nx, sizeof *a->col);
    if (base) {
        plfx_frame_tables(&a->frame, NULL);
        number_views(a);
        keep_shifts(a);
        if (a->frame.cfg.median1) {
            plfx_median_of_labels(&a->frame, &a->median);
        }
    }
    return arena.used;
}

static plfx_arms_range around(plfx_arms_range r, int32_t more, int32_t ny)
{
    plfx_arms_range out = {plfx_max_i32(r.from - more, 0),
                           plfx_min_i32(r.to + more, ny)};

    return out;
}

plfx_arms_range plfx_arms_start(plfx_arms_stream *a, int32_t j0, int32_t j1)
{
    plfx_frame_state *s = &a->frame;
    plfx_arms_range map = {j0, j1};
    plfx_arms_range rows;
    plfx_arms_range seen = around(map, behind(a), s->ny);

    a->winner_rows = around(map, median_radius(a), s->ny);
    a->cost_rows = around(a->winner_rows, 1, s->ny);
    a->next = a->cost_rows.from;
    a->winner = a->winner_rows.from;
    memset(a->col, 0,
           (size_t)s->arms * (size_t)s->labels * (size_t)s->nx * sizeof *a->col);
    memset(s->sample + (size_t)s->ring * (size_t)s->stride, 0,
           PLFX_WINNER_CHUNK * sizeof *s->sample);
    rows = around(a->cost_rows, radius(a), s->ny);
    rows.from = plfx_max_i32(rows.from - a->before, 0);
    rows.to = plfx_min_i32(rows.to + a->after, s->ny);
    rows.from = plfx_min_i32(rows.from, seen.from);
    return rows;
}

/* A row becomes one of 12 bits, in place, ends repeated. */
static void widen(const plfx_frame_state *s, uint16_t *row)
{
    int32_t up = 12 - s->plan->cfg.bits;
    int32_t x;

    for (x = 0; x < s->nx; x++) {
        row[x] = (uint16_t)(row[x] << up);
    }
    for (x = -s->pad; x < 0; x++) {
        row[x] = row[0];
    }
    for (x = s->nx; x < s->stride - s->pad; x++) {
        row[x] = row[s->nx - 1];
    }
}

/* Row y of view k at rest; the reference is not. */
static uint8_t *stored(const plfx_arms_stream *a, int32_t k, int32_t y)
{
    int32_t view = k > a->frame.plan->cfg.ref ? k - 1 : k;

    return a->store + (size_t)(view * a->depth + y % a->depth) * store_bytes(a);
}

void plfx_arms_put(plfx_arms_stream *a, int32_t j, const uint16_t *rows)
{
    const plfx_frame_state *s = &a->frame;
    const plfx_cfg *c = &s->plan->cfg;
    int32_t k;

    for (k = 0; k < s->n; k++) {
        const uint16_t *row = rows + (size_t)k * (size_t)s->nx;
        if (k == c->ref) {
            uint16_t *to =
                s->sample + (size_t)(j % s->ring) * (size_t)s->stride + s->pad;
            memcpy(to, row, (size_t)s->nx * sizeof *row);
            widen(s, to);
        } else {
            plfx_store_put(stored(a, k, j), s->nx, c->bits, row);
        }
    }
}

/* Rows first .. last of view k are laid out. */
static void lay_view(const plfx_arms_stream *a, int32_t k, int32_t first, int32_t last)
{
    const plfx_frame_state *s = &a->frame;
    int32_t r;

    for (r = first; r <= last; r++) {
        size_t at = (size_t)(s->slot[k] * s->span + r % s->span);
        uint16_t *line = s->lines + at * (size_t)s->stride + s->pad;
        plfx_store_get(stored(a, k, r), s->nx, s->plan->cfg.bits, line);
        widen(s, line);
    }
}

/* Rows of an arm's views that cost row y reads: of a view that no label moves across
 * rows it is row y alone. */
static void lay(const plfx_arms_stream *a, int32_t arm, int32_t y)
{
    const plfx_frame_state *s = &a->frame;
    int32_t k;

    for (k = 0; k < s->n; k++) {
        int32_t level = s->plan->dv_q8[k] == 0;
        int32_t before = level ? a->grad : a->before;
        int32_t after = level ? a->grad : a->after;
        if (s->arm_of[k] == arm) {
            lay_view(a, k, plfx_max_i32(y - before, 0),
                     plfx_min_i32(y + after, s->ny - 1));
        }
    }
}

static int16_t *diff_line(const plfx_arms_stream *a, int32_t i)
{
    return a->diff + (size_t)i * ((size_t)a->frame.nx + 2);
}

/* Cost of view k at row y on top of the arm. */
static void add_view(const plfx_arms_stream *a, int32_t k, const plfx_shift *shift,
                     int32_t y)
{
    const plfx_frame_state *s = &a->frame;
    int32_t last = s->ny - 1;
    int32_t i;

    if (!a->grad) {
        plfx_arms_flat(s, k, shift, y, a->warp, a->arm);
        return;
    }
    for (i = 0; i < 3; i++) {
        plfx_arms_diff(s, k, shift, plfx_clamp_i32(y + i - 1, 0, last), 1, a->warp,
                       diff_line(a, i));
    }
    plfx_arms_cost(diff_line(a, 0), diff_line(a, 1), diff_line(a, 2), &s->cfg, s->nx,
                   a->arm);
}

/* Row y of arm `arm` at a label enters its column (sign 1) or leaves it. */
static void column(const plfx_arms_stream *a, int32_t arm, int32_t label, int32_t y,
                   int32_t sign, int16_t *col)
{
    const plfx_frame_state *s = &a->frame;
    int32_t k;

    memset(a->arm, 0, (size_t)s->nx * sizeof *a->arm);
    for (k = 0; k < s->n; k++) {
        if (s->arm_of[k] == arm) {
            plfx_shift shift = shift_of(a, k, label);
            add_view(a, k, &shift, y);
        }
    }
    plfx_arms_column(a->arm, s->arm_mul[arm], s->arm_shift[arm], s->nx, sign, col);
}

/* Row y of an arm into or out of the columns of all labels. */
static void columns(const plfx_arms_stream *a, int32_t arm, int32_t y, int32_t sign,
                    int16_t *col)
{
    int32_t l;

    lay(a, arm, y);
    for (l = 0; l < a->frame.labels; l++) {
        column(a, arm, l, y, sign, col + (size_t)l * (size_t)a->frame.nx);
    }
}

/* Columns of an arm around cost row y: all rows of the first one, then the row that
 * enters and the row that leaves.  Rows beyond the map repeat its ends. */
static void move_columns(const plfx_arms_stream *a, int32_t arm, int32_t y,
                         int16_t *col)
{
    int32_t last = a->frame.ny - 1;
    int32_t r = radius(a);
    int32_t i;

    if (y > a->cost_rows.from) {
        columns(a, arm, plfx_min_i32(y + r, last), 1, col);
        columns(a, arm, plfx_max_i32(y - 1 - r, 0), -1, col);
        return;
    }
    for (i = -r; i <= r; i++) {
        columns(a, arm, plfx_clamp_i32(y + i, 0, last), 1, col);
    }
}

/* All columns around cost row y. */
static void move_arms(const plfx_arms_stream *a, int32_t y)
{
    const plfx_frame_state *s = &a->frame;
    int16_t *col = a->col;
    int32_t arm;

    for (arm = 0; arm < s->cfg.arms; arm++) {
        if (s->arm_n[arm] > 0) {
            move_columns(a, arm, y, col);
            col += (size_t)s->labels * (size_t)s->nx;
        }
    }
}

/* Box of an arm's column into the arm, and its place among the least. */
static void box(const plfx_arms_stream *a, int32_t arm, const int16_t *col)
{
    const plfx_frame_state *s = &a->frame;
    int32_t axis = plfx_arms_axis(s, arm);
    int32_t r = radius(a);
    int32_t i;

    memcpy(a->wide + r, col, (size_t)s->nx * sizeof *col);
    for (i = 0; i < r; i++) {
        a->wide[i] = col[0];
        a->wide[r + s->nx + i] = col[s->nx - 1];
    }
    plfx_arms_box(a->wide, 2 * r + 1, s->nx, a->arm);
    plfx_arms_keep(a->arm, s->nx, a->least);
    if (s->cfg.axes && axis >= 0) {
        plfx_arms_lesser(a->arm, s->nx, a->axis + axis * s->nx);
    }
}

static uint8_t *cost_line(const plfx_arms_stream *a, int32_t label, int32_t y)
{
    return a->cost + ((size_t)label * 3 + (size_t)(y % 3)) * ((size_t)a->frame.nx + 2);
}

static uint8_t *axis_line(const plfx_arms_stream *a, int32_t axis, int32_t y)
{
    return a->axis_label + ((size_t)(y & 1) * 2 + (size_t)axis) * (size_t)a->frame.nx;
}

static void follow_axes(const plfx_arms_stream *a, int32_t label, int32_t y)
{
    int32_t nx = a->frame.nx;
    int32_t k;

    for (k = 0; k < 2; k++) {
        if (label == 0) {
            memcpy(a->best + k * nx, a->axis + k * nx, (size_t)nx * sizeof *a->best);
            memset(axis_line(a, k, y), 0, (size_t)nx);
        } else {
            plfx_arms_follow(a->axis + k * nx, label, nx, a->best + k * nx,
                             axis_line(a, k, y));
        }
    }
}

/* Cost of row y at a label, ends repeated. */
static void cost_row(const plfx_arms_stream *a, int32_t label, int32_t y)
{
    const plfx_frame_state *s = &a->frame;
    uint8_t *out = cost_line(a, label, y);
    int16_t *col = a->col + (size_t)label * (size_t)s->nx;
    int32_t arm;
    int32_t i;

    for (i = 0; i < PLFX_ARMS_LEVELS * s->nx; i++) {
        a->least[i] = INT16_MAX;
    }
    for (i = 0; i < 2 * s->nx; i++) {
        a->axis[i] = INT16_MAX;
    }
    for (arm = 0; arm < s->cfg.arms; arm++) {
        if (s->arm_n[arm] > 0) {
            box(a, arm, col);
            col += (size_t)s->labels * (size_t)s->nx;
        }
    }
    if (s->cfg.axes) {
        follow_axes(a, label, y);
    }
    plfx_arms_quantise(a->least, s->nx, s->keep, s->vol_mul, out + 1);
    out[0] = out[1];
    out[s->nx + 1] = out[s->nx];
}

/* Costs of n lenses from x on at winner row y into the sums. */
static void lend(const plfx_arms_stream *a, int32_t y, int32_t x, int32_t n)
{
    const plfx_frame_state *s = &a->frame;
    uint8_t least[CHUNK];
    int32_t l;
    int32_t i;

    for (l = 0; l < s->labels; l++) {
        const uint8_t *mid = cost_line(a, l, y) + x;
        int16_t *sum = a->sum + (size_t)l * CHUNK;
        if (s->cfg.shrink) {
            const uint8_t *up = cost_line(a, l, plfx_max_i32(y - 1, 0)) + x;
            const uint8_t *down = cost_line(a, l, plfx_min_i32(y + 1, s->ny - 1)) + x;
            plfx_arms_least(up, mid, down, n, least);
        } else {
            memcpy(least, mid + 1, (size_t)n);
        }
        for (i = 0; i < n; i++) {
            sum[i] = least[i];
        }
    }
}

static void winner_row(const plfx_arms_stream *a, int32_t y)
{
    const plfx_frame_state *s = &a->frame;
    size_t at = plfx_frame_at(s, y);
    int32_t x;

    memset(a->sum, 0, (size_t)s->labels * CHUNK * sizeof *a->sum);
    for (x = 0; x < s->nx; x += CHUNK) {
        int32_t n = plfx_min_i32(CHUNK, s->nx - x);
        lend(a, y, x, n);
        plfx_winner_chunk(s, at + (size_t)x, a->sum, CHUNK, n, a->chunk);
    }
    if (s->cfg.axes) {
        plfx_frame_axes(s, axis_line(a, 0, y), axis_line(a, 1, y), s->flags + at);
    }
    if (s->cfg.median1) {
        plfx_median_load(s, &a->median, s->e_a + at, y);
    }
}

/* Winners that the cost rows before `end` complete, up to row y. */
static void winners(plfx_arms_stream *a, int32_t end, int32_t y)
{
    int32_t whole = end == a->frame.ny ? end - 1 : end - 2;
    int32_t last = plfx_min_i32(plfx_min_i32(y, whole), a->winner_rows.to - 1);

    for (; a->winner <= last; a->winner++) {
        winner_row(a, a->winner);
    }
}

/* Costs up to row y and what they complete, as long as map row `map` is the next: no
 * winners beyond its median. */
static void advance(plfx_arms_stream *a, int32_t y, int32_t map)
{
    int32_t last = plfx_min_i32(y, a->cost_rows.to - 1);
    int32_t l;

    winners(a, a->next, map + median_radius(a));
    for (; a->next <= last; a->next++) {
        move_arms(a, a->next);
        for (l = 0; l < a->frame.labels; l++) {
            cost_row(a, l, a->next);
        }
        winners(a, a->next + 1, map + median_radius(a));
    }
}

void plfx_arms_enter(plfx_arms_stream *a, int32_t last, int32_t y)
{
    int32_t whole = last >= a->frame.ny - 1 ? last : last - radius(a) - a->after;

    advance(a, plfx_min_i32(whole, y + median_radius(a) + 1), y);
}

void plfx_arms_row(plfx_arms_stream *a, int32_t y, const plfx_map *row)
{
    const plfx_frame_state *s = &a->frame;
    size_t at = plfx_frame_at(s, y);
    plfx_frame_out out;
    int32_t x;

    advance(a, y + median_radius(a) + 1, y);
    out.raw = plfx_frame_line(s, s->plan->cfg.ref, y);
    out.top = ((1u << s->plan->cfg.bits) - 1u) << (12 - s->plan->cfg.bits);
    out.e = s->e_a + at;
    out.conf = s->conf + at;
    out.flags = s->flags + at;
    if (s->cfg.median1) {
        plfx_median_row(s, &a->median, y, a->e, a->work);
        out.e = a->e;
    }
    if (row->flags) {
        plfx_frame_flags(s, &out, y);
        memcpy(row->flags, out.flags, (size_t)s->nx);
    }
    for (x = 0; x < s->nx; x++) {
        row->slope_q16[x] = plfx_frame_slope_of(s, out.e[x]);
    }
    for (x = 0; row->conf_u16 && x < s->nx; x++) {
        row->conf_u16[x] = out.conf[x];
    }
    for (x = 0; row->sigma_u20 && x < s->nx; x++) {
        row->sigma_u20[x] = PLFX_SIGMA_NONE;
    }
}
