/* SPDX-License-Identifier: MIT */
#include "common/band_pass.h"

#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"

#define REACH 3 /* of the mean */
#define SIDE  (2 * REACH + 1)
#define BOX   (SIDE * SIDE)
#define FINE  16 /* sum of the binomial's weights */

typedef struct plane { /* a view and the sums over the rows about one of its rows */
    int nx, ny;
    uint16_t *px;
    int32_t *fine, *box; /* 4 * 4095 and 7 * 4095 at most */
} plane;

static int within(int k, int n)
{
    return k < 0 ? 0 : k >= n ? n - 1 : k;
}

static void sum_rows(const plane *p, int y)
{
    const uint16_t *mid = p->px + (size_t)y * (size_t)p->nx;
    int x, k;

    for (x = 0; x < p->nx; x++) {
        p->fine[x] = 2 * mid[x];
        p->box[x] = 0;
    }
    for (k = -REACH; k <= REACH; k++) {
        const uint16_t *row = p->px + (size_t)within(y + k, p->ny) * (size_t)p->nx;
        int near = k == -1 || k == 1;
        for (x = 0; x < p->nx; x++) {
            p->box[x] += row[x];
            p->fine[x] += near ? row[x] : 0;
        }
    }
}

/* The filter's value at column x of the summed rows, times FINE * BOX: 784 * 4095 and
 * its negative at most. */
static int32_t filtered(const plane *p, int x)
{
    int32_t fine =
        p->fine[within(x - 1, p->nx)] + 2 * p->fine[x] + p->fine[within(x + 1, p->nx)];
    int32_t box = 0;
    int k;

    for (k = -REACH; k <= REACH; k++) {
        box += p->box[within(x + k, p->nx)];
    }
    return BOX * fine - FINE * box;
}

static void filter_row(const plane *p, int y, int bits, uint16_t *to)
{
    const uint16_t *from = p->px + (size_t)y * (size_t)p->nx;
    int32_t one = FINE * BOX, full = (1 << bits) - 1;
    int x;

    sum_rows(p, y);
    for (x = 0; x < p->nx; x++) {
        int32_t v = filtered(p, x) + (one << (bits - 1)) + one / 2;
        v = v < 0 ? 0 : v / one;
        v = v < full ? v : full - 1;
        to[x] = (uint16_t)(from[x] >= full ? full : v);
    }
}

static uint16_t *row_of(const plfx_views *v, int k, int y)
{
    return v->px + ((size_t)y * (size_t)v->n + (size_t)k) * (size_t)v->nx;
}

static void filter_view(plane *p, plfx_views *v, int k, int bits)
{
    int y;

    for (y = 0; y < p->ny; y++) {
        memcpy(p->px + (size_t)y * (size_t)p->nx, row_of(v, k, y),
               (size_t)p->nx * sizeof *p->px);
    }
    for (y = 0; y < p->ny; y++) {
        filter_row(p, y, bits, row_of(v, k, y));
    }
}

int plft_band_pass(plfx_views *views, int bits)
{
    plane p = {views->nx, views->ny, NULL, NULL, NULL};
    int k, ok;

    p.px = (uint16_t *)plft_alloc((size_t)p.nx * (size_t)p.ny, sizeof *p.px);
    p.fine = (int32_t *)plft_alloc((size_t)p.nx, sizeof *p.fine);
    p.box = (int32_t *)plft_alloc((size_t)p.nx, sizeof *p.box);
    ok = p.px != NULL && p.fine != NULL && p.box != NULL;
    for (k = 0; ok && k < views->n; k++) {
        filter_view(&p, views, k, bits);
    }
    free(p.px);
    free(p.fine);
    free(p.box);
    return ok ? 0 : PLFT_DATA;
}
