/* SPDX-License-Identifier: MIT */
#include "common/optics.h"

#include <math.h>
#include <string.h>

#include "common/err.h"
#include "common/json.h"

static int number(const json_t *o, const char *key, double lo, double hi, double *v,
                  const char *path)
{
    if (json_object_get(o, key) == NULL) {
        return plft_fail(
            PLFT_DATA,
            "%s: \"%s\" is missing; give inv0 and gain, or F_mm, focus_mm, "
            "f_mu_mm, pixel_mm and pitch_mm",
            path, key);
    }
    return plft_json_real(o, key, lo, hi, 1, v, path);
}

/* Ranges catch metres and micrometres given for millimetres. */
static int from_lenses(plft_optics *o, const json_t *root, const char *path)
{
    double big_f = 0, focus = 0, f_mu = 0, pixel = 0, pitch = 0, f, kappa;

    if (number(root, "F_mm", 1.0, 5000.0, &big_f, path) != 0 ||
        number(root, "focus_mm", 2.0, 1e7, &focus, path) != 0 ||
        number(root, "f_mu_mm", 0.01, 100.0, &f_mu, path) != 0 ||
        number(root, "pixel_mm", 0.0005, 0.1, &pixel, path) != 0 ||
        number(root, "pitch_mm", 0.005, 10.0, &pitch, path) != 0) {
        return PLFT_DATA;
    }
    if (focus <= big_f) {
        return plft_fail(PLFT_DATA, "%s: \"focus_mm\" %g must be over \"F_mm\" %g",
                         path, focus, big_f);
    }
    f = 1.0 / (1.0 / big_f - 1.0 / focus);
    kappa = f * pixel / (f_mu * pitch);
    o->inv0 = 1000.0 / focus;
    o->gain = -1000.0 / (f * kappa);
    o->f_mm = f;
    o->pitch_mm = pitch;
    return 0;
}

static int from_line(plft_optics *o, const json_t *root, const char *path)
{
    if (number(root, "inv0", -1e6, 1e6, &o->inv0, path) != 0 ||
        number(root, "gain", -1e9, 1e9, &o->gain, path) != 0 ||
        plft_json_real(root, "f_mm", 1.0, 5000.0, 0, &o->f_mm, path) != 0 ||
        plft_json_real(root, "pitch_mm", 0.005, 10.0, 0, &o->pitch_mm, path) != 0) {
        return PLFT_DATA;
    }
    return 0;
}

static int to_fixed(plft_optics *o, const char *path, int positive)
{
    if (o->gain == 0.0 || (o->gain > 0.0) != (positive != 0)) {
        return plft_fail(
            PLFT_DATA,
            "%s: \"gain\" %g has the wrong sign: near objects have %s slopes "
            "here; see docs/units.md",
            path, o->gain, positive ? "positive" : "negative");
    }
    if (fabs(o->inv0) >= 128.0 || fabs(o->gain) >= 32768.0) {
        return plft_fail(PLFT_DATA,
                         "%s: inv0 %g, gain %g dioptres are out of range (128, 32768): "
                         "check the units, or the camera is a microscope",
                         path, o->inv0, o->gain);
    }
    o->line.inv0_q24 = (int32_t)lround(o->inv0 * 16777216.0);
    o->line.gain_q24 = llround(o->gain * 16777216.0);
    return 0;
}

int plft_optics_read(plft_optics *o, const char *path, int positive)
{
    json_t *root;
    int rc = plft_json_read(&root, path);

    memset(o, 0, sizeof *o);
    if (rc != 0) {
        return rc;
    }
    rc = json_object_get(root, "inv0") != NULL || json_object_get(root, "gain") != NULL
             ? from_line(o, root, path)
             : from_lenses(o, root, path);
    json_decref(root);
    return rc != 0 ? rc : to_fixed(o, path, positive);
}
