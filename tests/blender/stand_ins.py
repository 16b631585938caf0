# SPDX-License-Identifier: GPL-3.0-or-later
"""Stand-ins for Blender's objects that a final render works with: the engine, a render pass and its pixels, a job."""
from types import SimpleNamespace

import numpy as np


class Rect:
    """Pass.rect: wants (N, channels) up to 4.0, flat from 4.1."""

    def __init__(self, flat, count, channels):
        self.flat, self.size, self.stored = flat, count * channels, None
        self.shape = (count * channels,) if flat or channels == 1 else (count, channels)

    def foreach_set(self, array):
        if array.shape != self.shape and array.ndim != 1 or (not self.flat and len(self.shape) == 2 and array.ndim == 1):
            raise TypeError("Array length mismatch")
        assert array.dtype == np.float32 and array.flags.c_contiguous and array.size == self.size
        self.stored = np.array(array).ravel()


class Pass:
    """A render pass of 6 pixels."""

    def __init__(self, flat, channels, name="P"):
        self.name, self.channels, self.rect = name, channels, Rect(flat, 6, channels)


class Engine:
    """What final.py asks of Blender's engine, with an Esc after some polls."""

    resolution_x, resolution_y, is_preview, camera_override = 4, 3, False, None

    def __init__(self, escape_after=None):
        self.polls, self.escape_after, self.said, self.results = 0, escape_after, [], []

    def test_break(self):
        self.polls += 1
        return self.escape_after is not None and self.polls > self.escape_after

    def begin_result(self, *_args, layer):
        import sluice.passes
        passes = []
        for item in sluice.passes.fixed_passes():
            found = Pass(True, len(item.channels), item.name)
            found.rect.size, found.rect.shape = 12 * len(item.channels), (12 * len(item.channels),)
            passes.append(found)
        result = SimpleNamespace(resolution_x=4, resolution_y=3, layers=[SimpleNamespace(passes=passes)], stamp_data_add_field=lambda *_pair: None)
        self.results.append(result)
        return result

    def get_result(self):
        return self.results[-1]

    def end_result(self, result):
        self.said.append(("end", result))

    def report(self, kind, message):
        self.said.append((kind, message))

    def __getattr__(self, _name):
        return lambda *_args, **_named: None


def job_of_engine():
    """A job for render, as update leaves it: a small frame and very many passes."""
    from sluice.final import Job
    from sluice.passes import fixed_passes
    frame = {"x0": 0, "y0": 0, "x1": 4, "y1": 3, "width": 4, "height": 3}
    return Job("Layer", {"frame": frame, "edits": []}, {"passes": 100000, "photons": 1000, "time_limit": 0, "error_target": 0, "seed": 0, "frame": 1},
               passes=fixed_passes())
