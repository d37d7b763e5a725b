/* SPDX-License-Identifier: MIT
 * plenofix simulate: frames of an imagined plenoptic camera, and the truth. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/frame.h"
#include "common/json.h"
#include "common/memory.h"
#include "common/out.h"
#include "common/pfm.h"
#include "common/progress.h"
#include "sim/scene.h"
#include "sim/sequence.h"
#include "sim/trace.h"
#include "sim/truth.h"

typedef struct job {
    const plft_scene *scene;
    const char *folder;
    double *signal;   /* [h][w] */
    plft_frame frame; /* counts */
} job;

typedef struct shot { /* a frame to take */
    unsigned flag;
    const char *file;
    int lit;     /* 0: shutter closed */
    int stopped; /* pupil closed down */
    int white;   /* before a white target */
} shot;

/* Its place in this list numbers its noise. */
static const shot shots[] = {
    {PLFT_FRAME_DOTS, "dots.png", 1, 1, 1},
    {PLFT_FRAME_WHITE, "white.png", 1, 0, 1},
    {PLFT_FRAME_DARK, "dark.png", 0, 0, 1},
    {PLFT_FRAME_SCENE, "scene.png", 1, 0, 0},
};

static int path_of(char *path, size_t size, const char *folder, const char *file)
{
    int n = snprintf(path, size, "%s/%s", folder, file);

    return n < 0 || (size_t)n >= size
               ? plft_fail(PLFT_DATA, "%s: path too long", folder)
               : 0;
}

static int make_folder(const char *folder)
{
    struct stat st;

    if (mkdir(folder, 0777) == 0) {
        return 0;
    }
    if (errno == EEXIST && stat(folder, &st) == 0 && S_ISDIR(st.st_mode)) {
        return 0;
    }
    return plft_fail(PLFT_DATA, "%s: cannot make the folder: %s", folder,
                     strerror(errno == EEXIST ? ENOTDIR : errno));
}

static int light(job *j, const shot *s)
{
    const plft_scene *scene = j->scene;
    plft_trace trace;

    if (!s->lit) {
        memset(j->signal, 0,
               (size_t)j->frame.w * (size_t)j->frame.h * sizeof *j->signal);
        return 0;
    }
    memset(&trace, 0, sizeof trace);
    trace.cam = &scene->cam;
    trace.world = s->white ? NULL : &scene->world;
    trace.pupil_r = s->stopped ? scene->stopped_r : scene->cam.pupil_r;
    trace.rays = scene->rays;
    trace.bayer = scene->bayer;
    memcpy(trace.colour, scene->colour, sizeof trace.colour);
    if (plft_trace_frame(&trace, j->signal) != 0) {
        return plft_fail(PLFT_DATA, "simulate: out of memory");
    }
    return 0;
}

static int take(job *j, const shot *s)
{
    char path[4096];
    uint32_t n = (uint32_t)j->frame.w * (uint32_t)j->frame.h;
    uint64_t stream = 20u + (uint64_t)(s - shots);

    if (path_of(path, sizeof path, j->folder, s->file) || light(j, s)) {
        return PLFT_DATA;
    }
    plft_sensor_expose(&j->scene->sensor, j->signal, NULL, n, j->scene->seed, stream,
                       j->frame.px);
    return plft_png_write(path, &j->frame);
}

static int take_all(job *j)
{
    size_t count = sizeof shots / sizeof shots[0];
    size_t k;
    int rc = 0;

    for (k = 0; k < count && rc == 0; k++) {
        if (j->scene->frames & shots[k].flag) {
            rc = take(j, &shots[k]);
        }
        plft_progress("simulate", (double)(k + 1) / (double)count);
    }
    return rc;
}

static int write_frames(const plft_scene *scene, const char *folder)
{
    size_t n = (size_t)scene->cam.w * (size_t)scene->cam.h;
    job j = {scene, folder, NULL, {NULL, 0, 0, 1, 0}};
    int rc = PLFT_DATA;

    j.frame.w = scene->cam.w;
    j.frame.h = scene->cam.h;
    j.frame.bits = scene->sensor.bits;
    j.signal = plft_alloc(n, sizeof *j.signal);
    j.frame.px = plft_alloc(n, sizeof *j.frame.px);
    if (j.signal != NULL && j.frame.px != NULL) {
        rc = take_all(&j);
    }
    free(j.signal);
    free(j.frame.px);
    return rc;
}

static int write_maps(const plft_scene *scene, const char *folder, float *slope,
                      float *depth, uint16_t *id)
{
    plft_frame objects = {id, scene->cam.nx, scene->cam.ny, 1, 8};
    char path[3][4096];

    if (path_of(path[0], sizeof path[0], folder, "slope.pfm") ||
        path_of(path[1], sizeof path[1], folder, "depth_mm.pfm") ||
        path_of(path[2], sizeof path[2], folder, "objects.png")) {
        return PLFT_DATA;
    }
    plft_truth_maps(scene, slope, depth, id);
    if (plft_pfm_write(path[0], slope, objects.w, objects.h) ||
        plft_pfm_write(path[1], depth, objects.w, objects.h)) {
        return PLFT_DATA;
    }
    return plft_png_write(path[2], &objects);
}

static int write_truth(const plft_scene *scene, const char *folder)
{
    size_t n = (size_t)scene->cam.nx * (size_t)scene->cam.ny;
    float *slope = plft_alloc(n, sizeof *slope);
    float *depth = plft_alloc(n, sizeof *depth);
    uint16_t *id = plft_alloc(n, sizeof *id);
    int rc = PLFT_DATA;

    if (slope != NULL && depth != NULL && id != NULL) {
        rc = write_maps(scene, folder, slope, depth, id);
    }
    free(slope);
    free(depth);
    free(id);
    return rc;
}

static int write_centres(const plft_camera *cam, const char *folder)
{
    char path[4096];
    plft_out out;
    int i, j;

    if (path_of(path, sizeof path, folder, "centres.csv") ||
        plft_out_open(&out, path)) {
        return PLFT_DATA;
    }
    (void)fprintf(out.file, "row,col,x,y\n");
    for (j = 0; j < cam->ny; j++) {
        for (i = 0; i < cam->nx; i++) {
            double x, y;
            plft_camera_spot(cam, i, j, &x, &y);
            (void)fprintf(out.file, "%d,%d,%.6f,%.6f\n", j, i, x, y);
        }
    }
    return plft_out_commit(&out);
}

static int write_object(const char *folder, const char *file, json_t *json)
{
    char path[4096];
    int rc = PLFT_DATA;

    if (json != NULL && path_of(path, sizeof path, folder, file) == 0) {
        rc = plft_json_write(path, json);
    }
    json_decref(json);
    return rc;
}

/* The camera in the terms of `depth --optics`. */
static int write_optics(const plft_camera *cam, const char *folder)
{
    return write_object(folder, "optics.json",
                        json_pack("{sf sf sf sf sf}", "F_mm", cam->F, "focus_mm",
                                  cam->focus, "f_mu_mm", cam->f_mu, "pixel_mm",
                                  cam->pixel, "pitch_mm", cam->pitch));
}

/* What was used after defaults and derivation. */
static int write_resolved(const plft_scene *s, const char *folder)
{
    const plft_camera *cam = &s->cam;
    double diopter = 1000.0 * cam->f_mu * cam->pitch / (cam->L * cam->L * cam->pixel);

    return write_object(
        folder, "scene_resolved.json",
        json_pack("{sI si s[ii] s[ii] si sf sf sf sf sf sf sf si sf sf sf sf}", "seed",
                  (json_int_t)s->seed, "rays", s->rays, "sensor", cam->w, cam->h,
                  "lenses", cam->nx, cam->ny, "hex", cam->hex, "pupil_mm",
                  2.0 * cam->pupil_r, "stopped_pupil_mm", 2.0 * s->stopped_r,
                  "pupil_distance_mm", cam->L, "micro_image_pitch_px",
                  plft_camera_pitch_px(cam), "micro_image_radius_px",
                  plft_camera_radius_px(cam), "inv0", 1000.0 / cam->focus, "gain",
                  -diopter, "bits", s->sensor.bits, "full_well_e", s->sensor.full_well,
                  "read_noise_e", s->sensor.read_noise, "offset", s->sensor.offset,
                  "exposure", s->sensor.exposure));
}

static int simulate(const char *file, const char *folder)
{
    plft_scene scene;
    int rc = plft_scene_read(&scene, file);

    if (rc != 0) {
        return rc;
    }
    rc = make_folder(folder) || write_frames(&scene, folder) ||
                 write_truth(&scene, folder) || write_centres(&scene.cam, folder) ||
                 write_optics(&scene.cam, folder) || write_resolved(&scene, folder) ||
                 (scene.motion.frames > 0 && plft_sequence_write(&scene, folder))
             ? PLFT_DATA
             : 0;
    plft_scene_free(&scene);
    return rc;
}

int plft_cmd_simulate(int argc, char **argv)
{
    static const plft_usage usage = {
        "simulate", "SCENE.json -o DIR",
        "Frames of an imagined plenoptic camera with their truth: dots.png (stopped "
        "down),\nwhite.png, dark.png, scene.png (right-justified samples: give the "
        "other "
        "commands\n--bits as in the scene), slope.pfm, depth_mm.pfm, objects.png, "
        "centres.csv,\noptics.json, scene_resolved.json; a scene with motion also "
        "frame_00000.png ... and\nmotion.csv."};
    const char *folder = NULL;
    const char *file = NULL;
    const plft_option options[] = {{"-o", PLFT_TEXT, &folder, "DIR", 0, 0,
                                    "folder to write into; made if missing"},
                                   {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    int n, helped;
    int rc = plft_args(argc, argv, &usage, options, &file, 1, &n, &helped);

    if (rc != 0 || helped) {
        return rc;
    }
    if (n != 1 || folder == NULL) {
        return plft_fail(PLFT_USAGE, "simulate: want SCENE.json -o DIR");
    }
    return simulate(file, folder);
}
