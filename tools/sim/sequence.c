/* SPDX-License-Identifier: MIT */
#include "sim/sequence.h"

#include <stdio.h>
#include <string.h>

#include "common/err.h"
#include "common/frame.h"
#include "common/out.h"
#include "common/progress.h"
#include "sim/film.h"

#define PI 3.14159265358979323846

typedef struct record {
    plft_film film;
    const char *folder;
    plft_out csv;
} record;

static void header(record *r)
{
    int k;

    (void)fprintf(r->csv.file,
                  "frame,time_s,lamp,bend1_mm,bend2_mm,torsion_mm,shake_x_mm,"
                  "shake_y_mm,shake_z_mm,turn_x_deg,turn_y_deg,turn_z_deg");
    for (k = 0; k < r->film.scene->motion.stations; k++) {
        (void)fprintf(r->csv.file, ",s%d_w_mm,s%d_col,s%d_row,s%d_slope", k, k, k, k);
    }
    (void)fputc('\n', r->csv.file);
}

static void write_row(record *r, int n, const plft_instant *i)
{
    FILE *csv = r->csv.file;
    int k;

    (void)fprintf(csv, "%d,%.6f,%.5f,%.6f,%.6f,%.6f", n, i->time, i->lamp, i->q[0],
                  i->q[1], i->q[2]);
    for (k = 0; k < 3; k++) {
        (void)fprintf(csv, ",%.6f", i->pose.shift[k]);
    }
    for (k = 0; k < 3; k++) {
        (void)fprintf(csv, ",%.6f", i->pose.turn[k] * 180.0 / PI);
    }
    for (k = 0; k < r->film.scene->motion.stations; k++) {
        (void)fprintf(csv, ",%.6f,%.7f,%.7f,%.8f", i->move[k][0], i->move[k][1],
                      i->move[k][2], i->move[k][3]);
    }
    (void)fputc('\n', csv);
}

static int save(record *r, int n)
{
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/frame_%05d.png", r->folder, n);

    if (length < 0 || (size_t)length >= sizeof path) {
        return plft_fail(PLFT_DATA, "%s: path too long", r->folder);
    }
    return plft_png_write(path, &r->film.frame);
}

static int roll(record *r)
{
    int frames = r->film.scene->motion.rest + r->film.scene->motion.frames;
    plft_instant truth;
    int n;

    header(r);
    for (n = 0; n < frames; n++) {
        if (plft_film_next(&r->film, &truth)) {
            return PLFT_DATA;
        }
        write_row(r, n, &truth);
        if (save(r, n)) {
            return PLFT_DATA;
        }
        plft_progress("sequence", (double)(n + 1) / frames);
    }
    return plft_out_commit(&r->csv);
}

int plft_sequence_write(plft_scene *scene, const char *folder)
{
    char path[4096];
    record r;
    int rc, length;

    memset(&r, 0, sizeof r);
    length = snprintf(path, sizeof path, "%s/motion.csv", folder);
    if (length < 0 || (size_t)length >= sizeof path || plft_out_open(&r.csv, path)) {
        return PLFT_DATA;
    }
    r.folder = folder;
    rc = plft_film_open(&r.film, scene, NULL);
    rc = rc ? rc : roll(&r);
    plft_out_abort(&r.csv);
    plft_film_close(&r.film);
    return rc;
}
