/* SPDX-License-Identifier: MIT
 * Page about a calibration. */
#include "calib/report.h"

#include "calib/embed.h"
#include "calib/figures.h"
#include "common/colour.h"
#include "common/err.h"
#include "common/out.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDE    1400 /* pixels of the overview picture, at most */
#define CIRCLES 8000 /* lenses drawn over it, at most */
#define CUT     180  /* pixels of a full-size cut on a side */
#define CELLS   36   /* columns of the vector map, at most */
#define BINS    41

typedef struct page {
    FILE *f;
    const plft_calib *c;
    const plft_grey *g;
    const plft_saved *s;
    double low, high; /* sample values shown black and white */
} page;

static const char style[] =
    "<style>body{font:15px/1.45 sans-serif;max-width:1100px;margin:1.5em auto;"
    "padding:0 1em;color:#222}h1{font-size:1.4em}h2{font-size:1.1em;margin:1.6em 0 "
    ".4em}"
    ".v{padding:.7em 1em;border-radius:6px;color:#fff;font-weight:bold}"
    ".green{background:#2a7d3c}.amber{background:#b56a00}.red{background:#b3261e}"
    "table{border-collapse:collapse}td{padding:.15em .9em .15em 0;vertical-align:top}"
    "td+td{font-variant-numeric:tabular-nums}svg,img{border:1px solid #999;"
    "background:#fff}.row{display:flex;flex-wrap:wrap;gap:14px}figure{margin:0}"
    "figcaption{font-size:.85em;color:#555;max-width:420px}#o{width:100%;height:auto;"
    "cursor:grab;touch-action:none}.k{fill:none;stroke:#35d04a}.d{fill:none;"
    "stroke:#ff3b30}.i{fill:none;stroke:#ffb000}</style>";

static const char script[] =
    "<script>(function(){var s=document.getElementById('o'),v=s.viewBox.baseVal,"
    "w=v.width,h=v.height,d=null;function at(e){var r=s.getBoundingClientRect();return"
    "[v.x+(e.clientX-r.left)/r.width*v.width,v.y+(e.clientY-r.top)/r.height*v.height]}"
    "s.addEventListener('wheel',function(e){var p=at(e),k=e.deltaY>0?1.25:0.8,"
    "n=Math.min(w,Math.max(w/60,v.width*k));k=n/v.width;v.x=p[0]-(p[0]-v.x)*k;"
    "v.y=p[1]-(p[1]-v.y)*k;v.width=n;v.height=n*h/w;e.preventDefault()},"
    "{passive:false});s.addEventListener('pointerdown',function(e){d=at(e);"
    "s.setPointerCapture(e.pointerId)});s.addEventListener('pointermove',function(e){"
    "if(d){var p=at(e);v.x+=d[0]-p[0];v.y+=d[1]-p[1]}});s.addEventListener('pointerup',"
    "function(){d=null});s.addEventListener('dblclick',function(){v.x=v.y=0;v.width=w;"
    "v.height=h})})();</script>";

static uint8_t tone(const page *p, double v)
{
    const double t = (v - p->low) / (p->high - p->low);
    return (uint8_t)(255.0 * sqrt(fmax(0.0, fmin(1.0, t))) + 0.5); /* gamma 2 */
}

/* Grey levels of the page from a sparse look at the frame. */
static void levels(page *p)
{
    const size_t n = (size_t)p->g->w * (size_t)p->g->h, step = n / 20000u + 1u;
    size_t count[256] = {0}, total = 0, sum = 0, k;
    int b;

    for (k = 0; k < n; k += step) {
        count[p->g->px[k] >> 8]++;
        total++;
    }
    p->low = 0.0;
    p->high = 65535.0;
    for (b = 0; b < 256; b++) {
        sum += count[b];
        if (sum * 200u < total) {
            p->low = b * 256.0;
        }
        if (sum * 500u <= total * 499u) {
            p->high = (b + 2) * 256.0;
        }
    }
    p->high = fmax(p->high, p->low + 512.0);
}

/* A part of the frame, reduced `by` times by the mean, as the address of a picture. */
static void picture(const page *p, int x0, int y0, int w, int h, int by)
{
    const int ow = w / by, oh = h / by;
    uint8_t *px = malloc((size_t)ow * (size_t)oh);
    int x, y, i, j;

    for (y = 0; px != NULL && y < oh; y++) {
        for (x = 0; x < ow; x++) {
            double sum = 0.0;
            for (j = 0; j < by; j++) {
                const uint16_t *row = p->g->px +
                                      (size_t)(y0 + y * by + j) * (size_t)p->g->w + x0 +
                                      x * by;
                for (i = 0; i < by; i++) {
                    sum += row[i];
                }
            }
            px[y * ow + x] = tone(p, sum / (by * by));
        }
    }
    if (px != NULL) {
        plft_embed_png(p->f, px, ow, oh, 1);
    }
    free(px);
}

static const char *class_of(const plft_spot *s)
{
    return (s->flags & PLFX_LENS_MISSING) != 0u ? "d"
           : (s->flags & (PLFX_LENS_INTERP | PLFX_LENS_DIM | PLFX_LENS_CLIPPED)) != 0u
               ? "i"
               : "k";
}

/* Circle and centre mark of a lens, in frame pixels less (x0,y0). */
static void mark(const page *p, int lens, double x0, double y0, double width)
{
    const plft_vec c = p->c->final[lens];
    const double x = c.x - p->g->shift - x0 + 0.5, y = c.y - p->g->shift - y0 + 0.5;
    const double m = 0.12 * p->c->pitch;

    fprintf(p->f,
            "<path class='%s' stroke-width='%.2g' d='M%.2f %.2fh%.2fM%.2f %.2fv%.2f'/>",
            class_of(&p->c->field.spot[lens]), width, x - m, y, 2 * m, x, y - m, 2 * m);
    fprintf(p->f,
            "<circle class='%s' stroke-width='%.2g' cx='%.2f' cy='%.2f' r='%.2f'/>",
            class_of(&p->c->field.spot[lens]), width, x, y, p->c->usable_radius);
}

static int off_sensor(const page *p, int lens)
{
    const plft_vec c = p->c->final[lens];
    return c.x < -0.5 || c.y < -0.5 || c.x > p->g->w - 0.5 || c.y > p->g->h - 0.5;
}

static void overview(const page *p)
{
    const int by = (p->g->w + WIDE - 1) / WIDE, n = p->c->lattice.nx * p->c->lattice.ny;
    const int step = n / CIRCLES + 1;
    int k;

    fprintf(p->f,
            "<h2>Found centres</h2><svg id='o' viewBox='0 0 %d %d'><image "
            "width='%d' height='%d' preserveAspectRatio='none' href='",
            p->g->w, p->g->h, p->g->w / by * by, p->g->h / by * by);
    picture(p, 0, 0, p->g->w, p->g->h, by);
    fputs("'/>", p->f);
    for (k = 0; k < n; k++) {
        const int flagged = class_of(&p->c->field.spot[k])[0] != 'k';
        if (!off_sensor(p, k) && (flagged || k % step == 0)) {
            mark(p, k, 0.0, 0.0, 0.05 * p->c->pitch);
        }
    }
    fprintf(p->f,
            "</svg><p>Wheel: zoom. Drag: move. Double click: all. Circles have the "
            "usable radius; green: good%s, orange: dim, clipped or interpolated, "
            "red: no light.</p>",
            step > 1 ? " (every few only)" : "");
}

/* A full-size cut around (cx,cy), drawn twice its size, with what lies in it. */
static void cut(const page *p, double cx, double cy, const char *caption)
{
    const int w = CUT < p->g->w ? CUT : p->g->w, h = CUT < p->g->h ? CUT : p->g->h;
    int x0 = (int)cx - w / 2, y0 = (int)cy - h / 2, k;

    x0 = x0 < 0 ? 0 : x0 + w > p->g->w ? p->g->w - w : x0;
    y0 = y0 < 0 ? 0 : y0 + h > p->g->h ? p->g->h - h : y0;
    fprintf(p->f,
            "<figure><svg width='340' viewBox='0 0 %d %d'><image width='%d' "
            "height='%d' style='image-rendering:pixelated' href='",
            w, h, w, h);
    picture(p, x0, y0, w, h, 1);
    fputs("'/>", p->f);
    for (k = 0; k < p->c->lattice.nx * p->c->lattice.ny; k++) {
        const double x = p->c->final[k].x - x0, y = p->c->final[k].y - y0;
        if (x > 0 && y > 0 && x < w && y < h) {
            mark(p, k, x0, y0, 0.6);
        }
    }
    fprintf(p->f, "</svg><figcaption>%s, at (%d, %d)</figcaption></figure>", caption,
            x0, y0);
}

static void cuts(const page *p)
{
    fputs("<h2>Full size</h2><div class='row'>", p->f);
    cut(p, 0.5 * p->g->w, 0.5 * p->g->h, "Middle");
    cut(p, 0.0, 0.0, "Top left");
    cut(p, p->g->w, p->g->h, "Bottom right");
    fputs("</div>", p->f);
}

static int measured(const plft_spot *s)
{
    return (s->flags & (PLFX_LENS_MISSING | PLFX_LENS_INTERP)) == 0u;
}

/* Mean spot minus plane lattice in blocks of lenses, as arrows; the longest arrow is
 * drawn a block long. */
static void vectors(const page *p)
{
    const int nx = p->c->lattice.nx, ny = p->c->lattice.ny,
              by = (nx + CELLS - 1) / CELLS;
    const int cx = (nx + by - 1) / by, cy = (ny + by - 1) / by;
    double *v = calloc(3u * (size_t)(cx * cy), sizeof *v), longest = 1e-9, scale;
    int i, j, k;

    for (k = 0; v != NULL && k < nx * ny; k++) {
        const plft_spot *s = &p->c->field.spot[k];
        const plft_vec l = plft_lattice_at(&p->c->lattice, k % nx, k / nx);
        double *cell = v + 3 * (k / nx / by * cx + k % nx / by);
        if (measured(s)) {
            cell[0] += s->x - l.x;
            cell[1] += s->y - l.y;
            cell[2] += 1.0;
        }
    }
    for (k = 0; v != NULL && k < cx * cy; k++) {
        if (v[3 * k + 2] > 0.0) {
            v[3 * k] /= v[3 * k + 2];
            v[3 * k + 1] /= v[3 * k + 2];
            longest = fmax(longest, hypot(v[3 * k], v[3 * k + 1]));
        }
    }
    scale = 14.0 / longest;
    fprintf(p->f, "<figure><svg width='520' viewBox='0 0 %d %d'>", cx * 14, cy * 14);
    for (j = 0; v != NULL && j < cy; j++) {
        for (i = 0; i < cx; i++) {
            const double *cell = v + 3 * (j * cx + i);
            if (cell[2] > 0.0) {
                fprintf(p->f,
                        "<path stroke='#0645ad' d='M%d %dl%.2f %.2f'/><circle r='1.3' "
                        "cx='%d' cy='%d'/>",
                        i * 14 + 7, j * 14 + 7, scale * cell[0], scale * cell[1],
                        i * 14 + 7, j * 14 + 7);
            }
        }
    }
    fprintf(p->f,
            "</svg><figcaption>Measured minus plane lattice, mean of %d x %d "
            "lenses; the longest arrow is %.4f px. A pattern is distortion, "
            "disorder is noise.</figcaption></figure>",
            by, by, longest);
    free(v);
}

static void histogram(const page *p)
{
    const double width = fmax(8.0 * p->c->model.rms, 1e-6);
    int count[2][BINS] = {{0}}, k, b, axis, most = 1;

    for (k = 0; k < p->c->lattice.nx * p->c->lattice.ny; k++) {
        const plft_spot *s = &p->c->field.spot[k];
        const plft_vec m =
            plft_model_at(&p->c->model, k % p->c->lattice.nx, k / p->c->lattice.nx);
        const double r[2] = {s->x - m.x, s->y - m.y};
        for (axis = 0; measured(s) && axis < 2; axis++) {
            b = (int)floor((r[axis] / width + 0.5) * BINS);
            if (b >= 0 && b < BINS) {
                count[axis][b]++;
                most = count[axis][b] > most ? count[axis][b] : most;
            }
        }
    }
    fputs("<figure><svg width='420' viewBox='0 0 420 230'>", p->f);
    for (axis = 0; axis < 2; axis++) {
        fprintf(p->f, "<path fill='none' stroke-width='2' stroke='%s' d='M5 205",
                axis == 0 ? "#0645ad" : "#c2410c");
        for (b = 0; b < BINS; b++) {
            fprintf(p->f, "V%.1fh10", 205.0 - 190.0 * count[axis][b] / most);
        }
        fputs("V205'/>", p->f);
    }
    fprintf(p->f,
            "<path stroke='#999' d='M0 205H420M210 0V210'/><text x='4' y='223' "
            "font-size='12'>%.4f px</text><text x='416' y='223' font-size='12' "
            "text-anchor='end'>+%.4f px</text></svg><figcaption>Measured minus "
            "model, x blue, y orange; rms %.4f px an axis, of which a spot's own "
            "noise is %.4f.</figcaption></figure>",
            -0.5 * width, 0.5 * width, p->c->model.rms, p->c->spot_sigma);
}

/* Mean micro-image, six samples a pixel, with the usable radius. */
static void micro_image(const page *p)
{
    const int r = (int)ceil(0.55 * p->c->pitch), n = 2 * r + 1, up = n > 60 ? 2 : 6;
    uint8_t *px = malloc((size_t)(n * up) * (size_t)(n * up));
    int x, y;

    fprintf(p->f,
            "<figure><svg width='280' viewBox='0 0 %d %d'><image width='%d' "
            "height='%d' href='",
            n, n, n, n);
    for (y = 0; px != NULL && y < n * up; y++) {
        for (x = 0; x < n * up; x++) {
            px[y * n * up + x] =
                tone(p, plft_shape_at(&p->c->shape,
                                      p->c->shape.centre.x + (x + 0.5) / up - 0.5 - r,
                                      p->c->shape.centre.y + (y + 0.5) / up - 0.5 - r));
        }
    }
    if (px != NULL) {
        plft_embed_png(p->f, px, n * up, n * up, 1);
    }
    free(px);
    fprintf(p->f,
            "'/><circle class='k' stroke-width='.15' cx='%.1f' cy='%.1f' r='%.2f'/>"
            "<circle class='i' stroke-width='.15' cx='%.1f' cy='%.1f' r='%.2f'/>"
            "</svg><figcaption>Mean micro-image; usable radius green, micro-image "
            "orange; cross-talk at the border %.1f %%.</figcaption></figure>",
            n / 2.0, n / 2.0, p->c->usable_radius, n / 2.0, n / 2.0, p->c->edge_radius,
            100.0 * p->c->crosstalk);
}

static void profile(const page *p)
{
    const double reach = 0.55 * p->c->pitch;
    double top =
        plft_shape_at(&p->c->shape, p->c->shape.centre.x, p->c->shape.centre.y);
    int k, a;

    top = fmax(top, 1.0);
    fputs("<figure><svg width='420' viewBox='0 0 420 230'><path fill='none' "
          "stroke-width='2' stroke='#0645ad' d='",
          p->f);
    for (k = 0; k <= 100; k++) {
        double sum = 0.0;
        for (a = 0; a < 24; a++) {
            const double t = 6.28318530717958647693 * a / 24.0, r = reach * k / 100.0;
            sum += plft_shape_at(&p->c->shape, p->c->shape.centre.x + r * cos(t),
                                 p->c->shape.centre.y + r * sin(t)) /
                   24.0;
        }
        fprintf(p->f, "%s%.1f %.1f", k == 0 ? "M" : "L", 10.0 + 4.0 * k,
                205.0 - 180.0 * fmin(sum / top, 1.1));
    }
    fprintf(p->f,
            "'/><path stroke='#2a7d3c' d='M%.1f 0V205'/><path stroke='#b56a00' "
            "d='M%.1f 0V205'/><path stroke='#999' d='M0 205H420'/><text x='10' "
            "y='223' font-size='12'>0</text><text x='410' y='223' font-size='12' "
            "text-anchor='end'>%.2f px</text></svg><figcaption>Mean over circles "
            "against radius; usable %.2f px, micro-image %.2f px.</figcaption>"
            "</figure>",
            10.0 + 400.0 * p->c->usable_radius / reach,
            10.0 + 400.0 * p->c->edge_radius / reach, reach, p->c->usable_radius,
            p->c->edge_radius);
}

/* One pixel a lens: its contrast, or its white gain where there are gains. */
static void lens_map(const page *p)
{
    const int nx = p->c->lattice.nx, ny = p->c->lattice.ny;
    uint8_t *px = malloc(3u * (size_t)(nx * ny));
    double lo = HUGE_VAL, hi = 0.0, v;
    int k, pass;

    for (pass = 0; px != NULL && pass < 2; pass++) { /* 0: range; 1: paint */
        for (k = 0; k < nx * ny; k++) {
            const int ok = measured(&p->c->field.spot[k]);
            v = p->s->gain != NULL ? p->s->gain[k] / 8192.0
                                   : (double)p->c->field.spot[k].gain;
            if (pass == 0 && ok) {
                lo = fmin(lo, v);
                hi = fmax(hi, v);
            } else if (pass == 1) {
                plft_colour(ok ? (float)((v - lo) / fmax(hi - lo, 1e-9)) : NAN,
                            px + 3 * k);
            }
        }
    }
    fputs("<figure><img width='420' style='image-rendering:pixelated' alt='lens map' "
          "src='",
          p->f);
    if (px != NULL) {
        plft_embed_png(p->f, px, nx, ny, 3);
    }
    fprintf(p->f,
            "'><figcaption>%s a lens, %.3f (dark) to %.3f (bright); grey: not "
            "measured.</figcaption></figure>",
            p->s->gain != NULL ? "White gain of" : "Contrast against the mean of", lo,
            hi);
    free(px);
}

/* NOLINTNEXTLINE(misc-no-recursion): objects of `figures` nest once */
static void table(const page *p, const json_t *figures)
{
    const char *key;
    json_t *v;

    json_object_foreach((json_t *)(uintptr_t)figures, key, v)
    {
        if (json_is_object(v)) {
            table(p, v);
        } else {
            char *text = json_dumps(v, JSON_ENCODE_ANY | JSON_REAL_PRECISION(8));
            fprintf(p->f, "<tr><td>%s</td><td>%s</td></tr>", key,
                    text != NULL ? text : "");
            free(text);
        }
    }
}

static void write_page(page *p, const json_t *figures)
{
    char reason[200];
    const plft_verdict v = plft_calib_verdict(p->c, p->g, reason, sizeof reason);
    const char *name = plft_verdict_name(v);

    levels(p);
    fprintf(p->f,
            "<!DOCTYPE html><html lang='en'><meta charset='utf-8'><title>plenofix "
            "calibration: %s</title>%s<h1>Calibration</h1><p class='v %s'>%s: %s</p>",
            name, style, name, name, reason);
    overview(p);
    cuts(p);
    fputs("<h2>Residuals</h2><div class='row'>", p->f);
    vectors(p);
    histogram(p);
    fputs("</div><h2>Micro-image and light</h2><div class='row'>", p->f);
    micro_image(p);
    profile(p);
    lens_map(p);
    fputs("</div><h2>Figures</h2><p>Pixels and degrees; sigma: one standard deviation."
          "</p><table>",
          p->f);
    table(p, figures);
    fprintf(p->f, "</table>%s</html>\n", script);
}

int plft_report_write(const char *path, const plft_calib *c, const plft_grey *g,
                      const plft_saved *s, const json_t *figures)
{
    page p = {NULL, c, g, s, 0.0, 0.0};
    plft_out out;
    int status;

    memset(&out, 0, sizeof out);
    status = plft_out_open(&out, path);
    if (status != 0) {
        return status;
    }
    p.f = out.file;
    write_page(&p, figures);
    return plft_out_commit(&out);
}
