/* SPDX-License-Identifier: MIT */
#include "plenofix/preset.h"
#include "fix.h"

#define VIEWS_MAX 2048

typedef struct preset {
    plfx_frame_cfg frame;
    uint8_t window;
    uint16_t texture, unique_u16;
    uint16_t step_q8; /* between labels, lens pitches in the farthest view */
} preset;

static const preset presets[PLFX_PRESETS] = {
    {{.arms = 4,
      .keep = 2,
      .shrink = 1,
      .paths = 0,
      .median1 = 5,
      .median2 = 0,
      .taps = 0,
      .window = 5,
      .passes = 1,
      .axes = 1,
      .trunc_q4 = 192,
      .gtrunc_q4 = 256,
      .gweight_q4 = 0,
      .p1_q4 = 1,
      .p2_q4 = 2,
      .soften_q4 = 64,
      .similar_q4 = 350,
      .robust_q4 = 96,
      .gate_q8 = 82,
      .clamp_q8 = 61,
      .rival_q8 = 98,
      .prior_q12 = 82,
      .noise_q4 = 0},
     5,
     8,
     0,
     128},
    {{.arms = 8,
      .keep = 3,
      .shrink = 1,
      .paths = 8,
      .median1 = 7,
      .median2 = 5,
      .taps = 4,
      .window = 5,
      .passes = 1,
      .axes = 0,
      .trunc_q4 = 192,
      .gtrunc_q4 = 256,
      .gweight_q4 = 12,
      .p1_q4 = 12,
      .p2_q4 = 40,
      .soften_q4 = 64,
      .similar_q4 = 350,
      .robust_q4 = 96,
      .gate_q8 = 82,
      .clamp_q8 = 61,
      .rival_q8 = 98,
      .prior_q12 = 82,
      .noise_q4 = 0},
     5,
     8,
     0,
     102},
    {{.arms = 8,
      .keep = 3,
      .shrink = 1,
      .paths = 8,
      .median1 = 7,
      .median2 = 0,
      .taps = 6,
      .window = 15,
      .passes = 3,
      .axes = 0,
      .trunc_q4 = 192,
      .gtrunc_q4 = 256,
      .gweight_q4 = 12,
      .p1_q4 = 12,
      .p2_q4 = 40,
      .soften_q4 = 64,
      .similar_q4 = 350,
      .robust_q4 = 160,
      .gate_q8 = 82,
      .clamp_q8 = 64,
      .rival_q8 = 0,
      .prior_q12 = 65535,
      .noise_q4 = 0},
     5,
     8,
     0,
     102},
};

plfx_status plfx_preset(int32_t id, plfx_cfg *cfg, plfx_frame_cfg *frame)
{
    const preset *p;

    if (id < 0 || id >= PLFX_PRESETS || !cfg || !frame) {
        return PLFX_E_ARG;
    }
    p = presets + id;
    *frame = p->frame;
    cfg->method = PLFX_METHOD_ARMS;
    cfg->cost = PLFX_COST_SAD;
    cfg->fit = PLFX_FIT_VEE;
    cfg->fuse = PLFX_FUSE_MEDIAN;
    cfg->window = p->window;
    cfg->texture = p->texture;
    cfg->unique_u16 = p->unique_u16;
    return PLFX_OK;
}

static int32_t magnitude(int32_t v)
{
    return v < 0 ? -v : v;
}

/* Within 1/10 of one of the eight rays. */
static int32_t on_star(int32_t u, int32_t v)
{
    int32_t a = magnitude(u);
    int32_t b = magnitude(v);
    int32_t most = plfx_max_i32(a, b);

    return most > 0 &&
           (10 * plfx_min_i32(a, b) <= most || 10 * magnitude(a - b) <= most);
}

static int32_t choose_star(const plfx_offset *at, int32_t n, int32_t ref, uint8_t *use)
{
    int32_t count = 1;
    int32_t k;

    for (k = 0; k < n; k++) {
        int32_t in = on_star(at[k].u_q8 - at[ref].u_q8, at[k].v_q8 - at[ref].v_q8);
        use[k] = (uint8_t)(in || k == ref);
        count += in;
    }
    if (count < 5) {
        for (k = 0; k < n; k++) {
            use[k] = 1;
        }
        count = n;
    }
    return count;
}

/* Distance along half axis h (0 +u, 1 +v, 2 -u, 3 -v), or 0 when off it. */
static int32_t along(const plfx_offset *a, const plfx_offset *ref, int32_t h)
{
    int32_t u = a->u_q8 - ref->u_q8;
    int32_t v = a->v_q8 - ref->v_q8;
    int32_t d = h % 2 ? v : u;
    int32_t off = magnitude(h % 2 ? u : v);

    d = h < 2 ? d : -d;
    return d > 0 && 10 * off <= d ? d : 0;
}

/* The view whose distance along h is nearest `goal`; -1 when none is on it. */
static int32_t nearest(const plfx_offset *at, int32_t n, int32_t ref, int32_t h,
                       int32_t goal)
{
    int32_t best = -1;
    int32_t error = INT32_MAX;
    int32_t k;

    for (k = 0; k < n; k++) {
        int32_t d = along(at + k, at + ref, h);
        if (d > 0 && magnitude(d - goal) < error) {
            error = magnitude(d - goal);
            best = k;
        }
    }
    return best;
}

static int32_t choose_axes(const plfx_offset *at, int32_t n, int32_t ref, uint8_t *use)
{
    int32_t count = 0;
    int32_t h;
    int32_t k;

    for (k = 0; k < n; k++) {
        use[k] = (uint8_t)(k == ref);
    }
    for (h = 0; h < 4; h++) {
        int32_t far = nearest(at, n, ref, h, 1 << 20);
        if (far >= 0) {
            int32_t d = along(at + far, at + ref, h);
            use[far] = 1;
            use[nearest(at, n, ref, h, d / 2)] = 1;
        }
    }
    for (k = 0; k < n; k++) {
        count += use[k];
    }
    return count;
}

int32_t plfx_preset_views(int32_t id, const plfx_offset *at, int32_t n, int32_t ref,
                          uint8_t *use)
{
    if (id < 0 || id >= PLFX_PRESETS || !at || !use || n < 2 || n > VIEWS_MAX ||
        ref < 0 || ref >= n) {
        return 0;
    }
    return id == PLFX_PRESET_STREAM ? choose_axes(at, n, ref, use)
                                    : choose_star(at, n, ref, use);
}

int32_t plfx_preset_labels(int32_t id, int32_t min_q16, int32_t max_q16,
                           int32_t base_q8)
{
    int64_t span = ((int64_t)max_q16 - min_q16) * base_q8; /* lens pitches, q24 */
    int64_t step;

    if (id < 0 || id >= PLFX_PRESETS || span <= 0) {
        return PLFX_LABELS_MIN;
    }
    step = (int64_t)presets[id].step_q8 * 65536;
    return (int32_t)plfx_clamp_i32(plfx_sat_i32((span + step - 1) / step + 1),
                                   PLFX_LABELS_MIN, PLFX_LABELS_MAX);
}
