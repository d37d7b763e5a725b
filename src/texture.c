/* SPDX-License-Identifier: MIT
 * Texture of the reference view: window sum of |backward differences| along the axes on
 * which the plan's views lie apart. */
#include "sweep_state.h"
#include "fix.h"

static int32_t uses_u(const plfx_plan *p)
{
    int32_t k;

    for (k = 0; k < p->cfg.n; k++) {
        if (p->du_q8[k] != 0) {
            return 1;
        }
    }
    return 0;
}

static int32_t uses_v(const plfx_plan *p)
{
    int32_t k;

    for (k = 0; k < p->cfg.n; k++) {
        if (p->dv_q8[k] != 0) {
            return 1;
        }
    }
    return 0;
}

static uint32_t apart(uint16_t a, uint16_t b)
{
    return a > b ? (uint32_t)a - b : (uint32_t)b - a;
}

void plfx_texture_row(const plfx_sweep_state *s, int32_t y, int32_t sign)
{
    const uint16_t *a = plfx_ref_row(s, y);
    const uint16_t *above = plfx_ref_row(s, y > 0 ? y - 1 : 0);
    uint32_t u = (uint32_t)uses_u(s->plan);
    uint32_t v = (uint32_t)uses_v(s->plan);
    int32_t i;

    for (i = 0; i < s->plan->nx; i++) {
        uint32_t d =
            v * apart(a[i], above[i]) + (i > 0 ? u * apart(a[i], a[i - 1]) : 0u);
        s->tex_col[i] += (uint32_t)sign * d;
    }
}

void plfx_texture_sums(const plfx_sweep_state *s)
{
    int32_t w = s->plan->cfg.window;
    uint32_t sum = 0;
    int32_t i;

    for (i = 0; i < s->plan->nx; i++) {
        sum += s->tex_col[i];
        if (i >= w) {
            sum -= s->tex_col[i - w];
        }
        if (i >= w - 1) {
            s->tex[i - w / 2] = sum; /* 961 * 2 * 4095 < 2^23 */
        }
    }
}
