/* SPDX-License-Identifier: MIT */
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/frame.h"
#include "common/memory.h"
#include "common/out.h"

typedef struct source {
    const unsigned char *at;
    size_t left;
    char why[96]; /* libpng's message */
} source;

static void on_error(png_structp png, png_const_charp text)
{
    source *s = (source *)png_get_error_ptr(png);

    (void)snprintf(s->why, sizeof s->why, "%s", text);
    longjmp(png_jmpbuf(png), 1);
}

static void on_warning(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text;
}

static void on_read(png_structp png, png_bytep to, png_size_t n)
{
    source *s = (source *)png_get_io_ptr(png);

    if (n > s->left) {
        png_error(png, "the file ends early");
    }
    memcpy(to, s->at, n);
    s->at += n;
    s->left -= n;
}

/* Refusals that are no damage: what the file is, and what to do. */
static int accept_kind(png_structp png, png_infop info, const char *name)
{
    int colour = png_get_color_type(png, info);
    int depth = png_get_bit_depth(png, info);

    if (colour == PNG_COLOR_TYPE_PALETTE) {
        return plft_fail(PLFT_DATA, "%s: a palette PNG; save it as grey or RGB", name);
    }
    if ((colour & PNG_COLOR_MASK_ALPHA) != 0 ||
        png_get_valid(png, info, PNG_INFO_tRNS)) {
        return plft_fail(PLFT_DATA,
                         "%s: a PNG with transparency; save it without alpha", name);
    }
    if (depth != 8 && depth != 16) {
        return plft_fail(PLFT_DATA, "%s: %d bits a sample; save it with 8 or 16", name,
                         depth);
    }
    return 0;
}

static void unpack_row(const png_byte *row, int depth, size_t n, uint16_t *px)
{
    size_t i;

    for (i = 0; i < n; i++) {
        px[i] = depth == 8 ? row[i]
                           : (uint16_t)((unsigned)row[2 * i] << 8 | row[2 * i + 1]);
    }
}

/* Where the bytes of row y wait in the frame itself: at the end of its samples, so that
 * unpacking them from the left reads each before it is written over. */
static png_byte *waiting(const plft_frame *frame, int y, size_t n, size_t bytes)
{
    return (png_byte *)(frame->px + (size_t)y * n) + (2 * n - bytes);
}

/* Whole images only: interlaced files deliver rows in passes.  No object with a
 * destructor lives here: libpng leaves by longjmp. */
static int read_rows(png_structp png, png_infop info, plft_frame *frame)
{
    size_t n = (size_t)frame->w * (size_t)frame->channels;
    size_t bytes = png_get_rowbytes(png, info); /* n or 2n */
    int passes = png_set_interlace_handling(png);
    int pass, y;

    for (pass = 0; pass < passes; pass++) {
        for (y = 0; y < frame->h; y++) {
            png_read_row(png, waiting(frame, y, n, bytes), NULL);
        }
    }
    png_read_end(png, NULL);
    for (y = 0; y < frame->h; y++) {
        unpack_row(waiting(frame, y, n, bytes), png_get_bit_depth(png, info), n,
                   frame->px + (size_t)y * n);
    }
    frame->bits = png_get_bit_depth(png, info);
    return 0;
}

static int read_png(png_structp png, png_infop info, source *s, plft_frame *frame,
                    const char *name)
{
    if (setjmp(png_jmpbuf(png)) != 0) {
        return plft_fail(PLFT_DATA, "%s: damaged PNG: %s; copy it again", name, s->why);
    }
    png_read_info(png, info);
    if (accept_kind(png, info, name) != 0 ||
        plft_frame_alloc(frame, png_get_image_width(png, info),
                         png_get_image_height(png, info), png_get_channels(png, info),
                         name) != 0) {
        return PLFT_DATA;
    }
    return read_rows(png, info, frame);
}

int plft_png_parse(plft_frame *frame, const unsigned char *bytes, size_t n,
                   const char *name)
{
    source s = {bytes, n, ""};
    png_structp png =
        png_create_read_struct(PNG_LIBPNG_VER_STRING, &s, on_error, on_warning);
    png_infop info = png == NULL ? NULL : png_create_info_struct(png);
    int rc;

    memset(frame, 0, sizeof *frame);
    if (info == NULL) {
        png_destroy_read_struct(&png, NULL, NULL);
        return plft_fail(PLFT_DATA, "%s: out of memory", name);
    }
    png_set_user_limits(png, PLFT_SIDE_MAX, PLFT_SIDE_MAX);
    png_set_read_fn(png, &s, on_read);
    rc = read_png(png, info, &s, frame, name);
    png_destroy_read_struct(&png, &info, NULL);
    if (rc != 0) {
        plft_frame_free(frame);
    }
    return rc;
}

/* One picture to write: rows of `bytes` bytes each. */
typedef struct picture {
    const png_byte *rows;
    size_t bytes;
    int w, h, depth, colour, sbit;
} picture;

static int write_png(png_structp png, png_infop info, FILE *file, const picture *p)
{
    png_color_8 sig;
    int y;

    if (setjmp(png_jmpbuf(png)) != 0) {
        return PLFT_DATA;
    }
    png_init_io(png, file);
    png_set_compression_level(png, 3); /* a third of the time of 6, 3 % larger */
    png_set_IHDR(png, info, (png_uint_32)p->w, (png_uint_32)p->h, p->depth, p->colour,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (p->sbit != 0) {
        memset(&sig, 0, sizeof sig);
        sig.gray = sig.red = sig.green = sig.blue = (png_byte)p->sbit;
        png_set_sBIT(png, info, &sig);
    }
    png_write_info(png, info);
    for (y = 0; y < p->h; y++) {
        png_write_row(png, p->rows + (size_t)y * p->bytes);
    }
    png_write_end(png, info);
    return 0;
}

static int write_picture(const char *path, const picture *p)
{
    source s = {NULL, 0, ""};
    plft_out out;
    png_structp png;
    png_infop info;
    int rc;

    if (plft_out_open(&out, path) != 0) {
        return PLFT_DATA;
    }
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &s, on_error, on_warning);
    info = png == NULL ? NULL : png_create_info_struct(png);
    rc = info == NULL ? PLFT_DATA : write_png(png, info, out.file, p);
    png_destroy_write_struct(&png, &info);
    if (rc != 0 && !ferror(out.file)) {
        rc = plft_fail(PLFT_DATA, "cannot write %s: %s", path,
                       s.why[0] != '\0' ? s.why : "out of memory");
        plft_out_abort(&out);
        return rc;
    }
    return plft_out_commit(&out);
}

int plft_png_write(const char *path, const plft_frame *frame)
{
    size_t n = (size_t)frame->w * (size_t)frame->channels;
    size_t wide = frame->bits <= 8 ? 1 : 2;
    size_t i, all = n * (size_t)frame->h;
    png_byte *bytes = (png_byte *)plft_alloc(all, wide);
    picture p;
    int rc;

    if (bytes == NULL) {
        return PLFT_DATA;
    }
    for (i = 0; i < all; i++) {
        if (wide == 1) {
            bytes[i] = (png_byte)frame->px[i];
        } else {
            bytes[2 * i] = (png_byte)(frame->px[i] >> 8);
            bytes[2 * i + 1] = (png_byte)(frame->px[i] & 255u);
        }
    }
    p.rows = bytes;
    p.bytes = n * wide;
    p.w = frame->w;
    p.h = frame->h;
    p.depth = (int)(8 * wide);
    p.colour = frame->channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY;
    p.sbit = frame->bits == p.depth ? 0 : frame->bits;
    rc = write_picture(path, &p);
    free(bytes);
    return rc;
}

int plft_png_write_rgb8(const char *path, const uint8_t *rgb, int w, int h)
{
    picture p;

    p.rows = rgb;
    p.bytes = 3 * (size_t)w;
    p.w = w;
    p.h = h;
    p.depth = 8;
    p.colour = PNG_COLOR_TYPE_RGB;
    p.sbit = 0;
    return write_picture(path, &p);
}
