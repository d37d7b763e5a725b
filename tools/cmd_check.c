/* SPDX-License-Identifier: MIT
 * plenofix check: has the lens lattice moved since the calibration? */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/drift.h"
#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/frame.h"
#include "common/json.h"
#include "common/table.h"

#define DEGREES 57.295779513082320877
#define LENSES  2048

typedef struct options {
    const char *raw, *lut;
    int bits, json;
} options;

static int parse(int argc, char **argv, options *o, int *helped)
{
    const plft_usage usage = {
        "check", "RAW --lut CAM.plut [options]",
        "Shift, rotation and scale of the lens lattice of a frame against a table."};
    const plft_option table[] = {
        {"--lut", PLFT_TEXT, NULL, "CAM.plut", 0, 0, "the table"},
        {"--bits", PLFT_INT, NULL, "N", 8, 16, "significant bits (as the file)"},
        {"--json", PLFT_FLAG, NULL, NULL, 0, 0, "figures as JSON"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    plft_option t[sizeof table / sizeof table[0]];
    int n = 0, status;

    memcpy(t, table, sizeof table);
    t[0].target = &o->lut;
    t[1].target = &o->bits;
    t[2].target = &o->json;
    status = plft_args(argc, argv, &usage, t, &o->raw, 1, &n, helped);
    if (status == 0 && !*helped && (n != 1 || o->lut == NULL)) {
        status = plft_fail(PLFT_USAGE, "check wants a frame and --lut CAM.plut");
    }
    return status;
}

static int print_json(const plft_drift *d)
{
    json_t *root = json_pack(
        "{s:b,s:[ff],s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:i,s:i}", "moved", d->moved, "shift",
        d->shift_x, d->shift_y, "shift_sigma", d->shift_sigma, "rotation_deg",
        DEGREES * d->rotation, "rotation_sigma_deg", DEGREES * d->rotation_sigma,
        "scale", d->scale, "scale_sigma", d->scale_sigma, "worst_px", d->corner,
        "residual_rms", d->rms, "lenses", d->lenses, "tried", d->tried);
    int status = root != NULL ? plft_json_print(root) : PLFT_DATA;

    json_decref(root);
    return status;
}

static int print_text(const plft_drift *d)
{
    printf("%s\n", d->moved ? "moved: calibrate again" : "not moved");
    printf("shift      (%+.4f, %+.4f) px, 1-sigma %.4f\n", d->shift_x, d->shift_y,
           d->shift_sigma);
    printf("rotation   %+.5f degrees, 1-sigma %.5f\n", DEGREES * d->rotation,
           DEGREES * d->rotation_sigma);
    printf("scale      %+.3e, 1-sigma %.1e\n", d->scale, d->scale_sigma);
    printf("worst      %.4f px at a corner\n", d->corner);
    printf("lenses     %d of %d, residual %.4f px rms an axis\n", d->lenses, d->tried,
           d->rms);
    return 0;
}

int plft_cmd_check(int argc, char **argv)
{
    options o;
    plft_frame frame;
    plft_table table;
    plft_drift drift;
    int helped = 0;
    int status;

    memset(&o, 0, sizeof o);
    memset(&frame, 0, sizeof frame);
    memset(&table, 0, sizeof table);
    status = parse(argc, argv, &o, &helped);
    if (status == 0 && !helped) {
        status = plft_table_read(&table, o.lut);
        if (status == 0) {
            status = plft_frame_read(&frame, o.raw, o.bits);
        }
        if (status == 0) {
            plft_frame_to_grey(&frame);
        }
        if (status == 0 && plft_drift_find(&drift, &table.lut, &frame, LENSES) != 0) {
            status = plft_fail(PLFT_DATA, "%s: %s", o.raw, drift.reason);
        }
        if (status == 0) {
            status = o.json ? print_json(&drift) : print_text(&drift);
        }
    }
    plft_frame_free(&frame);
    plft_table_free(&table);
    return status;
}
