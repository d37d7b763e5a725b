/* SPDX-License-Identifier: MIT */
#include "sim/sequence.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/frame.h"
#include "common/memory.h"
#include "common/out.h"
#include "common/progress.h"
#include "sim/trace.h"

#define PI      3.14159265358979323846
#define STREAMS 1000u /* noise of frame n: stream STREAMS + n */

typedef struct point { /* followed from its place at rest */
    plft_hit rest;
    double at[3]; /* camera coordinates, mm */
    double col, row, slope;
} point;

typedef struct film {
    plft_scene *scene;
    const char *folder;
    double *signal, *sum; /* [h][w] */
    plft_frame frame;
    plft_out csv;
    point *station;
    uint64_t steps; /* sub-steps taken */
} film;

/* ---- stations ---- */

static plft_hit look(const plft_scene *scene, const int lens[2])
{
    const plft_camera *cam = &scene->cam;
    const double *c =
        cam->centre + 2 * ((size_t)lens[0] * (size_t)cam->nx + (size_t)lens[1]);
    double k = 1.0 + cam->f_mu / cam->L;
    plft_ray ray = plft_trace_ray(cam, c[0], c[1], c[0], c[1], c[0] * k, c[1] * k);

    return plft_world_trace(&scene->world, &ray);
}

/* Where a material point stands now in camera coordinates. */
static void locate(const plft_hit *hit, const plft_pose *pose, double at[3])
{
    const plft_quad *q = hit->quad;
    double lift = q->bend != NULL ? plft_bend_at(q->bend, hit->a, hit->b) : 0.0;
    double world[3];
    int k;

    for (k = 0; k < 3; k++) {
        world[k] = q->o[k] + hit->a * q->e1[k] + hit->b * q->e2[k] - lift * q->n[k];
    }
    plft_pose_inverse(pose, world, at);
}

/* Lens coordinates and slope of a point seen through the middle of the pupil. */
static void project(const plft_camera *cam, point *p)
{
    double x = p->at[0] * cam->L / p->at[2];
    double y = p->at[1] * cam->L / p->at[2];
    double c = cos(cam->rotation);
    double s = sin(cam->rotation);

    p->col = (c * x + s * y) / cam->pitch;
    p->row = (-s * x + c * y) / cam->pitch;
    p->slope = plft_camera_slope(cam, p->at[2]);
}

static int find_stations(film *f)
{
    static const plft_pose none;
    const plft_motion *m = &f->scene->motion;
    int k;

    f->station = plft_alloc((size_t)m->stations, sizeof *f->station);
    if (f->station == NULL) {
        return PLFT_DATA;
    }
    for (k = 0; k < m->stations; k++) {
        point *p = &f->station[k];
        p->rest = look(f->scene, m->station[k]);
        if (p->rest.quad == NULL) {
            return plft_fail(PLFT_DATA, "motion: station %d sees nothing", k);
        }
        locate(&p->rest, &none, p->at);
        project(&f->scene->cam, p);
    }
    return 0;
}

/* ---- the record ---- */

static void header(film *f)
{
    int k;

    (void)fprintf(f->csv.file,
                  "frame,time_s,lamp,bend1_mm,bend2_mm,torsion_mm,shake_x_mm,"
                  "shake_y_mm,shake_z_mm,turn_x_deg,turn_y_deg,turn_z_deg");
    for (k = 0; k < f->scene->motion.stations; k++) {
        (void)fprintf(f->csv.file, ",s%d_w_mm,s%d_col,s%d_row,s%d_slope", k, k, k, k);
    }
    (void)fputc('\n', f->csv.file);
}

typedef struct instant { /* means over the exposure */
    double lamp;
    double q[PLFT_SHAPES];
    plft_pose pose;
    double move[PLFT_STATIONS_MAX][4]; /* w mm, columns, rows, slope */
} instant;

static void add_instant(film *f, instant *mean, const plft_pose *pose, double lamp)
{
    const plft_motion *m = &f->scene->motion;
    double part = 1.0 / m->blur;
    int k;

    mean->lamp += part * lamp;
    for (k = 0; k < PLFT_SHAPES; k++) {
        mean->q[k] += part * f->scene->bend.q[k];
    }
    for (k = 0; k < 3; k++) {
        mean->pose.shift[k] += part * pose->shift[k];
        mean->pose.turn[k] += part * pose->turn[k];
    }
    for (k = 0; k < m->stations; k++) {
        const point *rest = &f->station[k];
        const plft_quad *q = rest->rest.quad;
        point now = *rest;
        locate(&rest->rest, pose, now.at);
        project(&f->scene->cam, &now);
        mean->move[k][0] +=
            part *
            (q->bend != NULL ? plft_bend_at(q->bend, rest->rest.a, rest->rest.b) : 0.0);
        mean->move[k][1] += part * (now.col - rest->col);
        mean->move[k][2] += part * (now.row - rest->row);
        mean->move[k][3] += part * (now.slope - rest->slope);
    }
}

static void record(film *f, int n, double t, const instant *i)
{
    FILE *csv = f->csv.file;
    int k;

    (void)fprintf(csv, "%d,%.6f,%.5f,%.6f,%.6f,%.6f", n, t, i->lamp, i->q[0], i->q[1],
                  i->q[2]);
    for (k = 0; k < 3; k++) {
        (void)fprintf(csv, ",%.6f", i->pose.shift[k]);
    }
    for (k = 0; k < 3; k++) {
        (void)fprintf(csv, ",%.6f", i->pose.turn[k] * 180.0 / PI);
    }
    for (k = 0; k < f->scene->motion.stations; k++) {
        (void)fprintf(csv, ",%.6f,%.7f,%.7f,%.8f", i->move[k][0], i->move[k][1],
                      i->move[k][2], i->move[k][3]);
    }
    (void)fputc('\n', csv);
}

/* ---- frames ---- */

/* Light of one instant added to the frame's. */
static int expose(film *f, const plft_pose *pose, double lamp)
{
    const plft_scene *s = f->scene;
    size_t n = (size_t)s->cam.w * (size_t)s->cam.h;
    plft_trace trace;
    size_t k;

    memset(&trace, 0, sizeof trace);
    trace.cam = &s->cam;
    trace.world = &s->world;
    trace.pose = pose;
    trace.pupil_r = s->cam.pupil_r;
    trace.rays = s->rays;
    trace.bayer = s->bayer;
    memcpy(trace.colour, s->colour, sizeof trace.colour);
    if (plft_trace_frame(&trace, f->signal) != 0) {
        return plft_fail(PLFT_DATA, "simulate: out of memory");
    }
    for (k = 0; k < n; k++) {
        f->sum[k] += f->signal[k] * lamp / s->motion.blur;
    }
    return 0;
}

/* Advance to sub-step `until` of the record. */
static void advance(film *f, uint64_t until)
{
    plft_motion *m = &f->scene->motion;
    double all = (double)m->frames * PLFT_SUBSTEPS;

    while (f->steps < until) {
        plft_motion_step(m, f->steps, (double)f->steps / all);
        f->steps++;
    }
    plft_motion_bend(m, &f->scene->bend);
}

static int save(film *f, int n)
{
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/frame_%05d.png", f->folder, n);

    if (length < 0 || (size_t)length >= sizeof path) {
        return plft_fail(PLFT_DATA, "%s: path too long", f->folder);
    }
    plft_sensor_expose(&f->scene->sensor, f->sum,
                       (uint32_t)f->frame.w * (uint32_t)f->frame.h, f->scene->seed,
                       STREAMS + (uint64_t)n, f->frame.px);
    return plft_png_write(path, &f->frame);
}

static int take(film *f, int n)
{
    const plft_motion *m = &f->scene->motion;
    size_t size = (size_t)f->frame.w * (size_t)f->frame.h * sizeof *f->sum;
    double begin = n / m->rate;
    instant mean;
    int k;

    memset(f->sum, 0, size);
    memset(&mean, 0, sizeof mean);
    for (k = 0; k < m->blur; k++) {
        double t = begin + m->expose * (k + 0.5) / m->blur;
        plft_pose pose = plft_motion_pose(m, t);
        double lamp = plft_motion_lamp(m, t);
        advance(f, (uint64_t)floor(t * m->rate * PLFT_SUBSTEPS + 0.5));
        plft_world_swing(&f->scene->world, t);
        add_instant(f, &mean, &pose, lamp);
        if (expose(f, &pose, lamp)) {
            return PLFT_DATA;
        }
    }
    record(f, n, begin + 0.5 * m->expose, &mean);
    return save(f, n);
}

static int roll(film *f)
{
    int frames = f->scene->motion.frames;
    int n;

    if (f->signal == NULL || f->sum == NULL || f->frame.px == NULL ||
        find_stations(f)) {
        return PLFT_DATA;
    }
    header(f);
    for (n = 0; n < frames; n++) {
        if (take(f, n)) {
            return PLFT_DATA;
        }
        plft_progress("sequence", (double)(n + 1) / frames);
    }
    return plft_out_commit(&f->csv);
}

/* Longest time constant of the modes, times five, so that the record starts in the
 * steady state; at most a minute. */
static double settle(const plft_motion *m)
{
    double longest = 0.0;
    int k;

    for (k = 0; k < m->modes; k++) {
        double tau = 1.0 / (2.0 * PI * m->mode[k].hz * m->mode[k].damping);
        longest = tau > longest ? tau : longest;
    }
    return fmin(5.0 * longest, 60.0);
}

int plft_sequence_write(plft_scene *scene, const char *folder)
{
    size_t n = (size_t)scene->cam.w * (size_t)scene->cam.h;
    char path[4096];
    film f;
    int rc, length;

    memset(&f, 0, sizeof f);
    length = snprintf(path, sizeof path, "%s/motion.csv", folder);
    if (length < 0 || (size_t)length >= sizeof path || plft_out_open(&f.csv, path)) {
        return PLFT_DATA;
    }
    f.scene = scene;
    f.folder = folder;
    f.frame.w = scene->cam.w;
    f.frame.h = scene->cam.h;
    f.frame.channels = 1;
    f.frame.bits = scene->sensor.bits;
    f.signal = plft_alloc(n, sizeof *f.signal);
    f.sum = plft_alloc(n, sizeof *f.sum);
    f.frame.px = plft_alloc(n, sizeof *f.frame.px);
    plft_motion_start(&scene->motion, settle(&scene->motion));
    rc = roll(&f);
    plft_out_abort(&f.csv);
    free(f.signal);
    free(f.sum);
    free(f.frame.px);
    free(f.station);
    return rc;
}
