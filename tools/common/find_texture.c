/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "common/band_pass.h"
#include "common/match.h"
#include "plenofix/viewcheck.h"

#define OVER_NOISE 1.3
#define STEP_MEAN  1.1284 /* mean difference of two normal samples, in sigmas */
#define LEAST      2.0    /* 1/1000 of full scale */
#define MOST       12.0

int plft_own_window(const plft_field *field)
{
    int side = field->nx < field->ny ? field->nx : field->ny;

    return side >= 72 ? 9 : side >= 48 ? 7 : side >= 16 ? 5 : 3;
}

int plft_find_texture(const plft_field *field, int u_only, double *texture)
{
    plft_field plain = *field;
    plfx_offset centre = plft_field_offset(field, 0.0, 0.0);
    double noise; /* of full scale; the core counts sixteenths of 1/255 */
    plfx_views one;
    int rc;

    *texture = LEAST;
    if (field->lut == NULL) {
        return 0;
    }
    plain.band_pass = 0;
    rc = plft_field_views(&plain, &centre, 1, &one);
    if (rc == 0) {
        noise = plfx_views_noise_q4(&one, field->bits, 0) / 16.0 / 255.0;
        noise *= 1000.0 * OVER_NOISE * STEP_MEAN * (u_only ? 1.0 : 2.0);
        noise *= field->band_pass ? PLFT_BAND_STEP : 1.0;
        *texture = fmin(fmax(noise, LEAST), MOST);
        free(one.px);
    }
    return rc;
}
