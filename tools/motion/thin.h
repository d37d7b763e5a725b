/* SPDX-License-Identifier: MIT
 * Thinning of a mode's channel among other modes: what of them leaks through. */
#ifndef PLFT_MOTION_THIN_H
#define PLFT_MOTION_THIN_H

/* Share of the amplitude of a motion at `from` Hz that reaches the channel of a mode at
 * `to` Hz, sampled at `rate` and thinned by `every` (plenofix/modal.h): a triangle over
 * two periods, at the distances from - to and from + to that mixing makes of it. */
double plft_thin_leak(double rate, int every, double from, double to);

/* Are two modes apart?  Those nearer than half the thinned rate are read as one. */
int plft_thin_apart(double rate, int every, double a, double b);

/* The thinning near plfx_modal_every() through which those of the n modes that are
 * apart from mode m leak least into it, all taken as equally strong in acceleration; at
 * least 1. */
int plft_thin_every(double rate, const double *freq, int n, int m, double damping);

#endif
