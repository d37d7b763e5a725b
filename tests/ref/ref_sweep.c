/* SPDX-License-Identifier: MIT */
#include "ref.h"
#include "rows.h"

#include <stdlib.h>

uint32_t ref_next(ref_rng *rng)
{
    rng->state = rng->state * 1664525u + 1013904223u;
    return (rng->state ^ (rng->state >> 16)) * 2654435769u;
}

int32_t ref_range(ref_rng *rng, int32_t lo, int32_t hi)
{
    return lo + (int32_t)(ref_next(rng) % (uint32_t)(hi - lo + 1));
}

static int32_t clamp(int32_t v, int32_t hi)
{
    return v < 0 ? 0 : v > hi ? hi : v;
}

static int32_t floor_div(int32_t n, int32_t d)
{
    int32_t q = n / d;

    return q * d > n ? q - 1 : q;
}

static uint32_t px(const plfx_views *v, int32_t k, int32_t x, int32_t y)
{
    return v
        ->px[((size_t)clamp(y, v->ny - 1) * (size_t)v->n + (size_t)k) * (size_t)v->nx +
             (size_t)clamp(x, v->nx - 1)];
}

static uint32_t tap(const plfx_plan *plan, const plfx_views *v, int32_t k, int32_t x_q4,
                    int32_t x, int32_t y, int32_t row)
{
    int32_t r = clamp(row, v->ny - 1);
    int32_t q4 = x_q4 + (plan->hex ? plan->odd_q4 * (y % 2 - r % 2) : 0);
    int32_t whole = floor_div(q4, 16);
    uint32_t f = (uint32_t)(q4 - 16 * whole);

    return px(v, k, x + whole, r) * (16 - f) + px(v, k, x + whole + 1, r) * f;
}

uint16_t ref_sample(const plfx_plan *plan, const plfx_views *views, int32_t k,
                    int32_t l, int32_t x, int32_t y)
{
    plfx_shift s = plfx_plan_shift(plan, k, l);
    int32_t x_q4 = 16 * s.kx + s.fx_q4;
    uint32_t fy = (uint32_t)s.fy_q4;

    return (uint16_t)((tap(plan, views, k, x_q4, x, y, y + s.ky) * (16 - fy) +
                       tap(plan, views, k, x_q4, x, y, y + s.ky + 1) * fy + 128) >>
                      8);
}

static int32_t view_of(const plfx_plan *plan, int32_t p)
{
    return p < plan->cfg.ref ? p : p + 1;
}

static uint16_t sad(const plfx_plan *plan, const plfx_views *v, int32_t p, int32_t l,
                    int32_t x, int32_t y)
{
    int32_t r = plan->cfg.window / 2;
    int32_t last = plan->cfg.method == PLFX_METHOD_SWEEP ? plan->cfg.n - 2 : p;
    uint32_t sum = 0;

    for (int32_t i = x - r; i <= x + r; i++) {
        uint32_t column = 0;
        for (int32_t j = y - r; j <= y + r; j++) {
            uint32_t c = 0;
            for (int32_t q = p; q <= last; q++) {
                c += (uint32_t)abs((int32_t)px(v, plan->cfg.ref, i, j) -
                                   ref_sample(plan, v, view_of(plan, q), l, i, j));
            }
            column += c >> plan->sad_shift1;
        }
        sum += column >> plan->sad_shift2;
    }
    return (uint16_t)sum;
}

typedef struct sums {
    int64_t a, b, aa, bb, ab, n;
} sums;

static sums moments(const plfx_plan *plan, const plfx_views *v, int32_t p, int32_t l,
                    int32_t x, int32_t y)
{
    int32_t r = plan->cfg.window / 2;
    sums m = {0, 0, 0, 0, 0, 0};

    for (int32_t j = y - r; j <= y + r; j++) {
        for (int32_t i = x - r; i <= x + r; i++) {
            int64_t a = px(v, plan->cfg.ref, i, j);
            int64_t b = ref_sample(plan, v, view_of(plan, p), l, i, j);
            m.a += a;
            m.b += b;
            m.aa += a * a;
            m.bb += b * b;
            m.ab += a * b;
            m.n++;
        }
    }
    return m;
}

static int64_t floor_shift(int64_t v, int32_t s)
{
    int64_t d = (int64_t)1 << s;

    return v >= 0 ? v / d : -((-v + d - 1) / d);
}

static uint16_t zncc(const plfx_plan *plan, const plfx_views *v, int32_t p, int32_t l,
                     int32_t x, int32_t y)
{
    sums m = moments(plan, v, p, l, x, y);
    plfx_rsqrt a = plfx_rsqrt_u64((uint64_t)(m.n * m.aa - m.a * m.a));
    plfx_rsqrt b = plfx_rsqrt_u64((uint64_t)(m.n * m.bb - m.b * m.b));
    int64_t cov = m.n * m.ab - m.a * m.b;
    int32_t down = a.exp + b.exp + 15;
    int64_t t = down >= 0 ? floor_shift(cov, down) : cov * ((int64_t)1 << -down);

    if (a.g == 0 || b.g == 0) {
        return 32767;
    }
    return (uint16_t)(32767 - floor_shift(t * b.g + 16384, 15));
}

void ref_costs(const plfx_plan *plan, const plfx_views *views, int32_t p, int32_t x,
               int32_t y, uint16_t *cost)
{
    for (int32_t l = 0; l < plan->cfg.labels; l++) {
        cost[l] = plan->cfg.cost == PLFX_COST_ZNCC ? zncc(plan, views, p, l, x, y)
                                                   : sad(plan, views, p, l, x, y);
    }
}

/* 1 when the displaced window of view k at label l leaves the map. */
static int leaves(const plfx_plan *plan, int32_t k, int32_t l, int32_t x, int32_t y)
{
    plfx_shift s = plfx_plan_shift(plan, k, l);
    int32_t r = plan->cfg.window / 2;
    int32_t odd = plan->hex && (s.ky != 0 || s.fy_q4 != 0) ? abs(plan->odd_q4) : 0;
    int32_t lo = floor_div(16 * s.kx + s.fx_q4 - odd, 16);
    int32_t hi = -floor_div(-(16 * s.kx + s.fx_q4 + odd), 16);

    return x - r + (lo < 0 ? lo : 0) < 0 || x + r + (hi > 0 ? hi : 0) > plan->nx - 1 ||
           y - r + (s.ky < 0 ? s.ky : 0) < 0 ||
           y + r + (s.ky + (s.fy_q4 > 0) > 0 ? s.ky + (s.fy_q4 > 0) : 0) > plan->ny - 1;
}

static int32_t fit(const plfx_plan *plan, const uint16_t *cost, int32_t l)
{
    uint32_t a = (uint32_t)cost[l + 1] - cost[l];
    uint32_t b = (uint32_t)cost[l - 1] - cost[l];
    uint32_t d;

    if (a >= 16384 || b >= 16384) {
        a /= 4;
        b /= 4;
    }
    d = plan->cfg.fit == PLFX_FIT_VEE ? (a > b ? a : b) : a + b;
    if (d == 0) {
        return 0;
    }
    return b > a ? (int32_t)((16 * (b - a) / d + 1) / 2)
                 : -(int32_t)((16 * (a - b) / d + 1) / 2);
}

typedef struct winner {
    int32_t label, slope_q16, second;
    uint16_t conf, weight;
    uint32_t flags;
} winner;

static uint32_t texture(const plfx_plan *plan, const plfx_views *v, int32_t x,
                        int32_t y)
{
    int32_t r = plan->cfg.window / 2;
    int u = 0;
    int w = 0;
    uint32_t sum = 0;

    for (int32_t k = 0; k < plan->cfg.n; k++) {
        u |= plan->du_q8[k] != 0;
        w |= plan->dv_q8[k] != 0;
    }
    for (int32_t j = y - r; j <= y + r; j++) {
        for (int32_t i = x - r; i <= x + r; i++) {
            int32_t a = (int32_t)px(v, plan->cfg.ref, i, j);
            sum += u ? (uint32_t)abs(a - (int32_t)px(v, plan->cfg.ref, i - 1, j)) : 0;
            sum += w ? (uint32_t)abs(a - (int32_t)px(v, plan->cfg.ref, i, j - 1)) : 0;
        }
    }
    return sum;
}

static uint16_t margin(uint32_t c1, uint32_t c2, uint32_t k)
{
    uint32_t num = (c2 - c1) / 4;
    uint32_t den = (c2 + k) / 4;
    uint32_t q = den ? 256 * num / den : 0;

    return (uint16_t)(256 * (q > 255 ? 255 : q));
}

static int32_t corr(uint16_t cost, uint32_t g)
{
    int64_t r = floor_shift((int64_t)(32767 - (int32_t)cost) * g + 4096, 13);

    return (int32_t)(r > 32767 ? 32767 : r < -32768 ? -32768 : r);
}

static void judge(const plfx_plan *plan, const plfx_views *v, int32_t p, int32_t x,
                  int32_t y, const uint16_t *cost, winner *w)
{
    uint32_t c2 = w->second < 0 ? cost[w->label] : (uint32_t)w->second;
    uint32_t n = plan->cfg.method == PLFX_METHOD_SWEEP ? plan->cfg.n - 1u : 1u;
    uint32_t k =
        (n * plan->cfg.window * plan->cfg.window * (1u << plan->cfg.bits) / 1024u) >>
        (plan->sad_shift1 + plan->sad_shift2);

    if (plan->cfg.cost == PLFX_COST_ZNCC) {
        sums m = moments(plan, v, p, 0, x, y);
        uint32_t g = plfx_rsqrt_u64((uint64_t)(m.n * m.aa - m.a * m.a)).g;
        int32_t r1 = corr(cost[w->label], g);
        int32_t r2 = corr((uint16_t)c2, g);
        w->conf =
            r1 > 0 ? margin((uint32_t)(32768 - r1), (uint32_t)(32768 - r2), 512) : 0;
        w->weight = (uint16_t)(r1 > 0 ? 2 * r1 : 0);
        w->flags |= g == 0 ? PLFX_FLAG_TEXTURE : 0;
    } else {
        w->conf = margin(cost[w->label], c2, k < 4 ? 4 : k);
        w->weight = w->conf;
    }
}

static winner decide(const plfx_plan *plan, const plfx_views *v, int32_t p, int32_t x,
                     int32_t y)
{
    uint16_t cost[PLFX_LABELS_MAX];
    int32_t labels = plan->cfg.labels;
    int32_t w2 = plan->cfg.window * plan->cfg.window;
    winner w = {0, 0, -1, 0, 0, 0};
    int32_t f = 0;

    ref_costs(plan, v, p, x, y, cost);
    for (int32_t l = 1; l < labels; l++) {
        w.label = cost[l] < cost[w.label] ? l : w.label;
    }
    for (int32_t l = 0; l < labels; l++) {
        if (abs(l - w.label) > 1 && (w.second < 0 || cost[l] < w.second)) {
            w.second = cost[l];
        }
    }
    judge(plan, v, p, x, y, cost, &w);
    if (w.second == cost[w.label] || w.conf < plan->cfg.unique_u16) {
        w.flags |= PLFX_FLAG_UNIQUE;
    }
    if ((int64_t)16 * texture(plan, v, x, y) < (int64_t)plan->cfg.texture * w2) {
        w.flags |= PLFX_FLAG_TEXTURE;
    }
    for (int32_t k = 0; k < plan->cfg.n; k++) {
        int used = plan->cfg.method == PLFX_METHOD_SWEEP || k == view_of(plan, p);
        w.flags |= used && leaves(plan, k, w.label, x, y) ? PLFX_FLAG_EDGE : 0;
    }
    if (w.label > 0 && w.label < labels - 1) {
        f = fit(plan, cost, w.label);
    }
    w.slope_q16 =
        w.flags ? PLFX_SLOPE_NONE : plfx_plan_slope_q16(plan, 16 * w.label + f);
    w.flags |= w.label == 0 || w.label == labels - 1 ? PLFX_FLAG_RANGE_END : 0;
    return w;
}

static int by_slope(const void *a, const void *b)
{
    int32_t x = *(const int32_t *)a;
    int32_t y = *(const int32_t *)b;

    return (x > y) - (x < y);
}

/* Median by sorting (slope, weight) records. */
static int32_t median(int32_t (*rec)[2], int32_t n)
{
    int64_t total = 0;
    int64_t sum = 0;

    qsort(rec, (size_t)n, sizeof rec[0], by_slope);
    for (int32_t i = 0; i < n; i++) {
        total += rec[i][1];
    }
    for (int32_t i = 0; i < n; i++) {
        sum += rec[i][1];
        if (2 * sum >= total && (i + 1 == n || rec[i + 1][0] != rec[i][0])) {
            if (2 * sum == total) {
                return (int32_t)floor_shift((int64_t)rec[i][0] + rec[i + 1][0] + 1, 1);
            }
            return rec[i][0];
        }
    }
    return PLFX_SLOPE_NONE;
}

static int32_t mean(int32_t (*rec)[2], int32_t n)
{
    int64_t s = 0;
    int64_t w = 0;

    for (int32_t i = 0; i < n; i++) {
        s += (int64_t)rec[i][0] * rec[i][1];
        w += rec[i][1];
    }
    if (w == 0) {
        return PLFX_SLOPE_NONE;
    }
    return (int32_t)(s >= 0 ? (s + w / 2) / w : -((-s + w / 2) / w));
}

static winner fused(const plfx_plan *plan, const plfx_views *v, int32_t x, int32_t y)
{
    winner pair[PLFX_VIEWS_MAX];
    int32_t rec[PLFX_VIEWS_MAX][2];
    int32_t pairs = plan->cfg.n - 1;
    int64_t two = 2 * ((int64_t)plan->cfg.slope_max_q16 - plan->cfg.slope_min_q16) /
                  (plan->cfg.labels - 1);
    int32_t ends = 1; /* every pair with a slope won at an end */
    int32_t counted = 0;
    int32_t n = 0;
    int32_t against = 0;
    uint32_t conf = 0;
    winner out = {0, PLFX_SLOPE_NONE, 0, 0, 0, 0};

    for (int32_t p = 0; p < pairs; p++) {
        pair[p] = decide(plan, v, p, x, y);
        out.flags |= pair[p].flags;
        ends &= pair[p].slope_q16 == PLFX_SLOPE_NONE ||
                (pair[p].flags & PLFX_FLAG_RANGE_END);
    }
    for (int32_t p = 0; p < pairs; p++) {
        int64_t u = plan->du_q8[view_of(plan, p)];
        int64_t t = plan->dv_q8[view_of(plan, p)];
        int64_t b = (u * u + t * t) / 1024;
        int32_t weight = (int32_t)(b < 1 ? 1 : b > 65535 ? 65535 : b);
        if (plan->cfg.fuse == PLFX_FUSE_CORRELATION) {
            weight = pair[p].weight;
        }
        if (pair[p].slope_q16 == PLFX_SLOPE_NONE ||
            (!ends && (pair[p].flags & PLFX_FLAG_RANGE_END))) {
            pair[p].slope_q16 = PLFX_SLOPE_NONE;
            continue;
        }
        counted++;
        conf += pair[p].conf;
        if (weight > 0) {
            rec[n][0] = pair[p].slope_q16;
            rec[n++][1] = weight;
        }
    }
    out.slope_q16 =
        plan->cfg.fuse == PLFX_FUSE_CORRELATION ? mean(rec, n) : median(rec, n);
    if (out.slope_q16 == PLFX_SLOPE_NONE) {
        return out;
    }
    for (int32_t p = 0; p < pairs; p++) {
        against += pair[p].slope_q16 != PLFX_SLOPE_NONE &&
                   llabs((int64_t)pair[p].slope_q16 - out.slope_q16) > two;
    }
    out.conf = (uint16_t)(conf / (uint32_t)pairs);
    out.flags = ends ? PLFX_FLAG_RANGE_END : 0;
    out.flags |= 3 * against > counted ? PLFX_FLAG_OCCLUDED : 0;
    return out;
}

void ref_sweep(const plfx_plan *plan, const plfx_views *views, const plfx_map *out)
{
    int32_t r = plan->cfg.window / 2;

    for (int32_t y = 0; y < plan->ny; y++) {
        for (int32_t x = 0; x < plan->nx; x++) {
            size_t at = (size_t)y * (size_t)out->stride + (size_t)x;
            winner w = {0, PLFX_SLOPE_NONE, 0, 0, 0, PLFX_FLAG_EDGE};
            if (x >= r && y >= r && x < plan->nx - r && y < plan->ny - r) {
                w = plan->cfg.method == PLFX_METHOD_SWEEP ? decide(plan, views, 0, x, y)
                                                          : fused(plan, views, x, y);
            }
            out->slope_q16[at] = w.slope_q16;
            out->conf_u16[at] = w.slope_q16 == PLFX_SLOPE_NONE ? 0 : w.conf;
            out->flags[at] = (uint8_t)w.flags;
        }
    }
}
