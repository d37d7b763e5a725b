/* SPDX-License-Identifier: MIT */
#include "preset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/arrange.h"
#include "common/band_pass.h"
#include "common/judge.h"
#include "common/err.h"
#include "common/memory.h"
#include "plenofix/viewcheck.h"

#define RINGS      6 /* views on a ray from the centre; more are thinned out */
#define SIDE_STEPS 256

static int distance(plfx_offset a)
{
    int u = abs(a.u_q8), v = abs(a.v_q8);

    return u > v ? u : v;
}

static int centre_of(const plfx_offset *at, int n)
{
    int best = 0, k;

    for (k = 1; k < n; k++) {
        best = distance(at[k]) < distance(at[best]) ? k : best;
    }
    return best;
}

/* Rays with more than RINGS views keep those at whole multiples of a coarser step. */
static void thin_out(const plft_field *field, const plfx_offset *at, int n, int ref,
                     uint8_t *use)
{
    int unit = SIDE_STEPS * (field->scale > 0 ? field->scale : 1);
    int far = 0, step, k;

    for (k = 0; k < n; k++) {
        far = use[k] && distance(at[k]) > far ? distance(at[k]) : far;
    }
    step = (far / unit + RINGS - 1) / RINGS;
    for (k = 0; k < n && step > 1; k++) {
        use[k] = use[k] && (k == ref || distance(at[k]) % (step * unit) == 0);
    }
}

/* The reference first; at most PLFX_VIEWS_MAX. */
static int copy_views(const plfx_offset *at, int n, int ref, const uint8_t *use,
                      plfx_cfg *cfg)
{
    int base = 0, count = 1, k;

    cfg->at[0] = at[ref];
    for (k = 0; k < n && count < PLFX_VIEWS_MAX; k++) {
        if (use[k] && k != ref) {
            cfg->at[count++] = at[k];
            base = distance(at[k]) > base ? distance(at[k]) : base;
        }
    }
    cfg->n = (uint8_t)count;
    cfg->ref = 0;
    return base;
}

int plft_preset_cfg(plft_preset *p, const plft_field *field, double radius,
                    plfx_cfg *cfg)
{
    plfx_offset *at = NULL;
    uint8_t *use = NULL;
    int n = 0, ref, base = 0;
    int rc = plft_arrange_all(field, radius, &at, &n);

    use = rc == 0 ? (uint8_t *)plft_alloc((size_t)n, 1) : NULL;
    if (use != NULL) {
        ref = centre_of(at, n);
        if (plfx_preset_views(p->id, at, n, ref, use) >= 2) {
            thin_out(field, at, n, ref, use);
            base = copy_views(at, n, ref, use, cfg);
        }
    }
    free(at);
    free(use);
    if (rc != 0 || use == NULL) {
        return rc != 0 ? rc : PLFT_DATA;
    }
    if (base == 0 || plfx_preset(p->id, cfg, &p->frame) != PLFX_OK) {
        return plft_fail(PLFT_DATA, "the light field has too few views for a preset");
    }
    cfg->labels = (uint16_t)plfx_preset_labels(p->id, cfg->slope_min_q16,
                                               cfg->slope_max_q16, base);
    return 0;
}

/* Noise of the views and, when asked, the band of them that is matched. */
static int filter(plft_preset *p, int band_pass, int bits, plfx_views *views)
{
    double noise = p->noise >= 0 ? 16 * p->noise
                                 : plfx_views_noise_q4(views, bits, PLFX_VIEWS_ALL);

    noise *= band_pass ? PLFT_BAND_NOISE : 1.0;
    p->frame.noise_q4 = (uint16_t)lround(noise < 0 ? 0 : noise > 256 ? 256 : noise);
    return band_pass ? plft_band_pass(views, bits) : 0;
}

static int run(plft_preset *p, const plfx_plan *plan, const plfx_views *views,
               const uint8_t *skip, const plfx_map *map)
{
    size_t n;
    void *ws;
    plfx_status status;

    n = plfx_frame_ws(plan, &p->frame);
    ws = plft_alloc_ws(n);
    if (ws == NULL) {
        return PLFT_DATA;
    }
    status = plfx_frame(plan, &p->frame, views, skip, map, ws, n);
    free(ws);
    return status == PLFX_OK
               ? 0
               : plft_fail(PLFT_DATA, "matching failed with status %d", (int)status);
}

int plft_preset_match(plft_preset *p, const plfx_plan *plan, const plft_field *field,
                      const plfx_map *map, plft_times *times)
{
    double t0 = plft_cpu_s(), t1;
    uint8_t skip[PLFX_VIEWS_MAX];
    plft_field plain = *field; /* what is out of order is judged before the band pass */
    plfx_views views;
    int rc;

    plain.band_pass = 0;
    rc = plft_field_views(&plain, plan->cfg.at, plan->cfg.n, &views);
    t1 = plft_cpu_s();
    times->extract += t1 - t0;
    if (rc == 0) {
        rc = plft_judge_views(field, &plan->cfg, &views, skip, &p->left_out);
        rc = rc != 0 ? rc : filter(p, field->band_pass, plan->cfg.bits, &views);
        rc = rc != 0 ? rc : run(p, plan, &views, skip, map);
        free(views.px);
    }
    times->match += plft_cpu_s() - t1;
    return rc;
}
