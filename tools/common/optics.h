/* SPDX-License-Identifier: MIT
 * O.json: the line 1/d = inv0 + gain*D of a camera. */
#ifndef PLFT_OPTICS_H
#define PLFT_OPTICS_H

#include "plenofix/depth.h"

typedef struct plft_optics {
    plfx_optics line;
    double inv0, gain;     /* dioptres, dioptres per unit slope */
    double f_mm, pitch_mm; /* lens-to-array distance and lens pitch; 0: not known */
} plft_optics;

/* {"inv0", "gain"} or {"F_mm", "focus_mm", "f_mu_mm", "pixel_mm", "pitch_mm"}: then
 *   1/f = 1/F - 1/focus,  kappa = f*pixel/(f_mu*pitch),  inv0 = 1/focus,
 *   gain = -1/(f*kappa)
 * focus is the distance of the plane in focus from the lens.  "f_mm" and "pitch_mm"
 * may stand beside the first form: they give x and y of a point cloud their scale.
 * positive: 1 when near objects have positive slopes (camera arrays), else 0: a gain of
 * the other sign is refused.  0 or PLFT_DATA. */
int plft_optics_read(plft_optics *optics, const char *path, int positive);

#endif
