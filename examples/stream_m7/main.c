/* SPDX-License-Identifier: MIT
 * Depth on a bare Cortex-M7: a raw frame comes row by row, map rows go out as soon
 * as they are done, and no frame is ever in memory.  All memory is static and its
 * size is known when the program is linked.
 *
 * usage: stream_m7 FRAME.raw TABLE.plut MAP.raw FRAME.raw: 16-bit little-endian
 * pixels; MAP.raw: 32-bit slopes, 2^-16, row by row. */
#include "plenofix/plenofix.h"
#include "semihost/semihost.h"

#include <string.h>

#define TABLE_MAX (64u * 1024u)
#define WORK_MAX  (192u * 1024u)
#define ROW_MAX   4096 /* pixels */
#define LENS_MAX  512  /* lenses in a row */
#define LINE      256u
#define VIEWS     5

static uint8_t table[TABLE_MAX];
static uint8_t work[WORK_MAX] __attribute__((aligned(PLFX_ALIGN)));
static uint16_t pixels[ROW_MAX];
static int32_t slope[LENS_MAX];
static char line[LINE];
static plfx_lut lut;
static plfx_plan plan;
static plfx_stream stream;
static plfx_stream_cfg setup;

static void stop(const char *why)
{
    plfx_semihost_print("stream_m7: ");
    plfx_semihost_print(why);
    plfx_semihost_print("\n");
    plfx_semihost_exit(1);
}

/* Word k of the command line, cut out in place; NULL if there is none. */
static char *word(uint32_t k)
{
    char *at = line;
    char *found = NULL;
    uint32_t n = 0;

    while (*at != 0 && found == NULL) { /* at most LINE rounds */
        while (*at == ' ') {            /* at most LINE rounds */
            at++;
        }
        if (n == k && *at != 0) {
            found = at;
        }
        n++;
        while (*at != ' ' && *at != 0) { /* at most LINE rounds */
            at++;
        }
    }
    if (found != NULL) {
        *at = 0;
    }
    return found;
}

static void read_table(const char *path)
{
    int32_t file = plfx_semihost_open(path, 0);
    uint32_t n = file > 0 ? plfx_semihost_size(file) : 0u;

    if (n == 0u || n > TABLE_MAX || plfx_semihost_read(file, table, n) != PLFX_OK ||
        plfx_lut_open(&lut, table, n) != PLFX_OK) {
        stop("no table");
    }
    plfx_semihost_close(file);
}

/* A row of views, SAD over 5 x 5 lenses, 21 slopes from 0 to 0.2. */
static void prepare(void)
{
    static plfx_cfg cfg;
    int32_t k;

    cfg.method = PLFX_METHOD_SWEEP;
    cfg.cost = PLFX_COST_SAD;
    cfg.fit = PLFX_FIT_VEE;
    cfg.window = 5;
    cfg.bits = 8;
    cfg.n = VIEWS;
    cfg.ref = VIEWS / 2;
    cfg.texture = 8;
    cfg.labels = 21;
    cfg.slope_min_q16 = 0;
    cfg.slope_max_q16 = 13107;
    for (k = 0; k < VIEWS; k++) {
        int32_t r = lut.radius_q8 * (k - VIEWS / 2);
        cfg.at[k].u_q8 = (int16_t)((r + (r < 0 ? -1 : 1)) / 2);
    }
    if (plfx_plan_init(&plan, &cfg, &lut, lut.lattice.nx, lut.lattice.ny) != PLFX_OK) {
        stop("the table does not suit this plan");
    }
    setup.plan = &plan;
    setup.lut = &lut;
    setup.tone = plfx_tone_unity(cfg.bits);
    setup.profile = PLFX_PROFILE_SMALL;
    setup.white = 1;
    setup.format = PLFX_RAW_U16LE;
    setup.bits = (uint8_t)lut.sensor_bits;
    setup.open_rows = plfx_stream_open_rows(&lut, &plan, &setup.tone);
    setup.j0 = 0;
    setup.j1 = lut.lattice.ny;
    if (lut.sensor_w > ROW_MAX || lut.lattice.nx > LENS_MAX ||
        plfx_stream_init(&stream, &setup, work, sizeof work) != PLFX_OK) {
        stop("not enough memory for this table");
    }
}

static void pop_rows(int32_t file, int32_t ready)
{
    plfx_map row;
    int32_t j;

    memset(&row, 0, sizeof row);
    row.slope_q16 = slope;
    row.w = lut.lattice.nx;
    row.h = 1;
    row.stride = row.w;
    while (ready > 0) { /* at most the rows of the map */
        if (plfx_stream_pop(&stream, &j, &row, &ready) != PLFX_OK ||
            plfx_semihost_write(file, slope, 4u * (uint32_t)row.w) != PLFX_OK) {
            stop("the map cannot be written");
        }
    }
}

static void run(int32_t frame, int32_t map)
{
    uint32_t bytes = 2u * (uint32_t)lut.sensor_w;
    plfx_raw_row row;
    int32_t first;
    int32_t last;
    int32_t y;

    plfx_stream_rows(&stream, &first, &last);
    memset(&row, 0, sizeof row);
    row.bytes = (const uint8_t *)pixels;
    row.format = setup.format;
    row.bits = setup.bits;
    row.width = lut.sensor_w;
    for (y = 0; y <= last; y++) {
        int32_t ready = 0;
        if (plfx_semihost_read(frame, pixels, bytes) != PLFX_OK) {
            stop("the frame ends too soon");
        }
        if (y >= first && plfx_stream_push(&stream, y, &row, &ready) != PLFX_OK) {
            stop("the core refused a row");
        }
        pop_rows(map, ready);
    }
    if (plfx_stream_finish(&stream) != PLFX_OK) {
        stop("rows of the map are missing");
    }
}

int main(void)
{
    const char *path[3];
    int32_t frame;
    int32_t map;
    uint32_t k;

    if (plfx_semihost_arguments(line, LINE) != PLFX_OK) {
        stop("no command line");
    }
    for (k = 3; k > 0u; k--) { /* from behind: each is cut off the line */
        path[k - 1u] = word(k - 1u);
        if (path[k - 1u] == NULL) {
            stop("usage: stream_m7 FRAME.raw TABLE.plut MAP.raw");
        }
    }
    read_table(path[1]);
    prepare();
    frame = plfx_semihost_open(path[0], 0);
    map = plfx_semihost_open(path[2], 1);
    if (frame < 0 || map < 0) {
        stop("no frame, or no place for the map");
    }
    run(frame, map);
    plfx_semihost_close(map);
    plfx_semihost_print("stream_m7: map written\n");
    plfx_semihost_exit(0);
    return 0;
}
