/* SPDX-License-Identifier: MIT
 * Regions: configuration, workspace, rest frames. */
#include "plenofix/roi.h"
#include "arena.h"
#include "fix.h"
#include "roi_state.h"
#include "sure.h"

#include <string.h>

#define OFFSET_MAX 32767

PLFX_STATIC_ASSERT(sizeof(plfx_roi_patch) <= 2048u, roi_patch_fits_the_macro);

static int32_t region_ok(const plfx_roi_region *r)
{
    return r->hx >= 1 && r->hx <= PLFX_ROI_HALF_MAX && r->hy >= 1 &&
           r->hy <= PLFX_ROI_HALF_MAX && r->i >= -PLFX_LENSES_MAX &&
           r->i <= 2 * PLFX_LENSES_MAX && r->j >= -PLFX_LENSES_MAX &&
           r->j <= 2 * PLFX_LENSES_MAX && r->reference <= 1;
}

static int32_t source_ok(const plfx_roi_cfg *c)
{
    if (c->lut) {
        return c->tone.dx_q8 >= -256 && c->tone.dx_q8 <= 256 && c->tone.dy_q8 >= -256 &&
               c->tone.dy_q8 <= 256 && c->views >= 1 && c->views <= PLFX_VIEWS_MAX;
    }
    return c->views == 1 && c->nx >= 1 && c->nx <= OFFSET_MAX && c->ny >= 1 &&
           c->ny <= OFFSET_MAX && c->bits >= 8 && c->bits <= 16;
}

static int32_t cfg_ok(const plfx_roi_cfg *c)
{
    int32_t ok = c && source_ok(c) && c->regions >= 1 && c->regions <= PLFX_ROI_MAX &&
                 c->rest >= 1 && c->rest <= PLFX_ROI_REST_MAX && c->steps >= 1 &&
                 c->steps <= PLFX_ROI_STEPS_MAX && c->seek >= 0 &&
                 c->seek <= PLFX_ROI_SEEK_MAX && c->residual_q8 >= 256 &&
                 c->residual_q8 <= 65535;
    int32_t k;

    for (k = 0; ok && k < c->regions; k++) {
        ok = region_ok(&c->region[k]);
    }
    return ok;
}

static int32_t gained(const plfx_roi_cfg *c)
{
    return c->lut && c->white && c->lut->gain.length > 0;
}

/* Lay patch k out; `p` NULL measures. */
static void carve_patch(const plfx_roi_cfg *c, int32_t k, plfx_roi_patch *p,
                        plfx_arena *a)
{
    size_t w = 2u * (size_t)c->region[k].hx + 1u;
    size_t h = 2u * (size_t)c->region[k].hy + 1u;
    size_t n = w * h * (size_t)c->views;
    size_t wide =
        (w + 2u * PLFX_ROI_MARGIN) * (h + 2u * PLFX_ROI_MARGIN) * (size_t)c->views;
    uint16_t *sums = plfx_take(a, wide, sizeof(uint16_t));
    uint16_t *gain = gained(c) ? plfx_take(a, wide, sizeof(uint16_t)) : NULL;
    uint16_t *ref = plfx_take(a, n, sizeof(uint16_t));
    int16_t *gx = plfx_take(a, n, sizeof(int16_t));
    int16_t *gy = plfx_take(a, n, sizeof(int16_t));

    if (p) {
        memset(p, 0, sizeof *p);
        p->wide = sums;
        p->gain = gain;
        p->ref = ref;
        p->gx = gx;
        p->gy = gy;
        p->w = (int32_t)w;
        p->h = (int32_t)h;
        p->i0 = c->region[k].i - c->region[k].hx;
        p->j0 = c->region[k].j - c->region[k].hy;
        memset(sums, 0, wide * sizeof *sums);
    }
}

/* Lenses of the largest region. */
static size_t largest(const plfx_roi_cfg *c)
{
    size_t most = 0;
    int32_t k;

    for (k = 0; k < c->regions; k++) {
        size_t n =
            (2u * (size_t)c->region[k].hx + 1u) * (2u * (size_t)c->region[k].hy + 1u);
        most = n > most ? n : most;
    }
    return most;
}

static size_t carve(const plfx_roi_cfg *c, plfx_roi *roi, void *ws)
{
    plfx_arena a = {ws, 0};
    plfx_roi_patch *patch = plfx_take(&a, (size_t)c->regions, sizeof(plfx_roi_patch));
    uint16_t *row =
        gained(c) ? plfx_take(&a, (size_t)c->lut->lattice.nx, sizeof(uint16_t)) : NULL;
    int32_t *lens = plfx_take(&a, largest(c), sizeof(int32_t));
    int32_t k;

    for (k = 0; k < c->regions; k++) {
        carve_patch(c, k, patch ? &patch[k] : NULL, &a);
    }
    if (roi) {
        roi->patch = patch;
        roi->row = row;
        roi->lens = lens;
    }
    return a.used;
}

size_t plfx_roi_ws(const plfx_roi_cfg *cfg)
{
    return cfg_ok(cfg) ? carve(cfg, NULL, NULL) : 0u;
}

/* Length of a step, q16 px. */
static int64_t length_q16(plfx_vec_q22 v)
{
    int64_t x = plfx_asr_i32(v.x_q22, 6);
    int64_t y = plfx_asr_i32(v.y_q22, 6);

    return (int64_t)plfx_roi_root((uint64_t)(x * x + y * y));
}

/* Displacement of each view a unit of slope at the rim. */
static void lean(plfx_roi *roi)
{
    int32_t k;

    for (k = 0; k < roi->cfg.views; k++) {
        plfx_offset o = roi->cfg.at[k];
        roi->rim_q8 = plfx_max_i32(roi->rim_q8, plfx_max_i32(o.u_q8, -o.u_q8));
        roi->rim_q8 = plfx_max_i32(roi->rim_q8, plfx_max_i32(o.v_q8, -o.v_q8));
    }
    for (k = 0; k < roi->cfg.views && roi->rim_q8 > 0; k++) {
        roi->lean_q12[k][0] = roi->cfg.at[k].u_q8 * roi->col_q12 / roi->rim_q8;
        roi->lean_q12[k][1] = roi->cfg.at[k].v_q8 * roi->row_q12 / roi->rim_q8;
    }
}

static void geometry(plfx_roi *roi)
{
    const plfx_lut *lut = roi->cfg.lut;
    int32_t k;

    roi->col_q12 = 4096;
    roi->row_q12 = 4096;
    if (lut) {
        int64_t pitch = plfx_lut_pitch_q16(lut);
        roi->col_q12 = (int32_t)(pitch * 4096 / length_q16(lut->lattice.a));
        roi->row_q12 = (int32_t)(pitch * 4096 / length_q16(lut->lattice.b));
        roi->cfg.nx = lut->lattice.nx;
        roi->cfg.ny = lut->lattice.ny;
        for (k = 0; k < roi->cfg.views; k++) {
            roi->shift[k] = plfx_view_offset(lut, roi->cfg.at[k]);
            roi->shift[k].x_q16 += 256 * roi->cfg.tone.dx_q8;
            roi->shift[k].y_q16 += 256 * roi->cfg.tone.dy_q8;
        }
        lean(roi);
    }
}

/* Gains around a patch. */
static void fill_gains(plfx_roi *roi, plfx_roi_patch *p)
{
    int32_t w = p->w + 2 * PLFX_ROI_MARGIN;
    int32_t h = p->h + 2 * PLFX_ROI_MARGIN;
    int32_t k;
    int32_t y;

    for (k = 0; k < roi->cfg.views; k++) {
        for (y = 0; y < h; y++) {
            plfx_offset o = roi->cfg.at[k];
            plfx_sure(plfx_lut_gain_row(roi->cfg.lut, p->j0 + y - PLFX_ROI_MARGIN,
                                        o.u_q8, o.v_q8, roi->row));
            /* NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): has gains */
            memcpy(p->gain + (size_t)(k * h + y) * (size_t)w,
                   roi->row + (p->i0 - PLFX_ROI_MARGIN), (size_t)w * sizeof *roi->row);
        }
    }
}

static void start_patch(plfx_roi *roi, plfx_roi_patch *p)
{
    const int32_t m = PLFX_ROI_MARGIN;

    if (p->i0 < m || p->j0 < m || p->i0 + p->w + m > roi->cfg.nx ||
        p->j0 + p->h + m > roi->cfg.ny) {
        p->flags = PLFX_ROI_EDGE;
    } else if (p->gain) {
        fill_gains(roi, p);
    }
}

plfx_status plfx_roi_init(plfx_roi *roi, const plfx_roi_cfg *cfg, void *ws,
                          size_t ws_size)
{
    int32_t k;

    if (!roi || !cfg_ok(cfg) || !ws) {
        return PLFX_E_ARG;
    }
    if (cfg->lut && cfg->lut->lattice.kind != PLFX_LATTICE_SQUARE) {
        return PLFX_E_RANGE;
    }
    if (!plfx_aligned(ws) || ws_size < plfx_roi_ws(cfg)) {
        return PLFX_E_SIZE;
    }
    memset(roi, 0, sizeof *roi);
    roi->cfg = *cfg;
    (void)carve(cfg, roi, ws);
    geometry(roi);
    for (k = 0; k < cfg->regions; k++) {
        start_patch(roi, &roi->patch[k]);
    }
    return PLFX_OK;
}

/* Add a frame's samples, cut to 12 bits. */
static void add_rest(const plfx_roi *roi, const plfx_roi_frame *frame,
                     plfx_roi_patch *p)
{
    uint16_t row[PLFX_ROI_WIDE];
    int32_t w = p->w + 2 * PLFX_ROI_MARGIN;
    int32_t h = p->h + 2 * PLFX_ROI_MARGIN;
    uint64_t square = 0;
    int32_t k;
    int32_t y;
    int32_t x;

    for (k = 0; k < roi->cfg.views; k++) {
        for (y = 0; y < h; y++) {
            uint16_t *sum = p->wide + (size_t)(k * h + y) * (size_t)w;
            plfx_roi_sample(roi, frame, p, k, y - PLFX_ROI_MARGIN, -PLFX_ROI_MARGIN, w,
                            row);
            for (x = 0; x < w; x++) {
                uint32_t v = ((uint32_t)row[x] + 8u) >> 4;
                v = v < 4095u ? v : 4095u;
                sum[x] = (uint16_t)(sum[x] + v);
                if (plfx_roi_within(p, x, y)) {
                    square += (uint64_t)v * v;
                }
            }
        }
    }
    p->rest_square += (int64_t)square;
}

static void complete(const plfx_roi *roi, plfx_roi_patch *p)
{
    if (!p->flags) {
        plfx_roi_learn(roi, p);
    }
    if (!p->flags) {
        plfx_roi_inform(roi, p);
    }
    if (!p->flags) {
        plfx_roi_tabulate(roi, p);
    }
}

plfx_status plfx_roi_rest(plfx_roi *roi, const plfx_roi_frame *frame)
{
    plfx_status status;
    int32_t k;

    if (!roi || !roi->patch) {
        return PLFX_E_ARG;
    }
    if (roi->rested >= roi->cfg.rest) {
        return PLFX_E_STATE;
    }
    status = plfx_roi_frame_ok(roi, frame);
    if (status != PLFX_OK) {
        return status;
    }
    for (k = 0; k < roi->cfg.regions; k++) {
        if (!roi->patch[k].flags) {
            add_rest(roi, frame, &roi->patch[k]);
        }
    }
    roi->rested++;
    for (k = 0; roi->rested == roi->cfg.rest && k < roi->cfg.regions; k++) {
        complete(roi, &roi->patch[k]);
    }
    return PLFX_OK;
}

plfx_status plfx_roi_aim(plfx_roi *roi, int32_t k, int32_t di, int32_t dj)
{
    if (!roi || !roi->patch || k < 0 || k >= roi->cfg.regions ||
        di < -PLFX_LENSES_MAX || di > PLFX_LENSES_MAX || dj < -PLFX_LENSES_MAX ||
        dj > PLFX_LENSES_MAX) {
        return PLFX_E_ARG;
    }
    roi->patch[k].ki = di;
    roi->patch[k].kj = dj;
    return PLFX_OK;
}
