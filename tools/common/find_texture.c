/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "common/match.h"
#include "common/memory.h"

#define FLATTEST   50 /* one window in so many */
#define OVER_NOISE 1.4
#define LEAST      2.0 /* 1/1000 of full scale */
#define MOST       12.0

int plft_own_window(const plft_field *field)
{
    int side = field->nx < field->ny ? field->nx : field->ny;

    return side >= 72 ? 9 : side >= 48 ? 7 : side >= 16 ? 5 : 3;
}

/* Mean of |A(x,y)-A(x-1,y)|, and of |A(x,y)-A(x,y-1)| where views lie off the u axis,
 * over a window, as the core tests it. */
static double roughness(const plfx_views *one, int u_only, int x0, int y0, int w)
{
    long sum = 0;
    int x, y;

    for (y = y0; y < y0 + w; y++) {
        for (x = x0; x < x0 + w; x++) {
            const uint16_t *p = one->px + (size_t)y * (size_t)one->nx + (size_t)x;
            sum += abs((int)p[0] - p[-1]);
            sum += u_only ? 0 : abs((int)p[0] - p[-one->nx]);
        }
    }
    return (double)sum / (w * w);
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static double flattest(const plfx_views *one, int u_only, int w)
{
    size_t n = 0, room = (size_t)(one->nx / w) * (size_t)(one->ny / w);
    double *r = (double *)plft_alloc(room, sizeof *r), found = 0.0;
    int x, y;

    if (r == NULL) {
        return 0.0;
    }
    for (y = 1; y + w <= one->ny; y += w) {
        for (x = 1; x + w <= one->nx && n < room; x += w) {
            r[n++] = roughness(one, u_only, x, y, w);
        }
    }
    if (n > 0) {
        qsort(r, n, sizeof *r, by_value);
        found = r[n / FLATTEST];
    }
    free(r);
    return found;
}

int plft_find_texture(const plft_field *field, int u_only, int window, double *texture)
{
    plfx_offset centre = plft_field_offset(field, 0.0, 0.0);
    double full = (double)((1 << field->bits) - 1), found;
    plfx_views one;
    int rc = plft_field_views(field, &centre, 1, &one);

    if (rc == 0) {
        found = 1000.0 * OVER_NOISE * flattest(&one, u_only, window) / full;
        *texture = fmin(fmax(found, LEAST), MOST);
        free(one.px);
    }
    return rc;
}
