/* SPDX-License-Identifier: MIT
 * plfx_drift_find() on drawn frames of a lattice that has moved from its exact table:
 * error over stated 1-sigma.  Exit 1 when an error is over 4 sigma or a kind is not
 * measured. */
#define _POSIX_C_SOURCE 200809L
#include "draw.h"

#include "calib/lattice.h"
#include "common/table.h"
#include "plenofix/drift.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define Q20 1048576.0
#define Q30 1073741824.0

typedef struct move {
    double x, y, turn, grow;
} move;

static int misses;

/* The drawn lattice as a table; aborts when it cannot be written. */
static uint8_t *table_of(const draw_frame *f, const draw_spec *s, plfx_lut *lut)
{
    const double *p = f->xy;
    plft_lattice l;
    plfx_lut_desc d;
    uint8_t *blob;
    size_t n;

    memset(&l, 0, sizeof l);
    memset(&d, 0, sizeof d);
    l.kind = s->hex ? PLFX_LATTICE_HEX : PLFX_LATTICE_SQUARE;
    l.nx = s->nx;
    l.ny = s->ny;
    l.origin.x = p[0];
    l.origin.y = p[1];
    l.a.x = (p[2 * (s->nx - 1)] - p[0]) / (s->nx - 1);
    l.a.y = (p[2 * (s->nx - 1) + 1] - p[1]) / (s->nx - 1);
    l.b.x = (p[4 * s->nx] - p[0]) / 2.0;
    l.b.y = (p[4 * s->nx + 1] - p[1]) / 2.0;
    l.odd.x = p[2 * s->nx] - p[0] - l.b.x;
    l.odd.y = p[2 * s->nx + 1] - p[1] - l.b.y;
    d.sensor_w = f->w;
    d.sensor_h = f->h;
    d.sensor_bits = s->bits;
    n = plft_lattice_quantise(&l, &d.lattice) == 0 ? plfx_lut_bytes(&d) : 0;
    blob = malloc(n + 1);
    if (n == 0 || blob == NULL || plfx_lut_write(&d, blob, n) != PLFX_OK ||
        plfx_lut_open(lut, blob, n) != PLFX_OK) {
        abort();
    }
    return blob;
}

typedef struct outcome {
    plfx_drift d;
    double chi[4]; /* error over sigma: x, y, turn, grow */
    double seconds;
} outcome;

static void run(const draw_spec *still, const move *m, outcome *o)
{
    draw_spec s = *still;
    draw_frame f, g;
    plfx_lut lut;
    plfx_raw raw;
    uint8_t *blob;
    void *ws;
    size_t need;
    clock_t start;

    draw(&f, still);
    blob = table_of(&f, still, &lut);
    s.shift_x = m->x;
    s.shift_y = m->y;
    s.turn = m->turn;
    s.grow = m->grow;
    s.seed += 1000;
    draw(&g, &s);
    raw.bytes = (const uint8_t *)g.px;
    raw.size = (size_t)g.w * (size_t)g.h * 2u;
    raw.format = PLFX_RAW_U16;
    raw.bits = (uint8_t)s.bits;
    raw.w = g.w;
    raw.h = g.h;
    need = plfx_drift_ws(&lut);
    if (posix_memalign(&ws, PLFX_ALIGN, need) != 0) {
        abort();
    }
    start = clock();
    if (plfx_drift_find(&lut, &raw, 512, ws, need, &o->d) != PLFX_OK) {
        abort();
    }
    o->seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    o->chi[0] = (o->d.shift_x_q20 / Q20 - m->x) / (o->d.shift_sigma_q20 / Q20 + 1e-9);
    o->chi[1] = (o->d.shift_y_q20 / Q20 - m->y) / (o->d.shift_sigma_q20 / Q20 + 1e-9);
    o->chi[2] =
        (o->d.rotation_q30 / Q30 - m->turn) / (o->d.rotation_sigma_q30 / Q30 + 1e-9);
    o->chi[3] = (o->d.scale_q30 / Q30 - m->grow) / (o->d.scale_sigma_q30 / Q30 + 1e-9);
    free(ws);
    free(blob);
    draw_free(&f);
    draw_free(&g);
}

static const draw_spec plain = {DRAW_DOTS, 0,   60,    40,  15.0, 0.0, 20.3, 19.7, 1.6,
                                8,         0.8, 0.004, 0.0, 0.0,  0.0, 1.0,  0.0,  1,
                                0.0,       0.0, 0.0,   0.0, 0.0,  0.0, 0.0};

static const move moves[] = {{0.0, 0.0, 0.0, 0.0},     {0.01, -0.02, 0.0, 0.0},
                             {0.1, 0.05, 1e-5, 0.0},   {-0.4, 0.3, 0.0, 5e-5},
                             {1.0, -1.0, 2e-4, -1e-4}, {-2.0, 1.5, 0.0, 0.0},
                             {2.0, 2.0, 1e-3, 5e-4},   {0.0, 0.0, -3e-3, 0.0}};

static void kind(const char *title, const draw_spec *spec)
{
    const int n = (int)(sizeof moves / sizeof moves[0]);
    double sum[4] = {0}, worst = 0.0, shift = 0.0;
    int k, i, measured = 0;
    outcome o;

    for (k = 0; k < n; k++) {
        draw_spec s = *spec;
        s.seed += (unsigned)k;
        run(&s, &moves[k], &o);
        if (o.d.state == PLFX_DRIFT_MEASURED) {
            measured++;
            shift += o.d.shift_sigma_q20 / Q20;
            for (i = 0; i < 4; i++) {
                sum[i] += o.chi[i] * o.chi[i];
                worst = fmax(worst, fabs(o.chi[i]));
            }
        }
    }
    printf(
        "%-34s %d of %d  sigma %.5f px  error/sigma: shift %.2f %.2f turn %.2f scale "
        "%.2f worst %.1f  %.0f ms\n",
        title, measured, n, shift / measured, sqrt(sum[0] / measured),
        sqrt(sum[1] / measured), sqrt(sum[2] / measured), sqrt(sum[3] / measured),
        worst, 1000.0 * o.seconds);
    misses += worst > 4.0 || measured < n;
}

int main(void)
{
    static const char *const spots[3] = {"dots", "soft white", "hard white"};
    draw_spec s;
    char title[64];
    int spot, hex, k;

    for (spot = 0; spot < 3; spot++) {
        for (hex = 0; hex < 2; hex++) {
            for (k = 0; k < 2; k++) {
                s = plain;
                s.spot = (draw_spot)spot;
                s.nx = 36;
                s.ny = 28;
                s.hex = hex;
                s.pitch = k ? 15.0 : 13.37;
                s.rotation = k ? 0.0 : 0.4;
                snprintf(title, sizeof title, "%s %s %.2f px", spots[spot],
                         hex ? "hex" : "square", s.pitch);
                kind(title, &s);
            }
        }
    }
    s = plain;
    s.hot = 0.01;
    s.dead = 0.02;
    s.gradient = 3.0;
    s.black = 0.2;
    s.level = 0.25;
    kind("dots, 6 bits, hot, dead, uneven", &s);
    for (k = 0; k < 4; k++) {
        static const double slope[4] = {0.0, 0.05, -0.15, 0.3};
        s = plain;
        s.spot = DRAW_FLAT;
        s.nx = 36;
        s.ny = 28;
        s.scene = 0.9;
        s.pitch = 14.2;
        s.rotation = 0.2;
        s.slope = slope[k];
        snprintf(title, sizeof title, "scene, slope %.2f", slope[k]);
        kind(title, &s);
    }
    printf("%d missed\n", misses);
    return misses != 0;
}
