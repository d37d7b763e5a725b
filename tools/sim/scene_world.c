/* SPDX-License-Identifier: MIT
 * Scene files: objects and their textures. */
#include "sim/scene_world.h"

#include <math.h>
#include <string.h>

#include "common/err.h"
#include "common/json.h"
#include "common/memory.h"

#define PI          3.14159265358979323846
#define OBJECTS_MAX 100
#define TILE_MIN    64 /* texels on a side */
#define TILE_MAX    1024

enum { SHAPE_PLANE, SHAPE_RECT, SHAPE_BOX, SHAPE_WING };

typedef struct builder {
    plft_scene *scene;
    const plft_node *node;
    int shape;
    double at[3];   /* middle of the front, mm */
    double size[3]; /* w, h, depth; 0: without end */
    plft_quad front;
} builder;

static int real(const plft_node *node, const char *key, double lo, double hi,
                int needed, double *v)
{
    return plft_json_real(node->json, key, lo, hi, needed, v, node->name);
}

static int read_texture(plft_texture_desc *d, const builder *b, int index)
{
    plft_node node;
    int pattern = PLFT_PATTERN_NOISE;
    int seed = index + 1;
    double pips[2] = {2.0, 3.0};

    memset(d, 0, sizeof *d);
    d->mean = 0.5;
    d->contrast = 0.18;
    d->cell_mm = 5.0;
    d->octaves = 3;
    d->persistence = 0.8;
    if (plft_node_child(&node, b->node, "texture") ||
        plft_node_only(&node,
                       "pattern mean contrast cell_mm octaves persistence soft_mm "
                       "seed pips") ||
        plft_node_word(&node, "pattern", "none|noise|speckle|checker|domino",
                       &pattern) ||
        real(&node, "mean", 0.0, 1.0, 0, &d->mean) ||
        real(&node, "contrast", 0.0, 1.0, 0, &d->contrast) ||
        real(&node, "cell_mm", 0.01, 10000.0, 0, &d->cell_mm) ||
        plft_node_int(&node, "octaves", 1, 8, &d->octaves) ||
        real(&node, "persistence", 0.0, 2.0, 0, &d->persistence) ||
        real(&node, "soft_mm", 0.0, 10000.0, 0, &d->soft_mm) ||
        plft_node_int(&node, "seed", 0, 1000000000, &seed) ||
        plft_node_reals(&node, "pips", 2, 0.0, 6.0, 0, pips)) {
        return PLFT_DATA;
    }
    d->pattern = (plft_pattern)pattern;
    d->pips[0] = (int)pips[0];
    d->pips[1] = (int)pips[1];
    d->face_mm[0] = b->size[0];
    d->face_mm[1] = b->size[1];
    d->seed = b->scene->seed * 1000003u + (uint64_t)seed;
    return 0;
}

/* Texels a quarter of a lens' footprint at the object, at most TILE_MAX of them; a tile
 * as large as the object, if that many do. */
static int draw_texture(const builder *b, int index)
{
    const plft_camera *cam = &b->scene->cam;
    double texel = 0.25 * cam->pitch * b->at[2] / cam->L;
    double extent = b->size[0] > b->size[1] ? b->size[0] : b->size[1];
    plft_texture_desc d;
    int n = TILE_MIN;

    if (read_texture(&d, b, index)) {
        return PLFT_DATA;
    }
    if (d.pattern == PLFT_PATTERN_DOMINO && extent <= 0.0) {
        return plft_fail(PLFT_DATA, "%s: a domino needs \"size_mm\"", b->node->name);
    }
    while (n < TILE_MAX && (extent <= 0.0 || n * texel < extent)) {
        n *= 2;
    }
    if (d.pattern == PLFT_PATTERN_DOMINO && n * texel < extent) {
        texel = extent / n;
    }
    if (d.pattern == PLFT_PATTERN_CHECKER) { /* a whole even number of squares */
        double pairs = ceil(n * texel / (2.0 * d.cell_mm));
        texel = pairs * 2.0 * d.cell_mm / n;
    }
    if (plft_texture_make(&b->scene->world.texture[index], &d, texel, n) != 0) {
        return plft_fail(PLFT_DATA, "%s: out of memory", b->node->name);
    }
    b->scene->world.textures = index + 1;
    return 0;
}

/* Axes of a surface turned by yaw about Y, then by pitch about its own horizontal. */
static void turn(plft_quad *q, double yaw_deg, double pitch_deg)
{
    double cy = cos(yaw_deg * PI / 180.0);
    double sy = sin(yaw_deg * PI / 180.0);
    double cp = cos(pitch_deg * PI / 180.0);
    double sp = sin(pitch_deg * PI / 180.0);
    const double e1[3] = {cy, 0.0, sy};
    const double e2[3] = {-sp * sy, cp, sp * cy};

    memcpy(q->e1, e1, sizeof e1);
    memcpy(q->e2, e2, sizeof e2);
}

static void add_quad(const builder *b, const plft_quad *q)
{
    plft_world *world = &b->scene->world;

    world->quad[world->quads] = *q;
    memcpy(world->quad[world->quads].home, q->o, sizeof q->o);
    plft_quad_ready(&world->quad[world->quads]);
    world->quads++;
}

static void step(double out[3], const double from[3], const double along[3], double by)
{
    int k;

    for (k = 0; k < 3; k++) {
        out[k] = from[k] + by * along[k];
    }
}

/* The four faces that run back from the edges of the front. */
static void add_sides(const builder *b)
{
    plft_quad side = b->front;
    const plft_quad *f = &b->front;
    double corner[3];
    int k;

    side.id += PLFT_ID_SIDE;
    for (k = 0; k < 2; k++) { /* left and right: texture continues round the edge */
        step(side.o, f->o, f->e1, k ? f->w : 0.0);
        memcpy(side.e1, f->n, sizeof side.e1);
        memcpy(side.e2, f->e2, sizeof side.e2);
        side.w = b->size[2];
        side.h = f->h;
        side.shift[0] = f->shift[0] + (k ? f->w : 0.5 * f->w);
        side.shift[1] = f->shift[1];
        add_quad(b, &side);
    }
    for (k = 0; k < 2; k++) { /* top and bottom */
        step(corner, f->o, f->e2, k ? f->h : 0.0);
        memcpy(side.o, corner, sizeof corner);
        memcpy(side.e1, f->e1, sizeof side.e1);
        memcpy(side.e2, f->n, sizeof side.e2);
        side.w = f->w;
        side.h = b->size[2];
        side.shift[0] = f->shift[0];
        side.shift[1] = f->shift[1] + (k ? f->h : 0.5 * f->h);
        add_quad(b, &side);
    }
}

static int read_place(builder *b)
{
    const plft_node *node = b->node;

    if (b->shape == SHAPE_PLANE) {
        return real(node, "z_mm", 1.0, 1e6, 1, &b->at[2]);
    }
    if (plft_node_reals(node, "at_mm", 3, -1e6, 1e6, 1, b->at) ||
        plft_node_reals(node, "size_mm", b->shape == SHAPE_BOX ? 3 : 2, 0.01, 1e6, 1,
                        b->size)) {
        return PLFT_DATA;
    }
    if (b->at[2] < 1.0) {
        return plft_fail(PLFT_DATA, "%s: \"at_mm\"[2] must lie before the lens",
                         node->name);
    }
    return 0;
}

static int read_object(builder *b, int index)
{
    plft_quad *q = &b->front;
    double yaw = 0.0;
    double pitch = 0.0;

    memset(q, 0, sizeof *q);
    q->rgb[0] = q->rgb[1] = q->rgb[2] = 1.0;
    if (plft_node_only(
            b->node,
            "name type z_mm at_mm size_mm yaw_deg pitch_deg texture rgb swing_mm "
            "swing_hz") ||
        plft_node_word(b->node, "type", "plane|rect|box|wing", &b->shape) ||
        read_place(b) || real(b->node, "yaw_deg", -80.0, 80.0, 0, &yaw) ||
        real(b->node, "pitch_deg", -80.0, 80.0, 0, &pitch) ||
        plft_node_reals(b->node, "rgb", 3, 0.0, 1.0, 0, q->rgb) ||
        plft_node_reals(b->node, "swing_mm", 3, -1e4, 1e4, 0, q->swing) ||
        real(b->node, "swing_hz", 0.0, 1e4, 0, &q->swing_hz) ||
        draw_texture(b, index)) {
        return PLFT_DATA;
    }
    turn(q, yaw, pitch);
    step(q->o, b->at, q->e1, -0.5 * b->size[0]);
    step(q->o, q->o, q->e2, -0.5 * b->size[1]);
    q->w = b->size[0];
    q->h = b->size[1];
    if (b->shape == SHAPE_WING) {
        b->scene->bend.span = q->w;
        b->scene->bend.chord = q->h;
        q->bend = &b->scene->bend;
    }
    q->texture = index;
    q->id = index + 1;
    plft_quad_ready(q);
    add_quad(b, q);
    if (b->shape == SHAPE_BOX) {
        add_sides(b);
    }
    return 0;
}

int plft_scene_world(plft_scene *scene, const plft_node *root)
{
    plft_world *world = &scene->world;
    int n, k;

    if (plft_node_count(root, "objects", OBJECTS_MAX, &n) ||
        real(root, "sky", 0.0, 1.0, 0, &world->sky)) {
        return PLFT_DATA;
    }
    world->quad = plft_alloc(5 * (size_t)n, sizeof *world->quad);
    world->texture = plft_alloc((size_t)n, sizeof *world->texture);
    if (world->quad == NULL || world->texture == NULL) {
        return PLFT_DATA;
    }
    for (k = 0; k < n; k++) {
        plft_node node;
        builder b;
        memset(&b, 0, sizeof b);
        b.scene = scene;
        b.node = &node;
        if (plft_node_item(&node, root, "objects", k) || read_object(&b, k)) {
            return PLFT_DATA;
        }
    }
    return 0;
}
