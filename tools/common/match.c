/* SPDX-License-Identifier: MIT */
#include "common/match.h"

#include "common/device.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/err.h"
#include "common/memory.h"
#include "plenofix/gradient.h"
#include "plenofix/sweep.h"

double plft_cpu_s(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

int plft_slopes_alloc(plfx_map *map, int nx, int ny)
{
    size_t n = (size_t)nx * (size_t)ny;

    map->slope_q16 = (int32_t *)plft_alloc(n, sizeof *map->slope_q16);
    map->conf_u16 = (uint16_t *)plft_alloc(n, sizeof *map->conf_u16);
    map->sigma_u20 = (uint16_t *)plft_alloc(n, sizeof *map->sigma_u20);
    map->flags = (uint8_t *)plft_alloc(n, 1);
    map->w = nx;
    map->h = ny;
    map->stride = nx;
    if (map->slope_q16 == NULL || map->conf_u16 == NULL || map->sigma_u20 == NULL ||
        map->flags == NULL) {
        plft_slopes_free(map);
        return PLFT_DATA;
    }
    return 0;
}

void plft_slopes_free(plfx_map *map)
{
    free(map->slope_q16);
    free(map->conf_u16);
    free(map->sigma_u20);
    free(map->flags);
    memset(map, 0, sizeof *map);
}

int plft_plan(plfx_plan *plan, const plfx_cfg *cfg, const plft_field *field)
{
    int side = field->nx < field->ny ? field->nx : field->ny;

    if (cfg->window > side) {
        return plft_fail(PLFT_USAGE, "--window %d: larger than a view of %d x %d",
                         cfg->window, field->nx, field->ny);
    }
    switch (plfx_plan_init(plan, cfg, field->lut, field->nx, field->ny)) {
    case PLFX_OK:
        return 0;
    case PLFX_E_RANGE:
        return plft_fail(
            PLFT_USAGE,
            "--slopes %g:%g: moves a view farther than it is wide (%d x %d), "
            "or %d views of %d bits overflow the summed cost",
            cfg->slope_min_q16 / 65536.0 * field->scale,
            cfg->slope_max_q16 / 65536.0 * field->scale, field->nx, field->ny, cfg->n,
            cfg->bits);
    default:
        return plft_fail(PLFT_USAGE,
                         "these options do not go together: slopes %g:%g:%d, "
                         "%d views, window %d",
                         cfg->slope_min_q16 / 65536.0 * field->scale,
                         cfg->slope_max_q16 / 65536.0 * field->scale, cfg->labels,
                         cfg->n, cfg->window);
    }
}

/* May the device take the raw frame?  A white frame given at run time is divided out
 * of the views, and these are filtered, on the host. */
static int from_raw(const plfx_plan *plan, const plft_field *field)
{
    return field->device != PLFT_CPU && field->ready == NULL &&
           field->white.px == NULL && !field->band_pass &&
           field->tone.bits == plan->cfg.bits;
}

static int match_raw(const plfx_plan *plan, const plft_field *field,
                     const plfx_map *map)
{
    plft_device_frame f;

    f.lut = &field->table.lut;
    f.px = field->frame.px;
    f.bits = field->frame.bits;
    f.tone = field->tone;
    f.white = field->use_gain;
    return plft_device_raw(field->device, plan, &f, map);
}

int plft_match(const plfx_plan *plan, const plft_field *field, const plfx_map *map,
               plft_times *times)
{
    double t0 = plft_cpu_s(), t1 = t0;
    plfx_views views;
    int rc;

    if (from_raw(plan, field)) {
        rc = match_raw(plan, field, map);
    } else {
        rc = plft_field_views(field, plan->cfg.at, plan->cfg.n, &views);
        t1 = plft_cpu_s();
        times->extract += t1 - t0;
        if (rc == 0) {
            rc = plft_device_match(field->device, plan, &views, map);
            free(views.px);
        }
    }
    times->match += plft_cpu_s() - t1;
    return rc;
}

void plft_flag_lenses(const plft_field *field, const plfx_map *map)
{
    size_t i, n = (size_t)field->nx * (size_t)field->ny;

    for (i = 0; field->lens != NULL && i < n; i++) {
        if (field->lens[i] != 0) {
            map->flags[i] |= PLFX_FLAG_LENS;
        }
        if ((field->lens[i] & PLFX_LENS_MISSING) != 0) {
            map->slope_q16[i] = PLFX_SLOPE_NONE;
            map->conf_u16[i] = 0;
            map->sigma_u20[i] = PLFX_SIGMA_NONE;
        }
    }
}
