/* SPDX-License-Identifier: MIT
 * record: a camera's frames into one file that survives a crash. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "camera/source.h"
#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/table.h"
#include "posix/recording.h"

#define OPERANDS 4096

typedef struct request {
    plft_wish wish;
    const char *out, *lut;
    int append, sync;
    double seconds;
} request;

static double now(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int broken(const request *r, const plfx_recording *rec, plfx_status status)
{
    if (status == PLFX_E_IO && rec->error == EEXIST) {
        return plft_fail(PLFT_DATA, "%s is there already; --append goes on with it",
                         r->out);
    }
    return plft_fail(PLFT_DATA, "%s: %s", r->out,
                     status == PLFX_E_IO       ? strerror(rec->error)
                     : status == PLFX_E_FORMAT ? "no recording"
                                               : "cannot hold such frames");
}

static int same_frames(const plfx_recording *rec, const plfx_camera_cfg *c)
{
    return rec->info.w == c->w && rec->info.h == c->h &&
           rec->info.format == c->format && rec->info.bits == c->bits &&
           rec->info.bayer == c->bayer;
}

/* Frames that belong to one camera and one table, as far as either is noted. */
static int same_origin(const plfx_recording_info *a, const plfx_recording_info *b)
{
    return (!a->camera_id || !b->camera_id || a->camera_id == b->camera_id) &&
           (!a->table_crc || !b->table_crc || a->table_crc == b->table_crc);
}

static int go_on(const request *r, const plft_camera *c,
                 const plfx_recording_info *info, plfx_recording *rec)
{
    plfx_status status = plfx_recording_open(rec, r->out, 1);

    if (status != PLFX_OK) {
        return broken(r, rec, status);
    }
    if (!same_frames(rec, &c->cfg)) {
        plfx_recording_close(rec);
        return plft_fail(PLFT_DATA, "%s holds %dx%d frames of another kind than %s",
                         r->out, (int)rec->info.w, (int)rec->info.h, c->name);
    }
    if (!same_origin(&rec->info, info)) {
        plfx_recording_close(rec);
        return plft_fail(PLFT_DATA, "%s is of another camera or table than %s", r->out,
                         r->lut ? r->lut : c->name);
    }
    if (rec->cut > 0) {
        plft_warn(
            "%s: cut off %llu bytes of an unfinished frame behind %llu whole ones",
            r->out, (unsigned long long)rec->cut, (unsigned long long)rec->count);
    }
    return 0;
}

/* Note the table that belongs to the frames. */
static int take_table(const request *r, const plft_camera *c, plfx_recording_info *info)
{
    plft_table table;
    int rc;

    if (r->lut == NULL) {
        return 0;
    }
    rc = plft_table_read(&table, r->lut);
    rc = rc != 0 ? rc : plft_camera_suits(c, &table.lut, r->lut);
    if (rc == 0) {
        info->camera_id = table.lut.camera_id ? table.lut.camera_id : c->camera_id;
        info->table_crc = table.lut.crc;
    }
    plft_table_free(&table);
    return rc;
}

static void describe(const plft_camera *c, plfx_recording_info *info)
{
    memset(info, 0, sizeof *info);
    info->w = c->cfg.w;
    info->h = c->cfg.h;
    info->format = c->cfg.format;
    info->bits = c->cfg.bits;
    info->bayer = c->cfg.bayer;
    info->camera_id = c->camera_id;
}

static int begin(const request *r, const plft_camera *c, plfx_recording *rec)
{
    plfx_recording_info info;
    plfx_status status;
    int rc;

    describe(c, &info);
    rc = take_table(r, c, &info);
    if (rc != 0 || r->append) {
        return rc != 0 ? rc : go_on(r, c, &info, rec);
    }
    status = plfx_recording_create(rec, r->out, &info);
    return status == PLFX_OK ? 0 : broken(r, rec, status);
}

static int record(const request *r, plft_camera *c, plfx_recording *rec)
{
    double end = now() + (r->seconds > 0 ? r->seconds : 1e12);
    int n = 0;
    int rc = 0;

    while (rc == 0 && now() < end && (r->wish.frames == 0 || n < r->wish.frames)) {
        plfx_status status;
        plfx_camera_frame f;
        rc = plft_camera_next(c, &f);
        if (rc != 0) {
            break;
        }
        status = plfx_recording_add(rec, &f);
        plft_camera_release(c, &f);
        n++;
        if (status == PLFX_OK && n % r->sync == 0) {
            status = plfx_recording_sync(rec);
        }
        if (status != PLFX_OK) {
            rc = broken(r, rec, status);
        }
    }
    if (plfx_recording_sync(rec) != PLFX_OK && rc <= 0) {
        rc = broken(r, rec, PLFX_E_IO);
    }
    printf("%s: %d frames recorded, %llu in all\n", r->out, n,
           (unsigned long long)rec->count);
    return rc < 0 ? 0 : rc;
}

int plft_cmd_record(int argc, char **argv)
{
    static const plft_usage usage = {
        "record", "CAMERA|PICTURE... -o FLIGHT.plxr [options]",
        "Frames of a camera, or of pictures, into one file.  Ctrl-C ends it; a crash "
        "costs at\nmost the frames since the last --sync."};
    static const char *operands[OPERANDS];
    plft_option options[PLFT_SOURCE_OPTIONS + 6];
    request r;
    plft_camera c;
    plfx_recording rec;
    int helped = 0;
    int rc;

    memset(&r, 0, sizeof r);
    plft_wish_none(&r.wish);
    r.sync = 16;
    {
        const plft_option own[] = {
            {"-o", PLFT_TEXT, &r.out, "FLIGHT.plxr", 0, 0, "the recording"},
            {"--append", PLFT_FLAG, &r.append, NULL, 0, 0, "go on with a recording"},
            {"--sync", PLFT_INT, &r.sync, "N", 1, 1e6,
             "to the medium each N frames; 16"},
            {"--seconds", PLFT_REAL, &r.seconds, "S", 0.001, 1e9, "stop after so long"},
            {"--lut", PLFT_TEXT, &r.lut, "CAM.plut", 0, 0, "table to note in the file"},
            {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
        memcpy(options + plft_wish_options(options, &r.wish), own, sizeof own);
    }
    rc = plft_args(argc, argv, &usage, options, operands, OPERANDS, &r.wish.n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    if (r.out == NULL) {
        return plft_fail(PLFT_USAGE, "want -o FLIGHT.plxr");
    }
    r.wish.names = operands;
    rc = plft_camera_start(&c, &r.wish);
    if (rc != 0) {
        return rc;
    }
    rc = begin(&r, &c, &rec);
    if (rc == 0) {
        rc = record(&r, &c, &rec);
        plfx_recording_close(&rec);
    }
    plft_camera_report(&c);
    plft_camera_stop(&c);
    return rc;
}
