/* SPDX-License-Identifier: MIT
 * depth: the slope of every lens, and what follows from it. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "common/args.h"
#include "common/arrange.h"
#include "common/device.h"
#include "common/err.h"
#include "common/json.h"
#include "common/judge.h"
#include "common/match.h"
#include "depth_out.h"
#include "preset.h"

#define NOT_GIVEN (-1)

typedef struct request { /* as the command line names it */
    plft_source source;
    plft_views_wish wish;
    plft_depth_paths paths;
    const char *slopes, *optics, *device;
    int axes; /* 0 uv, 1 u */
    int cost, fuse, window, json;
    double texture, unique;
    int preset; /* plfx_preset_id, or NOT_GIVEN */
    double noise;
    int window_given, texture_given, band_pass;
} request;

typedef struct job { /* as it is run */
    plft_field field;
    plfx_cfg cfg;
    plfx_plan plan;
    plfx_map map;
    plft_optics optics;
    plft_depth_stats stats;
    plft_times times;
    double lo, hi;
    int device;
    int labels, found; /* found: slopes come from the scene */
    plft_preset preset;
} job;

static int parse_slopes(const char *text, job *j)
{
    char rest;
    double lo, hi;
    int n;

    if (sscanf(text, "%lf:%lf:%d%c", &lo, &hi, &n, &rest) != 3) {
        return plft_fail(PLFT_USAGE, "--slopes %s: want MIN:MAX:N", text);
    }
    if (!(lo < hi) || fabs(lo) > 28.0 || fabs(hi) > 28.0) {
        return plft_fail(PLFT_USAGE,
                         "--slopes %s: want MIN under MAX, both from -8 to 8 "
                         "(-28 to 28 between ready-made views)",
                         text);
    }
    if (n < PLFX_LABELS_MIN || n > PLFX_LABELS_MAX) {
        return plft_fail(PLFT_USAGE, "--slopes %s: want %d to %d slopes", text,
                         PLFX_LABELS_MIN, PLFX_LABELS_MAX);
    }
    j->lo = lo;
    j->hi = hi;
    j->labels = n;
    return 0;
}

/* Options that a preset settles: named, so that none is silently without effect. */
static const char *settled_by_preset(const request *r)
{
    return r->wish.method != NOT_GIVEN ? "--method"
           : r->cost != NOT_GIVEN      ? "--cost"
           : r->fuse != NOT_GIVEN      ? "--fuse"
           : r->wish.n != 0            ? "--views"
           : r->axes != NOT_GIVEN      ? "--axes"
           : r->wish.adjacent          ? "--adjacent"
           : r->wish.step > 0.0        ? "--step"
                                       : NULL;
}

static int check_preset(request *r)
{
    const char *settled = r->preset != NOT_GIVEN ? settled_by_preset(r) : NULL;

    if (settled != NULL) {
        return plft_fail(PLFT_USAGE, "%s has no effect with --preset; leave one out",
                         settled);
    }
    if (r->preset == NOT_GIVEN && r->noise >= 0.0) {
        return plft_fail(PLFT_USAGE, "--noise: want --preset too");
    }
    r->wish.method = r->wish.method == NOT_GIVEN ? PLFT_PLENOPTIC : r->wish.method;
    r->fuse = r->fuse == NOT_GIVEN ? PLFX_FUSE_MEDIAN : r->fuse;
    r->axes = r->axes == NOT_GIVEN ? 0 : r->axes;
    return 0;
}

static int check_request(request *r, job *j)
{
    int rc = check_preset(r);

    if (rc != 0) {
        return rc;
    }
    if (r->paths.slope == NULL) {
        return plft_fail(PLFT_USAGE, "want -o OUT.pfm");
    }
    if (r->window != 0 && r->window % 2 == 0) {
        return plft_fail(PLFT_USAGE, "--window %d: want an odd number", r->window);
    }
    if (r->wish.method == PLFT_SWEEP && r->cost == PLFX_COST_ZNCC) {
        return plft_fail(PLFT_USAGE, "--cost zncc: the sweep method sums SAD only");
    }
    if (r->paths.depth_mm != NULL && r->optics == NULL) {
        return plft_fail(PLFT_USAGE, "--depth-mm: want --optics O.json too");
    }
    if (r->preset != NOT_GIVEN && r->device != NULL && strcmp(r->device, "cpu") != 0) {
        return plft_fail(PLFT_USAGE, "--device %s: presets run on the core alone",
                         r->device);
    }
    j->found = r->slopes == NULL;
    if (r->slopes != NULL && parse_slopes(r->slopes, j) != 0) {
        return PLFT_USAGE;
    }
    rc = plft_device_parse(&j->device, r->device);
    return rc != 0 ? rc : plft_depth_check_paths(&r->paths);
}

static void fill_gates(const request *r, const job *j, plfx_cfg *c)
{
    double full = (double)((1 << j->field.bits) - 1);

    c->window = (uint8_t)r->window;
    c->texture = (uint16_t)lround(r->texture / 1000.0 * full * 16.0);
    c->unique_u16 = (uint16_t)lround(r->unique * 65535.0);
}

static void fill_cfg(const request *r, job *j)
{
    plfx_cfg *c = &j->cfg;
    int cost = r->cost != NOT_GIVEN           ? r->cost
               : r->wish.method == PLFT_SWEEP ? PLFX_COST_SAD
                                              : PLFX_COST_ZNCC;

    c->method = (uint8_t)(r->wish.method == PLFT_SWEEP      ? PLFX_METHOD_SWEEP
                          : r->wish.method == PLFT_GRADIENT ? PLFX_METHOD_GRADIENT
                                                            : PLFX_METHOD_PAIRS);
    c->cost = (uint8_t)cost;
    c->fit = (uint8_t)(cost == PLFX_COST_SAD ? PLFX_FIT_VEE : PLFX_FIT_PARABOLA);
    c->fuse = (uint8_t)r->fuse;
    c->bits = (uint8_t)j->field.bits;
    c->ref = 0;
    fill_gates(r, j, c);
}

/* Views in which slopes are looked for: those that will be matched; for a single pair,
 * which a repeating pattern fools, the rings of the plenoptic method. */
static int search_views(const request *r, job *j, plfx_cfg *cfg)
{
    plfx_cfg views = j->cfg;
    plft_views_wish wish;
    plft_preset preset;
    int n = 0, rc;

    if (r->preset != NOT_GIVEN) {
        memset(&preset, 0, sizeof preset);
        preset.id = r->preset;
        rc = plft_preset_cfg(&preset, &j->field, r->wish.radius, &views);
    } else if (r->wish.method == PLFT_BINOCULAR) {
        memset(&wish, 0, sizeof wish);
        wish.method = PLFT_PLENOPTIC;
        wish.radius = r->wish.radius;
        wish.u_only = r->axes;
        rc = plft_arrange(&j->field, &wish, views.at, &n);
        views.n = (uint8_t)n;
    } else {
        return 0;
    }
    memcpy(cfg->at, views.at, sizeof cfg->at);
    cfg->n = views.n;
    cfg->cost = views.cost;
    return rc;
}

static int search(const request *r, job *j)
{
    plfx_cfg cfg = j->cfg;
    int rc = search_views(r, j, &cfg);

    return rc != 0 ? rc
                   : plft_find_slopes(&j->field, &cfg, &j->lo, &j->hi, &j->labels,
                                      &j->times);
}

static int settle_slopes(const request *r, job *j)
{
    double scale = j->field.scale;
    int rc;

    if (r->wish.method == PLFT_GRADIENT && j->found) { /* not used, but must be valid */
        j->lo = -1.0;
        j->hi = 1.0;
        j->labels = PLFX_LABELS_MIN;
    } else if (j->found) {
        rc = search(r, j);
        if (rc != 0) {
            return rc;
        }
        j->lo *= scale;
        j->hi *= scale;
    }
    if (fmax(fabs(j->lo), fabs(j->hi)) > 8.0 * scale) {
        return plft_fail(PLFT_USAGE, "--slopes %g:%g: out of range, -%g to %g", j->lo,
                         j->hi, 8.0 * scale, 8.0 * scale);
    }
    j->cfg.slope_min_q16 = (int32_t)lround(j->lo / scale * 65536.0);
    j->cfg.slope_max_q16 = (int32_t)lround(j->hi / scale * 65536.0);
    j->cfg.labels = (uint16_t)j->labels;
    return 0;
}

/* Window and gates that the command line names go before the preset's. */
static void keep_given(const request *r, job *j)
{
    plfx_cfg given;

    fill_gates(r, j, &given);
    j->cfg.window = r->window_given ? given.window : j->cfg.window;
    j->cfg.texture = r->texture_given ? given.texture : j->cfg.texture;
    j->cfg.unique_u16 = r->unique > 0.0 ? given.unique_u16 : j->cfg.unique_u16;
}

/* Slopes given with their number keep it; otherwise the preset steps finely enough. */
static int apply_preset(const request *r, job *j)
{
    int labels = j->labels;
    int rc;

    if (r->preset == NOT_GIVEN) {
        return 0;
    }
    j->preset.id = r->preset;
    j->preset.noise = r->noise;
    rc = plft_preset_cfg(&j->preset, &j->field, r->wish.radius, &j->cfg);
    keep_given(r, j);
    j->cfg.labels = j->found ? j->cfg.labels : (uint16_t)labels;
    j->labels = j->cfg.labels;
    return rc;
}

static int match(const request *r, job *j)
{
    if (r->preset == NOT_GIVEN) {
        return plft_match(&j->plan, &j->field, &j->map, &j->times);
    }
    return plft_preset_match(&j->preset, &j->plan, &j->field, &j->map, &j->times);
}

static int prepare(request *r, job *j)
{
    int n = 0;
    int rc = plft_field_open(&j->field, &r->source);

    j->times.read = plft_cpu_s();
    if (rc != 0) {
        return rc;
    }
    j->field.device = j->device;
    j->field.band_pass = r->band_pass;
    if (r->optics != NULL) {
        rc = plft_optics_read(&j->optics, r->optics, j->field.lut == NULL);
    }
    r->window_given = r->window != 0;
    r->texture_given = r->texture >= 0.0;
    r->window = r->window != 0 ? r->window : plft_own_window(&j->field);
    if (rc == 0 && r->texture < 0.0) {
        rc = plft_find_texture(&j->field, r->axes || r->wish.method == PLFT_BINOCULAR,
                               &r->texture);
    }
    plft_field_rescale(&j->field, j->found ? 12.0 : fmax(fabs(j->lo), fabs(j->hi)));
    r->wish.u_only = r->axes;
    rc = rc != 0 ? rc : plft_arrange(&j->field, &r->wish, j->cfg.at, &n);
    j->cfg.n = (uint8_t)n;
    fill_cfg(r, j);
    if (rc == 0 && r->preset == NOT_GIVEN) { /* presets judge the views they take */
        rc = plft_judge_ready(&j->field, &j->cfg, &j->preset.left_out);
    }
    rc = rc != 0 ? rc : settle_slopes(r, j);
    rc = rc != 0 ? rc : apply_preset(r, j);
    return rc != 0 ? rc : plft_plan(&j->plan, &j->cfg, &j->field);
}

static json_t *views_json(const job *j)
{
    json_t *list = json_array();
    int k;

    for (k = 0; k < j->cfg.n; k++) {
        double unit = 256.0 * j->field.scale;
        (void)json_array_append_new(list, json_pack("[f,f]", j->cfg.at[k].u_q8 / unit,
                                                    j->cfg.at[k].v_q8 / unit));
    }
    return list;
}

static json_t *preset_json(const request *r)
{
    static const char *const names[PLFX_PRESETS] = {"stream", "onboard", "precise"};

    return r->preset == NOT_GIVEN ? json_null() : json_string(names[r->preset]);
}

static json_t *config_json(const request *r, const job *j)
{
    static const char *const methods[] = {"binocular", "plenoptic", "sweep",
                                          "gradient"};
    const plfx_cfg *c = &j->cfg;

    return json_pack("{s:o,s:i,s:f,s:s,s:s,s:s,s:s,s:i,s:[f,f,i],s:b,s:o,s:f,s:f,s:f,s:"
                     "b,s:f,s:i,s:f}",
                     "preset", preset_json(r), "views_left_out", j->preset.left_out,
                     "noise", j->preset.frame.noise_q4 / 16.0, "method",
                     r->preset == NOT_GIVEN ? methods[r->wish.method] : "arms", "cost",
                     c->cost == PLFX_COST_SAD ? "sad" : "zncc", "fit",
                     c->fit == PLFX_FIT_VEE ? "vee" : "parabola", "fuse",
                     c->fuse == PLFX_FUSE_MEDIAN ? "median" : "correlation", "window",
                     c->window, "slopes", j->lo, j->hi, j->labels, "slopes_found",
                     j->found, "views", views_json(j), "radius", r->wish.radius, "step",
                     r->wish.step, "texture", r->texture, "band_pass", r->band_pass,
                     "unique", r->unique, "view_bits", j->field.bits, "tone_gain",
                     j->field.tone_gain);
}

static json_t *flags_json(const plft_depth_stats *s)
{
    return json_pack(
        "{s:I,s:I,s:I,s:I,s:I,s:I,s:I}", "texture", (json_int_t)s->flags[0],
        "saturated", (json_int_t)s->flags[1], "occluded", (json_int_t)s->flags[2],
        "edge", (json_int_t)s->flags[3], "lens", (json_int_t)s->flags[4], "range_end",
        (json_int_t)s->flags[5], "unique", (json_int_t)s->flags[6]);
}

static json_t *real_or_null(double v)
{
    return isfinite(v) ? json_real(v) : json_null();
}

static int print_json(const request *r, const job *j)
{
    const plft_depth_stats *s = &j->stats;
    char crc[16];
    json_t *root;
    int rc;

    (void)snprintf(crc, sizeof crc, "%08x", (unsigned)j->field.table.lut.crc);
    root = json_pack(
        "{s:s,s:i,s:i,s:o,s:s,s:f,s:{s:o,s:o,s:o},s:o,s:{s:f,s:f,s:f,s:f}}", "output",
        r->paths.slope, "width", j->field.nx, "height", j->field.ny, "config",
        config_json(r, j), "table_crc", crc, "measured",
        (double)s->measured / (double)s->lenses, "slope", "p1", real_or_null(s->lo),
        "median", real_or_null(s->median), "p99", real_or_null(s->hi), "flags",
        flags_json(s), "cpu_s", "read", j->times.read, "extract", j->times.extract,
        "match", j->times.match, "write", j->times.write);
    rc = plft_json_print(root);
    json_decref(root);
    return rc;
}

#define END_SHARE 0.1 /* of the samples at the ends of the range: it is too narrow */

static void warn_of_range(const job *j)
{
    const plft_depth_stats *s = &j->stats;

    /* A range that was found is not the user's to widen. */
    if (!j->found && (double)s->flags[5] > END_SHARE * (double)s->lenses) {
        plft_warn("%.0f %% of the samples lie at the ends of the slopes %g:%g; widen "
                  "--slopes",
                  100.0 * (double)s->flags[5] / (double)s->lenses, j->lo, j->hi);
    }
}

static int report(const request *r, const job *j)
{
    const plft_depth_stats *s = &j->stats;

    warn_of_range(j);
    if (r->json) {
        return print_json(r, j);
    }
    printf("%s: %d x %d lenses, %.1f %% measured, slopes %.4g .. %.4g (1 to 99 %%), "
           "median %.4g\n",
           r->paths.slope, j->field.nx, j->field.ny,
           100.0 * (double)s->measured / (double)s->lenses, s->lo, s->hi, s->median);
    if (r->wish.method != PLFT_GRADIENT) {
        printf("slopes searched: %.5g:%.5g:%d%s\n", j->lo, j->hi, j->labels,
               j->found ? ", found from the scene" : "");
    }
    return 0;
}

static int run(const request *r, job *j)
{
    double t0;
    int rc = plft_slopes_alloc(&j->map, j->field.nx, j->field.ny);

    rc = rc != 0 ? rc : match(r, j);
    if (rc != 0) {
        return rc;
    }
    plft_flag_lenses(&j->field, &j->map);
    rc = plft_depth_count(&j->field, &j->map, &j->stats);
    t0 = plft_cpu_s();
    rc = rc != 0 ? rc
                 : plft_depth_write(&j->field, &j->map,
                                    r->optics != NULL ? &j->optics : NULL, &r->paths);
    j->times.write = plft_cpu_s() - t0;
    return rc != 0 ? rc : report(r, j);
}

static const plft_usage usage = {
    "depth",
    "RAW --lut CAM.plut -o OUT.pfm [options]\n"
    "   or: plenofix depth --views-dir DIR [--grid RxC] -o OUT.pfm [options]",
    "Slope of every lens (lens pitches per sensor pixel of view offset) as a PFM map;\n"
    "NaN where nothing was measured.  docs/units.md explains sign and units."};

int plft_cmd_depth(int argc, char **argv)
{
    request r;
    job j;
    const char *operand[1] = {NULL};
    int n, helped, rc;
    const plft_option own[] = {
        {"-o", PLFT_TEXT, &r.paths.slope, "OUT.pfm", 0, 0, "the map"},
        {"--method", PLFT_WORD, &r.wish.method, PLFT_METHODS, 0, 0, "how; plenoptic"},
        {"--preset", PLFT_WORD, &r.preset, PLFT_PRESET_NAMES, 0, 0,
         "settings instead of a method: docs/walkthrough.md"},
        {"--noise", PLFT_REAL, &r.noise, "S", 0, 16,
         "of a view, grey levels of 255, with --preset; measured"},
        {"--cost", PLFT_WORD, &r.cost, "sad|zncc", 0, 0,
         "of a window; zncc, sweep: sad"},
        {"--fuse", PLFT_WORD, &r.fuse, "median|correlation", 0, 0,
         "pairs into one slope; median"},
        {"--window", PLFT_INT, &r.window, "N", PLFX_WINDOW_MIN, PLFX_WINDOW_MAX,
         "lenses on a side, odd; 9, less for small views"},
        {"--slopes", PLFT_TEXT, &r.slopes, "MIN:MAX:N", 0, 0,
         "range and number of slopes; found from the scene"},
        {"--views", PLFT_INT, &r.wish.n, "N", 2, PLFX_VIEWS_MAX,
         "views in rings of 4 and the centre; 9"},
        {"--axes", PLFT_WORD, &r.axes, "uv|u", 0, 0, "u: horizontal pairs alone"},
        {"--adjacent", PLFT_FLAG, &r.wish.adjacent, NULL, 0, 0,
         "only the views one step from the centre: less occlusion"},
        {"--radius", PLFT_REAL, &r.wish.radius, "R", 0.1, 127,
         "of the outermost views, pixels; the table's"},
        {"--step", PLFT_REAL, &r.wish.step, "S", 0.1, 127,
         "of gradient and --adjacent, pixels; a third of R"},
        {"--band-pass", PLFT_FLAG, &r.band_pass, NULL, 0, 0,
         "match what repeats in 4 to 11 lenses: uneven brightness without --white"},
        {"--texture", PLFT_REAL, &r.texture, "T", 0, 255,
         "least mean gradient, 1/1000 of full scale; over the noise"},
        {"--unique", PLFT_REAL, &r.unique, "C", 0, 1, "least confidence; 0"},
        {"--confidence", PLFT_TEXT, &r.paths.confidence, "C.pfm", 0, 0, "0 to 1"},
        {"--sigma", PLFT_TEXT, &r.paths.sigma, "S.pfm", 0, 0,
         "standard error of the slope, where the method gives one"},
        {"--flags", PLFT_TEXT, &r.paths.flags, "F.png", 0, 0,
         "why a sample is missing or weak, a bit each"},
        {"--png", PLFT_TEXT, &r.paths.png, "P.png", 0, 0, "false colours with a bar"},
        {"--png16", PLFT_TEXT, &r.paths.png16, "P.png", 0, 0,
         "grey, 1 to 65535 from least to greatest slope"},
        {"--ply", PLFT_TEXT, &r.paths.ply, "P.ply", 0, 0, "point cloud"},
        {"--optics", PLFT_TEXT, &r.optics, "O.json", 0, 0,
         "line from slope to distance"},
        {"--depth-mm", PLFT_TEXT, &r.paths.depth_mm, "D.pfm", 0, 0,
         "distance from the main lens, mm"},
        {"--device", PLFT_TEXT, &r.device, "cpu|cl[:N]", 0, 0,
         "where it is computed, with the same answers; cpu"},
        {"--json", PLFT_FLAG, &r.json, NULL, 0, 0, "print configuration and figures"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    plft_option options[PLFT_OPTIONS_MAX];

    memset(&r, 0, sizeof r);
    plft_source_options(options, own, &r.source, 1);
    memset(&j, 0, sizeof j);
    r.wish.method = NOT_GIVEN;
    r.cost = NOT_GIVEN;
    r.fuse = NOT_GIVEN;
    r.axes = NOT_GIVEN;
    r.preset = NOT_GIVEN;
    r.noise = NOT_GIVEN;
    r.texture = NOT_GIVEN;
    rc = plft_args(argc, argv, &usage, options, operand, 1, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    r.source.raw = operand[0];
    rc = check_request(&r, &j);
    rc = rc != 0 ? rc : prepare(&r, &j);
    rc = rc != 0 ? rc : run(&r, &j);
    plft_slopes_free(&j.map);
    plft_field_free(&j.field);
    return rc;
}
