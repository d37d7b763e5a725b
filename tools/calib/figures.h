/* SPDX-License-Identifier: MIT
 * The figures of a calibration, for people and for programs. */
#ifndef PLFT_CALIB_FIGURES_H
#define PLFT_CALIB_FIGURES_H

#include "calib/calib.h"

#include <jansson.h>

/* What the user knows of the optics; 0: unknown. */
typedef struct plft_optics_hint {
    double lens_pitch_mm, pixel_mm, f_mu_mm;
} plft_optics_hint;

typedef enum plft_verdict { PLFT_GREEN, PLFT_AMBER, PLFT_RED } plft_verdict;

/* Verdict, and in `reason` (at least 200 bytes) why. */
plft_verdict plft_calib_verdict(const plft_calib *calib, const plft_grey *grey,
                                char *reason, size_t size);
const char *plft_verdict_name(plft_verdict verdict);

/* Exit-pupil distance from the array, mm: micro-images lie P*(1 + f_mu/L) apart when
 * the lenses lie P apart, so L = f_mu/(ratio - 1).  0 when a hint is missing;
 * HUGE_VAL when the ratio is 1 (telecentric) or less. */
double plft_exit_pupil_mm(const plft_calib *calib, const plft_optics_hint *hint);

/* Largest change of the model from its plane lattice, px. */
double plft_distortion(const plft_calib *calib);

/* New reference, or NULL. `bytes`: size of the table written. */
json_t *plft_figures_json(const plft_calib *calib, const plft_grey *grey,
                          const plft_optics_hint *hint, size_t bytes);

void plft_figures_print(const plft_calib *calib, const plft_grey *grey,
                        const plft_optics_hint *hint);

#endif
