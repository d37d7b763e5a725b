/* SPDX-License-Identifier: MIT
 * Row kernels on striped rows: the contract that every implementation keeps to the
 * bit.
 *
 * Striping.  A row of nx samples is cut into PLFX_LANES segments of `blocks` samples;
 * block b holds sample b of every segment: block b, lane i is sample i*blocks + b.
 * Every step along the row (difference, column, running window, winner, fit) is then
 * one operation on all lanes, without shuffles.  Block b of a row may be read at b =
 * -left .. blocks-1+right: pads continue the row, with the first and the last sample
 * replicated outside the map.
 *
 * Cells.  Costs, columns and window sums are stored [block][label][lane].  Window sums
 * are biased by -2^15 so that a signed compare orders unsigned sums. */
#ifndef PLENOFIX_SRC_KERNELS_H
#define PLENOFIX_SRC_KERNELS_H

#include <stdint.h>

/* Explicit kernels of src/simd/ stand in for kernels_pair.c when the build defines
 * PLFX_KERNELS_AVX2 or PLFX_KERNELS_DSP: the same bits. */
#if defined(PLFX_KERNELS_AVX2)
#define PLFX_KERNELS_C 0
#define PLFX_LANES     16
#elif defined(PLFX_KERNELS_DSP)
#define PLFX_KERNELS_C 0
#define PLFX_LANES     2
#else
#define PLFX_KERNELS_C 1
#endif

/* Lanes: 1, 2, 4, 8, 16 or 32.  Sizes of workspaces depend on it, results do not. */
#ifndef PLFX_LANES
#if defined(__AVX2__)
#define PLFX_LANES 16
#elif defined(__SSE2__) || defined(__ARM_NEON) || defined(__ALTIVEC__) ||              \
    defined(__VECTOR__)
#define PLFX_LANES 8
#else
#define PLFX_LANES 1
#endif
#endif

#if PLFX_LANES == 1
#define PLFX_LANE_BITS 0
#elif PLFX_LANES == 2
#define PLFX_LANE_BITS 1
#elif PLFX_LANES == 4
#define PLFX_LANE_BITS 2
#elif PLFX_LANES == 8
#define PLFX_LANE_BITS 3
#elif PLFX_LANES == 16
#define PLFX_LANE_BITS 4
#elif PLFX_LANES == 32
#define PLFX_LANE_BITS 5
#else
#error "PLFX_LANES must be 1, 2, 4, 8, 16 or 32"
#endif

/* for (i = 0; i < n; i++), n constant: not peeled away before it is vectorised. */
#if defined(__GNUC__) && !defined(__clang__)
#define PLFX_LANE_LOOP(i, n) _Pragma("GCC unroll 1") for ((i) = 0; (i) < (n); (i)++)
#else
#define PLFX_LANE_LOOP(i, n) for ((i) = 0; (i) < (n); (i)++)
#endif

#define PLFX_BIAS 32768

/* Where a label reads a view: samples off and off + PLFX_LANES, counted from a base
 * row, mixed with weights 16 - f and f (f in 1/16, stored times 2^11).  w_q4 is the
 * weight of this source row against the one below it. */
typedef struct plfx_tap {
    int32_t off;
    int16_t f_q15;
    uint16_t w_q4;
} plfx_tap;

/* out: `blocks` blocks of lin[lane*blocks + b]. */
void plfx_k_stripe(const int16_t *lin, int32_t blocks, int16_t *out);

/* Pads around `blocks` blocks at row: `left` before, `right` behind. */
void plfx_k_pads(int16_t *row, int32_t blocks, int32_t left, int32_t right,
                 int16_t first, int16_t last);

/* item[l] = or += |c - (v0*(16-f) + v1*f + 8 >> 4)| for each label's tap along one
 * row. */
void plfx_k_cost(uint16_t *item, const int16_t *c, const int16_t *base,
                 const plfx_tap *tap, int32_t labels, int32_t first);

/* The same over two rows: one rounding, NUMERICS.md. */
void plfx_k_cost_2d(uint16_t *item, const int16_t *c, const int16_t *base,
                    const plfx_tap *upper, const plfx_tap *lower, int32_t labels,
                    int32_t first);

/* item >>= shift over n cells. */
void plfx_k_scale(uint16_t *item, int32_t n, int32_t shift);

/* What a slide of the window leaves for plfx_k_select(): the least sum of every lane,
 * and with one lane also its label (the first) and whether a label that is no neighbour
 * is as good. */
typedef struct plfx_lead {
    int16_t least[PLFX_LANES];
#if defined(PLFX_KERNELS_DSP)
    int16_t first[PLFX_LANES], last[PLFX_LANES]; /* labels that have it */
#elif PLFX_LANES == 1
    int16_t label, tie;
#endif
} plfx_lead;

/* Winners of one block.  order[q] = n - q for n = labels*PLFX_LANES cells.  sum has
 * one readable label before and behind. */
typedef struct plfx_winners {
    int16_t *code;  /* 32*label + fraction + 8, fraction -8 .. 8 sixteenths; the sign
                            bit is set when a label that is no neighbour is as good */
    uint16_t *conf; /* margin over the second best, select.c; NULL: not wanted */
    uint16_t floor_cost;  /* of the margin, under 2^14 */
    int16_t *best, *rest; /* the two sums instead of conf; NULL: not wanted */
} plfx_winners;
void plfx_k_select(const int16_t *sum, const plfx_lead *lead, const int16_t *order,
                   int32_t labels, int32_t fit, const plfx_winners *out);

/* A row of a pair at whole-sample shifts, block by block, label l at right + l*step:
 *   col += (|l0 - right| - |l1 - gone|) >> s1 each;  sum += (col >> s2) - (leave >> s2)
 * with l1, gone (step gone_step) the row that leaves the window and `leave` the column
 * `window` blocks before, zero ahead of the row.  Winners of block b go to block
 * b - window + 1 of out; out NULL: not wanted. */
typedef struct plfx_whole_row {
    uint16_t *col; /* [blocks][labels][lanes] */
    int16_t *sum;
    const uint16_t *zero; /* [labels][lanes] */
    const int16_t *left, *right, *left_gone, *right_gone;
    int32_t step, gone_step;
    int32_t gone_next; /* samples to the next block of the leaving row, or 0 */
    int32_t blocks, window, labels, s1, s2, fit;
    const int16_t *order;
    plfx_lead *lead;
    const plfx_winners *out;
} plfx_whole_row;
void plfx_k_whole(const plfx_whole_row *r);

/* col += item - gone;  sum += (col >> s2) - (leave >> s2), labels*PLFX_LANES cells. */
typedef struct plfx_update_block {
    uint16_t *col;
    int16_t *sum;
    const uint16_t *item, *gone, *leave;
    int32_t labels, s2;
    plfx_lead *lead;
} plfx_update_block;
void plfx_k_update(const plfx_update_block *b);

/* sum += (enter >> s2) - (leave >> s2); enter need not be aligned. */
void plfx_k_slide(int16_t *sum, const uint16_t *enter, const uint16_t *leave,
                  int32_t labels, int32_t s2, plfx_lead *lead);

/* out[lane*blocks + b] = in[b*PLFX_LANES + lane] for indices under n. */
void plfx_k_unstripe(const int16_t *in, int32_t blocks, int32_t n, int16_t *out);

#endif
