#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Least-squares interpolation kernels: writes src/ls_kernel.h to standard output.

For a fraction f the taps t minimise, over frequencies up to `band` cycles a sample,
    sum W(w)^2 |sum_k t_k exp(i w k) - exp(i w f)|^2
with sum t = 1 and sum k t = f (no phase error at the lowest frequencies);
W = w * sinc(w/2pi) * exp(-w): the derivative (what moves a slope) of a texture that a
pixel has averaged and that falls off with frequency.
"""
import numpy as np


def taps(n, f, band):
    w = 2 * np.pi * (np.arange(96) + 0.5) / 96 * band
    weight = w * np.sinc(w / (2 * np.pi)) * np.exp(-w)
    k = np.arange(n) - (n // 2 - 1)
    basis = np.exp(1j * np.outer(w, k)) * weight[:, None]
    goal = np.exp(1j * w * f) * weight
    m = np.vstack([basis.real, basis.imag])
    y = np.concatenate([goal.real, goal.imag])
    system = np.zeros((n + 2, n + 2))
    system[:n, :n] = m.T @ m
    system[:n, n] = system[n, :n] = 1.0
    system[:n, n + 1] = system[n + 1, :n] = k
    return np.linalg.solve(system, np.concatenate([m.T @ y, [1.0, f]]))[:n]


BAND = {4: 0.35, 6: 0.3}


def quantised(n, f):
    t = np.round(taps(n, f, BAND[n]) * 16384).astype(int)
    t[np.argmax(t)] += 16384 - t.sum()
    return t


def table(name, n, phases):
    print(f"static const int16_t {name}[{phases + 1}][{n}] = {{")
    for p in range(phases + 1):
        row = quantised(n, p / phases)
        print("    {" + ", ".join(str(v) for v in row) + "},")
    print("};\n")


print("/* SPDX-License-Identifier: MIT")
print(" * Written by tests/bench/ls_kernel.py: least-squares interpolation taps, q14, for")
print(" * fractions p/64 of a sample.  Each row sums to 16384. */")
print("#ifndef PLENOFIX_SRC_LS_KERNEL_H\n#define PLENOFIX_SRC_LS_KERNEL_H\n")
print("#include <stdint.h>\n")
print("/* clang-format off */")
table("plfx_ls4", 4, 64)
table("plfx_ls6", 6, 64)
print("/* clang-format on */\n\n#endif")
