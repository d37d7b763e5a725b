/* SPDX-License-Identifier: MIT
 * Calibration frames with known centres, drawn from formulas: nothing here is shared
 * with the simulator or with the code under test. */
#ifndef PLFT_BENCH_DRAW_H
#define PLFT_BENCH_DRAW_H

#include <stdint.h>

typedef enum draw_spot {
    DRAW_DOTS, /* Gaussian of `sigma` px */
    DRAW_SOFT, /* raised cosine over the pitch, integrated over the pixel */
    DRAW_FLAT  /* disc of 0.46 pitches, 25 % darker at its rim, integrated */
} draw_spot;

typedef struct draw_spec {
    draw_spot spot;
    int hex, nx, ny;
    double pitch, rotation; /* px, degrees */
    double x0, y0;          /* centre of lens (0,0) before the margin for rotation */
    double sigma;           /* of dots, px */
    int bits;
    double level, noise; /* of full scale */
    double barrel;       /* relative shift at the corner */
    double dead, hot;    /* share of lenses, of pixels */
    double gradient;     /* brightest over darkest side, 1: even */
    double black;        /* share of the field without light, at the right */
    unsigned seed;
    double shift_x, shift_y, turn, grow; /* moved about the middle: px, radians, part */
    double scene;  /* contrast of the scene that the lenses see, 0: white .. 1 */
    double slope;  /* its slope, lens pitches a pixel */
    double spread; /* of the light over neighbouring pixels, sigma in px */
} draw_spec;

typedef struct draw_frame {
    uint16_t *px;
    int w, h;
    int lenses;
    double *xy;     /* [lenses][2] */
    uint8_t *state; /* [lenses] 0 good, 1 dead, 2 in the black part */
} draw_frame;

/* Draw; aborts when memory is short. */
void draw(draw_frame *frame, const draw_spec *spec);
void draw_free(draw_frame *frame);

#endif
