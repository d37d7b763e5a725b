# SPDX-License-Identifier: MIT
"""The core's shared library through ctypes, for the benches that set it beside Python
packages: a 16-megapixel camera of 289 x 193 lenses, decoding, streaming.  The
structures are those of include/plenofix."""
import ctypes as c
import time

import numpy as np

SENSOR_W, SENSOR_H, LENSES_X, LENSES_Y = 4904, 3280, 289, 193
PITCH, TURN = 16.93, np.radians(0.05)
ORIGIN = (12.0, 9.0)  # every 13 x 13 patch lies on the sensor
FORMAT_U16 = 2
SMALL, FAST = 0, 1
GRADIENT = 2


def struct(name, **fields):
    return type(name, (c.Structure,), {'_fields_': list(fields.items())})


Point = struct('Point', x=c.c_int32, y=c.c_int32)
Lattice = struct('Lattice', kind=c.c_int32, nx=c.c_int32, ny=c.c_int32, origin=Point, a=Point,
                 b=Point, odd=Point)
LutDesc = struct('LutDesc', camera=c.c_uint32, w=c.c_int32, h=c.c_int32, bits=c.c_int32,
                 lattice=Lattice, radius=c.c_int32, resid=c.c_void_p, flags=c.c_void_p,
                 zones_x=c.c_int32, zones_y=c.c_int32, profile_r=c.c_int32,
                 profile=c.c_void_p, gain=c.c_void_p, dark=c.c_uint16, has_dark=c.c_int32,
                 opti=c.c_void_p, opti_len=c.c_uint32, meta=c.c_void_p, meta_len=c.c_uint32)
Offset = struct('Offset', u=c.c_int16, v=c.c_int16)
Tone = struct('Tone', black=c.c_uint16, sat=c.c_uint16, gain=c.c_uint16, shift=c.c_int8,
              bits=c.c_uint8, dx=c.c_int16, dy=c.c_int16)
Raw = struct('Raw', bytes=c.c_void_p, size=c.c_size_t, format=c.c_uint8, bits=c.c_uint8,
             w=c.c_int32, h=c.c_int32)
Views = struct('Views', px=c.c_void_p, nx=c.c_int32, ny=c.c_int32, n=c.c_int32)
Map = struct('Map', slope=c.c_void_p, conf=c.c_void_p, sigma=c.c_void_p, flags=c.c_void_p,
             w=c.c_int32, h=c.c_int32, stride=c.c_int32)
Cfg = struct('Cfg', method=c.c_uint8, cost=c.c_uint8, fit=c.c_uint8, fuse=c.c_uint8,
             window=c.c_uint8, bits=c.c_uint8, ref=c.c_uint8, n=c.c_uint8,
             labels=c.c_uint16, texture=c.c_uint16, unique=c.c_uint16, lo=c.c_int32,
             hi=c.c_int32, at=Offset * 128)
StreamCfg = struct('StreamCfg', plan=c.c_void_p, lut=c.c_void_p, frame=c.c_void_p, tone=Tone,
                   profile=c.c_uint8, white=c.c_uint8, format=c.c_uint8, bits=c.c_uint8,
                   fed=c.c_uint8, open_rows=c.c_int32, j0=c.c_int32, j1=c.c_int32)


def unity(bits):
    return Tone(0, 65535, 4096, 0, bits, 0, 0)


def aligned(size):
    """A workspace: the array that owns it, and its address."""
    room = np.zeros(size + 64, np.uint8)
    return room, room.ctypes.data + (-room.ctypes.data) % 64


def centres():
    """Lens centres in pixels, [ny][nx][2] (x, y), of the table that Core makes."""
    a = np.round(np.array([PITCH * np.cos(TURN), PITCH * np.sin(TURN)]) * 2**22) / 2**22
    b = np.array([-a[1], a[0]])
    i, j = np.meshgrid(np.arange(LENSES_X), np.arange(LENSES_Y))
    return np.array(ORIGIN) + i[..., None] * a + j[..., None] * b


class Core:
    def __init__(self, path):
        self.lib = c.CDLL(path)
        for name in ('plfx_lut_bytes', 'plfx_stream_ws'):
            getattr(self.lib, name).restype = c.c_size_t
        self.lib.plfx_lut_centre.restype = Point
        self.lib.plfx_view_offset.restype = Point
        self.lut = c.create_string_buffer(1024)
        a = [round(PITCH * f(TURN) * 2**22) for f in (np.cos, np.sin)]
        d = LutDesc(w=SENSOR_W, h=SENSOR_H, bits=12, radius=7 * 256)
        d.lattice = Lattice(0, LENSES_X, LENSES_Y, Point(*(int(v * 65536) for v in ORIGIN)),
                            Point(*a), Point(-a[1], a[0]), Point(0, 0))
        size = self.lib.plfx_lut_bytes(c.byref(d))
        self.blob = c.create_string_buffer(size)
        self.must(self.lib.plfx_lut_write(c.byref(d), self.blob, c.c_size_t(size)))
        self.must(self.lib.plfx_lut_open(self.lut, self.blob, c.c_size_t(size)))

    def places(self, u, v):
        """Sampling points of a view, pixels [ny][nx][2] (x, y): view.h's 1/256."""
        shift = self.lib.plfx_view_offset(self.lut, Offset(int(u * 256), int(v * 256)))
        at = [[self.lib.plfx_lut_centre(self.lut, i, j) for i in range(LENSES_X)]
              for j in range(LENSES_Y)]
        q16 = np.array([[(p.x + shift.x, p.y + shift.y) for p in row] for row in at])
        return np.floor((q16 + 128) / 256) / 256

    @staticmethod
    def must(status):
        if status != 0:
            raise RuntimeError(f'refused: status {status}')

    def decode(self, frame, offsets, out):
        """All views (u, v) of a frame, into out [ny][n][nx]."""
        at = (Offset * len(offsets))(*(Offset(int(u * 256), int(v * 256)) for u, v in offsets))
        raw = Raw(frame.ctypes.data, frame.nbytes, FORMAT_U16, 12, SENSOR_W, SENSOR_H)
        views = Views(out.ctypes.data, LENSES_X, LENSES_Y, len(offsets))
        tone = unity(12)

        def run():
            self.must(self.lib.plfx_view_all(self.lut, c.byref(raw), c.byref(tone), at, 0,
                                             c.byref(views)))
        return run


class Planned:
    """A plan on ready-made views [n][h][w], its workspace and its slopes."""

    def __init__(self, lib, images, **cfg):
        n, (h, w) = len(images), images[0].shape
        self.lib, self.name = lib, 'plfx_sweep'
        self.plan = c.create_string_buffer(8192)
        at = cfg.pop('at')
        settings = Cfg(n=n, **cfg)
        for k, (u, v) in enumerate(at):
            settings.at[k] = Offset(round(u * 256), round(v * 256))
        Core.must(lib.plfx_plan_init(self.plan, c.byref(settings), None, w, h))
        if cfg['method'] == GRADIENT:
            self.name = 'plfx_gradient'
        size_of = getattr(lib, self.name + '_ws')
        size_of.restype = c.c_size_t
        self.bytes = size_of(self.plan)
        self.room, self.at = aligned(self.bytes)
        self.block = np.ascontiguousarray(np.stack(images, 1), np.uint16)
        self.slope = np.zeros((h, w), np.int32)
        self.conf = np.zeros((h, w), np.uint16)
        self.views = Views(self.block.ctypes.data, w, h, n)
        self.map = Map(self.slope.ctypes.data, self.conf.ctypes.data, None, None, w, h, w)

    def __call__(self):
        Core.must(getattr(self.lib, self.name)(
            self.plan, c.byref(self.views), c.byref(self.map), c.c_void_p(self.at),
            c.c_size_t(self.bytes)))
        return self.slope

    def slopes(self):
        """In lens pitches a pixel; nan where nothing was measured."""
        return np.where(self.slope == -2**31, np.nan, self.slope / 65536)


def matcher(lib, left, right, labels, window, bits, ncc):
    """Two views, label l = l columns = l/16 of slope."""
    made = Planned(lib, [left, right], method=int(ncc), cost=int(ncc), window=window,
                   bits=bits, labels=labels, hi=(labels - 1) * 4096, at=[(0, 0), (-16, 0)])
    made.map.conf = None
    return made


class Stream:
    """Raw rows -> views along u -> summed sweep -> slopes: 17 labels, window 9."""

    def __init__(self, core, offsets, slope, profile):
        self.core, n = core, len(offsets)
        cfg = Cfg(fit=1, window=9, bits=12, ref=n // 2, n=n, labels=17,
                  lo=round(-slope * 65536), hi=round(slope * 65536))
        for k, u in enumerate(offsets):
            cfg.at[k].u = round(u * 256)
        self.plan = c.create_string_buffer(8192)
        lib = core.lib
        core.must(lib.plfx_plan_init(self.plan, c.byref(cfg), core.lut, LENSES_X, LENSES_Y))
        tone = unity(12)
        rows = lib.plfx_stream_open_rows(core.lut, self.plan, c.byref(tone))
        self.cfg = StreamCfg(c.addressof(self.plan), c.addressof(core.lut), None, tone, profile, 0,
                             FORMAT_U16, 12, 0, rows, 0, LENSES_Y)
        self.bytes = lib.plfx_stream_ws(c.byref(self.cfg))
        self.room, at = aligned(self.bytes)
        self.state = c.create_string_buffer(256)
        core.must(lib.plfx_stream_init(self.state, c.byref(self.cfg), c.c_void_p(at),
                                       c.c_size_t(self.bytes)))
        self.slope = np.zeros((LENSES_Y, LENSES_X), np.int32)

    def __call__(self, frame):
        """One frame: 193 calls of push_band, 193 of pop; their arguments are made once."""
        lib, state = self.core.lib, self.state
        push, pop = lib.plfx_stream_push_band, lib.plfx_stream_pop
        used, ready, j = c.c_int32(), c.c_int32(), c.c_int32()
        band = Raw(frame.ctypes.data, frame.nbytes, FORMAT_U16, 12, SENSOR_W, SENSOR_H)
        line = Map(self.slope.ctypes.data, None, None, None, LENSES_X, 1, LENSES_X)
        p_band, p_line, p_used = c.byref(band), c.byref(line), c.byref(used)
        p_ready, p_j = c.byref(ready), c.byref(j)
        start, row, y = band.bytes, 2 * SENSOR_W, 0
        failed = lib.plfx_stream_reset(state)
        while y < SENSOR_H and not failed:
            band.bytes, band.size, band.h = start + y * row, (SENSOR_H - y) * row, SENSOR_H - y
            failed = push(state, y, p_band, p_used, p_ready)
            y += used.value
            while ready.value > 0 and not failed:
                failed = pop(state, p_j, p_line, p_ready)
                line.slope += 4 * LENSES_X
        self.core.must(failed or lib.plfx_stream_finish(state))
        return self.slope


def least(candidates, rounds):
    """Least processor time of the thread, ms, candidates taking turns."""
    times = {name: float('inf') for name in candidates}
    for _ in range(rounds):
        for name, run in candidates.items():
            start = time.thread_time_ns()
            run()
            times[name] = min(times[name], (time.thread_time_ns() - start) / 1e6)
    return times
