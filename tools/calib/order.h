/* SPDX-License-Identifier: MIT
 * Rows and columns for lens centres that come in no order. */
#ifndef PLFT_CALIB_ORDER_H
#define PLFT_CALIB_ORDER_H

#include "calib/lattice.h"

typedef struct plft_order {
    int *row, *col;       /* [n]; -1 where a point fits no free place, malloc'd */
    int placed;           /* points with a place */
    plft_lattice lattice; /* least-squares lattice of the placed points, with nx, ny */
} plft_order;

/* Place n centres xy[n][2] in a lattice: neighbour vectors vote for the two steps, then
 * places spread from neighbour to neighbour, so distortion does not matter and holes
 * are walked around.  No two points get one place; row 0 and column 0 are in use. want:
 * PLFX_LATTICE_* or PLFT_LATTICE_AUTO 0, or -1 when no lattice is found (n < 9, or
 * fewer than half of the points fit) or memory is short; `order` is then untouched.
 * Cost: O(n). */
int plft_order_points(const double *xy, int n, int want, plft_order *order);

void plft_order_free(plft_order *order);

#endif
