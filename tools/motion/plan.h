/* SPDX-License-Identifier: MIT
 * What a camera will see and how sure, before it is built.
 *
 * Thin lenses, the plane in focus at distance d from the main lens, the array at L
 * behind it, 1/L = 1/F - 1/d (the line of inverse distance of docs/units.md).  A lens
 * pitch p spans p*d/L in the plane in focus.  With N the f-number of the main lens as
 * the array sees it and kappa the used part of its diameter, the views at the two ends
 * differ by
 *   delta = dz * kappa/(p*N) * (L/d)^2    lens pitches
 * for a step dz in depth, so
 *   sigma_w = (p*N/kappa) * (d/L)^2 * sigma_delta,   sigma_u = p * (d/L) * sigma.
 * d/L is the width of the field over that of the sensor: depth noise depends on field,
 * pitch and f-number alone.
 *
 * sigma and sigma_delta follow the bound of Cramer and Rao for n lenses and views at
 * offsets (u_k, v_k), brightness e electrons, read noise r, relative gradient G a lens:
 *   sigma^2 = s^2 * c0/(n*G^2*K),
 *   (rim sigma)^2 = s^2 * cw/(n*G^2*sum(u_k^2 + v_k^2)/rim^2),
 *   s^2 = (4/9) * (e + r^2)/e^2     of a bilinear sample, the mean over its places.
 * c0, cw: views closer than two pixels share pixels; the correlation is a cubic
 * B-spline of the offset. */
#ifndef PLFT_MOTION_PLAN_H
#define PLFT_MOTION_PLAN_H

#include <stddef.h>

typedef struct plft_plan_camera {
    double F, focus, f_mu, pitch, pixel; /* mm */
    double f_number;                     /* 0: that of the lenses, f_mu/pitch */
    int nx, ny;                          /* lenses */
    double rate;                         /* frames a second */
    int bits;
    double full_well, read_noise; /* electrons */
} plft_plan_camera;

typedef struct plft_plan_use {
    double radius; /* of the views, pixels; 0: what calibrate would say less 1/2 */
    int views;     /* centre and a cross */
    int regions, w, h, rest; /* regions of w x h lenses, frames of the rest state */
    int modes;               /* tracked in each region */
    double light;            /* mean brightness, part of full scale */
    double texture;          /* rms gradient over mean brightness, a lens pitch */
    int link;                /* bit/s */
} plft_plan_use;

typedef struct plft_plan_result {
    double L, matched;             /* mm; f-number of the small lenses */
    double pitch_px, spot_px;      /* micro-image: pitch and diameter */
    double radius, kappa;          /* px, used part of the pupil */
    int sensor_w, sensor_h;        /* px */
    double lens_mm, w_mm, h_mm;    /* lens, field */
    double sigma_lens, sigma_u_mm; /* in-plane, u and v alike */
    double sigma_slope, delta, sigma_w_mm;
    double reach_mm; /* motion in depth that a region follows, either way */
    double mm_slope; /* of depth towards the camera; sign as monitor --mm-per-slope */
    size_t table, workspace, state, trackers; /* bytes */
    double frame_ops, ops;                    /* multiply-adds: a frame, a second */
    double raw_bits, wide_bits, thin_bits;    /* a second: raw, all records, on the
                                                 link */
    int thin_every, thin_regions;
} plft_plan_result;

/* 0, or PLFT_USAGE with a message that names what cannot be. */
int plft_plan_make(plft_plan_result *p, const plft_plan_camera *c,
                   const plft_plan_use *u);

/* Offsets of the views, px: [views][2], the centre first. */
void plft_plan_cross(double (*at)[2], int views, double radius);

#endif
