/* SPDX-License-Identifier: MIT
 * Has the lens lattice moved since the calibration?  Any frame of the camera is
 * measured against its table: white, stopped down, or an ordinary scene with a larger
 * error.
 *
 * Some lenses, evenly spread, take part.  Window of a lens: samples at whole pixels
 * from its centre, through the cubic B-spline and the mean of two (nought at the
 * Nyquist frequency: a colour mosaic does not show).  T: mean window of those lenses,
 * E its even part without its mean, g the odd part of its central differences.  Over
 * the disc of half a pitch and half a pixel a lens w lies off the table by
 *   d = -(sum g g')^-1 sum(g w) * sum(E T) / sum(E w)
 * first order of Gauss and Newton for the centre of point symmetry, which is what
 * calibration calls a centre; the common brightness of a lens cancels.  The first
 * rounds take d from the centroid over the darkest sample instead, which finds far
 * lenses.  Displacements are a similarity about the middle of the sensor,
 *   dx = shift_x + scale*X - rotation*Y,   dy = shift_y + rotation*X + scale*Y,
 * least squares over the lenses within 4 rms, repeated until it stands still.
 *
 * Standard errors: sums of residuals over 8 x 8 tiles of the sensor, taken as
 * independent of each other (lenses of one tile are not: they see one scene), and of
 * the shift also what of T is not symmetric.
 *
 * Cost: at most 16 rounds, each reads (p+9)^2 pixels and takes 14 multiplications a
 * pixel for each lens, p the pitch in pixels. */
#ifndef PLENOFIX_DRIFT_H
#define PLENOFIX_DRIFT_H

#include "plenofix/lut.h"
#include "plenofix/raw.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_DRIFT_LENSES_MIN 64
#define PLFX_DRIFT_LENSES_MAX 4096

typedef enum plfx_drift_state {
    PLFX_DRIFT_MEASURED = 0,
    PLFX_DRIFT_FEW,     /* fewer than 16 unflagged lenses inside the array's border */
    PLFX_DRIFT_FLAT,    /* the micro-images have no structure of their own */
    PLFX_DRIFT_DISAGREE /* fewer than half of the lenses are where a lens should be:
                           another camera, or moved by a quarter of the pitch or more */
} plfx_drift_state;

typedef struct plfx_drift { /* all 0 but state, lenses and tried unless MEASURED */
    int32_t state;          /* plfx_drift_state */
    int32_t shift_x_q20, shift_y_q20; /* sensor pixels, of the middle of the sensor */
    int32_t rotation_q30;             /* radians, from +x to +y */
    int32_t scale_q30;                /* relative */
    int32_t shift_sigma_q20, rotation_sigma_q30, scale_sigma_q30; /* 1-sigma, an axis */
    int32_t corner_q20;       /* the longest displacement of a corner of the sensor */
    int32_t corner_sigma_q20; /* 1-sigma of it */
    int32_t rms_q20;          /* of the lenses about the similarity, an axis */
    int32_t lenses, tried;    /* that took part; that were looked at */
} plfx_drift;

/* Workspace, bytes: 12 (p+6)^2 and some 5 KiB; 0 when the pitch is over 256 pixels. */
size_t plfx_drift_ws(const plfx_lut *lut);

/* Measure a frame against a table; about `lenses` take part,
 * PLFX_DRIFT_LENSES_MIN .. _MAX.  A shift by whole pitches cannot show.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE (workspace, or the frame cut short), PLFX_E_RANGE
 * (pitch over 256 pixels). */
plfx_status plfx_drift_find(const plfx_lut *lut, const plfx_raw *raw, int32_t lenses,
                            void *ws, size_t ws_size, plfx_drift *out) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
