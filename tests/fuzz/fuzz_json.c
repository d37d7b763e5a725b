/* SPDX-License-Identifier: MIT
 * What the tools read as JSON or as regions: the bare object, or by the first byte a
 * scene, the optics, regions and their places, through a file in memory, or the
 * views.json of a folder. */
#define _GNU_SOURCE
#include "fuzz.h"

#include "common/json.h"
#include "common/optics.h"
#include "common/views_json.h"
#include "motion/regions.h"
#include "sim/scene.h"
#include "sim/texture.h"

#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

/* In place of the maker of textures (the linker's --wrap), which reads nothing and
 * takes half a second: what it is asked for is within its bounds. */
int __wrap_plft_texture_make(plft_texture *t, const plft_texture_desc *desc,
                             double texel_mm, int n);
int __wrap_plft_texture_make(plft_texture *t, const plft_texture_desc *desc,
                             double texel_mm, int n)
{
    fuzz_must(n >= 1 && n <= 1024 && texel_mm > 0);
    memset(t, 0, sizeof *t);
    t->n = n;
    t->texel = texel_mm;
    t->mean = desc->mean;
    return 0;
}

/* Views of a folder that holds nothing else. */
static void views(const uint8_t *bytes, size_t n)
{
    char folder[] = "/tmp/plenofix-fuzz-XXXXXX";
    char path[sizeof folder + 16];
    plft_field field;
    FILE *file;

    fuzz_must(mkdtemp(folder) != NULL);
    (void)snprintf(path, sizeof path, "%s/views.json", folder);
    file = fopen(path, "wb");
    fuzz_must(file != NULL);
    (void)fwrite(bytes, 1, n, file);
    (void)fclose(file);
    memset(&field, 0, sizeof field);
    if (plft_views_json_read(&field, folder) == 0) {
        fuzz_must(field.n_ready >= 2 && field.nx >= 1 && field.ny >= 1);
    }
    plft_field_free(&field);
    (void)unlink(path);
    (void)rmdir(folder);
}

static void by_file(uint32_t kind, const char *path)
{
    static plfx_roi_cfg cfg;
    static plft_scene scene;
    static double place[PLFX_ROI_MAX][3];
    plft_optics optics;
    int known;

    if (kind == 1) {
        if (plft_scene_read(&scene, path) == 0) {
            plft_scene_free(&scene);
        }
    } else if (kind == 2) {
        (void)plft_optics_read(&optics, path, 0);
        (void)plft_optics_read(&optics, path, 1);
    } else {
        memset(&cfg, 0, sizeof cfg);
        if (plft_regions_read(&cfg, path) == 0) {
            fuzz_must(cfg.regions >= 1 && cfg.regions <= PLFX_ROI_MAX);
            (void)plft_regions_places(path, place, &known);
        }
    }
}

static void as_file(uint32_t kind, const uint8_t *bytes, size_t n)
{
    int file = memfd_create("input", 0);
    char path[32];

    if (file >= 0 && write(file, bytes, n) == (ssize_t)n) {
        (void)snprintf(path, sizeof path, "/proc/self/fd/%d", file);
        by_file(kind, path);
    }
    if (file >= 0) {
        (void)close(file);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint32_t kind = fuzz_u8(&in) % 5u;
    uint8_t *copy = fuzz_rest(&in);
    json_t *root;

    if (kind == 4) {
        views(copy, in.left);
    } else if (kind != 0) {
        as_file(kind, copy, in.left);
    } else if (plft_json_parse(&root, (const char *)copy, in.left, "input") == 0) {
        double v = 1;
        (void)plft_json_real(root, "a", 0, 1, 1, &v, "input");
        json_decref(root);
    }
    free(copy);
    return 0;
}
