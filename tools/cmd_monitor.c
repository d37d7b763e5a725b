/* SPDX-License-Identifier: MIT
 * monitor: frames in, displacement of regions and their modes out. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/folder.h"
#include "common/frame.h"
#include "common/memory.h"
#include "common/out.h"
#include "common/progress.h"
#include "common/table.h"
#include "motion/find.h"
#include "motion/hdf5_out.h"
#include "motion/regions.h"
#include "motion/report.h"
#include "motion/thin.h"
#include "motion/uff.h"
#include "plenofix/modal.h"
#include "plenofix/packet.h"
#include "plenofix/roi.h"

#define FRAMES_MAX 100000
#define MODES_MAX  8
#define NATS_Q8    2816 /* evidence of a watch at which to alarm */
#define OVER_LEAK  5.0  /* amplitude of a mode over what leaks of the others */
#define ONE        16777216.0

typedef struct request {
    const char *table, *regions, *out, *packets, *uff, *modes, *hdf5, *report;
    double rate, mm_lens, mm_slope, radius, limit;
    int bits, rest, views, axis, seek, no_steady, link, white;
} request;

typedef struct job {
    request r;
    char **name; /* frames, in order */
    int frames;
    plft_table table;
    plfx_roi_cfg cfg;
    plfx_roi roi;
    void *ws;
    plfx_roi_result out[PLFX_ROI_MAX];
    double freq[MODES_MAX], zeta[MODES_MAX];
    double place[PLFX_ROI_MAX][3]; /* of the regions on the object, mm */
    int placed;
    int modes;
    int find;                /* modes from the spectrum of the whole series */
    plfx_modal *modal;       /* [region][mode] */
    plfx_modal_watch *watch; /* the same; limit 0: none */
    double *series, *sigma;  /* [frame][region][3], NaN where not valid */
    unsigned char *flags;    /* [frame][region] */
    double *time;            /* [frame], s */
    long *lost;              /* [frame] before it */
    plft_spectrum spectrum;
    plft_out csv, packets;
    plfx_packet_rate fit;
    uint16_t seq;
    plfx_packet_health health;
    long first, last; /* numbers of the frames, last: of the newest */
} job;

/* The last run of digits of the stem; -1 without. */
static long number_of(const char *path)
{
    const char *base = strrchr(path, '/');
    const char *p;
    long v = -1;

    base = base ? base + 1 : path;
    for (p = base; *p && *p != '.'; p++) {
        if (*p >= '0' && *p <= '9') {
            char *end;
            v = strtol(p, &end, 10);
            p = end - 1;
        }
    }
    return v;
}

/* Frames are named one by one, or by their folder. */
static int name_frames(job *j, const char **operands, int n)
{
    plft_names names;
    int k;
    int rc;

    if (n > 1 || strstr(operands[0], ".png") || strstr(operands[0], ".tif")) {
        j->name = plft_alloc((size_t)n, sizeof *j->name);
        for (k = 0; j->name && k < n; k++) {
            j->name[k] = plft_strdup(operands[k]);
        }
        j->frames = n;
        return j->name ? 0 : PLFT_DATA;
    }
    rc = plft_folder_numbered(&names, operands[0], NULL);
    if (rc == 0) {
        j->frames = names.n;
        j->name = plft_alloc((size_t)names.n, sizeof *j->name);
        for (k = 0; j->name && k < names.n; k++) {
            j->name[k] = plft_join(operands[0], names.name[k]);
        }
        plft_names_free(&names);
        rc = j->name ? 0 : PLFT_DATA;
    }
    return rc;
}

/* "6.2:0.015,22:0.012": frequency in Hz and expected damping; or "auto". */
static int parse_modes(job *j)
{
    const char *p = j->r.modes;
    char *end;

    if (p && strcmp(p, "auto") == 0) {
        j->find = 1;
        return 0;
    }
    while (p && *p) {
        if (j->modes == MODES_MAX) {
            return plft_fail(PLFT_USAGE, "--modes: at most %d", MODES_MAX);
        }
        j->freq[j->modes] = strtod(p, &end);
        j->zeta[j->modes] = 0.01;
        if (end != p && *end == ':') {
            p = end + 1;
            j->zeta[j->modes] = strtod(p, &end);
        }
        if (end == p || (*end != '\0' && *end != ',') || !(j->freq[j->modes] > 0) ||
            !(j->freq[j->modes] < j->r.rate / 2) || !(j->zeta[j->modes] > 0) ||
            !(j->zeta[j->modes] < 1)) {
            return plft_fail(PLFT_USAGE,
                             "--modes %s: want auto, or HZ[:DAMPING],... under half of "
                             "--rate",
                             j->r.modes);
        }
        j->modes++;
        p = *end == ',' ? end + 1 : end;
    }
    return 0;
}

static int start_modes(job *j)
{
    int n = j->cfg.regions * j->modes;
    int k;

    free(j->modal);
    free(j->watch);
    j->modal = plft_alloc((size_t)(n > 0 ? n : 1), sizeof *j->modal);
    j->watch = plft_alloc((size_t)(n > 0 ? n : 1), sizeof *j->watch);
    for (k = 0; j->modal && j->watch && k < n; k++) {
        plfx_modal_cfg c = {(uint32_t)lround(j->r.rate * 1000), 0, 1, 8, 8};
        int m = k % j->modes;
        c.freq_uhz = (uint32_t)lround(j->freq[m] * 1e6);
        c.every = plft_thin_every(j->r.rate, j->freq, j->modes, m, j->zeta[m]);
        /* A short record keeps 40 thinned samples. */
        c.every = j->frames < 40 * c.every ? (j->frames + 39) / 40 : c.every;
        c.block = (int32_t)(60.0 * j->r.rate / c.every / PLFX_MODAL_BLOCKS);
        c.block = c.block < 8 ? 8 : c.block;
        if (plfx_modal_init(&j->modal[k], &c) != PLFX_OK) {
            return plft_fail(PLFT_USAGE, "--modes %g: want 1 to 8000 frames a second",
                             j->freq[m]);
        }
        /* Watched where its expected damping is the healthy one over a limit. */
        if (plfx_modal_watch_init(
                &j->watch[k], &j->modal[k], (int32_t)lround(j->r.limit * 1e6),
                (int32_t)lround(j->zeta[m] * 1e6), NATS_Q8) != PLFX_OK) {
            memset(&j->watch[k], 0, sizeof j->watch[k]);
        }
    }
    return j->modal && j->watch ? 0 : PLFT_DATA;
}

/* The centre and a cross of views out to the radius, evenly. */
static void cross_of_views(plfx_roi_cfg *c, int views, double radius)
{
    int arm = (views - 1) / 4;
    int k;

    c->views = 4 * arm + 1;
    for (k = 1; k <= arm; k++) {
        int16_t d = (int16_t)lround(256.0 * radius * k / arm);
        c->at[4 * k - 3].u_q8 = d;
        c->at[4 * k - 2].u_q8 = (int16_t)-d;
        c->at[4 * k - 1].v_q8 = d;
        c->at[4 * k].v_q8 = (int16_t)-d;
    }
}

static int configure(job *j)
{
    double radius = j->r.radius;
    plfx_status status;
    size_t size;
    int rc = plft_table_read(&j->table, j->r.table);

    rc = rc ? rc : plft_regions_read(&j->cfg, j->r.regions);
    rc = rc ? rc : plft_regions_places(j->r.regions, j->place, &j->placed);
    if (rc != 0) {
        return rc;
    }
    j->cfg.lut = &j->table.lut;
    j->cfg.tone = plfx_tone_unity(12);
    j->cfg.white = j->r.white;
    j->cfg.rest = j->r.rest;
    j->cfg.steps = 2;
    j->cfg.seek = j->r.seek;
    j->cfg.residual_q8 = 640;
    radius = radius > 0 ? radius : j->table.lut.radius_q8 / 256.0 - 0.5;
    cross_of_views(&j->cfg, j->r.views, radius > 1 ? radius : 1);
    size = plfx_roi_ws(&j->cfg);
    j->ws = plft_alloc_ws(size ? size : 1);
    status = j->ws ? plfx_roi_init(&j->roi, &j->cfg, j->ws, size) : PLFX_E_SIZE;
    if (status == PLFX_E_RANGE) {
        return plft_fail(PLFT_DATA, "%s: regions want a square lattice", j->r.table);
    }
    if (status != PLFX_OK) {
        return plft_fail(PLFT_DATA, "%s: regions or views out of range", j->r.regions);
    }
    return start_modes(j);
}

static int read_frame(const job *j, int k, plft_frame *f)
{
    int rc = plft_frame_read(f, j->name[k], j->r.bits);

    if (rc == 0) {
        plft_frame_to_grey(f);
        if (f->w != j->table.lut.sensor_w || f->h != j->table.lut.sensor_h) {
            rc = plft_fail(PLFT_DATA, "%s is %dx%d but %s is for %dx%d", j->name[k],
                           f->w, f->h, j->r.table, j->table.lut.sensor_w,
                           j->table.lut.sensor_h);
            plft_frame_free(f);
        }
    }
    return rc;
}

/* Scale of a component in the outputs: millimetres when their size was given. */
static double scale(const job *j, int axis)
{
    double mm = axis == 2 ? j->r.mm_slope : j->r.mm_lens;

    return (mm != 0 ? mm : 1.0) / ONE;
}

static void csv_head(job *j)
{
    const char *uv = j->r.mm_lens > 0 ? "mm" : "pitch";
    const char *w = j->r.mm_slope != 0 ? "mm" : "slope";

    fprintf(j->csv.file,
            "frame,time_s,region,u_%s,v_%s,w_%s,u_sigma_%s,v_sigma_%s,w_sigma_%s,"
            "light_ratio,residual_ratio,flags%s\n",
            uv, uv, w, uv, uv, w, j->placed ? ",x_mm,y_mm,z_mm" : "");
}

static void csv_number(FILE *f, int32_t v, double s)
{
    if (v == PLFX_ROI_NONE) {
        fputs(",", f);
    } else {
        fprintf(f, ",%.7g", v * s);
    }
}

static void csv_rows(job *j, long number, double time)
{
    FILE *f = j->csv.file;
    int k;

    for (k = 0; k < j->cfg.regions; k++) {
        const plfx_roi_result *o = &j->out[k];
        fprintf(f, "%ld,%.6f,%d", number, time, k);
        csv_number(f, o->u_q24, scale(j, 0));
        csv_number(f, o->v_q24, scale(j, 1));
        csv_number(f, o->w_q24, scale(j, 2));
        fprintf(f, ",%.5g,%.5g,%.5g,%.4f,%.3f,%u", o->u_sigma_q24 * scale(j, 0),
                o->v_sigma_q24 * scale(j, 1), o->w_sigma_q24 * fabs(scale(j, 2)),
                o->light_q12 / 4096.0, o->residual_q8 / 256.0, o->flags);
        if (j->placed) {
            fprintf(f, ",%.9g,%.9g,%.9g", j->place[k][0], j->place[k][1],
                    j->place[k][2]);
        }
        fputc('\n', f);
    }
}

static int32_t axis_of(const plfx_roi_result *o, int axis)
{
    return axis == 0 ? o->u_q24 : axis == 1 ? o->v_q24 : o->w_q24;
}

static void feed(plfx_modal *t, plfx_modal_watch *w, double steps)
{
    double s = floor(steps + 0.5);

    s = s > 32767 ? 32767 : s < -32768 ? -32768 : s;
    if (plfx_modal_push(t, (int16_t)s) && w->limit_q20 > 0) {
        (void)plfx_modal_watch_add(w, t);
    }
}

/* Row `row` of the series into the trackers.  A sample is 2^-14 lens in the plane,
 * 2^-20 of slope. */
static void feed_modes(job *j, int row)
{
    double step = scale(j, j->r.axis) * ldexp(1, j->r.axis == 2 ? 4 : 10);
    int k;
    int m;

    for (k = 0; k < j->cfg.regions; k++) {
        double v = j->series[((size_t)row * (size_t)j->cfg.regions + (size_t)k) * 3 +
                             (size_t)j->r.axis];
        for (m = 0; m < j->modes; m++) {
            plfx_modal *t = &j->modal[k * j->modes + m];
            plfx_modal_gap(t, (uint32_t)j->lost[row]);
            if (isfinite(v)) {
                feed(t, &j->watch[k * j->modes + m], v / step);
            } else {
                plfx_modal_gap(t, 1);
            }
        }
    }
}

static uint32_t sigma_of(const plfx_roi_result *o, int axis)
{
    return axis == 0 ? o->u_sigma_q24 : axis == 1 ? o->v_sigma_q24 : o->w_sigma_q24;
}

static void keep_row(job *j, int row, double time, long lost)
{
    int k;
    int a;

    j->time[row] = time;
    j->lost[row] = lost;
    for (k = 0; k < j->cfg.regions; k++) {
        size_t at = (size_t)row * (size_t)j->cfg.regions + (size_t)k;
        j->flags[at] = j->out[k].flags;
        for (a = 0; a < 3; a++) {
            int32_t v = axis_of(&j->out[k], a);
            int bad = j->out[k].flags || v == PLFX_ROI_NONE;
            j->series[at * 3 + (size_t)a] = bad ? NAN : v * scale(j, a);
            j->sigma[at * 3 + (size_t)a] =
                bad ? NAN : sigma_of(&j->out[k], a) * fabs(scale(j, a));
        }
    }
}

static int16_t packed(int32_t q24, int shift)
{
    double v = floor(ldexp(q24, shift - 24) + 0.5);

    return (int16_t)(q24 == PLFX_ROI_NONE ? -32768
                     : v > 32767          ? 32767
                     : v < -32767         ? -32767
                                          : v);
}

static plfx_packet_head head(job *j, double time)
{
    plfx_packet_head h;

    memset(&h, 0, sizeof h);
    h.time_ns = (uint64_t)llround(time * 1e9);
    h.table = j->table.lut.crc;
    h.apid = 100;
    h.seq = j->seq;
    j->seq = plfx_packet_next(j->seq);
    return h;
}

static void send(job *j, const uint8_t *buf, size_t len)
{
    (void)fwrite(buf, 1, len, j->packets.file);
}

static void send_regions(job *j, double time)
{
    uint8_t buf[PLFX_PACKET_MAX];
    plfx_packet_region rec[PLFX_ROI_MAX];
    plfx_packet_regions info;
    size_t len;
    int k;

    memset(&info, 0, sizeof info);
    info.head = head(j, time);
    info.n = (uint8_t)j->fit.count;
    info.uv_shift = 12; /* +-8 lenses */
    info.w_shift = 18;  /* +-1/8 of slope */
    for (k = 0; k < j->fit.count; k++) {
        const plfx_roi_result *o = &j->out[k];
        rec[k].u = packed(o->u_q24, info.uv_shift);
        rec[k].v = packed(o->v_q24, info.uv_shift);
        rec[k].w = packed(o->w_q24, info.w_shift);
        rec[k].sigma =
            plfx_packet_sigma(o->w_sigma_q24 ? o->w_sigma_q24 : o->u_sigma_q24);
        rec[k].flags = o->flags;
    }
    if (plfx_packet_put_regions(&info, rec, buf, sizeof buf, &len) == PLFX_OK) {
        send(j, buf, len);
    }
}

static plfx_packet_mode packed_mode(const plfx_mode *m, int region, int mode)
{
    plfx_packet_mode p;

    memset(&p, 0, sizeof p);
    p.mode = (uint8_t)mode;
    p.channel = (uint8_t)region;
    p.flags = (uint8_t)m->flags;
    p.freq_uhz = m->freq_uhz;
    p.freq_sigma_uhz = m->freq_sigma_uhz;
    p.damp_ppm = m->damp_ppm;
    p.damp_sigma_ppm = m->damp_sigma_ppm;
    p.amp = m->amp_q8;
    p.amp_sigma = m->amp_sigma_q8;
    p.record_ms = m->record_ms;
    return p;
}

/* Amplitude of the other modes of the region that reaches this one's channel. */
static double leaked(const job *j, int region, int mode)
{
    int every = j->modal[region * j->modes + mode].cfg.every;
    double to = j->freq[mode];
    double sum = 0.0;
    int m;

    for (m = 0; m < j->modes; m++) {
        plfx_mode other;
        if (plft_thin_apart(j->r.rate, every, j->freq[m], to) &&
            plfx_modal_read(&j->modal[region * j->modes + m], PLFX_MODAL_BLOCKS,
                            &other) == PLFX_OK) {
            sum += other.amp_q8 * plft_thin_leak(j->r.rate, every, j->freq[m], to);
        }
    }
    return sum;
}

/* Region in which the mode is strongest; LOST where all of it can be others' leaks. */
static int strongest(const job *j, int mode, plfx_mode *best)
{
    int at = 0;
    int k;

    memset(best, 0, sizeof *best);
    for (k = 0; k < j->cfg.regions; k++) {
        plfx_mode m;
        if (plfx_modal_alarm(&j->modal[k * j->modes + mode],
                             (int32_t)lround(j->r.limit * 1e6), 384, &m) != PLFX_OK ||
            !(m.flags & PLFX_MODE_VALID) || m.amp_q8 <= best->amp_q8) {
            continue;
        }
        if (m.amp_q8 < OVER_LEAK * leaked(j, k, mode)) {
            best->flags |= best->flags & PLFX_MODE_VALID ? 0u : PLFX_MODE_LOST;
        } else {
            const plfx_modal_watch *w = &j->watch[k * j->modes + mode];
            *best = m;
            at = k;
            if (w->limit_q20 > 0 && w->evidence_q20 > w->limit_q20) {
                best->flags |= PLFX_MODE_ALARM;
            }
        }
    }
    return at;
}

static void send_slow(job *j, double time)
{
    uint8_t buf[PLFX_PACKET_MAX];
    plfx_packet_mode rec[MODES_MAX];
    plfx_packet_head h;
    size_t len;
    int m;

    j->health.alarms = 0;
    for (m = 0; m < j->modes; m++) {
        plfx_mode best;
        int at = strongest(j, m, &best);
        rec[m] = packed_mode(&best, at, m);
        j->health.alarms =
            (uint16_t)(j->health.alarms + ((best.flags & PLFX_MODE_ALARM) != 0));
    }
    if (j->modes > 0) {
        h = head(j, time);
        if (plfx_packet_put_modes(&h, rec, j->modes, buf, sizeof buf, &len) ==
            PLFX_OK) {
            send(j, buf, len);
        }
    }
    h = head(j, time);
    if (plfx_packet_put_health(&h, &j->health, buf, sizeof buf, &len) == PLFX_OK) {
        send(j, buf, len);
    }
}

static void take_health(job *j, const plfx_roi_shake *shake, long lost)
{
    double light = 0;
    int k;

    j->health.frames++;
    j->health.lost += (uint32_t)lost;
    j->health.regions = (uint16_t)j->cfg.regions;
    j->health.valid = 0;
    for (k = 0; k < j->cfg.regions; k++) {
        j->health.valid = (uint16_t)(j->health.valid + (j->out[k].flags == 0));
        j->health.rejected += j->out[k].flags != 0;
        light += j->out[k].light_q12;
    }
    j->health.light_q12 = (uint16_t)lround(light / j->cfg.regions);
    j->health.shake_q24[0] = shake->u_q24;
    j->health.shake_q24[1] = shake->v_q24;
    j->health.shake_q24[2] = shake->w_q24;
}

/* One frame after the rest state; row counts them. */
static int measure(job *j, const plfx_roi_frame *f, long number, int row)
{
    double time = (double)(number - j->first) / j->r.rate;
    long lost = row > 0 ? number - j->last - 1 : 0;
    plfx_roi_shake shake;

    memset(&shake, 0, sizeof shake);
    if (plfx_roi_measure(&j->roi, f, j->out) != PLFX_OK) {
        return plft_fail(PLFT_DATA, "frame %ld: could not be measured", number);
    }
    if (!j->r.no_steady && plfx_roi_shake_fit(&j->roi, j->out, &shake) == PLFX_OK) {
        plfx_roi_steady(&j->roi, &shake, j->out);
    }
    csv_rows(j, number, time);
    keep_row(j, row, time, lost);
    feed_modes(j, row);
    take_health(j, &shake, lost);
    if (j->packets.file) {
        if (row % j->fit.every == 0) {
            send_regions(j, time);
        }
        if ((row + 1) % (int)ceil(j->r.rate) == 0) {
            send_slow(j, time);
        }
    }
    j->last = number;
    return 0;
}

static int one_frame(job *j, int k, int *row)
{
    plft_frame f;
    plfx_raw raw;
    plfx_roi_frame frame = {&raw, NULL};
    long number = number_of(j->name[k]);
    int rc = read_frame(j, k, &f);

    if (rc != 0) {
        return rc;
    }
    number = number < 0 ? k : number;
    memset(&raw, 0, sizeof raw);
    raw.bytes = (const uint8_t *)f.px;
    raw.size = (size_t)f.w * (size_t)f.h * 2u;
    raw.format = PLFX_RAW_U16;
    raw.bits = (uint8_t)f.bits;
    raw.w = f.w;
    raw.h = f.h;
    if (j->roi.rested < j->cfg.rest) {
        rc = plfx_roi_rest(&j->roi, &frame) == PLFX_OK
                 ? 0
                 : plft_fail(PLFT_DATA, "%s: could not be sampled", j->name[k]);
        j->first = number + 1;
    } else if (*row > 0 && number <= j->last) {
        plft_warn("%s: goes back in time; left out", j->name[k]);
        j->health.late++;
    } else {
        rc = measure(j, &frame, number, *row);
        (*row)++;
    }
    plft_frame_free(&f);
    return rc;
}

static void print_modes(job *j)
{
    double unit = fabs(scale(j, j->r.axis)) * ldexp(1, j->r.axis == 2 ? 4 : 10);
    int m;

    for (m = 0; m < j->modes; m++) {
        plfx_mode best;
        int at = strongest(j, m, &best);
        if (!(best.flags & PLFX_MODE_VALID)) {
            printf("mode %g Hz: not found%s\n", j->freq[m],
                   best.flags & PLFX_MODE_LOST
                       ? ": what leaks of the other modes is as strong in every region"
                       : "");
            continue;
        }
        printf(
            "mode %g Hz: %.4f +- %.4f Hz, damping %.3f +- %.3f %%, rms %.5g +- %.2g in "
            "region %d, record %.1f s%s%s%s\n",
            j->freq[m], best.freq_uhz / 1e6, best.freq_sigma_uhz / 1e6,
            best.damp_ppm / 1e4, best.damp_sigma_ppm / 1e4, best.amp_q8 / 256.0 * unit,
            best.amp_sigma_q8 / 256.0 * unit, at, best.record_ms / 1e3,
            best.flags & PLFX_MODE_SHORT ? ", short" : "",
            best.flags & PLFX_MODE_GAP ? ", with a gap" : "",
            best.flags & PLFX_MODE_ALARM ? ", ALARM" : "");
    }
}

static int allot(job *j)
{
    size_t n = (size_t)j->frames * (size_t)j->cfg.regions;

    j->series = plft_alloc(3u * n, sizeof *j->series);
    j->sigma = plft_alloc(3u * n, sizeof *j->sigma);
    j->flags = plft_alloc(n, 1);
    j->time = plft_alloc((size_t)j->frames, sizeof *j->time);
    j->lost = plft_alloc((size_t)j->frames, sizeof *j->lost);
    return j->series && j->sigma && j->flags && j->time && j->lost ? 0 : PLFT_DATA;
}

/* Modes found in the spectrum, tracked from the kept series. */
static int find_modes(job *j, int rows)
{
    int rc = 0;
    int row;
    int k;

    j->modes = plft_find_modes(&j->spectrum, j->freq, MODES_MAX);
    for (k = 0; k < j->modes; k++) {
        j->zeta[k] = 0.01;
    }
    rc = start_modes(j);
    for (row = 0; rc == 0 && row < rows; row++) {
        feed_modes(j, row);
    }
    if (rc == 0 && j->packets.file && rows > 0) {
        send_slow(j, j->time[rows - 1]);
    }
    return rc;
}

static void line_of(job *j, int mode, plft_mode_line *l)
{
    double step = scale(j, j->r.axis) * ldexp(1, j->r.axis == 2 ? 4 : 10);

    l->hz = j->freq[mode];
    l->region = strongest(j, mode, &l->mode);
    l->rms = l->mode.amp_q8 / 256.0 * fabs(step);
}

static int write_report(job *j, const plft_series *m)
{
    plft_mode_line line[MODES_MAX];
    plft_series_report r;
    int k;

    for (k = 0; k < j->modes; k++) {
        line_of(j, k, &line[k]);
    }
    r.motion = m;
    r.spectrum = &j->spectrum;
    r.line = line;
    r.modes = j->modes;
    r.axis = j->r.axis;
    r.lost = (unsigned)j->health.lost;
    r.late = (unsigned)j->health.late;
    r.flagged = (unsigned)j->health.rejected;
    r.table = j->r.table;
    return plft_series_report_write(j->r.report, &r);
}

/* What is written after the last frame. */
static int write_outputs(job *j, int rows)
{
    plft_series m;
    int rc = 0;

    memset(&m, 0, sizeof m);
    m.time = j->time;
    m.series = j->series;
    m.sigma = j->sigma;
    m.flags = j->flags;
    m.region = j->cfg.region;
    m.place = j->placed ? (const double(*)[3])j->place : NULL;
    m.rows = rows;
    m.regions = j->cfg.regions;
    m.rate = j->r.rate;
    m.uv_unit = j->r.mm_lens > 0 ? "mm" : "pitch";
    m.w_unit = j->r.mm_slope != 0 ? "mm" : "slope";
    if (j->find || j->r.report) {
        rc = plft_spectrum_of(&j->spectrum, j->series, rows, j->cfg.regions, j->r.axis,
                              j->r.rate);
    }
    rc = rc || !j->find ? rc : find_modes(j, rows);
    if (rc == 0 && j->r.uff) {
        rc = plft_uff_write(j->r.uff, j->series, rows, j->cfg.regions, 1.0 / j->r.rate,
                            j->r.mm_lens > 0 && j->r.mm_slope != 0 ? "mm" : "pitch",
                            m.place);
    }
    rc = rc || !j->r.hdf5 ? rc : plft_hdf5_write(j->r.hdf5, &m);
    return rc || !j->r.report ? rc : write_report(j, &m);
}

static int run(job *j)
{
    int row = 0;
    int rc = plft_out_open(&j->csv, j->r.out);
    int k;

    if (rc == 0 && j->r.packets) {
        rc = plft_out_open(&j->packets, j->r.packets);
    }
    rc = rc ? rc : allot(j);
    if (rc == 0) {
        csv_head(j);
    }
    for (k = 0; rc == 0 && k < j->frames; k++) {
        rc = one_frame(j, k, &row);
        plft_progress("frames", (double)(k + 1) / j->frames);
    }
    rc = rc ? rc : write_outputs(j, row);
    rc = rc ? rc : plft_out_commit(&j->csv);
    rc = rc || !j->r.packets ? rc : plft_out_commit(&j->packets);
    if (rc == 0) {
        printf("%d frames, %d regions, %u lost, %u late, %u measurements flagged, "
               "workspace %zu bytes\n",
               row, j->cfg.regions, (unsigned)j->health.lost, (unsigned)j->health.late,
               (unsigned)j->health.rejected, plfx_roi_ws(&j->cfg));
        print_modes(j);
    }
    return rc;
}

static int fit_link(job *j)
{
    plfx_status s;

    j->fit.every = 1;
    j->fit.count = j->cfg.regions;
    if (!j->r.packets || j->r.link == 0) {
        return 0;
    }
    s = plfx_packet_fit((uint32_t)j->r.link, (uint32_t)lround(j->r.rate * 1000),
                        j->cfg.regions, j->modes, &j->fit);
    return s == PLFX_OK
               ? 0
               : plft_fail(PLFT_USAGE, "--link %d: carries not one region", j->r.link);
}

static void finish(job *j)
{
    int k;

    plft_out_abort(&j->csv);
    plft_out_abort(&j->packets);
    for (k = 0; j->name && k < j->frames; k++) {
        free(j->name[k]);
    }
    free(j->name);
    free(j->ws);
    free(j->modal);
    free(j->watch);
    free(j->series);
    free(j->sigma);
    free(j->flags);
    free(j->time);
    free(j->lost);
    plft_table_free(&j->table);
    free(j);
}

static const plft_usage usage = {
    "monitor",
    "FRAME... | FOLDER --lut CAM.plut --regions R.csv -o SERIES.csv [options]",
    "Displacement of regions against the first frames, with standard errors and "
    "flags,\n"
    "and the modes in it.  Numbers in frame names are their times; gaps stay gaps."};

static int parse(int argc, char **argv, request *r, const char **operands, int *n,
                 int *helped)
{
    const plft_option options[] = {
        {"--lut", PLFT_TEXT, &r->table, "CAM.plut", 0, 0, "lens table"},
        {"--regions", PLFT_TEXT, &r->regions, "R.csv", 0, 0,
         "columns i,j,hx,hy[,reference], lenses, and [x_mm,y_mm,z_mm]"},
        {"-o", PLFT_TEXT, &r->out, "SERIES.csv", 0, 0, "the series"},
        {"--rate", PLFT_REAL, &r->rate, "HZ", 1, 8000, "frames a second (200)"},
        {"--rest", PLFT_INT, &r->rest, "N", 1, PLFX_ROI_REST_MAX,
         "frames of the rest state (8)"},
        {"--bits", PLFT_INT, &r->bits, "N", 8, 16, "significant bits of 16-bit files"},
        {"--views", PLFT_INT, &r->views, "N", 5, 97, "centre and cross of views (25)"},
        {"--radius", PLFT_REAL, &r->radius, "R", 1, 127, "of the cross, pixels"},
        {"--white", PLFT_FLAG, &r->white, NULL, 0, 0, "use the table's white gains"},
        {"--seek", PLFT_INT, &r->seek, "N", 0, PLFX_ROI_SEEK_MAX,
         "lenses around which a lost region is sought (0)"},
        {"--no-steady", PLFT_FLAG, &r->no_steady, NULL, 0, 0,
         "keep camera shake although there are reference regions"},
        {"--mm-per-lens", PLFT_REAL, &r->mm_lens, "X", 1e-6, 1e6, "u and v in mm"},
        {"--mm-per-slope", PLFT_REAL, &r->mm_slope, "X", -1e9, 1e9, "w in mm"},
        {"--modes", PLFT_TEXT, &r->modes, "HZ[:Z],...|auto", 0, 0,
         "track modes, each with its expected damping (0.01); auto: from the spectrum"},
        {"--axis", PLFT_WORD, &r->axis, "u|v|w", 0, 0, "of the modes (w)"},
        {"--limit", PLFT_REAL, &r->limit, "Z", 0, 1, "damping under which to alarm"},
        {"--packets", PLFT_TEXT, &r->packets, "P.bin", 0, 0, "CCSDS space packets"},
        {"--link", PLFT_INT, &r->link, "BITS", 0, 1e9, "bit/s that packets must fit"},
        {"--uff", PLFT_TEXT, &r->uff, "U.uff", 0, 0, "series as UFF dataset 58"},
        {"--hdf5", PLFT_TEXT, &r->hdf5, "S.h5", 0, 0, "series as HDF5"},
        {"--report", PLFT_TEXT, &r->report, "R.html", 0, 0, "one page for people"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};

    return plft_args(argc, argv, &usage, options, operands, FRAMES_MAX, n, helped);
}

static int check(const request *r, int n)
{
    int rc = n < 1         ? plft_fail(PLFT_USAGE, "want frames or their folder")
             : !r->table   ? plft_fail(PLFT_USAGE, "want --lut CAM.plut")
             : !r->regions ? plft_fail(PLFT_USAGE, "want --regions R.csv")
             : !r->out     ? plft_fail(PLFT_USAGE, "want -o SERIES.csv")
                           : 0;

    rc = rc ? rc : plft_out_check(r->out);
    rc = rc ? rc : plft_out_check(r->packets);
    rc = rc ? rc : plft_out_check(r->uff);
    rc = rc ? rc : plft_out_check(r->report);
    rc = rc ? rc : plft_out_check(r->hdf5);
    return rc || !r->hdf5 || plft_hdf5_built()
               ? rc
               : plft_fail(PLFT_USAGE, "--hdf5: this program was built without HDF5");
}

int plft_cmd_monitor(int argc, char **argv)
{
    job *j = plft_alloc(1, sizeof *j);
    const char **operands = plft_alloc(FRAMES_MAX, sizeof *operands);
    int n = 0;
    int helped = 0;
    int rc = PLFT_DATA;

    if (j && operands) {
        j->r.rate = 200;
        j->r.rest = 8;
        j->r.views = 25;
        j->r.axis = 2;
        rc = parse(argc, argv, &j->r, operands, &n, &helped);
        if (rc == 0 && !helped) {
            rc = check(&j->r, n);
            rc = rc ? rc : name_frames(j, operands, n);
            rc = rc ? rc : parse_modes(j);
            rc = rc ? rc : configure(j);
            rc = rc ? rc : fit_link(j);
            if (rc == 0 && j->frames <= j->cfg.rest) {
                rc = plft_fail(PLFT_DATA, "%d frames: want more than the %d of --rest",
                               j->frames, j->cfg.rest);
            }
            rc = rc ? rc : run(j);
        }
    }
    free(operands);
    if (j) {
        finish(j);
    }
    return rc;
}
