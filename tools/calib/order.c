/* SPDX-License-Identifier: MIT
 * Unordered centres into rows and columns. */
#include "calib/order.h"

#include "calib/linalg.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NEARBY  64  /* points looked at around one */
#define SAMPLES 600 /* points that vote */
#define VOTES   8192
#define REACH   0.3 /* of the pitch: a point is where it was predicted */

/* Points sorted into square cells: cell c holds index[start[c] .. start[c+1]). */
typedef struct cells {
    const double *xy;
    int n, nx, ny;
    double x0, y0, size;
    int *start, *index;
} cells;

/* Places in the primitive basis, and the points that still spread. */
typedef struct places {
    int *m, *n; /* [points]; INT_MIN: none yet */
    int *queue, head, tail;
    int *slot; /* open hash of taken places, point + 1 */
    unsigned mask;
    plft_vec u, v; /* steps of m and n */
} places;

static int cell_of(const cells *c, double x, double y)
{
    int i = (int)((x - c->x0) / c->size), j = (int)((y - c->y0) / c->size);

    i = i < 0 ? 0 : i >= c->nx ? c->nx - 1 : i;
    j = j < 0 ? 0 : j >= c->ny ? c->ny - 1 : j;
    return j * c->nx + i;
}

static void cells_bounds(cells *c)
{
    double x1 = c->xy[0], y1 = c->xy[1];
    int k;

    c->x0 = x1;
    c->y0 = y1;
    for (k = 1; k < c->n; k++) {
        c->x0 = fmin(c->x0, c->xy[2 * k]);
        c->y0 = fmin(c->y0, c->xy[2 * k + 1]);
        x1 = fmax(x1, c->xy[2 * k]);
        y1 = fmax(y1, c->xy[2 * k + 1]);
    }
    /* About one point a cell; never more cells than 4 n + 4. */
    c->size = sqrt((x1 - c->x0 + 1e-9) * (y1 - c->y0 + 1e-9) / c->n);
    c->size = fmax(c->size, fmax(x1 - c->x0, y1 - c->y0) / c->n);
    c->nx = (int)((x1 - c->x0) / c->size) + 1;
    c->ny = (int)((y1 - c->y0) / c->size) + 1;
}

static int cells_init(cells *c, const double *xy, int n)
{
    int k, total;

    c->xy = xy;
    c->n = n;
    cells_bounds(c);
    if (!(c->size > 0.0) || !isfinite(c->size)) {
        return -1;
    }
    total = c->nx * c->ny;
    c->start = calloc((size_t)total + 2, sizeof *c->start);
    c->index = malloc((size_t)n * sizeof *c->index);
    if (c->start == NULL || c->index == NULL) {
        return -1;
    }
    for (k = 0; k < n; k++) {
        c->start[cell_of(c, xy[2 * k], xy[2 * k + 1]) + 2]++;
    }
    for (k = 2; k <= total; k++) {
        c->start[k] += c->start[k - 1];
    }
    for (k = 0; k < n; k++) {
        c->index[c->start[cell_of(c, xy[2 * k], xy[2 * k + 1]) + 1]++] = k;
    }
    return 0;
}

/* Vectors from (x,y) to the points in the 5x5 cells around it, at most NEARBY. */
static int nearby(const cells *c, double x, double y, int *which, plft_vec *d)
{
    int base = cell_of(c, x, y), i0 = base % c->nx, j0 = base / c->nx;
    int i, j, k, count = 0;

    for (j = j0 > 2 ? j0 - 2 : 0; j <= j0 + 2 && j < c->ny; j++) {
        for (i = i0 > 2 ? i0 - 2 : 0; i <= i0 + 2 && i < c->nx; i++) {
            const int cell = j * c->nx + i;
            for (k = c->start[cell]; k < c->start[cell + 1] && count < NEARBY; k++) {
                which[count] = c->index[k];
                d[count].x = c->xy[2 * c->index[k]] - x;
                d[count].y = c->xy[2 * c->index[k] + 1] - y;
                count++;
            }
        }
    }
    return count;
}

/* Point nearest to (x,y), or -1; *r2 its squared distance; `not` does not count. */
static int nearest(const cells *c, double x, double y, int not, double *r2)
{
    int which[NEARBY], n, k, best = -1;
    plft_vec d[NEARBY];

    n = nearby(c, x, y, which, d);
    for (k = 0; k < n; k++) {
        double r = d[k].x * d[k].x + d[k].y * d[k].y;
        if (which[k] != not &&(best < 0 || r < *r2)) {
            best = which[k];
            *r2 = r;
        }
    }
    return best;
}

/* Vectors from sampled points to their neighbours nearer than 1.6 times the nearest
 * one, both signs; *pitch is the median nearest distance. */
static int gather_votes(const cells *c, plft_vec *votes, double *pitch)
{
    double r[SAMPLES];
    int step = c->n / SAMPLES + 1, which[NEARBY], n, k, p, count = 0, samples = 0;
    plft_vec d[NEARBY];

    for (p = 0; p < c->n && samples < SAMPLES; p += step) {
        double r2 = 0.0;
        if (nearest(c, c->xy[2 * p], c->xy[2 * p + 1], p, &r2) < 0 || !(r2 > 0.0)) {
            continue;
        }
        r[samples++] = sqrt(r2);
        n = nearby(c, c->xy[2 * p], c->xy[2 * p + 1], which, d);
        for (k = 0; k < n && count < VOTES; k++) {
            double q = d[k].x * d[k].x + d[k].y * d[k].y;
            if (which[k] != p && q < 2.56 * r2) {
                votes[count++] = d[k];
            }
        }
    }
    *pitch = plft_median(r, samples);
    return count;
}

/* Mean of the votes within `reach` of the fullest place among those not along
 * `avoid` (NULL: any); returns how many. */
static int strongest(const plft_vec *votes, int n, double reach, const plft_vec *avoid,
                     plft_vec *mean)
{
    int step = n / 400 + 1, k, q, best = 0;

    for (k = 0; k < n; k += step) {
        plft_vec s = {0.0, 0.0}, c = votes[k];
        int count = 0;
        if (avoid != NULL &&
            fabs(c.x * avoid->y - c.y * avoid->x) <
                0.5 * sqrt((c.x * c.x + c.y * c.y) *
                           (avoid->x * avoid->x + avoid->y * avoid->y))) {
            continue;
        }
        for (q = 0; q < n; q++) {
            double dx = votes[q].x - c.x, dy = votes[q].y - c.y;
            if (dx * dx + dy * dy < reach * reach) {
                s.x += votes[q].x;
                s.y += votes[q].y;
                count++;
            }
        }
        if (count > best) {
            best = count;
            mean->x = s.x / count;
            mean->y = s.y / count;
        }
    }
    return best;
}

static int find_steps(const cells *c, int want, plft_lattice *lattice)
{
    plft_vec *votes = malloc(VOTES * sizeof *votes), v1, v2;
    double pitch;
    int n, status = -1;

    if (votes == NULL) {
        return -1;
    }
    n = gather_votes(c, votes, &pitch);
    if (strongest(votes, n, 0.15 * pitch, NULL, &v1) > 0 &&
        strongest(votes, n, 0.15 * pitch, &v1, &v2) > 0) {
        status = plft_lattice_orient(v1, v2, want, lattice);
    }
    free(votes);
    return status;
}

static unsigned slot_of(const places *s, int m, int n)
{
    unsigned h = (unsigned)m * 2654435761u ^ (unsigned)n * 2246822519u;
    unsigned k = (h ^ (h >> 15)) & s->mask;

    while (s->slot[k] != 0) {
        int p = s->slot[k] - 1;
        if (s->m[p] == m && s->n[p] == n) {
            break;
        }
        k = (k + 1u) & s->mask;
    }
    return k;
}

/* Give point p the place (m,n) if both are free. */
static void place(places *s, int p, int m, int n)
{
    unsigned k = slot_of(s, m, n);

    if (s->m[p] == INT_MIN && s->slot[k] == 0) {
        s->slot[k] = p + 1;
        s->m[p] = m;
        s->n[p] = n;
        s->queue[s->tail++] = p;
    }
}

/* Spread from every queued point to its four neighbours.  A step already seen on the
 * other side of the point predicts better than the mean step: it carries the local
 * distortion. */
static void spread(const cells *c, places *s, double reach)
{
    static const int step[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

    while (s->head < s->tail) {
        const int p = s->queue[s->head++];
        int k;
        for (k = 0; k < 4; k++) {
            const int m = step[k][0], n = step[k][1];
            const int back = s->slot[slot_of(s, s->m[p] - m, s->n[p] - n)] - 1;
            double x = c->xy[2 * p], y = c->xy[2 * p + 1], r2 = 0.0;
            int q;
            if (back >= 0) {
                x += x - c->xy[2 * back];
                y += y - c->xy[2 * back + 1];
            } else {
                x += m * s->u.x + n * s->v.x;
                y += m * s->u.y + n * s->v.y;
            }
            q = nearest(c, x, y, p, &r2);
            if (q >= 0 && r2 < reach * reach) {
                place(s, q, s->m[p] + m, s->n[p] + n);
            }
        }
    }
}

static int places_init(places *s, int n, const plft_lattice *l)
{
    unsigned size = 16u;
    int k;

    while (size < 3u * (unsigned)n) {
        size *= 2u;
    }
    memset(s, 0, sizeof *s);
    s->mask = size - 1u;
    s->m = malloc((size_t)n * sizeof *s->m);
    s->n = malloc((size_t)n * sizeof *s->n);
    s->queue = malloc((size_t)n * sizeof *s->queue);
    s->slot = calloc(size, sizeof *s->slot);
    s->u = l->a;
    s->v = l->b;
    if (l->kind == PLFX_LATTICE_HEX) {
        s->v.x += l->odd.x;
        s->v.y += l->odd.y;
    }
    for (k = 0; s->m != NULL && k < n; k++) {
        s->m[k] = INT_MIN;
    }
    return s->m != NULL && s->n != NULL && s->queue != NULL && s->slot != NULL ? 0 : -1;
}

static void places_free(places *s)
{
    free(s->m);
    free(s->n);
    free(s->queue);
    free(s->slot);
}

/* The point nearest to the mean of all. */
static int seed(const cells *c)
{
    double x = 0.0, y = 0.0, best = HUGE_VAL;
    int k, p = 0;

    for (k = 0; k < c->n; k++) {
        x += c->xy[2 * k] / c->n;
        y += c->xy[2 * k + 1] / c->n;
    }
    for (k = 0; k < c->n; k++) {
        double dx = c->xy[2 * k] - x, dy = c->xy[2 * k + 1] - y;
        if (dx * dx + dy * dy < best) {
            best = dx * dx + dy * dy;
            p = k;
        }
    }
    return p;
}

static int floor_half(int n)
{
    return n >= 0 ? n / 2 : -((1 - n) / 2);
}

/* Rows and columns from places: row 0 and column 0 in use, odd rows to the right. */
static void to_rows(const places *s, int n, plft_order *o)
{
    int k, hex = o->lattice.kind == PLFX_LATTICE_HEX;
    int n0 = INT_MAX, n1 = INT_MIN, c0 = INT_MAX, c1 = INT_MIN;

    for (k = 0; k < s->tail; k++) {
        int row = s->n[s->queue[k]];
        n0 = row < n0 ? row : n0;
        n1 = row > n1 ? row : n1;
    }
    for (k = 0; k < n; k++) {
        if (s->m[k] == INT_MIN) {
            o->row[k] = o->col[k] = -1;
            continue;
        }
        o->row[k] = s->n[k] - n0;
        o->col[k] = s->m[k] + (hex ? floor_half(o->row[k]) : 0);
        c0 = o->col[k] < c0 ? o->col[k] : c0;
        c1 = o->col[k] > c1 ? o->col[k] : c1;
    }
    for (k = 0; k < n; k++) {
        o->col[k] -= o->row[k] >= 0 ? c0 : 0;
    }
    o->lattice.nx = c1 - c0 + 1;
    o->lattice.ny = n1 - n0 + 1;
    o->placed = s->tail;
}

/* Least-squares origin, a, b (and odd = a/2 on hexagonal lattices). */
static int fit_lattice(const cells *c, plft_order *o)
{
    double g[9] = {0}, rx[3] = {0}, ry[3] = {0}, x[3], y[3];
    int k, i, j, hex = o->lattice.kind == PLFX_LATTICE_HEX;

    for (k = 0; k < c->n; k++) {
        double f[3];
        if (o->row[k] < 0) {
            continue;
        }
        f[0] = 1.0;
        f[1] = o->col[k] + (hex && o->row[k] % 2 != 0 ? 0.5 : 0.0);
        f[2] = o->row[k];
        for (i = 0; i < 3; i++) {
            rx[i] += f[i] * c->xy[2 * k];
            ry[i] += f[i] * c->xy[2 * k + 1];
            for (j = 0; j < 3; j++) {
                g[3 * i + j] += f[i] * f[j];
            }
        }
    }
    if (plft_spd_invert(g, 3) != 0) {
        return -1;
    }
    plft_mat_vec(g, rx, 3, x);
    plft_mat_vec(g, ry, 3, y);
    o->lattice.origin.x = x[0];
    o->lattice.origin.y = y[0];
    o->lattice.a.x = x[1];
    o->lattice.a.y = y[1];
    o->lattice.b.x = x[2];
    o->lattice.b.y = y[2];
    o->lattice.odd.x = hex ? 0.5 * x[1] : 0.0;
    o->lattice.odd.y = hex ? 0.5 * y[1] : 0.0;
    return 0;
}

/* Mean offset of the placed points around (x,y) from the fitted lattice: distortion. */
static plft_vec local_offset(const cells *c, const plft_order *o, double x, double y)
{
    int which[NEARBY], n, k, count = 0;
    plft_vec d[NEARBY], mean = {0.0, 0.0};

    n = nearby(c, x, y, which, d);
    for (k = 0; k < n; k++) {
        const int p = which[k];
        plft_vec at;
        if (o->row[p] < 0) {
            continue;
        }
        at = plft_lattice_at(&o->lattice, o->col[p], o->row[p]);
        mean.x += c->xy[2 * p] - at.x;
        mean.y += c->xy[2 * p + 1] - at.y;
        count++;
    }
    mean.x /= count > 0 ? count : 1;
    mean.y /= count > 0 ? count : 1;
    return mean;
}

/* Points that no walk reached: the lattice fitted so far, moved by what the placed
 * points around them say, offers them its nearest place, if that is free and within
 * `reach`. */
static void place_islands(const cells *c, places *s, const plft_order *o, int first,
                          double reach)
{
    const int hex = o->lattice.kind == PLFX_LATTICE_HEX;
    const int n0 = -o->row[first];
    const int c0 = -o->col[first] + (hex ? floor_half(o->row[first]) : 0);
    int k;

    for (k = 0; k < c->n; k++) {
        plft_vec p = {c->xy[2 * k], c->xy[2 * k + 1]}, at, off;
        int i, j;
        if (s->m[k] != INT_MIN) {
            continue;
        }
        off = local_offset(c, o, p.x, p.y);
        p.x -= off.x;
        p.y -= off.y;
        plft_lattice_nearest(&o->lattice, p, &i, &j);
        at = plft_lattice_at(&o->lattice, i, j);
        if (hypot(at.x - p.x, at.y - p.y) < reach) {
            place(s, k, i + c0 - (hex ? floor_half(j) : 0), j + n0);
        }
    }
}

static int walk(const cells *c, places *s, plft_order *o)
{
    const double pitch = plft_lattice_pitch(&o->lattice);
    int first = seed(c), round;

    place(s, first, 0, 0);
    for (round = 0; round <= 6; round++) { /* islands, then what they led to */
        spread(c, s, REACH * pitch);
        to_rows(s, c->n, o);
        if (fit_lattice(c, o) != 0) {
            return -1;
        }
        if (s->tail == c->n) {
            break;
        }
        place_islands(c, s, o, first, (REACH + 0.05 * round) * pitch);
    }
    to_rows(s, c->n, o);
    return fit_lattice(c, o);
}

void plft_order_free(plft_order *o)
{
    free(o->row);
    free(o->col);
    o->row = o->col = NULL;
}

int plft_order_points(const double *xy, int n, int want, plft_order *order)
{
    plft_order o;
    cells c;
    places s;
    int status = -1;

    memset(&o, 0, sizeof o);
    memset(&c, 0, sizeof c);
    memset(&s, 0, sizeof s);
    if (n < 9) {
        return -1;
    }
    o.row = malloc((size_t)n * sizeof *o.row);
    o.col = malloc((size_t)n * sizeof *o.col);
    if (o.row != NULL && o.col != NULL && cells_init(&c, xy, n) == 0 &&
        find_steps(&c, want, &o.lattice) == 0 && places_init(&s, n, &o.lattice) == 0) {
        status = walk(&c, &s, &o);
    }
    places_free(&s);
    free(c.start);
    free(c.index);
    if (status != 0 || 2 * o.placed < n) {
        plft_order_free(&o);
        return -1;
    }
    *order = o;
    return 0;
}
