/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "common/field.h"

static size_t count(const plft_option *table)
{
    size_t n = 0;

    while (table[n].name != NULL) {
        n++;
    }
    return n;
}

static size_t append(plft_option *all, size_t at, const plft_option *table)
{
    size_t n = count(table);

    n = n < PLFT_OPTIONS_MAX - 1 - at ? n : PLFT_OPTIONS_MAX - 1 - at;
    memcpy(all + at, table, n * sizeof *all);
    memset(all + at + n, 0, sizeof *all);
    return at + n;
}

void plft_source_options(plft_option *all, const plft_option *own, plft_source *s,
                         int dir)
{
    const plft_option raw[] = {
        {"--lut", PLFT_TEXT, &s->lut, "CAM.plut", 0, 0, "lens table of the camera"},
        {"--white", PLFT_TEXT, &s->white, "W", 0, 0, "white frame: divided out"},
        {"--dark", PLFT_TEXT, &s->dark, "D", 0, 0, "dark frame: subtracted"},
        {"--bits", PLFT_INT, &s->bits, "N", 8, 16, "of the raw samples; the file's"},
        {"--view-bits", PLFT_INT, &s->view_bits, "N", PLFX_BITS_MIN, PLFX_BITS_MAX,
         "of a view sample, 8 to 12"},
        {"--bayer", PLFT_WORD, &s->bayer, "none|rggb|grbg|gbrg|bggr", 0, 0,
         "mosaic of a colour camera"},
        {"--channel", PLFT_WORD, &s->channel, "grey|r|g|b", 0, 0,
         "of a mosaic: its 2x2 mean or one colour; grey"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    const plft_option ready[] = {
        {"--views-dir", PLFT_TEXT, &s->dir, "DIR", 0, 0, "folder of ready-made views"},
        {"--grid", PLFT_TEXT, &s->grid, "RxC", 0, 0, "rows and columns of the views"},
        {"--pattern", PLFT_TEXT, &s->pattern, "GLOB", 0, 0,
         "which files of the folder"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};
    size_t n = append(all, append(all, 0, own), raw);

    if (dir) {
        (void)append(all, n, ready);
    }
}
