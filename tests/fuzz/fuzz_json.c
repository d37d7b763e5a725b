/* SPDX-License-Identifier: MIT
 * JSON as the tools read it: the bare object, or by the first byte a scene, the optics
 * or regions, through a file in memory. */
#define _GNU_SOURCE
#include "fuzz.h"

#include "common/json.h"
#include "common/optics.h"
#include "motion/regions.h"
#include "sim/scene.h"

#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

static void by_file(uint32_t kind, const char *path)
{
    static plfx_roi_cfg cfg;
    static plft_scene scene;
    plft_optics optics;

    if (kind == 1) {
        if (plft_scene_read(&scene, path) == 0) {
            plft_scene_free(&scene);
        }
    } else if (kind == 2) {
        (void)plft_optics_read(&optics, path, 1);
    } else {
        memset(&cfg, 0, sizeof cfg);
        (void)plft_regions_read(&cfg, path);
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
    uint32_t kind = fuzz_u8(&in) % 4u;
    uint8_t *copy = fuzz_rest(&in);
    json_t *root;

    if (kind != 0) {
        as_file(kind, copy, in.left);
    } else if (plft_json_parse(&root, (const char *)copy, in.left, "input") == 0) {
        double v = 1;
        (void)plft_json_real(root, "a", 0, 1, 1, &v, "input");
        json_decref(root);
    }
    free(copy);
    return 0;
}
