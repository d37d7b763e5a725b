/* SPDX-License-Identifier: MIT
 * figures: what tools/demo needs besides plenofix itself. */
#include <stdio.h>
#include <string.h>

#include "common/err.h"
#include "figures/figures.h"

typedef struct entry {
    const char *name;
    plft_figure *run;
    const char *about;
} entry;

static const entry entries[] = {
    {"run", plft_figure_run, "LOG LABEL PROGRAM ARGS...: run, append time and memory"},
    {"zoom", plft_figure_zoom,
     "IN.png OUT.png X Y W H SCALE [CENTRES.csv]: part of a frame, enlarged"},
    {"map", plft_figure_map, "IN.pfm OUT.png LO HI LABEL: a map in false colours"},
    {"sheet", plft_figure_sheet,
     "OUT.png COLUMNS {IN.png LABEL}...: pictures side by side"},
    {"score", plft_figure_score,
     "LABEL MAP.pfm TRUTH.pfm OBJECTS.png LOG [BAND]: a row of the table"},
};

int main(int argc, char **argv)
{
    size_t k;

    for (k = 0; argc > 1 && k < sizeof entries / sizeof entries[0]; k++) {
        if (strcmp(argv[1], entries[k].name) == 0) {
            return entries[k].run(argc - 1, argv + 1);
        }
    }
    for (k = 0; k < sizeof entries / sizeof entries[0]; k++) {
        (void)fprintf(stderr, "figures %s %s\n", entries[k].name, entries[k].about);
    }
    return PLFT_USAGE;
}
