/* SPDX-License-Identifier: MIT
 * Where one lens lies against the mean micro-image. */
#include "drift_state.h"
#include "fix.h"
#include "sure.h"

#include <string.h>

#define CONTRAST 512 /* of 2^16: a lens with less says nothing about its centroid */
#define DIM      8   /* part of the mean lens' level that a lens must reach */

int64_t plfx_drift_ratio(int64_t n, int64_t d, int32_t up)
{
    uint64_t m = n < 0 ? (uint64_t)-n : (uint64_t)n;
    int32_t room = m > 0 ? 61 - plfx_log2_u64(m) : up;
    int32_t left = plfx_min_i32(up, room);
    int64_t q;

    d = up > left ? plfx_asr_i64(d, plfx_min_i32(up - left, 62)) : d;
    q = d > 0 ? (int64_t)(m << left) / d : (int64_t)1 << 62;
    return n < 0 ? -q : q;
}

#define TAPS 5
#define RING 7 /* rows y .. y+4 lie at y & 7 */

/* out[i] of n samples along a row of n+4 pixels; t: weights that add up to 2^14, no sum
 * reaches 2^30. */
static void along_row(const uint16_t *p, int32_t n, int32_t up, const uint32_t *t,
                      uint16_t *out)
{
    int32_t i;

    for (i = 0; i < n; i++) {
        uint32_t s = t[0] * p[i] + t[1] * p[i + 1] + t[2] * p[i + 2] + t[3] * p[i + 3] +
                     t[4] * p[i + 4];
        out[i] = (uint16_t)(((s << up) + 8192u) >> 14);
    }
}

static void across_rows(const plfx_drift_window *w, int32_t y, const uint32_t *t)
{
    const uint16_t *r0 = w->ring + (y & RING) * w->n;
    const uint16_t *r1 = w->ring + ((y + 1) & RING) * w->n;
    const uint16_t *r2 = w->ring + ((y + 2) & RING) * w->n;
    const uint16_t *r3 = w->ring + ((y + 3) & RING) * w->n;
    const uint16_t *r4 = w->ring + ((y + 4) & RING) * w->n;
    uint16_t *out = w->px + y * w->n;
    int32_t i;

    for (i = 0; i < w->n; i++) {
        uint32_t s =
            t[0] * r0[i] + t[1] * r1[i] + t[2] * r2[i] + t[3] * r3[i] + t[4] * r4[i];
        out[i] = (uint16_t)((s + 8192u) >> 14);
    }
}

/* u^3/6 in q13, u in q12, 0 .. 4096. */
static uint32_t sixth_cube(uint32_t u)
{
    return (uint32_t)(((uint64_t)u * u * u + 25165824u) / 50331648u);
}

/* Cubic B-spline at fraction f of the second of four pixels, meant over two neighbours.
 * From its outer weights and f the inner ones follow: sum and centroid are exact. */
static void weights(int32_t v_q12, uint32_t t[TAPS])
{
    uint32_t f = (uint32_t)v_q12 & 4095u;
    uint32_t c0 = sixth_cube(4096u - f);
    uint32_t c3 = sixth_cube(f);
    uint32_t c1 = 8192u - 2u * f + c3 - 2u * c0;
    uint32_t c2 = 2u * f + c0 - 2u * c3;

    t[0] = c0;
    t[1] = c0 + c1;
    t[2] = c1 + c2;
    t[3] = c2 + c3;
    t[4] = c3;
}

int32_t plfx_drift_sample(const plfx_drift_window *w, int32_t x_q12, int32_t y_q12)
{
    const int32_t read = w->n + TAPS - 1;
    int32_t x0 = plfx_asr_i32(x_q12 - 2048, 12) - 1 - w->half;
    int32_t y0 = plfx_asr_i32(y_q12 - 2048, 12) - 1 - w->half;
    uint32_t tx[TAPS];
    uint32_t ty[TAPS];
    plfx_raw_row row;
    int32_t y;

    if (x0 < 0 || y0 < 0 || x0 + read > w->raw->w || y0 + read > w->raw->h) {
        return 0;
    }
    weights(x_q12 - 2048, tx);
    weights(y_q12 - 2048, ty);
    for (y = 0; y < read; y++) {
        plfx_sure(plfx_raw_row_at(w->raw, y0 + y, &row));
        plfx_sure(plfx_raw_unpack(&row, x0, read, w->row));
        along_row(w->row, w->n, 16 - w->raw->bits, tx, w->ring + (y & RING) * w->n);
        if (y >= TAPS - 1) {
            across_rows(w, y - TAPS + 1, ty);
        }
    }
    return 1;
}

void plfx_drift_fold(plfx_drift_window *w)
{
    int32_t k;

    for (k = 0; k < w->n * w->n; k++) {
        w->sum[k] += w->px[k]; /* < 2^12 * 2^16 */
    }
    w->folded++;
}

plfx_drift_lens plfx_drift_centroid(const plfx_drift_window *w)
{
    plfx_drift_lens lens = {0, 0, 0};
    const uint16_t *middle = w->px + w->half * w->n + w->half;
    int64_t mass = 0; /* < 2^33; moments < 2^40 */
    int64_t mx = 0;
    int64_t my = 0;
    int32_t low = 65535;
    int32_t high = 0;
    int32_t x;
    int32_t y;

    for (y = -w->half; y <= w->half; y++) {
        for (x = -w->span[y + w->half]; x <= w->span[y + w->half]; x++) {
            low = plfx_min_i32(low, middle[y * w->n + x]);
            high = plfx_max_i32(high, middle[y * w->n + x]);
        }
    }
    for (y = -w->half; y <= w->half; y++) {
        for (x = -w->span[y + w->half]; x <= w->span[y + w->half]; x++) {
            int32_t v = middle[y * w->n + x] - low;
            mass += v;
            mx += (int64_t)v * x;
            my += (int64_t)v * y;
        }
    }
    if (high - low >= CONTRAST) {
        lens.dx_q20 = plfx_sat_i32(plfx_drift_ratio(mx, mass, 20));
        lens.dy_q20 = plfx_sat_i32(plfx_drift_ratio(my, mass, 20));
        lens.ok = 1;
    }
    return lens;
}

/* The mean lens in 20 bits; differences below 2^22. */
typedef struct mean_lens {
    const uint32_t *sum; /* of its middle */
    int32_t n, down;
} mean_lens;

static int32_t at(const mean_lens *m, int32_t x, int32_t y)
{
    return (int32_t)(m->sum[y * m->n + x] >> m->down);
}

/* Four times the gradient's odd part. */
static int32_t odd_x(const mean_lens *m, int32_t x, int32_t y)
{
    return at(m, x + 1, y) - at(m, x - 1, y) - at(m, 1 - x, -y) + at(m, -1 - x, -y);
}

static int32_t odd_y(const mean_lens *m, int32_t x, int32_t y)
{
    return at(m, x, y + 1) - at(m, x, y - 1) - at(m, -x, 1 - y) + at(m, -x, -1 - y);
}

typedef struct extent { /* what the kernels are scaled by */
    int64_t even;       /* twice the mean of T */
    int32_t g, e;       /* largest magnitudes */
} extent;

static extent survey(const plfx_drift_window *w, const mean_lens *m)
{
    extent s = {0, 0, 0};
    int32_t x;
    int32_t y;

    for (y = -w->half; y <= w->half; y++) {
        for (x = -w->span[y + w->half]; x <= w->span[y + w->half]; x++) {
            s.even += at(m, x, y) + at(m, -x, -y);
        }
    }
    s.even = plfx_div_round_i64(s.even, w->cells);
    for (y = -w->half; y <= w->half; y++) {
        for (x = -w->span[y + w->half]; x <= w->span[y + w->half]; x++) {
            int32_t gx = odd_x(m, x, y);
            int32_t gy = odd_y(m, x, y);
            int32_t e = (int32_t)(at(m, x, y) + at(m, -x, -y) - s.even);
            s.g = plfx_max_i32(s.g, plfx_max_i32(gx < 0 ? -gx : gx, gy < 0 ? -gy : gy));
            s.e = plfx_max_i32(s.e, e < 0 ? -e : e);
        }
    }
    return s;
}

/* Bits to cut from |v| to stay under 2^15. */
static int32_t excess(int64_t v)
{
    return plfx_max_i32(0, v > 0 ? plfx_log2_u64((uint64_t)v) - 14 : 0);
}

typedef struct moments { /* of the 15-bit gradient; sums < 2^47, et < 2^52 */
    int64_t xx, xy, yy;
    int64_t et, ee; /* sum(E (T - mean T)), sum(E^2) */
    int64_t e;      /* sum(E): what rounding has left, < 2^17 */
    int64_t aa;     /* sum (T(x) - T(-x))^2, < 2^57 */
    int32_t g_down, e_down;
} moments;

/* Symmetric in sign: the kernels stay odd. */
static int32_t cut(int32_t v, int32_t down)
{
    return v < 0 ? -plfx_asr_i32(-v, down) : plfx_asr_i32(v, down);
}

static moments fill(plfx_drift_window *w, const mean_lens *m, const extent *s)
{
    moments q = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    int32_t x;
    int32_t y;

    q.g_down = excess(s->g);
    q.e_down = excess(s->e);
    for (y = -w->half; y <= w->half; y++) {
        for (x = -w->span[y + w->half]; x <= w->span[y + w->half]; x++) {
            int32_t k = (y + w->half) * w->n + x + w->half;
            int32_t gx = cut(odd_x(m, x, y), q.g_down);
            int32_t gy = cut(odd_y(m, x, y), q.g_down);
            int32_t e = cut((int32_t)(at(m, x, y) + at(m, -x, -y) - s->even), q.e_down);
            int64_t a = at(m, x, y) - at(m, -x, -y);
            w->kx[k] = (int16_t)gx;
            w->ky[k] = (int16_t)gy;
            w->even[k] = (int16_t)e;
            q.xx += gx * gx;
            q.xy += gx * gy;
            q.yy += gy * gy;
            q.et += (int64_t)e * (2 * at(m, x, y) - s->even);
            q.e += e;
            q.ee += e * e;
            q.aa += a * a;
        }
    }
    q.et /= 2;
    return q;
}

/* (kx,ky) = M^-1 g times det 2^-17, M in 15 bits. */
static void turn(plfx_drift_window *w, int32_t xx, int32_t xy, int32_t yy)
{
    int32_t k;

    for (k = 0; k < w->n * w->n; k++) {
        int64_t gx = w->kx[k];
        int64_t gy = w->ky[k];
        w->kx[k] = (int16_t)plfx_div_round_i64(yy * gx - xy * gy, 131072); /* < 2^14 */
        w->ky[k] = (int16_t)plfx_div_round_i64(xx * gy - xy * gx, 131072);
    }
}

int32_t plfx_drift_kernels(plfx_drift_window *w)
{
    mean_lens m = {w->sum + w->half * w->n + w->half, w->n, 0};
    extent s;
    moments q;
    int64_t det;
    int64_t gg;
    int32_t down;
    int32_t xx;
    int32_t xy;
    int32_t yy;

    m.down = plfx_max_i32(plfx_log2_u64((uint64_t)w->folded) - 3, 0);
    s = survey(w, &m);
    q = fill(w, &m, &s);
    down = excess(q.xx > q.yy ? q.xx : q.yy);
    xx = (int32_t)plfx_asr_i64(q.xx, down);
    xy = (int32_t)plfx_div_round_i64(q.xy, (int64_t)1 << down);
    yy = (int32_t)plfx_asr_i64(q.yy, down);
    det = (int64_t)xx * yy - (int64_t)xy * xy; /* < 2^30 */
    if (det < 131072 || q.et <= 0) {
        return 0;
    }
    turn(w, xx, xy, yy);
    /* sum(kx G) = det 2^(down-17), G = 4 g 2^-g_down */
    gg = (down >= 17 ? det << (down - 17) : plfx_asr_i64(det, 17 - down))
         << q.g_down; /* < 2^52 */
    w->to_px_q16 = plfx_sat_i32(plfx_drift_ratio(q.et, gg, 18));
    w->level = (q.et << m.down) / w->folded;
    w->even_sum = q.e;
    w->even_norm = plfx_isqrt_u64((uint64_t)q.ee);
    /* 128 aa / (cells sum G^2): 16 neighbours count as one sample */
    w->asymmetry_q40 = plfx_drift_ratio(
        q.aa / w->cells, ((q.xx < q.yy ? q.xx : q.yy) << (2 * q.g_down)) + 1, 47);
    return 1;
}

typedef struct sums { /* of a lens, < 2^48 */
    int64_t x, y, e;
    uint64_t v, vv;
} sums;

static sums project(const plfx_drift_window *w)
{
    sums s = {0, 0, 0, 0, 0};
    int32_t x;
    int32_t y;

    for (y = 0; y < w->n; y++) {
        const int32_t span = w->span[y];
        const int32_t k = y * w->n + w->half;
        for (x = -span; x <= span; x++) {
            const int32_t v = w->px[k + x];
            s.x += (int64_t)w->kx[k + x] * v;
            s.y += (int64_t)w->ky[k + x] * v;
            s.e += (int64_t)w->even[k + x] * v;
            s.v += (uint32_t)v;
            s.vv += (uint64_t)(uint32_t)v * (uint32_t)v;
        }
    }
    return s;
}

/* A sum in pixels.  The ratio is under a quarter for displacements of a spot's
 * width. */
static int32_t scaled(const plfx_drift_window *w, int64_t n, int64_t e)
{
    int64_t q = plfx_sat_i32(plfx_drift_ratio(-n, e, 20));

    return plfx_sat_i32(plfx_asr_i64(q * w->to_px_q16 + 32768, 16)); /* < 2^62 */
}

plfx_drift_lens plfx_drift_match(const plfx_drift_window *w)
{
    plfx_drift_lens lens = {0, 0, 0};
    sums s = project(w);
    uint64_t mean = s.v / (uint64_t)w->cells;
    /* < 2^49: the mean cut to an integer adds cells at most */
    uint64_t spread = s.vv - mean * s.v;
    uint64_t norm = (uint64_t)w->even_norm * plfx_isqrt_u64(spread); /* < 2^49 */

    s.e -= w->even_sum * (int64_t)mean;
    if (s.e * DIM <= w->level || (uint64_t)s.e * 10u < norm * 3u) {
        return lens; /* dark, or correlation with E under 0.3 */
    }
    lens.dx_q20 = scaled(w, s.x, s.e);
    lens.dy_q20 = scaled(w, s.y, s.e);
    lens.ok = 1;
    return lens;
}
