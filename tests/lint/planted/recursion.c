/* SPDX-License-Identifier: MIT
 * Broken on purpose: recursion through a second function. */
static int planted_odd(unsigned n);

static int planted_even(unsigned n)
{
    return n == 0u ? 1 : planted_odd(n - 1u);
}

static int planted_odd(unsigned n)
{
    return n == 0u ? 0 : planted_even(n - 1u);
}

int plfx_planted(unsigned n)
{
    return planted_even(n);
}
