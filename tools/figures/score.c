/* SPDX-License-Identifier: MIT
 * figures score: a map against the truth of a simulated scene, as one row. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/frame.h"
#include "common/memory.h"
#include "common/pfm.h"
#include "figures/figures.h"

#define EDGE 5   /* lenses kept off depth edges and the border */
#define CLIP 0.1 /* largest error that is counted */

typedef struct tally {
    double *error; /* sizes of the errors on surfaces */
    int n, inner;  /* measured, all, on surfaces */
    int all, seen; /* of the map with truth, of those measured */
    int band;      /* object without texture that does not count, 0: none */
} tally;

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return x < y ? -1 : x > y;
}

/* Whether all lenses around see the same object. */
static int inside(const plft_frame *ids, int i, int j)
{
    int x, y;

    if (i < EDGE || j < EDGE || i >= ids->w - EDGE || j >= ids->h - EDGE) {
        return 0;
    }
    for (y = j - EDGE; y <= j + EDGE; y++) {
        for (x = i - EDGE; x <= i + EDGE; x++) {
            if (ids->px[y * ids->w + x] != ids->px[j * ids->w + i]) {
                return 0;
            }
        }
    }
    return 1;
}

static void count(tally *t, const plft_map *map, const plft_map *truth,
                  const plft_frame *ids)
{
    int k;

    for (k = 0; k < map->w * map->h; k++) {
        float v = map->v[k];
        float want = truth->v[k];
        int flat = inside(ids, k % map->w, k / map->w);
        if (isnan(want) || (t->band != 0 && ids->px[k] == t->band)) {
            continue;
        }
        t->all++;
        t->inner += flat;
        t->seen += !isnan(v);
        if (flat && !isnan(v)) {
            t->error[t->n++] = fmin(fabs((double)v - (double)want), CLIP);
        }
    }
}

/* Time and memory of `label` in the log of `figures run`. */
static void look_up(const char *path, const char *label, double *cpu, double *mib)
{
    FILE *log = fopen(path, "r");
    char line[256];
    size_t n = strlen(label);

    *cpu = *mib = NAN;
    while (log != NULL && fgets(line, sizeof line, log) != NULL) {
        if (strncmp(line, label, n) == 0 && line[n] == '\t') {
            (void)sscanf(line + n, "%lf %lf", cpu, mib);
        }
    }
    if (log != NULL) {
        (void)fclose(log);
    }
}

static void print_row(const char *label, tally *t, const char *log)
{
    double square = 0.0;
    double cpu, mib;
    int k;

    for (k = 0; k < t->n; k++) {
        square += t->error[k] * t->error[k];
    }
    qsort(t->error, (size_t)t->n, sizeof *t->error, by_value);
    look_up(log, label, &cpu, &mib);
    printf("%-40s %8.4f %8.4f %8.1f %8.2f %8.1f\n", label,
           t->n > 0 ? t->error[t->n / 2] : NAN, t->n > 0 ? sqrt(square / t->n) : NAN,
           100.0 * t->seen / t->all, cpu, mib);
}

static int score(char **argv, plft_map *map, plft_map *truth, plft_frame *ids)
{
    tally t = {NULL, 0, 0, 0, 0, 0};

    t.band = argv[6] != NULL ? atoi(argv[6]) : 0;
    if (plft_pfm_read(map, argv[2]) || plft_pfm_read(truth, argv[3]) ||
        plft_frame_read(ids, argv[4], 8)) {
        return PLFT_DATA;
    }
    if (map->w != truth->w || map->h != truth->h || ids->w != map->w ||
        ids->h != map->h) {
        return plft_fail(PLFT_DATA, "score: %s and %s differ in size", argv[2],
                         argv[3]);
    }
    t.error = plft_alloc((size_t)map->w * (size_t)map->h, sizeof *t.error);
    if (t.error == NULL) {
        return PLFT_DATA;
    }
    count(&t, map, truth, ids);
    print_row(argv[1], &t, argv[5]);
    free(t.error);
    return 0;
}

int plft_figure_score(int argc, char **argv)
{
    plft_map map = {NULL, 0, 0};
    plft_map truth = {NULL, 0, 0};
    plft_frame ids;
    int rc;

    if (argc != 6 && argc != 7) {
        return plft_fail(PLFT_USAGE, "score: want LABEL MAP TRUTH OBJECTS LOG [BAND]");
    }
    memset(&ids, 0, sizeof ids);
    rc = score(argv, &map, &truth, &ids);
    plft_map_free(&map);
    plft_map_free(&truth);
    plft_frame_free(&ids);
    return rc;
}
