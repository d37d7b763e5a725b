/* SPDX-License-Identifier: MIT
 * The core's drift in pixels, and why there is none. */
#include "calib/drift.h"

#include "common/err.h"
#include "common/memory.h"
#include "plenofix/drift.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOVED 0.05 /* px at the worst corner */
#define Q20   1048576.0
#define Q30   1073741824.0

static int explain(plft_drift *d)
{
    switch (d->state) {
    case PLFX_DRIFT_FEW:
        snprintf(
            d->reason, sizeof d->reason,
            "the table has fewer than 16 good lenses inside its border: too few to "
            "check");
        break;
    case PLFX_DRIFT_FLAT:
        snprintf(d->reason, sizeof d->reason,
                 "the frame disagrees with the table: the micro-images at its centres "
                 "have no structure (black, saturated or even?)");
        break;
    default:
        snprintf(d->reason, sizeof d->reason,
                 "the frame disagrees with the table: %d of %d lenses are where a lens "
                 "should be (another camera, or moved by over a quarter of the pitch?)",
                 d->lenses, d->tried);
        break;
    }
    return -1;
}

static void convert(plft_drift *d, const plfx_drift *c)
{
    d->shift_x = c->shift_x_q20 / Q20;
    d->shift_y = c->shift_y_q20 / Q20;
    d->rotation = c->rotation_q30 / Q30;
    d->scale = c->scale_q30 / Q30;
    d->shift_sigma = c->shift_sigma_q20 / Q20;
    d->rotation_sigma = c->rotation_sigma_q30 / Q30;
    d->scale_sigma = c->scale_sigma_q30 / Q30;
    d->corner = c->corner_q20 / Q20;
    d->rms = c->rms_q20 / Q20;
    d->moved = d->corner > MOVED && d->corner > 4.0 * c->corner_sigma_q20 / Q20;
}

int plft_drift_find(plft_drift *d, const plfx_lut *lut, const plft_frame *f, int lenses)
{
    const size_t need = plfx_drift_ws(lut);
    plfx_raw raw = {(const uint8_t *)f->px,
                    2u * (size_t)f->w * (size_t)f->h,
                    PLFX_RAW_U16,
                    (uint8_t)f->bits,
                    f->w,
                    f->h};
    plfx_drift c;
    plfx_status status = PLFX_E_ARG;
    void *ws;

    memset(d, 0, sizeof *d);
    memset(&c, 0, sizeof c);
    if (lut->sensor_w != f->w || lut->sensor_h != f->h) {
        snprintf(d->reason, sizeof d->reason,
                 "the frame is %dx%d but the table is for %dx%d", f->w, f->h,
                 lut->sensor_w, lut->sensor_h);
        return -1;
    }
    ws = plft_alloc_ws(need);
    if (ws != NULL) {
        status = plfx_drift_find(lut, &raw, lenses, ws, need, &c);
    }
    free(ws);
    if (status != PLFX_OK) {
        snprintf(d->reason, sizeof d->reason, "%s",
                 status == PLFX_E_RANGE ? "the table's pitch is over 256 pixels"
                                        : "out of memory");
        return -1;
    }
    d->state = c.state;
    d->lenses = c.lenses;
    d->tried = c.tried;
    if (c.state != PLFX_DRIFT_MEASURED) {
        return explain(d);
    }
    convert(d, &c);
    return 0;
}

void plft_drift_warn(const char *path, const plfx_lut *lut, const plft_frame *frame)
{
    plft_drift d;

    if (plft_drift_find(&d, lut, frame, PLFX_DRIFT_LENSES_MIN * 4) != 0 &&
        d.state == PLFX_DRIFT_DISAGREE) {
        plft_warn("%s: only %d of %d lenses show where the table has them: another "
                  "camera's table? (the lenses of a sparse or dark scene may hide)",
                  path, d.lenses, d.tried);
    }
}
