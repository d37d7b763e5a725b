/* SPDX-License-Identifier: MIT
 * Bayer mosaics: grey and single channels. */
#include "plenofix/raw.h"

plfx_status plfx_raw_bayer_grey(const uint16_t *r0, const uint16_t *r1, int32_t w,
                                uint16_t *out)
{
    int32_t x;

    if (!r0 || !r1 || !out || w < 2) {
        return PLFX_E_ARG;
    }
    for (x = 0; x + 1 < w; x++) {
        uint32_t sum = (uint32_t)r0[x] + r0[x + 1] + r1[x] + r1[x + 1];
        out[x] = (uint16_t)((sum + 2u) >> 2);
    }
    out[w - 1] = out[w - 2];
    return PLFX_OK;
}

/* Colour of pixel (x,y): 0 red, 1 green, 2 blue. */
static int32_t colour_at(int32_t bayer, int32_t x, int32_t y)
{
    int32_t red_x = bayer == PLFX_BAYER_GRBG || bayer == PLFX_BAYER_BGGR;
    int32_t red_y = bayer == PLFX_BAYER_GBRG || bayer == PLFX_BAYER_BGGR;

    if (((x ^ red_x) & 1) != ((y ^ red_y) & 1)) {
        return 1;
    }
    return ((y ^ red_y) & 1) ? 2 : 0;
}

typedef struct rows {
    const uint16_t *above, *row, *below;
    int32_t w;
} rows;

static uint32_t at(const uint16_t *row, int32_t x, int32_t w)
{
    return row[x < 0 ? 1 : x >= w ? w - 2 : x]; /* mirrored: same colour */
}

/* Mean of the nearest neighbours that have the channel, seen from a pixel that has
 * not. */
static uint16_t neighbours(const rows *r, int32_t bayer, int32_t channel, int32_t x,
                           int32_t y)
{
    uint32_t beside = at(r->row, x - 1, r->w) + at(r->row, x + 1, r->w);
    uint32_t over = at(r->above, x, r->w) + at(r->below, x, r->w);

    if (channel == 1) {
        return (uint16_t)((beside + over + 2u) >> 2);
    }
    if (colour_at(bayer, x + 1, y) == channel) {
        return (uint16_t)((beside + 1u) >> 1);
    }
    if (colour_at(bayer, x, y + 1) == channel) {
        return (uint16_t)((over + 1u) >> 1);
    }
    return (uint16_t)((at(r->above, x - 1, r->w) + at(r->above, x + 1, r->w) +
                       at(r->below, x - 1, r->w) + at(r->below, x + 1, r->w) + 2u) >>
                      2);
}

plfx_status plfx_raw_bayer_channel(int32_t bayer, int32_t channel, int32_t y,
                                   const uint16_t *above, const uint16_t *row,
                                   const uint16_t *below, int32_t w, uint16_t *out)
{
    rows r;
    int32_t x;

    if (bayer <= PLFX_BAYER_NONE || bayer > PLFX_BAYER_BGGR || channel < 0 ||
        channel > 2 || y < 0 || !row || !out || out == row || w < 2 ||
        (!above && !below)) {
        return PLFX_E_ARG;
    }
    r.above = above ? above : below;
    r.row = row;
    r.below = below ? below : above;
    r.w = w;
    for (x = 0; x < w; x++) {
        out[x] = colour_at(bayer, x, y) == channel
                     ? row[x]
                     : neighbours(&r, bayer, channel, x, y);
    }
    return PLFX_OK;
}
