/* SPDX-License-Identifier: MIT */
#include "motion/pick.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/arrange.h"
#include "common/err.h"
#include "common/memory.h"
#include "motion/plan.h"
#include "plenofix/viewcheck.h"

#define WINDOW     5
#define MEASURED   0.75  /* least share of a region's lenses that have a slope */
#define DISAGREE   0.10  /* lenses rms: what views of one surface differ by at most */
#define RIM_SPREAD 0.25  /* lenses at the rim between the slopes of one surface */
#define FINE       20000 /* lenses: so many take every place */
#define ROUNDS     3     /* in which regions settle */
#define TAPS       (130.0 / 144.0) /* noise of the derivative (1, -8, 0, 8, -1)/12 */

typedef struct scan {
    const plft_field *field;
    const plft_pick_wish *wish;
    plfx_views views; /* and four views at the rim: +u, -u, +v, -v */
    plfx_map map;
    double noise;  /* variance of a view sample */
    double radius; /* of the rim views, px */
    double limit;  /* of the spread of slopes */
} scan;

/* Sample of the centre view; view k of the row lies k rows of lenses behind. */
static const uint16_t *at_lens(const scan *s, int x, int y)
{
    return s->views.px + (size_t)y * (size_t)s->views.n * (size_t)s->views.nx +
           (size_t)x;
}

static ptrdiff_t below(const scan *s)
{
    return (ptrdiff_t)s->views.n * s->views.nx;
}

/* ---- texture ---- */

static double derivative(const uint16_t *p, ptrdiff_t step)
{
    return (8.0 * ((double)p[step] - p[-step]) - ((double)p[2 * step] - p[-2 * step])) /
           12.0;
}

/* Gradients over their mean brightness; PLFX_ROI_MARGIN keeps the taps inside. */
static void texture(const scan *s, plft_pick *c)
{
    double xx = 0, xy = 0, yy = 0, mean = 0, root;
    int n = s->wish->w * s->wish->h;
    int x, y;

    for (y = c->j - s->wish->h / 2; y <= c->j + s->wish->h / 2; y++) {
        for (x = c->i - s->wish->w / 2; x <= c->i + s->wish->w / 2; x++) {
            const uint16_t *p = at_lens(s, x, y);
            double gx = derivative(p, 1);
            double gy = derivative(p, below(s));
            xx += gx * gx - TAPS * s->noise;
            yy += gy * gy - TAPS * s->noise;
            xy += gx * gy;
            mean += *p;
        }
    }
    mean = fmax(mean / n, 1.0);
    c->mean = mean;
    root = sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
    c->texture = sqrt(fmax(0.5 * (xx + yy) / n, 0.0)) / mean;
    c->weak = sqrt(fmax((0.5 * (xx + yy) - root) / n, 0.0)) / mean;
}

/* ---- depth ---- */

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return x < y ? -1 : x > y;
}

/* Cubic through four samples about p[0] and p[step]; t 0 .. 1 between the two. */
static double between(const uint16_t *p, ptrdiff_t step, double t)
{
    double a = p[-step], b = p[0], c = p[step], d = p[2 * step];

    return b +
           0.5 * t *
               (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/* Variance of the centre view, displaced along x or y by the region's slope, that rim
 * view k, whose brightness is its own, leaves unexplained.  The margin holds
 * displacements of a lens and a half. */
static double unlike(const scan *s, const plft_pick *c, int k)
{
    double shift = (k % 2 ? 1.0 : -1.0) * c->slope * s->radius;
    double clamped = fmin(fmax(shift, -1.49), 1.49);
    int whole = (int)floor(clamped);
    ptrdiff_t step = k < 2 ? 1 : below(s);
    double a = 0, b = 0, aa = 0, ab = 0, bb = 0, m = s->wish->w * s->wish->h;
    int x, y;

    for (y = c->j - s->wish->h / 2; y <= c->j + s->wish->h / 2; y++) {
        for (x = c->i - s->wish->w / 2; x <= c->i + s->wish->w / 2; x++) {
            const uint16_t *p = at_lens(s, x, y);
            double u = between(p + whole * step, step, clamped - whole);
            double v = p[(k + 1) * s->views.nx];
            a += u / m;
            b += v / m;
            aa += u * u / m;
            ab += u * v / m;
            bb += v * v / m;
        }
    }
    aa -= a * a;
    ab -= a * b;
    bb -= b * b;
    return bb > 0.0 ? aa - ab * ab / bb : aa;
}

/* Do the rim views show what the centre view shows, one slope allowed for? */
static int views_agree(const scan *s, const plft_pick *c)
{
    double limit = DISAGREE * c->texture * c->mean;
    double sum = 0.0;
    int k;

    for (k = 0; k < 4; k++) {
        sum += 0.25 * unlike(s, c, k);
    }
    return sum - 2.0 * s->noise <= limit * limit;
}

/* Slopes of another surface in the region and its margin, where something at another
 * depth biases w. */
static int others(const scan *s, const plft_pick *c)
{
    int hw = s->wish->w / 2 + PLFX_ROI_MARGIN;
    int hh = s->wish->h / 2 + PLFX_ROI_MARGIN;
    int n = 0, x, y;

    for (y = c->j - hh; y <= c->j + hh; y++) {
        for (x = c->i - hw; x <= c->i + hw; x++) {
            int32_t q = s->map.slope_q16[(size_t)y * (size_t)s->map.stride + (size_t)x];
            n += q != PLFX_SLOPE_NONE && fabs(q / 65536.0 - c->slope) > 0.5 * s->limit;
        }
    }
    return n;
}

/* One surface: enough slopes, the 10th and 90th percentile near each other, and few
 * others around. */
static int one_surface(const scan *s, plft_pick *c)
{
    double v[(2 * PLFX_ROI_HALF_MAX + 1) * (2 * PLFX_ROI_HALF_MAX + 1)];
    int n = 0, x, y;

    for (y = c->j - s->wish->h / 2; y <= c->j + s->wish->h / 2; y++) {
        for (x = c->i - s->wish->w / 2; x <= c->i + s->wish->w / 2; x++) {
            int32_t q = s->map.slope_q16[(size_t)y * (size_t)s->map.stride + (size_t)x];
            if (q != PLFX_SLOPE_NONE) {
                v[n++] = q / 65536.0;
            }
        }
    }
    if (n < MEASURED * s->wish->w * s->wish->h) {
        return 0;
    }
    qsort(v, (size_t)n, sizeof *v, by_value);
    c->slope = v[n / 2];
    return v[n - 1 - n / 10] - v[n / 10] < s->limit &&
           others(s, c) * 10 <= s->wish->w * s->wish->h && views_agree(s, c);
}

static int lenses_ok(const scan *s, const plft_pick *c)
{
    int bad = 0, x, y;

    for (y = c->j - s->wish->h / 2; s->field->lens && y <= c->j + s->wish->h / 2; y++) {
        for (x = c->i - s->wish->w / 2; x <= c->i + s->wish->w / 2; x++) {
            bad += s->field->lens[(size_t)y * (size_t)s->field->nx + (size_t)x] != 0;
        }
    }
    return 8 * bad <= s->wish->w * s->wish->h;
}

/* Slopes of every lens, by pairs of views. */
static int find_slopes(scan *s)
{
    plft_views_wish wish = {PLFT_PLENOPTIC, 0, 0, 0, 0.0, 0.0};
    plft_times times = {0, 0, 0, 0};
    plfx_plan *plan = plft_alloc(1, sizeof *plan);
    double lo = 0, hi = 0;
    int n = 0, labels = 0, rc = PLFT_DATA;
    plfx_cfg cfg;

    memset(&cfg, 0, sizeof cfg);
    if (plan != NULL) {
        rc = plft_arrange(s->field, &wish, cfg.at, &n);
    }
    cfg.n = (uint8_t)n;
    cfg.method = PLFX_METHOD_PAIRS;
    cfg.cost = PLFX_COST_ZNCC;
    cfg.fit = PLFX_FIT_PARABOLA;
    cfg.window = WINDOW;
    cfg.bits = (uint8_t)s->field->bits;
    rc = rc ? rc : plft_find_slopes(s->field, &cfg, &lo, &hi, &labels, &times);
    cfg.slope_min_q16 = (int32_t)lround(lo * 65536.0);
    cfg.slope_max_q16 = (int32_t)lround(hi * 65536.0);
    cfg.labels = (uint16_t)labels;
    rc = rc ? rc : plft_plan(plan, &cfg, s->field);
    rc = rc ? rc : plft_slopes_alloc(&s->map, s->field->nx, s->field->ny);
    rc = rc ? rc : plft_match(plan, s->field, &s->map, &times);
    s->limit = RIM_SPREAD / fmax(wish.radius, 1.0);
    free(plan);
    return rc;
}

/* ---- choice ---- */

/* Every candidate with texture; *n of them in a list of *all places. */
static plft_pick *candidates(scan *s, int *n, plft_pick_why *why)
{
    int fine = s->field->nx * s->field->ny < FINE;
    int step_x = fine ? 1 : s->wish->w / 4 + 1;
    int step_y = fine ? 1 : s->wish->h / 4 + 1;
    int x0 = s->wish->w / 2 + PLFX_ROI_MARGIN;
    int y0 = s->wish->h / 2 + PLFX_ROI_MARGIN;
    int cols = (s->field->nx - 2 * x0 + step_x - 1) / step_x;
    int rows = (s->field->ny - 2 * y0 + step_y - 1) / step_y;
    plft_pick *list;
    int k;

    *n = 0;
    why->all = cols > 0 && rows > 0 ? cols * rows : 0;
    list = plft_alloc((size_t)why->all, sizeof *list);
    for (k = 0; list != NULL && k < why->all; k++) {
        plft_pick *c = &list[*n];
        c->i = x0 + k % cols * step_x;
        c->j = y0 + k / cols * step_y;
        texture(s, c);
        if (!lenses_ok(s, c)) {
            why->lens++;
        } else if (!(c->weak >= s->wish->texture)) {
            why->flat++;
        } else {
            (*n)++;
        }
    }
    return list;
}

static void drop_edges(const scan *s, plft_pick *list, int *n, plft_pick_why *why)
{
    int kept = 0, k;

    for (k = 0; k < *n; k++) {
        if (one_surface(s, &list[k])) {
            list[kept++] = list[k];
        } else {
            why->edge++;
        }
    }
    *n = kept;
}

static int apart(const plft_pick_wish *w, const plft_pick *a, const plft_pick *b)
{
    return abs(a->i - b->i) >= w->w + w->gap || abs(a->j - b->j) >= w->h + w->gap;
}

/* Where regions can lie: lenses between the outermost centres. */
typedef struct reach {
    double x, y;
} reach;

static reach reach_of(const plft_pick *list, int n)
{
    int x0 = list[0].i, x1 = x0, y0 = list[0].j, y1 = y0, k;
    reach r;

    for (k = 1; k < n; k++) {
        x0 = list[k].i < x0 ? list[k].i : x0;
        x1 = list[k].i > x1 ? list[k].i : x1;
        y0 = list[k].j < y0 ? list[k].j : y0;
        y1 = list[k].j > y1 ? list[k].j : y1;
    }
    r.x = x1 > x0 ? x1 - x0 : 1;
    r.y = y1 > y0 ? y1 - y0 : 1;
    return r;
}

/* Squared distance to the nearest of the others, in parts of the reach, so that a long
 * surface gets regions at both rims too: twist moves nothing else.  `self`: not
 * counted. */
static double distance(const reach *r, const plft_pick *c, const plft_pick *chosen,
                       int n, int self)
{
    double least = 4.0; /* over any */
    int k;

    for (k = 0; k < n; k++) {
        double x = (c->i - chosen[k].i) / r->x;
        double y = (c->j - chosen[k].j) / r->y;
        if (k != self) {
            least = fmin(least, x * x + y * y);
        }
    }
    return least;
}

static int is_free(const plft_pick_wish *w, const plft_pick *c, const plft_pick *chosen,
                   int n, int self)
{
    int m = 0;

    while (m < n && (m == self || apart(w, c, &chosen[m]))) {
        m++;
    }
    return m == n;
}

/* Far from the others before rich in texture: what lies here has enough of it, and a
 * place twice as far counts as much as sixteen times the texture. */
static double worth(const reach *r, const plft_pick *c, const plft_pick *chosen, int n,
                    int self)
{
    return distance(r, c, chosen, n, self) * sqrt(c->weak);
}

/* The best place for a region beside the chosen ones but `self`.  -1: none fits. */
static int next(const plft_pick_wish *w, const reach *r, const plft_pick *list, int n,
                const plft_pick *chosen, int count, int self)
{
    double best = -1.0;
    int at = -1, k;

    for (k = 0; k < n; k++) {
        double v = worth(r, &list[k], chosen, count, self);
        if (v > best && is_free(w, &list[k], chosen, count, self)) {
            best = v;
            at = k;
        }
    }
    return at;
}

static int spread_out(const plft_pick_wish *w, const reach *r, const plft_pick *list,
                      int n, plft_pick *chosen)
{
    int count = 0, k = 0;

    while (count < w->n && k >= 0) {
        k = next(w, r, list, n, chosen, count, -1);
        if (k >= 0) {
            chosen[count++] = list[k];
        }
    }
    return count;
}

/* Row by row, as many as fit. */
static int packed(const plft_pick_wish *w, const plft_pick *list, int n, plft_pick *to)
{
    int count = 0, k;

    for (k = 0; k < n; k++) {
        if (is_free(w, &list[k], to, count, -1)) {
            to[count++] = list[k];
        }
    }
    return count;
}

/* Each region in turn moves to the best place that the others leave. */
static void settle(const plft_pick_wish *w, const reach *r, const plft_pick *list,
                   int n, plft_pick *chosen, int count)
{
    int round, k, at;

    for (round = 0; round < ROUNDS; round++) {
        for (k = 0; k < count; k++) {
            at = next(w, r, list, n, chosen, count, k);
            if (at >= 0 && worth(r, &list[at], chosen, count, k) >
                               worth(r, &chosen[k], chosen, count, k)) {
                chosen[k] = list[at];
            }
        }
    }
}

static int by_place(const void *a, const void *b)
{
    const plft_pick *x = a;
    const plft_pick *y = b;

    return x->j != y->j ? (x->j < y->j ? -1 : 1) : x->i < y->i ? -1 : x->i > y->i;
}

/* Spread out; where that leaves no room for some, spread over the places of a
 * packing. */
int plft_pick_choose(const plft_pick_places *places, const plft_pick_wish *wish,
                     plft_pick *picked, int *n)
{
    reach r = reach_of(places->list, places->n);
    plft_pick *dense;
    int most;

    *n = spread_out(wish, &r, places->list, places->n, picked);
    if (*n < wish->n) {
        dense = plft_alloc((size_t)places->n, sizeof *dense);
        if (dense == NULL) {
            return PLFT_DATA;
        }
        most = packed(wish, places->list, places->n, dense);
        if (most > *n) {
            *n = spread_out(wish, &r, dense, most, picked);
        }
        free(dense);
    }
    settle(wish, &r, places->list, places->n, picked, *n);
    qsort(picked, (size_t)*n, sizeof *picked, by_place);
    return 0;
}

void plft_pick_avoid(plft_pick_places *places, const plft_pick_wish *wish,
                     const plft_pick *bad)
{
    int n = 0, k;

    for (k = 0; k < places->n; k++) {
        const plft_pick *p = &places->list[k];
        if (3 * abs(p->i - bad->i) > wish->w || 3 * abs(p->j - bad->j) > wish->h) {
            places->list[n++] = *p;
        }
    }
    places->n = n;
}

static int open_views(scan *s)
{
    double r = s->field->radius;
    plfx_offset at[5];
    double q;
    int rc;

    s->radius = r;
    at[0] = plft_field_offset(s->field, 0.0, 0.0);
    at[1] = plft_field_offset(s->field, r, 0.0);
    at[2] = plft_field_offset(s->field, -r, 0.0);
    at[3] = plft_field_offset(s->field, 0.0, r);
    at[4] = plft_field_offset(s->field, 0.0, -r);
    rc = plft_field_views(s->field, at, 5, &s->views);

    if (rc == 0) { /* sixteenths of 1/255 of full scale */
        q = plfx_views_noise_q4(&s->views, s->field->bits, 0) / 16.0 / 255.0;
        q *= (double)((1 << s->field->bits) - 1);
        s->noise = q * q;
    }
    return rc;
}

int plft_pick_find(const plft_field *field, const plft_pick_wish *wish,
                   plft_pick_places *places)
{
    int rc;
    scan s;

    memset(&s, 0, sizeof s);
    memset(places, 0, sizeof *places);
    s.field = field;
    s.wish = wish;
    rc = open_views(&s);
    if (rc == 0) {
        places->list = candidates(&s, &places->n, &places->why);
        rc = places->list == NULL ? PLFT_DATA : places->n > 0 ? find_slopes(&s) : 0;
    }
    if (rc == 0 && places->n > 0) {
        drop_edges(&s, places->list, &places->n, &places->why);
    }
    free(s.views.px);
    plft_slopes_free(&s.map);
    return rc;
}

/* ---- the core's word ---- */

static void fill(plfx_roi_cfg *cfg, const plfx_lut *lut, int rest, int views,
                 double radius, const plft_pick_wish *wish, const plft_pick *p, int n)
{
    double at[PLFX_VIEWS_MAX][2];
    int k;

    cfg->lut = lut;
    cfg->tone = plfx_tone_unity(12);
    cfg->views = views;
    plft_plan_cross(at, views, radius);
    for (k = 0; k < views; k++) {
        cfg->at[k].u_q8 = (int16_t)lround(256.0 * at[k][0]);
        cfg->at[k].v_q8 = (int16_t)lround(256.0 * at[k][1]);
    }
    cfg->regions = n;
    for (k = 0; k < n; k++) {
        cfg->region[k].i = (int16_t)p[k].i;
        cfg->region[k].j = (int16_t)p[k].j;
        cfg->region[k].hx = (uint8_t)(wish->w / 2);
        cfg->region[k].hy = (uint8_t)(wish->h / 2);
    }
    cfg->rest = rest;
    cfg->steps = 1;
    cfg->residual_q8 = 65535;
}

static int measure(plfx_roi *roi, const plfx_roi_cfg *cfg, const plfx_raw *raw,
                   plft_pick *picked)
{
    size_t size = plfx_roi_ws(cfg);
    void *ws = plft_alloc_ws(size > 0 ? size : 1);
    plfx_roi_result out[PLFX_ROI_MAX];
    plfx_roi_frame frame = {raw, NULL};
    plfx_status status =
        ws != NULL && size > 0 ? plfx_roi_init(roi, cfg, ws, size) : PLFX_E_SIZE;
    int k;

    for (k = 0; status == PLFX_OK && k < cfg->rest; k++) {
        frame.raw = &raw[k];
        status = plfx_roi_rest(roi, &frame);
    }
    if (status == PLFX_OK) {
        status = plfx_roi_measure(roi, &frame, out);
    }
    for (k = 0; status == PLFX_OK && k < cfg->regions; k++) {
        picked[k].flags = out[k].flags;
        picked[k].sigma[0] = ldexp(out[k].u_sigma_q24, -24);
        picked[k].sigma[1] = ldexp(out[k].v_sigma_q24, -24);
        picked[k].sigma[2] = ldexp(out[k].w_sigma_q24, -24);
    }
    free(ws);
    return status == PLFX_OK ? 0
           : status == PLFX_E_RANGE
               ? plft_fail(PLFT_DATA, "regions want a square lattice")
               : plft_fail(PLFT_DATA, "the frames do not fit the table");
}

int plft_pick_check(const plfx_lut *lut, const plfx_raw *raw, int count, int views,
                    double radius, const plft_pick_wish *wish, plft_pick *picked, int n)
{
    plfx_roi *roi = plft_alloc(1, sizeof *roi);
    plfx_roi_cfg *cfg = plft_alloc(1, sizeof *cfg);
    int rc = PLFT_DATA;

    if (roi != NULL && cfg != NULL) {
        fill(cfg, lut, count, views, radius, wish, picked, n);
        rc = measure(roi, cfg, raw, picked);
    }
    free(cfg);
    free(roi);
    return rc;
}
