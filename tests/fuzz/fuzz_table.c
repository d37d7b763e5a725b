/* SPDX-License-Identifier: MIT
 * Lens tables.  First byte odd: checksums are made to hold, so that what lies behind
 * them is reached. */
#include "fuzz.h"

#include "bytes.h"
#include "crc32.h"
#include "lut_format.h"

#include "plenofix/plan.h"

static void mend(uint8_t *b, size_t n)
{
    uint32_t header = n >= LUT_HEADER ? plfx_get_u32(b + LUT_AT_HEADER) : 0;
    uint32_t at;

    if (header < LUT_HEADER || header > n) {
        return;
    }
    for (at = LUT_HEADER; at + LUT_ENTRY <= header; at += LUT_ENTRY) {
        uint32_t from = plfx_get_u32(b + at + 4);
        uint32_t length = plfx_get_u32(b + at + 8);
        if (from <= n && length <= n - from) {
            plfx_put_u32(b + at + 12, plfx_crc32(0, b + from, length));
        }
    }
    plfx_put_u32(b + LUT_AT_CRC, 0);
    plfx_put_u32(b + LUT_AT_CRC, plfx_crc32(0, b, header));
}

/* Everything that reads an opened table. */
static void use(const plfx_lut *t)
{
    uint16_t *row = fuzz_room(2 * (size_t)t->lattice.nx);
    plfx_offset at = {300, -300};
    int32_t j;

    for (j = 0; j<t->lattice.ny; j += t->lattice.ny> 64 ? 63 : 1) {
        fuzz_must(plfx_lut_gain_row(t, j, (int16_t)(j * 997), -32768, row) == PLFX_OK);
        (void)plfx_lut_centre(t, t->lattice.nx - 1, j);
        (void)plfx_lut_flags(t, 0, j);
    }
    fuzz_must(plfx_lut_pitch_q16(t) > 0);
    (void)plfx_view_offset(t, at);
    free(row);
}

static void plan(const plfx_lut *t)
{
    static plfx_plan p;
    plfx_cfg c;

    memset(&c, 0, sizeof c);
    c.window = 5;
    c.bits = 12;
    c.n = 2;
    c.labels = 9;
    c.slope_min_q16 = -65536;
    c.slope_max_q16 = 65536;
    c.at[1].u_q8 = 512;
    c.at[1].v_q8 = -512;
    if (plfx_plan_init(&p, &c, t, t->lattice.nx, t->lattice.ny) == PLFX_OK) {
        (void)plfx_plan_shift(&p, 1, 8);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint32_t mended = fuzz_u8(&in) & 1u;
    uint8_t *blob = fuzz_rest(&in);
    plfx_lut t;

    if (mended) {
        mend(blob, in.left);
    }
    if (plfx_lut_open(&t, blob, in.left) == PLFX_OK) {
        use(&t);
        plan(&t);
    }
    free(blob);
    return 0;
}
