/* SPDX-License-Identifier: MIT */
#include "sim/film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"

#define PI      3.14159265358979323846
#define STREAMS 1000u /* noise of frame n: stream STREAMS + n */

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
static void project(const plft_camera *cam, plft_station *p)
{
    double x = p->at[0] * cam->L / p->at[2];
    double y = p->at[1] * cam->L / p->at[2];
    double c = cos(cam->rotation);
    double s = sin(cam->rotation);

    p->col = (c * x + s * y) / cam->pitch;
    p->row = (-s * x + c * y) / cam->pitch;
    p->slope = plft_camera_slope(cam, p->at[2]);
}

static int find_stations(plft_film *f)
{
    static const plft_pose none;
    const plft_motion *m = &f->scene->motion;
    int k;

    for (k = 0; k < m->stations; k++) {
        plft_station *p = &f->station[k];
        p->rest = look(f->scene, m->station[k]);
        if (p->rest.quad == NULL) {
            return plft_fail(PLFT_DATA, "motion: station %d sees nothing", k);
        }
        locate(&p->rest, &none, p->at);
        project(&f->scene->cam, p);
    }
    return 0;
}

/* ---- frames ---- */

static void add_instant(plft_film *f, plft_instant *mean, const plft_pose *pose,
                        double lamp)
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
        const plft_station *rest = &f->station[k];
        const plft_quad *q = rest->rest.quad;
        plft_station now = *rest;
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

static void trace_of(const plft_film *f, plft_trace *t)
{
    const plft_scene *s = f->scene;

    memset(t, 0, sizeof *t);
    t->cam = &s->cam;
    t->world = &s->world;
    t->pupil_r = s->cam.pupil_r;
    t->rays = s->rays;
    t->bayer = s->bayer;
    memcpy(t->colour, s->colour, sizeof t->colour);
}

/* Light of one instant added to the frame's. */
static int expose(plft_film *f, const plft_pose *pose, double lamp)
{
    size_t n = (size_t)f->frame.w * (size_t)f->frame.h;
    plft_trace trace;
    size_t k;

    trace_of(f, &trace);
    trace.pose = pose;
    if (plft_beams_frame(&f->beams, &trace, f->signal) != 0) {
        return plft_fail(PLFT_DATA, "simulate: out of memory");
    }
    for (k = 0; k < n; k++) {
        f->sum[k] += f->signal[k] * lamp / f->scene->motion.blur;
    }
    return 0;
}

/* Advance to sub-step `until` of the record. */
static void advance(plft_film *f, uint64_t until)
{
    plft_motion *m = &f->scene->motion;
    double all = (double)m->frames * PLFT_SUBSTEPS;

    while (f->steps < until) {
        plft_motion_step(m, f->steps, (double)f->steps / all);
        f->steps++;
    }
    plft_motion_bend(m, &f->scene->bend);
}

static void count(plft_film *f)
{
    plft_sensor_expose(&f->scene->sensor, f->sum, f->mask,
                       (uint32_t)f->frame.w * (uint32_t)f->frame.h, f->scene->seed,
                       STREAMS + (uint64_t)f->n, f->frame.px);
    f->n++;
}

/* Frames of a moving scene are counted from the first that moves. */
static int take(plft_film *f, plft_instant *mean)
{
    const plft_motion *m = &f->scene->motion;
    double begin = (f->n - f->stills) / m->rate;
    int k;

    mean->time = begin + 0.5 * m->expose;
    for (k = 0; k < m->blur; k++) {
        double t = begin + m->expose * (k + 0.5) / m->blur;
        plft_pose pose = plft_motion_pose(m, t);
        double lamp = plft_motion_lamp(m, t);
        advance(f, (uint64_t)floor(t * m->rate * PLFT_SUBSTEPS + 0.5));
        plft_world_swing(&f->scene->world, t);
        add_instant(f, mean, &pose, lamp);
        if (expose(f, &pose, lamp)) {
            return PLFT_DATA;
        }
    }
    return 0;
}

static int take_still(plft_film *f, plft_instant *mean)
{
    static const plft_pose rest;
    int k;

    memset(f->scene->bend.q, 0, sizeof f->scene->bend.q);
    mean->time = (f->n - f->scene->motion.rest) / f->scene->motion.rate;
    plft_world_swing(&f->scene->world, 0.0);
    for (k = 0; k < f->scene->motion.blur; k++) {
        add_instant(f, mean, &rest, 1.0);
        if (expose(f, &rest, 1.0)) {
            return PLFT_DATA;
        }
    }
    f->stills++;
    return 0;
}

int plft_film_next(plft_film *f, plft_instant *truth)
{
    int still = f->n < f->scene->motion.rest;
    int rc;

    memset(f->sum, 0, (size_t)f->frame.w * (size_t)f->frame.h * sizeof *f->sum);
    memset(truth, 0, sizeof *truth);
    rc = still ? take_still(f, truth) : take(f, truth);
    if (rc == 0) {
        count(f);
    }
    return rc;
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

int plft_film_open(plft_film *f, plft_scene *scene, const uint8_t *mask)
{
    size_t n = (size_t)scene->cam.w * (size_t)scene->cam.h;
    plft_trace trace;

    memset(f, 0, sizeof *f);
    f->scene = scene;
    f->mask = mask;
    f->frame.w = scene->cam.w;
    f->frame.h = scene->cam.h;
    f->frame.channels = 1;
    f->frame.bits = scene->sensor.bits;
    f->signal = plft_alloc(n, sizeof *f->signal);
    f->sum = plft_alloc(n, sizeof *f->sum);
    f->frame.px = plft_alloc(n, sizeof *f->frame.px);
    if (f->signal == NULL || f->sum == NULL || f->frame.px == NULL) {
        return PLFT_DATA;
    }
    trace_of(f, &trace);
    if (plft_beams_make(&f->beams, &trace, mask) != 0) {
        return plft_fail(PLFT_DATA, "simulate: out of memory");
    }
    plft_motion_start(&scene->motion, settle(&scene->motion));
    return find_stations(f);
}

void plft_film_close(plft_film *f)
{
    plft_beams_free(&f->beams);
    free(f->signal);
    free(f->sum);
    free(f->frame.px);
    memset(f, 0, sizeof *f);
}
