/* SPDX-License-Identifier: MIT
 * White gains: a profile over the micro-image, different from zone to zone of the
 * array, times one number a lens. */
#include "lut_format.h"
#include "lut_rows.h"
#include "bytes.h"
#include "fix.h"

typedef struct profile { /* where an offset falls in every zone's profile */
    const uint8_t *zones;
    uint32_t zx, zy, side;
    uint32_t at;     /* element of the cell's first corner */
    uint32_t fu, fv; /* q8 */
} profile;

static profile open_profile(const plfx_lut *lut, int32_t u_q8, int32_t v_q8)
{
    const uint8_t *p = lut->blob + lut->gain.offset;
    int32_t r = (int32_t)plfx_get_u16(p + 4);
    int32_t u = plfx_clamp_i32(u_q8, -256 * r, 256 * r) + 256 * r;
    int32_t v = plfx_clamp_i32(v_q8, -256 * r, 256 * r) + 256 * r;
    int32_t cu = plfx_min_i32(u / 256, 2 * r - 1);
    int32_t cv = plfx_min_i32(v / 256, 2 * r - 1);
    profile q;

    q.zones = p + LUT_GAIN_HEAD;
    q.zx = plfx_get_u16(p);
    q.zy = plfx_get_u16(p + 2);
    q.side = (uint32_t)(2 * r + 1);
    q.at = (uint32_t)cv * q.side + (uint32_t)cu;
    q.fu = (uint32_t)(u - 256 * cu);
    q.fv = (uint32_t)(v - 256 * cv);
    return q;
}

/* Profile of zone (a,b) at the offset: bilinear, 16 bits in, 16 bits out. */
static uint32_t zone(const profile *q, uint32_t a, uint32_t b)
{
    const uint8_t *p = q->zones + 2 * ((b * q->zx + a) * q->side * q->side + q->at);
    const uint8_t *n = p + 2 * q->side;
    uint32_t top = plfx_get_u16(p) * (256u - q->fu) + plfx_get_u16(p + 2) * q->fu;
    uint32_t low = plfx_get_u16(n) * (256u - q->fu) + plfx_get_u16(n + 2) * q->fu;

    return (
        uint32_t)(((uint64_t)top * (256u - q->fv) + (uint64_t)low * q->fv + 32768u) >>
                  16);
}

typedef struct place {         /* between which zones a lens stands */
    uint32_t first, second, f; /* f q8 */
} place;

/* Zone centres stand at (k + 1/2)*n/zones lenses; outside them the nearest holds. */
static place between(int32_t i, int32_t n, uint32_t zones)
{
    int32_t at = ((2 * i + 1) * (int32_t)zones * 128) / n - 128; /* q8 zones, < 2^21 */
    int32_t k = plfx_clamp_i32(plfx_asr_i32(at, 8), 0, (int32_t)zones - 1);
    place p;

    p.first = (uint32_t)k;
    p.second = (uint32_t)plfx_min_i32(k + 1, (int32_t)zones - 1);
    p.f = (uint32_t)plfx_clamp_i32(at - 256 * k, 0, 256);
    return p;
}

static uint32_t mix(uint32_t a, uint32_t b, uint32_t f)
{
    return (a * (256u - f) + b * f + 128u) >> 8;
}

static uint32_t column(const profile *q, uint32_t a, place y)
{
    return mix(zone(q, a, y.first), zone(q, a, y.second), y.f);
}

static void fill(const plfx_lut *lut, int32_t j, const profile *q, uint16_t *gain)
{
    int32_t nx = lut->lattice.nx;
    size_t zones = (size_t)q->zx * q->zy * q->side * q->side;
    const uint8_t *lens = plfx_lut_gains_row(lut, j, q->zones + 2 * zones);
    place y = between(j, lut->lattice.ny, q->zy);
    uint32_t at = q->zx; /* zone whose columns left, right are at hand */
    uint32_t left = 0;
    uint32_t right = 0;
    int32_t i;

    for (i = 0; i < nx; i++) {
        place x = between(i, nx, q->zx);
        uint32_t g;
        if (x.first != at) {
            left = column(q, x.first, y);
            right = column(q, x.second, y);
            at = x.first;
        }
        g = (mix(left, right, x.f) * plfx_get_u16(lens + 2 * i) + 4096u) >> 13;
        gain[i] = (uint16_t)(g > 65535u ? 65535u : g);
    }
}

plfx_status plfx_lut_gain_row(const plfx_lut *lut, int32_t j, int16_t u_q8,
                              int16_t v_q8, uint16_t *gain_u13)
{
    int32_t i;

    if (!lut || !gain_u13 || j < 0 || j >= lut->lattice.ny) {
        return PLFX_E_ARG;
    }
    if (lut->gain.length) {
        profile q = open_profile(lut, u_q8, v_q8);
        fill(lut, j, &q, gain_u13);
        return PLFX_OK;
    }
    for (i = 0; i < lut->lattice.nx; i++) {
        gain_u13[i] = 8192u;
    }
    return PLFX_OK;
}
