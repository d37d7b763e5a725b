/* SPDX-License-Identifier: MIT
 * 64-bit arithmetic for a 32-bit machine: that of the compiler is built for a later
 * SPARC.  Bit by bit; names are those that the compiler calls. */
#include <stdint.h>

uint64_t __udivdi3(uint64_t n, uint64_t d);
uint64_t __umoddi3(uint64_t n, uint64_t d);
int64_t __divdi3(int64_t n, int64_t d);
int64_t __moddi3(int64_t n, int64_t d);
int __clzdi2(uint64_t v);

static uint64_t divide(uint64_t n, uint64_t d, uint64_t *rest)
{
    uint64_t quotient = 0;
    uint64_t r = 0;
    int32_t i;

    for (i = 63; i >= 0; i--) {
        uint64_t carry = r >> 63;
        r = (r << 1) | ((n >> i) & 1u);
        if (carry != 0u || r >= d) {
            r -= d;
            quotient |= (uint64_t)1 << i;
        }
    }
    *rest = r;
    return quotient;
}

static uint64_t magnitude(int64_t v)
{
    return v < 0 ? 0u - (uint64_t)v : (uint64_t)v;
}

uint64_t __udivdi3(uint64_t n, uint64_t d)
{
    uint64_t rest;

    return divide(n, d, &rest);
}

uint64_t __umoddi3(uint64_t n, uint64_t d)
{
    uint64_t rest;

    (void)divide(n, d, &rest);
    return rest;
}

int64_t __divdi3(int64_t n, int64_t d)
{
    uint64_t rest;
    uint64_t q = divide(magnitude(n), magnitude(d), &rest);

    return (int64_t)((n < 0) != (d < 0) ? 0u - q : q);
}

int64_t __moddi3(int64_t n, int64_t d)
{
    uint64_t rest;

    (void)divide(magnitude(n), magnitude(d), &rest);
    return (int64_t)(n < 0 ? 0u - rest : rest);
}

int __clzdi2(uint64_t v)
{
    int n = 0;

    for (; n < 63 && (v >> (63 - n)) == 0u; n++) {
    }
    return n;
}
