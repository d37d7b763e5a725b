/* SPDX-License-Identifier: MIT
 * Which views a method looks at. */
#ifndef PLFT_ARRANGE_H
#define PLFT_ARRANGE_H

#include "common/field.h"

typedef enum plft_method {
    PLFT_BINOCULAR = 0, /* centre and one view at (+radius, 0) */
    PLFT_PLENOPTIC,     /* centre and rings of opposite views, pair by pair */
    PLFT_SWEEP,         /* the same views, one summed cost */
    PLFT_GRADIENT       /* centre and four views one small step away */
} plft_method;

#define PLFT_METHODS "binocular|plenoptic|sweep|gradient"

typedef struct plft_views_wish {
    int method;    /* plft_method */
    int n;         /* views; 0: the method's own number */
    int u_only;    /* no views off the u axis */
    int adjacent;  /* one ring, at `step` */
    double radius; /* of the outermost ring; 0: the light field's */
    double step;   /* of GRADIENT and `adjacent`; 0: a third of radius, at least 1 */
} plft_views_wish;

/* Offsets for a wish, the centre first; rings at radius*k/rings.  Fills the wish's
 * zeros with what was taken.  Offsets that a folder of views cannot give are
 * replaced by the nearest, doubles dropped.  0, or PLFT_USAGE when the radius leaves
 * the lens or the number of views does not suit the method, or PLFT_DATA. */
int plft_arrange(const plft_field *field, plft_views_wish *wish, plfx_offset *at,
                 int *n);

/* Every whole-pixel offset within the radius (raw), or every view there is (folders),
 * row by row.  *at malloc'd. */
int plft_arrange_all(const plft_field *field, double radius, plfx_offset **at, int *n);

#endif
