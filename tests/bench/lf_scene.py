#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Light-field views of random scenes with truth: slanted planes, smooth surfaces,
occluding boxes and thin bars, textures from broad to fine, flat patches, mild shading.

    lf_scene.py SEED [-o DIR] [--size N] [--views 9] [--noise GREY] [--bits 10]

A point of the centre view at (x, y) with disparity d is seen in view (r, c) at
(x - d*(c - cc), y - d*(r - rc)); the greatest d is nearest.  Each pixel averages `over`
x `over` rays.  With -o: input_CamNNN.png (16 bit) and truth.pfm.
"""
import argparse
import os

import numpy as np

OVERSAMPLED = 4  # texture samples a pixel


def smooth_noise(rng, n, lowest, highest, fall):
    """Periodic noise, frequencies in cycles a pixel, amplitude f^-fall, variance 1."""
    f = np.fft.fftfreq(n) * OVERSAMPLED
    r = np.hypot(f[:, None], f[None, :])
    band = (r >= lowest) & (r <= highest)
    amplitude = np.where(band, np.maximum(r, 1e-3) ** -fall, 0.0)
    t = np.fft.ifft2(amplitude * np.exp(2j * np.pi * rng.random((n, n)))).real
    return (t / t.std()).astype(np.float32)


def textures(rng, n=1024):
    y, x = np.mgrid[:n, :n] / OVERSAMPLED
    fine = smooth_noise(rng, n, 0.05, 0.45, 0.5)
    broad = smooth_noise(rng, n, 0.004, 0.12, 1.0)
    natural = smooth_noise(rng, n, 0.004, 0.45, 1.3)
    stripes = np.tanh(3 * np.sin(2 * np.pi * (x / 8 + 0.4 * broad)))
    weave = np.sin(2 * np.pi * x / 4) * np.sin(2 * np.pi * y / 4) + 0.8 * broad
    faint = 0.15 * natural
    blocks = np.sign(smooth_noise(rng, n, 0.004, 0.08, 1.0)) + 0.3 * fine
    return [fine, broad, natural, stripes, weave, faint, blocks]


class Surface:
    """d(X, Y) = a + b X + c Y + bump; inside(X, Y); texture with mean and contrast."""

    def __init__(self, rng, size, bank, kind, disparity):
        self.tex = bank[rng.integers(len(bank))]
        self.mean = rng.uniform(60, 190)
        self.contrast = np.exp(rng.uniform(np.log(2.5), np.log(35)))
        self.at = rng.uniform(0, 1000, 2)
        tilt = rng.uniform(-1, 1, 2) * (0.6 if kind == "back" else 0.5) / size
        self.centre = rng.uniform(0.1, 0.9, 2) * size
        self.plane = (disparity - tilt @ self.centre, tilt[0], tilt[1])
        self.kind = kind
        self.half = rng.uniform(0.06, 0.22, 2) * size
        if kind == "bar":
            self.half = np.array([rng.uniform(1.0, 3.5), rng.uniform(0.2, 0.6) * size])
        self.turn = rng.uniform(0, np.pi) if kind == "bar" else rng.uniform(-0.4, 0.4)
        self.bump = rng.uniform(0.2, 0.6) if kind in ("ball", "back") else 0.0
        self.light = rng.uniform(-1, 1, 2) * 20 / size

    def local(self, x, y):
        cx, cy = x - self.centre[0], y - self.centre[1]
        c, s = np.cos(self.turn), np.sin(self.turn)
        return c * cx + s * cy, -s * cx + c * cy

    def disparity(self, x, y):
        a, b, c = self.plane
        d = a + b * x + c * y
        if self.bump:
            u, v = self.local(x, y)
            d = d + self.bump * np.exp(-((u / 60) ** 2 + (v / 60) ** 2))
        return d

    def inside(self, x, y):
        u, v = self.local(x, y)
        if self.kind == "back":
            return np.ones(x.shape, bool)
        if self.kind == "ball":
            return (u / self.half[0]) ** 2 + (v / self.half[1]) ** 2 < 1
        return (np.abs(u) < self.half[0]) & (np.abs(v) < self.half[1])

    def colour(self, x, y):
        n = self.tex.shape[0]
        u, v = (x + self.at[0]) * OVERSAMPLED, (y + self.at[1]) * OVERSAMPLED
        i, j = np.floor(u).astype(int), np.floor(v).astype(int)
        fu, fv = (u - i).astype(np.float32), (v - j).astype(np.float32)
        i, j, i1, j1 = i % n, j % n, (i + 1) % n, (j + 1) % n
        t = self.tex
        value = (1 - fv) * ((1 - fu) * t[j, i] + fu * t[j, i1]) \
            + fv * ((1 - fu) * t[j1, i] + fu * t[j1, i1])
        return self.mean + self.contrast * value + self.light[0] * (x - 128)


def surfaces(seed, size, low=-1.8, high=1.8):
    rng = np.random.default_rng(seed)
    bank = textures(rng)
    out = [Surface(rng, size, bank, "back", rng.uniform(low + 0.3, low + 0.8))]
    kinds = ["box"] * rng.integers(3, 6) + ["ball"] * 2 + ["bar"] * rng.integers(2, 5)
    for kind in kinds:
        out.append(Surface(rng, size, bank, kind, rng.uniform(low + 0.9, high - 0.7)))
    return out


def cast(scene, x, y, du, dv):
    """Grey and disparity seen by rays at (x, y) of the view (du, dv)."""
    best = np.full(x.shape, -99.0)
    grey = np.zeros(x.shape, np.float32)
    for s in scene:
        px, py = x, y
        for _ in range(6 if du or dv else 1):
            d = s.disparity(px, py)
            px, py = x + d * du, y + d * dv
        seen = s.inside(px, py) & (d > best)
        best[seen] = d[seen]
        grey[seen] = s.colour(px[seen], py[seen])
    return grey, best


def render(seed, size=256, views=9, star=True, over=2):
    """{(r, c): grey 0..255, float}, disparity of the centre view."""
    scene = surfaces(seed, size)
    c = views // 2
    sub = (np.arange(size * over) + 0.5) / over - 0.5
    x, y = np.meshgrid(sub, sub)
    out = {}
    for r in range(views):
        for q in range(views):
            dv, du = r - c, q - c
            if star and du and dv and abs(du) != abs(dv):
                continue
            g, _ = cast(scene, x, y, du, dv)
            g = g.reshape(size, over, size, over).mean((1, 3))
            out[(r, q)] = np.clip(g, 0, 255).astype(np.float32)
    px = np.arange(size, dtype=float)
    _, truth = cast(scene, *np.meshgrid(px, px), 0, 0)
    return out, truth


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("seed", type=int)
    p.add_argument("-o", dest="folder", required=True)
    p.add_argument("--size", type=int, default=256)
    p.add_argument("--views", type=int, default=9)
    p.add_argument("--noise", type=float, default=0.0)
    p.add_argument("--bits", type=int, default=10)
    a = p.parse_args()
    from PIL import Image
    os.makedirs(a.folder, exist_ok=True)
    views, truth = render(a.seed, a.size, a.views, star=False)
    rng = np.random.default_rng(a.seed + 1000)
    for k, (r, c) in enumerate(sorted(views)):
        v = views[(r, c)] + rng.normal(0, a.noise, views[(r, c)].shape)
        v = np.clip(np.round(v * 2 ** (a.bits - 8)), 0, 2 ** a.bits - 1)
        Image.fromarray(v.astype(np.uint16)).save(f"{a.folder}/input_Cam{k:03d}.png")
    with open(f"{a.folder}/truth.pfm", "wb") as f:
        f.write(b"Pf\n%d %d\n-1\n" % (a.size, a.size))
        f.write(np.flipud(truth).astype("<f4").tobytes())


if __name__ == "__main__":
    main()
