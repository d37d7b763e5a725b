/* SPDX-License-Identifier: MIT */
#include "camera/whole.h"

#include <math.h>
#include <string.h>

#include "camera/picture_of.h"
#include "common/match.h"

static int open_field(const plft_whole *w, const plfx_camera_frame *frame,
                      const char *name, plft_field *field)
{
    plft_source source;
    plft_frame picture;
    int rc;

    memset(&source, 0, sizeof source);
    memset(&picture, 0, sizeof picture);
    rc = plft_picture_of(&picture, frame, name);
    source.raw = name;
    source.lut = w->lut;
    source.frame = &picture;
    source.bayer = frame->bayer;
    rc = rc != 0 ? rc : plft_field_open(field, &source);
    field->device = w->device;
    plft_frame_free(&picture);
    return rc;
}

static int fill_cfg(const plft_whole *w, const plft_field *field, plfx_cfg *c)
{
    plft_views_wish wish = w->wish;
    double full = (double)((1 << field->bits) - 1);
    double texture = 0;
    int sweep = wish.method == PLFT_SWEEP;
    int n = 0;
    int rc = plft_find_texture(field, wish.u_only || wish.method == PLFT_BINOCULAR,
                               &texture);

    rc = rc != 0 ? rc : plft_arrange(field, &wish, c->at, &n);
    c->n = (uint8_t)n;
    c->method = (uint8_t)(sweep                          ? PLFX_METHOD_SWEEP
                          : wish.method == PLFT_GRADIENT ? PLFX_METHOD_GRADIENT
                                                         : PLFX_METHOD_PAIRS);
    c->cost = (uint8_t)(sweep ? PLFX_COST_SAD : PLFX_COST_ZNCC);
    c->fit = (uint8_t)(sweep ? PLFX_FIT_VEE : PLFX_FIT_PARABOLA);
    c->fuse = PLFX_FUSE_MEDIAN;
    c->window = (uint8_t)(w->window != 0 ? w->window : plft_own_window(field));
    c->bits = (uint8_t)field->bits;
    c->texture = (uint16_t)lround(texture / 1000.0 * full * 16.0);
    c->slope_min_q16 = (int32_t)lround(w->lo * 65536.0);
    c->slope_max_q16 = (int32_t)lround(w->hi * 65536.0);
    c->labels = (uint16_t)w->labels;
    return rc;
}

int plft_whole_map(const plft_whole *w, const plfx_camera_frame *frame,
                   const char *name, const plfx_map *map)
{
    plft_field field;
    plft_times times;
    plfx_cfg cfg;
    plfx_plan plan;
    int rc;

    memset(&field, 0, sizeof field);
    memset(&times, 0, sizeof times);
    memset(&cfg, 0, sizeof cfg);
    rc = open_field(w, frame, name, &field);
    rc = rc != 0 ? rc : fill_cfg(w, &field, &cfg);
    rc = rc != 0 ? rc : plft_plan(&plan, &cfg, &field);
    rc = rc != 0 ? rc : plft_match(&plan, &field, map, &times);
    if (rc == 0) {
        plft_flag_lenses(&field, map);
    }
    plft_field_free(&field);
    return rc;
}
