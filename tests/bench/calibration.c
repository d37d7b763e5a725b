/* SPDX-License-Identifier: MIT
 * Accuracy, speed and memory of the calibration on frames drawn from formulas.
 * Prints one line a case and a verdict against the project's figures; exit 1 when
 * one is missed.  Arguments: `quick` (the default) runs the accuracy and stress
 * cases, `full` adds the 16 megapixel frame and repeated draws for the stated
 * 1-sigma. */
#define _POSIX_C_SOURCE 200809L
#include "draw.h"

#include "calib/calib.h"
#include "common/progress.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

typedef struct limits { /* 0: not asked for */
    double spot, fit, pitch, rotation;
} limits;

typedef struct score {
    int found, invented, missed, flagged_dead, dead, flagged_good, good;
    double spot_x, spot_y, fit;     /* rms px: per lens and axis; 2-D after the fit */
    double pitch, rotation, origin; /* errors */
    double seconds;
} score;

static int misses;

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Drawn lens nearest to lens k of the table, or -1 beyond a third of the pitch. */
static int match(const draw_frame *f, const draw_spec *s, plft_vec p)
{
    int k, best = -1;
    double least = s->pitch * s->pitch / 9.0;

    for (k = 0; k < f->lenses; k++) {
        double dx = f->xy[2 * k] - p.x, dy = f->xy[2 * k + 1] - p.y;
        if (dx * dx + dy * dy < least) {
            least = dx * dx + dy * dy;
            best = k;
        }
    }
    return best;
}

/* Column and row of drawn lens 0 in the table: the drawn array is then walked in
 * step. */
static int first_lens(const plft_calib *c, const draw_frame *f, const draw_spec *s)
{
    int k;

    for (k = 0; k < c->lattice.nx * c->lattice.ny; k++) {
        if (match(f, s, c->final[k]) == 0) {
            return k;
        }
    }
    return 0;
}

static void add_lens(score *r, const plft_calib *c, const draw_frame *f, int lens,
                     int at)
{
    const plft_spot *s = &c->field.spot[at];
    const double x = f->xy[2 * lens], y = f->xy[2 * lens + 1];
    const int bad =
        (s->flags & (PLFX_LENS_MISSING | PLFX_LENS_DIM | PLFX_LENS_INTERP)) != 0u;

    r->fit += pow(c->final[at].x - x, 2.0) + pow(c->final[at].y - y, 2.0);
    if (f->state[lens] == 0) {
        r->good++;
        r->flagged_good += bad;
        if (!bad) {
            r->spot_x += pow(s->x - x, 2.0);
            r->spot_y += pow(s->y - y, 2.0);
        }
    } else if (f->state[lens] == 1) {
        r->dead++;
        r->flagged_dead += bad;
    }
    r->found += (s->flags & PLFX_LENS_MISSING) == 0u;
}

static void judge(score *r, const plft_calib *c, const draw_frame *f,
                  const draw_spec *s)
{
    const int at0 = first_lens(c, f, s), i0 = at0 % c->lattice.nx,
              j0 = at0 / c->lattice.nx;
    int k, seen = 0, lit = 0;

    for (k = 0; k < f->lenses; k++) {
        const int i = i0 + k % s->nx, j = j0 + k / s->nx;
        if (i >= c->lattice.nx || j >= c->lattice.ny) {
            r->missed += f->state[k] == 0;
            continue;
        }
        add_lens(r, c, f, k, j * c->lattice.nx + i);
        seen++;
    }
    for (k = 0; k < c->lattice.nx * c->lattice.ny; k++) {
        lit += (c->field.spot[k].flags & PLFX_LENS_MISSING) == 0u;
    }
    r->invented = lit - r->found;
    r->fit = sqrt(r->fit / fmax(seen, 1));
    r->spot_x = sqrt(r->spot_x / fmax(r->good - r->flagged_good, 1));
    r->spot_y = sqrt(r->spot_y / fmax(r->good - r->flagged_good, 1));
    r->pitch = c->pitch - s->pitch;
    r->rotation = plft_lattice_rotation(&c->lattice) - s->rotation;
    r->origin = hypot(c->final[at0].x - f->xy[0], c->final[at0].y - f->xy[1]);
}

static const char *name(draw_spot spot)
{
    static const char *const names[3] = {"dots", "soft", "flat"};
    return names[spot];
}

static int over(double v, double limit)
{
    return limit > 0.0 && !(fabs(v) <= limit);
}

/* Draw, calibrate, compare.  0, or -1 when nothing was found. */
static int run(const draw_spec *s, score *r, plft_calib *c)
{
    const plft_calib_options o = {PLFT_LATTICE_AUTO, 0.0, 1};
    draw_frame f;
    plft_grey g;
    double start;
    int status;

    memset(r, 0, sizeof *r);
    draw(&f, s);
    plft_grey_take(&g, f.px, f.w, f.h, s->bits);
    start = now();
    status = plft_grey_finish(&g, NULL);
    plft_grey_drop_hot(&g);
    status = status != 0 ? status : plft_calibrate(c, &g, &o);
    r->seconds = now() - start;
    if (status == 0) {
        judge(r, c, &f, s);
    } else {
        printf("  %s\n", c->reason);
    }
    draw_free(&f);
    return status;
}

static void print(const draw_spec *s, const score *r, const plft_calib *c, int bad)
{
    printf("%-4s %-6s %5.1f  %5d %4d %4d  %.5f %.5f  %.5f  %+.6f %+.6f  %.4f %.5f  "
           "%.2f%s\n",
           name(s->spot), s->hex ? "hex" : "square", s->rotation, r->found, r->missed,
           r->invented, r->spot_x, r->spot_y, r->fit, r->pitch, r->rotation,
           c->spot_sigma, c->origin_sigma, r->seconds, bad ? "  MISSED" : "");
}

static void one(const draw_spec *s, const limits *l)
{
    plft_calib c;
    score r;
    int bad = 1;

    if (run(s, &r, &c) == 0) {
        bad = r.missed != 0 || r.invented != 0 ||
              over(fmax(r.spot_x, r.spot_y), l->spot) || over(r.fit, l->fit) ||
              over(r.pitch, l->pitch) || over(r.rotation, l->rotation) ||
              r.flagged_good * 1000 > r.good || r.flagged_dead * 20 < r.dead * 19;
        print(s, &r, &c, bad);
        if (r.dead > 0) {
            printf("     dead lenses flagged %d of %d, good ones %d of %d\n",
                   r.flagged_dead, r.dead, r.flagged_good, r.good);
        }
    }
    misses += bad;
    plft_calib_free(&c);
}

static const draw_spec plain = {DRAW_DOTS, 0,   60,    40,  15.0, 0.0, 20.3, 19.7, 1.6,
                                8,         0.8, 0.004, 0.0, 0.0,  0.0, 1.0,  0.0,  1,
                                0.0,       0.0, 0.0,   0.0, 0.0,  0.0, 0.0};

static void head(const char *title)
{
    printf(
        "\n%s\nspot lattice rot   found miss invt  rms x   rms y    fit 2-D  pitch err "
        "rot err     1-sigma: spot origin  s\n",
        title);
}

static void accuracy(void)
{
    static const double rotation[3] = {0.0, 0.3, 1.0};
    const limits dots = {0.006, 0.0007, 0.0002, 0.0005};
    const limits white = {0.0, 0.02, 0.0002, 0.0005};
    int spot, hex, k;

    head("2,400 lenses of 15 px, noise 0.4 % of full scale, 8 bits");
    for (spot = DRAW_DOTS; spot <= DRAW_FLAT; spot++) {
        for (hex = 0; hex < 2; hex++) {
            for (k = 0; k < 3; k++) {
                draw_spec s = plain;
                s.spot = (draw_spot)spot;
                s.hex = hex;
                s.rotation = rotation[k];
                s.seed = (unsigned)(100 * spot + 10 * hex + k + 1);
                one(&s, spot == DRAW_DOTS ? &dots : &white);
            }
        }
    }
}

static void range(void)
{
    static const double pitch[] = {7.0, 7.3, 9.93, 22.5, 48.0, 96.0, 150.0};
    static const double angle[] = {-15.0, -7.0, 4.0, 12.0, 15.0};
    const limits l = {0.0, 0.02, 0.0, 0.0};
    size_t k;

    head("pitch 7 to 150 px and rotation -15 to 15 degrees");
    for (k = 0; k < sizeof pitch / sizeof pitch[0]; k++) {
        draw_spec s = plain;
        s.pitch = pitch[k];
        s.sigma = 0.11 * pitch[k];
        s.nx = pitch[k] > 60.0 ? 8 : pitch[k] > 30.0 ? 16 : 40;
        s.ny = pitch[k] > 60.0 ? 7 : pitch[k] > 30.0 ? 14 : 36;
        s.hex = (int)k % 2;
        s.spot = k % 3 == 1 ? DRAW_SOFT : DRAW_DOTS;
        one(&s, &l);
    }
    for (k = 0; k < sizeof angle / sizeof angle[0]; k++) {
        draw_spec s = plain;
        s.rotation = angle[k];
        s.hex = (int)k % 2;
        one(&s, &l);
    }
}

/* One at a time, on spots of one kind. */
static void one_by_one(draw_spot spot, int hex, double rotation)
{
    const limits l = {0.05, 0.05, 0.0, 0.0};
    draw_spec s = plain;

    s.spot = spot;
    s.hex = hex;
    s.rotation = rotation;
    s.barrel = 0.001;
    one(&s, &l);
    s.barrel = 0.0;
    s.dead = 0.02;
    one(&s, &l);
    s.dead = 0.0;
    s.hot = 0.01;
    one(&s, &l);
    s.hot = 0.0;
    s.gradient = 3.0;
    one(&s, &l);
    s.gradient = 1.0;
    s.black = 0.2;
    one(&s, &l);
    s.black = 0.0;
    s.level = 0.25;
    one(&s, &l);
}

static void stress(void)
{
    const limits l = {0.05, 0.05, 0.0, 0.0};
    draw_spec s = plain;
    int spot, hex;

    head("barrel 0.1 %, 2 % dead, 1 % hot, 3:1 light, 20 % black, 6 bits of contrast, "
         "one "
         "by one: turned, then every lens of a row at one phase");
    for (spot = DRAW_DOTS; spot <= DRAW_FLAT; spot++) {
        for (hex = 0; hex < 2; hex++) {
            one_by_one((draw_spot)spot, hex, 0.2);
            one_by_one((draw_spot)spot, hex, 0.0);
        }
    }
    head("defocused; all at once");
    for (hex = 0; hex < 2; hex++) {
        s = plain;
        s.hex = hex;
        s.rotation = 0.2;
        s.sigma = 3.2;
        one(&s, &l);
        s.sigma = 2.4;
        s.level = 0.25;
        s.barrel = 0.001;
        s.dead = 0.02;
        s.hot = 0.01;
        s.gradient = 3.0;
        s.black = 0.2;
        one(&s, &l);
    }
}

/* Stated 1-sigma against the scatter over repeated draws. */
static void sigmas(void)
{
    enum { DRAWS = 24 };
    double pitch = 0.0, rotation = 0.0, pitch_said = 0.0, rotation_said = 0.0;
    double spot = 0.0, spot_said = 0.0;
    int k, bad;

    for (k = 0; k < DRAWS; k++) {
        draw_spec s = plain;
        plft_calib c;
        score r;
        s.hex = k % 2;
        s.rotation = 0.37 + 0.01 * k;
        s.seed = (unsigned)(1000 + k);
        if (run(&s, &r, &c) == 0) {
            pitch += r.pitch * r.pitch / DRAWS;
            rotation += r.rotation * r.rotation / DRAWS;
            spot += (r.spot_x * r.spot_x + r.spot_y * r.spot_y) / (2.0 * DRAWS);
            pitch_said += c.pitch_sigma * c.pitch_sigma / DRAWS;
            rotation_said += c.rotation_sigma * c.rotation_sigma / DRAWS;
            spot_said += c.spot_sigma * c.spot_sigma / DRAWS;
        }
        plft_calib_free(&c);
    }
    pitch = sqrt(pitch / pitch_said);
    rotation = sqrt(rotation / rotation_said);
    spot = sqrt(spot / spot_said);
    bad = over(log(pitch), log(1.5)) || over(log(rotation), log(1.5)) ||
          over(log(spot), log(1.5));
    misses += bad;
    printf(
        "\ntrue error over stated 1-sigma, %d draws: spot %.2f, pitch %.2f, rotation "
        "%.2f%s\n",
        DRAWS, spot, pitch, rotation, bad ? "  MISSED" : "");
}

static double peak_mib(void)
{
    struct rusage u;

    getrusage(RUSAGE_SELF, &u);
    return (double)u.ru_maxrss / 1024.0;
}

static void large(void)
{
    const limits l = {0.006, 0.0007, 0.0002, 0.0005};
    draw_spec s = plain;

    s.nx = 289;
    s.ny = 193;
    s.pitch = 16.97;
    s.rotation = 0.1;
    s.bits = 12;
    head("289 x 193 lenses of 17 px, 12 bits");
    one(&s, &l);
    printf("     peak of this process, drawing included: %.0f MiB\n", peak_mib());
}

int main(int argc, char **argv)
{
    const int full = argc > 1 && strcmp(argv[1], "full") == 0;
    const char *only = argc > 1 && !full ? argv[1] : NULL;

    if (only == NULL || strcmp(only, "accuracy") == 0) {
        accuracy();
    }
    if (only == NULL || strcmp(only, "range") == 0) {
        range();
    }
    if (only == NULL || strcmp(only, "stress") == 0) {
        stress();
    }
    if (full) {
        sigmas();
        large();
    }
    printf("\n%d missed\n", misses);
    return misses != 0;
}
