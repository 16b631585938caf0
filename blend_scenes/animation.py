# SPDX-License-Identifier: GPL-3.0-or-later
"""24 frames: a cut crystal turns; its caustic, taken from the table, travels along the wall and through the colours."""

import math
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

WALL_Y, FRAMES = 0.40, 24


def animate(item, path, first, last):
    """A value that goes evenly from the first frame's to that of the frame after the last, so that the frames make a loop: a key in
    each, since how to choose the way between two keys depends on Blender's version."""
    owner, _, name = path.rpartition(".")
    target = item.path_resolve(owner) if owner else item
    first, last = np.array(first), np.array(last)
    for frame in range(1, FRAMES + 2):
        value = first + (last - first) * ((frame - 1) / FRAMES)
        setattr(target, name, value.tolist())
        item.keyframe_insert(path, frame=frame)


def edits():
    size = (0.30, 0.26)
    caustic = m.entry("Caustic", "LS'Crystal'+", (0.16, 0.04, 0), (0, 0, 1), (1, 0, 0), size, feather=0.2)
    out = m.exit_of(caustic, "Along the wall", (-0.30, WALL_Y, 0.29), (0, -1, 0), (1, 0, 0), size, intensity=2.0)
    animate(out, "location", (-0.30, WALL_Y, 0.29), (0.36, WALL_Y, 0.29))
    animate(out, "sluice.hue_shift", 0.0, 2 * math.pi)


scene = m.start(480, 270)
props.sweep("Paper", m.matte("Paper", (0.22, 0.26, 0.30)), wall=WALL_Y, radius=0.06)
crystal = props.blossom("Crystal", 0.068, (-0.02, 0, 0.091), m.glass("Amber", (1.0, 0.62, 0.24)))
animate(crystal, "rotation_euler", (0, 0, 0), (0, 0, math.radians(72)))
disk = [(0, 0), (0.085, 0), (0.088, 0.004), (0.088, 0.016), (0.084, 0.021), (0, 0.021)]
m.lathe("Turntable", disk, (-0.02, 0, 0), props.pewter())
m.world((0.6, 0.64, 0.7), 0.2)
m.light("Lamp", "POINT", (-0.48, -0.12, 0.36), 12.0, (1.0, 0.93, 0.84), shadow_soft_size=0.006)
m.light("Softbox", "AREA", (0.9, -1.3, 1.4), 12.0, (0.84, 0.92, 1.0), target=(0, 0.2, 0.1), shape="RECTANGLE", size=1.0, size_y=1.0)
edits()
m.camera((0.02, -1.10, 0.40), (0.02, 0.15, 0.175), lens=48, focus=(0, -0.05, 0.1), f_stop=8)
scene.frame_start, scene.frame_end = 1, FRAMES
scene.sluice.passes, scene.sluice.photons = 16, 100000
m.save(__file__)
