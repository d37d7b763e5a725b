/* SPDX-License-Identifier: MIT
 * Table description of a calibration. */
#include "calib/save.h"

#include "calib/drift.h"
#include "common/err.h"
#include "common/memory.h"
#include "common/out.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plenofix/drift.h"
#include "plenofix/version.h"

#define META_MAX 1024
#define LENSES   1024 /* looked at to see whether a frame agrees */

static int32_t count(const plft_saved *s)
{
    return s->desc.lattice.nx * s->desc.lattice.ny;
}

/* A centre of the quantised lattice, as plfx_lut_centre() adds it up. */
static plft_vec stored(const plfx_lattice *l, int i, int j)
{
    const double q22 = 1.0 / 4194304.0, q16 = 1.0 / 65536.0;
    const int odd = j % 2 != 0;
    plft_vec p;

    p.x =
        l->origin.x_q16 * q16 + q22 * ((double)i * l->a.x_q22 + (double)j * l->b.x_q22 +
                                       (odd ? l->odd.x_q22 : 0));
    p.y =
        l->origin.y_q16 * q16 + q22 * ((double)i * l->a.y_q22 + (double)j * l->b.y_q22 +
                                       (odd ? l->odd.y_q22 : 0));
    return p;
}

static int16_t q12(double v)
{
    v = floor(v * 4096.0 + 0.5);
    return (int16_t)(v < -32768.0 ? -32768.0 : v > 32767.0 ? 32767.0 : v);
}

static int fill_residuals(plft_saved *s, const plft_calib *c)
{
    int i, j;

    if (!c->smooth && !c->individual) {
        return 0;
    }
    s->resid = plft_alloc(2u * (size_t)count(s), sizeof *s->resid);
    if (s->resid == NULL) {
        return PLFT_DATA;
    }
    for (j = 0; j < s->desc.lattice.ny; j++) {
        for (i = 0; i < s->desc.lattice.nx; i++) {
            const int k = j * s->desc.lattice.nx + i;
            const plft_vec p = stored(&s->desc.lattice, i, j);
            s->resid[2 * k] = q12(c->final[k].x - p.x);
            s->resid[2 * k + 1] = q12(c->final[k].y - p.y);
        }
    }
    s->desc.resid_q12 = s->resid;
    return 0;
}

static int fill_flags(plft_saved *s, const plft_calib *c)
{
    int k, any = 0;

    s->flags = plft_alloc((size_t)count(s), 1);
    if (s->flags == NULL) {
        return PLFT_DATA;
    }
    for (k = 0; k < count(s); k++) {
        s->flags[k] = c->field.spot[k].flags;
        any |= s->flags[k];
    }
    s->desc.flags = any ? s->flags : NULL;
    return 0;
}

static int fill_meta(plft_saved *s, const plft_calib *c, const plft_grey *g)
{
    int n;

    s->meta = plft_alloc(META_MAX, 1);
    if (s->meta == NULL) {
        return PLFT_DATA;
    }
    n = snprintf(s->meta, META_MAX,
                 "plenofix " PLFX_VERSION_STRING " calibrate\ninput %s\nframes %d\n"
                 "lenses %d\nmissing %d\npitch_px %.6f\npitch_sigma_px %.6f\n"
                 "rotation_deg %.6f\nrotation_sigma_deg %.6f\norigin_sigma_px %.6f\n"
                 "spot_sigma_px %.6f\nresidual_rms_px %.6f\nunexplained_px %.6f\n"
                 "model_order %d\nindividual %d\ncrosstalk %.4f\n",
                 plft_input_name(c->input), g->frames, c->found, c->missing, c->pitch,
                 c->pitch_sigma, plft_lattice_rotation(&c->lattice), c->rotation_sigma,
                 c->origin_sigma, c->spot_sigma, c->model.rms, c->model.tau,
                 c->model.order, c->individual, c->crosstalk);
    s->desc.meta = (const uint8_t *)s->meta;
    s->desc.meta_len = (uint32_t)(n < META_MAX ? n : META_MAX - 1);
    return 0;
}

int plft_saved_init(plft_saved *s, const plft_calib *c, const plft_grey *g)
{
    memset(s, 0, sizeof *s);
    s->desc.sensor_w = g->w;
    s->desc.sensor_h = g->h;
    s->desc.sensor_bits = g->bits;
    s->desc.radius_q8 = (int32_t)floor(c->usable_radius * 256.0 + 0.5);
    s->desc.has_dark = g->dark_level > 0.0;
    s->desc.dark_u16 = (uint16_t)(g->dark_level + 0.5);
    if (plft_lattice_quantise(&c->lattice, &s->desc.lattice) != 0) {
        return plft_fail(PLFT_DATA, "lens steps of over 511 px do not fit a table");
    }
    if (fill_residuals(s, c) != 0 || fill_flags(s, c) != 0 || fill_meta(s, c, g) != 0) {
        plft_saved_free(s);
        return PLFT_DATA;
    }
    return 0;
}

/* The table in memory of its own, opened; NULL with a message. */
static uint8_t *blob_of(const plft_saved *s, const char *path, plfx_lut *lut,
                        size_t *bytes)
{
    uint8_t *blob;

    *bytes = plfx_lut_bytes(&s->desc);
    blob = *bytes > 0 ? plft_alloc(*bytes, 1) : NULL;
    if (blob != NULL && plfx_lut_write(&s->desc, blob, *bytes) == PLFX_OK &&
        plfx_lut_open(lut, blob, *bytes) == PLFX_OK) {
        return blob;
    }
    plft_fail(PLFT_DATA, "%s: this calibration does not fit a table", path);
    free(blob);
    return NULL;
}

int plft_saved_agrees(const plft_saved *saved, const plft_grey *frame, const char *path)
{
    plft_frame f;
    plft_drift d;
    plfx_lut lut;
    size_t bytes;
    uint8_t *blob = blob_of(saved, path, &lut, &bytes);
    int status = blob != NULL ? 0 : PLFT_DATA;

    memset(&f, 0, sizeof f);
    f.px = frame->px;
    f.w = frame->w;
    f.h = frame->h;
    f.bits = 16;
    if (status == 0 && plft_drift_find(&d, &lut, &f, LENSES) != 0 &&
        d.state != PLFX_DRIFT_FEW) {
        status = plft_fail(PLFT_DATA, "%s: %s; no table written", path, d.reason);
    }
    free(blob);
    return status;
}

int plft_saved_write(const plft_saved *s, const char *path, size_t *bytes)
{
    plfx_lut lut;
    uint8_t *blob = blob_of(s, path, &lut, bytes);
    int status = blob != NULL ? plft_out_bytes(path, blob, *bytes) : PLFT_DATA;

    free(blob);
    return status;
}

void plft_saved_free(plft_saved *s)
{
    free(s->resid);
    free(s->flags);
    free(s->profile);
    free(s->gain);
    free(s->meta);
    memset(s, 0, sizeof *s);
}
