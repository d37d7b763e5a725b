/* SPDX-License-Identifier: MIT */
#include "common/square.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/memory.h"

typedef struct steps {
    double col, row; /* lens columns and rows a pixel of the picture */
    double odd;      /* columns by which odd rows stand to the right */
} steps;

static double length(plfx_vec_q22 v)
{
    return hypot(v.x_q22, v.y_q22) / 4194304.0;
}

static steps steps_of(const plfx_lattice *l)
{
    double a = length(l->a), b = length(l->b), pitch = a < b ? a : b;
    steps s;

    s.odd = 0.0;
    if (l->kind == PLFX_LATTICE_HEX) {
        double dx = (double)l->b.x_q22 + l->odd.x_q22,
               dy = l->b.y_q22 + (double)l->odd.y_q22;
        double dot =
            (double)l->odd.x_q22 * l->a.x_q22 + (double)l->odd.y_q22 * l->a.y_q22;
        pitch = fmin(a, hypot(dx, dy) / 4194304.0);
        s.odd = dot / pow(a * 4194304.0, 2.0);
    }
    s.col = pitch / a;
    s.row = pitch / b;
    return s;
}

int plft_square_init(plft_square *sq, const plfx_lattice *lattice, int nx, int ny)
{
    steps s = {1.0, 1.0, 0.0};
    int x, y;

    memset(sq, 0, sizeof *sq);
    if (lattice != NULL) {
        s = steps_of(lattice);
    }
    sq->w = (int)lround(((double)nx + fabs(s.odd)) / s.col);
    sq->h = (int)lround((double)ny / s.row);
    sq->w = sq->w < 1 ? 1 : sq->w;
    sq->h = sq->h < 1 ? 1 : sq->h;
    sq->col = (float *)plft_alloc((size_t)sq->w * (size_t)sq->h, sizeof *sq->col);
    sq->line = (int *)plft_alloc((size_t)sq->h, sizeof *sq->line);
    if (sq->col == NULL || sq->line == NULL) {
        plft_square_free(sq);
        return PLFT_DATA;
    }
    for (y = 0; y < sq->h; y++) {
        int j = (int)lround(y * s.row);
        sq->line[y] = j < ny ? j : ny - 1;
        for (x = 0; x < sq->w; x++) {
            double i = x * s.col - (sq->line[y] % 2 != 0 ? s.odd : 0.0) +
                       (s.odd < 0.0 ? s.odd : 0.0);
            i = i < 0.0 ? 0.0 : i > nx - 1.0 ? nx - 1.0 : i;
            sq->col[(size_t)y * (size_t)sq->w + (size_t)x] = (float)i;
        }
    }
    return 0;
}

void plft_square_map(const plft_square *sq, const float *v, int nx, float *out)
{
    size_t k, w = (size_t)sq->w, n = w * (size_t)sq->h;

    for (k = 0; k < n; k++) {
        out[k] = v[(size_t)sq->line[k / w] * (size_t)nx + (size_t)lroundf(sq->col[k])];
    }
}

void plft_square_view(const plft_square *sq, const uint16_t *v, int nx, uint16_t *out)
{
    size_t k, w = (size_t)sq->w, n = w * (size_t)sq->h;

    for (k = 0; k < n; k++) {
        const uint16_t *line = v + (size_t)sq->line[k / w] * (size_t)nx;
        size_t i = (size_t)sq->col[k];
        size_t i1 = i + 1 < (size_t)nx ? i + 1 : i;
        float f = sq->col[k] - (float)i;
        out[k] = (uint16_t)lroundf((float)line[i] * (1.0f - f) + (float)line[i1] * f);
    }
}

void plft_square_free(plft_square *sq)
{
    free(sq->col);
    free(sq->line);
    memset(sq, 0, sizeof *sq);
}
