/* SPDX-License-Identifier: MIT
 * Random numbers addressed by key, so that the draw for a pixel depends on its place
 * and the seed alone: the same on every machine and in any order. */
#ifndef PLFT_SIM_RNG_H
#define PLFT_SIM_RNG_H

#include <stdint.h>

/* A well-mixed 64-bit word of a key (finaliser of the splitmix64 generator). */
static inline uint64_t plft_mix(uint64_t key)
{
    key += 0x9E3779B97F4A7C15u;
    key = (key ^ (key >> 30)) * 0xBF58476D1CE4E5B9u;
    key = (key ^ (key >> 27)) * 0x94D049BB133111EBu;
    return key ^ (key >> 31);
}

/* Key of the n-th draw of stream `stream`. */
static inline uint64_t plft_key(uint64_t seed, uint64_t stream, uint64_t n)
{
    return plft_mix(seed ^ plft_mix(stream)) + 4u * n;
}

/* Uniform in [0, 1), 53 bits. */
static inline double plft_uniform(uint64_t key)
{
    return (double)(plft_mix(key) >> 11) * (1.0 / 9007199254740992.0);
}

/* Sum of the four 16-bit parts of a word. */
static inline uint32_t plft_parts(uint64_t word)
{
    return (uint32_t)((word & 0xFFFFu) + ((word >> 16) & 0xFFFFu) +
                      ((word >> 32) & 0xFFFFu) + (word >> 48));
}

/* Mean 0, variance 1, |value| < 6: twelve uniform draws.  Uses keys key .. key+2;
 * integers up to the last step, so that no library function decides a bit. */
static inline double plft_gauss(uint64_t key)
{
    uint32_t sum = plft_parts(plft_mix(key)) + plft_parts(plft_mix(key + 1u)) +
                   plft_parts(plft_mix(key + 2u));

    return ((double)sum - 6.0 * 65535.0) / 65536.0;
}

#endif
