# SPDX-License-Identifier: GPL-3.0-or-later
"""Three empty canvases; light that a lens gathers on the table is copied onto them: cut by an intensity texture, coloured by a hue shift
texture, rippled by a normal map (paper, figure 4)."""

import math
import os
import sys

import numpy as np
from mathutils import Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

WALL_Y = 0.42
LENS, LAMP = Vector((-0.16, -0.06, 0.135)), Vector((-0.54, -0.16, 0.34))
BEAM = (LENS - LAMP).normalized()


def star():
    """A star with soft edges: how much light passes."""
    v, u = np.meshgrid(np.linspace(-1, 1, 128), np.linspace(-1, 1, 128), indexing="ij")
    radius, angle = np.hypot(u, v), np.arctan2(v, u) + math.pi / 2
    turn = np.abs((angle / (2 * math.pi) * 5) % 1 - 0.5) * 2 * math.pi / 5  # from a tip, where 0, to a notch
    tip, (x, y) = 0.62, (0.40 * math.cos(math.pi / 5), 0.40 * math.sin(math.pi / 5))  # a tip at (tip, 0), the notch beside it at (x, y)
    edge = tip * y / (y * np.cos(turn) + (tip - x) * np.sin(turn))
    inside = ((edge - radius) / 0.03).clip(0, 1)
    return m.image("Star", np.repeat(inside[..., None], 3, axis=2))


def spectrum():
    """From black to white, bottom to top: no shift to a whole turn."""
    return m.image("Ramp", np.repeat(np.repeat(np.linspace(0, 1, 128)[:, None, None], 128, axis=1), 3, axis=2))


def ripples():
    """Rings on water, as a tangent space normal map."""
    v, u = np.meshgrid(np.linspace(-1, 1, 128), np.linspace(-1, 1, 128), indexing="ij")
    radius = np.hypot(u, v)
    slope = 0.25 * np.cos(radius * 16)
    normal = np.stack([-slope * u / (radius + 1e-6), -slope * v / (radius + 1e-6), np.ones_like(u)], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return m.image("Ripples", normal * 0.5 + 0.5, colorspace="Non-Color")


def edits():
    """The entry stands in the air behind the lens, across the beam; each exit like a projector before its canvas."""
    beam = m.entry("Beam behind the lens", "L'Lamp'S'Lens'+", LENS + 0.10 * BEAM, -BEAM, (1, 0, 0), (0.15, 0.15))
    changes = (("Star", {"intensity_texture": star()}), ("Spectrum", {"hue_shift": 2 * math.pi, "hue_shift_texture": spectrum()}),
               ("Ripples", {"normal_map": ripples()}))  # fmt: skip
    for i, (name, change) in enumerate(changes):
        m.exit_of(beam, name, (0.32 * (i - 1), WALL_Y - 0.06, 0.36), (0, -1, 0), (1, 0, 0), (0.25, 0.25), **change)


scene = m.start()
props.table(props.boards("Oak", (0.80, 0.64, 0.46), (0.60, 0.43, 0.27)), wall=WALL_Y)
props.wall(props.plaster("Plaster", (0.20, 0.27, 0.33)), WALL_Y)
props.lens_on_foot(LENS, BEAM, m.glass("Rose", (1.0, 0.50, 0.32)), size=(0.085, 0.001, 0.013, 0.0045), stem=0.047, segments=128, levels=0)
frame, canvas = m.glossy("Black wood", (0.03, 0.03, 0.032), 0.35), m.matte("Canvas", (0.50, 0.49, 0.47))
for i in range(3):
    props.framed(f"Canvas {i + 1}", (0.32 * (i - 1), WALL_Y, 0.36), (0.25, 0.25), canvas, frame, rail=0.014)
m.world((0.5, 0.56, 0.65), 0.15)
m.light("Lamp", "POINT", LAMP, 14.0, (1.0, 0.90, 0.75), shadow_soft_size=0.006)
m.light("Softbox", "AREA", (0.9, -1.3, 1.5), 12.0, (0.84, 0.92, 1.0), target=(0, 0.2, 0.1), shape="RECTANGLE", size=1.2, size_y=1.2)
edits()
m.camera((0.0, -1.38, 0.42), (0.0, 0.2, 0.225), lens=50, focus=(0, 0.1, 0.2), f_stop=8)
scene.sluice.passes, scene.sluice.photons = 64, 250000
m.save(__file__)
