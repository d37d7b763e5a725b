/* SPDX-License-Identifier: MIT
 * Numbers of a plan as the kernels take them: indices into one array of int32. */
#ifndef PLENOFIX_CL_PARAMS_H
#define PLENOFIX_CL_PARAMS_H

#define CL_NX       0
#define CL_NY       1
#define CL_VIEWS    2
#define CL_REF      3
#define CL_LABELS   4
#define CL_WINDOW   5
#define CL_BITS     6
#define CL_PAIRS    7
#define CL_ZNCC     8
#define CL_VEE      9
#define CL_WEIGHTED 10 /* fuse by correlation */
#define CL_TEXTURE  11
#define CL_UNIQUE   12
#define CL_SHIFT1   13
#define CL_SHIFT2   14
#define CL_FLOOR    15
#define CL_HEX      16
#define CL_ODD      17
#define CL_MIN      18
#define CL_MAX      19
#define CL_USES_U   20
#define CL_USES_V   21
#define CL_COL      22
#define CL_ROW      23
#define CL_STEP     24 /* du of the gradient's views */
#define CL_RAW_W    25
#define CL_RAW_H    26
#define CL_FORMAT   27
#define CL_RAW_BITS 28
#define CL_BLACK    29
#define CL_CLIPPED  30
#define CL_GAIN     31
#define CL_DOWN     32
#define CL_WHITE    33
#define CL_BAND     34 /* rows a work-item slides along */
#define CL_PAD      35 /* columns of replicated border on either side of a view row */
#define CL_STRIDE   36 /* elements of a padded view row */
#define CL_WIDE     37 /* elements of a row of costs: lenses rounded up to 8 */
#define CL_INVERSE  38 /* of depth: offset, low and high word of the gain */
#define CL_LOW      39
#define CL_HIGH     40
#define CL_PARAMS   44

#endif
