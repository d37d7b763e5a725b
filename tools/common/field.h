/* SPDX-License-Identifier: MIT
 * Where views come from: a raw frame with its lens table, or a folder of ready-made
 * views.  Either way a command asks for offsets and gets a block of views. */
#ifndef PLFT_FIELD_H
#define PLFT_FIELD_H

#include "common/args.h"
#include "common/frame.h"
#include "common/table.h"
#include "plenofix/image.h"
#include "plenofix/view.h"

/* What the command line names. */
typedef struct plft_source {
    const char *raw, *lut, *white, *dark;
    plft_frame *frame; /* not NULL: instead of the file `raw`, and taken over */
    const char *dir, *grid, *pattern;
    int bits;      /* of the raw samples; 0: as the file */
    int view_bits; /* 0: 12 for raw samples of 12 bits and more, else 10 */
    int bayer;     /* plfx_bayer */
    int channel;   /* 0 grey, 1 red, 2 green, 3 blue */
} plft_source;

#define PLFT_OPTIONS_MAX 64

/* A command's own table followed by the options that fill `source`: those of raw
 * frames, and of folders of views when `dir` is set. */
void plft_source_options(plft_option *all, const plft_option *own, plft_source *source,
                         int dir);

typedef struct plft_ready { /* one ready-made view */
    char *path;
    plfx_offset at;
} plft_ready;

typedef struct plft_field {
    plft_table table;        /* raw only */
    plfx_lut shell;          /* views.json: a lut with nothing but its lattice */
    const plfx_lut *lut;     /* for the plan; NULL for views of a camera array */
    int nx, ny, bits;        /* of the views */
    double radius, reach;    /* default and largest |offset|, in u */
    int scale;               /* u counts 1/scale of a view step (camera arrays) */
    uint8_t *lens;           /* [ny][nx] PLFX_LENS_*, or NULL */
    plft_frame frame, white; /* raw only: one plane each; white.px NULL when none */
    plfx_tone tone, white_tone;
    double stretch, white_ref; /* run-time white: sample = s/w * white_ref * stretch */
    int use_gain;              /* the table's GAIN section corrects the views */
    plft_ready *ready;         /* [n_ready], NULL for raw */
    int n_ready;
    int band_pass;    /* views come filtered (band_pass.h) */
    int device;       /* where maps are made: PLFT_CPU or an OpenCL device */
    double tone_gain; /* for reports: factor on the raw samples */
} plft_field;

/* Load and check; *helper messages name the files.  0, PLFT_DATA or PLFT_USAGE. */
int plft_field_open(plft_field *field, const plft_source *source);

/* Ready-made views: stretch the unit of u so that slopes up to `slope` (in view steps)
 * fit a plan.  No effect on raw frames. */
void plft_field_rescale(plft_field *field, double slope);

/* The offset nearest to (u,v) that the light field can give, u and v in sensor pixels
 * or, for camera arrays, view steps. */
plfx_offset plft_field_offset(const plft_field *field, double u, double v);

/* Views at `at[0..n)`, as plft_field_offset() gave them: px malloc'd, banded. */
int plft_field_views(const plft_field *field, const plfx_offset *at, int n,
                     plfx_views *views);

void plft_field_free(plft_field *field);

#endif
