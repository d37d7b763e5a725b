/* SPDX-License-Identifier: MIT
 * Broken on purpose: C11's own assertion, an implicit conversion.  The header test must
 * refuse it. */
_Static_assert(sizeof(int) == 4, "C11, not C99");

static inline short narrowed(long v)
{
    return v;
}
