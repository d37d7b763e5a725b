/* SPDX-License-Identifier: MIT
 * A sensor row as the lenses of the fast profile meet it. */
#ifndef PLENOFIX_SRC_GATHER_ROW_H
#define PLENOFIX_SRC_GATHER_ROW_H

#include "gather.h"

typedef struct plfx_gather_row {
    const uint16_t *px;
    int32_t from,
        to;         /* a first tap here when the row over the sample is one of these */
    int32_t before; /* a second tap when it is this one */
    int32_t last_x, down;
    uint32_t half;
    int32_t narrow; /* 1: pixels of 12 bits and less, rows of 15 */
} plfx_gather_row;

/* 1: some lens of a block has a tap here, for displacements least .. most. */
static inline int32_t plfx_gather_meets(const plfx_gather_row *v,
                                        const plfx_gather_block *b, int32_t least,
                                        int32_t most)
{
    int32_t first = plfx_min_i32(v->from, v->before);

    return b->most_q16 >= b->least_q16 &&
           plfx_asr_i32(b->most_q16 + most, 16) >= first &&
           plfx_asr_i32(b->least_q16 + least, 16) <= v->to;
}

#if defined(PLFX_KERNELS_AVX2)
/* Taps of all views of a block that lies inside a narrow row, in 16 bits. */
void plfx_gather_narrow(const plfx_gather *g, const plfx_gather_row *v,
                        const plfx_gather_block *b, const int32_t *cx,
                        const int32_t *cy, uint16_t *to);
#endif

#endif
