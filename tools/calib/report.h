/* SPDX-License-Identifier: MIT
 * The calibration as one page that opens anywhere: no file beside it, no network. */
#ifndef PLFT_CALIB_REPORT_H
#define PLFT_CALIB_REPORT_H

#include "calib/save.h"

#include <jansson.h>

/* Verdict, found centres over the frame (zoomable), full-size cuts, residual vectors
 * and histogram, mean micro-image and profile, gains, all figures.  0 or PLFT_DATA. */
int plft_report_write(const char *path, const plft_calib *calib, const plft_grey *grey,
                      const plft_saved *saved, const json_t *figures);

#endif
