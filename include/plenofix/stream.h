/* SPDX-License-Identifier: MIT
 * Streaming: sensor rows in, map rows out.  No raw row is kept: each lens row gathers
 * its taps as the rows pass, each view row is matched as soon as it is whole.  The map
 * is that of plfx_view_all() and plfx_sweep() to the bit, whatever the profile; of
 * plfx_gradient() and plfx_frame() where the plan's method is GRADIENT or ARMS.
 *
 *   plfx_plan_init(&plan, &what, &lut, lut.lattice.nx, lut.lattice.ny);
 *   memset(&cfg, 0, sizeof cfg);
 *   cfg.plan = &plan, cfg.lut = &lut, cfg.tone = plfx_tone_unity(plan.cfg.bits);
 *   cfg.format = PLFX_RAW_MONO12P, cfg.bits = 12, cfg.j1 = plan.ny;
 *   cfg.open_rows = plfx_stream_open_rows(&lut, &plan, &cfg.tone);
 *   plfx_stream_init(&s, &cfg, ws, plfx_stream_ws(&cfg));   ws aligned to PLFX_ALIGN
 *   for (y = 0; y < lut.sensor_h; y++) {
 *       plfx_stream_push(&s, y, &row, &ready);
 *       while (ready > 0) {
 *           plfx_stream_pop(&s, &j, &line, &ready);
 *       }
 *   }
 *   plfx_stream_finish(&s);          then plfx_stream_reset() for the next frame
 *
 * Map row j can be popped when lens row j + window/2 + b is whole, b the rows that
 * views reach below their targets (0 when all lie along u); with ARMS 1 + median1/2
 * rows later.  Most pushes gather taps alone; one that ends a lens row also brings its
 * costs in, and a pop finds the winners of its row.  Nothing is kept outside `s` and
 * `ws`; two streams may run on two threads. */
#ifndef PLENOFIX_STREAM_H
#define PLENOFIX_STREAM_H

#include "plenofix/plan.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum plfx_profile {
    PLFX_PROFILE_SMALL = 0, /* least memory: view rows at rest in 8 or 12 bits a sample,
                               leaving costs computed again; ARMS does so in both.
                               NCC keeps the rows of a window in both, GRADIENT
                               their derivatives */
    PLFX_PROFILE_FAST       /* a ring of cost rows (SWEEP of 3 and more views) or of
                               striped view rows, cached lens centres */
} plfx_profile;

#define PLFX_STREAM_OPEN_MAX 8 /* lens rows gathering taps at the same time */

typedef struct plfx_stream_cfg {
    const plfx_plan *plan;              /* made with `lut`; kept */
    const plfx_lut *lut;                /* kept, with its blob */
    const struct plfx_frame_cfg *frame; /* ARMS: plfx_preset() of PLFX_PRESET_STREAM, or
                                           any without paths, refinement, second median
                                           and noise from 0.75 grey on; kept */
    plfx_tone tone;                     /* tone.bits = plan->cfg.bits */
    uint8_t profile;                    /* plfx_profile */
    uint8_t white;                      /* 1: the table's gains */
    uint8_t format;                     /* plfx_raw_format of the rows */
    uint8_t bits;                       /* significant bits of a raw pixel, 8 .. 16 */
    uint8_t fed;       /* 1: rows of the table come by plfx_stream_feed() */
    int32_t open_rows; /* 1 .. PLFX_STREAM_OPEN_MAX, plfx_stream_open_rows() */
    int32_t j0, j1;    /* map rows wanted, 0 <= j0 < j1 <= ny */
} plfx_stream_cfg;

typedef struct plfx_stream {
    plfx_stream_cfg cfg;
    void *state;     /* in the workspace */
    int32_t y;       /* next sensor row */
    int32_t j;       /* next map row */
    int32_t ready;   /* map rows up to here can be popped */
    int32_t started; /* 1: a row has come */
} plfx_stream;

/* Lens rows that gather taps at the same time with this table, plan and tone: the least
 * open_rows that plfx_stream_init() takes; 0 when no number does (E_RANGE: lens rows of
 * the table are not in the order of the sensor's, or over 8 overlap).
 * Cost: one pass over the lenses. */
int32_t plfx_stream_open_rows(const plfx_lut *lut, const plfx_plan *plan,
                              const plfx_tone *tone);

/* Workspace, bytes: exactly that much is enough and is needed; 0 when the
 * configuration is out of range.  A function of sizes alone, not of the table's
 * content. */
size_t plfx_stream_ws(const plfx_stream_cfg *cfg);

/* An upper bound of plfx_stream_ws() for static buffers, from sizes alone, 3 to 8 %
 * over on a frame of 16 megapixels, more on small ones:
 *   nx, n, labels, window   as in the plan
 *   packed_w   pixels of a sensor row; 0 when rows are PLFX_RAW_U16
 *   pairs      n - 1 for PAIRS, 0 for SWEEP
 *   reach      the plan's reach_x: columns that a view is displaced at most
 *   around     lens rows that vertical views need besides: 0 when all views lie along
 *              u, else 2*(reach_y + 1)
 *   open       open_rows
 *   fast, texture   1: PLFX_PROFILE_FAST, the plan's texture test
 *   lanes      PLFX_LANES of the build: 1 on small cores, 8 with SSE2, NEON or VSX, 16
 *              with AVX2; 32 holds for all
 * Each row of `around` costs n*nx*2 bytes, and n*nx*3/2 more in the small profile. */
#define PLFX_STREAM_WIDE(nx, window, lanes)                                            \
    ((nx) + (lanes) > (window) * (lanes) ? (nx) + (lanes) : (window) * (lanes))
#define PLFX_STREAM_COLS(nx, pairs, labels, window, lanes)                             \
    (2u * ((pairs) > 1u ? (pairs) : 1u) * (labels)*PLFX_STREAM_WIDE(nx, window, lanes))
#define PLFX_STREAM_WS(nx, packed_w, n, pairs, labels, window, reach, around, open,    \
                       fast, texture, lanes)                                           \
    PLFX_ALIGNED(                                                                      \
        2304u + (n) * (28u + (labels) * ((around) ? 40u : 8u)) +                       \
        2u * (n) *                                                                     \
            (PLFX_STREAM_WIDE(nx, window, lanes) + (2u * (reach) + 4u) * (lanes)) *    \
            (1u + (around) + ((fast) && ((pairs) || (n) == 2u) ? (window) : 0u)) +     \
        4u * PLFX_STREAM_WIDE(nx, window, lanes) + 8u * (nx) +                         \
        ((texture) ? (12u + 2u * (window)) * (nx) : 0u) +                              \
        PLFX_STREAM_COLS(nx, pairs, labels, window, lanes) *                           \
            (1u + ((fast) && !(pairs) && (n) > 2u ? (window) : 0u)) +                  \
        10u * (labels) * (lanes) + 8u * (labels) +                                     \
        (pairs) * (8u * (labels) + 9u * (nx) + 128u) +                                 \
        (open) * (2u * (n) * (nx) + ((fast) ? 9u * (nx) + 256u : 0u)) +                \
        ((fast) ? 2u * (packed_w)                                                      \
                : ((window) + (around)-1u) * (n) * ((nx)*3u / 2u + 1u)))

/* The same for ARMS:
 *   arms, in_arm   arms that have views, most views of one
 *   around         2*reach_y, 2 more with gradient weights
 *   median         frame.median1
 * The arguments of PLFX_STREAM_WS() that are not here do not matter. */
#define PLFX_STREAM_MORE(a, b) ((a) > (b) ? (a) : (b))
#define PLFX_STREAM_BACK(window, median)                                               \
    PLFX_STREAM_MORE((window) + 1u,                                                    \
                     (window) / 2u + (median) / 2u + 2u +                              \
                         PLFX_STREAM_MORE((window) / 2u + 1u, (median) / 2u))
#define PLFX_STREAM_ARMS_WS(nx, packed_w, n, arms, in_arm, labels, window, reach,      \
                            around, median, open, fast)                                \
    PLFX_ALIGNED(4096u + (n) * (20u + 8u * (labels)) +                                 \
                 (open) * (2u * (n) * (nx) + ((fast) ? 9u * (nx) + 256u : 0u)) +       \
                 ((fast) ? 2u * (packed_w) : 0u) + 2u * (nx) +                         \
                 2u * ((nx) + 2u * (reach) + 24u) *                                    \
                     (PLFX_STREAM_BACK(window, median) + (around)) +                   \
                 ((n)-1u) * ((window) + 1u + (around)) * ((nx)*3u / 2u + 1u) +         \
                 (7u * ((median) / 2u + 1u) + 8u) * (nx) +                             \
                 2u * (median) * ((nx) + (median) + 63u) +                             \
                 PLFX_STREAM_MORE(                                                     \
                     2u * (in_arm) * ((around) + 1u) * ((nx) + 2u * (reach) + 24u) +   \
                         30u * (nx),                                                   \
                     PLFX_STREAM_MORE(128u * (labels), 256u * (median) * (median))) +  \
                 (labels) * (3u * ((nx) + 2u) + 2u * (arms) * (nx)))

/* The same for pairs by NCC and for the gradient; reach_y as in the plan, open as
 * above.  They are a fifth too wide for 289x193 lenses, several times for a handful of
 * lenses or labels of whole lenses. */
#define PLFX_STREAM_TAPS(nx, packed_w, n, open, fast)                                  \
    ((open) * (2u * (n) * (nx) + ((fast) ? 9u * (nx) + 256u : 0u)) +                   \
     ((fast) ? 2u * (packed_w) : 0u) + 2u * (nx) + 8u * (n))
#define PLFX_STREAM_NCC_WS(nx, packed_w, n, labels, window, reach, reach_y, open,      \
                           fast, lanes)                                                \
    PLFX_ALIGNED(                                                                      \
        8192u + PLFX_STREAM_TAPS(nx, packed_w, n, open, fast) +                        \
        2u * (n) * (nx) * ((window) + 2u + 2u * (reach_y)) +                           \
        ((n)-1u) * (labels) *                                                          \
            (PLFX_STREAM_MORE(12u * (nx), 4u * PLFX_STREAM_WIDE(nx, window, lanes)) +  \
             8u) +                                                                     \
        (labels) * (2u * (nx) + 24u * (lanes)) + (9u * (n) + 140u) * (nx) +            \
        (8u * (n) + 64u) * (PLFX_STREAM_WIDE(nx, window, lanes) +                      \
                            (2u * (reach) + (window) + 2u) * (lanes)))

#define PLFX_STREAM_GRADIENT_WS(nx, packed_w, window, open, fast)                      \
    PLFX_ALIGNED(4096u + PLFX_STREAM_TAPS(nx, packed_w, 5u, open, fast) +              \
                 (nx) * (8u * (window) + 98u))

/* PLFX_OK, PLFX_E_ARG (a field out of range; settings of ARMS that do not stream),
 * PLFX_E_SIZE (ws NULL, not aligned to PLFX_ALIGN, or shorter than plfx_stream_ws()),
 * PLFX_E_RANGE (the table needs more open rows). */
plfx_status plfx_stream_init(plfx_stream *s, const plfx_stream_cfg *cfg, void *ws,
                             size_t ws_size) PLFX_MUST_USE;

/* First and last sensor row that the wanted map rows depend on; rows before the first
 * need not be pushed.  last < first: none at all.  Of a fed table: all rows. */
void plfx_stream_rows(const plfx_stream *s, int32_t *first, int32_t *last);

/* A row of the lens table, from wherever it is kept. */
typedef struct plfx_lens_row {
    const int16_t *resid_q12;      /* [nx][2] residuals dx, dy; NULL: 0 */
    const uint8_t *flags;          /* [nx] PLFX_LENS_*; NULL: 0 */
    const uint16_t *lens_gain_u13; /* [nx], times the profiles of the table's GAIN
                                      section, without which it is not read; NULL: 1 */
} plfx_lens_row;

/* A table that is not in memory as a whole (cfg.fed = 1): cfg.lut gives the lattice,
 * the sensor and the profiles of white gains; its rows of residuals, flags and gains of
 * lenses are not read but fed, in order, every frame anew:
 *
 *   while ((j = plfx_stream_wants(&s)) >= 0) {
 *       plfx_stream_feed(&s, j, &lens_row, &ready);     then pop what is ready
 *   }
 *   plfx_stream_push(...)
 *
 * open_rows is found beforehand, with the whole table.  The workspace grows by
 * PLFX_STREAM_FED_WS(). */
#define PLFX_STREAM_FED_WS(nx, open)                                                   \
    (PLFX_ALIGNED(sizeof(plfx_lut)) + PLFX_ALIGNED(7u * (nx) * (open)))

/* Row of the table that is to be fed before another sensor row; -1: none now. */
int32_t plfx_stream_wants(const plfx_stream *s);

/* Row j of the table; copied.  *ready as in plfx_stream_push().  PLFX_OK, PLFX_E_ARG,
 * PLFX_E_STATE (not the row that is wanted), PLFX_E_RANGE (the row needs sensor rows
 * that went by: more open rows, or a table whose rows are not in the order of the
 * sensor's).  After an error the stream is as before the call. */
plfx_status plfx_stream_feed(plfx_stream *s, int32_t j, const plfx_lens_row *row,
                             int32_t *ready) PLFX_MUST_USE;

/* Sensor row y; *ready: map rows that can be popped now.  Rows come in order; the
 * first may be any row up to the first one needed.  PLFX_OK, PLFX_E_ARG (y off the
 * sensor, or a row that is not as configured), PLFX_E_STATE (y is not the next row,
 * map rows wait: pop first, or a row of the table is wanted: feed first).  After an
 * error the stream is as before the call. */
plfx_status plfx_stream_push(plfx_stream *s, int32_t y, const plfx_raw_row *row,
                             int32_t *ready) PLFX_MUST_USE;

/* Rows y .. y+h-1 in one bit stream.  *used: rows taken, fewer than h when map rows
 * wait or a row of the table is wanted; call again with the rest after that.  Same
 * errors; PLFX_E_ARG for no rows. */
plfx_status plfx_stream_push_band(plfx_stream *s, int32_t y, const plfx_raw *band,
                                  int32_t *used, int32_t *ready) PLFX_MUST_USE;

/* The next map row into `row`, a map of one row (h = 1, w = nx), and its number;
 * *ready: rows that can be popped after it.  PLFX_OK, PLFX_E_ARG, PLFX_E_STATE (none
 * ready). */
plfx_status plfx_stream_pop(plfx_stream *s, int32_t *j, const plfx_map *row,
                            int32_t *ready) PLFX_MUST_USE;

/* End of the frame: PLFX_OK when every wanted map row was popped, else PLFX_E_STATE.
 * Changes nothing. */
plfx_status plfx_stream_finish(const plfx_stream *s) PLFX_MUST_USE;

/* Forget the frame, at any time, and begin another. */
plfx_status plfx_stream_reset(plfx_stream *s) PLFX_MUST_USE;

#ifdef __cplusplus
}
#endif
#endif
