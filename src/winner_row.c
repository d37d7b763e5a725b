/* SPDX-License-Identifier: MIT
 * Winner, runner-up and equiangular fit of a row of aggregated costs. */
#include "frame_state.h"
#include "fix.h"

#define CHUNK PLFX_WINNER_CHUNK /* pixels whose running least is held at once */

typedef struct chunk {
    int16_t best[CHUNK], label[CHUNK], second[CHUNK];
} chunk;

static void find_best(const int16_t *sum, int32_t labels, int32_t step, chunk *c)
{
    int32_t l;
    int32_t i;

    for (i = 0; i < CHUNK; i++) {
        c->best[i] = INT16_MAX;
        c->label[i] = 0;
    }
    for (l = 0; l < labels; l++) {
        const int16_t *row = sum + (size_t)l * (size_t)step;
        int16_t now = (int16_t)l;
        for (i = 0; i < CHUNK; i++) {
            int16_t v = row[i];
            int16_t k = c->label[i];
            c->label[i] = v < c->best[i] ? now : k;
            c->best[i] = v < c->best[i] ? v : c->best[i];
        }
    }
}

/* Least over the labels at least two away from the winner. */
static void find_second(const int16_t *sum, int32_t labels, int32_t step, chunk *c)
{
    int32_t l;
    int32_t i;

    for (i = 0; i < CHUNK; i++) {
        c->second[i] = INT16_MAX;
    }
    for (l = 0; l < labels; l++) {
        const int16_t *row = sum + (size_t)l * (size_t)step;
        for (i = 0; i < CHUNK; i++) {
            int16_t away = (int16_t)(l - c->label[i]);
            int16_t v = row[i];
            int16_t near = (int16_t) - (away >= -1 && away <= 1);
            v = (int16_t)(v | (near & INT16_MAX));
            c->second[i] = v < c->second[i] ? v : c->second[i];
        }
    }
}

/* Equiangular fit: (a - c)/(2(max(a,c) - b)), sixteenths of a label, half away from 0.
 */
static int32_t vee_q4(int32_t a, int32_t b, int32_t c)
{
    int32_t rise = plfx_max_i32(a, c) - b; /* b is the first of the least: a > b */

    return plfx_clamp_i32((int32_t)plfx_div_round_i64(8 * (a - c), rise), -8, 8);
}

static void store(const plfx_frame_state *s, const int16_t *sum, int32_t step,
                  size_t at, const chunk *c, int32_t i)
{
    int32_t label = c->label[i];
    int32_t best = c->best[i];
    int32_t second = c->second[i];
    int32_t end = label == 0 || label == s->labels - 1;
    int32_t q4 = 16 * label;
    int32_t floor_cost = 8 * plfx_max_i32(s->cfg.paths, 1);

    if (!end) {
        q4 += vee_q4(sum[-step], best, sum[step]);
    }
    s->e_a[at] = plfx_frame_e_of(s, plfx_plan_slope_q16(s->plan, q4));
    s->conf[at] = (uint16_t)((uint32_t)(second - best) * 65535u /
                             (uint32_t)(second + floor_cost));
    s->flags[at] = end ? PLFX_FLAG_RANGE_END : 0;
}

size_t plfx_winner_scratch(void)
{
    return sizeof(chunk);
}

void plfx_winner_chunk(const plfx_frame_state *s, size_t at, const int16_t *sum,
                       int32_t step, int32_t n, void *work)
{
    chunk *c = work;
    int32_t i;

    find_best(sum, s->labels, step, c);
    find_second(sum, s->labels, step, c);
    for (i = 0; i < n; i++) {
        store(s, sum + (size_t)c->label[i] * (size_t)step + i, step, at + (size_t)i, c,
              i);
    }
}

void plfx_winner_row(const plfx_frame_state *s, int32_t y, const int16_t *sum,
                     void *work)
{
    int32_t x;

    for (x = 0; x < s->nx; x += CHUNK) {
        /* The last chunk reads into the next label's row, or the spare after the last.
         */
        plfx_winner_chunk(s, plfx_frame_at(s, y) + (size_t)x, sum + x, s->nx,
                          plfx_min_i32(CHUNK, s->nx - x), work);
    }
}
