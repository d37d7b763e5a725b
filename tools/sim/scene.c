/* SPDX-License-Identifier: MIT
 * Scene files: camera, sensor and frames; scene_world.c reads the objects. */
#include "sim/scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/err.h"
#include "common/json.h"
#include "sim/scene_keys.h"
#include "sim/scene_motion.h"
#include "sim/scene_world.h"
#include "sim/trace.h"

#define PI 3.14159265358979323846

static int real(const plft_node *node, const char *key, double lo, double hi,
                int needed, double *v)
{
    return plft_json_real(node->json, key, lo, hi, needed, v, node->name);
}

/* Pupil radius from "pupil_mm" (a diameter), "working_f_number" (L over the diameter)
 * or "f_number" (F over it). */
static int read_pupil(plft_camera *cam, const plft_node *node)
{
    double L = 1.0 / (1.0 / cam->F - 1.0 / cam->focus);
    double diameter = 0.0;
    double number = 0.0;
    double working = 4.0;

    if (real(node, "pupil_mm", 0.01, 1000.0, 0, &diameter) ||
        real(node, "f_number", 0.5, 100.0, 0, &number) ||
        real(node, "working_f_number", 0.5, 100.0, 0, &working)) {
        return PLFT_DATA;
    }
    cam->pupil_r = 0.5 * (diameter > 0.0 ? diameter
                          : number > 0.0 ? cam->F / number
                                         : L / working);
    return 0;
}

static int read_lens(plft_camera *cam, const plft_node *node)
{
    double stop[2] = {0.0, 0.0};

    if (real(node, "F_mm", 1.0, 2000.0, 1, &cam->F) ||
        real(node, "focus_mm", 2.0, 1e6, 1, &cam->focus) ||
        plft_node_reals(node, "stop_mm", 2, 0.0, 1000.0, 0, stop)) {
        return PLFT_DATA;
    }
    if (cam->focus < 1.05 * cam->F) {
        return plft_fail(PLFT_DATA, "%s: \"focus_mm\" must be beyond \"F_mm\"",
                         node->name);
    }
    if (stop[0] >= 0.9 * cam->focus) {
        return plft_fail(PLFT_DATA, "%s: \"stop_mm\" lies at the focus plane",
                         node->name);
    }
    cam->stop_z = stop[0];
    cam->stop_r = 0.5 * stop[1];
    return read_pupil(cam, node);
}

static int read_array(plft_camera *cam, const plft_node *node)
{
    double lenses[2];
    double offset[2] = {0.0, 0.0};
    double degrees = 0.0;
    double jitter = 0.0;

    cam->fill = 1.0;
    if (real(node, "f_mu_mm", 0.01, 100.0, 1, &cam->f_mu) ||
        real(node, "pitch_mm", 0.005, 10.0, 1, &cam->pitch) ||
        real(node, "pixel_mm", 0.0005, 0.1, 1, &cam->pixel) ||
        plft_node_reals(node, "lenses", 2, 2.0, 2000.0, 1, lenses) ||
        real(node, "rotation_deg", -30.0, 30.0, 0, &degrees) ||
        plft_node_reals(node, "offset_px", 2, -100.0, 100.0, 0, offset) ||
        real(node, "jitter_px", 0.0, 1.0, 0, &jitter) ||
        real(node, "fill", 0.2, 1.0, 0, &cam->fill) ||
        real(node, "blur_px", 0.0, 1.0, 0, &cam->blur) ||
        plft_node_word(node, "lattice", "square|hex", &cam->hex)) {
        return PLFT_DATA;
    }
    cam->nx = (int)lenses[0];
    cam->ny = (int)lenses[1];
    cam->rotation = degrees * PI / 180.0;
    cam->offset_x = offset[0] * cam->pixel;
    cam->offset_y = offset[1] * cam->pixel;
    cam->jitter = jitter * cam->pixel;
    if (cam->pitch < 4.0 * cam->pixel || cam->pitch > 100.0 * cam->pixel) {
        return plft_fail(PLFT_DATA, "%s: a lens must be 4 to 100 pixels wide",
                         node->name);
    }
    return 0;
}

static int read_size(plft_camera *cam, const plft_node *node)
{
    double size[2] = {0.0, 0.0};

    if (plft_node_reals(node, "sensor", 2, 16.0, 16384.0, 0, size)) {
        return PLFT_DATA;
    }
    cam->w = (int)size[0];
    cam->h = (int)size[1];
    if (cam->w == 0 && cam->nx * cam->pitch / cam->pixel > 16000.0) {
        return plft_fail(PLFT_DATA, "%s: a sensor of over 16000 pixels", node->name);
    }
    return 0;
}

/* "dim": a list of [row, column, transmission]; 0 is a dead lens. */
static int read_dim(plft_camera *cam, const plft_node *node)
{
    const json_t *list = json_object_get(node->json, "dim");
    plft_node row = *node;
    int n, k;

    if (plft_node_count(node, "dim", 10000, &n)) {
        return PLFT_DATA;
    }
    for (k = 0; k < n; k++) {
        double v[3];
        row.json = json_pack("{sO}", "dim", json_array_get(list, (size_t)k));
        if (plft_node_reals(&row, "dim", 3, 0.0, 1e4, 1, v)) {
            json_decref((json_t *)(size_t)row.json);
            return PLFT_DATA;
        }
        json_decref((json_t *)(size_t)row.json);
        if (v[0] >= cam->ny || v[1] >= cam->nx || v[2] > 1.0) {
            return plft_fail(PLFT_DATA,
                             "%s: \"dim\"[%d] names no lens or a gain over 1",
                             node->name, k);
        }
        cam->gain[(size_t)v[0] * (size_t)cam->nx + (size_t)v[1]] = v[2];
    }
    return 0;
}

static int read_camera(plft_scene *scene, const plft_node *root)
{
    plft_camera *cam = &scene->cam;
    plft_node node;
    double stopped = 22.0;

    if (plft_node_child(&node, root, "camera") ||
        plft_node_only(
            &node, "F_mm focus_mm pupil_mm f_number working_f_number stop_mm f_mu_mm "
                   "pitch_mm pixel_mm lattice lenses rotation_deg offset_px "
                   "jitter_px fill blur_px sensor dim stopped_f_number") ||
        read_lens(cam, &node) || read_array(cam, &node) || read_size(cam, &node) ||
        real(&node, "stopped_f_number", 1.0, 200.0, 0, &stopped)) {
        return PLFT_DATA;
    }
    if (plft_camera_ready(cam, scene->seed) != 0) {
        return plft_fail(PLFT_DATA, "%s: out of memory", node.name);
    }
    scene->stopped_r = 0.5 * cam->L / stopped;
    return read_dim(cam, &node);
}

static int read_sensor(plft_scene *scene, const plft_node *root)
{
    plft_sensor *s = &scene->sensor;
    plft_node node;

    s->bits = 12;
    s->full_well = 20000.0;
    s->read_noise = 8.0;
    s->exposure = 0.9;
    if (plft_node_child(&node, root, "sensor") ||
        plft_node_only(&node,
                       "bits full_well_e read_noise_e offset prnu exposure bayer "
                       "colour") ||
        plft_node_int(&node, "bits", 8, 14, &s->bits) ||
        real(&node, "full_well_e", 0.0, 1e6, 0, &s->full_well) ||
        real(&node, "read_noise_e", 0.0, 1e4, 0, &s->read_noise) ||
        real(&node, "offset", 0.0, (double)(1 << s->bits) / 4.0, 0, &s->offset) ||
        real(&node, "prnu", 0.0, 0.2, 0, &s->prnu) ||
        real(&node, "exposure", 0.01, 4.0, 0, &s->exposure) ||
        plft_node_word(&node, "bayer", "none|rggb|grbg|gbrg|bggr", &scene->bayer) ||
        plft_node_reals(&node, "colour", 3, 0.0, 1.0, 0, scene->colour)) {
        return PLFT_DATA;
    }
    return 0;
}

static int read_frames(plft_scene *scene, const plft_node *root)
{
    static const char words[] = "dots|white|dark|scene";
    const json_t *list = json_object_get(root->json, "frames");
    int n, k;

    scene->frames =
        PLFT_FRAME_DOTS | PLFT_FRAME_WHITE | PLFT_FRAME_DARK | PLFT_FRAME_SCENE;
    if (list == NULL) {
        return 0;
    }
    if (plft_node_count(root, "frames", 4, &n)) {
        return PLFT_DATA;
    }
    scene->frames = 0;
    for (k = 0; k < n; k++) {
        plft_node item = *root;
        int which = 0;
        int rc;
        item.json = json_pack("{sO}", "frames", json_array_get(list, (size_t)k));
        rc = plft_node_word(&item, "frames", words, &which);
        json_decref((json_t *)(size_t)item.json);
        if (rc != 0) {
            return rc;
        }
        scene->frames |= 1u << which;
    }
    return 0;
}

static int read_root(plft_scene *scene, const plft_node *root)
{
    int seed = 1;

    scene->rays = 3;
    scene->colour[0] = scene->colour[1] = scene->colour[2] = 1.0;
    if (plft_node_only(root,
                       "about seed frames rays camera sensor sky objects motion") ||
        plft_node_int(root, "seed", 0, 1000000000, &seed) ||
        plft_node_int(root, "rays", 1, 8, &scene->rays)) {
        return PLFT_DATA;
    }
    scene->seed = (uint64_t)seed;
    if (read_frames(scene, root) || read_camera(scene, root) ||
        read_sensor(scene, root)) {
        return PLFT_DATA;
    }
    return plft_scene_world(scene, root) || plft_scene_motion(scene, root) ? PLFT_DATA
                                                                           : 0;
}

int plft_scene_read(plft_scene *scene, const char *path)
{
    json_t *json = NULL;
    plft_node root;
    int rc;

    memset(scene, 0, sizeof *scene);
    rc = plft_json_read(&json, path);
    if (rc != 0) {
        return rc;
    }
    root.json = json;
    (void)snprintf(root.name, sizeof root.name, "%.200s", path);
    rc = read_root(scene, &root);
    json_decref(json);
    if (rc != 0) {
        plft_scene_free(scene);
    }
    return rc;
}

void plft_scene_free(plft_scene *scene)
{
    plft_camera_free(&scene->cam);
    plft_world_free(&scene->world);
}
