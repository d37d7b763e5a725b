/* SPDX-License-Identifier: MIT
 * Similarity of a frame's lattice to the table's. */
#include "plenofix/drift.h"
#include "arena.h"
#include "drift_state.h"
#include "fix.h"

#include <string.h>

#define ROUNDS  16
#define COARSE  5         /* rounds by centroid, at most */
#define NEAR    (1 << 19) /* q20: a coarse step this small at a corner is the last */
#define STILL   256       /* q20: a fine one */
#define TILES   8         /* on an axis */
#define ENOUGH  16        /* lenses */
#define CUT     4         /* rms of a lens that still takes part */
#define CUT_MIN 16384     /* q20 */
#define LOST    65536     /* q20: a last step this long has not settled */
#define GRAIN   16384     /* q40: the arithmetic's own 2^-13 px */

/* Sums over lenses.  Places q4 from the middle of the sensor, < 2^18; displacements
 * q20, < 2^27; lenses < 2^13. */
typedef struct tally {
    int64_t n, x, y, rr;     /* lenses, places, squared distances */
    int64_t dx, dy;          /* displacements */
    int64_t radial, tangent; /* X dx + Y dy, X dy - Y dx: < 2^59 */
} tally;

typedef struct similarity {
    int64_t sx_q20, sy_q20, rotation_q30, scale_q30;
} similarity;

typedef struct search {
    const plfx_lut *lut;
    plfx_drift_window w;
    tally *tile; /* [TILES^2] */
    similarity at;
    int32_t stride;        /* every so-manieth lens of a row, and row */
    int32_t reach_q20;     /* a longer displacement is none */
    int32_t tried, lenses; /* of a round */
    int64_t square_q24;    /* sum of squared displacements, px^2, < 2^52 */
} search;

static void carve(search *s, plfx_arena *a)
{
    plfx_drift_window *w = &s->w;
    const size_t n = (size_t)w->n;

    s->tile = plfx_take(a, (size_t)TILES * TILES, sizeof *s->tile);
    w->sum = plfx_take(a, n * n, sizeof *w->sum);
    w->px = plfx_take(a, n * n, sizeof *w->px);
    w->kx = plfx_take(a, n * n, sizeof *w->kx);
    w->ky = plfx_take(a, n * n, sizeof *w->ky);
    w->even = plfx_take(a, n * n, sizeof *w->even);
    w->ring = plfx_take(a, 8u * n, sizeof *w->ring);
    w->row = plfx_take(a, n + 4u, sizeof *w->row);
    w->span = plfx_take(a, n, sizeof *w->span);
}

/* Half width: the disc of p/2 + 1/2 and a border for differences. */
static int32_t size_of(search *s, const plfx_lut *lut)
{
    int32_t pitch = plfx_lut_pitch_q16(lut);

    memset(s, 0, sizeof *s);
    s->lut = lut;
    s->w.half = plfx_asr_i32(pitch + 65536, 17) + 2;
    s->w.n = 2 * s->w.half + 1;
    return pitch <= DRIFT_PITCH_MAX * 65536;
}

size_t plfx_drift_ws(const plfx_lut *lut)
{
    plfx_arena a = {NULL, 0};
    search s;

    if (!lut || !size_of(&s, lut)) {
        return 0;
    }
    carve(&s, &a);
    return a.used;
}

static void make_disc(search *s)
{
    plfx_drift_window *w = &s->w;
    int64_t r = plfx_asr_i32(plfx_lut_pitch_q16(s->lut), 9) + 128; /* q8, < 2^17 */
    int32_t y;

    for (y = -w->half; y <= w->half; y++) {
        int64_t left = r * r - (int64_t)65536 * y * y;
        int32_t span = -1; /* none */
        if (left >= 0) {
            span = (int32_t)(plfx_isqrt_u64((uint64_t)left) >> 8);
            w->cells += 2 * span + 1;
        }
        w->span[y + w->half] = (int16_t)span;
    }
}

typedef struct place {    /* of a lens */
    int32_t x_q16, y_q16; /* by the table and the similarity so far */
    int32_t x_q4, y_q4;   /* by the table, from the middle of the sensor */
} place;

static place place_of(const search *s, int32_t i, int32_t j)
{
    plfx_point c = plfx_lut_centre(s->lut, i, j);
    int64_t x;
    int64_t y;
    place p;

    p.x_q4 = plfx_asr_i32(c.x_q16, 12) - 8 * (s->lut->sensor_w - 1);
    p.y_q4 = plfx_asr_i32(c.y_q16, 12) - 8 * (s->lut->sensor_h - 1);
    x = s->at.sx_q20 + plfx_round_shift_i64(
                           s->at.scale_q30 * p.x_q4 - s->at.rotation_q30 * p.y_q4, 14);
    y = s->at.sy_q20 + plfx_round_shift_i64(
                           s->at.rotation_q30 * p.x_q4 + s->at.scale_q30 * p.y_q4, 14);
    p.x_q16 = plfx_sat_i32(c.x_q16 + plfx_round_shift_i64(x, 4));
    p.y_q16 = plfx_sat_i32(c.y_q16 + plfx_round_shift_i64(y, 4));
    return p;
}

static int32_t tile_of(int32_t v_q4, int32_t side)
{
    return plfx_clamp_i32((v_q4 + 8 * side) * TILES / (16 * side), 0, TILES - 1);
}

static void add_lens(search *s, const place *p, const plfx_drift_lens *d)
{
    tally *t = &s->tile[tile_of(p->y_q4, s->lut->sensor_h) * TILES +
                        tile_of(p->x_q4, s->lut->sensor_w)];
    int64_t dx = plfx_asr_i32(d->dx_q20, 8);
    int64_t dy = plfx_asr_i32(d->dy_q20, 8);

    t->n++;
    t->x += p->x_q4;
    t->y += p->y_q4;
    t->rr += (int64_t)p->x_q4 * p->x_q4 + (int64_t)p->y_q4 * p->y_q4;
    t->dx += d->dx_q20;
    t->dy += d->dy_q20;
    t->radial += (int64_t)p->x_q4 * d->dx_q20 + (int64_t)p->y_q4 * d->dy_q20;
    t->tangent += (int64_t)p->x_q4 * d->dy_q20 - (int64_t)p->y_q4 * d->dx_q20;
    s->square_q24 += dx * dx + dy * dy;
    s->lenses++;
}

static int32_t within(const plfx_drift_lens *d, int64_t reach_q20)
{
    int64_t x = d->dx_q20;
    int64_t y = d->dy_q20;

    return d->ok && x <= reach_q20 && x >= -reach_q20 && y <= reach_q20 &&
           y >= -reach_q20 && x * x + y * y <= reach_q20 * reach_q20;
}

/* Sample, measure and add one lens. */
static void take(search *s, int32_t i, int32_t j, int32_t fine)
{
    place p = place_of(s, i, j);
    int32_t x_q12 = (int32_t)plfx_round_shift_i64(p.x_q16, 4);
    int32_t y_q12 = (int32_t)plfx_round_shift_i64(p.y_q16, 4);
    plfx_drift_lens d;

    if (!plfx_drift_sample(&s->w, x_q12, y_q12)) {
        return;
    }
    s->tried++;
    d = fine ? plfx_drift_match(&s->w) : plfx_drift_centroid(&s->w);
    if (within(&d, s->reach_q20)) {
        d.dx_q20 += 16 * (16 * x_q12 - p.x_q16); /* it was sampled there */
        d.dy_q20 += 16 * (16 * y_q12 - p.y_q16);
        add_lens(s, &p, &d);
        plfx_drift_fold(&s->w);
    }
}

/* Least stride that leaves at most `lenses`. */
static int32_t stride_of(const plfx_lattice *l, int32_t lenses)
{
    int32_t k =
        (int32_t)plfx_isqrt_u64((uint64_t)l->nx * (uint64_t)l->ny / (uint64_t)lenses);

    k = plfx_max_i32(1, k);
    return ((l->nx + k - 1) / k) * ((l->ny + k - 1) / k) > lenses ? k + 1 : k;
}

/* Border lenses are left out: neighbours lighten them on one side only. */
static void look(search *s, int32_t fine)
{
    const size_t cells = (size_t)s->w.n * (size_t)s->w.n;
    int32_t i;
    int32_t j;

    memset(s->tile, 0, sizeof *s->tile * TILES * TILES);
    memset(s->w.sum, 0, sizeof *s->w.sum * cells);
    s->w.folded = 0;
    s->tried = 0;
    s->lenses = 0;
    s->square_q24 = 0;
    for (j = 1 + s->stride / 2; j < s->lut->lattice.ny - 1; j += s->stride) {
        for (i = 1 + s->stride / 2; i < s->lut->lattice.nx - 1; i += s->stride) {
            if (plfx_lut_flags(s->lut, i, j) == 0u) {
                take(s, i, j, fine);
            }
        }
    }
}

/* The longest displacement of a corner of the sensor, q20, at most 2^31. */
static int64_t corner(const search *s, const similarity *m)
{
    const int64_t x = 8 * ((int64_t)s->lut->sensor_w - 1);
    const int64_t y = 8 * ((int64_t)s->lut->sensor_h - 1);
    int64_t worst = 0;
    int32_t k;

    for (k = 0; k < 4; k++) {
        int64_t px = (k & 1) ? x : -x;
        int64_t py = (k & 2) ? y : -y;
        int64_t dx =
            m->sx_q20 + plfx_asr_i64(m->scale_q30 * px - m->rotation_q30 * py, 14);
        int64_t dy =
            m->sy_q20 + plfx_asr_i64(m->rotation_q30 * px + m->scale_q30 * py, 14);
        int64_t d = plfx_isqrt_u64((uint64_t)(dx * dx + dy * dy));
        worst = d > worst ? d : worst;
    }
    return worst;
}

static tally total(const search *s)
{
    tally t = {0, 0, 0, 0, 0, 0, 0, 0};
    int32_t k;

    for (k = 0; k < TILES * TILES; k++) {
        t.n += s->tile[k].n;
        t.x += s->tile[k].x;
        t.y += s->tile[k].y;
        t.rr += s->tile[k].rr;
        t.dx += s->tile[k].dx;
        t.dy += s->tile[k].dy;
        t.radial += s->tile[k].radial;
        t.tangent += s->tile[k].tangent;
    }
    return t;
}

/* About their mean place, where the normal equations are diagonal but for the rounding
 * of that place: half of q4. */
typedef struct pivot {
    int64_t x, y, rr; /* q4, q4, q8, at least 1: lenses in one place pull with 0 */
    int64_t n;
} pivot;

static pivot pivot_of(const tally *t)
{
    pivot p;
    int64_t rr;

    p.n = t->n;
    p.x = plfx_div_round_i64(t->x, t->n);
    p.y = plfx_div_round_i64(t->y, t->n);
    rr = t->rr - 2 * (p.x * t->x + p.y * t->y) + t->n * (p.x * p.x + p.y * p.y);
    p.rr = rr > 1 ? rr : 1;
    return p;
}

static int64_t radial(const tally *t, const pivot *p)
{
    return t->radial - p->x * t->dx - p->y * t->dy;
}

static int64_t tangent(const tally *t, const pivot *p)
{
    return t->tangent - p->x * t->dy + p->y * t->dx;
}

static int64_t clamp(int64_t v, int64_t most)
{
    return plfx_clamp_i64(v, -most, most);
}

/* One step of the similarity; the longest displacement it makes at a corner.  A turn or
 * scale is held under 1/16, a shift under 512 pixels: beyond, no lens is found. */
static int64_t solve(search *s)
{
    const tally t = total(s);
    const pivot p = pivot_of(&t);
    similarity d;

    d.scale_q30 = clamp(plfx_drift_ratio(radial(&t, &p), p.rr, 14), 1 << 26);
    d.rotation_q30 = clamp(plfx_drift_ratio(tangent(&t, &p), p.rr, 14), 1 << 26);
    d.sx_q20 = plfx_div_round_i64(t.dx, t.n) -
               plfx_asr_i64(d.scale_q30 * p.x - d.rotation_q30 * p.y, 14);
    d.sy_q20 = plfx_div_round_i64(t.dy, t.n) -
               plfx_asr_i64(d.rotation_q30 * p.x + d.scale_q30 * p.y, 14);
    s->at.scale_q30 = clamp(s->at.scale_q30 + d.scale_q30, 1 << 26);
    s->at.rotation_q30 = clamp(s->at.rotation_q30 + d.rotation_q30, 1 << 26);
    s->at.sx_q20 = clamp(s->at.sx_q20 + d.sx_q20, 1 << 29);
    s->at.sy_q20 = clamp(s->at.sy_q20 + d.sy_q20, 1 << 29);
    return corner(s, &d);
}

/* An axis, q20. */
static int32_t rms(const search *s)
{
    return 256 * (int32_t)plfx_isqrt_u64((uint64_t)s->square_q24 /
                                         (2u * (uint64_t)s->lenses));
}

/* Rounds until it stands still; a plfx_drift_state. */
static int32_t settle(search *s)
{
    const int32_t pitch_q20 = plfx_lut_pitch_q16(s->lut) * 16; /* < 2^29 */
    int64_t step = (int64_t)1 << 30;
    int32_t fine = 0;
    int32_t round;

    s->reach_q20 = pitch_q20 / 5 * 2;
    for (round = 0; round < ROUNDS && (!fine || step > STILL); round++) {
        if (fine && !plfx_drift_kernels(&s->w)) {
            return PLFX_DRIFT_FLAT;
        }
        look(s, fine);
        if (s->tried < ENOUGH) {
            return PLFX_DRIFT_FEW;
        }
        if (s->lenses < ENOUGH) {
            return fine ? PLFX_DRIFT_DISAGREE : PLFX_DRIFT_FLAT;
        }
        step = solve(s);
        if (fine) {
            s->reach_q20 = plfx_clamp_i32(CUT * rms(s), CUT_MIN, pitch_q20 / 10 * 3);
        }
        if (!fine && (step <= NEAR || round + 1 == COARSE)) {
            fine = 1;
            step = (int64_t)1 << 30;
        }
    }
    return 2 * s->lenses < s->tried || step > LOST ? PLFX_DRIFT_DISAGREE
                                                   : PLFX_DRIFT_MEASURED;
}

/* Variances of the parameters from what the tiles pull, each held under 2^28. */
typedef struct pulls {
    uint64_t x_q48, y_q48, turn_q72, scale_q72;
} pulls;

static uint64_t square(int64_t v)
{
    const int64_t c = clamp(v, 1 << 28);

    return (uint64_t)(c * c); /* 64 of them < 2^62 */
}

static pulls pull(const search *s, const pivot *p)
{
    pulls v = {0, 0, 0, 0};
    int32_t k;
    uint64_t used = 0;

    for (k = 0; k < TILES * TILES; k++) {
        const tally *t = &s->tile[k];
        v.x_q48 += square(plfx_drift_ratio(t->dx, p->n, 4));
        v.y_q48 += square(plfx_drift_ratio(t->dy, p->n, 4));
        v.scale_q72 += square(plfx_drift_ratio(radial(t, p), p->rr, 20));
        v.turn_q72 += square(plfx_drift_ratio(tangent(t, p), p->rr, 20));
        used += t->n > 0;
    }
    used = used > 1 ? used : 2;
    v.x_q48 += v.x_q48 / (used - 1);
    v.y_q48 += v.y_q48 / (used - 1);
    v.scale_q72 += v.scale_q72 / (used - 1);
    v.turn_q72 += v.turn_q72 / (used - 1);
    return v;
}

static int64_t root(uint64_t v)
{
    return plfx_isqrt_u64(v);
}

/* Lenses that meet the pixels at a slowly changing phase pull at turn and scale with a
 * quarter of what one phase for all pulls at the shift. */
static uint64_t moire_q60(int64_t asymmetry_q40, const pivot *p)
{
    return (uint64_t)plfx_drift_ratio(asymmetry_q40 * p->n, 16 * p->rr + 1, 28);
}

static void errors(const search *s, plfx_drift *out)
{
    const tally t = total(s);
    const pivot p = pivot_of(&t);
    const pulls v = pull(s, &p);
    const int64_t uneven = clamp(s->w.asymmetry_q40, (int64_t)1 << 40);
    const int64_t turn = root((v.turn_q72 >> 12) + moire_q60(uneven, &p));
    const int64_t scale = root((v.scale_q72 >> 12) + moire_q60(uneven, &p));
    const int64_t both = root((uint64_t)(turn * turn + scale * scale));
    const int64_t arm = root((uint64_t)(p.x * p.x + p.y * p.y));
    const int64_t w = 8 * (int64_t)s->lut->sensor_w;
    const int64_t h = 8 * (int64_t)s->lut->sensor_h;
    const int64_t corner_arm = plfx_asr_i64(root((uint64_t)(w * w + h * h)) * both, 14);
    const int64_t lever = plfx_asr_i64(arm * both, 14);
    const uint64_t pulled = v.x_q48 > v.y_q48 ? v.x_q48 : v.y_q48;
    const int64_t shift =
        root((pulled >> 8) + (uint64_t)(lever * lever) + (uint64_t)uneven + GRAIN);

    out->shift_sigma_q20 = plfx_sat_i32(shift);
    out->rotation_sigma_q30 = plfx_sat_i32(turn);
    out->scale_sigma_q30 = plfx_sat_i32(scale);
    out->corner_sigma_q20 =
        plfx_sat_i32(root((uint64_t)(2 * shift * shift + corner_arm * corner_arm)));
}

static void report(const search *s, plfx_drift *out)
{
    out->shift_x_q20 = (int32_t)s->at.sx_q20;
    out->shift_y_q20 = (int32_t)s->at.sy_q20;
    out->rotation_q30 = (int32_t)s->at.rotation_q30;
    out->scale_q30 = (int32_t)s->at.scale_q30;
    out->corner_q20 = plfx_sat_i32(corner(s, &s->at));
    out->rms_q20 = rms(s);
    errors(s, out);
}

static plfx_status check(const plfx_lut *lut, const plfx_raw *raw, int32_t lenses,
                         const void *ws, size_t ws_size, const plfx_drift *out)
{
    size_t need;

    if (!lut || !raw || !raw->bytes || !ws || !out || lenses < PLFX_DRIFT_LENSES_MIN ||
        lenses > PLFX_DRIFT_LENSES_MAX || raw->w != lut->sensor_w ||
        raw->h != lut->sensor_h || raw->bits < 8 || raw->bits > 16 ||
        plfx_raw_bytes(raw->format, raw->w, raw->h) == 0) {
        return PLFX_E_ARG;
    }
    need = plfx_drift_ws(lut);
    if (need == 0) {
        return PLFX_E_RANGE;
    }
    return ws_size < need || !plfx_aligned(ws) ||
                   raw->size < plfx_raw_bytes(raw->format, raw->w, raw->h)
               ? PLFX_E_SIZE
               : PLFX_OK;
}

plfx_status plfx_drift_find(const plfx_lut *lut, const plfx_raw *raw, int32_t lenses,
                            void *ws, size_t ws_size, plfx_drift *out)
{
    plfx_status status = check(lut, raw, lenses, ws, ws_size, out);
    plfx_arena a = {ws, 0};
    search s;

    if (status != PLFX_OK) {
        return status;
    }
    (void)size_of(&s, lut);
    s.w.raw = raw;
    carve(&s, &a);
    make_disc(&s);
    s.stride = stride_of(&lut->lattice, lenses);
    memset(out, 0, sizeof *out);
    out->state = settle(&s);
    out->lenses = s.lenses;
    out->tried = s.tried;
    if (out->state == PLFX_DRIFT_MEASURED) {
        report(&s, out);
    }
    return PLFX_OK;
}
