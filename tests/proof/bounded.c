/* SPDX-License-Identifier: MIT
 * Harnesses of a bounded model checker (ESBMC): for every value of the inputs within
 * the stated ranges no overflow, no access outside, no shift out of range, and the
 * result as specified.  .ci/checks/proof.py runs each function check_... on its own. */
#include "bytes.h"
#include "fix.h"
#include "scalar.h"

void __ESBMC_assume(_Bool holds);
void __ESBMC_assert(_Bool holds, const char *what);
int32_t nondet_int(void);
unsigned int nondet_uint(void);
long nondet_long(void);
unsigned long nondet_ulong(void);

/* The remainder of v over 2^s tells whether it goes up. */
void check_round_shift(void)
{
    int64_t v = nondet_long();
    int32_t s;

    __ESBMC_assume(v > -((int64_t)1 << 62) && v < (int64_t)1 << 62);
    for (s = 1; s <= 62; s++) {
        int64_t r = plfx_round_shift_i64(v, s);
        __ESBMC_assert(r == (v >> s) + (v >> (s - 1) & 1), "half goes up");
    }
}

void check_log2(void)
{
    uint64_t v = nondet_ulong();
    int32_t n;

    __ESBMC_assume(v > 0);
    n = plfx_log2_u64(v);
    __ESBMC_assert(n >= 0 && n <= 63, "within 64 bits");
    __ESBMC_assert(v >> n == 1, "the highest bit");
}

void check_bytes(void)
{
    uint8_t b[4];
    uint32_t v = nondet_uint();

    plfx_put_u32(b, v);
    __ESBMC_assert(plfx_get_u32(b) == v, "32 bits there and back");
    __ESBMC_assert(plfx_get_i32(b) == (int32_t)v, "and their sign");
    __ESBMC_assert(b[0] == (v & 255u) && b[3] == v >> 24, "least byte first");
    plfx_put_u16(b, v);
    __ESBMC_assert(plfx_get_u16(b) == (v & 0xffffu), "16 bits");
    __ESBMC_assert(plfx_get_i16(b) == (int16_t)(v & 0xffffu), "and their sign");
}

void check_vertex(void)
{
    uint32_t a = nondet_uint() & 0xffffu;
    uint32_t b = nondet_uint() & 0xffffu;
    int32_t f = plfx_vertex_q4(a, b, nondet_int() & 1);

    __ESBMC_assert(f >= -8 && f <= 8, "half a label at most");
    __ESBMC_assert(a <= b || f <= 0, "towards the lower side");
    __ESBMC_assert(a != b || f == 0, "in the middle when both rise alike");
}

void check_margin(void)
{
    uint32_t second = nondet_uint() & 0xffffu;
    uint32_t best = nondet_uint() & 0xffffu;
    uint32_t least = nondet_uint() & 0xffffu;
    uint32_t m;

    __ESBMC_assume(best <= second);
    m = plfx_margin_u16(best, second, least);
    __ESBMC_assert(m <= 65280 && m % 256 == 0, "steps of 2^-8");
    __ESBMC_assert(best != second || m == 0, "no margin between equals");
}

void check_correlation(void)
{
    uint32_t cost = nondet_uint();
    uint32_t g = nondet_uint();
    int32_t r;

    __ESBMC_assume(cost <= 65535 && g <= 32768);
    r = plfx_correlation_q15(cost, g);
    __ESBMC_assert(r >= -32768 && r <= 32767, "Q15");
}
