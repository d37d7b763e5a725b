/* SPDX-License-Identifier: MIT
 * Structural motion of the goldens: regions, modes, the watch on damping, packets. */
#include "golden.h"

#include <string.h>

#include "scene.h"

static void add_u64(golden_crc *c, uint64_t v)
{
    golden_add(c, (uint32_t)(v & 0xffffffffu), 4);
    golden_add(c, (uint32_t)(v >> 32), 4);
}

/* The scene with noise of -7 .. 8, its pixels taken from `by` to the left. */
static size_t noisy(uint32_t *seed, int32_t by, plfx_lut *lut)
{
    size_t size = scene_make(PLFX_LATTICE_SQUARE, lut);
    int32_t k;

    for (k = SCENE_W * SCENE_H - 1; k >= 0; k--) {
        int32_t v = scene_frame[k < by ? 0 : k - by];
        v += (int32_t)(golden_random(seed) >> 28) - 7;
        scene_frame[k] = (uint16_t)(v < 0 ? 0 : v > 4095 ? 4095 : v);
    }
    return size;
}

static void region_cfg(plfx_roi_cfg *c, const plfx_lut *lut)
{
    int32_t k;

    memset(c, 0, sizeof *c);
    c->lut = lut;
    c->tone = scene_tone();
    c->white = 1;
    c->views = SCENE_VIEWS;
    c->regions = 4;
    c->rest = 3;
    c->steps = 2;
    c->seek = 1;
    c->residual_q8 = 2048;
    for (k = 0; k < SCENE_VIEWS; k++) {
        c->at[k] = scene_at[k];
    }
    for (k = 0; k < 4; k++) {
        c->region[k].i = (int16_t)(9 + 20 * (k % 2));
        c->region[k].j = (int16_t)(8 + 13 * (k / 2));
        c->region[k].hx = 4;
        c->region[k].hy = 3;
        c->region[k].reference = (uint8_t)(k != 2);
    }
}

static void add_result(golden_crc *c, const plfx_roi_result *r)
{
    golden_add(c, (uint32_t)r->u_q24, 4);
    golden_add(c, (uint32_t)r->v_q24, 4);
    golden_add(c, (uint32_t)r->w_q24, 4);
    golden_add(c, r->u_sigma_q24, 4);
    golden_add(c, r->v_sigma_q24, 4);
    golden_add(c, r->w_sigma_q24, 4);
    golden_add(c, r->light_q12, 2);
    golden_add(c, r->residual_q8, 2);
    golden_add(c, r->flags, 1);
}

uint32_t golden_regions(void)
{
    static plfx_roi_cfg cfg;
    static plfx_roi roi;
    plfx_roi_result out[4];
    plfx_roi_shake shake;
    plfx_lut lut;
    plfx_raw raw;
    plfx_roi_frame frame = {&raw, NULL};
    golden_crc c;
    uint32_t seed = 77;
    int32_t t;
    int32_t k;

    if (scene_make(PLFX_LATTICE_SQUARE, &lut) == 0u) {
        return 0;
    }
    raw = scene_raw();
    region_cfg(&cfg, &lut);
    if (plfx_roi_ws(&cfg) == 0u || plfx_roi_ws(&cfg) > SCENE_WS ||
        plfx_roi_init(&roi, &cfg, scene_ws(), SCENE_WS) != PLFX_OK) {
        return 0;
    }
    golden_begin(&c);
    for (t = 0; t < 5; t++) {
        if (noisy(&seed, t == 4 ? 1 : 0, &lut) == 0u) {
            return 0;
        }
        if (t < 3) {
            if (plfx_roi_rest(&roi, &frame) != PLFX_OK) {
                return 0;
            }
            continue;
        }
        if (plfx_roi_measure(&roi, &frame, out) != PLFX_OK ||
            plfx_roi_shake_fit(&roi, out, &shake) != PLFX_OK) {
            return 0;
        }
        plfx_roi_steady(&roi, &shake, out);
        for (k = 0; k < 4; k++) {
            add_result(&c, &out[k]);
        }
        golden_add(&c, (uint32_t)shake.turn_q24, 4);
        golden_add(&c, (uint32_t)shake.wi_q24, 4);
    }
    return golden_end(&c);
}

static void add_mode(golden_crc *c, const plfx_mode *m)
{
    golden_add(c, m->freq_uhz, 4);
    golden_add(c, m->freq_sigma_uhz, 4);
    golden_add(c, (uint32_t)m->damp_ppm, 4);
    golden_add(c, m->damp_sigma_ppm, 4);
    golden_add(c, m->amp_q8, 4);
    golden_add(c, m->amp_sigma_q8, 4);
    golden_add(c, m->record_ms, 4);
    golden_add(c, m->flags, 4);
}

/* A resonance at 1/16 of the rate, kicked at random, that loses damping half-way. */
uint32_t golden_modes(void)
{
    static plfx_modal m;
    plfx_modal_cfg cfg = {200000, 12600000, 8, 40, 8};
    plfx_modal_watch w;
    plfx_modal_shape shape = {0, 0, 0};
    plfx_mode mode;
    golden_crc c;
    uint32_t seed = 5;
    int64_t x = 0;
    int64_t last = 0;
    int32_t t;

    if (plfx_modal_init(&m, &cfg) != PLFX_OK ||
        plfx_modal_watch_init(&w, &m, 10000, 25000, 2304) != PLFX_OK) {
        return 0;
    }
    golden_begin(&c);
    for (t = 0; t < 8000; t++) { /* x = 2 r cos(2 pi/16) x1 - r^2 x2, q14 */
        int64_t a = t < 4000 ? 29973 : 30200;
        int64_t b = t < 4000 ? 16063 : 16304;
        int64_t kick = (int64_t)(golden_random(&seed) >> 20) - 2048;
        int64_t next = (a * x - b * last) / 16384 + kick / 4;
        last = x;
        x = next;
        if (t == 3000) {
            plfx_modal_gap(&m, 7);
        }
        if (plfx_modal_push(&m, (int16_t)(x > 32767    ? 32767
                                          : x < -32768 ? -32768
                                                       : x)) != 0) {
            (void)plfx_modal_watch_add(&w, &m);
            plfx_modal_shape_add(&shape, &m, &m);
            golden_add(&c, (uint32_t)w.evidence_q20, 4);
        }
        if (t % 1000 == 999) {
            if (plfx_modal_read(&m, 4, &mode) != PLFX_OK) {
                return 0;
            }
            add_mode(&c, &mode);
            if (plfx_modal_alarm(&m, 30000, 256, &mode) != PLFX_OK) {
                return 0;
            }
            add_mode(&c, &mode);
        }
    }
    add_u64(&c, (uint64_t)shape.re);
    add_u64(&c, (uint64_t)shape.ref);
    return golden_end(&c);
}

uint32_t golden_packets(void)
{
    plfx_packet_regions info = {{7, 9, 100, 16383, 0}, 3, 5, 12, 18};
    plfx_packet_region rec[5];
    plfx_packet_mode mode[2];
    uint8_t bytes[256];
    golden_crc c;
    size_t n = 0;
    size_t k;

    golden_begin(&c);
    for (k = 0; k < 5; k++) {
        rec[k].u = (int16_t)(1000 * (int32_t)k - 2000);
        rec[k].v = (int16_t)(-7 * (int32_t)k);
        rec[k].w = (int16_t)(k == 4 ? -32768 : 321);
        rec[k].sigma = plfx_packet_sigma((uint32_t)1 << (3u * k));
        rec[k].flags = (uint8_t)k;
    }
    if (plfx_packet_put_regions(&info, rec, bytes, sizeof bytes, &n) != PLFX_OK) {
        return 0;
    }
    for (k = 0; k < n; k++) {
        golden_add(&c, bytes[k], 1);
    }
    memset(mode, 0, sizeof mode);
    mode[1].freq_uhz = 22000000;
    mode[1].damp_ppm = -1234;
    mode[1].record_ms = 60000;
    if (plfx_packet_put_modes(&info.head, mode, 2, bytes, sizeof bytes, &n) !=
        PLFX_OK) {
        return 0;
    }
    for (k = 0; k < n; k++) {
        golden_add(&c, bytes[k], 1);
    }
    return golden_end(&c);
}
