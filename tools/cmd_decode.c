/* SPDX-License-Identifier: MIT
 * decode: space packets of monitor, as tables. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/out.h"
#include "plenofix/packet.h"

typedef struct job {
    const char *in, *out, *modes;
    plft_out csv, list;
    long packets, damaged, lost;
    int seen;
    uint16_t seq;
    uint32_t table;
    plfx_packet_health health;
} job;

static void regions(job *j, const plfx_packet *p)
{
    static plfx_packet_region rec[PLFX_PACKET_REGIONS_MAX];
    plfx_packet_regions info;
    int k;

    if (plfx_packet_get_regions(p, &info, rec, PLFX_PACKET_REGIONS_MAX) != PLFX_OK) {
        return;
    }
    for (k = 0; k < info.n; k++) {
        fprintf(j->csv.file, "%.6f,%d,%.7g,%.7g,", (double)p->head.time_ns / 1e9,
                info.first + k, ldexp(rec[k].u, -info.uv_shift),
                ldexp(rec[k].v, -info.uv_shift));
        if (rec[k].w != -32768) {
            fprintf(j->csv.file, "%.7g", ldexp(rec[k].w, -info.w_shift));
        }
        fprintf(j->csv.file, ",%.4g,%u\n",
                plfx_packet_sigma_q24(rec[k].sigma) / 16777216.0, rec[k].flags);
    }
}

static void modes(job *j, const plfx_packet *p)
{
    static plfx_packet_mode rec[PLFX_PACKET_MODES_MAX];
    int32_t n = 0;
    int k;

    if (!j->list.file ||
        plfx_packet_get_modes(p, rec, PLFX_PACKET_MODES_MAX, &n) != PLFX_OK) {
        return;
    }
    for (k = 0; k < n; k++) {
        fprintf(j->list.file, "%.6f,%d,%d,%.6f,%.6f,%.6f,%.6f,%.5g,%.3g,%.3f,%u\n",
                (double)p->head.time_ns / 1e9, rec[k].mode, rec[k].channel,
                rec[k].freq_uhz / 1e6, rec[k].freq_sigma_uhz / 1e6,
                rec[k].damp_ppm / 1e6, rec[k].damp_sigma_ppm / 1e6, rec[k].amp / 256.0,
                rec[k].amp_sigma / 256.0, rec[k].record_ms / 1e3, rec[k].flags);
    }
}

static void take(job *j, const plfx_packet *p)
{
    if (j->seen) {
        j->lost += (long)((p->head.seq - j->seq - 1u) & PLFX_PACKET_SEQ_MASK);
    }
    j->seen = 1;
    j->seq = p->head.seq;
    j->table = p->head.table;
    j->packets++;
    if (p->head.kind == PLFX_PACKET_REGIONS) {
        regions(j, p);
    } else if (p->head.kind == PLFX_PACKET_MODES) {
        modes(j, p);
    } else {
        plfx_packet_health h;
        if (plfx_packet_get_health(p, &h) == PLFX_OK) {
            j->health = h;
        }
    }
}

/* Every packet; after damage the next byte at which one opens. */
static void walk(job *j, const unsigned char *bytes, size_t n)
{
    size_t at = 0;
    int bad = 0;

    while (at < n) {
        plfx_packet p;
        if (plfx_packet_open(bytes + at, n - at, &p) == PLFX_OK) {
            take(j, &p);
            at += p.whole;
            bad = 0;
        } else {
            j->damaged += !bad;
            bad = 1;
            at++;
        }
    }
}

static int run(job *j)
{
    unsigned char *bytes = NULL;
    size_t n = 0;
    int rc = plft_in_bytes(j->in, &bytes, &n);

    rc = rc ? rc : plft_out_open(&j->csv, j->out);
    rc = rc || !j->modes ? rc : plft_out_open(&j->list, j->modes);
    if (rc == 0) {
        fprintf(j->csv.file,
                "time_s,region,u_pitch,v_pitch,w_slope,w_sigma_slope,flags\n");
        if (j->list.file) {
            fprintf(j->list.file, "time_s,mode,region,freq_hz,freq_sigma_hz,damping,"
                                  "damping_sigma,rms_steps,rms_sigma_steps,record_s,"
                                  "flags\n");
        }
        walk(j, bytes, n);
    }
    free(bytes);
    if (rc == 0 && j->packets == 0) {
        rc = plft_fail(PLFT_DATA, "%s: no packet in it", j->in);
    }
    rc = rc ? rc : plft_out_commit(&j->csv);
    rc = rc || !j->modes ? rc : plft_out_commit(&j->list);
    plft_out_abort(&j->csv);
    plft_out_abort(&j->list);
    if (rc == 0) {
        printf("%ld packets, %ld lost, %ld damaged places, table %08x\n", j->packets,
               j->lost, j->damaged, (unsigned)j->table);
        printf("last health: %u frames, %u lost, %u late, %u flagged, %u of %u regions "
               "valid, %u alarms\n",
               (unsigned)j->health.frames, (unsigned)j->health.lost,
               (unsigned)j->health.late, (unsigned)j->health.rejected, j->health.valid,
               j->health.regions, j->health.alarms);
    }
    return rc;
}

int plft_cmd_decode(int argc, char **argv)
{
    static const plft_usage usage = {
        "decode", "P.bin -o SERIES.csv [--modes M.csv]",
        "Space packets of monitor back to tables; damage is "
        "skipped and counted."};
    job j;
    const char *operand[1] = {NULL};
    int n = 0;
    int helped = 0;
    int rc;
    const plft_option options[] = {
        {"-o", PLFT_TEXT, &j.out, "SERIES.csv", 0, 0, "displacements"},
        {"--modes", PLFT_TEXT, &j.modes, "M.csv", 0, 0, "modes"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};

    memset(&j, 0, sizeof j);
    rc = plft_args(argc, argv, &usage, options, operand, 1, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    j.in = operand[0];
    if (!j.in || !j.out) {
        return plft_fail(PLFT_USAGE, "want %s",
                         j.in ? "-o SERIES.csv" : "a packet file");
    }
    rc = plft_out_check(j.out);
    rc = rc ? rc : plft_out_check(j.modes);
    return rc ? rc : run(&j);
}
