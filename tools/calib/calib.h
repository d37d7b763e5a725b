/* SPDX-License-Identifier: MIT
 * From a calibration frame to a lens table, without a hint.
 *
 * Steps from the autocorrelation; phase by folding; then lenses are registered against
 * the mean micro-image in a region that grows while the fitted model predicts the next
 * ones; the mean micro-image is rebuilt over the whole field and all lenses are
 * registered once more. */
#ifndef PLFT_CALIB_CALIB_H
#define PLFT_CALIB_CALIB_H

#include "calib/model.h"

typedef enum plft_input {
    PLFT_INPUT_DOTS,  /* stopped-down aperture: spots much smaller than the pitch */
    PLFT_INPUT_WHITE, /* filled micro-images of a uniform scene */
    PLFT_INPUT_SCENE  /* micro-images of an ordinary scene */
} plft_input;

typedef struct plft_calib_options {
    int kind;      /* PLFX_LATTICE_* or PLFT_LATTICE_AUTO */
    double radius; /* usable radius, px; 0: from the frame */
    int quiet;     /* no progress bar */
} plft_calib_options;

typedef struct plft_calib {
    plft_input input;
    plft_lattice lattice; /* nearest plane lattice, sensor pixels, nx and ny set */
    plft_field field;     /* i0 = j0 = 0, sensor pixels; row 0 and column 0 in use */
    plft_model model;     /* of the field, sensor pixels */
    plft_shape shape;     /* mean micro-image */
    plft_vec *final;      /* [ny][nx] centre written to the table */
    int smooth;           /* the model has terms beyond the lattice */
    int individual;       /* lenses deviate from it by more than noise */
    double pitch, strength, contrast;
    double spot_sigma;    /* median 1-sigma of a spot, px per axis */
    double match;         /* median correlation with the mean micro-image */
    double noise;         /* median residual of a spot, of full scale */
    double level;         /* best contrast of a lens, of full scale */
    double peak;          /* contrast of the mean micro-image, sample values */
    double edge_radius;   /* where the micro-image has fallen to half, px */
    double usable_radius; /* default aperture radius, px */
    double crosstalk;     /* light at the border between two lenses over the centre's */
    double outline; /* rms of its half-light radius over the mean, calib/outline.h */
    double origin_sigma, pitch_sigma, rotation_sigma; /* px, px, degrees */
    int found, missing, dim, clipped, interpolated, off_sensor;
    char reason[200]; /* why nothing was found; empty on success */
} plft_calib;

/* 0, or -1 with calib->reason set in plain words.  plft_calib_free() in either case. */
int plft_calibrate(plft_calib *calib, const plft_grey *grey,
                   const plft_calib_options *options);

/* Second half of plft_calibrate(), in calib/judge.c: extent, flags, radius and
 * figures of a fitted field. */
int plft_calib_finish(plft_calib *calib, const plft_grey *grey,
                      const plft_calib_options *options, const plft_bank *bank);

void plft_calib_free(plft_calib *calib);

const char *plft_input_name(plft_input input);

#endif
