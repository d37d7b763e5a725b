/* SPDX-License-Identifier: MIT
 * What flies: frames in, telemetry out, in static memory, by the core alone.
 * One file for the workstation (stdio) and for a bare Cortex-M7 (semihosting).
 *
 * usage: onboard TABLE.plut REGIONS.bin FRAMES.raw PACKETS.bin
 * REGIONS.bin: int16 little-endian w, h, bits, rest, n, then i, j, hx, hy,
 * reference of each region.  FRAMES.raw: 16-bit little-endian pixels, frame
 * behind frame. */
#include <string.h>

#include "plenofix/packet.h"
#include "plenofix/roi.h"

#define PIXELS_MAX  (600u * 1024u)
#define WORK_MAX    (640u * 1024u)
#define TABLE_MAX   4096u
#define REGIONS_MAX 16
#define RATE        200u

#ifdef __arm__
#include "semihost/semihost.h"
#define file_open  plfx_semihost_open
#define file_read  plfx_semihost_read
#define file_write plfx_semihost_write
#define file_close plfx_semihost_close
#define say        plfx_semihost_print
#else
#include <stdio.h>
#include <stdlib.h>
static FILE *open_files[8];

static int32_t file_open(const char *path, int32_t write)
{
    static int32_t n;

    open_files[++n] = fopen(path, write ? "wb" : "rb");
    return open_files[n] ? n : -1;
}

static plfx_status file_read(int32_t f, void *data, uint32_t n)
{
    return fread(data, 1, n, open_files[f]) == n ? PLFX_OK : PLFX_E_IO;
}

static plfx_status file_write(int32_t f, const void *data, uint32_t n)
{
    return fwrite(data, 1, n, open_files[f]) == n ? PLFX_OK : PLFX_E_IO;
}

static void file_close(int32_t f)
{
    (void)fclose(open_files[f]);
}

static void say(const char *text)
{
    (void)fputs(text, stdout);
}
#endif

static uint16_t pixels[PIXELS_MAX];
static uint8_t work[WORK_MAX] __attribute__((aligned(PLFX_ALIGN)));
static uint8_t table[TABLE_MAX];
static uint8_t packet[PLFX_PACKET_MAX];
static plfx_lut lut;
static plfx_roi_cfg cfg;
static plfx_roi roi;
static plfx_roi_result result[REGIONS_MAX];
static plfx_raw raw;

static const char *start(const char *table_path, const char *regions_path)
{
    int16_t head[5];
    uint32_t n = 0;
    int32_t k;
    int32_t f = file_open(table_path, 0);

    while (f > 0 && n < TABLE_MAX && file_read(f, table + n, 1) == PLFX_OK) {
        n++;
    }
    if (n == 0 || plfx_lut_open(&lut, table, n) != PLFX_OK) {
        return "no table";
    }
    f = file_open(regions_path, 0);
    if (f < 0 || file_read(f, head, sizeof head) != PLFX_OK || head[4] < 1 ||
        head[4] > REGIONS_MAX || (uint32_t)(head[0] * head[1]) > PIXELS_MAX) {
        return "no regions, or frames too large";
    }
    cfg.lut = &lut;
    cfg.tone = plfx_tone_unity(12);
    cfg.views = 25;
    for (k = 1; k <= 6; k++) {
        cfg.at[4 * k - 3].u_q8 = (int16_t)(256 * k);
        cfg.at[4 * k - 2].u_q8 = (int16_t)(-256 * k);
        cfg.at[4 * k - 1].v_q8 = (int16_t)(256 * k);
        cfg.at[4 * k].v_q8 = (int16_t)(-256 * k);
    }
    cfg.regions = head[4];
    for (k = 0; k < cfg.regions; k++) {
        int16_t r[5];
        if (file_read(f, r, sizeof r) != PLFX_OK) {
            return "regions cut short";
        }
        cfg.region[k].i = r[0];
        cfg.region[k].j = r[1];
        cfg.region[k].hx = (uint8_t)r[2];
        cfg.region[k].hy = (uint8_t)r[3];
        cfg.region[k].reference = (uint8_t)r[4];
    }
    cfg.rest = head[3];
    cfg.steps = 2;
    cfg.residual_q8 = 640;
    raw.bytes = (const uint8_t *)pixels;
    raw.size = 2u * (size_t)head[0] * (size_t)head[1];
    raw.format = PLFX_RAW_U16;
    raw.bits = (uint8_t)head[2];
    raw.w = head[0];
    raw.h = head[1];
    return plfx_roi_init(&roi, &cfg, work, sizeof work) == PLFX_OK ? NULL : "no memory";
}

/* q24 to an int16 step of 2^-shift. */
static int16_t packed(int32_t q24, int32_t shift)
{
    int64_t one = (int64_t)1 << (24 - shift);
    int64_t v = ((int64_t)q24 + (q24 < 0 ? -one / 2 : one / 2)) / one;

    return (int16_t)(q24 == PLFX_ROI_NONE ? -32768
                     : v > 32767          ? 32767
                     : v < -32767         ? -32767
                                          : v);
}

/* u and v in 2^-14 lens, w in 2^-18 of slope. */
static plfx_status send(int32_t out, uint32_t n)
{
    plfx_packet_region rec[REGIONS_MAX];
    plfx_packet_regions info;
    plfx_status status;
    size_t len;
    int32_t k;

    memset(&info, 0, sizeof info);
    info.head.time_ns = (uint64_t)n * (1000000000u / RATE);
    info.head.table = lut.crc;
    info.head.apid = 100;
    info.head.seq = (uint16_t)(n & PLFX_PACKET_SEQ_MASK);
    info.n = (uint8_t)cfg.regions;
    info.uv_shift = 14;
    info.w_shift = 18;
    for (k = 0; k < cfg.regions; k++) {
        rec[k].u = packed(result[k].u_q24, 14);
        rec[k].v = packed(result[k].v_q24, 14);
        rec[k].w = packed(result[k].w_q24, 18);
        rec[k].sigma = plfx_packet_sigma(result[k].w_sigma_q24);
        rec[k].flags = result[k].flags;
    }
    status = plfx_packet_put_regions(&info, rec, packet, sizeof packet, &len);
    return status == PLFX_OK ? file_write(out, packet, (uint32_t)len) : status;
}

static const char *fly(const char *frames_path, const char *packets_path)
{
    int32_t in = file_open(frames_path, 0);
    int32_t out = file_open(packets_path, 1);
    plfx_roi_frame frame = {&raw, NULL};
    plfx_roi_shake shake;
    uint32_t n = 0;

    if (in < 0 || out < 0) {
        return "no frames, or no place for packets";
    }
    while (file_read(in, pixels, (uint32_t)raw.size) == PLFX_OK) {
        if (roi.rested < cfg.rest) {
            if (plfx_roi_rest(&roi, &frame) != PLFX_OK) {
                return "the core refused a frame";
            }
            continue;
        }
        if (plfx_roi_measure(&roi, &frame, result) != PLFX_OK ||
            plfx_roi_shake_fit(&roi, result, &shake) != PLFX_OK) {
            return "the core refused a frame";
        }
        plfx_roi_steady(&roi, &shake, result);
        if (send(out, n++) != PLFX_OK) {
            return "the packets cannot be written";
        }
    }
    file_close(out);
    return n > 0 ? NULL : "no frame behind the rest state";
}

static int run(const char *const path[4])
{
    const char *why = start(path[0], path[1]);

    why = why ? why : fly(path[2], path[3]);
    say(why ? "onboard: " : "onboard: packets written");
    say(why ? why : "");
    say("\n");
    return why != NULL;
}

#ifdef __arm__
int main(void)
{
    static char line[256];
    const char *path[4] = {NULL, NULL, NULL, NULL};
    char *at = line;
    int k = 0;

    if (plfx_semihost_arguments(line, sizeof line) != PLFX_OK) {
        plfx_semihost_exit(1);
    }
    while (*at != 0 && k < 4) {
        while (*at == ' ') {
            *at++ = 0;
        }
        path[k++] = at;
        while (*at != ' ' && *at != 0) {
            at++;
        }
    }
    *at = 0;
    plfx_semihost_exit(k == 4 ? run(path) : 2);
    return 0;
}
#else
int main(int argc, char **argv)
{
    if (argc != 5) {
        say("usage: onboard TABLE.plut REGIONS.bin FRAMES.raw PACKETS.bin\n");
        return 2;
    }
    return run((const char *const *)(argv + 1));
}
#endif
