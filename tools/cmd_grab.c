/* SPDX-License-Identifier: MIT
 * grab and replay: frames of a camera, or of a recording, as PNG files. */
#include <stdio.h>
#include <string.h>

#include "camera/picture_of.h"
#include "camera/source.h"
#include "commands.h"
#include "common/args.h"
#include "common/err.h"

typedef struct request {
    plft_wish wish;
    const char *out;
    int list;
} request;

static int write_picture(const plft_camera *c, const plfx_camera_frame *f,
                         const char *path)
{
    plft_frame picture = {NULL, 0, 0, 0, 0};
    int rc = plft_picture_of(&picture, f, c->name);

    rc = rc != 0 ? rc : plft_png_write(path, &picture);
    plft_frame_free(&picture);
    return rc;
}

/* Path of frame k: the name itself for a single frame, else name_0000.png. */
static const char *path_of(const request *r, int k, char *path, size_t n)
{
    size_t stem = strlen(r->out);

    if (r->wish.frames == 1) {
        return r->out;
    }
    if (stem > 4 && strcmp(r->out + stem - 4, ".png") == 0) {
        stem -= 4;
    }
    (void)snprintf(path, n, "%.*s_%04d.png", (int)stem, r->out, k);
    return path;
}

static void print_frame(int k, const plfx_camera_frame *f)
{
    printf("%6d  frame %u  %llu.%06llu s  clock %u  dropped %u\n", k, f->sequence,
           (unsigned long long)(f->time_ns / 1000000000u),
           (unsigned long long)(f->time_ns / 1000u % 1000000u), f->clock, f->dropped);
}

static int take(const request *r, plft_camera *c)
{
    char path[4096];
    int rc = 0;
    int k;

    for (k = 0; rc == 0 && (r->wish.frames == 0 || k < r->wish.frames); k++) {
        plfx_camera_frame f;
        rc = plft_camera_next(c, &f);
        if (rc != 0) {
            break;
        }
        if (r->list) {
            print_frame(k, &f);
        }
        if (r->out) {
            rc = write_picture(c, &f, path_of(r, k, path, sizeof path));
        }
        plft_camera_release(c, &f);
    }
    printf("%s: %d frames of %dx%d, %d bits", c->name, k, (int)c->cfg.w, (int)c->cfg.h,
           c->cfg.bits);
    if (c->camera_id) {
        printf(", camera %u", (unsigned)c->camera_id);
    }
    printf("\n");
    if (rc < 0 && k == 0) {
        return plft_fail(PLFT_DATA, "%s holds no whole frame", c->name);
    }
    return rc < 0 ? 0 : rc;
}

static int run(int argc, char **argv, const plft_usage *usage, int frames, double speed,
               int list)
{
    static const char *operand[1];
    plft_option options[PLFT_SOURCE_OPTIONS + 4];
    request r;
    plft_camera c;
    int helped = 0;
    int rc;

    memset(&r, 0, sizeof r);
    plft_wish_none(&r.wish);
    r.wish.frames = frames;
    r.wish.speed = speed;
    r.list = list;
    {
        const plft_option own[] = {
            {"-o", PLFT_TEXT, &r.out, "FRAME.png", 0, 0,
             "the picture; several: FRAME_0000.png ..."},
            {"--speed", PLFT_REAL, &r.wish.speed, "X", 0, 1000,
             "of a recording: 1 real time, 0 without waiting"},
            {"--list", PLFT_FLAG, &r.list, NULL, 0, 0, "a line a frame"},
            {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
        memcpy(options + plft_wish_options(options, &r.wish), own, sizeof own);
    }
    rc = plft_args(argc, argv, usage, options, operand, 1, &r.wish.n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    if (r.out == NULL && !r.list) {
        return plft_fail(PLFT_USAGE, "want -o FRAME.png or --list");
    }
    r.wish.names = operand;
    rc = plft_camera_start(&c, &r.wish);
    if (rc != 0) {
        return rc;
    }
    rc = take(&r, &c);
    plft_camera_report(&c);
    plft_camera_stop(&c);
    return rc;
}

int plft_cmd_grab(int argc, char **argv)
{
    static const plft_usage usage = {"grab", "CAMERA -o FRAME.png [options]",
                                     "A frame of a camera as a picture, pixels as they "
                                     "came: the input of calibrate\n"
                                     "and depth."};

    return run(argc, argv, &usage, 1, 0, 0);
}

int plft_cmd_replay(int argc, char **argv)
{
    static const plft_usage usage = {
        "replay", "FLIGHT.plxr [-o FRAME.png] [options]",
        "A recording frame by frame, in the time in which it was taken."};

    return run(argc, argv, &usage, 0, 1, 1);
}
