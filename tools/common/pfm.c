/* SPDX-License-Identifier: MIT */
#include "common/pfm.h"

#include <ctype.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"
#include "common/out.h"

#define SIDE_MAX 32767

/* Next word of the header; leaves *at behind the one white space that ends it. */
static int word(const unsigned char *s, size_t n, size_t *at, char *to, size_t room)
{
    size_t k = 0;

    while (*at < n && isspace(s[*at])) {
        (*at)++;
    }
    while (*at < n && !isspace(s[*at]) && k + 1 < room) {
        to[k++] = (char)s[(*at)++];
    }
    to[k] = '\0';
    if (k == 0 || *at >= n || !isspace(s[*at])) {
        return PLFT_DATA;
    }
    (*at)++;
    return 0;
}

static int number(const unsigned char *s, size_t n, size_t *at, double *v)
{
    char text[32], *end;

    if (word(s, n, at, text, sizeof text) != 0) {
        return PLFT_DATA;
    }
    *v = strtod(text, &end);
    return *end == '\0' && isfinite(*v) ? 0 : PLFT_DATA;
}

static float sample(const unsigned char *p, int little)
{
    uint32_t bits = little ? (uint32_t)p[0] | (uint32_t)p[1] << 8 |
                                 (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24
                           : (uint32_t)p[3] | (uint32_t)p[2] << 8 |
                                 (uint32_t)p[1] << 16 | (uint32_t)p[0] << 24;
    float v;

    memcpy(&v, &bits, sizeof v);
    return v;
}

static int header(const unsigned char *s, size_t n, size_t *at, plft_map *map,
                  int *little)
{
    char magic[4];
    double w, h, scale;

    if (word(s, n, at, magic, sizeof magic) != 0 || strcmp(magic, "Pf") != 0 ||
        number(s, n, at, &w) != 0 || number(s, n, at, &h) != 0 ||
        number(s, n, at, &scale) != 0) {
        return PLFT_DATA;
    }
    if (w < 1 || h < 1 || w > SIDE_MAX || h > SIDE_MAX || w != floor(w) ||
        h != floor(h) || scale == 0.0) {
        return PLFT_DATA;
    }
    map->w = (int)w;
    map->h = (int)h;
    *little = scale < 0.0;
    return 0;
}

int plft_pfm_parse(plft_map *map, const unsigned char *s, size_t n, const char *name)
{
    size_t at = 0, i, count, w;
    int little = 1;

    memset(map, 0, sizeof *map);
    if (header(s, n, &at, map, &little) != 0) {
        return plft_fail(PLFT_DATA,
                         "%s: not a grey PFM map (header \"Pf\", size, scale)", name);
    }
    w = (size_t)map->w;
    count = w * (size_t)map->h;
    if (n - at != 4 * count) {
        return plft_fail(PLFT_DATA, "%s: %zu bytes of samples where %d x %d needs %zu",
                         name, n - at, map->w, map->h, 4 * count);
    }
    map->v = (float *)plft_alloc(count, sizeof *map->v);
    if (map->v == NULL) {
        return PLFT_DATA;
    }
    for (i = 0; i < count; i++) {
        size_t row = (size_t)map->h - 1 - i / w;
        map->v[row * w + i % w] = sample(s + at + 4 * i, little);
    }
    return 0;
}

int plft_pfm_read(plft_map *map, const char *path)
{
    unsigned char *bytes = NULL;
    size_t n = 0;
    int rc = plft_in_bytes(path, &bytes, &n);

    memset(map, 0, sizeof *map);
    if (rc == 0) {
        rc = plft_pfm_parse(map, bytes, n, path);
    }
    free(bytes);
    return rc;
}

int plft_pfm_write(const char *path, const float *v, int w, int h)
{
    plft_out out;
    int x, y;

    if (plft_out_open(&out, path) != 0) {
        return PLFT_DATA;
    }
    fprintf(out.file, "Pf\n%d %d\n-1.0\n", w, h);
    for (y = h - 1; y >= 0; y--) {
        for (x = 0; x < w; x++) {
            uint32_t bits;
            unsigned char le[4];
            memcpy(&bits, &v[(size_t)y * (size_t)w + (size_t)x], sizeof bits);
            le[0] = (unsigned char)(bits & 255u);
            le[1] = (unsigned char)(bits >> 8 & 255u);
            le[2] = (unsigned char)(bits >> 16 & 255u);
            le[3] = (unsigned char)(bits >> 24);
            (void)fwrite(le, 1, 4, out.file);
        }
    }
    return plft_out_commit(&out);
}

void plft_map_free(plft_map *map)
{
    free(map->v);
    memset(map, 0, sizeof *map);
}
