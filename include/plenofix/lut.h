/* SPDX-License-Identifier: MIT
 * Lens lookup table: where the centre of each microlens falls on the sensor.
 *
 * The table is a blob (src/FORMAT.md) that is read in place, byte by byte, from RAM or
 * flash of any byte order and alignment; opening copies nothing.  Centre of lens (i,j):
 *   c = origin + i*a + j*b + (j odd ? odd : 0) + residual(i,j)
 * with a the step along a lens row, b to the next row.  On a hexagonal lattice b points
 * straight across the rows and `odd` is about half of a; on a square one `odd` is 0.
 * Pixel centres are at integers, x right, y down. */
#ifndef PLENOFIX_LUT_H
#define PLENOFIX_LUT_H

#include "plenofix/base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLFX_LATTICE_SQUARE 0
#define PLFX_LATTICE_HEX    1 /* rows shifted by half a step: odd rows carry `odd` */

/* Per-lens quality, plfx_lut_flags(). */
#define PLFX_LENS_DIM     1u   /* white level under 1/8 of the best: gain over 8 */
#define PLFX_LENS_CLIPPED 2u   /* its calibration spot was saturated */
#define PLFX_LENS_MISSING 4u   /* no light, or off the sensor: never use */
#define PLFX_LENS_INTERP  8u   /* centre interpolated from its neighbours */
#define PLFX_LENS_TURNED  128u /* reserved, 0 */

typedef struct plfx_point {
    int32_t x_q16, y_q16; /* sensor pixels */
} plfx_point;

typedef struct plfx_vec_q22 {
    int32_t x_q22, y_q22; /* sensor pixels, -512 .. 512 */
} plfx_vec_q22;

typedef struct plfx_lattice {
    int32_t kind;      /* PLFX_LATTICE_* */
    int32_t nx, ny;    /* lenses in a row, rows; 1 .. PLFX_LENSES_MAX */
    plfx_point origin; /* centre of lens (0,0) */
    plfx_vec_q22 a, b, odd;
} plfx_lattice;

typedef struct plfx_section { /* bytes inside the blob; length 0: absent */
    uint32_t offset, length;
} plfx_section;

/* An opened table.  Holds a pointer into the caller's blob, which must outlive it. */
typedef struct plfx_lut {
    const uint8_t *blob;
    uint32_t size;      /* bytes of the blob */
    uint32_t camera_id; /* 0: none given */
    int32_t sensor_w, sensor_h, sensor_bits;
    plfx_lattice lattice;
    int32_t radius_q8; /* usable radius, sensor pixels */
    uint32_t crc;      /* CRC-32 of the header: names the table in telemetry */
    plfx_section resi, flag, gain, dark, opti, meta;
    const uint8_t *rows; /* NULL; inside a fed stream (stream.h) rows that were fed */
    int32_t held;        /* so many */
} plfx_lut;

/* Validate a blob and fill `lut`: magic, version, sizes, directory, every CRC, steps
 * not zero and not parallel, every lens not flagged MISSING within a pitch of the
 * sensor.  Cost: one pass over the blob and the lenses.
 * PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE (n short of the stored size), PLFX_E_FORMAT. */
plfx_status plfx_lut_open(plfx_lut *lut, const void *blob, size_t n) PLFX_MUST_USE;

/* Centre of lens (i,j).  Precondition: 0 <= i < nx, 0 <= j < ny.  Lattice terms add up
 * exactly at q22 in 64 bits, one rounding to q16. */
plfx_point plfx_lut_centre(const plfx_lut *lut, int32_t i, int32_t j);

/* PLFX_LENS_* of lens (i,j); 0 when the table has no FLAG section.
 * Same precondition. */
uint32_t plfx_lut_flags(const plfx_lut *lut, int32_t i, int32_t j);

/* Distance between nearest lens centres, sensor pixels: min(|a|, |b|) on a square
 * lattice, min(|a|, |b + odd|) on a hexagonal one. */
int32_t plfx_lut_pitch_q16(const plfx_lut *lut);

/* White gain of lens row j at offset (u,v), for lenses 0 .. nx-1, gain 0 .. 8 - 2^-13.
 * gain(i,j,u,v) = lens gain(i,j) * profile(zone(i,j); u,v): the profile is bilinear in
 * (u,v) and between zone centres.  All 8192 (= 1.0) when the table has no GAIN section.
 * PLFX_OK, PLFX_E_ARG (j, or |u| or |v| > 128 px). */
plfx_status plfx_lut_gain_row(const plfx_lut *lut, int32_t j, int16_t u_q8,
                              int16_t v_q8, uint16_t *gain_u13) PLFX_MUST_USE;

/* What to write.  Pointers may be NULL where the section is not wanted. */
typedef struct plfx_lut_desc {
    uint32_t camera_id;
    int32_t sensor_w, sensor_h, sensor_bits;
    plfx_lattice lattice;
    int32_t radius_q8;
    const int16_t *resid_q12; /* [ny][nx][2] (dx,dy), -8 .. 8 px */
    const uint8_t *flags;     /* [ny][nx] PLFX_LENS_* */
    int32_t zones_x, zones_y; /* gain zones, 1 .. 16 each */
    int32_t profile_r;        /* profile half width, sensor pixels, 1 .. 127 */
    /* [zones_y][zones_x][2r+1][2r+1]; with lens_gain_u13 */
    const uint16_t *profile_u13;
    const uint16_t *lens_gain_u13; /* [ny][nx] */
    uint16_t dark_u16; /* black level, full scale 65535; stored when has_dark */
    int32_t has_dark;
    const uint8_t *opti; /* OPTI payload (plfx_optics, src/FORMAT.md), opti_len */
    uint32_t opti_len;
    const uint8_t *meta; /* META payload: UTF-8 text, meta_len bytes */
    uint32_t meta_len;
} plfx_lut_desc;

/* Bytes that plfx_lut_write() needs; 0 if the description is out of range. */
size_t plfx_lut_bytes(const plfx_lut_desc *desc);

/* Write the blob.  PLFX_OK, PLFX_E_ARG, PLFX_E_SIZE. */
plfx_status plfx_lut_write(const plfx_lut_desc *desc, uint8_t *buf,
                           size_t size) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
