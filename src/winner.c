/* SPDX-License-Identifier: MIT
 * From window costs to slopes of a pair, with its tests; and from pairs to one
 * slope. */
#include "plenofix/fuse.h"
#include "sweep_state.h"
#include "fix.h"

uint32_t plfx_sad_floor(const plfx_plan *p)
{
    uint32_t others = p->cfg.method == PLFX_METHOD_SWEEP ? p->cfg.n - 1u : 1u;
    uint32_t w = p->cfg.window;
    uint32_t sum = others * w * w * (1u << p->cfg.bits) / 1024u;

    sum >>= p->sad_shift1 + p->sad_shift2;
    return sum > 4u ? sum : 4u;
}

typedef struct judged {
    uint16_t conf, weight;
} judged;

/* Costs 1 - r in Q15 with a floor of 1/64; weight = r.  Sums of differences are judged
 * in match_judge.c. */
static judged judge_zncc(const plfx_winner *w, uint32_t g)
{
    int32_t r1 = plfx_correlation_q15(w->best, g);
    int32_t r2 = plfx_correlation_q15(w->second, g);
    judged j = {0, 0};

    if (r1 > 0) {
        j.conf = (uint16_t)plfx_margin_u16((uint32_t)(32768 - r1),
                                           (uint32_t)(32768 - r2), 512u);
        j.weight = (uint16_t)(2 * r1);
    }
    return j;
}

static int32_t outside(const plfx_span *s, int32_t x, int32_t y)
{
    return x < s->x0 || x > s->x1 || y < s->y0 || y > s->y1;
}

/* Too little texture: mean |gradient| under the threshold, or no variance at all. */
static int32_t flat(const plfx_sweep_state *s, int32_t x)
{
    uint32_t w = s->plan->cfg.window;
    int32_t low = 16u * s->tex[x] < s->plan->cfg.texture * w * w;

    return low || s->a_rsqrt[x].g == 0;
}

/* Tests that turn a winner into NONE; 0 when it stands. */
static uint32_t refusals(const plfx_sweep_state *s, const plfx_winner *w,
                         const plfx_span *span, uint16_t conf, int32_t x, int32_t y)
{
    uint32_t f = 0;

    f |= outside(span, x, y) ? PLFX_FLAG_EDGE : 0u;
    f |= flat(s, x) ? PLFX_FLAG_TEXTURE : 0u;
    f |= w->tie || conf < s->plan->cfg.unique_u16 ? PLFX_FLAG_UNIQUE : 0u;
    return f;
}

/* The winner of lens x, as plfx_select() would find it. */
static plfx_winner raced(const plfx_sweep_state *s, int32_t x)
{
    const plfx_cfg *c = &s->plan->cfg;
    plfx_winner w = {s->race.label[x], 0, s->race.best[x], s->race.second[x], 0, 0};
    int32_t alone = c->labels == 3 && w.label == 1; /* neighbours only */

    w.second = alone ? w.best : w.second;
    w.tie = !alone && w.second == w.best;
    w.end = w.label == 0 || w.label == c->labels - 1;
    if (!w.end) {
        const uint16_t *k = s->cost + (size_t)w.label * (size_t)s->plan->nx + x;
        w.frac_q4 = plfx_vertex_q4((uint32_t)(k[s->plan->nx] - w.best),
                                   (uint32_t)(k[-s->plan->nx] - w.best), c->fit);
    }
    return w;
}

static void winner_at(const plfx_sweep_state *s, int32_t p, int32_t x, int32_t y)
{
    const plfx_plan *plan = s->plan;
    plfx_winner w = raced(s, x);
    const plfx_span *span = s->span + p * plan->cfg.labels + w.label;
    judged j = judge_zncc(&w, s->a_rsqrt[x].g);
    uint32_t refused = refusals(s, &w, span, j.conf, x, y);
    size_t at = (size_t)p * (size_t)plan->nx + (size_t)x;

    s->out.slope_q16[at] =
        refused ? PLFX_SLOPE_NONE : plfx_plan_slope_q16(plan, 16 * w.label + w.frac_q4);
    s->out.conf_u16[at] = j.conf;
    s->out.weight_u16[at] = j.weight;
    s->out.flags[at] = (uint8_t)(refused | (w.end ? PLFX_FLAG_RANGE_END : 0u));
}

void plfx_pair_winners(const plfx_sweep_state *s, int32_t p, int32_t y)
{
    int32_t r = s->plan->cfg.window / 2;
    int32_t x;

    plfx_race_row(s);
    for (x = r; x < s->plan->nx - r; x++) {
        winner_at(s, p, x, y);
    }
}

uint16_t plfx_baseline_weight(const plfx_plan *plan, int32_t view)
{
    int64_t u = plan->du_q8[view];
    int64_t v = plan->dv_q8[view];
    int64_t b = plfx_asr_i64(u * u + v * v, 10);

    return (uint16_t)plfx_clamp_i64(b, 1, 65535);
}

/* Pairs whose slope lies more than two labels from the fused one. */
static int32_t dissent(const plfx_plan *plan, const int32_t *slope, int32_t n,
                       int32_t fused)
{
    int64_t limit = 2 * ((int64_t)plan->cfg.slope_max_q16 - plan->cfg.slope_min_q16) /
                    (plan->cfg.labels - 1);
    int32_t count = 0;
    int32_t k;

    for (k = 0; k < n; k++) {
        int64_t d = (int64_t)slope[k] - fused;
        count += slope[k] != PLFX_SLOPE_NONE && (d > limit || d < -limit);
    }
    return count;
}

typedef struct tally { /* what the pairs of one lens say together */
    int32_t measured;
    uint32_t conf, flags;
} tally;

/* A winner at an end of the range is no minimum and counts only when `ends` is set. */
static int32_t counts(const plfx_sweep_state *s, size_t at, int32_t ends)
{
    return s->out.slope_q16[at] != PLFX_SLOPE_NONE &&
           (ends || !(s->out.flags[at] & PLFX_FLAG_RANGE_END));
}

/* Slopes and weights of lens x into s->slopes, s->weights. */
static tally gather(const plfx_sweep_state *s, int32_t x, int32_t ends)
{
    int32_t weighted = s->plan->cfg.fuse == PLFX_FUSE_CORRELATION;
    tally t = {0, 0, 0};
    int32_t p;

    for (p = 0; p < s->pairs; p++) {
        size_t at = (size_t)p * (size_t)s->plan->nx + (size_t)x;
        int32_t counted = counts(s, at, ends);
        s->slopes[p] = counted ? s->out.slope_q16[at] : PLFX_SLOPE_NONE;
        s->weights[p] = weighted
                            ? s->out.weight_u16[at]
                            : plfx_baseline_weight(s->plan, plfx_pair_view(s->plan, p));
        t.flags |= s->out.flags[at];
        if (counted) {
            t.measured++;
            t.conf += s->out.conf_u16[at];
        }
    }
    return t;
}

/* The median of one pair is its slope. */
static plfx_fused only_pair(const plfx_sweep_state *s, int32_t x)
{
    plfx_fused f = {s->out.slope_q16[x], s->out.conf_u16[x], s->out.flags[x]};

    if (f.slope_q16 == PLFX_SLOPE_NONE) {
        f.conf_u16 = 0;
    } else {
        f.flags &= PLFX_FLAG_RANGE_END;
    }
    return f;
}

plfx_fused plfx_fuse_pairs(const plfx_sweep_state *s, int32_t x)
{
    plfx_fused f = {PLFX_SLOPE_NONE, 0, 0};
    tally t;

    if (s->pairs == 1 && s->plan->cfg.fuse == PLFX_FUSE_MEDIAN) {
        return only_pair(s, x);
    }
    t = gather(s, x, 0);
    if (t.measured == 0) {
        t = gather(s, x, 1);
        f.flags = PLFX_FLAG_RANGE_END;
    }
    f.slope_q16 = s->plan->cfg.fuse == PLFX_FUSE_CORRELATION
                      ? plfx_fuse_mean(s->slopes, s->weights, s->pairs)
                      : plfx_fuse_median(s->slopes, s->weights, s->pairs);
    if (f.slope_q16 == PLFX_SLOPE_NONE) {
        f.flags = (uint8_t)t.flags;
        return f;
    }
    f.conf_u16 = (uint16_t)(t.conf / (uint32_t)s->pairs);
    if (3 * dissent(s->plan, s->slopes, s->pairs, f.slope_q16) > t.measured) {
        f.flags |= PLFX_FLAG_OCCLUDED;
    }
    return f;
}
