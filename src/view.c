/* SPDX-License-Identifier: MIT */
#include "plenofix/view.h"
#include "fix.h"
#include "mend.h"
#include "sure.h"
#include "view_run.h"

#define LANES PLFX_RUN_LENSES /* of a block */
#define BAND  4 /* lens rows: their sensor rows stay in the second-level cache */
#if PLFX_LANES >= 8
#define RUN   3 /* views side by side from which they are sampled at once, */
#define SIDE  PLFX_RUN_VIEWS /* so many at most */
#define CHUNK 176            /* views whose displacements are held at once */
#else                        /* small cores: view by view, little code and stack */
#define SIDE  1
#define CHUNK 16
#endif

plfx_tone plfx_tone_unity(int32_t bits)
{
    plfx_tone t = {0, 65535u, 4096u, 0, 0, 0, 0};

    t.bits = (uint8_t)bits;
    return t;
}

plfx_point plfx_view_offset(const plfx_lut *lut, plfx_offset at)
{
    /* steps in q12 (< 2^21), offsets q8 (< 2^15): products under 2^37, << 8 under
     * 2^45 */
    int64_t ax = plfx_asr_i32(lut->lattice.a.x_q22, 10);
    int64_t ay = plfx_asr_i32(lut->lattice.a.y_q22, 10);
    int64_t len = (int64_t)plfx_isqrt_u64((uint64_t)(ax * ax + ay * ay));
    plfx_point p;

    p.x_q16 = (int32_t)plfx_div_round_i64((at.u_q8 * ax - at.v_q8 * ay) * 256, len);
    p.y_q16 = (int32_t)plfx_div_round_i64((at.u_q8 * ay + at.v_q8 * ax) * 256, len);
    return p;
}

typedef struct sampler { /* what is the same for every lens of a call */
    const plfx_lut *lut;
    const plfx_raw *raw;
    const uint16_t *px; /* the frame when it is of plain pixels, else NULL */
    plfx_curve curve;
    int32_t w, h, down, white;
    uint32_t half;
    int32_t fine;  /* 1: plain pixels of 12 bits and less */
    int32_t aimed; /* 1: displacements are those of the first chunk */
    /* Displacements of views: whole pixels, and the rest in 2^-16. */
    int16_t x_px[CHUNK], y_px[CHUNK];
    uint16_t x_u16[CHUNK + SIDE], y_u16[CHUNK + SIDE];
    uint8_t run[CHUNK]; /* views from this one on that lie side by side, SIDE at most */
    plfx_point least, most; /* of the displacements */
} sampler;

static plfx_point shift_of(const sampler *s, int32_t k)
{
    plfx_point d;

    d.x_q16 = s->x_px[k] * 65536 + s->x_u16[k];
    d.y_q16 = s->y_px[k] * 65536 + s->y_u16[k];
    return d;
}

typedef struct block { /* lenses side by side: centres and their bounds */
    int32_t x_q16[LANES], y_q16[LANES];
    plfx_point least, most;
    int32_t
        inside; /* 1: no tap of any view leaves the sensor, nor pixels read beside */
} block;

static int32_t tone_ok(const plfx_tone *t)
{
    return t && t->bits >= PLFX_BITS_MIN && t->bits <= PLFX_BITS_MAX &&
           t->gain_q12 >= 4096u && t->gain_q12 <= 8191u && t->shift >= -8 &&
           t->shift <= 8 && t->dx_q8 >= -256 && t->dx_q8 <= 256 && t->dy_q8 >= -256 &&
           t->dy_q8 <= 256;
}

static int32_t raw_ok(const plfx_lut *lut, const plfx_raw *raw)
{
    return raw && raw->w == lut->sensor_w && raw->h == lut->sensor_h;
}

static int32_t views_ok(const plfx_lut *lut, const plfx_views *v)
{
    return v && v->px && v->n >= 1 && v->n <= PLFX_DECODE_MAX &&
           v->nx == lut->lattice.nx && v->ny == lut->lattice.ny;
}

static plfx_status check(const plfx_lut *lut, const plfx_raw *raw,
                         const plfx_tone *tone, const plfx_views *out)
{
    plfx_raw_row first;

    if (!lut || !raw_ok(lut, raw) || !tone_ok(tone) || !views_ok(lut, out)) {
        return PLFX_E_ARG;
    }
    return plfx_raw_row_at(raw, 0, &first); /* format, bits, size */
}

/* Pixels x and x + 1 of row y, indices clamped to the sensor. */
static uint32_t two_clamped(const sampler *s, int32_t x, int32_t y)
{
    int32_t x0 = plfx_clamp_i32(x, 0, s->w - 1);
    int32_t x1 = plfx_clamp_i32(x + 1, 0, s->w - 1);
    uint16_t v[2] = {0, 0};
    plfx_raw_row row;

    if (s->px) {
        const uint16_t *px = s->px + (size_t)y * (size_t)s->w;
        return px[x0] | (uint32_t)px[x1] << 16;
    }
    plfx_sure(plfx_raw_row_at(s->raw, y, &row));
    plfx_sure(plfx_raw_unpack(&row, x0, x1 - x0 + 1, v));
    return v[0] | (uint32_t)v[x1 - x0] << 16;
}

/* Sample at a point that holds the rounding half, 16 bits. */
static uint32_t sample_at(const sampler *s, int32_t x_q16, int32_t y_q16)
{
    int32_t x = plfx_asr_i32(x_q16, 16);
    int32_t y = plfx_asr_i32(y_q16, 16);
    uint32_t f = ((uint32_t)x_q16 >> 8) & 255u;
    uint32_t two0 = two_clamped(s, x, plfx_clamp_i32(y, 0, s->h - 1));
    uint32_t two1 = two_clamped(s, x, plfx_clamp_i32(y + 1, 0, s->h - 1));
    uint32_t h0 = plfx_along(two0, f, s->half, s->down);
    uint32_t h1 = plfx_along(two1, f, s->half, s->down);

    return plfx_across(h0, h1, ((uint32_t)y_q16 >> 8) & 255u);
}

static void bound(block *b)
{
    int32_t k;

    b->least.x_q16 = b->x_q16[0];
    b->least.y_q16 = b->y_q16[0];
    b->most = b->least;
    for (k = 1; k < LANES; k++) {
        b->least.x_q16 = plfx_min_i32(b->least.x_q16, b->x_q16[k]);
        b->least.y_q16 = plfx_min_i32(b->least.y_q16, b->y_q16[k]);
        b->most.x_q16 = plfx_max_i32(b->most.x_q16, b->x_q16[k]);
        b->most.y_q16 = plfx_max_i32(b->most.y_q16, b->y_q16[k]);
    }
}

/* Lenses i .. i+m-1 of lens row j.  Missing lenses, and lanes behind the last, stand
 * where a measured one does: their samples are defined and not used. */
static void place_block(const plfx_lut *lut, int32_t i, int32_t m, int32_t j, block *b)
{
    plfx_point c = {0, 0};
    int32_t known = 0;
    int32_t k;
    int32_t l;

    for (k = 0; k < LANES; k++) {
        if (k < m && !(plfx_lut_flags(lut, i + k, j) & PLFX_LENS_MISSING)) {
            c = plfx_lut_centre(lut, i + k, j);
            for (l = known ? k : 0; l < k; l++) { /* those before the first */
                b->x_q16[l] = c.x_q16;
                b->y_q16[l] = c.y_q16;
            }
            known = 1;
        }
        b->x_q16[k] = c.x_q16;
        b->y_q16[k] = c.y_q16;
    }
    bound(b);
}

/* One view of a block of m lenses; `to` holds the gains when they are wanted. */
static void fill_block(const sampler *s, const block *b, int32_t k, int32_t m,
                       uint16_t *to)
{
    plfx_point d = shift_of(s, k);
    int32_t l;

    for (l = 0; l < m; l++) {
        uint32_t v = sample_at(s, b->x_q16[l] + d.x_q16, b->y_q16[l] + d.y_q16);
        to[l] = (uint16_t)(s->white ? plfx_toned_white(s->curve, v, to[l])
                                    : plfx_toned(s->curve, v));
    }
}

#if PLFX_LANES >= 8
/* 1: no tap of the block leaves the sensor, `spare` columns to the right included, for
 * displacements between two. */
static int32_t inside(const sampler *s, const block *b, plfx_point first,
                      plfx_point last, int32_t spare)
{
    int32_t left = b->least.x_q16 + plfx_min_i32(first.x_q16, last.x_q16);
    int32_t right = b->most.x_q16 + plfx_max_i32(first.x_q16, last.x_q16);
    int32_t top = b->least.y_q16 + plfx_min_i32(first.y_q16, last.y_q16);
    int32_t end = b->most.y_q16 + plfx_max_i32(first.y_q16, last.y_q16);

    return left >= 0 && top >= 0 && plfx_asr_i32(right, 16) + spare < s->w &&
           plfx_asr_i32(end, 16) + 1 < s->h;
}

/* 1: pixels of n views do not lie side by side for some lens, displaced by `first` ..
 * `last`: then `apart` tells which.  Displacements are a straight line, rounded: when
 * the last view's pixel is n-1 beside the first one's, so are those between. */
static int32_t parted(const block *b, plfx_point first, plfx_point last, int32_t n,
                      int32_t *restrict apart)
{
    int32_t any = 0;
    int32_t l;

    PLFX_LANE_LOOP(l, LANES)
    {
        int32_t x = plfx_asr_i32(b->x_q16[l] + last.x_q16, 16) -
                    plfx_asr_i32(b->x_q16[l] + first.x_q16, 16) - (n - 1);
        int32_t y = plfx_asr_i32(b->y_q16[l] + last.y_q16, 16) -
                    plfx_asr_i32(b->y_q16[l] + first.y_q16, 16);
        apart[l] = (x != 0) | (y != 0);
        any |= apart[l];
    }
    return any;
}

/* Views of the lens at c whose pixels do not lie in line with the first view's: with
 * the last one's, sampled into `other`, or with neither. */
static void mend_parted(const sampler *s, plfx_point c, int32_t k, int32_t n,
                        const uint16_t *other, uint16_t *out)
{
    plfx_point first = shift_of(s, k);
    plfx_point last = shift_of(s, k + n - 1);
    int32_t i;

    for (i = 0; i < n; i++) {
        plfx_point d = shift_of(s, k + i);
        int32_t x = plfx_asr_i32(c.x_q16 + d.x_q16, 16) - i;
        int32_t y = plfx_asr_i32(c.y_q16 + d.y_q16, 16);
        if (x == plfx_asr_i32(c.x_q16 + first.x_q16, 16) &&
            y == plfx_asr_i32(c.y_q16 + first.y_q16, 16)) {
            continue;
        }
        if (x == plfx_asr_i32(c.x_q16 + last.x_q16, 16) - (n - 1) &&
            y == plfx_asr_i32(c.y_q16 + last.y_q16, 16)) {
            out[i] = other[i];
        } else {
            uint32_t v = sample_at(s, c.x_q16 + d.x_q16, c.y_q16 + d.y_q16);
            out[i] = (uint16_t)(s->white ? v : plfx_toned(s->curve, v));
        }
    }
}

/* Samples of a block whose views `apart` does not leave side by side. */
static void mend_block(const sampler *s, const block *b, int32_t k, int32_t n,
                       const plfx_view_run *run, const int32_t *apart,
                       uint16_t (*restrict tile)[SIDE])
{
    uint16_t other[LANES][SIDE];
    plfx_view_run from_last = *run;
    int32_t l;

    from_last.first = shift_of(s, k + n - 1);
    from_last.first.x_q16 -= (n - 1) * 65536;
    plfx_view_tile(&from_last, other);
    for (l = 0; l < LANES; l++) {
        plfx_point c = {b->x_q16[l], b->y_q16[l]};
        if (apart[l]) {
            mend_parted(s, c, k, n, other[l], tile[l]);
        }
    }
}

static inline plfx_view_run run_at(const sampler *s, const block *b, int32_t k)
{
    plfx_view_run run;

    run.px = s->px;
    run.w = s->w;
    run.x_q16 = b->x_q16;
    run.y_q16 = b->y_q16;
    run.first = shift_of(s, k);
    run.x_u16 = s->x_u16 + k;
    run.y_u16 = s->y_u16 + k;
    run.down = s->down;
    run.toned = !s->white;
    run.curve = s->curve;
    return run;
}

/* n views from view k on of all lenses of a block, turned into rows of the views. */
static void fill_run(const sampler *s, const block *b, int32_t k, int32_t n,
                     uint16_t *to)
{
    size_t nx = (size_t)s->lut->lattice.nx;
    uint16_t tile[LANES][SIDE];
    int32_t apart[LANES];
    plfx_view_run run = run_at(s, b, k);
    int32_t any = parted(b, run.first, shift_of(s, k + n - 1), n, apart);
    int32_t i;
    int32_t l;

    plfx_view_tile(&run, tile);
    if (any) {
        mend_block(s, b, k, n, &run, apart, tile);
    }
    if (run.toned) {
        plfx_view_turn(tile, n, to, nx);
        return;
    }
    for (i = 0; i < n; i++) {
        uint16_t *restrict row = to + (size_t)i * nx;
        for (l = 0; l < LANES; l++) {
            row[l] = (uint16_t)plfx_toned_white(s->curve, tile[l][i], row[l]);
        }
    }
}

static int32_t all_inside(const sampler *s, const block *b)
{
    return inside(s, b, s->least, s->most, SIDE + 1);
}

/* From view k on as many as lie side by side, at once where the block allows it. */
static int32_t fill_some(const sampler *s, const block *b, int32_t k, int32_t m,
                         uint16_t *to)
{
    int32_t run = s->run[k];

    if (run >= RUN && m == LANES && s->fine && b->inside) {
        fill_run(s, b, k, run, to);
        return run;
    }
    fill_block(s, b, k, m, to);
    return 1;
}
#else
static int32_t all_inside(const sampler *s, const block *b)
{
    (void)s;
    (void)b;
    return 0;
}

static int32_t fill_some(const sampler *s, const block *b, int32_t k, int32_t m,
                         uint16_t *to)
{
    fill_block(s, b, k, m, to);
    return 1;
}
#endif

/* n views of a block of m lenses. */
static void fill_views(const sampler *s, const block *b, int32_t n, int32_t m,
                       uint16_t *to)
{
    size_t nx = (size_t)s->lut->lattice.nx;
    int32_t k = 0;

    while (k < n) { /* at most n times */
        k += fill_some(s, b, k, m, to + (size_t)k * nx);
    }
}

/* Lens row j of n views, whose rows lie one behind the other. */
static void fill_row(const sampler *s, const plfx_offset *at, int32_t n, int32_t j,
                     uint16_t *rows)
{
    int32_t nx = s->lut->lattice.nx;
    int32_t i;
    int32_t k;
    block b;

    for (k = 0; s->white && k < n; k++) {
        plfx_sure(plfx_lut_gain_row(s->lut, j, at[k].u_q8, at[k].v_q8,
                                    rows + (size_t)k * (size_t)nx));
    }
    for (i = 0; i < nx; i += LANES) {
        int32_t m = plfx_min_i32(LANES, nx - i);
        place_block(s->lut, i, m, j, &b);
        b.inside = all_inside(s, &b);
        fill_views(s, &b, n, m, rows + i);
    }
    for (k = 0; k < n; k++) {
        plfx_mend_row(s->lut, j, rows + (size_t)k * (size_t)nx);
    }
}

static void start(sampler *s, const plfx_lut *lut, const plfx_raw *raw,
                  const plfx_tone *tone, int32_t white)
{
    s->lut = lut;
    s->raw = raw;
    s->px =
        raw->format == PLFX_RAW_U16 ? (const uint16_t *)(const void *)raw->bytes : NULL;
    s->curve = plfx_curve_of(tone, raw->bits);
    s->w = raw->w;
    s->h = raw->h;
    s->down = raw->bits - 8;
    s->half = (1u << s->down) >> 1;
    s->white = white && lut->gain.length > 0;
    s->fine = s->px && raw->bits <= 12;
    s->aimed = 0;
}

/* Views from at[0] on that lie side by side, one pixel apart. */
static int32_t run_of(const plfx_offset *at, int32_t n)
{
    int32_t i = 1;

    /* at most SIDE times */
    while (i < n && i < SIDE && at[i].u_q8 == at[i - 1].u_q8 + 256 &&
           at[i].v_q8 == at[0].v_q8) {
        i++;
    }
    return i;
}

/* Displacements of n views. */
static void aim(sampler *s, const plfx_tone *tone, const plfx_offset *at, int32_t n)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        plfx_point d = plfx_tap_shift(s->lut, tone, at[i]);
        s->x_px[i] = (int16_t)plfx_asr_i32(d.x_q16, 16);
        s->y_px[i] = (int16_t)plfx_asr_i32(d.y_q16, 16);
        s->x_u16[i] = (uint16_t)((uint32_t)d.x_q16 & 65535u);
        s->y_u16[i] = (uint16_t)((uint32_t)d.y_q16 & 65535u);
        s->run[i] = (uint8_t)run_of(at + i, n - i);
        s->least.x_q16 = i ? plfx_min_i32(s->least.x_q16, d.x_q16) : d.x_q16;
        s->least.y_q16 = i ? plfx_min_i32(s->least.y_q16, d.y_q16) : d.y_q16;
        s->most.x_q16 = i ? plfx_max_i32(s->most.x_q16, d.x_q16) : d.x_q16;
        s->most.y_q16 = i ? plfx_max_i32(s->most.y_q16, d.y_q16) : d.y_q16;
    }
    for (; i < n + SIDE; i++) { /* read with the last views, not used */
        s->x_u16[i] = 0;
        s->y_u16[i] = 0;
    }
}

/* Views of the next chunk: as many as fit whose last run is not cut. */
static int32_t chunk_of(const plfx_offset *at, int32_t n)
{
    int32_t m = 0;

    while (m < n) { /* at most CHUNK times */
        int32_t run = run_of(at + m, n - m);
        if (m + run > CHUNK) {
            break;
        }
        m += run;
    }
    return m;
}

/* Lens rows j0 .. j1-1 of views k0 .. k0+n-1 of `out`: views a chunk at a time, so that
 * their displacements are found once a band. */
static void fill(sampler *s, const plfx_tone *tone, const plfx_offset *at, int32_t n,
                 int32_t j0, int32_t j1, const plfx_views *out, int32_t k0)
{
    int32_t k;
    int32_t m;
    int32_t j;

    for (k = 0; k < n; k += m) {
        m = chunk_of(at + k, n - k);
        if (m < n || !s->aimed) {
            aim(s, tone, at + k, m);
            s->aimed = 1;
        }
        for (j = j0; j < j1; j++) {
            size_t row = (size_t)j * (size_t)out->n + (size_t)(k0 + k);
            fill_row(s, at + k, m, j, out->px + row * (size_t)out->nx);
        }
    }
}

plfx_status plfx_view_rows(const plfx_lut *lut, const plfx_raw *raw,
                           const plfx_tone *tone, plfx_offset at, int32_t white,
                           int32_t j0, int32_t j1, const plfx_views *out, int32_t k)
{
    plfx_status status = check(lut, raw, tone, out);
    sampler s;

    if (status == PLFX_E_ARG || k < 0 || k >= out->n || j0 < 0 || j1 > out->ny ||
        j0 > j1) {
        return PLFX_E_ARG;
    }
    if (status == PLFX_OK) {
        start(&s, lut, raw, tone, white);
        fill(&s, tone, &at, 1, j0, j1, out, k);
    }
    return status;
}

plfx_status plfx_view_all(const plfx_lut *lut, const plfx_raw *raw,
                          const plfx_tone *tone, const plfx_offset *at, int32_t white,
                          const plfx_views *out)
{
    plfx_status status = at ? check(lut, raw, tone, out) : PLFX_E_ARG;
    sampler s;
    int32_t j;

    if (status == PLFX_OK) {
        start(&s, lut, raw, tone, white);
        for (j = 0; j < out->ny; j += BAND) {
            fill(&s, tone, at, out->n, j, plfx_min_i32(j + BAND, out->ny), out, 0);
        }
    }
    return status;
}
