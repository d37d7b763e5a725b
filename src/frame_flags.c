/* SPDX-License-Identifier: MIT
 * Why a sample of a frame is weak, beside what aggregation and refinement found. */
#include "frame_state.h"
#include "fix.h"

/* Largest and least share of a direction among the views in use. */
typedef struct reach {
    int32_t low, high;
} reach;

static reach reach_of(const plfx_frame_state *s, const int32_t *share)
{
    reach r = {0, 0};
    int32_t k;

    for (k = 0; k < s->n; k++) {
        if (s->arm_of[k] >= 0) {
            r.low = plfx_min_i32(r.low, share[k]);
            r.high = plfx_max_i32(r.high, share[k]);
        }
    }
    return r;
}

/* Does a window around x, displaced by e in some view, leave 0 .. n-1? */
static int32_t leaves(int32_t x, int32_t r, int32_t n, int64_t e_q16, reach share)
{
    int64_t a = e_q16 * share.low;
    int64_t b = e_q16 * share.high;
    int64_t least = plfx_asr_i64(a < b ? a : b, 32);
    int64_t most = -plfx_asr_i64(-(a < b ? b : a), 32);

    return x - r + least < 0 || x + r + most > n - 1;
}

void plfx_frame_axes(const plfx_frame_state *s, const uint8_t *u, const uint8_t *v,
                     uint8_t *flags)
{
    int32_t x;

    for (x = 0; x < s->nx; x++) {
        int32_t d = u[x] - v[x];
        uint32_t apart = d > 1 || d < -1 ? PLFX_FLAG_OCCLUDED : 0u;
        flags[x] = (uint8_t)(flags[x] | apart);
    }
}

/* Mean |dx| + |dy| of texture that can be matched, counts of 12 bits in sixteenths: the
 * plan's, or 1.3 times what noise alone makes (4/sqrt(pi) of it a lens, 0.489 of it
 * when views are smoothed). */
static int64_t least_texture(const plfx_frame_state *s)
{
    int64_t plan = (int64_t)s->plan->cfg.texture << (12 - s->plan->cfg.bits);
    int64_t noise = (int64_t)s->cfg.noise_q4 * (s->smooth ? 10 : 47);

    return plan > noise ? plan : noise;
}

/* Sum of |differences| over the window.  Rows are summed until they reach it. */
static int32_t flat(const plfx_frame_state *s, int64_t least, int32_t x, int32_t y)
{
    int32_t w = s->plan->cfg.window;
    int64_t limit = least * w * w;
    int64_t sum = 0;
    int32_t i;
    int32_t j;

    for (j = y - w / 2; j <= y + w / 2 && 16 * sum < limit; j++) {
        const uint16_t *a =
            plfx_frame_line(s, s->plan->cfg.ref, plfx_clamp_i32(j, 0, s->ny - 1));
        const uint16_t *b =
            plfx_frame_line(s, s->plan->cfg.ref, plfx_clamp_i32(j - 1, 0, s->ny - 1));
        for (i = x - w / 2; i <= x + w / 2; i++) {
            int32_t k = plfx_clamp_i32(i, 0, s->nx - 1);
            int32_t dx = a[k] - a[k - 1];
            int32_t dy = a[k] - b[k];
            sum += (dx < 0 ? -dx : dx) + (dy < 0 ? -dy : dy);
        }
    }
    return 16 * sum < limit;
}

void plfx_frame_flags(const plfx_frame_state *s, const plfx_frame_out *row, int32_t y)
{
    const plfx_cfg *c = &s->plan->cfg;
    reach rx = reach_of(s, s->bx_q16);
    reach ry = reach_of(s, s->by_q16);
    int64_t least = least_texture(s);
    int32_t r = c->window / 2;
    int32_t x;

    for (x = 0; x < s->nx; x++) {
        uint32_t f = row->flags[x];
        int64_t e = row->e[x];
        if (leaves(x, r, s->nx, e, rx) || leaves(y, r, s->ny, e, ry)) {
            f |= PLFX_FLAG_EDGE;
        }
        f |= row->raw[x] >= row->top ? PLFX_FLAG_SATURATED : 0u;
        f |= row->conf[x] < c->unique_u16 ? PLFX_FLAG_UNIQUE : 0u;
        f |= c->texture && flat(s, least, x, y) ? PLFX_FLAG_TEXTURE : 0u;
        row->flags[x] = (uint8_t)f;
    }
}
