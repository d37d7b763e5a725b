/* SPDX-License-Identifier: MIT
 * Scene files: the motion of a sequence. */
#include "sim/scene_motion.h"

#include "common/err.h"
#include "common/json.h"

#define PI 3.14159265358979323846

static int real(const plft_node *node, const char *key, double lo, double hi,
                int needed, double *v)
{
    return plft_json_real(node->json, key, lo, hi, needed, v, node->name);
}

static int read_mode(plft_mode *mode, const plft_node *node)
{
    mode->damping = 0.01;
    if (plft_node_only(node, "shape hz damping damping_end tip_rms_mm") ||
        plft_node_word(node, "shape", "bend1|bend2|torsion", &mode->shape) ||
        real(node, "hz", 0.01, 1e5, 1, &mode->hz) ||
        real(node, "damping", 1e-5, 0.5, 0, &mode->damping) ||
        real(node, "tip_rms_mm", 0.0, 1e3, 1, &mode->rms)) {
        return PLFT_DATA;
    }
    mode->damping_end = mode->damping;
    return real(node, "damping_end", 1e-5, 0.5, 0, &mode->damping_end);
}

static int read_modes(plft_motion *m, const plft_node *node)
{
    int k;

    if (plft_node_count(node, "modes", PLFT_MODES_MAX, &m->modes)) {
        return PLFT_DATA;
    }
    for (k = 0; k < m->modes; k++) {
        plft_node item;
        if (plft_node_item(&item, node, "modes", k) || read_mode(&m->mode[k], &item)) {
            return PLFT_DATA;
        }
        if (m->mode[k].hz > 0.5 * m->rate * PLFT_SUBSTEPS / 4.0) {
            return plft_fail(PLFT_DATA, "%s: \"hz\" is over twice the frame rate",
                             item.name);
        }
    }
    return 0;
}

/* "stations": [row, column] of lenses whose material points are followed. */
static int read_stations(plft_scene *scene, const plft_node *node)
{
    plft_motion *m = &scene->motion;
    const json_t *list = json_object_get(node->json, "stations");
    int k;

    if (plft_node_count(node, "stations", PLFT_STATIONS_MAX, &m->stations)) {
        return PLFT_DATA;
    }
    for (k = 0; k < m->stations; k++) {
        const json_t *at = json_array_get(list, (size_t)k);
        json_int_t row = json_integer_value(json_array_get(at, 0));
        json_int_t col = json_integer_value(json_array_get(at, 1));
        if (json_array_size(at) != 2 || row < 0 || col < 0 || row >= scene->cam.ny ||
            col >= scene->cam.nx) {
            return plft_fail(PLFT_DATA, "%s: \"stations\"[%d] names no lens",
                             node->name, k);
        }
        m->station[k][0] = (int)row;
        m->station[k][1] = (int)col;
    }
    return 0;
}

static int read_shake(plft_motion *m, const plft_node *node)
{
    double degrees = 0.0;

    if (real(node, "shake_mm", 0.0, 100.0, 0, &m->shake_mm) ||
        real(node, "shake_deg", 0.0, 2.0, 0, &degrees) ||
        real(node, "shake_hz", 0.0, 1e4, 0, &m->shake_hz) ||
        real(node, "flicker", 0.0, 1.0, 0, &m->flicker) ||
        real(node, "flicker_hz", 0.0, 1e5, 0, &m->flicker_hz)) {
        return PLFT_DATA;
    }
    m->shake_rad = degrees * PI / 180.0;
    return 0;
}

int plft_scene_motion(plft_scene *scene, const plft_node *root)
{
    plft_motion *m = &scene->motion;
    plft_node node;

    if (plft_node_child(&node, root, "motion")) {
        return PLFT_DATA;
    }
    if (node.json == NULL) {
        return 0;
    }
    m->rate = 200.0;
    m->blur = 1;
    m->frames = 100;
    m->shake_hz = 1.3;
    m->flicker_hz = 100.0;
    m->seed = scene->seed;
    if (plft_node_only(&node,
                       "frames rest rate_hz exposure_s blur_steps modes shake_mm "
                       "shake_deg shake_hz flicker flicker_hz stations") ||
        plft_node_int(&node, "frames", 1, 1000000, &m->frames) ||
        plft_node_int(&node, "rest", 0, 1000, &m->rest) ||
        real(&node, "rate_hz", 0.01, 1e5, 0, &m->rate) ||
        real(&node, "exposure_s", 0.0, 1.0 / m->rate, 0, &m->expose) ||
        plft_node_int(&node, "blur_steps", 1, PLFT_SUBSTEPS, &m->blur)) {
        return PLFT_DATA;
    }
    return read_modes(m, &node) || read_shake(m, &node) || read_stations(scene, &node)
               ? PLFT_DATA
               : 0;
}
