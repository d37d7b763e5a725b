/* SPDX-License-Identifier: MIT
 * Status codes, limits and the conventions that every other header leans on.
 *
 * Fixed point.  A suffix _qN means N fractional bits of a signed container, _uN of an
 * unsigned one: int16_t x_q12 holds -8 .. 8 - 2^-12 in steps of 2^-12.
 *
 * Memory.  Every structure is complete, declared by the caller and plain data.  No
 * function keeps a pointer after it returns unless its comment says so.  A workspace is
 * a pointer and a size, aligned to PLFX_ALIGN; its contents before and after are
 * irrelevant.  Strides count elements, not bytes.
 *
 * Errors.  Arguments are checked before anything is written; on an error every output
 * is untouched.  A measurement that could not be made is data (PLFX_SLOPE_NONE), never
 * an error.  A pointer parameter may be NULL only where its comment says so. */
#ifndef PLENOFIX_BASE_H
#define PLENOFIX_BASE_H

#include <stddef.h>
#include <stdint.h>

typedef enum plfx_status {
    PLFX_OK = 0,
    PLFX_E_ARG = -1,    /* an argument is outside its documented range */
    PLFX_E_SIZE = -2,   /* a buffer or workspace is too small or misaligned */
    PLFX_E_FORMAT = -3, /* stored data: bad magic, version, size or CRC */
    PLFX_E_IO = -4,     /* a port callback failed */
    PLFX_E_RANGE = -5,  /* a result does not fit its Q format or its mode */
    PLFX_E_STATE = -6,  /* a call out of order */
    PLFX_E_DEVICE = -7, /* an accelerator or camera failed */
    PLFX_E_TIMEOUT = -8 /* nothing arrived in time */
} plfx_status;

/* C99 compile-time assertion (C11's _Static_assert is not available to us). */
#define PLFX_STATIC_ASSERT(cond, name)                                                 \
    typedef char plfx_static_assert_##name[(cond) ? 1 : -1]

#if defined(__GNUC__)
#define PLFX_MUST_USE __attribute__((warn_unused_result))
#else
#define PLFX_MUST_USE
#endif

/* Alignment of every workspace, bytes. */
#define PLFX_ALIGN 64u
/* n rounded up to PLFX_ALIGN. */
#define PLFX_ALIGNED(n) (((size_t)(n) + (PLFX_ALIGN - 1u)) & ~(size_t)(PLFX_ALIGN - 1u))

#define PLFX_BITS_MIN   8 /* significant bits of a view sample */
#define PLFX_BITS_MAX   12
#define PLFX_WINDOW_MIN 3 /* matching window, lenses on a side, odd */
#define PLFX_WINDOW_MAX 31
#define PLFX_LABELS_MIN 3
#define PLFX_LABELS_MAX 256
#define PLFX_VIEWS_MAX  128  /* views of one plan */
#define PLFX_LENSES_MAX 4096 /* lenses on a side of the array */

#endif
