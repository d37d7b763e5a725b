/* SPDX-License-Identifier: MIT
 * The table reader in the bounded model checker (ESBMC): a table of one section and one
 * lens, every other byte anything (a local array without a value is that to the
 * checker), any length up to the buffer's.  Checksums may come out as they like, and a
 * square root as any number: what follows from them is covered all the more.  No access
 * outside, no shift out of range; that sums do not overflow is lattice.c's.
 * .ci/checks/proof.py runs it. */
#include "fix.h"

unsigned int nondet_uint(void);
void __ESBMC_assume(_Bool holds);
void __ESBMC_assert(_Bool holds, const char *what);

#define plfx_isqrt_u64(v) ((uint32_t)(v) >> 1 ^ nondet_uint() >> 1)
#include "lut.c"

uint32_t plfx_crc32(uint32_t crc, const uint8_t *bytes, size_t n)
{
    (void)crc;
    (void)bytes;
    (void)n;
    return nondet_uint();
}

void check_table(void)
{
    uint8_t blob[88 + 16];
    plfx_lut t;
    uint32_t n = nondet_uint();

    __ESBMC_assume(n <= sizeof blob);
    blob[LUT_AT_SECTIONS] = 1;
    blob[LUT_AT_SECTIONS + 1] = blob[LUT_AT_LENSES + 1] = blob[LUT_AT_LENSES + 3] = 0;
    blob[LUT_AT_LENSES] = blob[LUT_AT_LENSES + 2] = 1;
    if (plfx_lut_open(&t, blob, n) == PLFX_OK) {
        __ESBMC_assert(t.size <= n, "inside the blob");
        __ESBMC_assert(t.lattice.nx == 1 && t.lattice.ny == 1, "as stored");
        __ESBMC_assert(t.gain.length <= 16, "no more than there is");
    }
}
