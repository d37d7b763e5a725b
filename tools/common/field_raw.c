/* SPDX-License-Identifier: MIT */
#include "common/field_raw.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calib/drift.h"
#include "common/err.h"
#include "common/memory.h"
#include "common/mosaic.h"

#define WORK_BITS 12    /* of views before division by white */
#define GAIN_MAX  8.0   /* as in the table: dimmer lenses are flagged, not amplified */
#define BRIGHT    0.999 /* this share of the centre view ... */
#define TARGET    0.90  /* ... lands at or under this part of full scale */

static plfx_raw raw_of(const plft_frame *f)
{
    plfx_raw raw;

    raw.bytes = (const uint8_t *)f->px;
    raw.size = (size_t)f->w * (size_t)f->h * sizeof *f->px;
    raw.format = PLFX_RAW_U16;
    raw.bits = (uint8_t)f->bits;
    raw.w = f->w;
    raw.h = f->h;
    return raw;
}

/* One view of one frame into view k of `to`. */
static int extract(const plft_field *field, const plft_frame *f, const plfx_tone *tone,
                   plfx_offset at, int gain, const plfx_views *to, int k)
{
    plfx_raw raw = raw_of(f);

    if (plfx_view_rows(&field->table.lut, &raw, tone, at, gain, 0, to->ny, to, k) !=
        PLFX_OK) {
        return plft_fail(PLFT_DATA, "view at (%g, %g): outside what the table covers",
                         at.u_q8 / 256.0, at.v_q8 / 256.0);
    }
    return 0;
}

/* A single view of its own memory. */
static int extract_one(const plft_field *field, const plft_frame *f,
                       const plfx_tone *tone, plfx_offset at, int gain, plfx_views *one)
{
    one->nx = field->nx;
    one->ny = field->ny;
    one->n = 1;
    one->px =
        (uint16_t *)plft_alloc((size_t)one->nx * (size_t)one->ny, sizeof *one->px);
    return one->px == NULL ? PLFT_DATA : extract(field, f, tone, at, gain, one, 0);
}

/* Value under which a share `q` of the samples lies; max < 2^WORK_BITS. */
static double quantile(const plfx_views *one, double q)
{
    size_t count[1 << WORK_BITS] = {0};
    size_t n = (size_t)one->nx * (size_t)one->ny, i, sum = 0;
    int v;

    for (i = 0; i < n; i++) {
        count[one->px[i]]++;
    }
    for (v = 0; v < (1 << WORK_BITS) - 1; v++) {
        sum += count[v];
        if ((double)sum >= q * (double)n) {
            break;
        }
    }
    return v;
}

/* mantissa and shift of a factor of at least 1. */
static void tone_factor(plfx_tone *tone, double factor)
{
    int shift = 0;
    long gain;

    factor = factor < 1.0 ? 1.0 : factor > 256.0 ? 256.0 : factor;
    while (factor >= 2.0 && shift < 8) {
        factor /= 2.0;
        shift++;
    }
    gain = lround(factor * 4096.0);
    tone->gain_q12 = (uint16_t)(gain > 8191 ? 8191 : gain);
    tone->shift = (int8_t)shift;
}

/* Tone that brings the bright end of the centre view to TARGET.  From the frame alone:
 * every view of it gets the same, whichever are asked for. */
static int settle_tone(const plft_field *field, const plft_frame *f, int gain,
                       plfx_tone *tone)
{
    plfx_offset centre = {0, 0};
    plfx_views one;
    double bright;
    int rc = extract_one(field, f, tone, centre, gain, &one);

    if (rc == 0) {
        bright = quantile(&one, BRIGHT);
        if (bright < 1.0) {
            rc = plft_fail(PLFT_DATA, "the frame is black: nothing to measure");
        } else {
            tone_factor(tone, TARGET * (1 << WORK_BITS) / bright);
        }
    }
    free(one.px);
    return rc;
}

/* Black level of the table's DARK section: src/FORMAT.md. */
static uint16_t table_black(const plfx_lut *lut)
{
    const uint8_t *p = lut->blob + lut->dark.offset;

    return lut->dark.length < 2 ? 0 : (uint16_t)(p[0] | (unsigned)p[1] << 8);
}

static void first_tone(const plft_field *field, const plft_frame *f, int half,
                       uint16_t black, plfx_tone *tone)
{
    (void)field;
    *tone = plfx_tone_unity(WORK_BITS);
    tone->black_u16 = black;
    tone->sat_u16 = (uint16_t)(((1u << f->bits) - 1u) << (16 - f->bits));
    tone->dx_q8 = tone->dy_q8 = (int16_t)(half ? -128 : 0);
}

/* The frame in memory, or that of a file. */
static int take_frame(plft_frame *f, const char *path, const plft_source *s)
{
    if (s->frame == NULL || path != s->raw) {
        return plft_frame_read(f, path, s->bits);
    }
    *f = *s->frame;
    memset(s->frame, 0, sizeof *s->frame);
    return 0;
}

/* One frame down to one plane without its dark level. */
static int read_plane(plft_frame *f, const char *path, const plft_source *s,
                      const plft_frame *dark, int *half)
{
    int rc = take_frame(f, path, s);

    if (rc == 0 && dark->px != NULL) {
        rc = plft_subtract_dark(f, dark, s->dark);
    }
    if (rc == 0) {
        rc = plft_to_plane(f, s->bayer, s->channel - 1, half, path);
    }
    if (rc != 0) {
        plft_frame_free(f);
    }
    return rc;
}

static int check_size(const plft_frame *f, const plfx_lut *lut, const char *path,
                      const char *table)
{
    if (f->w != lut->sensor_w || f->h != lut->sensor_h) {
        return plft_fail(
            PLFT_DATA,
            "%s: %d x %d where the table %s is for %d x %d; use the table of "
            "this camera",
            path, f->w, f->h, table, lut->sensor_w, lut->sensor_h);
    }
    return 0;
}

static int read_frames(plft_field *field, const plft_source *s, int *half)
{
    const plfx_lut *lut = &field->table.lut;
    plft_frame dark;
    int rc = 0;

    memset(&dark, 0, sizeof dark);
    if (s->dark != NULL) {
        rc = plft_frame_read(&dark, s->dark, s->bits);
    }
    if (rc == 0) {
        rc = read_plane(&field->frame, s->raw, s, &dark, half);
    }
    if (rc == 0) {
        rc = check_size(&field->frame, lut, s->raw, s->lut);
    }
    if (rc == 0 && s->white != NULL) {
        rc = read_plane(&field->white, s->white, s, &dark, half);
        rc = rc != 0 ? rc : check_size(&field->white, lut, s->white, s->lut);
    }
    plft_frame_free(&dark);
    return rc;
}

static int read_flags(plft_field *field)
{
    const plfx_lut *lut = &field->table.lut;
    int i, j;

    if (lut->flag.length == 0) {
        return 0;
    }
    field->lens = (uint8_t *)plft_alloc((size_t)field->nx * (size_t)field->ny, 1);
    if (field->lens == NULL) {
        return PLFT_DATA;
    }
    for (j = 0; j < field->ny; j++) {
        for (i = 0; i < field->nx; i++) {
            field->lens[(size_t)j * (size_t)field->nx + (size_t)i] =
                (uint8_t)plfx_lut_flags(lut, i, j);
        }
    }
    return 0;
}

static void divide(const plft_field *field, const plfx_views *w, const plfx_views *to,
                   int k)
{
    double max = (double)((1 << field->bits) - 1);
    double floor_w = field->white_ref / GAIN_MAX;
    int x, y;

    for (y = 0; y < to->ny; y++) {
        uint16_t *p = to->px + ((size_t)y * (size_t)to->n + (size_t)k) * (size_t)to->nx;
        const uint16_t *q = w->px + (size_t)y * (size_t)to->nx;
        for (x = 0; x < to->nx; x++) {
            double under = q[x] > floor_w ? q[x] : floor_w;
            double v = p[x] * field->white_ref / under * field->stretch;
            p[x] = (uint16_t)(p[x] == (1 << WORK_BITS) - 1 || v > max ? max : v + 0.5);
        }
    }
}

/* Scene and white view, one through the other. */
static int extract_divided(const plft_field *field, plfx_offset at,
                           const plfx_views *to, int k)
{
    plfx_views w;
    int rc = extract(field, &field->frame, &field->tone, at, 0, to, k);

    if (rc != 0) {
        return rc;
    }
    rc = extract_one(field, &field->white, &field->white_tone, at, 0, &w);
    if (rc == 0) {
        divide(field, &w, to, k);
    }
    free(w.px);
    return rc;
}

int plft_field_extract(const plft_field *field, plfx_offset at, const plfx_views *to,
                       int k)
{
    return field->white.px != NULL ? extract_divided(field, at, to, k)
                                   : extract(field, &field->frame, &field->tone, at,
                                             field->use_gain, to, k);
}

/* After the tone of the frame: white's own tone, its reference level, and the stretch
 * that brings the divided centre view to TARGET. */
static int settle_white(plft_field *field)
{
    plfx_offset centre = {0, 0};
    plfx_views one;
    double work = (double)(1 << WORK_BITS), out = (double)(1 << field->bits);
    double bright;
    int bits = field->bits;
    int rc = settle_tone(field, &field->white, 0, &field->white_tone);

    if (rc != 0) {
        return rc;
    }
    rc = extract_one(field, &field->white, &field->white_tone, centre, 0, &one);
    if (rc == 0) {
        field->white_ref = quantile(&one, 0.95);
        field->stretch = 1.0;
        field->bits = WORK_BITS; /* look at the divided view in work units first */
        rc = extract_divided(field, centre, &one, 0);
        field->bits = bits;
        bright = quantile(&one, BRIGHT);
        field->stretch =
            out / work * (bright > 1.0 ? fmin(1.0, TARGET * work / bright) : 1.0);
    }
    free(one.px);
    return rc;
}

static int settle(plft_field *field, const plft_source *s, int half)
{
    uint16_t black = s->dark != NULL ? 0 : table_black(&field->table.lut);
    int rc;

    field->use_gain = s->white == NULL && field->table.lut.gain.length > 0;
    first_tone(field, &field->frame, half, black, &field->tone);
    rc = settle_tone(field, &field->frame, field->use_gain, &field->tone);
    if (rc == 0 && s->white != NULL) {
        first_tone(field, &field->white, half, black, &field->white_tone);
        rc = settle_white(field);
    } else {
        field->tone.bits = (uint8_t)field->bits;
    }
    field->tone_gain = ldexp(field->tone.gain_q12 / 4096.0, field->tone.shift);
    return rc;
}

int plft_field_open_raw(plft_field *field, const plft_source *s)
{
    int half = 0;
    int rc = plft_table_read(&field->table, s->lut);

    if (rc != 0) {
        return rc;
    }
    rc = read_frames(field, s, &half);
    if (rc != 0) {
        return rc;
    }
    if (s->frame == NULL) { /* one file, not each frame of a camera */
        const int white = field->white.px != NULL;
        plft_drift_warn(white ? s->white : s->raw, &field->table.lut,
                        white ? &field->white : &field->frame);
    }
    field->lut = &field->table.lut;
    field->nx = field->lut->lattice.nx;
    field->ny = field->lut->lattice.ny;
    field->scale = 1;
    field->radius = field->lut->radius_q8 / 256.0;
    field->reach = plfx_lut_pitch_q16(field->lut) / 131072.0;
    field->bits = s->view_bits != 0 ? s->view_bits : field->frame.bits >= 12 ? 12 : 10;
    rc = read_flags(field);
    return rc != 0 ? rc : settle(field, s, half);
}
