/* SPDX-License-Identifier: MIT */
#include "common/judge.h"

#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"
#include "plenofix/viewcheck.h"

static const char *words(unsigned found)
{
    return (found & PLFX_VIEW_DARK) != 0      ? "dark"
           : (found & PLFX_VIEW_CLIPPED) != 0 ? "saturated"
                                              : "unlike the others in brightness";
}

/* Every other view is measured against the centre. */
static int judge_centre(unsigned found)
{
    return (found & (PLFX_VIEW_DARK | PLFX_VIEW_CLIPPED)) == 0
               ? 0
               : plft_fail(PLFT_DATA,
                           "the centre view is %s; the others are compared with it",
                           words(found));
}

int plft_judge_views(const plft_field *field, const plfx_cfg *cfg,
                     const plfx_views *views, uint8_t *skip, int *left_out)
{
    uint32_t *work = (uint32_t *)plft_alloc(2 * (size_t)views->n, sizeof *work);
    double unit = 256.0 * (field->scale > 0 ? field->scale : 1);
    int k;

    *left_out = 0;
    if (work == NULL) {
        return PLFT_DATA;
    }
    if (plfx_views_check(views, cfg->bits, skip, work) < 0) {
        memset(skip, 0, (size_t)views->n);
    }
    free(work);
    if (judge_centre(skip[cfg->ref]) != 0) {
        return PLFT_DATA;
    }
    for (k = 0; k < views->n; k++) {
        if (skip[k] != 0) {
            plft_warn("the view at (%g, %g) is %s%s", cfg->at[k].u_q8 / unit,
                      cfg->at[k].v_q8 / unit, words(skip[k]),
                      k == cfg->ref ? "" : " and left out");
            *left_out += k != cfg->ref;
            skip[k] = k != cfg->ref;
        }
    }
    return 0;
}

/* The reference stays first. */
static void drop(plfx_cfg *cfg, const uint8_t *skip)
{
    int k, n = 0;

    for (k = 0; k < cfg->n; k++) {
        if (!skip[k]) {
            cfg->at[n++] = cfg->at[k];
        }
    }
    cfg->n = (uint8_t)n;
}

int plft_judge_ready(const plft_field *field, plfx_cfg *cfg, int *left_out)
{
    uint8_t skip[PLFX_VIEWS_MAX];
    plft_field plain = *field; /* before any band pass */
    plfx_views views;
    int rc;

    *left_out = 0;
    if (field->ready == NULL || cfg->n < 3) {
        return 0;
    }
    plain.band_pass = 0;
    rc = plft_field_views(&plain, cfg->at, cfg->n, &views);
    if (rc == 0) {
        rc = plft_judge_views(field, cfg, &views, skip, left_out);
        free(views.px);
    }
    if (rc == 0 && *left_out > 0 && cfg->method == PLFX_METHOD_GRADIENT) {
        return plft_fail(PLFT_DATA, "--method gradient needs all of its five views");
    }
    if (rc == 0) {
        drop(cfg, skip);
    }
    return rc;
}
