/* SPDX-License-Identifier: MIT
 * plenofix calibrate: a lens table from a calibration frame. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/calib.h"
#include "calib/figures.h"
#include "calib/report.h"
#include "calib/save.h"
#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/frame.h"
#include "common/json.h"

#define FRAMES_MAX 256

enum { BAYER_AUTO = 0, BAYER_NONE = 1 }; /* index in the option's words */

typedef struct options {
    const char *frames[FRAMES_MAX];
    int n;
    const char *white, *report, *dark, *out;
    int bayer, bits, lattice, json, camera;
    double radius;
    plft_optics_hint hint;
} options;

typedef struct job {
    options o;
    plft_grey grey;
    plft_calib calib;
    plft_saved saved;
    size_t bytes;
} job;

static int parse(int argc, char **argv, options *o, int *helped)
{
    const plft_usage usage = {"calibrate", "FRAME [FRAME ...] -o CAM.plut [options]",
                              "A lens table from stopped-down dots, a white frame or "
                              "ordinary scenes; several "
                              "frames are averaged."};
    const plft_option table[] = {
        {"-o", PLFT_TEXT, NULL, "CAM.plut", 0, 0, "the table to write"},
        {"--white", PLFT_TEXT, NULL, "W", 0, 0, "white frame for the gains"},
        {"--report", PLFT_TEXT, NULL, "R.html", 0, 0, "page with pictures and figures"},
        {"--dark", PLFT_TEXT, NULL, "D", 0, 0, "dark frame to subtract"},
        {"--bayer", PLFT_WORD, NULL, "auto|none|rggb|grbg|gbrg|bggr", 0, 0,
         "colour mosaic of the frames (auto)"},
        {"--bits", PLFT_INT, NULL, "N", 8, 16, "significant bits (as the file)"},
        {"--lattice", PLFT_WORD, NULL, "auto|square|hex", 0, 0, "lens lattice (auto)"},
        {"--radius", PLFT_REAL, NULL, "R", 0.5, 128, "usable radius, px (measured)"},
        {"--lens-pitch-mm", PLFT_REAL, NULL, "P", 1e-4, 100, "pitch of the lens array"},
        {"--pixel-mm", PLFT_REAL, NULL, "p", 1e-5, 1, "pitch of the sensor's pixels"},
        {"--f-mu-mm", PLFT_REAL, NULL, "f", 1e-3, 1000, "focal length of a lens"},
        {"--json", PLFT_FLAG, NULL, NULL, 0, 0, "figures as JSON"},
        {"--camera", PLFT_INT, NULL, "ID", 1, 2147483647,
         "whose table it is, as grab prints it; other cameras are refused"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    plft_option t[sizeof table / sizeof table[0]];
    int status;

    memcpy(t, table, sizeof table);
    t[0].target = &o->out;
    t[1].target = &o->white;
    t[2].target = &o->report;
    t[3].target = &o->dark;
    t[4].target = &o->bayer;
    t[5].target = &o->bits;
    t[6].target = &o->lattice;
    t[7].target = &o->radius;
    t[8].target = &o->hint.lens_pitch_mm;
    t[9].target = &o->hint.pixel_mm;
    t[10].target = &o->hint.f_mu_mm;
    t[11].target = &o->json;
    t[12].target = &o->camera;
    status = plft_args(argc, argv, &usage, t, o->frames, FRAMES_MAX, &o->n, helped);
    if (status == 0 && !*helped && o->n < 1) {
        status = plft_fail(PLFT_USAGE, "calibrate wants a frame");
    }
    if (status == 0 && !*helped && o->out == NULL) {
        status = plft_fail(PLFT_USAGE, "calibrate wants -o CAM.plut");
    }
    return status;
}

/* Read a frame as one plane; size must be w x h unless w is 0. */
static int read_plane(plft_frame *f, const options *o, const char *path, int w, int h)
{
    int status;

    memset(f, 0, sizeof *f);
    status = plft_frame_read(f, path, o->bits);
    if (status == 0) {
        plft_frame_to_grey(f);
    }
    if (status == 0 && w > 0 && (f->w != w || f->h != h)) {
        status = plft_fail(PLFT_DATA,
                           "%s is %dx%d but %s is %dx%d: frames of one camera "
                           "have one size",
                           path, f->w, f->h, o->frames[0], w, h);
        plft_frame_free(f);
    }
    return status;
}

static int add_frames(plft_grey *g, const options *o, const char *const *paths, int n)
{
    plft_frame f;
    int k;

    for (k = 0; k < n; k++) {
        int status = read_plane(&f, o, paths[k], g->w, g->h);
        if (status != 0) {
            return status;
        }
        if (n == 1) {
            plft_grey_take(g, f.px, f.w, f.h, f.bits);
            return 0;
        }
        status = plft_grey_add(g, f.px, f.w, f.h, f.bits);
        plft_frame_free(&f);
        if (status != 0) {
            return plft_fail(PLFT_DATA,
                             "%s cannot be averaged with the others: another "
                             "bit depth, or no memory",
                             paths[k]);
        }
    }
    return 0;
}

/* Mean of frames, without dark level, mosaic and hot pixels. */
static int load(plft_grey *g, const options *o, const char *const *paths, int n)
{
    plft_frame dark;
    int status = add_frames(g, o, paths, n);

    memset(&dark, 0, sizeof dark);
    if (status == 0 && o->dark != NULL) {
        status = read_plane(&dark, o, o->dark, g->w, g->h);
    }
    if (status == 0 && dark.px != NULL && dark.bits != g->bits) {
        status =
            plft_fail(PLFT_DATA, "%s has %d bits but %s has %d: one camera, one depth",
                      o->dark, dark.bits, paths[0], g->bits);
    }
    if (status == 0 && plft_grey_finish(g, dark.px) != 0) {
        status = plft_fail(PLFT_DATA, "out of memory");
    }
    plft_frame_free(&dark);
    if (status == 0) {
        if (o->bayer > BAYER_NONE ||
            (o->bayer == BAYER_AUTO && plft_grey_is_mosaic(g))) {
            plft_grey_merge_mosaic(g);
        }
        plft_grey_drop_hot(g);
    }
    return status;
}

static int calibrate(job *j)
{
    const plft_calib_options o = {j->o.lattice - 1, j->o.radius, 0};

    if (plft_calibrate(&j->calib, &j->grey, &o) != 0) {
        return plft_fail(PLFT_DATA, "%s: %s; no table written", j->o.frames[0],
                         j->calib.reason);
    }
    return plft_saved_init(&j->saved, &j->calib, &j->grey);
}

/* Gains from --white, or from the calibration frame when that is white. */
static int add_gains(job *j)
{
    plft_grey white;
    int status;

    if (j->o.white == NULL) {
        return j->calib.input == PLFT_INPUT_WHITE
                   ? plft_saved_gain(&j->saved, &j->calib, &j->grey)
                   : 0;
    }
    memset(&white, 0, sizeof white);
    status = load(&white, &j->o, &j->o.white, 1);
    if (status == 0 && (white.w != j->grey.w || white.h != j->grey.h)) {
        status = plft_fail(PLFT_DATA,
                           "%s is %dx%d but %s is %dx%d: frames of one camera "
                           "have one size",
                           j->o.white, white.w, white.h, j->o.frames[0], j->grey.w,
                           j->grey.h);
    }
    if (status == 0) {
        status = plft_saved_agrees(&j->saved, &white, j->o.white);
    }
    if (status == 0) {
        status = plft_saved_gain(&j->saved, &j->calib, &white);
    }
    plft_grey_free(&white);
    return status;
}

static int report(job *j)
{
    json_t *root = plft_figures_json(&j->calib, &j->grey, &j->o.hint, j->bytes);
    int status = 0;

    if (root == NULL) {
        return plft_fail(PLFT_DATA, "out of memory");
    }
    if (j->o.json) {
        status = plft_json_print(root);
    } else {
        plft_figures_print(&j->calib, &j->grey, &j->o.hint);
    }
    if (status == 0 && j->o.report != NULL) {
        status = plft_report_write(j->o.report, &j->calib, &j->grey, &j->saved, root);
    }
    json_decref(root);
    return status;
}

int plft_cmd_calibrate(int argc, char **argv)
{
    job j;
    int helped = 0;
    int status;

    memset(&j, 0, sizeof j);
    status = parse(argc, argv, &j.o, &helped);
    if (status == 0 && !helped) {
        status = load(&j.grey, &j.o, j.o.frames, j.o.n);
        if (status == 0) {
            status = calibrate(&j);
        }
        if (status == 0) {
            status = add_gains(&j);
        }
        if (status == 0) {
            j.saved.desc.camera_id = (uint32_t)j.o.camera;
            status = plft_saved_write(&j.saved, j.o.out, &j.bytes);
        }
        if (status == 0) {
            status = report(&j);
        }
    }
    plft_saved_free(&j.saved);
    plft_calib_free(&j.calib);
    plft_grey_free(&j.grey);
    return status;
}
