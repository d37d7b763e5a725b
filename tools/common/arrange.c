/* SPDX-License-Identifier: MIT */
#include "common/arrange.h"

#include <math.h>
#include <stdlib.h>

#include "common/err.h"
#include "common/memory.h"

typedef struct list {
    const plft_field *field;
    plfx_offset *at;
    int n;
} list;

static void add(list *l, double u, double v)
{
    plfx_offset o = plft_field_offset(l->field, u, v);
    int k;

    for (k = 0; k < l->n; k++) {
        if (l->at[k].u_q8 == o.u_q8 && l->at[k].v_q8 == o.v_q8) {
            return;
        }
    }
    l->at[l->n++] = o;
}

static void add_ring(list *l, double r, int u_only)
{
    add(l, r, 0.0);
    add(l, -r, 0.0);
    if (!u_only) {
        add(l, 0.0, r);
        add(l, 0.0, -r);
    }
}

static int own_number(const plft_views_wish *w)
{
    int ring = w->u_only ? 2 : 4;

    if (w->method == PLFT_BINOCULAR) {
        return 2;
    }
    return 1 + (w->method == PLFT_GRADIENT || w->adjacent ? ring : 2 * ring);
}

static int check_number(const plft_views_wish *w)
{
    int ring = w->u_only ? 2 : 4;
    int fixed =
        w->method == PLFT_BINOCULAR || w->method == PLFT_GRADIENT || w->adjacent;

    if (fixed && w->n != own_number(w)) {
        return plft_fail(PLFT_USAGE, "--views %d: this method takes %d", w->n,
                         own_number(w));
    }
    if (w->method == PLFT_GRADIENT && w->u_only) {
        return plft_fail(PLFT_USAGE, "--axes u: the gradient method needs both axes");
    }
    if (!fixed && (w->n < 1 + ring || (w->n - 1) % ring != 0)) {
        return plft_fail(PLFT_USAGE,
                         "--views %d: want 1 + a multiple of %d: rings of %d "
                         "about the centre",
                         w->n, ring, ring);
    }
    return 0;
}

static int fill_wish(const plft_field *field, plft_views_wish *w)
{
    w->n = w->n != 0 ? w->n : own_number(w);
    w->radius = w->radius > 0.0 ? w->radius : field->radius;
    if (w->step <= 0.0) {
        w->step = fmin(fmax(1.0, w->radius / 3.0), w->radius);
        w->step = field->lut == NULL ? 1.0 : w->step;
    }
    if (w->radius > field->reach || w->step > field->reach) {
        return plft_fail(
            PLFT_USAGE,
            "--radius %g: outside the lens, whose edge is %.2f px from its "
            "centre",
            w->radius > w->step ? w->radius : w->step, field->reach);
    }
    return check_number(w);
}

int plft_arrange(const plft_field *field, plft_views_wish *w, plfx_offset *at, int *n)
{
    list l;
    int ring, k, rings, rc = fill_wish(field, w);

    if (rc != 0) {
        return rc;
    }
    l.field = field;
    l.at = at;
    l.n = 0;
    add(&l, 0.0, 0.0);
    if (w->method == PLFT_BINOCULAR) {
        add(&l, w->radius, 0.0);
    } else if (w->method == PLFT_GRADIENT) { /* the order that the core asks for */
        add(&l, -w->step, 0.0);
        add(&l, w->step, 0.0);
        add(&l, 0.0, -w->step);
        add(&l, 0.0, w->step);
    } else {
        ring = w->u_only ? 2 : 4;
        rings = w->adjacent ? 1 : (w->n - 1) / ring;
        for (k = rings; k >= 1; k--) {
            add_ring(&l, w->adjacent ? w->step : w->radius * k / rings, w->u_only);
        }
    }
    *n = l.n;
    if (l.n < 2 || (w->method == PLFT_GRADIENT && l.n != 5)) {
        return plft_fail(PLFT_DATA, "the folder has too few views for this method");
    }
    return 0;
}

static int all_ready(const plft_field *field, plfx_offset **at, int *n)
{
    int k;

    *n = field->n_ready;
    *at = (plfx_offset *)plft_alloc((size_t)*n, sizeof **at);
    if (*at == NULL) {
        return PLFT_DATA;
    }
    for (k = 0; k < *n; k++) {
        (*at)[k] = field->ready[k].at;
    }
    return 0;
}

int plft_arrange_all(const plft_field *field, double radius, plfx_offset **at, int *n)
{
    int r, u, v;

    if (field->ready != NULL) {
        return all_ready(field, at, n);
    }
    radius = radius > 0.0 ? radius : field->radius;
    if (radius > field->reach) {
        return plft_fail(
            PLFT_USAGE,
            "--radius %g: outside the lens, whose edge is %.2f px from its "
            "centre",
            radius, field->reach);
    }
    r = (int)radius;
    *n = 0;
    *at = (plfx_offset *)plft_alloc((size_t)(2 * r + 1) * (size_t)(2 * r + 1),
                                    sizeof **at);
    if (*at == NULL) {
        return PLFT_DATA;
    }
    for (v = -r; v <= r; v++) {
        for (u = -r; u <= r; u++) {
            if (u * u + v * v <= radius * radius) {
                (*at)[(*n)++] = plft_field_offset(field, u, v);
            }
        }
    }
    return 0;
}
