/* SPDX-License-Identifier: MIT
 * A first lens centre, given the steps. */
#ifndef PLFT_CALIB_PHASE_H
#define PLFT_CALIB_PHASE_H

#include "calib/grey.h"
#include "calib/lattice.h"

/* Fold windows of the picture into one unit cell; in the window where the cell has
 * most contrast, the lens centre is a point about which the cell repeats when it is
 * turned by a quarter (square) or a sixth (hexagonal), and of such points the
 * brightest. Sets lattice->origin to the lens centre nearest to that window's
 * middle.
 *   contrast: standard deviation of the folded cell over that of the window's pixels
 * 0, or -1 when memory is short or the picture holds no window. */
int plft_phase_find(const plft_grey *grey, plft_lattice *lattice, double *contrast);

#endif
