/* SPDX-License-Identifier: MIT */
#include "motion/report.h"

#include <math.h>
#include <stdio.h>

#include "common/out.h"

#define WIDE   880
#define HIGH   110
#define POINTS 1760 /* of a curve at most: minimum and maximum of each column */

static const char *const head =
    "<!doctype html><meta charset=utf-8><title>plenofix monitor</title><style>"
    "body{font:14px sans-serif;margin:2em;max-width:900px}table{border-collapse:"
    "collapse}td,th{padding:2px 10px;text-align:right;border-bottom:1px solid #ddd}"
    "svg{border:1px solid #999;display:block}figcaption{color:#444;margin-bottom:1em}"
    "figure{margin:0}.bad{color:#b00;font-weight:bold}</style><h1>Motion of "
    "regions</h1>\n";

static double value(const plft_series *m, int row, int k, int axis)
{
    return m->series[((size_t)row * (size_t)m->regions + (size_t)k) * 3 + (size_t)axis];
}

/* Least and greatest of a component, 0 when never measured. */
static void range(const plft_series *m, int k, int axis, double *low, double *high)
{
    int n = 0;
    int t;

    *low = 0;
    *high = 0;
    for (t = 0; t < m->rows; t++) {
        double v = value(m, t, k, axis);
        if (isfinite(v)) {
            *low = n == 0 || v < *low ? v : *low;
            *high = n == 0 || v > *high ? v : *high;
            n++;
        }
    }
}

/* A curve broken where nothing was measured; a long one by the least and the greatest
 * of each column. */
static void curve(FILE *f, const plft_series *m, int k, int axis, double low,
                  double high)
{
    double scale = high > low ? (HIGH - 10) / (high - low) : 0;
    int step = m->rows > POINTS ? m->rows / (POINTS / 2) : 1;
    int pen = 0;
    int t;

    fprintf(f, "<path fill=none stroke='#06c' d='");
    for (t = 0; t < m->rows; t += step) {
        double a = INFINITY;
        double b = -INFINITY;
        int s;
        for (s = t; s < t + step && s < m->rows; s++) {
            double v = value(m, s, k, axis);
            a = v < a ? v : a;
            b = v > b ? v : b;
        }
        if (a > b) {
            pen = 0;
            continue;
        }
        fprintf(f, "%c%.1f %.1f", pen ? 'L' : 'M', (double)WIDE * t / m->rows,
                HIGH - 5 - (a - low) * scale);
        fprintf(f, "L%.1f %.1f", (double)WIDE * t / m->rows + 0.1,
                HIGH - 5 - (b - low) * scale);
        pen = 1;
    }
    fprintf(f, "'/>");
}

static void region(FILE *f, const plft_series_report *r, int k)
{
    static const char *const name[3] = {"u", "v", "w"};
    const plft_series *m = r->motion;
    int bad = 0;
    double low;
    double high;
    int t;

    for (t = 0; t < m->rows; t++) {
        bad += m->flags[(size_t)t * (size_t)m->regions + (size_t)k] != 0;
    }
    range(m, k, r->axis, &low, &high);
    fprintf(f, "<figure><svg width=%d height=%d viewBox='0 0 %d %d'>", WIDE, HIGH, WIDE,
            HIGH);
    curve(f, m, k, r->axis, low, high);
    fprintf(f,
            "</svg><figcaption>region %d at lens (%d, %d)%s: %s from %.4g to %.4g %s, "
            "%d of %d frames flagged</figcaption></figure>\n",
            k, m->region[k].i, m->region[k].j,
            m->region[k].reference ? ", reference" : "", name[r->axis], low, high,
            r->axis == 2 ? m->w_unit : m->uv_unit, bad, m->rows);
}

static void spectrum(FILE *f, const plft_series_report *r)
{
    const plft_spectrum *s = r->spectrum;
    int k;

    if (s->bins == 0) {
        fprintf(f, "<p>No spectrum: under 128 frames.</p>\n");
        return;
    }
    fprintf(f,
            "<h2>Spectrum</h2><figure><svg width=%d height=160 viewBox='0 0 %d 160'>"
            "<path fill=none stroke='#06c' d='",
            WIDE, WIDE);
    for (k = 1; k < s->bins; k++) {
        double db = 20 * log10((s->amplitude[k] + 1.0) / 1e9);
        fprintf(f, "%c%.1f %.1f", k == 1 ? 'M' : 'L', (double)WIDE * k / s->bins,
                5 - (db < -60 ? -60 : db) * 2.5);
    }
    fprintf(f, "'/>");
    for (k = 0; k < r->modes; k++) {
        double x = WIDE * r->line[k].hz / s->hz_bin / s->bins;
        fprintf(f,
                "<path stroke='#b00' stroke-dasharray='2 3' d='M%.1f 0V160'/><text "
                "x=%.1f y=155 font-size=11>%.2f</text>",
                x, x + 3, r->line[k].hz);
    }
    fprintf(f,
            "</svg><figcaption>0 to %.4g Hz, 60 dB, over the regions' own means"
            "</figcaption></figure>\n",
            s->hz_bin * (s->bins - 1));
}

static void modes(FILE *f, const plft_series_report *r)
{
    int k;

    fprintf(f,
            "<h2>Modes</h2><table><tr><th>looked for, Hz<th>frequency, Hz<th>damping, "
            "%%<th>rms, %s<th>region<th>record, s<th>flags</tr>\n",
            r->axis == 2 ? r->motion->w_unit : r->motion->uv_unit);
    for (k = 0; k < r->modes; k++) {
        const plft_mode_line *l = &r->line[k];
        if (!(l->mode.flags & PLFX_MODE_VALID)) {
            fprintf(f, "<tr><td>%.4g<td colspan=6>not found</tr>\n", l->hz);
            continue;
        }
        fprintf(f,
                "<tr><td>%.4g<td>%.4f &plusmn; %.4f<td>%.3f &plusmn; %.3f<td>%.4g<td>%d"
                "<td>%.1f<td class=bad>%s%s%s</tr>\n",
                l->hz, l->mode.freq_uhz / 1e6, l->mode.freq_sigma_uhz / 1e6,
                l->mode.damp_ppm / 1e4, l->mode.damp_sigma_ppm / 1e4, l->rms, l->region,
                l->mode.record_ms / 1e3,
                l->mode.flags & PLFX_MODE_SHORT ? "short " : "",
                l->mode.flags & PLFX_MODE_GAP ? "gap " : "",
                l->mode.flags & PLFX_MODE_ALARM ? "ALARM" : "");
    }
    fprintf(f, "</table>\n");
}

int plft_series_report_write(const char *path, const plft_series_report *r)
{
    plft_out out = {NULL, NULL, NULL};
    int rc = plft_out_open(&out, path);
    int k;

    if (rc != 0) {
        return rc;
    }
    fputs(head, out.file);
    fprintf(out.file,
            "<p>%d frames at %.4g Hz, %d regions, table %s. Frames lost: %u, late: %u. "
            "Measurements flagged: %u of %d.</p>\n",
            r->motion->rows, r->motion->rate, r->motion->regions, r->table, r->lost,
            r->late, r->flagged, r->motion->rows * r->motion->regions);
    if (r->modes > 0) {
        modes(out.file, r);
    }
    spectrum(out.file, r);
    fprintf(out.file,
            "<h2>Series</h2><p>%.4g s from left to right; a gap is where "
            "nothing valid was measured.</p>\n",
            r->motion->rows / r->motion->rate);
    for (k = 0; k < r->motion->regions; k++) {
        region(out.file, r, k);
    }
    return plft_out_commit(&out);
}
