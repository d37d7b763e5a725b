/* SPDX-License-Identifier: MIT
 * Figures of a calibration. */
#include "calib/figures.h"

#include "calib/outline.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

static plft_verdict say(plft_verdict v, char *reason, size_t size, const char *format,
                        ...)
{
    va_list args;

    va_start(args, format);
    vsnprintf(reason, size, format, args);
    va_end(args);
    return v;
}

const char *plft_verdict_name(plft_verdict v)
{
    static const char *const name[3] = {"green", "amber", "red"};
    return name[v];
}

plft_verdict plft_calib_verdict(const plft_calib *c, const plft_grey *g, char *reason,
                                size_t size)
{
    const int places = c->found + c->missing;
    const double bad = (double)(c->missing + c->interpolated) / fmax(places, 1);
    const double left = c->individual ? 0.0 : c->model.tau;

    if (c->model.rms > 0.05 * c->pitch) {
        return say(
            PLFT_RED, reason, size,
            "the lenses scatter by %.2f px about the lattice, over 5 %% of the pitch",
            c->model.rms);
    }
    if (places - c->missing < places / 2) {
        return say(PLFT_RED, reason, size, "%d of %d lenses have no light", c->missing,
                   places);
    }
    if (c->input == PLFT_INPUT_SCENE) {
        return say(
            PLFT_AMBER, reason, size,
            "made from an ordinary scene: the lattice holds, single lenses were not "
            "measured; use a white or stopped-down frame when there is one");
    }
    if (left > 0.05) {
        return say(PLFT_AMBER, reason, size,
                   "lenses lie %.3f px off the lattice without a pattern", left);
    }
    if (plft_outline_odd(c) != 0) {
        return say(
            PLFT_AMBER, reason, size,
            "the micro-images are not round (their half-light radius varies by "
            "%.0f %%): so look overlapping ones, those of a bladed aperture, and "
            "photographs of something regular",
            100.0 * c->outline);
    }
    if (c->origin_sigma > 0.05) {
        return say(
            PLFT_AMBER, reason, size,
            "the common centre of the micro-images is only known to %.3f px: they "
            "are not symmetric",
            c->origin_sigma);
    }
    if (bad > 0.05) {
        return say(PLFT_AMBER, reason, size,
                   "%.1f %% of the lenses are dark or could not be measured",
                   100.0 * bad);
    }
    if (g->saturated > 0 && c->clipped * 20 > c->found) {
        return say(PLFT_AMBER, reason, size, "%d lenses are clipped: expose less",
                   c->clipped);
    }
    return say(
        PLFT_GREEN, reason, size,
        "%d lenses on one lattice, a spot known to %.4f px, the lattice to %.4f px",
        c->found, c->spot_sigma, c->origin_sigma);
}

double plft_exit_pupil_mm(const plft_calib *c, const plft_optics_hint *h)
{
    double ratio;

    if (!(h->lens_pitch_mm > 0.0) || !(h->pixel_mm > 0.0) || !(h->f_mu_mm > 0.0)) {
        return 0.0;
    }
    ratio = c->pitch * h->pixel_mm / h->lens_pitch_mm;
    return ratio > 1.0 ? h->f_mu_mm / (ratio - 1.0) : HUGE_VAL;
}

double plft_distortion(const plft_calib *c)
{
    double worst = 0.0;
    int i, j;

    for (j = 0; j < c->field.ny; j++) {
        for (i = 0; i < c->field.nx; i++) {
            plft_vec m = plft_model_at(&c->model, i, j);
            plft_vec l = plft_lattice_at(&c->lattice, i, j);
            worst = fmax(worst, hypot(m.x - l.x, m.y - l.y));
        }
    }
    return worst;
}

static void put(json_t *o, const char *key, double v)
{
    json_object_set_new(o, key, isfinite(v) ? json_real(v) : json_null());
}

static json_t *pair(plft_vec v)
{
    return json_pack("[ff]", v.x, v.y);
}

static void put_lattice(json_t *root, const plft_calib *c)
{
    json_t *o = json_object();

    json_object_set_new(
        o, "kind", json_string(c->lattice.kind == PLFX_LATTICE_HEX ? "hex" : "square"));
    json_object_set_new(o, "turned", json_boolean(c->lattice.turned));
    json_object_set_new(o, "columns", json_integer(c->lattice.nx));
    json_object_set_new(o, "rows", json_integer(c->lattice.ny));
    put(o, "pitch", c->pitch);
    put(o, "pitch_sigma", c->pitch_sigma);
    put(o, "rotation_deg", plft_lattice_rotation(&c->lattice));
    put(o, "rotation_sigma_deg", c->rotation_sigma);
    json_object_set_new(o, "origin", pair(c->lattice.origin));
    put(o, "origin_sigma", c->origin_sigma);
    json_object_set_new(o, "a", pair(c->lattice.a));
    json_object_set_new(o, "b", pair(c->lattice.b));
    json_object_set_new(o, "odd", pair(c->lattice.odd));
    put(o, "distortion", plft_distortion(c));
    json_object_set_new(o, "model_order", json_integer(c->model.order));
    json_object_set_new(root, "lattice", o);
}

static void put_lenses(json_t *root, const plft_calib *c)
{
    json_t *o = json_object();

    json_object_set_new(o, "found", json_integer(c->found));
    json_object_set_new(o, "missing", json_integer(c->missing));
    json_object_set_new(o, "off_sensor", json_integer(c->off_sensor));
    json_object_set_new(o, "dim", json_integer(c->dim));
    json_object_set_new(o, "clipped", json_integer(c->clipped));
    json_object_set_new(o, "interpolated", json_integer(c->interpolated));
    put(o, "spot_sigma", c->spot_sigma);
    put(o, "residual_rms", c->model.rms);
    put(o, "unexplained_rms", c->model.tau);
    json_object_set_new(o, "individual", json_boolean(c->individual));
    put(o, "match", c->match);
    put(o, "noise", c->noise);
    put(o, "contrast", c->level);
    json_object_set_new(root, "lenses", o);
}

json_t *plft_figures_json(const plft_calib *c, const plft_grey *g,
                          const plft_optics_hint *h, size_t bytes)
{
    json_t *root = json_object();
    char reason[200];
    plft_verdict v = plft_calib_verdict(c, g, reason, sizeof reason);
    const double pupil = plft_exit_pupil_mm(c, h);

    if (root == NULL) {
        return NULL;
    }
    json_object_set_new(root, "input", json_string(plft_input_name(c->input)));
    json_object_set_new(root, "frames", json_integer(g->frames));
    json_object_set_new(root, "verdict", json_string(plft_verdict_name(v)));
    json_object_set_new(root, "reason", json_string(reason));
    put_lattice(root, c);
    put_lenses(root, c);
    put(root, "usable_radius", c->usable_radius);
    put(root, "micro_image_radius", c->edge_radius);
    put(root, "micro_image_unevenness", c->outline);
    put(root, "crosstalk", c->crosstalk);
    json_object_set_new(root, "hot_pixels", json_integer(g->hot));
    json_object_set_new(root, "saturated_pixels", json_integer(g->saturated));
    if (pupil > 0.0) {
        put(root, "exit_pupil_mm", pupil);
    }
    json_object_set_new(root, "table_bytes", json_integer((json_int_t)bytes));
    return root;
}

void plft_figures_print(const plft_calib *c, const plft_grey *g,
                        const plft_optics_hint *h)
{
    char reason[200];
    plft_verdict v = plft_calib_verdict(c, g, reason, sizeof reason);
    const double pupil = plft_exit_pupil_mm(c, h);

    printf("%s: %s\n", plft_verdict_name(v), reason);
    printf("input      %s, %d frame%s, %d bits%s\n", plft_input_name(c->input),
           g->frames, g->frames == 1 ? "" : "s", g->bits,
           g->shift > 0.0 ? ", colour mosaic" : "");
    printf("lattice    %s%s, %d columns x %d rows\n",
           c->lattice.kind == PLFX_LATTICE_HEX ? "hexagonal" : "square",
           c->lattice.turned ? " (turned by 90 degrees)" : "", c->lattice.nx,
           c->lattice.ny);
    printf("pitch      %.5f px, 1-sigma %.5f\n", c->pitch, c->pitch_sigma);
    printf("rotation   %.5f degrees, 1-sigma %.5f\n",
           plft_lattice_rotation(&c->lattice), c->rotation_sigma);
    printf("origin     (%.4f, %.4f) px, 1-sigma %.4f\n", c->lattice.origin.x,
           c->lattice.origin.y, c->origin_sigma);
    printf(
        "lenses     %d found, %d without light, %d dim, %d clipped, %d interpolated\n",
        c->found, c->missing, c->dim, c->clipped, c->interpolated);
    printf(
        "residual   %.4f px rms an axis, spot noise %.4f, distortion up to %.4f px\n",
        c->model.rms, c->spot_sigma, plft_distortion(c));
    printf("radius     %.2f px usable of %.2f, cross-talk at the border %.1f %%\n",
           c->usable_radius, c->edge_radius, 100.0 * c->crosstalk);
    if (pupil > 0.0 && isfinite(pupil)) {
        printf("exit pupil %.2f mm from the lens array\n", pupil);
    } else if (pupil > 0.0) {
        printf(
            "exit pupil at infinity: micro-images are no farther apart than lenses\n");
    }
}
