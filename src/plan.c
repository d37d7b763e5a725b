/* SPDX-License-Identifier: MIT */
#include "plenofix/plan.h"
#include "rows.h"
#include "fix.h"

#define SLOPE_LIMIT_Q16 (32 * 65536)

/* The rules of NUMERICS.md for the widest window of the deepest samples. */
#define TOP   (((uint64_t)1 << PLFX_BITS_MAX) - 1u)
#define ITEMS ((uint64_t)PLFX_WINDOW_MAX * PLFX_WINDOW_MAX)
PLFX_STATIC_ASSERT(TOP <= 65535u, a_difference_fits_its_column);
PLFX_STATIC_ASSERT(PLFX_WINDOW_MAX * 65535u < 1u << 21, a_shift_ends_in_21_steps);
PLFX_STATIC_ASSERT(ITEMS *ITEMS *TOP *TOP < (uint64_t)1 << 45, moments_fit);

static int32_t method_ok(const plfx_cfg *c)
{
    if (c->method == PLFX_METHOD_GRADIENT) {
        return c->n == 5 && c->ref == 0;
    }
    if (c->method == PLFX_METHOD_SWEEP) {
        return c->cost == PLFX_COST_SAD;
    }
    if (c->method == PLFX_METHOD_ARMS) {
        return c->cost == PLFX_COST_SAD;
    }
    return c->method == PLFX_METHOD_PAIRS && c->cost <= PLFX_COST_ZNCC;
}

static int32_t cfg_ok(const plfx_cfg *c)
{
    return method_ok(c) && c->fit <= PLFX_FIT_VEE && c->fuse <= PLFX_FUSE_CORRELATION &&
           c->window >= PLFX_WINDOW_MIN && c->window <= PLFX_WINDOW_MAX &&
           c->window % 2 == 1 && c->bits >= PLFX_BITS_MIN && c->bits <= PLFX_BITS_MAX &&
           c->n >= 2 && c->n <= PLFX_VIEWS_MAX && c->ref < c->n &&
           c->labels >= PLFX_LABELS_MIN && c->labels <= PLFX_LABELS_MAX &&
           c->slope_min_q16 >= -SLOPE_LIMIT_Q16 &&
           c->slope_max_q16 <= SLOPE_LIMIT_Q16 && c->slope_min_q16 < c->slope_max_q16;
}

typedef struct ratios { /* of the lattice: P/|a|, P/b, displacement of odd rows */
    int32_t col_q16, row_q16, hex, odd_q4;
} ratios;

/* Steps are cut to q16 so that products stay under 2^51. */
static ratios lattice_ratios(const plfx_lut *lut)
{
    const plfx_lattice *t = &lut->lattice;
    int64_t ax = plfx_asr_i32(t->a.x_q22, 6);
    int64_t ay = plfx_asr_i32(t->a.y_q22, 6);
    int64_t bx = plfx_asr_i32(t->b.x_q22, 6);
    int64_t by = plfx_asr_i32(t->b.y_q22, 6);
    int64_t aa = ax * ax + ay * ay;
    int64_t cross = ax * by - ay * bx;
    int64_t len = (int64_t)plfx_isqrt_u64((uint64_t)aa);
    int64_t pitch = plfx_lut_pitch_q16(lut);
    int64_t odd =
        plfx_asr_i32(t->odd.x_q22, 6) * ax + plfx_asr_i32(t->odd.y_q22, 6) * ay;
    ratios r;

    cross = cross < 0 ? -cross : cross;
    r.col_q16 = (int32_t)plfx_div_round_i64(pitch * 65536, len);
    r.row_q16 = (int32_t)plfx_div_round_i64(pitch * len, plfx_asr_i64(cross, 16));
    r.hex = t->kind == PLFX_LATTICE_HEX;
    r.odd_q4 = r.hex ? (int32_t)plfx_div_round_i64(odd * 16, aa) : 0;
    return r;
}

static ratios ratios_of(const plfx_lut *lut)
{
    ratios square = {65536, 65536, 0, 0};

    return lut ? lattice_ratios(lut) : square;
}

static int32_t least_shift(uint32_t per_item, uint32_t items)
{
    int32_t s = 0;

    /* at most 21 steps: per_item < 2^17, items <= 31 */
    while (items * (per_item >> s) > 65535u) {
        s++;
    }
    return s;
}

/* Largest cost of one lens: the differences of all views that are summed. */
static uint32_t top_cost(const plfx_cfg *c)
{
    uint32_t others = c->method == PLFX_METHOD_SWEEP ? c->n - 1u : 1u;

    return others * ((1u << c->bits) - 1u);
}

/* D (q16, 2^21) * offset (q8, 2^16) * ratio (q16, 2^17): under 2^54; sixteenths. */
static int32_t shift_q4(int32_t slope_q16, int32_t d_q8, int32_t ratio_q16)
{
    return (int32_t)plfx_div_round_i64((int64_t)slope_q16 * d_q8 * ratio_q16,
                                       (int64_t)1 << 36);
}

/* Farthest sample from its target along one axis, whole steps. */
static int32_t farthest(int32_t q4)
{
    return plfx_asr_i32((q4 < 0 ? -q4 : q4) + 15, 4);
}

static int32_t du_of(const plfx_cfg *c, int32_t k)
{
    return c->at[k].u_q8 - c->at[c->ref].u_q8;
}

static int32_t dv_of(const plfx_cfg *c, int32_t k)
{
    return c->at[k].v_q8 - c->at[c->ref].v_q8;
}

typedef struct reach {
    int32_t x, y;
} reach;

/* Over all views at both ends of the range: shifts are linear in the label.  On a
 * hexagonal lattice another row brings a column more. */
static reach reach_of(const plfx_cfg *c, const ratios *r)
{
    reach far = {0, 0};
    int32_t k;

    for (k = 0; k < c->n; k++) {
        int32_t du = du_of(c, k);
        int32_t dv = dv_of(c, k);
        int32_t x0 = farthest(shift_q4(c->slope_min_q16, du, r->col_q16));
        int32_t x1 = farthest(shift_q4(c->slope_max_q16, du, r->col_q16));
        int32_t y0 = farthest(shift_q4(c->slope_min_q16, dv, r->row_q16));
        int32_t y1 = farthest(shift_q4(c->slope_max_q16, dv, r->row_q16));
        int32_t y = plfx_max_i32(y0, y1);
        far.x = plfx_max_i32(far.x, plfx_max_i32(x0, x1) + (r->hex && y > 0));
        far.y = plfx_max_i32(far.y, y);
    }
    return far;
}

/* Every offset but the reference's differs from it. */
static int32_t offsets_ok(const plfx_cfg *c)
{
    int32_t k;

    for (k = 0; k < c->n; k++) {
        if (k != c->ref && du_of(c, k) == 0 && dv_of(c, k) == 0) {
            return 0;
        }
    }
    return 1;
}

/* Order centre, -u, +u, -v, +v at one step. */
static int32_t cross_ok(const plfx_cfg *c)
{
    int32_t s = du_of(c, 2);

    return dv_of(c, 2) == 0 && du_of(c, 1) == -s && dv_of(c, 1) == 0 &&
           du_of(c, 3) == 0 && dv_of(c, 3) == -s && du_of(c, 4) == 0 &&
           dv_of(c, 4) == s;
}

static plfx_status check_ranges(const plfx_cfg *c, reach far, int32_t nx, int32_t ny)
{
    if (c->method == PLFX_METHOD_GRADIENT) {
        return cross_ok(c) ? PLFX_OK : PLFX_E_ARG;
    }
    if (top_cost(c) > 65535u || far.x >= nx || far.y >= ny) {
        return PLFX_E_RANGE;
    }
    return PLFX_OK;
}

static void fill(plfx_plan *p, const plfx_cfg *c, const ratios *r, reach far)
{
    uint32_t w = c->window;
    int32_t k;

    if (&p->cfg != c) {
        p->cfg = *c;
    }
    p->hex = r->hex;
    p->odd_q4 = r->odd_q4;
    p->col_q16 = r->col_q16;
    p->row_q16 = r->row_q16;
    p->reach_x = far.x;
    p->reach_y = far.y;
    p->sad_shift1 = least_shift(top_cost(c), w);
    p->sad_shift2 = least_shift(w * (top_cost(c) >> p->sad_shift1), w);
    for (k = 0; k < PLFX_VIEWS_MAX; k++) {
        p->du_q8[k] = k < c->n ? du_of(c, k) : 0;
        p->dv_q8[k] = k < c->n ? dv_of(c, k) : 0;
    }
}

plfx_status plfx_plan_init(plfx_plan *plan, const plfx_cfg *cfg, const plfx_lut *lut,
                           int32_t nx, int32_t ny)
{
    plfx_status status;
    ratios r;
    reach far;

    if (!plan || !cfg || !cfg_ok(cfg) || !offsets_ok(cfg) || nx < cfg->window ||
        nx > PLFX_LENSES_MAX || ny < cfg->window || ny > PLFX_LENSES_MAX) {
        return PLFX_E_ARG;
    }
    if (lut && (lut->lattice.nx != nx || lut->lattice.ny != ny)) {
        return PLFX_E_ARG;
    }
    r = ratios_of(lut);
    far = reach_of(cfg, &r);
    status = check_ranges(cfg, far, nx, ny);
    if (status == PLFX_OK) {
        fill(plan, cfg, &r, far);
        plan->nx = nx;
        plan->ny = ny;
    }
    return status;
}

int32_t plfx_plan_slope_q16(const plfx_plan *plan, int32_t label_q4)
{
    const plfx_cfg *c = &plan->cfg;
    int64_t span = (int64_t)c->slope_max_q16 - c->slope_min_q16;

    return c->slope_min_q16 +
           (int32_t)plfx_div_round_i64(span * label_q4, 16 * ((int64_t)c->labels - 1));
}

plfx_shift plfx_shift_at(const plfx_plan *plan, int32_t k, int32_t slope_q16)
{
    int32_t x = shift_q4(slope_q16, plan->du_q8[k], plan->col_q16);
    int32_t y = shift_q4(slope_q16, plan->dv_q8[k], plan->row_q16);
    plfx_shift s;

    s.kx = plfx_asr_i32(x, 4);
    s.fx_q4 = x - 16 * s.kx;
    s.ky = plfx_asr_i32(y, 4);
    s.fy_q4 = y - 16 * s.ky;
    return s;
}

plfx_shift plfx_plan_shift(const plfx_plan *plan, int32_t k, int32_t label)
{
    return plfx_shift_at(plan, k, plfx_plan_slope_q16(plan, 16 * label));
}
